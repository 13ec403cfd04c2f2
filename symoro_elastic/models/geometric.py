"""Geometric and kinematic models of frames, each seen from the base, from itself, or from any other."""

from __future__ import annotations

from dataclasses import replace

from symoro_elastic.equations.kinematics import (
    FrameSet,
    Scalars,
    accelerations,
    frame_set,
    jacobian,
    motion_expressed_in,
    velocities,
)
from symoro_elastic.equations.mechanism import Mechanism
from symoro_elastic.equations.spatial import AT_REST, Twist
from symoro_elastic.machine.scene import Parts
from symoro_elastic.models.bind import Bound
from symoro_elastic.models.model import CheckedBy, Frame, Frames, Model, Result, Results
from symoro_elastic.models.naming import name_frames, name_jacobian, name_twists
from symoro_elastic.quantities import quantity
from symoro_elastic.scalar import Scalar
from symoro_elastic.symbolic.program import Section

EQUATIONS = {"V": "[3]", "Vd": "[6], [7]"}


def _geometric_model(bound: Bound, asked: Frames) -> Results:
    views = _views(bound, asked)
    entries: list[Scalar] = []
    for frame in asked:
        for row, x in zip(*views[frame.seen_from or 0].frames[_link(bound, frame)], strict=True):
            entries += [*row, x]
        entries += [0, 0, 0, 1]
    return {"T": _of_frames(asked, entries, (4, 4))}


def _velocities(bound: Bound, asked: Frames) -> Results:
    own = velocities(bound.mechanism, bound.rates())
    return {"V": _twists(bound, asked, "V", own, bound.mechanism, [0] * len(own))}


def _accelerations(bound: Bound, asked: Frames) -> Results:
    mechanism, qdd = replace(bound.mechanism, acceleration=bound.base_acceleration), bound.given_accelerations()
    return {"Vd": _twists(bound, asked, "Vd", accelerations(mechanism, bound.rates(), qdd), mechanism, qdd)}


def _jacobian_dot_qd(bound: Bound, asked: Frames) -> Results:
    """V' on a base at rest, at zero joint accelerations; components in frame 0 where no other is named."""
    _refuse_without_joints(bound, "jacobian_dot_qd")
    still, qdd = replace(bound.mechanism, velocity=AT_REST, acceleration=AT_REST), [0] * len(bound.rates())
    in_base = tuple(replace(frame, seen_from=frame.seen_from or 0) for frame in asked)
    found = _twists(bound, in_base, "Vd", accelerations(still, bound.rates(), qdd), still, qdd)
    return {"Vd": replace(found, frames=asked)}


def _jacobian(bound: Bound, asked: Frames) -> Results:
    """Components in frame 0 where no other is named, as those of `jacobian_dot_qd`."""
    _refuse_without_joints(bound, "jacobian")
    views = _views(bound, asked)
    entries: list[Scalar] = []
    for frame in asked:
        columns = jacobian(bound.mechanism, views[frame.seen_from or 0], _link(bound, frame))
        rows = {j: column.entries for j, column in columns.items()}
        if not frame.seen_from:
            name_jacobian(bound, rows, _link(bound, frame))
        entries += [rows[j][k] if j in rows else 0 for k in range(6) for j in bound.machine.moving]
    return {"J": _of_frames(asked, entries, (6, len(bound.machine.moving)))}


def _views(bound: Bound, asked: Frames) -> dict[int, FrameSet]:
    """All frames as seen from frame 0, named, and from every other that is asked for."""
    seen_from = dict.fromkeys((0, *(frame.seen_from or 0 for frame in asked)))
    views = {k: frame_set(bound.mechanism, k) for k in seen_from}
    name_frames(bound, views[0].frames)
    return views


def _twists(bound: Bound, asked: Frames, quantity: str, own: list[Twist], mechanism: Mechanism, qdd: Scalars) -> Result:
    """V or Vd of each frame: `own` in the frame itself, or with components in the frame it is seen from."""
    views = _views(bound, asked)
    name_twists(bound, own, views[0].frames, quantity, EQUATIONS[quantity])
    motions = {k: motion_expressed_in(mechanism, seen_by, bound.rates(), qdd) for k, seen_by in views.items()}
    _name_seen(bound, *motions[0], EQUATIONS[quantity])
    seen = {k: motion[quantity == "Vd"] for k, motion in motions.items()}
    twists = [(own if f.seen_from in (None, f.number) else seen[f.seen_from or 0])[_link(bound, f)] for f in asked]
    return _of_frames(asked, [x for twist in twists for x in twist.entries], (6,))


def _name_seen(bound: Bound, V: list[Twist], Vd: list[Twist], equations: str) -> None:
    """Name angular velocities and accelerations in frame 0."""
    for j, _ in bound.mechanism.from_base():
        here = Section("Forward recursion, in frame 0", j, equations)
        for axis, x in zip("xyz", V[j].angular, strict=True):
            bound.names.give(x, f"W{j}_{axis}", here)
        for k, x in enumerate(Vd[j].entries, start=1):
            bound.names.give(x, f"Ac{j}_{k}", here)


def _of_frames(asked: Frames, entries: list[Scalar], columns: tuple[int, ...]) -> Result:
    return Result(tuple(f.number for f in asked), tuple(entries), columns, asked)


def _link(bound: Bound, frame: Frame) -> int:
    """The number of a frame in the mechanism, where points come after the table."""
    if frame.at is None:
        return frame.number
    return len(bound.machine.joints) + 1 + bound.points.index((frame.number, frame.at))


def _refuse_without_joints(bound: Bound, model: str) -> None:
    if not bound.machine.moving:
        what = "no joint moves, so no frame has a Jacobian: ask for geometric_model, or free a joint"
        raise bound.machine.error(model, what)


FAMILY = "geometry and kinematics"
GEOMETRIC = (
    Model(
        "geometric_model",
        "placement of frames",
        "[1], [2]",
        ("q",),
        ("T",),
        _geometric_model,
        FAMILY,
        Parts.POINTS,
        on_base=(),
        checked_by=CheckedBy.FRAMES,
    ),
    Model(
        "velocities",
        "velocities of frames",
        "[3]",
        ("q", "qd"),
        ("V",),
        _velocities,
        FAMILY,
        Parts.POINTS,
        on_base=("V0",),
    ),
    Model(
        "accelerations",
        "accelerations of frames",
        "[6], [7]",
        ("q", "qd", "qdd"),
        ("Vd",),
        _accelerations,
        FAMILY,
        Parts.POINTS,
        on_base=("V0", "V0d"),
    ),
    Model(
        "jacobian",
        "Jacobians of frames",
        "[3]",
        ("q",),
        ("J",),
        _jacobian,
        FAMILY,
        Parts.POINTS,
        on_base=(),
    ),
    Model(
        "jacobian_dot_qd",
        "accelerations of frames at zero joint acceleration on a base at rest",
        "[6], [7]",
        ("q", "qd"),
        ("Vd",),
        _jacobian_dot_qd,
        FAMILY,
        Parts.POINTS,
        own=(
            replace(
                quantity("Vd"),
                meaning="(dJ/dt) qd of each frame",
                frame="of the motion relative to frame 0, in its axes or in those of the frame it is asked in",
                frame0=True,
            ),
        ),
        on_base=(),
    ),
)
