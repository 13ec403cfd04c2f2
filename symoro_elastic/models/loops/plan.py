"""Plans of loops: selected equations, dependent variables, closed form and branch, singularities."""

from __future__ import annotations

import math
import random
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from enum import StrEnum

from symoro_elastic.machine.loops import Loop, branches
from symoro_elastic.machine.machine import Machine
from symoro_elastic.mechanics.loops.circuit import Passed
from symoro_elastic.mechanics.loops.closing import POINT, closing_columns
from symoro_elastic.mechanics.loops.linear import solve
from symoro_elastic.mechanics.loops.planar import Closed
from symoro_elastic.mechanics.spatial import Axis, is_zero
from symoro_elastic.models.loops.assembly import (
    SEED,
    Assembly,
    Position,
    independent,
    independent_rows,
    loop_branches,
    refuse_singular,
    refuse_wrong_number,
)
from symoro_elastic.models.loops.closed_forms import (
    Angles,
    agreeing_joints,
    agrees,
    in_space,
    is_planar,
    loop_circuit,
    parallelogram_angles,
    planar,
)
from symoro_elastic.models.loops.continuation import CLOSED
from symoro_elastic.models.loops.open_loops import not_closed, open_positions
from symoro_elastic.models.tree.once import once_for_each_machine
from symoro_elastic.models.tree.tree import Tree
from symoro_elastic.symbolic.arithmetic import FLOATS, evaluate
from symoro_elastic.symbolic.expression import Level, reachable
from symoro_elastic.symbolic.program import count

SAMPLES, DRAWS, REACH, GUESSES = 4, 16, 0.3, 12
ROUGH = 0.2
"""Largest correction of a start, rad or m."""

IN_PLANE = 0, 1, 5
"""Rows of the equations of a triangle in axes whose z is its normal."""


class Form(StrEnum):
    """Method by which dependent variables of a loop are computed from the independent ones."""

    MAP = "constant map"
    TRIANGLE = "triangle"
    SLIDE = "triangle with a slide"
    SLIDES = "two slides"
    ONE = "one joint"
    INVERSE = "inverse geometry"
    ASSEMBLED = "assembled"


FORMS = {3: Form.TRIANGLE, 2: Form.SLIDE, 1: Form.SLIDES}
"""Closed forms of planar loops by the number of turns among their three unknown joints."""


@dataclass(frozen=True)
class LoopPlan:
    """Plan of a loop: kept and dropped rows of its equations, dependent joints, closed form and branch.

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
        """Selected rows of the loop's equations in the axes of `view`; of a triangle, those in its plane."""
        return IN_PLANE[: len(self.kept)] if self.pivot is not None else self.kept


@dataclass(frozen=True)
class Plan:
    """All loops of a machine, in the order in which they are closed; `positions` are assembled, the first at start."""

    loops: tuple[LoopPlan, ...]
    assembly: Assembly
    positions: tuple[Position, ...]


def loops_of(machine: Machine) -> tuple[LoopPlan, ...]:
    """Plans of the loops of a machine, in the order in which they are closed; empty without loops."""
    return plan_of(machine).loops if machine.loops else ()


def assembled_joints(machine: Machine) -> tuple[int, ...]:
    """Joints whose variables no loop gives in closed form: arguments of the models."""
    return tuple(sorted({j for loop in loops_of(machine) if loop.is_assembled for j in loop.dependent}))


def lacks_closed_form(machine: Machine) -> bool:
    """Whether a loop of a machine closes by iteration only, so that its functions need the dependent variables."""
    return bool(assembled_joints(machine))


@once_for_each_machine
def plan_of(machine: Machine) -> Plan:
    """The plan of the loops of a machine (cached); raises `InputError` for loops that do not close."""
    assembly = Assembly(replace(machine))  # a copy: what is remembered must not keep the machine itself alive
    start = assembled_start(machine, assembly)
    positions = (start, *positions_near(machine, assembly, start))
    selected = independent_rows(assembly, positions)
    refuse_wrong_number(machine, assembly, selected)
    refuse_singular(machine, assembly, selected, positions)
    plans = []
    for loop in machine.loops:
        own = [k for k, equation in enumerate(assembly.equations) if equation.loop == loop.name]
        rows = tuple(assembly.equations[k].row for k in own if k in selected)
        dropped = tuple(assembly.equations[k].row for k in own if k not in selected)
        half_turns = _half_turns(assembly, machine.dependent_in(loop), start)
        plans.append(
            LoopPlan(loop, rows, dropped, machine.dependent_in(loop), Form.ASSEMBLED, {}, half_turns=half_turns)
        )
    return Plan(_with_forms(machine, assembly, _with_own(plans), positions), assembly, positions)


def _half_turns(assembly: Assembly, joints: Sequence[int], start: Position) -> dict[int, int]:
    """Angles of joints at the start in half turns, rounded, by joint."""
    turning = {j: assembly.tree.angle(j) for j in joints if assembly.machine.joint(j).sigma == 0}
    value = evaluate(turning.values(), assembly.symbols(start), FLOATS)
    return {j: round(float(value(x)) / math.pi) for j, x in turning.items()}


def _with_own(plans: Sequence[LoopPlan]) -> list[LoopPlan]:
    """The plans with dependent joints assigned to the loops that determine them, one loop after another."""
    waiting = list(plans)
    determined: list[LoopPlan] = []
    while waiting:
        used = {j for plan in determined for j in plan.dependent}
        rests = [(plan, tuple(j for j in plan.dependent if j not in used)) for plan in waiting]
        ready = next(((plan, dependent) for plan, dependent in rests if len(dependent) == len(plan.kept)), None)
        if ready is None:
            return [*determined, *(replace(plan, dependent=dependent) for plan, dependent in rests)]
        waiting.remove(ready[0])
        determined.append(replace(ready[0], dependent=ready[1]))
    return determined


def _with_forms(
    machine: Machine, assembly: Assembly, plans: Sequence[LoopPlan], positions: Sequence[Position]
) -> tuple[LoopPlan, ...]:
    """The plans with their closed forms, in the order in which loops can be closed."""
    waiting = list(plans)
    planned: list[LoopPlan] = []
    while waiting:
        shared = {j for plan in waiting for j in plan.dependent if sum(j in x.dependent for x in plans) > 1}
        ready = [plan for plan in waiting if not _needs(machine, plan, waiting)] or waiting[:1]
        plan = ready[0]
        waiting.remove(plan)
        if shared.isdisjoint(plan.dependent):
            other = [j for x in (*planned, *waiting) if x.form is not Form.MAP for j in x.dependent]
            plan = _with_form(assembly, plan, positions, other)
        planned.append(plan)
    return tuple(planned)


def _needs(machine: Machine, plan: LoopPlan, waiting: Sequence[LoopPlan]) -> bool:
    """Whether a loop contains dependent joints of other loops that are not closed yet."""
    around = machine.around(plan.loop)
    return any(j in around for other in waiting if other is not plan for j in other.dependent)


def _with_form(assembly: Assembly, plan: LoopPlan, positions: Sequence[Position], other: Sequence[int]) -> LoopPlan:
    """The plan with the closed form that gives the assembled positions; `other` joints depend on other loops."""
    tree = assembly.tree
    angles = parallelogram_angles(tree, plan.loop, plan.dependent, other)
    if angles is not None and all(agrees(tree, assembly, j, x, positions) for j, x in angles.items()):
        return replace(plan, form=Form.MAP)
    unknown = loop_circuit(tree, plan.loop, plan.dependent).unknown
    turns = sum(joint.axis is Axis.REVOLUTE for joint in unknown)
    if len(unknown) == 1 or (len(unknown) == 3 and turns and is_planar(assembly, plan.loop)):
        return _with_signs(assembly, plan, unknown, positions)
    if not {*other}.isdisjoint(tree.machine.around(plan.loop)):
        return plan
    if in_space(tree, plan.loop, plan.dependent, assembly, positions) is None:
        return plan
    view = view_of_point(tree, plan.loop, plan.dependent) if plan.kept == POINT else None
    return replace(plan, form=Form.INVERSE if turns else Form.SLIDES, is_in_space=True, view=view)


def _with_signs(
    assembly: Assembly, plan: LoopPlan, unknown: Sequence[Passed], positions: Sequence[Position]
) -> LoopPlan:
    """The plan, with the signs of its branch, of a planar loop or a loop with a single unknown joint."""
    signs = _signs(assembly, plan, [joint.joint for joint in unknown], positions)
    if signs is None:
        return plan
    turns = sum(joint.axis is Axis.REVOLUTE for joint in unknown)
    form = FORMS[turns] if len(unknown) == 3 else Form.ONE
    view, pivot = view_of_triangle(assembly.tree, plan.loop, plan.dependent) if form is Form.TRIANGLE else (None, None)
    return replace(plan, form=form, signs=signs, view=view, pivot=pivot)


def _signs(
    assembly: Assembly, plan: LoopPlan, unknown: Sequence[int], positions: Sequence[Position]
) -> dict[int, int] | None:
    """Signs of the root with which the closed form gives the assembled positions.

    None where neither sign does, and where both do: at a flat triangle, which selects no branch.
    """

    def closed_by(signs: Mapping[int, int]) -> tuple[Closed, list[int]]:
        closed_form = planar(assembly.tree, plan.loop, plan.dependent, signs)
        return closed_form, agreeing_joints(assembly.tree, assembly, plan.dependent, closed_form, positions)

    by_sign = {sign: closed_by(dict.fromkeys(unknown, sign)) for sign in (1, -1)}
    complete = [sign for sign, (_, joints) in by_sign.items() if len(joints) == len(plan.dependent)]
    if complete:
        (plus, _), (minus, _) = by_sign.values()
        is_determined = len(complete) == 1 or (plus.turns, plus.slides) == (minus.turns, minus.slides)
        return dict.fromkeys(unknown, complete[0]) if is_determined else None
    mixed = {j: -1 if j in by_sign[-1][1] else 1 for j in unknown}
    return mixed if len(closed_by(mixed)[1]) == len(plan.dependent) else None


def view_of_triangle(tree: Tree, loop: Loop, dependent: Collection[int]) -> tuple[int | None, int | None]:
    """The link in whose axes a triangle's equations are shortest, and the triangle's dependent revolute joint.

    It is a dependent turn of m's branch whose antecedent has the same normal.
    """
    _, to_end = branches(tree.machine.antecedents, loop)
    for j in to_end:
        link = tree.mechanism.link(j)
        if j in dependent and link.axis is Axis.REVOLUTE and is_zero(link.transform.steps[1].sine):
            return link.antecedent, j
    return None, None


def view_of_point(tree: Tree, loop: Loop, dependent: Collection[int]) -> int | None:
    """The link of a loop in whose axes the rates of three dependent joints need the fewest operations.

    Equations of a cut ball joint are equivalent in any axes. None is the frame that the cut joint meets.
    """
    views = [None, *(j for branch in branches(tree.machine.antecedents, loop) for j in branch)]
    return min(views, key=lambda view: _operations(tree, loop, dependent, view))


def _operations(tree: Tree, loop: Loop, dependent: Collection[int], view: int | None) -> int:
    """Number of operations of -W_d^-1 W over the other moving joints of the loop."""
    columns = {j: [V.entries[i] for i in POINT] for j, V in closing_columns(loop_branches(tree, loop, view)).items()}
    moving = [j for j in columns if j not in dependent and tree.mechanism.link(j).axis is not Axis.NONE]
    rates = solve([columns[j] for j in dependent], [columns[j] for j in moving])
    operations = count(reachable(x for column in rates for x in column), Level.STATE)
    return operations.products + operations.add


# The assembled position of a machine at the start of its loops, and others near it.
def assembled_start(machine: Machine, assembly: Assembly) -> Position:
    """The position where the loops close, near the start of the file; raises `InputError` where there is none."""
    parallelograms = _parallelograms(machine, assembly)
    rough = _with_found(machine, assembly, _mapped_start(machine, assembly, parallelograms))
    _refuse_doubt(machine, assembly, rough, parallelograms)
    assembled, error = assembly.assembled_position(rough, machine.dependent)
    if not error < CLOSED:
        assembled, error = assembly.assembled_position(rough, machine.with_variable)
        if error < CLOSED:
            selected = independent_rows(assembly, [assembled])
            refuse_wrong_number(machine, assembly, selected)
            refuse_singular(machine, assembly, selected, [assembled])
        error = error if all(abs(assembled[j] - rough[j]) < ROUGH for j in machine.independent) else math.inf
    if not error < CLOSED:
        _refuse_singular_anywhere(machine, assembly)
        raise not_closed(machine, assembly, rough)
    return assembled


def _refuse_singular_anywhere(machine: Machine, assembly: Assembly) -> None:
    """Reject dependent variables that depend on each other at all positions, closed or not.

    Where loops close the rank of W is at most what it is elsewhere.
    """
    positions = open_positions(machine)
    columns = independent([assembly.numbers(position)[1].T for position in positions])
    if len(columns) >= len(machine.dependent):
        refuse_singular(machine, assembly, range(len(assembly.equations)), positions)


def positions_near(machine: Machine, assembly: Assembly, start: Position) -> list[Position]:
    """Further assembled positions on the branch of the start, closer to it where distant ones are not reached.

    A parallelogram at the start is one at all of them: where it is flat another branch begins.
    """
    source, positions, reach = random.Random(SEED), list[Position](), REACH
    holding = [x for x in _parallelograms(machine, assembly).values() if _hold(assembly, x, start)]
    mapped_joints = {j for angles in holding for j in angles}
    for _ in range(DRAWS):
        target = {j: start[j] + source.uniform(-reach, reach) for j in machine.independent}
        if mapped_joints.issuperset(machine.dependent):
            positions.append(_on_parallelograms(assembly, holding, start | target))
        elif neighbour := assembly.position_at(start, target):
            positions += [neighbour] if all(_hold(assembly, x, neighbour) for x in holding) else []
        else:
            reach /= 2
        if len(positions) == SAMPLES:
            break
    return positions


def _hold(assembly: Assembly, angles: Angles, position: Position) -> bool:
    """Whether a loop is a parallelogram at a position, not crossed."""
    return all(agrees(assembly.tree, assembly, j, x, [position]) for j, x in angles.items())


def _on_parallelograms(assembly: Assembly, parallelograms: Sequence[Angles], position: Position) -> Position:
    """A position with the dependent joints of parallelograms set by their angles, in order of dependence."""
    for angles in parallelograms:
        offsets = {j: assembly.tree.offset(j) for j in angles}
        value = evaluate([*angles.values(), *offsets.values()], assembly.symbols(position), FLOATS)
        position = position | {j: float(value(x) - value(offsets[j])) for j, x in angles.items()}
    return position


def _refuse_doubt(machine: Machine, assembly: Assembly, rough: Position, parallelograms: Collection[str]) -> None:
    """Reject a loop without start that closes in several positions, unless it is a parallelogram."""
    for loop in machine.loops:
        dependent = machine.dependent_in(loop)
        if loop.start or not dependent or loop.name in parallelograms:
            continue
        closings = _other_positions(machine, assembly, rough, dependent)
        if len(closings) > 1:
            joint = machine.joint(dependent[0])
            values = " or ".join(f"{x[dependent[0]]:.2f}" for x in closings)
            count = {2: "two"}.get(len(closings), str(len(closings)))
            what = f"{count} positions ({joint.variable} = {values}): write start = {{ ... }}"
            raise machine.error(f"loop {loop.name}", what)


def _with_found(machine: Machine, assembly: Assembly, rough: Position) -> Position:
    """The start, completed by positions of joints that it omits, such that the loops close.

    Independent joints stay at zero; where loops do not close so, they move by the smallest change found at random.
    Raises `InputError` where the loops close in several positions.
    """
    missing = [j for j in machine.not_started if j in machine.dependent]
    free = [j for j in machine.not_started if j not in missing]
    if not machine.not_started:
        return rough
    starts = _near(machine, rough, _other_positions(machine, assembly, rough, missing, machine.dependent), free)
    if not starts and free:
        moving = (*machine.dependent, *free)
        closed = _near(machine, rough, _other_positions(machine, assembly, rough, machine.not_started, moving), free)
        nearest = min(closed, key=lambda x: sum(x[j] ** 2 for j in free), default=rough)
        rough = rough | {j: nearest[j] for j in free}
        starts = _near(machine, rough, _other_positions(machine, assembly, rough, missing, machine.dependent), free)
    if len(starts) > 1:
        ambiguous = next(j for j in missing if not _same(machine, starts[0], starts[1], [j]))
        loop = next(loop for loop in machine.loops if loop.start and ambiguous in machine.with_variable_in(loop))
        variable = machine.joint(ambiguous).variable
        values = " or ".join(dict.fromkeys(f"{x[ambiguous]:.2f}" for x in starts))
        what = f"the loops close in {len(starts)} positions ({variable} = {values}): give {variable} there"
        raise machine.error(f"loop {loop.name}, start", what)
    return _within_half_turns(machine, starts[0], missing) if starts else rough


def _within_half_turns(machine: Machine, position: Position, joints: Iterable[int]) -> Position:
    """The position with angles of `joints` reduced to half a turn, unless other joints follow them."""
    followed = {name for joint in machine.joints for name in joint.selected.names}
    turning = [j for j in joints if machine.joint(j).sigma == 0 and machine.joint(j).variable not in followed]
    return position | {j: math.remainder(position[j], 2 * math.pi) for j in turning}


def _near(machine: Machine, rough: Position, candidates: Sequence[Position], free: Collection[int]) -> list[Position]:
    """Candidates in which joints with a given start are roughly at it."""
    names_in_starts = {name for loop in machine.loops for name in loop.start}
    fixed = [j for name, j in machine.variables.items() if name in names_in_starts and j not in free]
    return [x for x in candidates if all(abs(x[j] - rough[j]) < ROUGH for j in fixed)]


def _other_positions(
    machine: Machine, assembly: Assembly, rough: Position, joints: Sequence[int], moving: Sequence[int] | None = None
) -> list[Position]:
    """Positions of joints in which the loops close, found from random guesses.

    Guesses are of `joints`, and Newton's method changes them, then the `moving` ones too; without `moving` all
    dependent joints.
    """
    source = random.Random(SEED)
    guessed = machine.dependent if moving is None else joints
    closings: list[Position] = []
    for _ in range(GUESSES):
        guess = rough | {j: source.uniform(-math.pi, math.pi) for j in guessed}
        if moving is not None:
            guess, _ = assembly.assembled_position(guess, joints)
        position, error = assembly.assembled_position(guess, machine.dependent if moving is None else moving)
        if error < CLOSED and not any(_same(machine, position, other, joints) for other in closings):
            closings.append(position)
    return sorted(closings, key=lambda x: -x[joints[0]]) if joints else closings


def _same(machine: Machine, a: Position, b: Position, joints: Sequence[int]) -> bool:
    """Whether joints have equal positions, up to full turns."""
    return all(
        abs(math.remainder(a[j] - b[j], 2 * math.pi) if machine.joint(j).sigma == 0 else a[j] - b[j]) < 1e-4
        for j in joints
    )


def _mapped_start(machine: Machine, assembly: Assembly, parallelograms: Mapping[str, Angles]) -> Position:
    """The start of the file; parallelograms without start are moved away from their flat position."""
    position = assembly.start()
    unstarted = {loop.name for loop in machine.loops if not loop.start}
    for name, angles in parallelograms.items():
        if name not in unstarted:
            continue
        if len(unstarted) == len(machine.loops):
            position |= {j: position[j] + 0.5 * (k + 1) for k, j in enumerate(machine.independent) if not position[j]}
        position = _on_parallelograms(assembly, [angles], position)
    return position


def _parallelograms(machine: Machine, assembly: Assembly) -> dict[str, Angles]:
    """Angles of the dependent joints of parallelograms by loop, in order of dependence."""
    angles_of_loops: dict[str, Angles] = {}
    waiting = list(machine.loops)
    while waiting:
        used = {j for angles in angles_of_loops.values() for j in angles}
        for loop in waiting:
            own = [j for j in machine.dependent_in(loop) if j not in used]
            angles = parallelogram_angles(assembly.tree, loop, own)
            if angles is not None:
                angles_of_loops[loop.name] = angles
                waiting.remove(loop)
                break
        else:
            break
    return angles_of_loops
