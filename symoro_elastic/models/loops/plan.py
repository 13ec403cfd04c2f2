"""How each loop of a machine closes: equations kept, dependent variables, closed form and branch, singularities."""

from __future__ import annotations

import math
import random
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from enum import StrEnum
from typing import TYPE_CHECKING

import numpy as np

from symoro_elastic.machine.loops import Loop
from symoro_elastic.machine.machine import Machine
from symoro_elastic.mechanics.loops.circuit import Passed
from symoro_elastic.mechanics.loops.closing import POINT
from symoro_elastic.mechanics.spatial import Axis
from symoro_elastic.models.loops.assembly import SEED, Assembly, Position, loop_branches
from symoro_elastic.models.loops.closed_forms import agreeing, agrees, in_space, loop_circuit, mapped, planar
from symoro_elastic.models.loops.independent_rows import independent_rows, refuse_singular, refuse_wrong_number
from symoro_elastic.models.loops.start import assembled_start, positions_near
from symoro_elastic.models.loops.view import view_of_point, view_of_triangle
from symoro_elastic.models.once import once_for_each_machine
from symoro_elastic.symbolic.arithmetic import FLOATS, evaluate

if TYPE_CHECKING:
    from symoro_elastic.models.bind import Bound

PARALLEL = 1e-12
"""Cosine or sine of the angle between axes that are at right angles, or parallel."""


IN_PLANE = 0, 1, 5
"""Rows of the equations of a triangle in axes whose z is its normal."""


class Form(StrEnum):
    """How dependent variables follow from the independent ones."""

    MAP = "constant map"
    TRIANGLE = "triangle"
    SLIDE = "triangle with a slide"
    SLIDES = "two slides"
    ONE = "one joint"
    INVERSE = "inverse geometry"
    ASSEMBLED = "assembled"


FORMS = {3: Form.TRIANGLE, 2: Form.SLIDE, 1: Form.SLIDES}
"""Of planar loops, by the number of turns among their three unknown joints."""


@dataclass(frozen=True)
class LoopPlan:
    """One loop: the rows of its equations that are kept and dropped, its dependent joints, its form and branch.

    `signs` are those of the root at each unknown joint of a planar loop. Rates may be found in the axes of the link
    `view`, where the same equations are `rows`, with levers over the turn `pivot`. Angles of joints are within half a
    turn of `half_turns`, those next to the start.
    """

    loop: Loop
    kept: tuple[int, ...]
    dropped: tuple[int, ...]
    dependent: tuple[int, ...]
    form: Form
    signs: dict[int, int]
    is_in_space: bool = False
    view: int | None = None
    pivot: int | None = None
    half_turns: Mapping[int, int] = field(default_factory=dict)

    @property
    def is_assembled(self) -> bool:
        """Whether no closed form gives its dependent variables."""
        return self.form is Form.ASSEMBLED

    @property
    def rows(self) -> tuple[int, ...]:
        """Rows of the equations in the axes of `view`: of a triangle, those along its plane."""
        return IN_PLANE[: len(self.kept)] if self.pivot is not None else self.kept


@dataclass(frozen=True)
class Plan:
    """All loops of a machine, in the order in which they are closed; `positions` are assembled, the first at start."""

    loops: tuple[LoopPlan, ...]
    assembly: Assembly
    positions: tuple[Position, ...]


@once_for_each_machine
def plan_of(machine: Machine, bind: Callable[[Machine], Bound]) -> Plan:
    """The plan of a machine with loops, made once; raises `InputError` for loops that do not close."""
    assembly = Assembly(machine, bind)
    start = assembled_start(machine, assembly)
    positions = (start, *positions_near(machine, assembly, start))
    kept = independent_rows(assembly, positions)
    refuse_wrong_number(machine, assembly, kept)
    refuse_singular(machine, assembly, kept, positions)
    plans = []
    for loop in machine.loops:
        own = [k for k, one in enumerate(assembly.equations) if one.loop == loop.name]
        rows = tuple(assembly.equations[k].row for k in own if k in kept)
        dropped = tuple(assembly.equations[k].row for k in own if k not in kept)
        half_turns = _half_turns(assembly, machine.dependent_in(loop), start)
        plans.append(
            LoopPlan(loop, rows, dropped, machine.dependent_in(loop), Form.ASSEMBLED, {}, half_turns=half_turns)
        )
    return Plan(_with_forms(machine, assembly, _with_own(plans), positions), assembly, positions)


def _half_turns(assembly: Assembly, joints: Sequence[int], start: Position) -> dict[int, int]:
    """Half turns that the angles of joints are next to at the start, by joint."""
    turning = {j: assembly.bound.angle(j) for j in joints if assembly.machine.joint(j).sigma == 0}
    value = evaluate(turning.values(), assembly.symbols(start), FLOATS)
    return {j: round(float(value(x)) / math.pi) for j, x in turning.items()}


def _with_own(plans: Sequence[LoopPlan]) -> list[LoopPlan]:
    """The plans, each with the dependent joints that it alone gives once others have theirs."""
    waiting = list(plans)
    found: list[LoopPlan] = []
    while waiting:
        taken = {j for one in found for j in one.dependent}
        rests = [(one, tuple(j for j in one.dependent if j not in taken)) for one in waiting]
        ready = next(((one, rest) for one, rest in rests if len(rest) == len(one.kept)), None)
        if ready is None:
            return [*found, *(replace(one, dependent=rest) for one, rest in rests)]
        waiting.remove(ready[0])
        found.append(replace(ready[0], dependent=ready[1]))
    return found


def _with_forms(
    machine: Machine, assembly: Assembly, plans: Sequence[LoopPlan], positions: Sequence[Position]
) -> tuple[LoopPlan, ...]:
    """The plans with their closed forms, loops whose other joints are known first."""
    waiting = list(plans)
    found: list[LoopPlan] = []
    while waiting:
        shared = {j for one in waiting for j in one.dependent if sum(j in x.dependent for x in plans) > 1}
        ready = [one for one in waiting if not _needs(machine, one, waiting)] or waiting[:1]
        one = ready[0]
        waiting.remove(one)
        if shared.isdisjoint(one.dependent):
            other = [j for x in (*found, *waiting) if x.form is not Form.MAP for j in x.dependent]
            one = _with_form(assembly, one, positions, other)
        found.append(one)
    return tuple(found)


def _needs(machine: Machine, one: LoopPlan, waiting: Sequence[LoopPlan]) -> bool:
    """Whether a loop runs through dependent joints of others that are not closed yet."""
    around = machine.around(one.loop)
    return any(j in around for other in waiting if other is not one for j in other.dependent)


def _with_form(assembly: Assembly, one: LoopPlan, positions: Sequence[Position], other: Sequence[int]) -> LoopPlan:
    """The plan with the closed form that gives the assembled positions; `other` joints depend on other loops."""
    bound = assembly.bound
    angles = mapped(bound, one.loop, one.dependent, other)
    if angles is not None and all(agrees(bound, assembly, j, x, positions) for j, x in angles.items()):
        return replace(one, form=Form.MAP)
    unknown = loop_circuit(bound, one.loop, one.dependent).unknown
    turns = sum(joint.axis is Axis.REVOLUTE for joint in unknown)
    if len(unknown) == 1 or (len(unknown) == 3 and turns and _is_planar(bound, one, assembly)):
        return _with_signs(assembly, one, unknown, positions)
    if not {*other}.isdisjoint(bound.machine.around(one.loop)):
        return one
    if in_space(bound, one.loop, one.dependent, assembly, positions) is None:
        return one
    view = view_of_point(bound, one.loop, one.dependent) if one.kept == POINT else None
    return replace(one, form=Form.INVERSE if turns else Form.SLIDES, is_in_space=True, view=view)


def _with_signs(
    assembly: Assembly, one: LoopPlan, unknown: Sequence[Passed], positions: Sequence[Position]
) -> LoopPlan:
    """The plan of a planar loop, or of one with a single unknown joint, on its branch."""
    signs = _signs(assembly, one, [joint.joint for joint in unknown], positions)
    if signs is None:
        return one
    turns = sum(joint.axis is Axis.REVOLUTE for joint in unknown)
    form = FORMS[turns] if len(unknown) == 3 else Form.ONE
    view, pivot = view_of_triangle(assembly.bound, one.loop, one.dependent) if form is Form.TRIANGLE else (None, None)
    return replace(one, form=form, signs=signs, view=view, pivot=pivot)


def _signs(
    assembly: Assembly, one: LoopPlan, unknown: Sequence[int], positions: Sequence[Position]
) -> dict[int, int] | None:
    """Signs of the root with which the closed form gives the assembled positions; None where there are none."""

    def closed_by(signs: Mapping[int, int]) -> list[int]:
        found = planar(assembly.bound, one.loop, one.dependent, signs)
        return agreeing(assembly.bound, assembly, one.dependent, found, positions)

    by_sign = {sign: closed_by(dict.fromkeys(unknown, sign)) for sign in (1, -1)}
    for sign, joints in by_sign.items():
        if len(joints) == len(one.dependent):
            return dict.fromkeys(unknown, sign)
    mixed = {j: -1 if j in by_sign[-1] else 1 for j in unknown}
    return mixed if len(closed_by(mixed)) == len(one.dependent) else None


def _is_planar(bound: Bound, one: LoopPlan, assembly: Assembly) -> bool:
    """Whether all turns of a loop are about one direction, and all its slides across it, in any position."""
    seen = loop_branches(bound, one.loop)
    axes = [(link.axis, seen.seen.frames[k].z) for k, link in seen.mechanism.from_base() if link.axis is not Axis.NONE]
    if seen.cut.axis is not Axis.NONE:
        axes.append((seen.cut.axis, seen.seen.frames[seen.number[seen.cut.m]].z))
    source = random.Random(SEED)
    anywhere = assembly.symbols({j: source.uniform(-3, 3) for j in bound.machine.owners})
    value = evaluate([x for _, z in axes for x in z], anywhere, FLOATS)
    numbers = [(axis, np.array([value(x) for x in z])) for axis, z in axes]
    turning = [z for axis, z in numbers if axis is Axis.REVOLUTE]
    if not turning:
        return False
    normal = turning[0]
    return all(
        np.linalg.norm(np.cross(normal, z)) < PARALLEL if axis is Axis.REVOLUTE else abs(normal @ z) < PARALLEL
        for axis, z in numbers
    )
