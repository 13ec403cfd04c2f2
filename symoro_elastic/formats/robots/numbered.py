"""A machine as links and joints in numbers: the inverse of the table, for formats that are written.

Each row is a link on a joint. Both have its name, and their frame is that of the row, unless the machine has a frame of
this name, which a robot that was read has: then it is that frame, and the link has the name of the first other frame
there. Ends of loops that are nothing else are parts of their loops. What a format lacks is refused by the joint.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.polynomial import Polynomial

from symoro_elastic.formats.robots.joint_tree import ROUNDING, about_x, about_z, rotation
from symoro_elastic.formats.robots.robot import (
    Connection,
    Description,
    Holding,
    JointType,
    Link,
    LinkJoint,
    Mimicked,
    PlacedFrame,
    Placement,
)
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.errors import refusing
from symoro_elastic.machine.checks import parameter_values, place_of
from symoro_elastic.machine.columns import Cell, cells
from symoro_elastic.machine.described import DescribedMachine, limits_of
from symoro_elastic.machine.formula import FUNCTIONS, Formula, FormulaError
from symoro_elastic.machine.joints import SELECTED
from symoro_elastic.machine.limits import Limits
from symoro_elastic.machine.loops import Closing, Loop
from symoro_elastic.machine.machine import Base, Body, Floating, Joint, Kind, Machine
from symoro_elastic.machine.names import distinct, quote
from symoro_elastic.quantities.frames import SITE, kind_and_name

TYPES = {0: JointType.REVOLUTE, 1: JointType.PRISMATIC, 2: JointType.FIXED}
Z = np.array([0.0, 0.0, 1.0])
SMOOTH = {
    "creep": "creep velocities",
    "static": "friction at rest",
    "load": "friction by load",
    "bristle": "states of friction",
}
"""Laws of dry friction that formats of robots lack."""
DROPPED = {"motors": "rotors", **dict.fromkeys(SMOOTH, "creep")}
"""The part of `--drop`, if its name differs from the section, or the column, of the table."""


@dataclass(frozen=True)
class Holds:
    """Entries that a robot format can represent.

    `title` is its name, `lacks` says in words what it has not, by section or column of the table. Joints follow others
    by polynomials of at most this `degree`, which `following` states. `passive` and `any_gravity` say whether it tells
    joints with motors from others, and gravity.
    """

    title: str
    lacks: dict[str, str]
    degree: int
    following: str
    passive: bool = False
    any_gravity: bool = False


def robot_of(machine: Machine, holds: Holds) -> Description:
    """Convert a machine to a robot description; raises `InputError` that names joint, cell or parameter."""
    return _Robot(machine, holds).description


@dataclass(frozen=True)
class _Robot:
    """Conversion of a machine with numbers to a robot description."""

    machine: Machine
    holds: Holds

    @cached_property
    def description(self) -> Description:
        machine = self.machine
        self._refuse()
        body = machine.floating.body if machine.floating else Body()
        links = tuple(self._link(j, body, place) for j, body, place in ((0, body, "base"), *self._bodies()))
        joints = tuple(self._joint(j, machine.joint(j)) for j, _, _ in self._bodies())
        if machine.floating:
            links = (Link(self.world), *links)
            floating = distinct(f"{self.base}_joint", [row.name for row in machine.joints])
            damping = self._damping_of_base(machine.floating)
            joints = (LinkJoint(floating, JointType.FLOATING, self.world, self.base, damping=damping), *joints)
        connections = tuple(map(self._connection, machine.loops))
        remarks = machine.origin.notes if isinstance(machine, DescribedMachine) else ()
        gravity, frames = self._gravity(machine.base), tuple(self._other_frames())
        return Description(machine.name, links, joints, connections, gravity, remarks, frames)

    def _bodies(self) -> Iterator[tuple[int, Body, str]]:
        """Rows that are not only ends of loops: number, body and name for messages."""
        numbered = enumerate(self.machine.joints, start=1)
        yield from ((j, row.body, place_of(j, row)) for j, row in numbered if j not in self.ends)

    @cached_property
    def frames(self) -> dict[int, list[tuple[str, Placement]]]:
        """Named frames by the row that carries them: names without prefix, and placements."""
        frames: dict[int, list[tuple[str, Placement]]] = {}
        for frame in self.machine.frames:
            place = f"frame {frame.name}"
            x, y, z, *rpy = (self._number(place, cell, formula) for cell, formula in cells(frame))
            placed_frame = kind_and_name(frame.name)[1], Placement(rotation(*rpy), np.array([x, y, z]))
            frames.setdefault(self.machine.rows.get(frame.on, 0), []).append(placed_frame)
        return frames

    @cached_property
    def shifts(self) -> dict[int, Placement]:
        """Placement of a link's frame in the frame of its row, by row; identities are omitted."""
        shifts = {}
        for j, row in enumerate(self.machine.joints, start=1):
            own = dict(self.frames.get(j, ())).get(row.name)
            if own and (row.sigma != 0 or not plain(own.translation[:2], 1.0).any()):
                shifts[j] = own
        return shifts

    def _shift(self, j: int) -> Placement:
        return self.shifts.get(j, Placement())

    @cached_property
    def links(self) -> dict[int, str]:
        """Names of the links of the rows, and of frame 0."""
        rows = {joint.name for joint in self.machine.joints}
        names = {}
        for j, row in enumerate((None, *self.machine.joints)):
            moving = row is None or row.sigma != 2
            here = [name for name, at in self.frames.get(j, ()) if name not in rows and self._is_link(j, at)]
            names[j] = here[0] if moving and here else row.name if row else self._free("base")
        return names

    def _is_link(self, j: int, placement: Placement) -> bool:
        """Whether a frame coincides with the frame of a row's link."""
        between = (self._shift(j).inverse * placement).matrix - np.eye(4)
        return not plain(between, max(1.0, float(np.abs(placement.translation).max()))).any()

    def _other_frames(self) -> Iterator[PlacedFrame]:
        """Named frames other than those of links and joints."""
        fixed = {self._fixed_joint(j) for j, row in enumerate(self.machine.joints, start=1) if row.sigma == 2}
        used = {*self.links.values(), *(joint.name for joint in self.machine.joints), *fixed}
        for j, frames in self.frames.items():
            for name, place in frames:
                if name not in used or not self._is_link(j, place):
                    yield PlacedFrame(distinct(name, used), SITE, self.links[j], self._shift(j).inverse * place)
                    used.add(distinct(name, used))

    @cached_property
    def values(self) -> dict[str, float]:
        """Values of the machine's parameters."""
        return parameter_values(self.machine)

    @cached_property
    def limits(self) -> Limits:
        """Limits of the joints."""
        return limits_of(self.machine)

    @cached_property
    def base(self) -> str:
        """The name of the link whose frame is frame 0."""
        return self.links[0]

    @cached_property
    def world(self) -> str:
        """Name of the world link, in which the base floats."""
        return self._free("world")

    @cached_property
    def ends(self) -> frozenset[int]:
        """Numbers of the rows that are only ends of loops: cut joints, and frames that they meet."""
        carrying, loops = {*self.machine.antecedents}, self.machine.loops
        rows = {loop.meets: self.machine.joint(loop.meets) for loop in loops if loop.meets not in carrying}
        meeting = {j for j, row in rows.items() if row.sigma == 2 and row.body == Body()}
        return frozenset(meeting | {loop.cut for loop in loops})

    def _free(self, name: str) -> str:
        names = {joint.name for joint in self.machine.joints}
        return name if name not in names else next(f"{name}_{k}" for k in range(2, 2000) if f"{name}_{k}" not in names)

    def _refuse(self) -> None:
        """Raise `InputError` for entries that the format cannot represent."""
        machine, lacks = self.machine, self.holds.lacks
        if machine.loops and "loops" in lacks:
            raise machine.error(f"loop {machine.loops[0].name}", self._way_out("loops"))
        if machine.is_grouped:
            raise machine.error("bodies", "base parameters are not those of bodies: convert without --base")
        for j, joint in enumerate(machine.joints, start=1):
            if joint.kind is Kind.ELASTIC and "springs" in lacks:
                raise machine.error(place_of(j, joint, "kind"), f"elastic: {self._way_out('springs')}")
            if joint.kind is Kind.PASSIVE and not self.holds.passive:
                what = f"passive: {self.holds.title} cannot say which joint has no motor"
                raise machine.error(place_of(j, joint, "kind"), what)
            for cell, formula in cells(joint):
                key = cell.column.key if cell.column.key in lacks else cell.column.section
                if key in lacks and not formula.is_zero:
                    raise machine.error(place_of(j, joint, cell.label), self._way_out(key))

    def _way_out(self, key: str) -> str:
        what = f"{self.holds.title} has no {self.holds.lacks[key]}: write .toml, or leave them out"
        return f"{what} by --drop {DROPPED.get(key, key)}"

    def _damping_of_base(self, floating: Floating) -> float:
        """Damping coefficient of a free joint, equal for velocities in N s/m and N m s/rad."""
        ways = [(cell, formula) for cell, formula in cells(floating) if cell.column.section == "base"]
        damping = {cell: formula for cell, formula in ways if not formula.is_zero}
        values = {self._number("base", cell, formula) for cell, formula in damping.items()}
        if damping and "base" in self.holds.lacks:
            what = f"{self.holds.title} has no {self.holds.lacks['base']}"
        elif damping and (len(damping) < 2 or len(values) > 1):
            what = f"{self.holds.title} has one damping for both: give linear_damping and angular_damping one number"
        else:
            return max(values, default=0.0)
        raise self.machine.error(f"base, {next(iter(damping)).label}", f"{what}, write .toml, or leave it out")

    def _gravity(self, base: Base) -> tuple[float, float, float]:
        """Gravity minus the acceleration of a base without rotation, which is equivalent."""
        vectors: dict[str, list[float]] = {"gravity": [], "acceleration": []}
        for cell, formula in cells(base):
            turns = "angular" in cell.column.key
            if not formula.is_zero and (turns or (cell.column.key != "gravity" and not self.holds.any_gravity)):
                kind = "turning" if turns and self.holds.any_gravity else "moving"
                raise self.machine.error(cell.label, f"{self.holds.title} has no {kind} base: leave it out")
            if cell.column.key in vectors:
                vectors[cell.column.key].append(self._number(cell.column.key, cell, formula))
        x, y, z = (g - a for g, a in zip(vectors["gravity"], vectors["acceleration"], strict=True))
        return x, y, z

    def _number(self, place: str, cell: Cell, formula: Formula) -> float:
        """Value of a cell; raises `InputError` without one."""
        for name in sorted(formula.names - self.values.keys()):
            if name in self.machine.variables:
                what = f"{quote(formula)}: {self.holds.title} holds numbers only, nothing that changes with joints"
                raise self.machine.error(f"{place}, {cell.label}", what)
            what = f"parameter {name} in {cell.label} has no value, and {self.holds.title} holds numbers only"
            raise self.machine.error(place, f"{what}: give it one")
        with refusing(self.machine.label, f"{place}, {cell.label}"):
            return formula.table_value(self.values)

    def _link(self, j: int, body: Body, place: str) -> Link:
        """Link of a body, with its inertia about its centre of mass."""
        name, into = self.links[j], self._shift(j).inverse
        if body == Body():
            return Link(name)
        mass, *numbers = (self._number(place, cell, formula) for cell, formula in cells(body))
        moments, (xx, xy, xz, yy, yz, zz) = np.array(numbers[:3]), numbers[3:]
        inertia = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        center = moments
        if not body.central and mass:
            center = moments / mass
            inertia = inertia - mass * (center @ center * np.eye(3) - np.outer(center, center))
        elif not body.central and moments.any():
            what = f"first moments without mass: {self.holds.title} has a mass and its centre"
            raise self.machine.error(place, what)
        center = into.rotation @ center + into.translation
        return Link(name, mass, center, into.rotation @ inertia @ into.rotation.T, frame_only=False)

    def _joint(self, j: int, row: Joint) -> LinkJoint:
        place, law = place_of(j, row), self._law(j, row)
        parent, child, shift = self._carrier(row), self.links[j], self._shift(j)
        at = self._placement(row, place, float(law.coef[0]) if law else None)
        placement = self._shift(row.antecedent).inverse * at * shift
        if row.sigma == 2:
            return LinkJoint(self._fixed_joint(j), JointType.FIXED, parent, child, placement)
        follows = None
        if law:
            leader = next(iter(row.selected.names & self.machine.variables.keys()))
            multiplier, *powers = map(float, law.coef[1:])
            follows = Mimicked(self.machine.joint(self.machine.variables[leader]).name, multiplier, 0.0, tuple(powers))
        forces = self._forces(row, place)
        forces |= {"driven": row.kind is Kind.MOTOR, "limits": self.limits.of(row.name)}
        axis = shift.rotation.T @ Z
        return LinkJoint(row.name, TYPES[row.sigma], parent, child, placement, axis, **forces, follows=follows)

    def _fixed_joint(self, j: int) -> str:
        """Name of a fixed joint: that of a named frame at the place of its link, else that of the link."""
        names = {joint.name for joint in self.machine.joints}
        here = [name for name, at in self.frames.get(j, ()) if name not in names and self._is_link(j, at)]
        return here[0] if here else self.links[j]

    def _forces(self, row: Joint, place: str) -> dict[str, Any]:
        """The forces on a joint that moves, as fields of its `LinkJoint`."""
        spring = {cell.name: self._number(place, cell, formula) for cell, formula in cells(row.spring)}
        friction = {cell.name: self._number(place, cell, formula) for cell, formula in cells(row.friction)}
        reflected = next(cell for cell, _ in cells(row) if cell.column.section == "motors")
        return {
            "stiffness": spring["stiffness"],
            "neutral": spring["neutral"],
            "damping": spring["damping"] + friction["viscous"],
            "friction": friction["coulomb"],
            "rotor_inertia": self._number(place, reflected, row.reflected_inertia),
        }

    def _carrier(self, row: Joint) -> str:
        return self.links[row.antecedent]

    def _placement(self, row: Joint, place: str, offset: float | None = None) -> Placement:
        """Placement of the row at position 0; `offset` replaces a formula in the cell that sigma selects."""
        numbers = {}
        for cell, formula in cells(row):
            if cell.column.section == "joints":
                is_offset = offset is not None and cell.column.key == SELECTED[row.sigma]
                numbers[cell.column.key] = offset if is_offset else self._number(place, cell, formula)
        keys = ("gamma", "b", "alpha", "d", "theta", "r")
        gamma, b, alpha, d, theta, r = (float(numbers[key] or 0.0) for key in keys)
        return about_z(gamma, b) * about_x(alpha, d) * about_z(theta, r)

    def _law(self, j: int, row: Joint) -> Polynomial | None:
        """Polynomial that a coupled joint follows; None for other joints.

        Raises `InputError` for other couplings, and for one in addition to an own variable.
        """
        names = row.selected.names & self.machine.variables.keys()
        if not names:
            return None
        alone = row.kind is Kind.COUPLED and len(names) == 1
        law = polynomial(row.selected, self.values, *names) if alone else None
        if law is None or not 0 < law.degree() <= self.holds.degree:
            what = f"{quote(row.selected)}: {self.holds.title} has {self.holds.following}, no other couplings"
            raise self.machine.error(place_of(j, row, SELECTED[row.sigma]), what)
        return law

    def _connection(self, loop: Loop) -> Connection:
        """Connection of the two frames that coincide in a loop."""
        place, cut, end = f"loop {loop.name}", self.machine.joint(loop.cut), self.machine.joint(loop.meets)
        if cut.sigma == 1 and loop.closes is Closing.FRAME:
            what = f"its cut joint {cut.name} slides, which {self.holds.title} has not: cut it at a joint that turns"
            raise self.machine.error(place, what)
        holding = Holding.POINT if loop.closes is Closing.POINT else Holding.FRAME if cut.sigma == 2 else Holding.AXIS
        on_cut = self._shift(cut.antecedent).inverse * self._placement(cut, place_of(loop.cut, cut))
        second, on_end = self.links[loop.meets], self._shift(loop.meets).inverse
        if loop.meets in self.ends:
            at = self._placement(end, place_of(loop.meets, end))
            second, on_end = self._carrier(end), self._shift(end.antecedent).inverse * at
        owners = {variable: self.machine.joint(j).name for variable, j in self.machine.variables.items()}
        start = {owners[x]: formula.value(self.values) for x, formula in loop.start.items() if x in owners}
        return Connection(loop.name, self._carrier(cut), second, on_cut, on_end, holding, start)


def polynomial(formula: Formula, values: dict[str, float], name: str) -> Polynomial | None:
    """Expand a formula to a polynomial of one name, others by their values; None if it is no polynomial."""
    try:
        names = {"pi": np.pi, **values, name: Polynomial([0.0, 1.0])}
        value = formula.evaluate(names, {name: _of_numbers(name) for name in FUNCTIONS})
    except (FormulaError, ArithmeticError, KeyError, TypeError, ValueError):
        return None
    return value.trim() if isinstance(value, Polynomial) and np.isfinite(value.coef).all() else None


def _of_numbers(name: str) -> Any:
    """Return the formula function with this name, such as sin, for numerical arguments only."""

    def value(*arguments: Any) -> float:
        tree = (name, *(("name", f"x{k}") for k in range(len(arguments))))
        return Formula(name, tree).value({f"x{k}": float(x) for k, x in enumerate(arguments)})

    return value


def with_frames_as_links(robot: Description) -> Description:
    """Return the robot with frames as massless links on fixed joints; of two that coincide, one names the joint."""
    places: list[list[PlacedFrame]] = []
    for frame in robot.frames:
        same = (x for x in places if x[0].link == frame.link and len(x) == 1)
        pair = next((x for x in same if np.array_equal(x[0].placement.matrix, frame.placement.matrix)), None)
        if pair:
            pair.append(frame)
        else:
            places.append([frame])
    names = {joint.name for joint in robot.joints}
    links = tuple(Link(frames[0].name) for frames in places)
    joints = (
        LinkJoint(
            frames[-1].name if len(frames) > 1 else distinct(f"{frames[0].name}_fixed", names),
            JointType.FIXED,
            frames[0].link,
            frames[0].name,
            frames[0].placement,
        )
        for frames in places
    )
    return replace(robot, links=(*robot.links, *links), joints=(*robot.joints, *joints), frames=())


def size_of(robot: Description) -> float:
    """Size of a robot: largest coordinate of a joint in the preceding joint's frame, m; 1 if all are zero."""
    return max((float(np.abs(joint.placement.translation).max()) for joint in robot.joints), default=0.0) or 1.0


def notes_of(robot: Description) -> Iterator[str]:
    """Notes as texts of XML comments: without `--` and characters that XML does not allow."""
    for note in robot.remarks:
        plain = "".join(x if x.isprintable() else " " for x in note)
        yield f" {plain.replace('--', '- -').replace('--', '- -')} "


def numbers_text(numbers: Array | list[float] | tuple[float, ...]) -> str:
    """Numbers as text, in full precision."""
    return " ".join(repr(float(x) + 0.0) for x in numbers)


def plain(numbers: Array, size: float = 1.0) -> Array:
    """Numbers with rounding errors of zeros removed, which are small relative to `size`."""
    return np.where(np.abs(numbers) <= ROUNDING * size, 0.0, numbers)
