"""How each loop of a machine closes: equations kept, dependent variables, closed form and branch, singularities."""

from __future__ import annotations

import math
import random
import weakref
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from typing import TYPE_CHECKING

import numpy as np

from symoro_elastic.array_types import Array
from symoro_elastic.equations.spatial import Axis, is_zero
from symoro_elastic.machine.loops import Loop, branches
from symoro_elastic.machine.machine import Machine
from symoro_elastic.models.loops.assembly import CLOSED, SEED, STEPS, Assembly, Position, loop_branches
from symoro_elastic.models.loops.closed_forms import Angles, agrees, loop_circuit, mapped, planar
from symoro_elastic.symbolic.arithmetic import FLOATS, evaluate

if TYPE_CHECKING:
    from symoro_elastic.models.bind import Bound

INDEPENDENT = 1e-8
"""Of a row of W, relative, beyond which it is no combination of others."""
SAMPLES, DRAWS, REACH, GUESSES, ROUGH = 4, 40, 0.3, 12, 0.2
EIGHT_ULPS = 1e-12


class Form(StrEnum):
    """How dependent variables follow from the independent ones."""

    MAP = "constant map"
    TRIANGLE = "triangle"
    SLIDE = "triangle with a slide"
    SLIDES = "two slides"
    ONE = "one joint"
    ASSEMBLED = "assembled"


FORMS = {3: Form.TRIANGLE, 2: Form.SLIDE, 1: Form.SLIDES}
"""Of planar loops, by the number of turns among their three unknown joints."""


@dataclass(frozen=True)
class LoopPlan:
    """One loop: the rows of its equations that are kept and dropped, its dependent joints, its form and branch.

    `signs` are those of the root at each unknown joint. Rates may be found in the axes of the link `view`, where the
    same equations are `rows`, with levers over the turn `pivot`.
    """

    loop: Loop
    kept: tuple[int, ...]
    dropped: tuple[int, ...]
    dependent: tuple[int, ...]
    form: Form
    signs: dict[int, int]
    view: int | None = None
    pivot: int | None = None

    @property
    def rows(self) -> tuple[int, ...]:
        """Rows of the equations in the axes of `view`, whose z is the normal of the plane; those kept without."""
        return self.kept if self.view is None else (0, 1, 5)[: len(self.kept)]


@dataclass(frozen=True)
class Plan:
    """All loops of a machine, in the order in which they are closed; `positions` are assembled, the first at start."""

    loops: tuple[LoopPlan, ...]
    assembly: Assembly
    positions: tuple[Position, ...]

    @property
    def needs_assembly(self) -> bool:
        """Whether dependent variables are arguments of the models."""
        return any(one.form is Form.ASSEMBLED for one in self.loops)


_known: dict[int, tuple[weakref.ref[Machine], Plan]] = {}


def plan_of(machine: Machine, bind: Callable[[Machine], Bound]) -> Plan:
    """The plan of a machine with loops, made once; raises `InputError` for loops that do not close."""
    known = _known.get(id(machine))
    if known is not None and known[0]() is machine:
        return known[1]
    plan = _made(machine, bind)
    key = id(machine)
    _known[key] = weakref.ref(machine, lambda _: _known.pop(key, None) if _known is not None else None), plan
    return plan


def _made(machine: Machine, bind: Callable[[Machine], Bound]) -> Plan:
    assembly = Assembly(machine, bind)
    start = _assembled_start(machine, assembly)
    positions = (start, *_positions_near(machine, assembly, start))
    kept = _independent_rows(assembly, positions)
    _refuse_wrong_number(machine, assembly, kept)
    _refuse_singular(machine, assembly, kept, positions)
    plans = []
    for loop in machine.loops:
        own = [k for k, one in enumerate(assembly.equations) if one.loop == loop.name]
        rows = tuple(assembly.equations[k].row for k in own if k in kept)
        dropped = tuple(assembly.equations[k].row for k in own if k not in kept)
        plans.append(LoopPlan(loop, rows, dropped, machine.dependent_in(loop), Form.ASSEMBLED, {}))
    return Plan(_with_forms(machine, assembly, _with_own(plans), positions), assembly, positions)


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


def _assembled_start(machine: Machine, assembly: Assembly) -> Position:
    rough = _mapped_start(machine, assembly)
    _refuse_doubt(machine, assembly, rough)
    found, error = assembly.assembled(rough, machine.dependent)
    if not error < CLOSED:
        found, error = assembly.assembled(rough, machine.owners)
        if error < CLOSED:
            kept = _independent_rows(assembly, [found])
            _refuse_wrong_number(machine, assembly, kept)
            _refuse_singular(machine, assembly, kept, [found])
        error = error if all(abs(found[j] - rough[j]) < ROUGH for j in machine.moving) else math.inf
    if not error < CLOSED:
        found, _ = assembly.assembled(rough, machine.dependent)
        errors = np.abs(assembly.numbers(found)[0])
        worst = assembly.equations[int(np.argmax(errors))]
        what = f"no position near start: {np.max(errors):.2g} {'m' if worst.row < 3 else 'rad'} stay open"
        what += f" after {STEPS} steps of Newton's method"
        started = any(loop.start for loop in machine.loops if loop.name == worst.loop)
        raise machine.error(f"loop {worst.loop}", what if started else f"{what}: write start = {{ ... }}")
    return found


def _refuse_doubt(machine: Machine, assembly: Assembly, rough: Position) -> None:
    """Refuse a loop that may be closed in several positions and has no start; parallelograms have one."""
    parallelograms = _parallelograms(machine, assembly)
    for loop in machine.loops:
        dependent = machine.dependent_in(loop)
        if loop.start or not dependent or loop.name in parallelograms:
            continue
        found = _other_positions(machine, assembly, rough, dependent)
        if len(found) > 1:
            joint = machine.joint(dependent[0])
            values = " or ".join(f"{x[dependent[0]]:.2f}" for x in found)
            count = {2: "two"}.get(len(found), str(len(found)))
            what = f"{count} positions ({joint.variable} = {values}): write start = {{ ... }}"
            raise machine.error(f"loop {loop.name}", what)


def _parallelograms(machine: Machine, assembly: Assembly) -> dict[str, Angles]:
    """Angles of the dependent joints of each parallelogram, those first through which others run."""
    found: dict[str, Angles] = {}
    waiting = list(machine.loops)
    while waiting:
        taken = {j for angles in found.values() for j in angles}
        for loop in waiting:
            own = [j for j in machine.dependent_in(loop) if j not in taken]
            angles = mapped(assembly.bound, loop, own)
            if angles is not None:
                found[loop.name] = angles
                waiting.remove(loop)
                break
        else:
            break
    return found


def _other_positions(machine: Machine, assembly: Assembly, rough: Position, dependent: Sequence[int]) -> list[Position]:
    """Positions of the dependent joints in which the loops close, found from random guesses."""
    source = random.Random(SEED)
    found: list[Position] = []
    for _ in range(GUESSES):
        guess = rough | {j: source.uniform(-math.pi, math.pi) for j in machine.dependent}
        position, error = assembly.assembled(guess, machine.dependent)
        if error < CLOSED and not any(_same(machine, position, other, dependent) for other in found):
            found.append(position)
    return sorted(found, key=lambda x: -x[dependent[0]])


def _same(machine: Machine, one: Position, other: Position, joints: Sequence[int]) -> bool:
    """Whether joints stand alike, up to full turns."""
    return all(
        abs(math.remainder(one[j] - other[j], 2 * math.pi) if machine.joint(j).sigma == 0 else one[j] - other[j]) < 1e-4
        for j in joints
    )


def _mapped_start(machine: Machine, assembly: Assembly) -> Position:
    """The start that the file gives; parallelograms without one stand apart from their flat position."""
    position = assembly.start()
    unstarted = {loop.name for loop in machine.loops if not loop.start}
    for name, angles in _parallelograms(machine, assembly).items():
        if name not in unstarted:
            continue
        if len(unstarted) == len(machine.loops):
            position |= {j: position[j] + 0.5 * (k + 1) for k, j in enumerate(machine.moving) if not position[j]}
        symbols = {str(machine.joint(j).variable): x for j, x in position.items()}
        offsets = {j: assembly.bound.offset(j) for j in angles}
        value = evaluate([*angles.values(), *offsets.values()], assembly.values | symbols, FLOATS)
        position |= {j: float(value(x) - value(offsets[j])) for j, x in angles.items()}
    return position


def _positions_near(machine: Machine, assembly: Assembly, start: Position) -> list[Position]:
    source, found = random.Random(SEED), []
    position = start
    for _ in range(DRAWS):
        target = {j: start[j] + source.uniform(-REACH, REACH) for j in machine.moving}
        moved = assembly.moved(position, target, machine.dependent)
        if moved is not None:
            found.append(moved)
            position = moved
        if len(found) == SAMPLES:
            break
    return found


def _independent_rows(assembly: Assembly, positions: Sequence[Position]) -> list[int]:
    """Equations that are no combination of those before them, in one of the positions at least."""
    kept: list[int] = []
    matrices = [assembly.numbers(position)[1] for position in positions]
    for row in range(len(assembly.equations)):
        if any(_rank(W[[*kept, row]]) > _rank(W[kept]) for W in matrices):
            kept.append(row)
    return kept


def _rank(W: Array) -> int:
    if not W.size:
        return 0
    lengths = np.linalg.norm(W, axis=1, keepdims=True)
    return int(np.linalg.matrix_rank(W / np.where(lengths > INDEPENDENT, lengths, np.inf), tol=INDEPENDENT))


def _refuse_wrong_number(machine: Machine, assembly: Assembly, kept: Sequence[int]) -> None:
    if len(kept) == len(machine.dependent):
        return
    taken: set[int] = set()
    for loop in machine.loops:
        own = [k for k, one in enumerate(assembly.equations) if one.loop == loop.name]
        dependent, rows = [j for j in machine.dependent_in(loop) if j not in taken], [k for k in own if k in kept]
        if len(dependent) != len(rows):
            raise machine.error(f"loop {loop.name}", _wrong_number(machine, dependent, len(rows), len(own)))
        taken.update(dependent)


def _wrong_number(machine: Machine, dependent: Sequence[int], rows: int, total: int) -> str:
    names = ", ".join(str(machine.joint(j).variable) for j in dependent)
    dropped = f" ({total - rows} of {total} are fulfilled by the plane)" if total > rows else ""
    what = f"{rows} equations for {len(dependent)} dependent variables{dropped}: "
    return what + (f"keep one of {names} independent" if len(dependent) > rows else "name more joints in dependent")


def _refuse_singular(machine: Machine, assembly: Assembly, kept: Sequence[int], positions: Sequence[Position]) -> None:
    columns = [machine.owners.index(j) for j in machine.dependent]
    matrices = [assembly.numbers(position)[1][list(kept)] for position in positions]
    if not columns or any(_rank(W[:, columns].T) == len(columns) for W in matrices):
        return
    *_, V = np.linalg.svd(matrices[-1][:, columns])
    together = [machine.joint(j) for j, x in zip(machine.dependent, V[-1], strict=True) if abs(x) > 1e-6]
    names = " and ".join(str(joint.variable) for joint in together)
    parallel = "are parallel" if len(together) == 2 else "depend on each other"
    both = "both" if len(together) == 2 else "all"
    what = f"{names} cannot {both} depend: their columns {parallel} in every position; try {_other(machine, matrices)}"
    loops = [loop.name for loop in machine.loops if {*machine.dependent_in(loop)} & {*machine.dependent}]
    raise machine.error(f"loop {loops[0]}", what)


def _other(machine: Machine, matrices: Sequence[Array]) -> str:
    """Joints that can depend, as a list in a file."""
    kept: list[int] = []
    for k in range(len(machine.owners)):
        if any(_rank(W[:, [*kept, k]].T) > len(kept) for W in matrices):
            kept.append(k)
    return "[" + ", ".join(f'"{machine.joint(machine.owners[k]).variable}"' for k in kept) + "]"


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
        form, signs = Form.ASSEMBLED, dict[int, int]()
        if shared.isdisjoint(one.dependent):
            other = [j for x in (*found, *waiting) if x.form is not Form.MAP for j in x.dependent]
            form, signs = _form(assembly, one, positions, other)
        view, pivot = _view(assembly.bound, one) if form is Form.TRIANGLE else (None, None)
        found.append(replace(one, form=form, signs=signs, view=view, pivot=pivot))
    return tuple(found)


def _view(bound: Bound, one: LoopPlan) -> tuple[int | None, int | None]:
    """The link in whose axes the equations of a triangle are shortest, and the turn that it carries.

    It is a dependent turn of m's branch whose antecedent has the same normal.
    """
    _, to_end = branches(bound.machine.antecedents, one.loop)
    for j in to_end:
        link = bound.mechanism.link(j)
        if j in one.dependent and link.axis is Axis.REVOLUTE and is_zero(link.transform.steps[1].sine):
            return link.antecedent, j
    return None, None


def _needs(machine: Machine, one: LoopPlan, waiting: Sequence[LoopPlan]) -> bool:
    """Whether a loop runs through dependent joints of others that are not closed yet."""
    around = {j for branch in branches(machine.antecedents, one.loop) for j in branch}
    return any(not around.isdisjoint(other.dependent) for other in waiting if other is not one)


def _form(
    assembly: Assembly, one: LoopPlan, positions: Sequence[Position], other: Sequence[int]
) -> tuple[Form, dict[int, int]]:
    """The closed form that gives the assembled positions, and its signs."""
    bound = assembly.bound
    angles = mapped(bound, one.loop, one.dependent, other)
    if angles is not None and all(agrees(assembly, j, x, positions) for j, x in angles.items()):
        return Form.MAP, {}
    loop = loop_circuit(bound, one.loop, one.dependent)
    turns = sum(joint.axis is Axis.REVOLUTE for joint in loop.unknown)
    if len(loop.unknown) != 1 and (len(loop.unknown) != 3 or not turns or not _is_planar(bound, one, assembly)):
        return Form.ASSEMBLED, {}
    signs = _signs(assembly, one, [joint.joint for joint in loop.unknown], positions)
    if signs is None:
        return Form.ASSEMBLED, {}
    return FORMS[turns] if len(loop.unknown) == 3 else Form.ONE, signs


def _signs(
    assembly: Assembly, one: LoopPlan, unknown: Sequence[int], positions: Sequence[Position]
) -> dict[int, int] | None:
    """Signs of the root with which the closed form gives the assembled positions; None where there are none."""

    def agreeing(signs: Mapping[int, int]) -> list[int]:
        found = planar(assembly.bound, one.loop, one.dependent, signs)
        forms = {**found.turns, **found.slides}
        return [j for j in one.dependent if agrees(assembly, j, forms[j], positions)]

    by_sign = {sign: agreeing(dict.fromkeys(unknown, sign)) for sign in (1, -1)}
    for sign, joints in by_sign.items():
        if len(joints) == len(one.dependent):
            return dict.fromkeys(unknown, sign)
    mixed = {j: -1 if j in by_sign[-1] else 1 for j in unknown}
    return mixed if len(agreeing(mixed)) == len(one.dependent) else None


def _is_planar(bound: Bound, one: LoopPlan, assembly: Assembly) -> bool:
    """Whether all turns of a loop are about one direction, and all its slides across it, in any position."""
    seen = loop_branches(bound, one.loop)
    axes = [(link.axis, seen.seen.frames[k].z) for k, link in seen.mechanism.from_base() if link.axis is not Axis.NONE]
    if seen.cut.axis is not Axis.NONE:
        axes.append((seen.cut.axis, seen.seen.frames[seen.number[seen.cut.m]].z))
    source = random.Random(SEED)
    symbols = {str(bound.machine.joint(j).variable): source.uniform(-3, 3) for j in bound.machine.owners}
    value = evaluate([x for _, z in axes for x in z], assembly.values | symbols, FLOATS)
    numbers = [(axis, np.array([value(x) for x in z])) for axis, z in axes]
    turning = [z for axis, z in numbers if axis is Axis.REVOLUTE]
    if not turning:
        return False
    normal = turning[0]
    return all(
        np.linalg.norm(np.cross(normal, z)) < EIGHT_ULPS if axis is Axis.REVOLUTE else abs(normal @ z) < EIGHT_ULPS
        for axis, z in numbers
    )
