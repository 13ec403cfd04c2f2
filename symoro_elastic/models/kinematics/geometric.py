"""Geometric and kinematic models of frames, each seen from the base, from itself, or from any other.

The frame of a cut joint is where its loop is closed: that of the row it meets. Where only origins meet, it is the frame
of the row itself, before the rotations of the ball.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from symoro_elastic.foundation.scalar import Scalar
from symoro_elastic.machine.joints import SELECTED
from symoro_elastic.machine.machine import Joint, Machine
from symoro_elastic.machine.scene import Parts
from symoro_elastic.machine.static_springs import with_free_springs
from symoro_elastic.mechanics.coordinates import projection
from symoro_elastic.mechanics.dynamics import Dynamics, dynamics, force_on_mode
from symoro_elastic.mechanics.kinematics import (
    FrameSet,
    Scalars,
    accelerations,
    frame_set,
    jacobian,
    motion_expressed_in,
    velocities,
)
from symoro_elastic.mechanics.mechanism import Mechanism
from symoro_elastic.mechanics.spatial import AT_REST, Axis, Twist
from symoro_elastic.models.bound.bind import Bound
from symoro_elastic.models.bound.model import ORIENTATION, CheckedBy, Frame, Frames, Joints, Model, Result, Results
from symoro_elastic.models.bound.naming import name_dynamics, name_frames, name_jacobian, name_twists
from symoro_elastic.models.bound.rules import given_rules
from symoro_elastic.models.bound.state import position_blocks
from symoro_elastic.models.tree.tree import Coupling, Tree
from symoro_elastic.quantities import quantity
from symoro_elastic.quantities.signatures import OR_ASKED
from symoro_elastic.symbolic.program import Section

EQUATIONS = {"V": "[3]", "Vd": "[6], [7]"}
DEFLECTIONS = "static_deflections"
PLACED = "geometric_model_with_deflections"


def geometric_model(bound: Bound, frames: Frames) -> Results:
    """Placements of frames, and of points of them, seen from frame 0 or from others."""
    views = _views(bound, frames)
    entries: list[Scalar] = []
    for frame in frames:
        for row, x in zip(*views[observer_of(bound, frame)].frames[link_of(bound, frame)], strict=True):
            entries += [*row, x]
        entries += [0, 0, 0, 1]
    return {"T": _of_frames(frames, entries, (4, 4))}


def _velocities(bound: Bound, frames: Frames) -> Results:
    own = velocities(bound.mechanism, bound.rates())
    return {"V": twists(bound, frames, "V", own, bound.mechanism, [0] * len(own))}


def _accelerations(bound: Bound, frames: Frames) -> Results:
    mechanism, qdd = replace(bound.mechanism, acceleration=bound.base_acceleration), bound.given_accelerations()
    return {"Vd": twists(bound, frames, "Vd", accelerations(mechanism, bound.rates(), qdd), mechanism, qdd)}


def _jacobian_dot_qd(bound: Bound, frames: Frames) -> Results:
    """V' on a base at rest, at zero joint accelerations; components in frame 0 where no other is named."""
    _refuse_without_joints(bound, "jacobian_dot_qd")
    still, qdd = replace(bound.mechanism, velocity=AT_REST, acceleration=AT_REST), bound.bias_accelerations()
    in_base = tuple(replace(frame, seen_from=frame.seen_from or 0) for frame in frames)
    twist = twists(bound, in_base, "Vd", accelerations(still, bound.rates(), qdd), still, qdd)
    return {"Vd": replace(twist, frames=frames)}


def _jacobian(bound: Bound, frames: Frames) -> Results:
    """The Jacobians of frames, with components in frame 0 where no other is named, as for `jacobian_dot_qd`."""
    _refuse_without_joints(bound, "jacobian")
    views = _views(bound, frames)
    entries: list[Scalar] = []
    for frame in frames:
        by_joint = jacobian(bound.mechanism, views[observer_of(bound, frame)], link_of(bound, frame))
        columns = by_independent(bound, by_joint)
        if not frame.seen_from:
            name_jacobian(bound, columns, link_of(bound, frame))
        entries += [columns[j][k] if j in columns else 0 for k in range(6) for j in bound.machine.independent]
    return {"J": _of_frames(frames, entries, (6, len(bound.machine.independent)))}


def by_independent(bound: Bound, columns: Mapping[int, Twist]) -> dict[int, tuple[Scalar, ...]]:
    """Columns of J S: twists of a frame per unit rate of the independent variables (L2)."""
    rows = [projection(bound.coordinates.S, {j: x.entries[k] for j, x in columns.items()}) for k in range(6)]
    from_tip = sorted({j for row in rows for j in row}, reverse=True)
    return {j: tuple(row.get(j, 0) for row in rows) for j in from_tip}


def _views(bound: Bound, frames: Frames) -> dict[int, FrameSet]:
    """Sets of all frames as seen from frame 0, which is named, and from every other requested observer."""
    seen_from = dict.fromkeys((0, *(observer_of(bound, frame) for frame in frames)))
    views = {k: frame_set(bound.mechanism, k) for k in seen_from}
    name_frames(bound, views[0].frames)
    return views


def twists(bound: Bound, frames: Frames, quantity: str, own: list[Twist], mechanism: Mechanism, qdd: Scalars) -> Result:
    """V or Vd of frames: `own` in the frame itself, or with components in the frame it is seen from."""
    views = _views(bound, frames)
    name_twists(bound, own, views[0].frames, quantity, EQUATIONS[quantity])
    motions = {k: motion_expressed_in(mechanism, seen_by, bound.rates(), qdd) for k, seen_by in views.items()}
    _name_in_frame_0(bound, *motions[0], EQUATIONS[quantity])
    components = {k: motion[quantity == "Vd"] for k, motion in motions.items()}
    twists_of_frames = [
        (own if f.seen_from in (None, f.number) else components[observer_of(bound, f)])[link_of(bound, f)]
        for f in frames
    ]
    return _of_frames(frames, [x for twist in twists_of_frames for x in twist.entries], (6,))


def _name_in_frame_0(bound: Bound, V: list[Twist], Vd: list[Twist], equations: str) -> None:
    """Name angular velocities and accelerations in frame 0."""
    for j, _ in bound.mechanism.from_base():
        here = Section("Forward recursion, in frame 0", j, equations)
        for axis, x in zip("xyz", V[j].angular, strict=True):
            bound.names.give(x, f"W{j}_{axis}", here)
        for k, x in enumerate(Vd[j].entries, start=1):
            bound.names.give(x, f"Ac{j}_{k}", here)


def _of_frames(frames: Frames, entries: list[Scalar], columns: tuple[int, ...]) -> Result:
    return Result(tuple(f.number for f in frames), tuple(entries), columns, frames)


def observer_of(bound: Bound, frame: Frame) -> int:
    """The mechanism's number of the frame from which a frame is seen; 0 where none is named."""
    return bound.link_of(frame.seen_from or 0)


def link_of(bound: Bound, frame: Frame) -> int:
    """The number of a frame in the mechanism."""
    return bound.link_of(frame.number, frame.at)


def _refuse_without_joints(bound: Bound, model: str) -> None:
    if not bound.machine.independent:
        what = "no joint moves, so no frame has a Jacobian: ask for geometric_model, or free a joint"
        raise bound.machine.error(model, what)


GEOMETRIC = (
    Model(
        "geometric_model",
        "placement of frames",
        "[1], [2]",
        ("q",),
        ("T",),
        geometric_model,
        Parts.POINTS,
        on_base=(),
        checked_by=CheckedBy.FRAMES,
    ),
    Model("velocities", "velocities of frames", "[3]", ("q", "qd"), ("V",), _velocities, Parts.POINTS, on_base=("V0",)),
    Model(
        "accelerations",
        "accelerations of frames",
        "[6], [7]",
        ("q", "qd", "qdd"),
        ("Vd",),
        _accelerations,
        Parts.POINTS,
        on_base=("V0", "V0d"),
    ),
    Model("jacobian", "Jacobians of frames", "[3]", ("q",), ("J",), _jacobian, Parts.POINTS, on_base=()),
    Model(
        "jacobian_dot_qd",
        "accelerations of frames at zero joint acceleration on a base at rest",
        "[6], [7]",
        ("q", "qd"),
        ("Vd",),
        _jacobian_dot_qd,
        Parts.POINTS,
        own=(
            replace(
                quantity("Vd"),
                meaning="(dJ/dt) qd of each frame",
                frame=f"of the motion relative to frame 0, in axes of frame 0 {OR_ASKED}",
                note="accelerations = jacobian qdd + jacobian_dot_qd on a base at rest, all in the same axes",
                frame0=True,
            ),
        ),
        on_base=(),
    ),
)


def _static_deflections(bound: Bound, _: Joints) -> Results:
    machine = bound.machine
    _refuse_without_static_springs(machine, DEFLECTIONS)
    rules = given_rules(bound)
    recursion = dynamics(bound.mechanism, bound.rates(), rules)
    name_dynamics(bound, recursion, "[15]", "[61]")
    of_followers = _of_followers(bound, recursion)
    entries: list[Scalar] = []
    for j, joint in machine.static_springs.items():
        neutral, stiffness = bound.cell(joint.spring.neutral), bound.cell(joint.spring.stiffness)
        Gamma = force_on_mode(recursion, j, rules) if j in machine.modal_rows else _reaction(recursion, j, joint)
        entries.append(neutral - (Gamma + of_followers.get(j, 0)) / stiffness)  # (9)
    return {"q_static": Result(tuple(machine.static_springs), tuple(entries))}


def _of_followers(bound: Bound, recursion: Dynamics) -> dict[int, Scalar]:
    """Forces, by static spring, that joints coupled to it add to its own, all springs at their held positions."""
    machine = bound.machine
    springs, rows = machine.static_springs, machine.static
    followers = [i for i in rows if i not in springs]
    if not followers:
        return {}
    free = Tree(with_free_springs(machine), sharing=bound)
    positions = {j: Coupling(bound, getattr(machine.joint(j), SELECTED[row.sigma])).value for j, row in springs.items()}
    free.variables |= {j: x - Coupling(free, springs[j].selected).value for j, x in positions.items()}
    forces: dict[int, Scalar] = {}
    for i in followers:
        Gamma = _reaction(recursion, i, rows[i]) + (bound.friction(i) if i in machine.articulated else 0)
        for j, x in free.couplings[i].partials.items():
            forces[j] = forces.get(j, 0) + x * Gamma  # (L3)
    return forces


def _reaction(recursion: Dynamics, j: int, joint: Joint) -> Scalar:
    """Force that the motion requires on a locked joint j, including its rotor where it follows other joints."""
    return recursion.Gamma[j] if j in recursion.Gamma else Axis(joint.sigma).T * recursion.f[j]  # (17), (61)


def _with_deflections(machine: Machine) -> Machine:
    _refuse_without_static_springs(machine, PLACED)
    return with_free_springs(machine)


def _arguments(bound: Bound, _: Results) -> dict[str, tuple[str, ...]]:
    """q of the joints that stay in the motion, then the variables of the static ones."""
    names = bound.arguments()
    static, position = names["q_static"], {name: names[name] for name in position_blocks(bound.machine)}
    return position | {"q": tuple(name for name in names["q"] if name not in static), "q_static": static}


def _refuse_without_static_springs(machine: Machine, model: str) -> None:
    if not machine.static:
        what = 'no spring is static: name those to be left out of the motion in a scene, static = ["name"]'
        raise machine.error(model, what)


STATIC_SPRINGS = (
    Model(
        DEFLECTIONS,
        "variables of static joints from the reactions there",
        "[9], [15], [35], [58]",
        ("q", "qd", "qdd"),
        ("q_static",),
        _static_deflections,
        Parts.WHOLE,
        on_base=(ORIENTATION, "V0", "V0d"),
    ),
    Model(
        PLACED,
        "placement of frames with static springs deflected",
        "[1], [2]",
        ("q", "q_static"),
        ("T",),
        geometric_model,
        Parts.POINTS,
        own_arguments=_arguments,
        on_base=(),
        binds=_with_deflections,
    ),
)
