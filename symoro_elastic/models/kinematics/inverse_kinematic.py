"""Inverse kinematic models of first and second order, and the determinant and inverse of a Jacobian.

A scene names the frame and its components, as in ["tool.x", "tool.y", "tool.rz"], which stand in the order x, y, z, rx,
ry, rz; without components they are those that some joint changes. Joints that do not change them have no entry in the
results.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from symoro_elastic.foundation.scalar import Scalar
from symoro_elastic.machine.frames import FrameNames
from symoro_elastic.machine.scene import COMPONENTS, Parts
from symoro_elastic.mechanics.inverse_kinematics import (
    DependentRows,
    blocks,
    determinant_factors,
    least_norm,
    solve_square,
)
from symoro_elastic.mechanics.kinematics import FrameSet, accelerations, frame_set, jacobian, path
from symoro_elastic.mechanics.spatial import AT_REST, ZERO, Axis, Twist, Vector, cross, is_zero
from symoro_elastic.models.bound.bind import Bound
from symoro_elastic.models.bound.model import Frames, Model, Result, Results
from symoro_elastic.models.kinematics.geometric import by_independent, link_of, observer_of, twists
from symoro_elastic.models.tree.modular import zero_test
from symoro_elastic.quantities import Quantity, quantity
from symoro_elastic.quantities.signatures import ARGUMENT, RESULT
from symoro_elastic.symbolic.expression import reachable
from symoro_elastic.symbolic.operations import SYMBOL

Row = tuple[Scalar, ...]


@dataclass(frozen=True)
class Task:
    """Components of a frame's twist, seen from another frame, and the Jacobian in which they are simplest.

    `rows` holds the Jacobian of the task, `columns` the joints of its columns. `restate` maps the components of
    a twist, or of its derivative at zero joint accelerations, to those of `rows`: by a change of axes and of the point
    where all six are given, else unchanged.
    """

    frames: Frames
    components: tuple[int, ...]
    columns: tuple[int, ...]
    rows: tuple[Row, ...]
    restate: Callable[[Sequence[Scalar]], Sequence[Scalar]]


def task_of(bound: Bound, requested: Frames, model: str) -> Task:
    """The task of a model in a scene; raises `InputError` where the joints cannot move its components."""
    frames = _frames(bound, requested, model)
    views = frame_set(bound.mechanism, observer_of(bound, frames[0]))
    columns = _columns(bound, jacobian(bound.mechanism, views, link_of(bound, frames[0])))
    vanishes = zero_test()
    changed = [k for k in range(6) if not all(vanishes(column[k]) for column in columns.values())]
    names = {frame.component for frame in frames}
    components = tuple(changed) if "" in names else tuple(k for k, name in enumerate(COMPONENTS) if name in names)
    _refuse_unchanged(bound, components, changed, model)
    joints = tuple(j for j, column in columns.items() if not all(vanishes(column[k]) for k in components))
    task = Task(frames, components, joints, tuple(tuple(columns[j][k] for j in joints) for k in components), tuple)
    _refuse_too_few_joints(bound, task, model)
    return _simplest(bound, task, views) if components == tuple(range(6)) else task


def _frames(bound: Bound, requested: Frames, model: str) -> Frames:
    """The single requested frame, once per component."""
    if len({(replace(frame, component=""), frame.component == "") for frame in requested}) > 1:
        what = "components of one frame are asked for, seen from one place: as in tool.x, tool.y, tool.rz"
        raise bound.machine.error(model, what)
    return requested


def _columns(bound: Bound, by_joint: dict[int, Twist]) -> dict[int, Row]:
    """Twists by the rates of all independent variables, from those by the rates of the joints."""
    twists_of_joints = by_independent(bound, by_joint)
    return {j: twists_of_joints.get(j, AT_REST.entries) for j in bound.machine.independent}


# The simplest Jacobian of all six components


def _simplest(bound: Bound, task: Task, views: FrameSet) -> Task:
    """The task in the axes of the frame, and about the origin, where the largest block is smallest.

    With a spherical wrist it falls into two blocks of three about the centre of the wrist, in the axes of the forearm
    (Khalil and Dombre 2002, 5.3).
    """
    frame = link_of(bound, task.frames[0])
    on_way = [j for j in path(bound.mechanism, frame) if bound.mechanism.link(j).axis is not None] or [frame]
    candidates = [task]
    for axes in on_way:
        views_of_axes = frame_set(bound.mechanism, axes)
        candidates += [_restate(bound, task, views, views_of_axes, axes, point) for point in on_way]
    return min(candidates, key=_size)


def _size(task: Task) -> tuple[int, int]:
    """Cost of solving a task: rows of its largest block if square, else 0, and the number of nonzero entries."""
    entries = sum(not is_zero(x) for row in task.rows for x in row)
    if len(task.columns) != len(task.rows):
        return 0, entries
    try:
        return max(len(block.rows) for block in blocks(task.rows)), entries
    except DependentRows:
        return len(task.rows), entries


def _restate(bound: Bound, task: Task, views: FrameSet, views_of_axes: FrameSet, axes: int, point: int) -> Task:
    """The task in the axes `axes` and about the origin `point`, a point fixed to the frame of the task.

    `views` are all frames seen from the task's observer, `views_of_axes` those seen from the frame `axes`.
    """
    mechanism, frame = bound.mechanism, link_of(bound, task.frames[0])
    origin = views_of_axes.frames[point].origin
    by_joint: dict[int, Twist] = {}
    for j in path(mechanism, frame):
        link, z = mechanism.link(j), views_of_axes.frames[j].z
        if link.axis is Axis.PRISMATIC:
            by_joint[j] = Twist(z, ZERO)  # (3)
        elif link.axis is Axis.REVOLUTE:
            by_joint[j] = Twist(cross(z, origin - views_of_axes.frames[j].origin), z)  # (3)
    columns = _columns(bound, by_joint)
    rows = tuple(tuple(columns[j][k] for j in task.columns) for k in range(6))
    pose, lever = views.frames[axes], views.frames[point].origin - views.frames[frame].origin

    def restate(V: Sequence[Scalar]) -> Sequence[Scalar]:
        linear, angular = Vector(*V[:3]), Vector(*V[3:])
        return Twist(pose.rotation.T * (linear + cross(angular, lever)), pose.rotation.T * angular).entries

    return replace(task, rows=rows, restate=restate)


# Models


def _jacobian_determinant(bound: Bound, requested: Frames) -> Results:
    name = "jacobian_determinant"
    task = task_of(bound, requested, name)
    _refuse_redundant(bound, task, name)
    factors = _factors(bound, task, name)
    product = factors[0]
    for factor in factors[1:]:
        product = product * factor
    return {"detJ": Result(None, (product,), (1,))}


def _inverse_jacobian(bound: Bound, requested: Frames) -> Results:
    name = "inverse_jacobian"
    task = task_of(bound, requested, name)
    _refuse_redundant(bound, task, name)
    _factors(bound, task, name)
    size = len(task.components)
    units = [[int(m == k) for m in range(size)] for k in range(size)]
    columns = [solve_square(task.rows, task.restate(unit)) for unit in units]
    entries = tuple(column[m] for m in range(size) for column in columns)
    return {"Jinv": Result(task.columns, entries, (size,), column_labels=tuple(COMPONENTS[k] for k in task.components))}


def _inverse_velocity_model(bound: Bound, requested: Frames) -> Results:
    name = "inverse_velocity_model"
    task = task_of(bound, requested, name)
    return {"qd": _solution(bound, task, _targets(bound, task, "V"), name)}


def _inverse_acceleration_model(bound: Bound, requested: Frames) -> Results:
    """Joint accelerations from Vd = J qdd + (dJ/dt) qd."""
    name = "inverse_acceleration_model"
    task = task_of(bound, requested, name)
    still, qdd = replace(bound.mechanism, velocity=AT_REST, acceleration=AT_REST), bound.bias_accelerations()
    own = accelerations(still, bound.rates(), qdd)
    frame = replace(task.frames[0], seen_from=task.frames[0].seen_from or 0)
    twist = twists(bound, (frame,), "Vd", own, still, qdd).entries
    target = [x - twist[k] for x, k in zip(_targets(bound, task, "Vd"), task.components, strict=True)]
    return {"qdd": _solution(bound, task, target, name)}


def _targets(bound: Bound, task: Task, letter: str) -> list[Scalar]:
    return [bound.graph.symbol(f"{letter}{task.frames[0].number}_{k + 1}") for k in task.components]


def _solution(bound: Bound, task: Task, components: Sequence[Scalar], model: str) -> Result:
    right = task.restate(components)
    if len(task.columns) > len(task.components):
        weights = [bound.graph.symbol(f"weight{j}") for j in task.columns]
        return Result(task.columns, tuple(least_norm(task.rows, weights, right)))
    _factors(bound, task, model)
    return Result(task.columns, tuple(solve_square(task.rows, right)))


def _arguments_of(letter: str) -> Callable[[Bound, Results], dict[str, tuple[str, ...]]]:
    """Arguments of an inverse kinematic model: the state, the prescribed components, weights if redundant.

    Each component is in the solution, as a Jacobian of full rank leaves none out.
    """

    def arguments(bound: Bound, results: Results) -> dict[str, tuple[str, ...]]:
        names = bound.arguments()
        components = _symbols(results, rf"{letter}\d+_\d")
        weights = _symbols(results, r"weight\d+")
        state = {name: names[name] for name in (("q", "qd") if letter == "Vd" else ("q",))}
        return state | {letter: components} | ({"weights": weights} if weights else {})

    return arguments


def _symbols(results: Results, pattern: str) -> tuple[str, ...]:
    """Symbols of the results whose names match a pattern, sorted by their numbers."""
    entries = [x for result in results.values() for x in result.entries]
    names = {str(node.operands[0]) for node in reachable(entries) if node.operation == SYMBOL}
    matching = [name for name in names if re.fullmatch(pattern, name)]
    return tuple(sorted(matching, key=lambda name: [int(part) for part in re.findall(r"\d+", name)]))


def _rows_of(letter: str, meaning: str) -> Callable[[Bound, Results], tuple[Quantity, ...]]:
    """Return a function that describes the arguments of an inverse kinematic model: components and weights."""

    def rows(bound: Bound, results: Results) -> tuple[Quantity, ...]:
        numbers = [map(int, re.findall(r"\d+", name)) for name in _symbols(results, rf"{letter}\d+_\d")]
        frames = FrameNames(bound.machine)
        names = [f"{frames.name(j)}.{COMPONENTS[k - 1]}" for j, k in numbers]
        joints = [bound.machine.joint(int(x.removeprefix("weight"))).name for x in _symbols(results, r"weight\d+")]
        weights = quantity("weights")
        wanted = _wanted_row(letter, f"{meaning} {', '.join(names)}")
        return wanted, replace(weights, meaning=f"{weights.meaning}: of {', '.join(joints)}")

    return rows


# Refusals


def _factors(bound: Bound, task: Task, model: str) -> list[Scalar]:
    """Factors of the determinant; raises `InputError` where one is zero at every position."""
    try:
        factors = determinant_factors(task.rows)
    except DependentRows:
        factors = [0]
    if any(map(zero_test(), factors)):
        what = f"{_component_list(bound, task)} depend on each other at every position: choose others, or fewer of them"
        raise bound.machine.error(model, what)
    return factors


def _refuse_unchanged(bound: Bound, components: Sequence[int], changed: Sequence[int], model: str) -> None:
    still = [COMPONENTS[k] for k in components if k not in changed]
    if still or not components:
        free = ", ".join(COMPONENTS[k] for k in changed)
        what = f"no joint changes {', '.join(still)}: choose among {free}" if free else "no joint moves the frame"
        raise bound.machine.error(model, what)


def _refuse_too_few_joints(bound: Bound, task: Task, model: str) -> None:
    if len(task.columns) < len(task.components):
        what = (
            f"{len(task.columns)} joints move {_component_list(bound, task)}, {len(task.components)} components: "
            f"choose {len(task.columns)} of them, as in {', '.join(_requests(bound, task)[: len(task.columns)])}"
        )
        raise bound.machine.error(model, what)


def _refuse_redundant(bound: Bound, task: Task, model: str) -> None:
    if len(task.columns) > len(task.components):
        joints = ", ".join(bound.machine.joint(j).name for j in task.columns)
        what = (
            f"{len(task.columns)} joints ({joints}) move {len(task.components)} components, so the Jacobian is not "
            "square: lock joints in a scene, or ask for inverse_velocity_model, which takes weights"
        )
        raise bound.machine.error(model, what)


def _requests(bound: Bound, task: Task) -> list[str]:
    name = FrameNames(bound.machine).name(task.frames[0].number)
    return [f"{name}.{COMPONENTS[k]}" for k in task.components]


def _component_list(bound: Bound, task: Task) -> str:
    return ", ".join(_requests(bound, task))


_EQUATIONS = "(Khalil and Dombre 2002, 6.2-6.7)"
_AXES = "in axes of frame 0, or of the frame it is asked in"
_VELOCITIES, _ACCELERATIONS = "wanted velocities", "wanted accelerations"


def _wanted_row(letter: str, meaning: str) -> Quantity:
    return replace(quantity(letter), meaning=meaning, frame=_AXES, shape="components", roles=ARGUMENT)


def _of_movers(name: str) -> Quantity:
    return replace(
        quantity(name),
        meaning=f"{quantity(name).meaning} that give the frame what is wanted",
        note="of the joints that move these components; not finite where the machine is singular",
        roles=RESULT,
    )


INVERSE_KINEMATIC = (
    Model(
        "jacobian_determinant",
        "determinant of the Jacobian of a frame",
        "[3]",
        ("q",),
        ("detJ",),
        _jacobian_determinant,
        Parts.COMPONENTS,
        on_base=(),
    ),
    Model(
        "inverse_jacobian",
        "inverse of the Jacobian of a frame",
        _EQUATIONS,
        ("q",),
        ("Jinv",),
        _inverse_jacobian,
        Parts.COMPONENTS,
        on_base=(),
    ),
    Model(
        "inverse_velocity_model",
        "inverse kinematic model of first order: joint velocities from those of a frame",
        _EQUATIONS,
        ("q", "V"),
        ("qd",),
        _inverse_velocity_model,
        Parts.COMPONENTS,
        own=(_of_movers("qd"), _wanted_row("V", f"{_VELOCITIES} of components of the frame")),
        own_rows=_rows_of("V", _VELOCITIES),
        own_arguments=_arguments_of("V"),
        on_base=(),
    ),
    Model(
        "inverse_acceleration_model",
        "inverse kinematic model of second order: joint accelerations from those of a frame",
        _EQUATIONS,
        ("q", "qd", "Vd"),
        ("qdd",),
        _inverse_acceleration_model,
        Parts.COMPONENTS,
        own=(_of_movers("qdd"), _wanted_row("Vd", f"{_ACCELERATIONS} of components of the frame")),
        own_rows=_rows_of("Vd", _ACCELERATIONS),
        own_arguments=_arguments_of("Vd"),
        on_base=(),
    ),
)
