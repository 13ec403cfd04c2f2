"""Geometric and kinematic models of frames, each seen from the base, from itself, or from any other."""

from __future__ import annotations

from dataclasses import replace

from symoro_elastic.equations.kinematics import accelerations, frames, jacobian, placement_between, velocities
from symoro_elastic.equations.spatial import ZERO, Matrix, Pair, Vector, times, transpose
from symoro_elastic.models.bind import Bound
from symoro_elastic.models.model import FRAMES, Frame, Frames, Model, Result, Results
from symoro_elastic.models.naming import name_frames, name_jacobian, name_screws
from symoro_elastic.symbolic.expression import Scalar

Placed = list[tuple[Matrix, Vector]]


def _geometric_model(bound: Bound, asked: Frames) -> Results:
    placed = frames(bound.mechanism)
    name_frames(bound, placed)
    entries: list[Scalar] = []
    for frame in asked:
        whole = placed[frame.number]
        if frame.seen_from:
            whole = placement_between(bound.mechanism, frame.seen_from, frame.number)
        for row, x in zip(*whole, strict=True):
            entries += [*row, x]
        entries += [0, 0, 0, 1]
    return {"T": _of_frames(asked, entries, (4, 4))}


def _velocities(bound: Bound, asked: Frames) -> Results:
    found = velocities(bound.mechanism, bound.rates())
    placed = frames(bound.mechanism)
    name_screws(bound, found, placed, "V", "[3]")
    return {"V": _of_frames(asked, _in_their_frames(found, placed, asked), (6,))}


def _accelerations(bound: Bound, asked: Frames) -> Results:
    mechanism = replace(bound.mechanism, acceleration=bound.base_acceleration)
    found = accelerations(mechanism, bound.rates(), bound.given_accelerations())
    placed = frames(bound.mechanism)
    name_screws(bound, found, placed, "Vd", "[6]")
    return {"Vd": _of_frames(asked, _in_their_frames(found, placed, asked), (6,))}


def _jacobian_dot_qd(bound: Bound, asked: Frames) -> Results:
    still = replace(bound.mechanism, velocity=(ZERO, ZERO), acceleration=(ZERO, ZERO))
    found = accelerations(still, bound.rates(), [0] * len(bound.rates()))
    placed = frames(bound.mechanism)
    name_screws(bound, found, placed, "Vd", "[6]")
    in_base = tuple(Frame(f.number, f.seen_from or 0) for f in asked)
    return {"Vd": _of_frames(asked, _in_their_frames(found, placed, in_base), (6,))}


def _jacobian(bound: Bound, asked: Frames) -> Results:
    placed = frames(bound.mechanism)
    name_frames(bound, placed)
    entries: list[Scalar] = []
    for frame in asked:
        columns = jacobian(bound.mechanism, placed, frame.number)
        rotation = transpose(placed[frame.seen_from or 0][0])
        seen = {j: (*times(rotation, v), *times(rotation, w)) for j, (v, w) in columns.items()}
        name_jacobian(bound, seen, frame.number)
        entries += [seen[j][k] if j in seen else 0 for k in range(6) for j in bound.machine.moving]
    return {"J": _of_frames(asked, entries, (6, len(bound.machine.moving)))}


def _of_frames(asked: Frames, entries: list[Scalar], columns: tuple[int, ...]) -> Result:
    return Result(tuple(f.number for f in asked), tuple(entries), columns, tuple(f.seen_from for f in asked))


def _in_their_frames(screws: list[Pair], placed: Placed, asked: Frames) -> list[Scalar]:
    """Each screw in its own frame, or in the one it is to be seen from."""
    entries: list[Scalar] = []
    for frame in asked:
        for vector in screws[frame.number]:
            entries += _turned(vector, placed, frame)
    return entries


def _turned(vector: Vector, placed: Placed, frame: Frame) -> Vector:
    if frame.seen_from is None or frame.seen_from == frame.number:
        return vector
    in_base = times(placed[frame.number][0], vector)
    return times(transpose(placed[frame.seen_from][0]), in_base) if frame.seen_from else in_base


GEOMETRIC = (
    Model("geometric_model", "placement of frames", "[1], [2]", ("q",), ("T",), _geometric_model, FRAMES),
    Model("velocities", "velocities of frames", "[3]", ("q", "qd"), ("V",), _velocities, FRAMES),
    Model("accelerations", "accelerations of frames", "[6], [7]", ("q", "qd", "qdd"), ("Vd",), _accelerations, FRAMES),
    Model("jacobian", "basic Jacobians of frames", "[3]", ("q",), ("J",), _jacobian, FRAMES),
    Model(
        "jacobian_dot_qd",
        "accelerations of frames at zero joint acceleration",
        "[6], [7]",
        ("q", "qd"),
        ("Vd",),
        _jacobian_dot_qd,
        FRAMES,
    ),
)
