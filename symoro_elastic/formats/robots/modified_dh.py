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

from symoro_elastic.formats.central import ENTRIES
from symoro_elastic.formats.robots.axis_frames import Axis, frame_on
from symoro_elastic.formats.robots.joint_tree import (
    ROUNDING,
    Tolerance,
    Tree,
    angle_cell,
    length_cell,
    number_cell,
    placement_of,
    rotation,
    rows_of,
    rpy_of,
    tree_of,
)
from symoro_elastic.formats.robots.loop_variables import following_joints
from symoro_elastic.formats.robots.robot import (
    SPRING_OF_FOLLOWER,
    Connection,
    Description,
    Holding,
    JointType,
    Link,
    LinkJoint,
    Mimicked,
    PlacedFrame,
    Placement,
    refuse_out_of_range,
)
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.described import BodyShape, DescribedMachine, Origin
from symoro_elastic.machine.formula import ZERO, Formula
from symoro_elastic.machine.limits import Limits, within_machine
from symoro_elastic.machine.machine import (
    Base,
    Body,
    Closing,
    Floating,
    Friction,
    Joint,
    Kind,
    Loop,
    NamedFrame,
    Spring,
    Vector3,
)
from symoro_elastic.machine.names import did_you_mean, list_of_names, quote
from symoro_elastic.quantities.frames import BASE

SEAT, CUT, END = "_seat", "_cut", "_end"
"""Ends of the names of rows that no joint or link has: of frames between nearly parallel axes, and of loops."""
LEAST_SIZE = 1e-9
"""Of a robot, m."""
MOST_ERROR = 1e-12
"""Of an exact table: displacements that it leaves between its frames and those of the robot, rad, and m by its size."""


@dataclass(frozen=True)
class Deviation:
    """Deviation of the table's frames from the robot's: largest entry of R - 1, rad, and displacement, m."""

    rotation: float
    translation: float


@dataclass(frozen=True, eq=False)
class Table:
    """The machine with the table of a robot, and the `deviation` of its frames at position 0."""

    machine: DescribedMachine
    deviation: Deviation


def machine_of(description: Description, source: str) -> DescribedMachine:
    """Convert a robot to a machine with an exact table; raises `InputError` that names the joint or the link."""
    return table_of(description, source).machine


def table_of(description: Description, source: str, snap: float = 0.0) -> Table:
    """Convert a robot to a table, exact but for rounding, or with cells within `snap` (rad, m) of simple values.

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
    """A frame with a row: the joint that carries it, None on frame 0, and its placement in the joint's frame.

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
    """Conversion of a robot description to a table of modified DH parameters."""

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
            floating=self._floating,
            source=self.source,
            origin=Origin(remarks=(*description.remarks, *self._remarks()), shapes=tuple(self._shapes())),
        )
        limits = within_machine(Limits({joint.name: joint.limits for joint in self.tree.moving}), machine)
        loops, frames = tuple(self._loops(machine)), tuple(self._named_frames())
        return replace(machine, loops=loops, limits=limits, frames=frames)

    @property
    def _floating(self) -> Floating | None:
        joint = self.tree.floating
        damping = length_cell(joint.damping, 0.0) if joint else ZERO
        body = self._body_on(None)
        return Floating(body=body, linear_damping=damping, angular_damping=damping) if joint else None

    def _named_frames(self) -> Iterator[NamedFrame]:
        """The frames of the file on the rows of the table, without those equal to a row of the same name."""
        by_name: dict[str, list[tuple[str, str, Placement]]] = {}
        for frame in self.tree.description.frames:
            if frame.link not in self.tree.carrying:
                continue
            on, at = self._on_row(frame)
            places = by_name.setdefault(frame.name, [])
            if all(row != on or not self._is_still(at.inverse * place) for _, row, place in places):
                places.append((frame.what, on, at))
        rows = {row.name for row in self.rows}
        for name, those in by_name.items():
            for what, on, at in those:
                is_own = len(those) == 1 and on != BASE and name == (on or BASE)
                if not (is_own and self._is_still(at)):
                    is_free = len(those) == 1 and name != BASE and (is_own or name not in rows)
                    yield self._named_frame(name if is_free else f"{what} {name}", on, at)

    def _on_row(self, frame: PlacedFrame) -> tuple[str, Placement]:
        """Row that carries a frame, empty for frame 0, and the frame's placement in it."""
        if frame.link in self._leaves_with_rows:
            return frame.link, frame.placement
        carried = self.tree.carrying[frame.link]
        at = self._frame_of(carried.joint).inverse * carried.placement * frame.placement
        return carried.joint.name if carried.joint else "", at

    @cached_property
    def _leaves_with_rows(self) -> frozenset[str]:
        """Names of the leaf links whose names differ from those of moving joints."""
        return frozenset(joint.child for joint in self.tree.leaves) - {joint.name for joint in self.tree.moving}

    def _is_still(self, at: Placement) -> bool:
        """Return whether a placement is the identity within rounding."""
        largest = max(float(np.abs(at.rotation - np.eye(3)).max()), float(np.abs(at.translation).max()) / self.size)
        return largest <= ROUNDING

    def _named_frame(self, name: str, on: str, at: Placement) -> NamedFrame:
        x, y, z = (length_cell(float(value), self.tolerance.length) for value in at.translation)
        roll, pitch, yaw = (angle_cell(angle, self.tolerance) for angle in rpy_of(at.rotation))
        return NamedFrame(name, on, (x, y, z), (roll, pitch, yaw))

    def _remarks(self) -> Iterator[str]:
        """Yield remarks on entries of the table that users of the robot may not expect."""
        followers = [joint.name for joint in self.tree.moving if joint.follows]
        if followers:
            limited = any(joint.limits for joint in self.tree.moving if joint.follows)
            without = "without a variable, and without limits" if limited else "without a variable"
            yield f"joints that mimic others become coupled rows, {without}: {list_of_names(followers)}"
        unknown = [joint.name for joint in self.tree.moving if all(x.frame_only for x, _ in self.tree.links_on(joint))]
        empty = [row.name for row in self.rows if row.name in unknown and row.rotor_inertia.is_zero]
        if len(empty) == len(self.tree.moving):
            yield "no link has a mass in the file"
        elif empty:
            yield f"the links on these joints have no mass in the file and are massless: {list_of_names(empty)}"
        on_base = [joint for joint in self.tree.moving if self.tree.carrier(joint) is None]
        mass = sum(link.mass for link, _ in self.tree.links_on(None))
        if mass and len(on_base) > 1 and not self.tree.floating:
            yield (
                f"link {quote(self.tree.root)} is held, its mass of {mass:g} kg is at rest: a floating base is the "
                "child of a floating joint"
            )

    @cached_property
    def deviation(self) -> Deviation:
        """Deviation of the machine's frames from those of the robot, at position 0."""
        largest = [0.0, 0.0]
        for realized, target in self._realized_and_wanted():
            between = target.inverse * realized
            errors = (np.abs(between.rotation - np.eye(3)).max(), np.abs(between.translation).max())
            largest = [max(pair) for pair in zip(largest, map(float, errors), strict=True)]
        return Deviation(*largest)

    def _realized_and_wanted(self) -> Iterator[tuple[Placement, Placement]]:
        """Placements of frames at position 0, by the table and by the robot: those of rows, then the named ones."""
        realized = [Placement()]
        for row in self.rows:
            realized.append(realized[row.antecedent] * placement_of(row))
        wanted: dict[str, Placement] = {"": Placement()}
        for row_frame, number in zip(self.row_frames, self.numbers, strict=True):
            target = wanted[row_frame.carrier.name if row_frame.carrier else ""] * self._displacement(row_frame)
            if row_frame.joint:
                wanted[row_frame.joint.name] = target
            yield realized[number], target
        rows = {"": 0} | {row.name: k for k, row in reversed([*enumerate(self.rows, start=1)])}
        for frame in self.tree.description.frames:
            if carried := self.tree.carrying.get(frame.link):
                on, at = self._on_row(frame)
                named = self._named_frame(frame.name, on, at)
                place = Placement(rotation(*(x.value() for x in named.rpy)), np.array([x.value() for x in named.at]))
                before = wanted[carried.joint.name if carried.joint else ""] * self._frame_of(carried.joint).inverse
                yield realized[rows[on]] * place, before * carried.placement * frame.placement

    @cached_property
    def size(self) -> float:
        """Size of the robot: largest distance of a joint or a centre of mass from the preceding joint, m."""
        places = [joint.placement.translation for joint in self.tree.joints]
        centers = [link.center for link in self.tree.description.links]
        return max(LEAST_SIZE, *(float(np.abs(x).max()) for x in (*places, *centers)))

    @cached_property
    def tolerance(self) -> Tolerance:
        """Angles and lengths that count as zero."""
        return Tolerance.of(self.snap, self.size) if self.snap else Tolerance.rounding(self.size)

    @cached_property
    def row_frames(self) -> tuple[Placed, ...]:
        """Frames with rows: moving joints, then leaves and the ends of connections."""
        tree = self.tree
        moving = [Placed(j.name, tree.carrier(j), tree.seat(j) * self._frame_of(j), j) for j in tree.moving]
        leaves = [Placed(joint.child, tree.carrier(joint), tree.seat(joint)) for joint in tree.leaves]
        ends = [end for connection in tree.description.connections for end in self._ends(connection)]
        return (*moving, *leaves, *ends)

    def _ends(self, connection: Connection) -> Iterator[Placed]:
        """Frames at the ends of a connection: the cut joint of the loop, and the frame that it meets."""
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
        """Loops of the connections, whose ends are the last rows of the machine."""
        connections = self.tree.description.connections
        ends = self.numbers[len(self.numbers) - 2 * len(connections) :]
        following = following_joints(self.tree, connections, self._slopes)
        for connection, cut, end in zip(connections, ends[::2], ends[1::2], strict=True):
            closes = Closing.POINT if connection.holding is Holding.POINT else Closing.FRAME
            loop = Loop(connection.name, cut, end, closes, following.get(connection.name, ()))
            owners = map(machine.joint, machine.with_variable_in(loop)) if connection.start else ()
            start = {str(joint.variable): number_cell(connection.start.get(joint.name, 0.0)) for joint in owners}
            yield replace(loop, start=start)

    @cached_property
    def _slopes(self) -> dict[str, tuple[str, float]]:
        """Independent joint of each following joint, and the ratio at position 0."""
        laws = {joint.name: self.followers.leader(joint) for joint in self.tree.moving if joint.follows}
        return {name: (law.joint, law.multiplier) for name, law in laws.items()}

    @property
    def followers(self) -> Followers:
        """Following joints of the robot."""
        return Followers(self.tree, self.source)

    @cached_property
    def frames(self) -> dict[str, Placement]:
        """Frames of moving joints in the table, relative to their frames in the description."""
        frames: dict[str, Placement] = {}
        for joint in self.tree.moving:
            carrier = self.tree.carrier(joint)
            before = self.tree.seat(joint).inverse * (frames[carrier.name] if carrier else Placement())
            frames[joint.name] = frame_on(Axis(np.zeros(3), joint.axis), before, self._axis_after(joint))
        return frames

    def _axis_after(self, joint: LinkJoint) -> Axis | None:
        """Axis of the next joint, on a branch the one that carries most joints."""
        for after in self.tree.carried_joints[joint.name]:
            seat = self.tree.seat(after)
            return Axis(seat.translation, seat.rotation @ after.axis)
        return None

    def _frame_of(self, joint: LinkJoint | None) -> Placement:
        """Frame of a moving joint in the table; the identity for frame 0 and fixed joints."""
        return self.frames.get(joint.name, Placement()) if joint else Placement()

    def _displacement(self, frame: Placed) -> Placement:
        """Placement of a row's frame in the frame of the row that carries it."""
        return self._frame_of(frame.carrier).inverse * frame.target

    @property
    def rows(self) -> list[Joint]:
        """Rows of the table; coupled ones still without their formulas."""
        return self._rows_and_numbers[0]

    @property
    def numbers(self) -> list[int]:
        """Row numbers of the placed frames."""
        return self._rows_and_numbers[1]

    @cached_property
    def _rows_and_numbers(self) -> tuple[list[Joint], list[int]]:
        rows: list[Joint] = []
        numbers: list[int] = []
        of_joints: dict[str, int] = {}
        for frame in self.row_frames:
            antecedent = of_joints[frame.carrier.name] if frame.carrier else 0
            *seats, last = rows_of(self._displacement(frame), self.tolerance)
            for seat in seats:
                rows.append(seat.put_into(Joint(frame.name + SEAT, antecedent, Kind.FIXED, 2), self.tolerance))
                antecedent = len(rows)
            numbers.append(len(rows) + 1)
            if frame.joint:
                of_joints[frame.joint.name] = numbers[-1]
            rows.append(last.put_into(self._row(frame, antecedent, numbers[-1]), self.tolerance))
        return rows, numbers

    def _row(self, frame: Placed, antecedent: int, number: int) -> Joint:
        """Row of a joint, still without geometric parameters."""
        joint = frame.joint
        if joint is None and frame.closes and frame.closes.holding is Holding.AXIS:
            return Joint(frame.name, antecedent, Kind.CUT, 0, f"q{number}")
        if joint is None:
            return Joint(frame.name, antecedent, Kind.CUT if frame.closes else Kind.FIXED, 2)
        kind, sigma = kind_of(joint, self.source), int(joint.type is JointType.PRISMATIC)
        variable = None if kind is Kind.COUPLED else f"q{number}"
        row = Joint(joint.name, antecedent, kind, sigma, variable, body=self._body_on(joint))
        return with_forces(row, joint)

    def _body_on(self, joint: LinkJoint | None) -> Body:
        """Body that moves with a joint, or with frame 0, in its frame of the table."""
        into = self._frame_of(joint).inverse
        links = [(link, into * place) for link, place in self.tree.links_on(joint)]
        return body_of(links, self.tolerance.length, self.snap)

    def _shapes(self) -> Iterator[BodyShape]:
        """Shapes of the bodies, in the frames of the table."""
        for joint in (None, *self.tree.moving):
            into = self._frame_of(joint).inverse
            for link, place in self.tree.links_on(joint):
                at, on = (into * place).matrix, joint.name if joint else ""
                yield from (replace(shape, joint=on, points=at @ shape.points) for shape in link.shapes)

    def _following(self, row: Joint) -> Joint:
        """Return a row; for a coupled joint with the formula of the variable that it follows."""
        if row.kind is not Kind.COUPLED:
            return row
        joint = next(candidate for candidate in self.tree.moving if candidate.name == row.name)
        variables = {described.name: described.variable for described in self.rows if described.variable}
        return row.with_selected(self.followers.cell(joint, row.selected, variables))


def kind_of(joint: LinkJoint, source: str) -> Kind:
    """Kind of a moving joint, that of its motor if it has a spring too; raises `InputError`."""
    if joint.follows and joint.stiffness:
        raise InputError(source, f"joint {quote(joint.name)}", SPRING_OF_FOLLOWER)
    if joint.follows:
        return Kind.COUPLED
    if joint.driven:
        return Kind.MOTOR
    return Kind.ELASTIC if joint.stiffness else Kind.PASSIVE


def with_forces(row: Joint, joint: LinkJoint) -> Joint:
    """The row with the forces on its joint: spring, friction, and rotor inertia.

    Damping is that of the spring, but friction where there is a motor.
    """
    stiffness, neutral, damping, dry, rotor, ball = (
        length_cell(x, 0.0)
        for x in (joint.stiffness, joint.neutral, joint.damping, joint.friction, joint.rotor_inertia, joint.ball)
    )
    elastic = row.kind is Kind.ELASTIC
    return replace(
        row,
        spring=Spring(stiffness, damping if elastic else ZERO, neutral),
        friction=Friction(coulomb=dry) if elastic else Friction(damping, dry, ball=ball),
        rotor_inertia=rotor,
    )


def _vector(values: Iterable[float]) -> Vector3:
    x, y, z = (length_cell(value, 0.0) for value in values)
    return x, y, z


def body_of(links: Iterable[tuple[Link, Placement]], length: float, products: float = 0.0) -> Body:
    """Return the body of links with these placements, about its centre of mass in the frame of the placements.

    Coordinates of the centre below `length`, m, and products of inertia below `products` of the trace are zero.
    """
    link = together(links)
    mass, center, inertia = link.mass, link.center, link.inertia
    trace = float(np.trace(inertia))
    least = [max(products, ROUNDING) * trace, ROUNDING * trace]
    if not mass and not np.any(inertia):
        return Body()
    x, y, z = (length_cell(float(entry), length) for entry in center)
    xx, xy, xz, yy, yz, zz = (length_cell(float(inertia[i, k]), least[i == k]) for i, k in ENTRIES)
    return Body(length_cell(mass, 0.0), (x, y, z), (xx, xy, xz, yy, yz, zz), central=True)


def together(links: Iterable[tuple[Link, Placement]]) -> Link:
    """Return the link equivalent to links with these placements, in the frame of the placements."""
    turned = [(x, at.rotation @ x.center + at.translation, at.rotation) for x, at in links]
    inertias = [(x.mass, center, A @ x.inertia @ A.T) for x, center, A in turned]
    mass = float(sum(m for m, _, _ in inertias))
    center = sum((m * c for m, c, _ in inertias), np.zeros(3)) / mass if mass else np.zeros(3)
    inertia = sum((tensor + m * _point_mass(c - center) for m, c, tensor in inertias), np.zeros((3, 3)))
    return Link("", mass, center, inertia, frame_only=not mass and not np.any(inertia))


def _point_mass(c: Array) -> Array:
    """Inertia tensor about the origin of a unit mass at c."""
    return np.asarray((c @ c) * np.eye(3) - np.outer(c, c))


@dataclass(frozen=True)
class Followers:
    """Following joints of a robot, and their laws."""

    tree: Tree
    source: str

    def leader(self, joint: LinkJoint) -> Mimicked:
        """Law of a joint in terms of an independent joint, through other followers.

        Raises `InputError` for one that follows itself, or no joint that moves.
        """
        joints = {x.name: x for x in self.tree.description.joints}
        assert joint.follows is not None
        followed, visited = joint.follows, [joint.name]
        while True:
            if followed.joint not in joints:
                what = f"it mimics {quote(followed.joint)}, which is not a joint{did_you_mean(followed.joint, joints)}"
                raise self._wrong(joint, what)
            leader = joints[followed.joint]
            if leader.name in visited:
                what = "mimics it" if leader is joint else "follows itself"
                raise self._wrong(joint, f"it mimics {quote(joint.follows.joint)}, which {what}: break the cycle")
            if leader.type in (JointType.FIXED, JointType.FLOATING):
                raise self._wrong(joint, f"it mimics {quote(leader.name)}, which has no variable of its own")
            if not any((followed.multiplier, *followed.powers)):
                raise self._wrong(joint, "its multiplier is 0: a joint that does not move is fixed")
            if leader.follows is None:
                return followed
            visited.append(leader.name)
            followed = _composition(followed, leader.follows)

    def cell(self, joint: LinkJoint, offset: Formula, variables: Mapping[str, str]) -> Formula:
        """Cell of a following joint: a polynomial of the leader's variable, plus the offset of the joint."""
        leader = self.leader(joint)
        types = {x.name: x.type for x in self.tree.description.joints}
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


def _composition(outer: Mimicked, inner: Mimicked) -> Mimicked:
    """Return the law of a joint that follows a following joint: `outer` of `inner`."""
    law, of = (Polynomial([mimicked.offset, mimicked.multiplier, *mimicked.powers]) for mimicked in (outer, inner))
    offset, multiplier, *powers = map(float, law(of).coef)
    return Mimicked(inner.joint, multiplier, offset, tuple(powers))
