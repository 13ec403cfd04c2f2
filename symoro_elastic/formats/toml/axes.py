"""Rows of a table by axis and point, at position zero, as rows of geometric parameters.

In the file the frame of a joint that moves is at its point, with the axes of frame 0 at position zero; a fixed frame
and a cut joint have the axes that are given. The table has frames on the axes of the joints, as that of a robot in
URDF; bodies, wrenches and frames without a row are then in these.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from symoro_elastic.formats.central import moved_body
from symoro_elastic.formats.polynomials import Polynomial, vector_of
from symoro_elastic.formats.robots.axis_frames import Axis, frame_on
from symoro_elastic.formats.robots.joint_tree import (
    ROUNDING,
    Tolerance,
    about_x,
    about_z,
    angle_cell,
    rotation,
    rows_of,
    rpy_of,
)
from symoro_elastic.formats.robots.modified_dh import LEAST_SIZE, SEAT
from symoro_elastic.formats.robots.robot import Placement
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.formula import Formula, FormulaError
from symoro_elastic.machine.joints import Body, Joint, Kind, NamedFrame, Wrench
from symoro_elastic.machine.names import quote
from symoro_elastic.machine.rounded_angles import ANGLES

Fail = Callable[[int, str, str], InputError]
"""The error to raise about a joint, by its number, and one of its keys."""
BASE_AXES = "base"
"""Of a body: parallel to frame 0 at position zero, at the point of the joint."""


@dataclass(frozen=True)
class Place:
    """Position of a joint by axis (None: parallel axes) and point, in the frame of row `within`, or of frame 0."""

    axis: tuple[float, float, float] | None
    at: tuple[Formula, ...]
    within: int = 0


@dataclass(frozen=True, eq=False)
class TableByAxes:
    """Conversion of joints that are given by axis and point (`places`) to rows of geometric parameters.

    `body_axes` names the axes of bodies by row where the file does.
    """

    joints: Sequence[Joint]
    places: Mapping[int, Place]
    body_axes: Mapping[int, str]
    fail: Fail
    _given: dict[int, Placement] = field(default_factory=dict)
    _frames: dict[int, Placement] = field(default_factory=dict)

    @cached_property
    def rows(self) -> tuple[Joint, ...]:
        """The rows, with a fixed row before each joint that needs two; raises `InputError`."""
        rows: list[Joint] = []
        numbers = [0]
        for j, joint in enumerate(self.joints, start=1):
            if not 0 <= joint.antecedent < j:
                raise self.fail(j, "antecedent", f"row {joint.antecedent} is not above: write a row above, or 0")
            try:
                *seats, last = self._rows(j)
                body, wrench = self._body(j), moved_wrench(joint.wrench, self.inner(j))
            except FormulaError as error:
                raise self.fail(j, "at", str(error)) from None
            antecedent = numbers[joint.antecedent]
            for seat in seats:
                rows.append(replace(seat, antecedent=antecedent))
                antecedent = len(rows)
            rows.append(replace(last, antecedent=antecedent, body=body, wrench=wrench))
            numbers.append(len(rows))
        return tuple(rows)

    def with_frame(self, frame: NamedFrame, source: str) -> NamedFrame:
        """Return a named frame, given in the file's frame of a row, in the frame of the table; raises `InputError`."""
        inner = self.inner(next((j for j, joint in enumerate(self.joints, start=1) if joint.name == frame.on), 0))
        if _is_none(inner):
            return frame
        try:
            x, y, z = (cell.formula for cell in inner.rotation @ vector_of(frame.at) + inner.translation)
            turned = _exact(inner.rotation @ rotation(*(cell.value() for cell in frame.rpy)))
        except (FormulaError, KeyError):
            what = f"joint {quote(frame.on)} is given by its axis: angles must be numbers here"
            raise InputError(source, f"frame {quote(frame.name)}, rpy", what) from None
        roll, pitch, yaw = (angle_cell(angle, self.tolerance) for angle in rpy_of(turned))
        return replace(frame, at=(x, y, z), rpy=(roll, pitch, yaw))

    def inner(self, j: int) -> Placement:
        """Placement of a row's frame in the file in its frame of the table."""
        return self.frame(j).inverse * self.given(j) if self._is_free(j) else Placement()

    @cached_property
    def at_zero(self) -> dict[str, float]:
        """Position zero: the variables of all joints with the value 0."""
        return {joint.variable: 0.0 for joint in self.joints if joint.variable}

    @cached_property
    def tolerance(self) -> Tolerance:
        """Tolerance of lengths that count as zero within rounding."""
        points = [Polynomial.of(cell).constant or 0.0 for place in self.places.values() for cell in place.at]
        return Tolerance.rounding(max([LEAST_SIZE, *map(abs, points)]))

    def given(self, j: int) -> Placement:
        """Placement of a row's frame in the file, in frame 0 at position zero."""
        if j not in self._given:
            self._given[j] = self._of_file(j) if j else Placement()
        return self._given[j]

    def _of_file(self, j: int) -> Placement:
        joint, place = self.joints[j - 1], self.places.get(j)
        if place is None:
            return self.given(joint.antecedent) * self._displacement(j)
        within = self.given(place.within)
        point = within.rotation @ vector_of(place.at) + within.translation
        if self._is_free(j):
            return Placement(translation=point)
        turn = np.eye(3) if place.axis is None else upright(np.array(place.axis))
        return Placement(_exact(within.rotation @ turn), point)

    def _displacement(self, j: int) -> Placement:
        """Displacement of a row of geometric parameters at position zero."""
        joint = self.joints[j - 1]
        angles = [self._angle(getattr(joint, key)) for key in ANGLES]
        if None in angles:
            key = ANGLES[angles.index(None)]
            what = f"{quote(getattr(joint, key))} must be a number where frames beyond it are given by axis"
            raise self.fail(j, key, what)
        gamma, alpha, theta = (angle or 0.0 for angle in angles)
        b, d, r = (Polynomial.of(cell, self.at_zero) for cell in (joint.b, joint.d, joint.r))
        steps = (about_z(gamma, b), about_x(alpha, d), about_z(theta, r))
        first, second, third = (replace(step, rotation=_exact(step.rotation)) for step in steps)
        return first * second * third

    def _angle(self, cell: Formula) -> float | None:
        """Value of an angle at position zero; None if it depends on other names."""
        try:
            return Polynomial.of(cell, {**self.at_zero, "pi": math.pi}).constant
        except FormulaError:
            return None

    def _is_free(self, j: int) -> bool:
        """Return whether a row's frame may be chosen: the joint moves and is given by its axis."""
        return j in self.places and _moves(self.joints[j - 1])

    def frame(self, j: int) -> Placement:
        """Placement of a row's frame in the table, in frame 0 at position zero."""
        if j not in self._frames:
            self._frames[j] = self._of_table(j) if self._is_free(j) else self.given(j)
        return self._frames[j]

    def _of_table(self, j: int) -> Placement:
        numbered = enumerate(self.joints, start=1)
        after = next((k for k, joint in numbered if joint.antecedent == j and _moves(joint)), None)
        before = self.frame(self.joints[j - 1].antecedent)
        frame = frame_on(self._axis(j), before, self._axis(after) if after else None, keep_x=True)
        return replace(frame, rotation=_exact(frame.rotation))

    def _axis(self, j: int) -> Axis:
        place, frame = self.places.get(j), self.given(j)
        if place is None or not self._is_free(j):
            return Axis.z_of(frame)
        return Axis(frame.translation, self.given(place.within).rotation @ np.array(place.axis))

    def _rows(self, j: int) -> Iterator[Joint]:
        """Rows of the table for a joint of the file, fixed rows first, without antecedents."""
        joint = self.joints[j - 1]
        if j not in self.places and not self._is_free(joint.antecedent):
            yield joint
            return
        *seats, last = rows_of(self.frame(joint.antecedent).inverse * self.frame(j), self.tolerance)
        for seat in seats:
            yield seat.put_into(Joint(joint.name + SEAT, 0, Kind.FIXED, 2), self.tolerance)
        row = last.put_into(joint, self.tolerance)
        if not joint.selected.names.isdisjoint(self.at_zero):
            shift = row.selected
            if joint.sigma != 1:
                shift = angle_cell(last.theta - (self._angle(joint.theta) or 0.0), self.tolerance)
            elif j not in self.places:
                shift = (Polynomial() + last.r - Polynomial.of(joint.r, self.at_zero)).formula
            text = joint.selected.text if shift.is_zero else f"{joint.selected} + ({shift})"
            row = row.with_selected(Formula.parse(text))
        yield row

    def _body(self, j: int) -> Body:
        body, place = self.joints[j - 1].body, self.places.get(j)
        if self.body_axes.get(j, BASE_AXES if place and place.axis else "") != BASE_AXES or body == Body():
            return body
        at = self.frame(j).inverse * Placement(translation=self.given(j).translation)
        return body if _is_none(at) else moved_body(body, at)


def _moves(joint: Joint) -> bool:
    return joint.sigma != 2 and joint.kind is not Kind.CUT


def upright(z: Array) -> Array:
    """Rotation (3, 3) with this z, and x near the coordinate axis that follows the one nearest to z."""
    x = np.eye(3)[(int(np.argmax(np.abs(z))) + 1) % 3]
    x = x - (x @ z) * z
    x = x / np.linalg.norm(x)
    return np.column_stack([x, np.cross(z, x), z])


def _exact(rotation: Array) -> Array:
    """A rotation with entries near 0 and 1 rounded to these."""
    rounded = np.round(rotation)
    return np.where(np.abs(rotation - rounded) <= ROUNDING, rounded + 0.0, rotation)


def _is_none(place: Placement) -> bool:
    """Return whether a placement is the identity."""
    return not any(x.terms for x in vector_of(place.translation)) and np.array_equal(place.rotation, np.eye(3))


def moved_wrench(wrench: Wrench, place: Placement) -> Wrench:
    """Return a wrench, given in a frame at `place`, in the reference frame."""
    if wrench == Wrench() or _is_none(place):
        return wrench
    force = place.rotation @ vector_of(wrench.force)
    moment = place.rotation @ vector_of(wrench.moment) + np.cross(place.translation, force)
    (fx, fy, fz), (mx, my, mz) = ([x.formula for x in vector] for vector in (force, moment))
    return Wrench((fx, fy, fz), (mx, my, mz))


def fault_of(cell: Formula, at_zero: Collection[str] | None = None) -> str:
    """Return why a coordinate has no value or, with `at_zero`, why a coupled joint's cell is not zero there."""
    try:
        value = Polynomial.of(cell, dict.fromkeys(at_zero or (), 0.0))
        _ = formula.value() if not (formula := value.formula).names else None
    except (FormulaError, ArithmeticError) as error:
        return str(error)
    what = f"{quote(cell)} is {quote(value.text)} where variables are 0, and axis and at are given there"
    return f"{what}: leave that out" if value.terms and at_zero is not None else ""
