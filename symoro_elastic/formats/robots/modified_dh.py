"""A robot's links and joints as the table of geometric parameters.

Frames are chosen on the axes of the joints at position 0; each row is the displacement between two of them, so any
robot has a table, and the table has the same positions, torques and frames. Links on fixed joints are merged; those
that carry nothing keep their frames, as fixed rows at the end. Frame 0 is that of the root link.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.polynomial import Polynomial

from symoro_elastic.formats.robots.axis_frames import Axis, frame_on
from symoro_elastic.formats.robots.displacements import (
    ROUNDING,
    Tolerance,
    length_cell,
    number_cell,
    placement_of,
    rows_of,
)
from symoro_elastic.formats.robots.joint_tree import Tree, tree_of
from symoro_elastic.formats.robots.robot import (
    Connection,
    Description,
    Holding,
    JointType,
    Link,
    LinkJoint,
    Mimicked,
    Placement,
    refuse_out_of_range,
)
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.described import BodyShape, DescribedMachine, Origin
from symoro_elastic.machine.formula import ZERO, Formula
from symoro_elastic.machine.limits import Limits, within_machine
from symoro_elastic.machine.machine import Base, Body, Closing, Floating, Friction, Joint, Kind, Loop, Spring, Vector3
from symoro_elastic.machine.names import did_you_mean, list_of_names, quote
from symoro_elastic.machine.springs_beside_motors import with_springs_beside

SEAT, CUT, END = "_seat", "_cut", "_end"
"""Ends of the names of rows that no joint or link has: of frames between nearly parallel axes, and of loops."""
LEAST_SIZE = 1e-9
"""Of a robot, m."""
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

    machine: DescribedMachine
    deviation: Deviation


def machine_of(description: Description, source: str) -> DescribedMachine:
    """The machine with the exact table of a robot; raises `InputError` that names the joint or the link."""
    return table_of(description, source).machine


def table_of(description: Description, source: str, snap: float = 0.0) -> Table:
    """The table of a robot, exact but for rounding, or with angles and lengths within `snap` (rad, m) of simple ones.

    Angles are then multiples of pi/12 and lengths zero. Raises `InputError` that names the joint or the link.
    """
    refuse_out_of_range(description, source)
    tree = tree_of(description, source)
    builder = _Builder(tree, source, snap)
    table = Table(builder.machine, builder.deviation)
    spread, size = 100 * snap * len(table.machine.joints), builder.size
    far = table.deviation.translation > MOST_ERROR * size + spread * max(size, 1.0)
    if far or table.deviation.rotation > MOST_ERROR + spread:
        what = f"its table would be {table.deviation.translation:.1e} m off: an axis cannot be placed; please report it"
        raise InputError(source, "robot", what)
    return table


@dataclass(frozen=True, eq=False)
class Placed:
    """A frame that gets a row: the joint that carries it, None on frame 0, and its placement in that joint's frame.

    `joint` is the joint that moves it there; a leaf and the ends of a loop have none. `closes` is the connection whose
    cut joint it is.
    """

    name: str
    carrier: LinkJoint | None
    target: Placement
    joint: LinkJoint | None = None
    closes: Connection | None = None


@dataclass(frozen=True, eq=False)
class _Builder:
    """A robot on the way to its table."""

    tree: Tree
    source: str
    snap: float

    @cached_property
    def machine(self) -> DescribedMachine:
        """The machine with the table."""
        description = self.tree.description
        machine = DescribedMachine(
            name=description.name,
            joints=tuple(self._following(row) for row in self.rows),
            base=Base(gravity=_vector(description.gravity)),
            floating=Floating(body=self._body_on(None)) if self.tree.floating else None,
            source=self.source,
            origin=Origin(remarks=(*description.remarks, *self._remarks()), shapes=tuple(self._shapes())),
        )
        limits = within_machine(Limits({joint.name: joint.limits for joint in self.tree.moving}), machine)
        return with_springs_beside(replace(machine, loops=tuple(self._loops(machine)), limits=limits))

    def _remarks(self) -> Iterator[str]:
        """What the table holds that the user of the robot may not expect."""
        followers = [joint.name for joint in self.tree.moving if joint.follows]
        if followers:
            limited = any(joint.limits for joint in self.tree.moving if joint.follows)
            without = "without a variable, and without limits" if limited else "without a variable"
            yield f"joints that mimic others become coupled rows, {without}: {list_of_names(followers)}"
        unknown = [one.name for one in self.tree.moving if all(x.frame_only for x, _ in self.tree.links_on(one))]
        empty = [row.name for row in self.rows if row.name in unknown and row.rotor_inertia.is_zero]
        if empty:
            yield f"the links on these joints have no mass in the file and are massless: {list_of_names(empty)}"
        on_base = [joint for joint in self.tree.moving if self.tree.carrier(joint) is None]
        held = sum(link.mass for link, _ in self.tree.links_on(None))
        if held and len(on_base) > 1 and not self.tree.floating:
            yield (
                f"link {quote(self.tree.root)} is held, its mass of {held:g} kg is at rest: a floating base is the "
                "child of a floating joint"
            )

    @cached_property
    def deviation(self) -> Deviation:
        """Between the frames of the rows and those of the robot, at position 0."""
        realized = [Placement()]
        for row in self.rows:
            realized.append(realized[row.antecedent] * placement_of(row))
        wanted: dict[str, Placement] = {}
        largest = [0.0, 0.0]
        for placed, number in zip(self.placed, self.numbers, strict=True):
            before = wanted[placed.carrier.name] if placed.carrier else Placement()
            target = before * self._displacement(placed)
            if placed.joint:
                wanted[placed.joint.name] = target
            between = target.inverse * realized[number]
            errors = (np.abs(between.rotation - np.eye(3)).max(), np.abs(between.translation).max())
            largest = [max(pair) for pair in zip(largest, map(float, errors), strict=True)]
        return Deviation(*largest)

    @cached_property
    def size(self) -> float:
        """Largest distance of a joint, or of a centre of mass, from the joint before, m."""
        places = [joint.placement.translation for joint in self.tree.joints]
        centers = [link.center for link in self.tree.description.links]
        return max(LEAST_SIZE, *(float(np.abs(x).max()) for x in (*places, *centers)))

    @cached_property
    def tolerance(self) -> Tolerance:
        """What is taken for zero."""
        return Tolerance.of(self.snap, self.size) if self.snap else Tolerance.rounding(self.size)

    @cached_property
    def placed(self) -> tuple[Placed, ...]:
        """What gets a row: joints that move, then leaves and the ends of connections."""
        tree = self.tree
        moving = [Placed(j.name, tree.carrier(j), tree.seat(j) * self._frame_of(j), j) for j in tree.moving]
        leaves = [Placed(joint.child, tree.carrier(joint), tree.seat(joint)) for joint in tree.leaves]
        ends = [end for connection in tree.description.connections for end in self._ends(connection)]
        return (*moving, *leaves, *ends)

    def _ends(self, connection: Connection) -> Iterator[Placed]:
        """The cut joint of a loop, and the frame that it meets."""
        on = ((CUT, connection.first, connection.on_first), (END, connection.second, connection.on_second))
        for suffix, link, place in on:
            if link not in self.tree.carrying:
                what = f"{quote(link)} is not a link that the robot moves{did_you_mean(link, self.tree.carrying)}"
                raise InputError(self.source, f"connection {quote(connection.name)}", what)
            carried = self.tree.carrying[link]
            target = carried.placement * place
            if connection.holding is Holding.POINT:
                target = Placement(self._frame_of(carried.joint).rotation, target.translation)
            cut = connection if suffix == CUT else None
            yield Placed(connection.name + suffix, carried.joint, target, closes=cut)

    def _loops(self, machine: DescribedMachine) -> Iterator[Loop]:
        """The loops that the connections close: the last rows of the machine are their ends."""
        connections = self.tree.description.connections
        ends = self.numbers[len(self.numbers) - 2 * len(connections) :]
        for connection, cut, end in zip(connections, ends[::2], ends[1::2], strict=True):
            closes = Closing.POINT if connection.holding is Holding.POINT else Closing.FRAME
            loop = Loop(connection.name, cut, end, closes)
            owners = map(machine.joint, machine.with_variable_in(loop)) if connection.start else ()
            start = {str(one.variable): number_cell(connection.start.get(one.name, 0.0)) for one in owners}
            yield replace(loop, start=start)

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

    def _displacement(self, placed: Placed) -> Placement:
        """Placement of the frame of a row in that of the row that carries it."""
        return self._frame_of(placed.carrier).inverse * placed.target

    @property
    def rows(self) -> list[Joint]:
        """The rows of the table; coupled ones without what they follow."""
        return self._rows_and_numbers[0]

    @property
    def numbers(self) -> list[int]:
        """The number of the row of each placed frame."""
        return self._rows_and_numbers[1]

    @cached_property
    def _rows_and_numbers(self) -> tuple[list[Joint], list[int]]:
        rows: list[Joint] = []
        numbers: list[int] = []
        of_joints: dict[str, int] = {}
        for placed in self.placed:
            antecedent = of_joints[placed.carrier.name] if placed.carrier else 0
            *seats, last = rows_of(self._displacement(placed), self.tolerance)
            for seat in seats:
                rows.append(seat.put_into(Joint(placed.name + SEAT, antecedent, Kind.FIXED, 2), self.tolerance))
                antecedent = len(rows)
            numbers.append(len(rows) + 1)
            if placed.joint:
                of_joints[placed.joint.name] = numbers[-1]
            rows.append(last.put_into(self._row(placed, antecedent, numbers[-1]), self.tolerance))
        return rows, numbers

    def _row(self, placed: Placed, antecedent: int, number: int) -> Joint:
        """The row of a joint, without its geometric parameters."""
        joint = placed.joint
        if joint is None and placed.closes and placed.closes.holding is Holding.AXIS:
            return Joint(placed.name, antecedent, Kind.CUT, 0, f"q{number}")
        if joint is None:
            return Joint(placed.name, antecedent, Kind.CUT if placed.closes else Kind.FIXED, 2)
        kind, sigma = kind_of(joint, self.source), int(joint.type is JointType.PRISMATIC)
        variable = None if kind is Kind.COUPLED else f"q{number}"
        row = Joint(joint.name, antecedent, kind, sigma, variable, body=self._body_on(joint))
        return with_forces(row, joint)

    def _body_on(self, joint: LinkJoint | None) -> Body:
        """The body that moves with a joint, or with frame 0, in the frame of the table."""
        into = self._frame_of(joint).inverse
        links = [(link, into * place) for link, place in self.tree.links_on(joint)]
        return body_of(links, self.tolerance.length, self.snap)

    def _shapes(self) -> Iterator[BodyShape]:
        """What the bodies look like, in the frames of the table."""
        for joint in (None, *self.tree.moving):
            into = self._frame_of(joint).inverse
            for link, place in self.tree.links_on(joint):
                at, on = (into * place).matrix, joint.name if joint else ""
                yield from (replace(shape, joint=on, points=at @ shape.points) for shape in link.shapes)

    def _following(self, row: Joint) -> Joint:
        """The row, a coupled one with the formula of the variable that it follows."""
        if row.kind is not Kind.COUPLED:
            return row
        joint = next(one for one in self.tree.moving if one.name == row.name)
        variables = {one.name: one.variable for one in self.rows if one.variable}
        return row.with_selected(Followers(self.tree, self.source).cell(joint, row.selected, variables))


def kind_of(joint: LinkJoint, source: str) -> Kind:
    """The kind of a joint that moves, that of its motor where it has a spring too; raises `InputError`."""
    if joint.follows and joint.stiffness:
        what = "it has a spring and follows another joint: a coupled row has no spring"
        raise InputError(source, f"joint {quote(joint.name)}", what)
    if joint.follows:
        return Kind.COUPLED
    if joint.driven:
        return Kind.MOTOR
    return Kind.ELASTIC if joint.stiffness else Kind.PASSIVE


def with_forces(row: Joint, joint: LinkJoint) -> Joint:
    """The row with the forces on the joint: spring, friction, and the inertia of the rotor.

    Damping is that of the spring, but friction where there is a motor.
    """
    stiffness, neutral, damping, dry, rotor = (
        length_cell(x, 0.0)
        for x in (joint.stiffness, joint.neutral, joint.damping, joint.friction, joint.rotor_inertia)
    )
    elastic = row.kind is Kind.ELASTIC
    return replace(
        row,
        spring=Spring(stiffness, damping if elastic else ZERO, neutral),
        friction=Friction(coulomb=dry) if elastic else Friction(damping, dry),
        rotor_inertia=rotor,
    )


def _vector(values: Iterable[float]) -> Vector3:
    x, y, z = (length_cell(value, 0.0) for value in values)
    return x, y, z


ENTRIES = ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))


def body_of(links: Iterable[tuple[Link, Placement]], length: float, products: float = 0.0) -> Body:
    """The body that links with these placements make, about its centre of mass in the frame of the placements.

    Coordinates of the centre below `length`, m, and products of inertia below `products` of the trace are zero.
    """
    whole = together(links)
    mass, center, inertia = whole.mass, whole.center, whole.inertia
    trace = float(np.trace(inertia))
    least = [max(products, ROUNDING) * trace, ROUNDING * trace]
    if not mass and not np.any(inertia):
        return Body()
    x, y, z = (length_cell(float(entry), length) for entry in center)
    xx, xy, xz, yy, yz, zz = (length_cell(float(inertia[i, k]), least[i == k]) for i, k in ENTRIES)
    return Body(length_cell(mass, 0.0), (x, y, z), (xx, xy, xz, yy, yz, zz), central=True)


def together(links: Iterable[tuple[Link, Placement]]) -> Link:
    """The link that links with these placements make, in the frame of the placements."""
    placed = [
        (link.mass, place.rotation @ link.center + place.translation, _turned(link, place)) for link, place in links
    ]
    mass = float(sum(m for m, _, _ in placed))
    center = sum((m * c for m, c, _ in placed), np.zeros(3)) / mass if mass else np.zeros(3)
    inertia = sum((tensor + m * _point_mass(c - center) for m, c, tensor in placed), np.zeros((3, 3)))
    return Link("", mass, center, inertia, frame_only=not mass and not np.any(inertia))


def _turned(link: Link, place: Placement) -> Array:
    """The inertia of a link about its centre of mass, in axes of the frame in which it is placed."""
    turned: Array = place.rotation @ link.inertia @ place.rotation.T
    return turned


def _point_mass(c: Array) -> Array:
    """Inertia about the origin of a unit mass at c."""
    tensor: Array = (c @ c) * np.eye(3) - np.outer(c, c)
    return tensor


@dataclass(frozen=True)
class Followers:
    """The joints of a robot that follow others."""

    tree: Tree
    source: str

    def leader(self, joint: LinkJoint) -> Mimicked:
        """The joint with a variable of its own that a joint follows, through others that follow it too.

        Raises `InputError` for one that follows itself, or no joint that moves.
        """
        joints = {one.name: one for one in self.tree.description.joints}
        assert joint.follows is not None
        found, seen = joint.follows, [joint.name]
        while True:
            if found.joint not in joints:
                what = f"it mimics {quote(found.joint)}, which is not a joint{did_you_mean(found.joint, joints)}"
                raise self._wrong(joint, what)
            leader = joints[found.joint]
            if leader.name in seen:
                what = "mimics it" if leader is joint else "follows itself"
                raise self._wrong(joint, f"it mimics {quote(joint.follows.joint)}, which {what}: break the cycle")
            if leader.type in (JointType.FIXED, JointType.FLOATING):
                raise self._wrong(joint, f"it mimics {quote(leader.name)}, which has no variable of its own")
            if not any((found.multiplier, *found.powers)):
                raise self._wrong(joint, "its multiplier is 0: a joint that does not move is fixed")
            if leader.follows is None:
                return found
            seen.append(leader.name)
            found = _composed(found, leader.follows)

    def cell(self, joint: LinkJoint, offset: Formula, variables: Mapping[str, str]) -> Formula:
        """The cell of a joint that follows another: a polynomial of that variable, and the offset of the joint."""
        leader = self.leader(joint)
        types = {one.name: one.type for one in self.tree.description.joints}
        variable = variables[leader.joint]
        if abs(leader.multiplier) == 1.0 and types[leader.joint] is joint.type:
            text = variable if leader.multiplier > 0 else f"-{variable}"
        else:
            text = f"{number_cell(leader.multiplier)}*{variable}"
        first = [text] if leader.multiplier else []
        powers = [f"({number_cell(x)})*{variable}^{k}" for k, x in enumerate(leader.powers, start=2) if x]
        terms = [term for term in (offset, number_cell(leader.offset)) if not term.is_zero]
        constants = [f"({term})" if term.text[0] == "-" else term.text for term in terms]
        return Formula.parse(" + ".join([*first, *powers, *constants]))

    def _wrong(self, joint: LinkJoint, what: str) -> InputError:
        return InputError(self.source, f"joint {quote(joint.name)}", what)


def _composed(outer: Mimicked, inner: Mimicked) -> Mimicked:
    """What a joint follows through another one that follows it."""
    law, of = (Polynomial([one.offset, one.multiplier, *one.powers]) for one in (outer, inner))
    offset, multiplier, *powers = map(float, law(of).coef)
    return Mimicked(inner.joint, multiplier, offset, tuple(powers))
