"""A robot's links and joints as the table of geometric parameters.

Frames are chosen on the axes of the joints at position 0; each row is the displacement between two of them, so any
robot has a table, and the table has the same positions, torques and frames. Links on fixed joints are merged; those
that carry nothing keep their frames, as fixed rows at the end. Frame 0 is that of the root link.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from symoro_elastic.errors import InputError
from symoro_elastic.machine.formats.robots.axis_frames import Axis, frame_on
from symoro_elastic.machine.formats.robots.bodies import body_of
from symoro_elastic.machine.formats.robots.closed_loops import closed
from symoro_elastic.machine.formats.robots.description import (
    Description,
    JointType,
    LinkJoint,
    Placement,
)
from symoro_elastic.machine.formats.robots.followed import Followers
from symoro_elastic.machine.formats.robots.rows import Tolerance, length_cell, placement_of, rows_of
from symoro_elastic.machine.formats.robots.tree import Tree, tree_of
from symoro_elastic.machine.machine import Base, Body, Floating, Friction, Joint, Kind, Machine, Spring, Vector3
from symoro_elastic.machine.names import listed, quoted

MOST_ERROR = 1e-12
"""Of an exact table: displacements that it leaves between its frames and those of the robot, rad, and m by its size."""


@dataclass(frozen=True)
class Deviation:
    """The largest rotation, rad, and displacement, m, between a frame of the table and the same of the robot."""

    rotation: float
    translation: float


@dataclass(frozen=True, eq=False)
class Table:
    """The table of a robot and what it leaves of it: `machine`, and the `deviation` of its frames at position 0."""

    machine: Machine
    deviation: Deviation


def machine_of(description: Description, source: str) -> Machine:
    """The machine with the exact table of a robot; raises `InputError` that names the joint or the link."""
    return table_of(description, source).machine


def table_of(description: Description, source: str, snap: float = 0.0) -> Table:
    """The table of a robot, exact but for rounding, or with angles and lengths within `snap` (rad, m) of simple ones.

    Angles are then multiples of pi/12 and lengths zero. Raises `InputError` that names the joint or the link.
    """
    tree = tree_of(description, source)
    builder = _Builder(tree, source, snap)
    table = Table(builder.machine, builder.deviation)
    limit = max(MOST_ERROR, 100 * snap * len(table.machine.joints))
    if max(table.deviation.rotation, table.deviation.translation / builder.size) > limit:
        what = f"its table would be {table.deviation.translation:.1e} m off: an axis cannot be placed; please report it"
        raise InputError(source, "robot", what)
    return table


@dataclass(frozen=True, eq=False)
class _Builder:
    """A robot on the way to its table."""

    tree: Tree
    source: str
    snap: float

    @cached_property
    def machine(self) -> Machine:
        """The machine with the table."""
        description = self.tree.description
        tree = Machine(
            name=description.name,
            joints=tuple(self._following(row) for row in self.rows),
            base=Base(gravity=_vector(description.gravity)),
            floating=Floating(body=self._body_on(None)) if self.tree.floating else None,
            remarks=(*description.remarks, *self._remarks()),
            source=self.source,
        )
        return closed(tree, description.connections, self._place, self.tolerance)

    def _place(self, link: str) -> tuple[int, Placement]:
        """Number of the row that carries a link, 0 for frame 0, and the placement of the link in its frame."""
        if link not in self.tree.carried:
            what = f"it is connected with {quoted(self.tree.root)}, in which the robot floats: remove one of both"
            raise InputError(self.source, f"link {quoted(link)}", what)
        carried = self.tree.carried[link]
        numbers = {row.name: number for number, row in enumerate(self.rows, start=1)}
        number = numbers[carried.joint.name] if carried.joint else 0
        return number, self._frame_of(carried.joint).inverse * carried.placement

    def _remarks(self) -> Iterator[str]:
        """What the table holds that the user of the robot may not expect."""
        followers = [joint.name for joint in self.tree.moving if joint.follows]
        if followers:
            yield f"joints that mimic others are coupled rows, without a variable: {listed(followers)}"
        unknown = [one.name for one in self.tree.moving if all(x.frame_only for x, _ in self.tree.links_on(one))]
        empty = [row.name for row in self.rows if row.name in unknown and row.rotor_inertia.is_zero]
        if empty:
            yield f"no mass is given for the links on these joints, none is taken: {listed(empty)}"
        on_base = [joint for joint in self.tree.moving if self.tree.carrier(joint) is None]
        held = sum(link.mass for link, _ in self.tree.links_on(None))
        if held and len(on_base) > 1 and not self.tree.floating:
            yield (
                f"link {quoted(self.tree.root)} is held, its mass of {held:g} kg is at rest: a base that floats is the "
                "child of a floating joint"
            )

    @cached_property
    def deviation(self) -> Deviation:
        """Between the frames of the rows and those of the robot, at position 0."""
        realized, wanted = [Placement()], {"": Placement()}
        joints = {row_name(joint): joint for joint in self.placed}
        largest = [0.0, 0.0]
        for row in self.rows:
            realized.append(realized[row.antecedent] * placement_of(row))
            if joint := joints.get(row.name):
                carrier = self.tree.carrier(joint)
                displacement = self._displacement(joint)
                wanted[row.name] = wanted[carrier.name if carrier else ""] * displacement
                between = wanted[row.name].inverse * realized[-1]
                errors = (np.abs(between.rotation - np.eye(3)).max(), np.abs(between.translation).max())
                largest = [max(pair) for pair in zip(largest, map(float, errors), strict=True)]
        return Deviation(*largest)

    @cached_property
    def size(self) -> float:
        """Largest distance of a joint from the one before, m; 1 where all are at one point."""
        return max((float(np.abs(j.placement.translation).max()) for j in self.tree.joints), default=0.0) or 1.0

    @cached_property
    def tolerance(self) -> Tolerance:
        """What is taken for zero."""
        return Tolerance.of(self.snap, self.size) if self.snap else Tolerance.rounding(self.size)

    @cached_property
    def placed(self) -> tuple[LinkJoint, ...]:
        """The joints that get a row: those that move, then those of leaves."""
        return (*self.tree.moving, *self.tree.leaves)

    @cached_property
    def frames(self) -> dict[str, Placement]:
        """The frame of each moving joint in the table, in the frame of the joint in the description."""
        found: dict[str, Placement] = {}
        for joint in self.tree.moving:
            carrier = self.tree.carrier(joint)
            before = self.tree.seat(joint).inverse * (found[carrier.name] if carrier else Placement())
            found[joint.name] = frame_on(Axis(np.zeros(3), joint.axis), before, self._axis_after(joint))
        return found

    def _axis_after(self, joint: LinkJoint) -> Axis | None:
        """The axis of the joint that follows, the one that carries most."""
        for after in self.tree.carried_joints[joint.name]:
            seat = self.tree.seat(after)
            return Axis(seat.translation, seat.rotation @ after.axis)
        return None

    def _frame_of(self, joint: LinkJoint | None) -> Placement:
        """The frame of a joint that moves, else that of its link."""
        return self.frames.get(joint.name, Placement()) if joint else Placement()

    def _displacement(self, joint: LinkJoint) -> Placement:
        """Placement of a joint's frame in the table in that of its antecedent."""
        return self._frame_of(self.tree.carrier(joint)).inverse * self.tree.seat(joint) * self._frame_of(joint)

    @cached_property
    def rows(self) -> list[Joint]:
        """The rows of the table; coupled ones without what they follow."""
        rows: list[Joint] = []
        numbers: dict[str, int] = {}
        for joint in self.placed:
            carrier = self.tree.carrier(joint)
            antecedent = numbers[carrier.name] if carrier else 0
            *seats, last = rows_of(self._displacement(joint), self.tolerance)
            for seat in seats:
                name = f"{row_name(joint)}_seat"
                rows.append(seat.put_into(Joint(name, antecedent, Kind.FIXED, 2), self.tolerance))
                antecedent = len(rows)
            numbers[joint.name] = len(rows) + 1
            rows.append(last.put_into(self._row(joint, antecedent, len(rows) + 1), self.tolerance))
        return rows

    def _row(self, joint: LinkJoint, antecedent: int, number: int) -> Joint:
        """The row of a joint, without its geometric parameters."""
        if joint.type is JointType.FIXED:
            return Joint(joint.child, antecedent, Kind.FIXED, 2)
        kind, sigma = kind_of(joint, self.source), int(joint.type is JointType.PRISMATIC)
        variable = None if kind is Kind.COUPLED else f"q{number}"
        row = Joint(joint.name, antecedent, kind, sigma, variable, body=self._body_on(joint))
        return with_forces(row, joint)

    def _body_on(self, joint: LinkJoint | None) -> Body:
        """The body that moves with a joint, or with frame 0, in the frame of the table."""
        into = self._frame_of(joint).inverse
        links = [(link, into * place) for link, place in self.tree.links_on(joint)]
        return body_of(links, self.tolerance.length, self.snap)

    def _following(self, row: Joint) -> Joint:
        """The row, a coupled one with the formula of the variable that it follows."""
        if row.kind is not Kind.COUPLED:
            return row
        joint = next(one for one in self.tree.moving if one.name == row.name)
        variables = {one.name: one.variable for one in self.rows if one.variable}
        return row.with_selected(Followers(self.tree, self.source).cell(joint, row.selected, variables))


def row_name(joint: LinkJoint) -> str:
    """The name of a joint's row: its own, or that of its link where it is fixed."""
    return joint.child if joint.type is JointType.FIXED else joint.name


def kind_of(joint: LinkJoint, source: str) -> Kind:
    """The kind of a joint that moves; raises `InputError` for a spring beside a motor."""
    if joint.follows or joint.stiffness:
        if joint.stiffness and (joint.follows or joint.driven):
            what = "it has a spring and a motor, or follows another joint: a row of the table has one of these"
            raise InputError(source, f"joint {quoted(joint.name)}", what)
        return Kind.COUPLED if joint.follows else Kind.ELASTIC
    return Kind.MOTOR if joint.driven else Kind.PASSIVE


def with_forces(row: Joint, joint: LinkJoint) -> Joint:
    """The row with the forces on the joint: spring, friction, and the inertia of the rotor."""
    stiffness, neutral, damping, dry, rotor = (
        length_cell(x, 0.0)
        for x in (joint.stiffness, joint.neutral, joint.damping, joint.friction, joint.rotor_inertia)
    )
    elastic = row.kind is Kind.ELASTIC
    return replace(
        row,
        spring=Spring(stiffness, damping, neutral) if elastic else Spring(),
        friction=Friction(coulomb=dry) if elastic else Friction(damping, dry),
        rotor_inertia=rotor,
    )


def _vector(values: Iterable[float]) -> Vector3:
    x, y, z = (length_cell(value, 0.0) for value in values)
    return x, y, z
