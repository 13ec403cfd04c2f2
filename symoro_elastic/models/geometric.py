"""Geometric and kinematic models."""

from __future__ import annotations

from symoro_elastic.equations.kinematics import frames
from symoro_elastic.models.bind import Bound
from symoro_elastic.models.model import FRAMES, Joints, Model, Result, Results
from symoro_elastic.models.naming import name_frames
from symoro_elastic.symbolic.expression import Scalar


def _geometric_model(bound: Bound, asked: Joints) -> Results:
    placed = frames(bound.mechanism)
    name_frames(bound, placed)
    entries: list[Scalar] = []
    for j in asked:
        rotation, position = placed[j]
        for row, x in zip(rotation, position, strict=True):
            entries += [*row, x]
        entries += [0, 0, 0, 1]
    return {"T": Result(asked, tuple(entries), (4, 4))}


GEOMETRIC = (
    Model(
        "geometric_model", "placement of the frames in frame 0", "[1], [2]", ("q",), ("T",), _geometric_model, FRAMES
    ),
)
