"""Cells of six elastic joints: against 50 digits by another method, against rows, and what is no cell."""

from __future__ import annotations

import random
from collections.abc import Mapping, Sequence
from typing import Any

import mpmath
import pytest

from symoro_elastic.generation.pipeline import prepare
from symoro_elastic.machine.machine import Machine
from symoro_elastic.mechanics.elastic_cells import elastic_cells
from symoro_elastic.models.bound.bind import Bound
from symoro_elastic.models.programs.catalogue import trace
from symoro_elastic.numerics.evaluation.values import parameter_values
from symoro_elastic.symbolic.arithmetic import FLOATS, evaluate, multiprecision
from symoro_elastic.symbolic.expression import reachable
from symoro_elastic.symbolic.program import Program
from tests.compiled_models import worst
from tests.references import multiprecision as reference

Row = dict[str, Any]
QUARTER = {"gamma": "pi/2", "alpha": "pi/2"}
BACK = {"alpha": "-pi/2", "theta": "-pi/2"}
DIRECTIONS = ("x", "y", "z", "rz", "ry", "rx")
SEQUENCES: Mapping[str, Sequence[Row]] = {
    "zyx": (QUARTER, QUARTER, QUARTER, {}, {"alpha": "-pi/2"}, QUARTER),
    "zyx, offset": (QUARTER, QUARTER, QUARTER, {"d": 0.1, "r": 0.2}, BACK, BACK),
    "xyz, turned": ({"gamma": 0.3, "alpha": 0.7, "d": 0.2}, QUARTER, QUARTER, {"alpha": 0.4}, QUARTER, QUARTER),
}


def cell(name: str, antecedent: str | int, sequence: str = "zyx", **place: Any) -> list[Row]:
    """Six rows, the last one of this name."""
    rows, names = [], [f"{name}_{direction}" for direction in DIRECTIONS[:5]] + [name]
    for k, (own, angles) in enumerate(zip(names, SEQUENCES[sequence], strict=True)):
        cell_of = "r" if k < 3 else "theta"
        offset = f" + ({angles['theta']})" if k > 2 and "theta" in angles else ""
        shift = place if k == 0 else {}
        rows.append(
            {"name": own, "kind": "elastic", "antecedent": antecedent, "sigma": int(k < 3)}
            | {**angles, **shift, cell_of: f"x_{own}{offset}"}
        )
        antecedent = own
    return rows


def machine(joints: Sequence[Row], seed: int = 0, **more: Any) -> Machine:
    """Joints with random springs, and bodies on all motors and at the end of all cells."""
    draw = random.Random(seed).uniform
    bodies, springs = {}, {}
    for row in joints:
        name = row["name"]
        if row["kind"] == "elastic":
            springs[name] = {"stiffness": round(draw(1e5, 1e6)), "damping": round(draw(10, 100))}
        if row["kind"] in ("motor", "fixed") or not name.endswith(tuple(f"_{x}" for x in DIRECTIONS)):
            center = [round(draw(-0.3, 0.3), 3) for _ in range(3)]
            inertia = [round(draw(0.2, 0.3), 3) if k in (0, 3, 5) else round(draw(-0.1, 0.1), 3) for k in range(6)]
            bodies[name] = {"mass": round(draw(1, 9), 3), "center_of_mass": center, "inertia": inertia}
    tables = {"name": "suspended", "gravity": [0.5, -1, -9.81], "joints": list(joints), **more}
    return prepare(tables | {"bodies": bodies | more.get("bodies", {}), "springs": springs})


AXIS: Row = {"name": "axis", "kind": "motor", "antecedent": 0, "sigma": 1, "r": "q1"}
SHOULDER: Row = {"name": "shoulder", "kind": "motor", "antecedent": 0, "sigma": 0, "alpha": 0.4, "theta": "q1"}


def arm(antecedent: str) -> list[Row]:
    elbow = {
        "name": "elbow",
        "kind": "motor",
        "antecedent": antecedent,
        "sigma": 0,
        "alpha": 0.5,
        "d": 0.3,
        "theta": "q2",
    }
    slide = {"name": "slide", "kind": "motor", "antecedent": "elbow", "sigma": 1, "alpha": "pi/2", "r": "q3"}
    return [elbow, slide]


def bushings(count: int) -> list[Row]:
    names = ["axis", *(f"bush{k}" for k in range(1, count + 1))]
    return [AXIS, *(row for k in range(count) for row in cell(names[k + 1], names[k], d=0.4, b=0.1))]


MACHINES: Mapping[str, Sequence[Row]] = {
    "on the base": cell("seat", 0),
    "on a slide": bushings(1),
    "in series": bushings(2),
    "side by side": [
        SHOULDER,
        *cell("first", "shoulder", "zyx, offset", d=0.2),
        *cell("second", "shoulder", "xyz, turned"),
    ],
    "below an arm": [SHOULDER, *cell("plate", "shoulder", "xyz, turned"), *arm("plate")],
    "below fixed frames": [
        SHOULDER,
        *cell("plate", "shoulder"),
        {"name": "tool", "kind": "fixed", "antecedent": "plate", "sigma": 2, "alpha": 0.3, "d": 0.2},
        {"name": "tip", "kind": "fixed", "antecedent": "tool", "sigma": 2, "r": 0.3},
        *cell("probe", "tool", d=0.1),
    ],
}


def state(machine: Machine, seed: int, deflection: float = 1.0) -> tuple[list[float], list[float], list[float]]:
    """q, qd, and torques or accelerations of motors; springs move by `deflection` at 100 rad/s."""
    source, springs = random.Random(seed), {*machine.elastic}
    size = [deflection if j in springs else 1.0 for j in machine.independent]
    q = [x * source.uniform(-1, 1) for x in size]
    qd = [(100 * x if x < 1 else 1) * source.uniform(-1, 1) for x in size]
    return q, qd, [source.uniform(-10, 10) for _ in machine.motors]


def results(
    program: Program, arguments: Sequence[Sequence[float]], values: Mapping[str, Any], arithmetic: Any
) -> list[Any]:
    entries = [x for output in program.outputs for x in output.entries]
    number = float if arithmetic is FLOATS else mpmath.mpf
    symbols = {
        name: number(x)
        for argument, numbers in zip(program.inputs, arguments, strict=True)
        for name, x in zip(argument.symbols, numbers, strict=True)
    }
    value = evaluate(entries, {name: number(x) for name, x in values.items()} | symbols, arithmetic)
    return [value(x) for x in entries]


def flat(entries: Any) -> list[Any]:
    return [x for row in entries for x in row] if isinstance(entries, tuple) else list(entries)


def cells_of(machine: Machine) -> list[tuple[int, ...]]:
    return elastic_cells(Bound(machine).mechanism, machine.elastic)


MODELS = ("direct_dynamics", "inverse_dynamics")


@pytest.mark.sampled(3)
@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("name", MACHINES)
def test_against_50_digits(name: str, model: str) -> None:
    """By the inertia matrix from Jacobians in frame 0: equal in 50 digits, and in doubles to 1e-14 of the largest."""
    suspended = machine(MACHINES[name])
    assert len(cells_of(suspended)) == len(suspended.elastic) // 6
    program, values = trace(suspended, model).program, parameter_values(suspended)
    for seed, deflection in enumerate((1.0, 1e-3, 1e-6)):
        arguments = state(suspended, seed, deflection)
        expected = flat(getattr(reference, model)(suspended, *arguments))
        assert worst(results(program, arguments, values, FLOATS), expected) < 1e-14
        with mpmath.workdps(50):
            exact = results(program, arguments, values, multiprecision(50))
            assert max(abs(x - y) for x, y in zip(exact, expected, strict=True)) < 1e-40 * max(map(abs, expected))


@pytest.mark.parametrize("count", [1, 2])
def test_bushings_to_1e_14_by_entry(count: int) -> None:
    suspended = machine(bushings(count))
    program = trace(suspended, "direct_dynamics").program
    for seed, deflection in enumerate((1.0, 1e-3, 1e-6)):
        arguments = state(suspended, seed, deflection)
        expected = reference.direct_dynamics(suspended, *arguments)
        found = results(program, arguments, {}, FLOATS)
        assert max(float(abs(x / y - 1)) for x, y in zip(found, expected, strict=True)) < 1e-14


FLOATING = {"floating": "quaternion", "body": {"mass": 3, "center_of_mass": [0, 0, 0.1], "inertia": [0.1, 0.2, 0.3]}}
GEARED: Row = {"name": "geared", "kind": "coupled", "antecedent": "axis", "sigma": 0, "theta": "2*q1"}


@pytest.mark.parametrize(
    ("rows", "more"),
    [
        ([SHOULDER, *cell("plate", "shoulder"), *arm("plate")], {"base": FLOATING}),
        (cell("plate", 0), {"base": FLOATING}),
        ([SHOULDER, *cell("plate", "shoulder")], {"base": FLOATING | {"known": "acceleration"}}),
        ([AXIS, GEARED, *cell("plate", "geared"), *arm("plate")], {}),
    ],
)
def test_other_bases_and_couplings(rows: Sequence[Row], more: Row) -> None:
    """Floating bases and coupled joints, against factors of the inertia matrix, in 50 digits."""
    suspended = machine(rows, **more)
    assert len(cells_of(suspended)) == 1
    found = []
    with mpmath.workdps(50):
        for model in ("direct_dynamics", "direct_dynamics_by_inertia_matrix"):
            program, source = trace(suspended, model).program, random.Random(5)
            arguments = [[source.uniform(-1, 1) for _ in argument.symbols] for argument in program.inputs]
            found.append(results(program, arguments, {}, multiprecision(50)))
        assert max(abs(x - y) for x, y in zip(*found, strict=True)) < 1e-40 * max(map(abs, found[0]))


def test_the_carrier_does_not_feel_the_carried_inertia() -> None:
    """K of a cell is exactly zero: no inertia of the carried body is in the acceleration of its carrier."""
    tables = bushings(1)
    inertia = {"mass": "M", "center_of_mass": ["x", 0, "z"], "inertia": ["XX", "YY", "ZZ"]}
    names = dict.fromkeys(("M", "x", "z", "XX", "YY", "ZZ"), 1)
    suspended = machine(tables, parameters=names, bodies={"bush1": inertia})
    qdd, *others = trace(suspended, "direct_dynamics").program.outputs[0].entries
    of_carrier, of_cell = ({str(node) for node in reachable(entries)} for entries in ([qdd], others))
    assert not {*names} & of_carrier and {*names} <= of_cell


def test_operations_of_bushings_do_not_grow() -> None:
    """Six rows take 202x 138+ and 592x 447+ here."""
    for count, products, sums in ((1, 108, 78), (2, 260, 201)):
        for model in MODELS:
            counted = trace(machine(bushings(count)), model).program.count
            assert counted.mul + counted.div <= products and counted.add <= sums
            assert counted.sincos == 6 * count


CHANGES: Mapping[str, tuple[int, Row, Row]] = {
    "a motor among them": (3, {"kind": "motor"}, {}),
    "a passive joint among them": (4, {"kind": "passive"}, {}),
    "axes that do not meet": (5, {"d": 0.1}, {}),
    "oblique turns": (5, {"alpha": 1.5}, {}),
    "oblique slides": (2, {"alpha": 1.5}, {}),
    "mass between": (4, {}, {"bodies": {"bush1_z": {"mass": 1}}}),
}


@pytest.mark.parametrize("change", CHANGES)
def test_other_rows_are_no_cell(change: str) -> None:
    """They are eliminated row by row, with the results of the reference."""
    k, entries, more = CHANGES[change]
    rows = bushings(1)
    suspended = machine([*rows[:k], rows[k] | entries, *rows[k + 1 :]], **more)
    assert not cells_of(suspended)
    arguments = state(suspended, 1, 1e-3)
    found = results(trace(suspended, "direct_dynamics").program, arguments, {}, FLOATS)
    assert worst(found, reference.direct_dynamics(suspended, *arguments)) < 1e-12


def test_a_branch_within_is_no_cell() -> None:
    side = {"name": "side", "kind": "motor", "antecedent": "bush1_z", "sigma": 0, "theta": "q9"}
    assert not cells_of(machine([*bushings(1), side]))
