"""A machine as links and joints in numbers: the way back from the table, for formats that are written.

Each row is a link on a joint, in the frame of the row, and both have its name. Ends of loops that are nothing else are
parts of their loops. What a format lacks is refused by the joint.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.polynomial import Polynomial

from symoro_elastic.formats.robots.displacements import about_x, about_z
from symoro_elastic.formats.robots.robot import (
    Connection,
    Description,
    Holding,
    JointType,
    Link,
    LinkJoint,
    Mimicked,
    Placement,
)
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.machine.checks import parameter_values, place_of
from symoro_elastic.machine.columns import Cell, cells
from symoro_elastic.machine.described import DescribedMachine, limits_of
from symoro_elastic.machine.formula import FUNCTIONS, Formula, FormulaError
from symoro_elastic.machine.joints import SELECTED
from symoro_elastic.machine.limits import Limits
from symoro_elastic.machine.loops import Closing, Loop
from symoro_elastic.machine.machine import Base, Body, Joint, Kind, Machine
from symoro_elastic.machine.names import distinct, quote

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
"""The part of `--drop` where it is not called as the section, or the column, of the table."""


@dataclass(frozen=True)
class Holds:
    """What a format of robots can say.

    `title` is its name, `lacks` says in words what it has not, by section or column of the table. Joints follow others
    by polynomials of at most this `degree`, which `following` says. `passive` and `any_gravity` say whether it tells
    joints with motors from others, and gravity.
    """

    title: str
    lacks: dict[str, str]
    degree: int
    following: str
    passive: bool = False
    any_gravity: bool = False


def robot_of(machine: Machine, holds: Holds) -> Description:
    """The robot that a machine is; raises `InputError` that names the joint, the cell or the parameter."""
    return _Robot(machine, holds).description


@dataclass(frozen=True)
class _Robot:
    """A machine on the way to its description."""

    machine: Machine
    holds: Holds

    @cached_property
    def description(self) -> Description:
        machine = self.machine
        self._refuse()
        rows = [(j, row) for j, row in enumerate(machine.joints, start=1) if j not in self.ends]
        body = machine.floating.body if machine.floating else Body()
        links = (self._link(self.base, body, "base"), *(self._link(r.name, r.body, place_of(j, r)) for j, r in rows))
        joints = tuple(self._joint(j, row) for j, row in rows)
        if machine.floating:
            links = (Link(self.world), *links)
            floating = distinct(f"{self.base}_joint", [row.name for row in machine.joints])
            joints = (LinkJoint(floating, JointType.FLOATING, self.world, self.base), *joints)
        connections = tuple(map(self._connection, machine.loops))
        remarks = machine.origin.notes if isinstance(machine, DescribedMachine) else ()
        return Description(machine.name, links, joints, connections, self._gravity(machine.base), remarks)

    @cached_property
    def values(self) -> dict[str, float]:
        """Values of the parameters."""
        return parameter_values(self.machine)

    @cached_property
    def limits(self) -> Limits:
        """Limits of its joints."""
        return limits_of(self.machine)

    @cached_property
    def base(self) -> str:
        """A name for the link whose frame is frame 0."""
        return self._free("base")

    @cached_property
    def world(self) -> str:
        """A name for the link in which the base floats."""
        return self._free("world")

    @cached_property
    def ends(self) -> frozenset[int]:
        """Numbers of the rows that are ends of loops and nothing else: cut joints, and frames that they meet."""
        carrying = {*self.machine.antecedents}
        meeting = {
            loop.meets
            for loop in self.machine.loops
            if loop.meets not in carrying and self._is_frame(self.machine.joint(loop.meets))
        }
        return frozenset(meeting | {loop.cut for loop in self.machine.loops})

    def _free(self, name: str) -> str:
        names = {joint.name for joint in self.machine.joints}
        return name if name not in names else next(f"{name}_{k}" for k in range(2, 2000) if f"{name}_{k}" not in names)

    def _is_frame(self, row: Joint) -> bool:
        return row.sigma == 2 and row.body == Body()

    def _refuse(self) -> None:
        """Raise `InputError` for what the format lacks."""
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

    def _gravity(self, base: Base) -> tuple[float, float, float]:
        """Gravity, less the acceleration of a base that moves without turning, which has the same effect."""
        found: dict[str, list[float]] = {"gravity": [], "acceleration": []}
        for cell, formula in cells(base):
            turns = "angular" in cell.column.key
            if not formula.is_zero and (turns or (cell.column.key != "gravity" and not self.holds.any_gravity)):
                kind = "turning" if turns and self.holds.any_gravity else "moving"
                raise self.machine.error(cell.label, f"{self.holds.title} has no {kind} base: leave it out")
            if cell.column.key in found:
                found[cell.column.key].append(self._number(cell.column.key, cell, formula))
        x, y, z = (g - a for g, a in zip(found["gravity"], found["acceleration"], strict=True))
        return x, y, z

    def _number(self, place: str, cell: Cell, formula: Formula) -> float:
        """The value of a cell."""
        for name in sorted(formula.names - self.values.keys()):
            if name in self.machine.variables:
                what = f"{quote(formula)}: {self.holds.title} holds numbers only, nothing that changes with joints"
                raise self.machine.error(f"{place}, {cell.label}", what)
            what = f"parameter {name} in {cell.label} has no value, and {self.holds.title} holds numbers only"
            raise self.machine.error(place, f"{what}: give it one")
        try:
            return formula.table_value(self.values)
        except FormulaError as error:
            raise self.machine.error(f"{place}, {cell.label}", str(error)) from None

    def _link(self, name: str, body: Body, place: str) -> Link:
        """The link of a body, with its inertia about its centre of mass."""
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
        return Link(name, mass, center, inertia, frame_only=False)

    def _joint(self, j: int, row: Joint) -> LinkJoint:
        place, law = place_of(j, row), self._law(j, row)
        parent = self._carrier(row)
        given = self._placement(row, place, float(law.coef[0]) if law else None)
        if row.sigma == 2:
            return LinkJoint(row.name, JointType.FIXED, parent, row.name, given)
        follows = None
        if law:
            leader = next(iter(row.selected.names & self.machine.variables.keys()))
            multiplier, *powers = map(float, law.coef[1:])
            follows = Mimicked(self.machine.joint(self.machine.variables[leader]).name, multiplier, 0.0, tuple(powers))
        forces = self._forces(row, place)
        forces |= {"driven": row.kind is Kind.MOTOR, "limits": self.limits.of(row.name)}
        return LinkJoint(row.name, TYPES[row.sigma], parent, row.name, given, Z, **forces, follows=follows)

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
        return self.machine.joint(row.antecedent).name if row.antecedent else self.base

    def _placement(self, row: Joint, place: str, offset: float | None = None) -> Placement:
        """Placement of the row at position 0; `offset` stands for a formula in the cell that sigma selects."""
        found = {}
        for cell, formula in cells(row):
            if cell.column.section == "joints":
                given = offset is not None and cell.column.key == SELECTED[row.sigma]
                found[cell.column.key] = offset if given else self._number(place, cell, formula)
        gamma, b, alpha, d, theta, r = (float(found[key] or 0.0) for key in ("gamma", "b", "alpha", "d", "theta", "r"))
        return about_z(gamma, b) * about_x(alpha, d) * about_z(theta, r)

    def _law(self, j: int, row: Joint) -> Polynomial | None:
        """What a coupled joint follows, a polynomial of one variable; None for others.

        Raises `InputError` for other couplings, and for one beside a variable of its own.
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
        """The two frames that a loop makes coincide."""
        place, cut, end = f"loop {loop.name}", self.machine.joint(loop.cut), self.machine.joint(loop.meets)
        if cut.sigma == 1 and loop.closes is Closing.FRAME:
            what = f"its cut joint {cut.name} slides, which {self.holds.title} has not: cut it at a joint that turns"
            raise self.machine.error(place, what)
        holding = Holding.POINT if loop.closes is Closing.POINT else Holding.FRAME if cut.sigma == 2 else Holding.AXIS
        on_cut = self._placement(cut, place_of(loop.cut, cut))
        second, on_end = end.name, Placement()
        if loop.meets in self.ends:
            second, on_end = self._carrier(end), self._placement(end, place_of(loop.meets, end))
        owners = {variable: self.machine.joint(j).name for variable, j in self.machine.variables.items()}
        start = {owners[x]: formula.value(self.values) for x, formula in loop.start.items() if x in owners}
        return Connection(loop.name, self._carrier(cut), second, on_cut, on_end, holding, start)


def polynomial(formula: Formula, values: dict[str, float], name: str) -> Polynomial | None:
    """A formula as a polynomial of one name, the others have values; None for one that is none."""
    try:
        names = {"pi": np.pi, **values, name: Polynomial([0.0, 1.0])}
        found = formula.evaluate(names, {each: _of_numbers(each) for each in FUNCTIONS})
    except (FormulaError, ArithmeticError, KeyError, TypeError, ValueError):
        return None
    return found.trim() if isinstance(found, Polynomial) and np.isfinite(found.coef).all() else None


def _of_numbers(name: str) -> Any:
    """A function of formulas, of numbers only."""

    def value(*arguments: Any) -> float:
        tree = (name, *(("name", f"x{k}") for k in range(len(arguments))))
        return Formula(name, tree).value({f"x{k}": float(x) for k, x in enumerate(arguments)})

    return value


def size_of(robot: Description) -> float:
    """The largest coordinate of a joint in the frame of the one before, m; 1 where all are zero."""
    return max((float(np.abs(joint.placement.translation).max()) for joint in robot.joints), default=0.0) or 1.0


def notes_of(robot: Description) -> Iterator[str]:
    """Notes as texts of XML comments: without `--`, and without what XML cannot hold."""
    for note in robot.remarks:
        plain = "".join(x if x.isprintable() else " " for x in note)
        yield f" {plain.replace('--', '- -').replace('--', '- -')} "


def numbers_text(numbers: Array | list[float] | tuple[float, ...]) -> str:
    """Numbers as text that is read back to the last digit."""
    return " ".join(repr(float(x) + 0.0) for x in numbers)
