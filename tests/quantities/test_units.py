"""Units of quantities are right: in units n times as long, heavy and slow all numbers change as their units say."""

from __future__ import annotations

import contextlib
import math
import re
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.columns import Cell, cells, with_cells
from symoro_elastic.machine.formula import ZERO, Formula
from symoro_elastic.machine.machine import Base, KnownOfBase, Machine, Parameter
from symoro_elastic.machine.scene import COMPONENTS
from symoro_elastic.models.programs.catalogue import MODELS, TracedModel, trace
from symoro_elastic.numerics.linear.grouping import grouping_by_rank
from symoro_elastic.quantities import INTERMEDIATES, PREFIXES, Intermediate, PairUnit, Quantity, Unit
from symoro_elastic.symbolic.arithmetic import FLOATS, evaluate
from tests.models.test_floating_base import HULL, on
from tests.references.random_machines import random_machine, two_children

SCALES = {"m": 3.0, "kg": 7.0, "s": 2.0, "rad": 1.0}
SCALES |= {"N": SCALES["kg"] * SCALES["m"] / SCALES["s"] ** 2}
SCALES |= {"J": SCALES["N"] * SCALES["m"]}
SCALES |= {"A": 5.0, "V": SCALES["J"] / SCALES["s"] / 5.0}
SCALES |= {"Ohm": SCALES["V"] / SCALES["A"], "H": SCALES["V"] * SCALES["s"] / SCALES["A"]}
TRIANGLE = "n(n + 1)/2"
WORD = re.compile(r"([A-Za-z]+)(\d*)")


def scale(unit: str) -> float:
    """How many of the smaller units make one: 9 of `m2`."""
    over, _, under = unit.partition("/")
    sizes = [[SCALES[name] ** int(power or 1) for name, power in WORD.findall(part)] for part in (over, under)]
    return math.prod(sizes[0]) / math.prod(sizes[1])


def kind(component: int) -> int:
    """Of a component of a screw: as of a prismatic joint (1) or of a revolute one (0)."""
    return int(component <= 3)


def kinds(machine: Machine, row: Intermediate, joint: int, component: str) -> list[int]:
    """Kinds of the joints and components that an intermediate variable belongs to, that of its row first."""
    sigma = [0, *(joint.sigma for joint in machine.joints)]
    if row.component == "entry":
        return [kind(int(x)) for x in component]
    numbers = [int(x) for x in component.split("_")] if component.replace("_", "").isdigit() else []
    if row.component == "six":
        return [kind(numbers[0]), sigma[joint]]
    if row.component == "row column":
        return [kind(numbers[0]), sigma[numbers[1] if row.name == "Jc" else joint]]
    if row.component in ("place", "number"):
        return places([joint, *numbers], sigma)
    return [sigma[joint]]


def places(numbers: list[int], sigma: list[int]) -> list[int]:
    """Kinds of the row and the column of `3_2`, `0_5_2`, `3_0_5`: joints, and degrees of freedom of the base."""
    number, *rest = numbers
    first = [sigma[number] if number else kind(rest.pop(0))]
    return [*first, *places(rest, sigma)] if rest else first


def unit_of(unit: Unit | PairUnit, found: list[int]) -> str:
    return unit.of(found[0]) if isinstance(unit, Unit) else unit.of(found[0], found[1])


def symbolic(machine: Machine) -> Machine:
    """The machine under a gravity that has a name."""
    gravity = Base(gravity=(ZERO, ZERO, Formula.parse("-g0")))
    return replace(machine, base=gravity, parameters=(*machine.parameters, Parameter("g0", Formula.parse(9.81))))


def floating(machine: Machine, known: KnownOfBase) -> Machine:
    """The machine on a floating base, the numbers of its body named."""
    named: list[Parameter] = []

    def name(cell: Cell, formula: Formula) -> Formula:
        named.append(Parameter(f"hull_{len(named)}", formula))
        return Formula.parse(named[-1].name)

    machine = on(replace(machine, base=Base()), known, with_cells(HULL, name))
    return replace(machine, base=symbolic(machine).base, parameters=(*machine.parameters, *named))


def parameter_scales(machine: Machine) -> dict[str, float]:
    """Of each parameter: it fills one cell."""
    found = {"g0": scale("m/s2")}
    for joint in machine.joints:
        for cell, formula in cells(joint):
            units = cell.column.dimension.units
            found |= dict.fromkeys(formula.names, scale(units[joint.sigma == 1]))
    for cell, formula in cells(machine.floating.body) if machine.floating else ():
        found |= dict.fromkeys(formula.names, scale(cell.column.dimension.units[0]))
    return found


def inputs(machine: Machine, traced: TracedModel, rng: np.random.Generator) -> Iterator[tuple[str, float, float]]:
    """Each variable, a value, the scale of its unit."""
    sigma = {"n": [j.sigma for j in machine.independent_joints], "m": [machine.joint(j).sigma for j in machine.motors]}
    scales = parameter_scales(machine)
    for parameter in machine.parameters:
        yield parameter.name, parameter.value.value(), scales[parameter.name]
    for argument in traced.program.inputs:
        row = traced.model.quantity(argument.name)
        each = sigma.get(row.shape) or [kind(k) for k in range(1, len(argument.symbols) + 1)]
        if row.shape == "components":
            each = [kind(int(name.rsplit("_", 1)[-1])) if row.unit else 0 for name in argument.symbols]
        for name, k in zip(argument.symbols, each, strict=True):
            yield name, float(rng.uniform(0.3, 1.0)), scale(row.unit.of(k)) if row.unit else 1.0


def entries(machine: Machine, traced: TracedModel, row: Quantity, shape: tuple[int, ...]) -> list[list[int]]:
    """Kinds that each entry of a result belongs to, its row first."""
    moving = [joint.sigma for joint in machine.independent_joints]
    motors = [machine.joint(j).sigma for j in machine.motors]
    others = [machine.joint(j).sigma for j in machine.independent if j not in machine.motors]
    six = [kind(k) for k in range(1, 7)]
    chosen = (
        [machine.joint(j).sigma for j in traced.rows[row.name]] if traced.model.family == "inverse kinematics" else []
    )
    of = {"n": (moving, others, six + moving, chosen), "m": (motors,), "6": (six,), "(n - m)": (others,)}
    of["components"] = (
        [kind(COMPONENTS.index(x) + 1) for x in traced.results[row.name].column_labels if x in COMPONENTS],
    )
    if row.axes == (TRIANGLE,):
        each = six + moving if machine.floating else moving
        return [[each[i], each[j]] for i in range(len(each)) for j in range(i + 1)]
    found: list[list[int]] = [[]]
    for axis, size in zip(row.axes, shape, strict=True):
        each = next(x for x in of.get(axis, ([-1] * size,)) if len(x) == size)
        found = [[*before, k] for before in found for k in each]
    return [[k for k in one if k >= 0] for one in found]


def statement_units(machine: Machine, traced: TracedModel) -> Iterator[tuple[str, Any, str]]:
    """Name, expression and unit of each intermediate variable that has one; parts of quantities are left out."""
    rows = [row for row in INTERMEDIATES if row.unit and (not row.of_results or {*traced.results} & {*row.of_results})]
    for statement in (*traced.program.once, *traced.program.statements):
        for row in rows if not statement.name.startswith(PREFIXES) else ():
            match = row.match(statement.name)
            if match and not match["part"]:
                of = kinds(machine, row, int(match["j"]), match.groupdict().get("c") or "")
                yield statement.name, statement.node, unit_of(row.unit, of)


def result_units(machine: Machine, traced: TracedModel) -> Iterator[tuple[str, Any, str]]:
    """Name, expression and unit of each entry of results."""
    for output in traced.program.outputs:
        row = traced.model.quantity(output.name)
        if row.unit is not None and output.name not in UNEVEN:
            for x, of in zip(output.entries, entries(machine, traced, row, output.shape), strict=True):
                yield output.name, x, unit_of(row.unit, of or [0])


UNEVEN = ("T", "E")
"""Rows of a placement end with 0 0 0 1; axes of E count energies."""


def traces(machine: Machine) -> Iterator[TracedModel]:
    for name in MODELS:
        with contextlib.suppress(InputError):
            yield trace(machine, name, grouping_of=grouping_by_rank)


CASES = [
    *(symbolic(random_machine(k, joints=4, symbolic=True, prismatic=0.5)) for k in range(4)),
    symbolic(two_children(symbolic=True)),
    *(floating(symbolic(random_machine(k, joints=3, symbolic=True)), known) for k, known in enumerate(KnownOfBase)),
]


@pytest.mark.sampled(1000)
@pytest.mark.parametrize("machine", CASES, ids=range(len(CASES)))
def test_numbers_change_as_their_units_say(machine: Machine) -> None:
    wrong, seen = set(), 0
    for traced in traces(machine):
        given = list(inputs(machine, traced, np.random.default_rng(1)))
        named = [*statement_units(machine, traced), *result_units(machine, traced)]
        roots = [x for _, x, _ in named]
        before = evaluate(roots, {name: x for name, x, _ in given}, FLOATS)
        after = evaluate(roots, {name: x * factor for name, x, factor in given}, FLOATS)
        for name, x, unit in named:
            if not math.isclose(after(x), before(x) * scale(unit), rel_tol=1e-6, abs_tol=1e-9):
                wrong.add(f"{traced.model.name}: {name}: {unit}")
        seen += len(named)
    assert not wrong and seen > 500
