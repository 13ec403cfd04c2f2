"""Frames on the axes of joints, chosen for as many zero parameters of the table as possible.

z is along the axis, and x along the common normal to the axis of the joint that follows [Khalil and Kleinfinger]. All
are placements in the frame of the joint, or in that of the joint whose parameters are asked for.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from symoro_elastic.formats.polynomials import direction_and_length
from symoro_elastic.formats.robots.robot import Placement
from symoro_elastic.foundation.array_types import Array

NEARLY_PARALLEL = 1e-2
"""Sine of the angle below which the common normal of two axes is too far away to place a frame there."""
SAME_LINE = 1e-9
"""Distance of parallel axes, m, below which their normal has no direction."""
UNDECIDED = 1e-6
"""Cosine of the angle of two directions below which neither sense is nearer."""


@dataclass(frozen=True, eq=False)
class Axis:
    """A line: a point of it (3,), m, and its direction (3,), of length 1."""

    point: Array
    direction: Array

    @classmethod
    def z_of(cls, frame: Placement) -> Axis:
        """Return the z axis of a frame."""
        return cls(frame.translation, frame.rotation[:, 2])

    def is_nearly_parallel(self, other: Axis) -> bool:
        """Whether the common normal of two axes is far away, or undetermined."""
        return bool(np.linalg.norm(np.cross(self.direction, other.direction)) < NEARLY_PARALLEL)

    def foot(self, other: Axis) -> Array:
        """The point of this axis nearest to another axis, or to its point if they are nearly parallel."""
        between = other.point - self.point
        if self.is_nearly_parallel(other):
            return self.point + self.direction * (between @ self.direction)
        normal = np.cross(self.direction, other.direction)
        along = np.cross(between, other.direction) @ normal / (normal @ normal)
        return self.point + self.direction * along

    def normal(self, other: Axis) -> Array | None:
        """Direction of the common normal to another axis; None if they nearly coincide, or if it depends on names."""
        if self.is_nearly_parallel(other):
            between = other.point - self.point
            across = between - self.direction * (between @ self.direction)
            along = direction_and_length(across)
            return _unit(along[0]) if along and np.linalg.norm(along[0]) > SAME_LINE else None
        return _unit(np.cross(self.direction, other.direction))


def frame_on(axis: Axis, before: Placement, after: Axis | None, keep_x: bool = False) -> Placement:
    """Modified DH frame of a joint with this axis, between the antecedent's frame `before` and the axis `after`.

    Its x goes to the axis that follows, its origin is the foot of their common normal. At the end of a branch, and
    where both axes are one line, x and origin make theta and r zero. Of the two senses of x the one nearer to that
    of the antecedent is taken, but for parallel axes, where it goes from the one to the other. With `keep_x` x makes
    theta zero also where the axis that follows needs it a quarter turn away, which gamma of that joint is then.
    """
    previous = Axis.z_of(before)
    x = axis.normal(after) if after else None
    if after is None or x is None:
        origin, x = axis.foot(previous), _nearer(_x_without_theta(axis, before), before)
    elif axis.is_nearly_parallel(after):
        origin = axis.foot(previous)
    else:
        origin, x = axis.foot(after), _nearer(x, before)
    without_theta = _x_without_theta(axis, before)
    if keep_x and abs(x @ without_theta) < UNDECIDED:
        x = _nearer(without_theta, before)
    return Placement(_axes(axis.direction, x), origin)


def _x_without_theta(axis: Axis, before: Placement) -> Array:
    """Direction of x along the normal from the antecedent's axis, or the antecedent's x if both axes coincide."""
    x = Axis.z_of(before).normal(axis)
    return before.rotation[:, 0] if x is None else x


def _nearer(x: Array, before: Placement) -> Array:
    """Return x or -x, whichever is nearer to x of the antecedent; if orthogonal, nearer to its y, then its z."""
    sense = next((along for along in x @ before.rotation if abs(along) > UNDECIDED), 1.0)
    return -x if sense < 0 else x


def _axes(z: Array, x: Array) -> Array:
    """Rotation with this z axis and the x axis nearest to the requested one."""
    y = _unit(np.cross(z, x))
    return np.column_stack([np.cross(y, z), y, z])


def _unit(vector: Array) -> Array:
    return np.asarray(vector / np.linalg.norm(vector))
