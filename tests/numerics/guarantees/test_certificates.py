"""Certificates are attacked: random states, corners and climbing never exceed a bound, and the bounds are near."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import symoro_elastic as se
from symoro_elastic.api.machines import the_machine
from symoro_elastic.codegen.precision import PRECISIONS
from symoro_elastic.codegen.printed_order import in_printed_order
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.generation.pipeline import certificates, prepare_machine, programs
from symoro_elastic.machine.described import DescribedMachine
from symoro_elastic.machine.limits import JointLimits, Limits, Range
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.scene import Scene
from symoro_elastic.machine.within import Evidence
from symoro_elastic.numerics.evaluation.arrays import arithmetic
from symoro_elastic.numerics.guarantees.box import Box, box_of
from symoro_elastic.numerics.guarantees.certificate import Certificate
from symoro_elastic.numerics.guarantees.certificates import Effort
from symoro_elastic.numerics.guarantees.header import at_least, at_most
from symoro_elastic.symbolic.arithmetic import evaluate
from symoro_elastic.symbolic.expression import Expression, Operand
from symoro_elastic.symbolic.operations import DIVIDE
from tests.benchmarks.certificates import exceeded, with_values
from tests.closed_chains.machines import machine as closed_machine
from tests.command_line import refused, run
from tests.numerics.guarantees.attack import ROUNDED, SLACK, Attack, results_as_printed
from tests.numerics.guarantees.boxes import limits_of_test
from tests.references.random_machines import chain, random_machine

EXAMPLES = Path(__file__).parents[3] / "examples"
MACHINES: dict[str, Callable[[], Machine]] = {
    "two_axis": lambda: se.read(EXAMPLES / "two_axis.toml"),
    "puma": lambda: se.read(EXAMPLES / "puma560_measured.toml"),
    "sr400": lambda: closed_machine("sr400"),
    "gantry": lambda: closed_machine("gantry"),
    "geared": lambda: closed_machine("geared_6r"),
    "tree": lambda: random_machine(7, joints=7),
    "named numbers": lambda: random_machine(8, joints=5, symbolic=True),
    "chain": lambda: chain(4, elastic=(2,), prismatic=(3,), symbolic=False),
    "two joints": lambda: chain(2, elastic=(2,), symbolic=False),
}
QUICK = ("two joints",)
NAMES = [*QUICK, *(pytest.param(name, marks=pytest.mark.thorough) for name in MACHINES if name not in QUICK)]
HINGE = {
    "name": "pendulum",
    "gravity": [0, "-g", 0],
    "joints": [{"name": "hinge", "antecedent": 0, "kind": "motor", "sigma": 0, "theta": "q1"}],
    "parameters": {"m": {"value": 2, "tolerance": "10 %"}, "g": 9.81},
    "bodies": {"hinge": {"mass": "m", "center_of_mass": [0.5, 0, 0], "inertia": [0.1, 0.1, 0.1]}},
    "limits": {"hinge": {"velocity": 1, "acceleration": 1, "torque": 1}},
}


def limited(machine: Machine, scale: float = 1.0) -> DescribedMachine:
    return replace(DescribedMachine.of(machine), limits=limits_of_test(machine, scale))


def certified(machine: Machine, model: str, precision: str = "double", sub_boxes: int = 16) -> Certificate:
    scene = Scene(models=(model,))
    return certificates(machine, scene, [PRECISIONS[precision]], Effort(sub_boxes)).certificates[0]


def results_of(machine: Machine, model: str) -> list[Operand]:
    return results_as_printed(programs(machine, Scene(models=(model,))).package.functions[0].program)


@pytest.mark.parametrize("name", NAMES)
def test_no_certificate_is_exceeded(name: str) -> None:
    """Every model, in single precision in the whole box and in double in a moderate one, drawn and by climbing.

    The other pairs, and many more machines: `python -m tests.benchmarks.certificates`.
    """
    whole = MACHINES[name]()
    for scale, precision in ((1.0, "single"), (0.2, "double")):
        machine = limited(whole, scale)
        for model in ("inverse_dynamics", "direct_dynamics", "inertia_matrix"):
            found = certified(machine, model, precision, sub_boxes=4)
            worst = Attack(results_of(machine, model), found.box, precision).run(2000, rounds=6)
            for k, entry in enumerate(found.entries):
                most = entry.error * (1 + SLACK[precision]) + ROUNDED[precision] * entry.magnitude
                assert worst.error[k] <= most, (model, precision, entry)
                assert entry.low <= worst.low[k] and worst.high[k] <= entry.high, (model, precision, entry)


@pytest.mark.thorough
def test_sums_are_put_in_the_order_of_the_text_once() -> None:
    """Put in order twice, the sum of four terms in A[j5, j5] of the RX90 is none of the code, and rounds less."""
    machine = limited(with_values(se.read(EXAMPLES / "rx90.par")))
    found = certified(machine, "inertia_matrix", sub_boxes=1)
    entry = found.entries[28]
    assert entry.entry == "j5, j5"
    worst = Attack([results_of(machine, "inertia_matrix")[28]], found.box, "double").run(2000, rounds=6)
    assert 0.9 * entry.error < worst.error[0] <= entry.error * (1 + SLACK["double"])


@pytest.mark.thorough
@pytest.mark.sampled(2)
@pytest.mark.parametrize("precision", ["double", "single"])
def test_smooth_dry_friction_is_proven(precision: str) -> None:
    """Its divisor is 1e-4 to 1: a range of 1, and errors in shares of the value."""
    hinge = {**HINGE, "friction": {"hinge": {"coulomb": 1.5, "creep": 1e-4, "static": 2, "stribeck": 0.01}}}
    (found,) = se.certify(hinge, "direct_dynamics", precisions=[precision]).certificates
    (entry,) = found.entries
    worst = Attack(results_of(the_machine(hinge), "direct_dynamics"), found.box, precision).run(4000, rounds=5)
    assert exceeded(found, worst) == []
    assert entry.error < 8 * worst.error[0] and entry.high < 1.5 * worst.high[0]


@pytest.mark.parametrize("name", NAMES)
def test_divisors_are_above_their_bounds(name: str) -> None:
    machine = limited(MACHINES[name](), 0.3)
    found = certified(machine, "direct_dynamics")
    program, _ = in_printed_order(programs(machine, Scene(models=("direct_dynamics",))).package.functions[0].program)
    divisors = [x.operands[1] for x in program.nodes if x.operation == DIVIDE and isinstance(x.operands[1], Expression)]
    states = found.box.states(2000, np.random.default_rng(1))
    value = evaluate(divisors, states, arithmetic(np.float64))
    least = [float(np.min(np.abs(value(x)))) for x in {x.id: x for x in divisors}.values()]
    assert found.pivots
    for bound, worst in zip(found.pivots, least, strict=True):
        assert 0 < bound.least <= worst * (1 + 1e-12), bound


@pytest.mark.thorough
@pytest.mark.parametrize(
    "name", ["sr400", "gantry", "geared_6r", "palletizer", "coupled_wrist", "differential", "five_bar"]
)
def test_pivots_of_coupled_machines_are_schur_complements(name: str) -> None:
    """At least the one over all coordinates, at most the entry of the inertia matrix; at least what is proven."""
    machine = limited(with_values(closed_machine(name)), 0.2)
    asked = programs(machine, Scene(models=("direct_dynamics", "inertia_matrix")))
    direct, inertia = (function.program for function in asked.package.functions)
    pivots = {h: x for h, x in direct.quantities.items() if re.fullmatch(r"H\d+", h) and isinstance(x, Expression)}
    box = box_of(asked.machine, machine.limits, direct.inputs, direct.used | inertia.used)
    states = box.states(100, np.random.default_rng(3))
    entries = inertia.outputs[0].entries
    n = len(asked.machine.independent)
    value = evaluate([*pivots.values()], states, arithmetic(np.float64))
    entry = evaluate(entries, states, arithmetic(np.float64))
    matrix = np.array([np.broadcast_to(entry(x), 100) for x in entries]).reshape(n, n, 100).transpose(2, 0, 1)
    least = 1 / np.diagonal(np.linalg.inv(matrix), axis1=1, axis2=2)
    found = certified(machine, "direct_dynamics", sub_boxes=1)
    bounds = {pivot.name: pivot.least for pivot in found.pivots}
    assert pivots
    for pivot, x in pivots.items():
        k = asked.machine.independent.index(int(pivot[1:]))
        assert np.all(least[:, k] <= value(x) * (1 + 1e-7)), pivot
        assert np.all(value(x) <= matrix[:, k, k] * (1 + 1e-9)), pivot
        assert bounds.get(pivot, 0.0) <= np.min(value(x)) * (1 + 1e-9), pivot


@pytest.mark.thorough
def test_no_pivot_of_a_possible_machine_vanishes() -> None:
    """The sr400 in its whole workspace: a loop, and no rotors."""
    found = certified(limited(MACHINES["sr400"]()), "direct_dynamics", sub_boxes=4)
    assert all(pivot.least > 0 for pivot in found.pivots)


@pytest.mark.thorough
def test_rotors_bound_no_pivot_where_bodies_cannot_exist() -> None:
    """A body with an inertia below zero takes from what its rotor has."""
    torques = {name: {"velocity": 2, "torque": 20} for name in ("shoulder", "elbow")}
    axes = {"kind": "motor", "sigma": 0}
    table = {
        "name": "impossible",
        "joints": [
            {"name": "shoulder", "antecedent": 0, "theta": "q1", **axes},
            {"name": "elbow", "antecedent": "shoulder", "d": 0.4, "theta": "q2", **axes},
        ],
        "parameters": {"a": 0.4},
        "bodies": {
            "shoulder": {"mass": 0, "first_moments": [0, 0, 0], "inertia_at_origin": [0, 0, "-a"]},
            "elbow": {"mass": 1, "first_moments": [0.3, 0, 0], "inertia_at_origin": [0, 0.1, 0.1]},
        },
        "motors": {"shoulder": {"rotor_inertia": 0.5}},
        "limits": torques,
    }
    (found,) = se.certify(table, "direct_dynamics").certificates
    (pivot,) = (pivot for pivot in found.pivots if pivot.name == "H1")
    assert 0 < pivot.least < 0.5 - 0.4 + 0.4**2  # its value where the elbow is straight
    program = programs(se.read(table), Scene(models=("direct_dynamics",))).package.functions[0].program
    worst = Attack(results_as_printed(program), found.box, found.precision).run(4000)
    for k, entry in enumerate(found.entries):
        assert worst.error[k] <= entry.error * (1 + SLACK["double"]) + ROUNDED["double"] * entry.magnitude
        assert entry.low <= worst.low[k] and worst.high[k] <= entry.high


@pytest.mark.thorough
def test_the_bounds_are_near_where_joints_slide_or_bend() -> None:
    machine = limited(MACHINES["two_axis"]())
    for model in ("inverse_dynamics", "direct_dynamics"):
        found = certified(machine, model, sub_boxes=64)
        worst = Attack(results_of(machine, model), found.box, "double").run(4000, rounds=10)
        ratios = [entry.error / most for entry, most in zip(found.entries, worst.error, strict=True) if most]
        assert max(ratios) < 10


DRY = {"viscous": 0.5, "coulomb": 0.7}
FORCES: dict[str, tuple[dict[str, object], str]] = {
    "dry friction": ({"friction": {"hinge": DRY}}, ""),
    "creep": ({"friction": {"hinge": {**DRY, "creep": 1e-3}}}, ""),
    "Stribeck": ({"friction": {"hinge": {**DRY, "static": 0.9, "stribeck": 0.05}}}, ""),
    "backlash": ({"springs": {"spring": {"stiffness": 500, "damping": 1, "backlash": 0.002}}}, ""),
    "friction that rises with the load": ({"friction": {"hinge": {**DRY, "load": 0.02}}}, "load has no limits"),
    "bristles": ({"friction": {"hinge": {**DRY, "bristle": 200, "bristle_damping": 0.05}}}, "z has no limits"),
}


@pytest.mark.thorough
@pytest.mark.parametrize("model", ["inverse_dynamics", "direct_dynamics"])
@pytest.mark.parametrize("force", FORCES)
def test_certificates_with_forces_of_joints_hold_or_are_refused(force: str, model: str) -> None:
    more, refusal = FORCES[force]
    joints = [
        *HINGE["joints"],  # type: ignore[misc]
        {"name": "spring", "antecedent": "hinge", "kind": "elastic", "sigma": 0, "theta": "q2", "alpha": "90 deg"},
    ]
    bodies = {**HINGE["bodies"], "spring": {"mass": 0.5, "inertia": [0.05, 0.04, 0.05]}}  # type: ignore[dict-item]
    springs = {"springs": {"spring": {"stiffness": 500}}}
    whole = {name: x for name, x in HINGE.items() if name != "limits"}
    machine = limited(se.read({**whole, "joints": joints, "bodies": bodies, **springs, **more}), 0.5)
    if refusal:
        with pytest.raises(InputError, match=refusal):
            certified(machine, model)
        return
    found = certified(machine, model)
    worst = Attack(results_of(machine, model), found.box, "double").run(100_000)
    assert any(entry.guarantee is Evidence.PROVEN for entry in found.entries)
    assert not exceeded(found, worst)


@pytest.mark.thorough
def test_a_pivot_that_vanishes_is_not_bounded_and_is_named() -> None:
    """A point mass on a wrist of two crossing axes: it moves nothing about the first where it stands on it."""
    joints = [
        {"name": "a", "antecedent": 0, "kind": "motor", "sigma": 0, "theta": "q1"},
        {"name": "b", "antecedent": "a", "kind": "motor", "sigma": 0, "theta": "q2", "alpha": "pi/2"},
    ]
    tables = {"name": "wrist", "joints": joints, "bodies": {"b": {"mass": 1, "center_of_mass": [1, 0, 0]}}}
    far = {**tables, "limits": {name: {"velocity": 1, "torque": 1} for name in "ab"}}
    (certificate,) = se.certify(far, "direct_dynamics").certificates
    assert certificate.guarantee is not Evidence.PROVEN
    assert any(pivot.least == 0 for pivot in certificate.pivots)
    near = {**tables, "limits": {name: {"position": 0.3, "velocity": 1, "torque": 1} for name in "ab"}}
    assert se.certify(near, "direct_dynamics").certificates[0].guarantee is Evidence.PROVEN


@pytest.mark.thorough
@pytest.mark.parametrize("seed", [1, 2])
def test_a_likely_error_holds_at_unseen_states(seed: int) -> None:
    machine = limited(random_machine(seed, joints=4, kinds=("motor",)))
    found = certified(machine, "direct_dynamics", "single")
    attack = Attack(results_of(machine, "direct_dynamics"), found.box, "single")
    errors, _ = attack.errors(found.box.rounded(np.float32).states(200_000, np.random.default_rng(99)))
    assert all(worst <= entry.likely for entry, worst in zip(found.entries, errors.max(axis=1), strict=True))


@pytest.mark.thorough
def test_grouped_parameters_keep_the_pivots() -> None:
    """Base parameters are not those of bodies: lemma 5 looks at the machine before."""
    grouped = prepare_machine(limited(MACHINES["puma"]()), lambda line: None, base=True)
    found = certified(grouped, "direct_dynamics", sub_boxes=1)
    assert found.guarantee is Evidence.PROVEN
    assert {pivot.name for pivot in found.pivots} >= {"H1", "H2", "H3"}


def test_ranges_of_parameters_are_part_of_the_box() -> None:
    found = se.certify(HINGE, "inertia_matrix", "inverse_dynamics")
    (entry,) = found.of("inertia_matrix")[0].entries
    assert (entry.low, entry.high) == pytest.approx((0.1 + 1.8 / 4, 0.1 + 2.2 / 4))
    torque = found.of("inverse_dynamics")[0].entries[0]
    assert torque.high == pytest.approx(0.1 + 2.2 / 4 + 2.2 * 9.81 / 2)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"limits": {}}, "limits, hinge: has no torque: give it, as in [limits] hinge = { torque = 300 }"),
        ({"parameters": {"m": math.nan, "g": 9.81}}, "parameters, m: m has no value: give it one in the file"),
        (
            {"base": {"floating": "rotation", "body": {"mass": 3, "inertia": [1, 1, 1]}}},
            "has no limits: models that take it have no box",
        ),
    ],
)
def test_what_a_box_lacks_is_named(change: dict[str, object], said: str) -> None:
    with pytest.raises(InputError) as error:
        se.certify({**HINGE, **change}, "direct_dynamics")
    assert said in str(error.value)


def test_a_slide_needs_its_range() -> None:
    limits = {"x": {"velocity": 1, "torque": 1}}
    joints = [{"name": "x", "antecedent": 0, "kind": "motor", "sigma": 1, "r": "x"}]
    tables = {"name": "slide", "joints": joints, "bodies": {"x": {"mass": 2}}, "springs": {}, "limits": limits}
    assert se.certify(tables, "direct_dynamics").certificates[0].guarantee is Evidence.PROVEN
    joints[0]["kind"], tables["springs"] = "elastic", {"x": {"stiffness": 1e4}}
    with pytest.raises(InputError, match="limits, x: has no position"):
        se.certify(tables, "direct_dynamics")


def test_printed_bounds_are_rounded_outwards() -> None:
    assert at_most(2.44e-3) == "0.0025"
    assert at_most(0.1) == "0.11"  # 0.1 is stored as a little more
    assert at_least(-281.71, 4) == "-281.8"
    assert at_least(0.20129, 3) == "0.201"
    assert at_most(math.inf) == "not bounded"


def test_certificates_as_data() -> None:
    found = se.certify(HINGE, "inverse_dynamics", precisions=["double", "mixed"])
    data = json.loads(json.dumps(found.as_json()))
    assert [one["precision"] for one in data["certificates"]] == ["double", "mixed"]
    assert len(found.columns()["error"]) == sum(len(one.entries) for one in found.certificates)
    assert repr(found).startswith("<Certificates of pendulum: inverse_dynamics")


@pytest.mark.thorough
def test_the_command(tmp_path: Path) -> None:
    path = tmp_path / "pendulum.toml"
    se.write(se.read(HINGE), path)
    shown = run("check", "--proven", path, "--model", "direct_dynamics").stdout
    for former in (("check", "--box"), ("certify",)):
        assert run(*former, path, "--model", "direct_dynamics").stdout == shown
    assert "error, proven" in shown and "no divisor is zero" in shown
    for arguments, said in (
        (["check", "--proven", "--self"], "--proven: and --self exclude each other: give one of them"),
        (["check", "--proven", "--precision", "double-double"], "double, single, mixed"),
        (["check", "--precision", "single"], "--precision: belongs to a proof: add --proven, or leave it out"),
    ):
        assert said in refused(*arguments, path)


def test_springs_without_ranges_are_named_with_the_motion_that_gives_them() -> None:
    """Deflections of a tenth of a millimetre in the example, not of the axis; joints that slide have no such way."""
    machine = DescribedMachine.of(MACHINES["two_axis"]())
    known = {x: JointLimits(Range(-0.3, 0.3), Range(-1, 1)) for x in ("motor_x", "motor_y")}
    with pytest.raises(InputError) as error:
        se.certify(replace(machine, limits=Limits(known)), "bias_forces")
    said = str(error.value)
    assert "= { position = [-1e-4, 1e-4] }" in said and "or take the ranges of springs from a motion" in said
    slide = {
        "name": "slide",
        "gravity": [0, 0, -9.81],
        "joints": [{"name": "x", "kind": "motor", "sigma": 1, "r": "q1"}],
        "bodies": {"x": {"mass": 2}},
        "limits": {"x": {"velocity": 1}},
    }
    with pytest.raises(InputError, match=r"position = \[-0\.4, 0\.4\] }$"):
        se.certify(slide, "energy")


def test_a_machine_without_limits_takes_none() -> None:
    machine = replace(DescribedMachine.of(MACHINES["chain"]()), limits=Limits({"joint1": JointLimits()}))
    with pytest.raises(InputError, match="joint3: has no position"):
        se.certify(machine)


@pytest.mark.thorough
@given(st.floats(-1e30, 1e30), st.floats(0, 1) | st.floats(0, 1e-7))
@settings(deadline=None)
def test_each_range_in_single_precision_holds_a_number(low: float, width: float) -> None:
    """A range that holds none is the number next to it, others stay: `*_in_box` says yes somewhere."""
    given_range = Range(low, low + width * abs(low))
    found = Box({"q": given_range}).rounded(np.float32).ranges["q"]
    tried = [np.nextafter(np.float32(low), np.float32(end)) for end in (-np.inf, low, np.inf)]
    inside = [x for x in map(float, tried) if given_range.low <= x <= given_range.high]
    assert found == given_range if inside else found.low == found.high == float(np.float32(found.low))
    assert abs(found.low - low) <= float(np.spacing(np.float32(abs(low)))) and found.low <= found.high
