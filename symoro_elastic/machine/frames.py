"""Frames of a machine by their names: the only reader of texts that name a frame."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

from symoro_elastic.machine.described import AnyMachine, with_changed_scene
from symoro_elastic.machine.formula import ZERO, Formula
from symoro_elastic.machine.machine import Friction, Joint, Kind, KnownOfBase, Machine
from symoro_elastic.machine.names import distinct
from symoro_elastic.machine.scene import COMPONENTS, Point, RequestedPart
from symoro_elastic.quantities.frames import BASE, JOINT, OF_FILES, ROW, kind_and_name

Points = tuple[tuple[int, Point | None], ...]
"""Frames without a row: number of the frame, and coordinates in it where the origin is elsewhere."""
COORDINATES = tuple(f"{BASE}.{axis}" for axis in COMPONENTS)
"""Names of the six joints; the frame they carry is the base."""
QUARTER = Formula.parse("pi/2")


class FrameNames:
    """Names and numbers of the frames of a machine: 0, those of its rows, then the named ones that have no row.

    Where frame 0 is a choice (`or_frame_0`) `base` is frame 0, whatever joints are called; elsewhere it is the body of
    a base that is given coordinates, else the joint of that name. A name that a frame of `machine.frames` has means
    that frame, not the row of the same name, which is `row NAME`; where a link and a joint have one name and two
    frames, they are `link NAME` and `joint NAME`. With `by_any_name` joints may be called by their variables and
    numbers, too; a joint's own name comes before the variable of another.
    """

    def __init__(self, machine: Machine, by_any_name: bool = False) -> None:
        rows = machine.rows
        numbers = {str(j): j for j in rows.values()}
        variables = {joint.variable: rows[joint.name] for joint in machine.joints if joint.variable}
        self.rows, self.joints = rows, {**numbers, **variables, **rows} if by_any_name else rows
        self.named = {frame.name: len(rows) + k for k, frame in enumerate(machine.frames, start=1)}
        named_too = {kind_and_name(name)[1] for name in self.named}
        self.own = {**{name: j for name, j in rows.items() if name not in named_too}, **self.named}
        self._base = row_of_base(machine)

    def number(self, text: str, or_frame_0: bool = False) -> int | None:
        """Return the number of a frame; None where there is none of this name."""
        if or_frame_0 and text == BASE:
            return 0
        if self._base and text == BASE:
            return self._base
        if text in self.own:
            return self.own[text]
        what, _, name = map(str.strip, text.partition(" "))
        if what in OF_FILES and name in self.named:
            return self.named[name]
        if what in (JOINT, ROW) and name:
            return self.rows.get(name)
        row = self.joints.get(text) if text not in self.rows else None
        return row if row is None or text.isdecimal() else self.of_row(row)

    def of_row(self, j: int) -> int:
        """Return the number of the frame that has the name of a row: that of the row unless another one has it."""
        name = [*self.rows][j - 1]
        return self.own.get(name, self.named.get(f"{JOINT} {name}", j))

    def row(self, text: str) -> int | None:
        """Return the number of a row, by its name, `joint NAME` or `row NAME`; None where there is none."""
        what, _, name = map(str.strip, text.partition(" "))
        return self.rows.get(name) if what in (JOINT, ROW) and name else self.joints.get(text)

    def name(self, number: int) -> str:
        """Return the name of a frame by its number, the inverse of `number`; the base for frame 0."""
        if number == 0:
            return BASE
        if number > len(self.rows):
            return [*self.named][number - len(self.rows) - 1]
        name = self.joint(number)
        return name if self.own.get([*self.rows][number - 1]) == number else f"{ROW} {name}"

    def joint(self, j: int) -> str:
        """Return the name of the joint of a row, which is never that of frame 0."""
        name = [BASE, *self.rows][j]
        return f"{JOINT} {name}" if j and name == BASE else name

    def in_base(self, number: int, at: Point | None = None) -> str:
        """Return the request for a frame, or a point of its body, seen from frame 0."""
        return str(RequestedPart(self.name(number), at, self.name(0)))

    def all(self) -> tuple[int, ...]:
        """Return the numbers of all frames: rows whose names no other frame has, then the named ones."""
        return tuple(sorted(self.own.values()))

    def choices(self, or_frame_0: bool = False) -> list[str]:
        """Return the names of frames, and of the base if `or_frame_0`, that a message may propose."""
        return [*self.own, *([BASE] if or_frame_0 else [])]


def points_of(machine: Machine, frames: Iterable[tuple[int, Point | None]]) -> Points:
    """Return the frames without a row, and the points other than origins, among `frames`, each once."""
    rows = len(machine.joints)
    return tuple(dict.fromkeys((number, at) for number, at in frames if at or number > rows))


def row_under(machine: Machine, number: int) -> int:
    """Return the number of the row on whose body a frame is; 0 for those on frame 0."""
    rows = len(machine.joints)
    if number <= rows:
        return number
    on = machine.frames[number - rows - 1].on
    return next((j for j, joint in enumerate(machine.joints, start=1) if joint.name == on), 0)


def with_base_coordinates(machine: AnyMachine) -> AnyMachine:
    """Return the machine on a base at rest, its six degrees of freedom being the first joints.

    Each axis is the next of x, y, z: Rot(z, pi/2) Rot(x, pi/2) permutes them. The row of its body is called `base`, but
    `base_body` where a joint has that name.
    """
    if machine.floating is None:
        return machine
    if machine.floating.known is KnownOfBase.ACCELERATION:
        return replace(machine, floating=None)
    names = {joint.name for joint in machine.joints}
    name = distinct(f"{BASE}_body", names) if BASE in names else BASE
    along, about = machine.floating.linear_damping, machine.floating.angular_damping
    frictions = [Friction(viscous=along)] * 3 + [Friction(), Friction(), Friction(ball=about)]
    coordinates = [_coordinate(k, *pair) for k, pair in enumerate(zip(COORDINATES, frictions, strict=True))]
    base = Joint(name, len(coordinates), Kind.FIXED, 2, body=machine.floating.body)
    before = len(coordinates) + 1
    carried = [replace(joint, antecedent=joint.antecedent + before) for joint in machine.joints]
    loops = tuple(replace(loop, cut=loop.cut + before, meets=loop.meets + before) for loop in machine.loops)
    static = {j + before: replace(row, antecedent=row.antecedent + before) for j, row in machine.static.items()}
    joints = (*coordinates, base, *carried)
    frames = tuple(replace(frame, on=frame.on or name) for frame in machine.frames)
    free = replace(machine, joints=joints, loops=loops, static=static, frames=frames, floating=None)
    return with_changed_scene(free, lambda _: None)


def row_of_base(machine: Machine) -> int | None:
    """Return the number of the row that carries the body of a base with coordinates; None where it has none."""
    has_coordinates = machine.joints[:1] and machine.joint(1).name == COORDINATES[0]
    return len(COORDINATES) + 1 if has_coordinates else None


def with_given_acceleration(machine: AnyMachine) -> AnyMachine:
    """Return the machine with a given acceleration of its base, where that moves freely."""
    floating = machine.floating and replace(machine.floating, known=KnownOfBase.ACCELERATION)
    return replace(machine, floating=floating)


def _coordinate(k: int, name: str, friction: Friction) -> Joint:
    """Return joint k + 1: prismatic for k up to 2, then revolute, its axis the next of x, y, z."""
    sigma, turn = int(k < 3), QUARTER
    return Joint(name, k, Kind.PASSIVE, sigma, name, gamma=turn, alpha=turn, theta=ZERO, r=ZERO, friction=friction)
