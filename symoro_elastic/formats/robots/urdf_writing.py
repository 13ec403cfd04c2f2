"""A machine as URDF: its frames as links, modified Denavit-Hartenberg parameters as origins.

URDF has numbers only, no springs, no rotors, no loops, and no gravity: readers take 9.81 m/s2 against z. What it lacks
is refused by the joint. Limits that it demands and the machine does not have are too far to be reached.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from xml.etree.ElementTree import Element, SubElement, indent, tostring

import numpy as np

from symoro_elastic.formats.robots.displacements import ROUNDING, about_x, about_z
from symoro_elastic.formats.robots.robot import Placement
from symoro_elastic.formats.robots.urdf import EITHER_WAY, FAR
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.machine.checks import parameter_values, place_of
from symoro_elastic.machine.columns import Cell, cells
from symoro_elastic.machine.described import limits_of
from symoro_elastic.machine.formula import Formula, FormulaError, Tree
from symoro_elastic.machine.joints import SELECTED
from symoro_elastic.machine.limits import JointLimits, Limits
from symoro_elastic.machine.machine import Base, Body, Joint, Kind, Machine
from symoro_elastic.machine.names import quote

GRAVITY = (0.0, 0.0, -9.81)
EXPRESSED = (Kind.MOTOR, Kind.COUPLED, Kind.FIXED)
NOT_EXPRESSED = {
    "springs": "URDF has no springs: write .toml, or leave them out by --drop springs",
    "motors": "URDF has no rotors: write .toml, or leave them out by --drop rotors",
    "wrenches": "URDF has no forces on bodies: leave them out, or write .toml",
}


def write(machine: Machine) -> str:
    """The URDF text of a machine; raises `InputError` that names the joint, the cell or the parameter."""
    return _Writer(machine).text


@dataclass(frozen=True)
class Following:
    """A position in proportion to a variable: factor times it plus offset."""

    variable: str
    factor: float
    offset: float


@dataclass(frozen=True)
class _Writer:
    """A machine on the way to URDF."""

    machine: Machine

    @cached_property
    def text(self) -> str:
        self._refuse_what_urdf_lacks()
        robot = Element("robot", name=self.machine.name)
        if self.machine.floating:
            SubElement(robot, "link", name=self.world)
            joint = SubElement(robot, "joint", name=f"{self.base}_joint", type="floating")
            SubElement(joint, "parent", link=self.world)
            SubElement(joint, "child", link=self.base)
        self._link(robot, self.base, self.machine.floating.body if self.machine.floating else Body(), "base")
        for j, row in enumerate(self.machine.joints, start=1):
            self._link(robot, row.name, row.body, place_of(j, row))
            self._joint(robot, j, row)
        indent(robot)
        return '<?xml version="1.0"?>\n' + tostring(robot, encoding="unicode") + "\n"

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

    def _free(self, name: str) -> str:
        names = {joint.name for joint in self.machine.joints}
        return name if name not in names else next(f"{name}_{k}" for k in range(2, 2000) if f"{name}_{k}" not in names)

    def _refuse_what_urdf_lacks(self) -> None:
        machine = self.machine
        if machine.loops:
            raise machine.error(f"loop {machine.loops[0].name}", "URDF has no closed loops: write .toml")
        if machine.is_grouped:
            raise machine.error("bodies", "base parameters are not those of bodies: convert without --base")
        for j, joint in enumerate(machine.joints, start=1):
            if joint.kind not in EXPRESSED:
                what = (
                    NOT_EXPRESSED["springs"]
                    if joint.kind is Kind.ELASTIC
                    else "URDF cannot say which joint has no motor"
                )
                raise machine.error(place_of(j, joint, "kind"), f"{joint.kind.value}: {what}")
            for cell, formula in cells(joint):
                if cell.column.section in NOT_EXPRESSED and not formula.is_zero:
                    raise machine.error(place_of(j, joint, cell.label), NOT_EXPRESSED[cell.column.section])
            if not joint.friction.creep.is_zero:
                raise machine.error(place_of(j, joint, "creep"), "URDF has no such friction: leave it out")
        self._refuse_base(machine.base)

    def _refuse_base(self, base: Base) -> None:
        for cell, formula in cells(base):
            if cell.column.key != "gravity" and not formula.is_zero:
                raise self.machine.error(cell.label, "URDF has no moving base: leave it out")
        gravity = tuple(self._number("gravity", cell, x) for cell, x in cells(base) if cell.column.key == "gravity")
        if gravity != GRAVITY:
            shown = ", ".join(f"{x:g}" for x in gravity)
            what = f"it is [{shown}], but readers of URDF take [0, 0, -9.81]: turn frame 0, and give this gravity"
            raise self.machine.error("gravity", what)

    def _number(self, place: str, cell: Cell, formula: Formula) -> float:
        for name in sorted(formula.names - self.values.keys()):
            what = f"parameter {name} in {cell.label} has no value, and URDF holds numbers only: give it one"
            raise self.machine.error(place, what)
        try:
            return formula.table_value(self.values)
        except FormulaError as error:
            raise self.machine.error(f"{place}, {cell.label}", str(error)) from None

    def _link(self, robot: Element, name: str, body: Body, place: str) -> None:
        link = SubElement(robot, "link", name=name)
        if body == Body():
            return
        mass, center, inertia = self._about_center(body, place)
        inertial = SubElement(link, "inertial")
        SubElement(inertial, "origin", xyz=_text(center), rpy="0 0 0")
        SubElement(inertial, "mass", value=_text([mass]))
        entries = {f"i{'xyz'[i]}{'xyz'[k]}": _text([inertia[i, k]]) for i in range(3) for k in range(i, 3)}
        SubElement(inertial, "inertia", entries)

    def _about_center(self, body: Body, place: str) -> tuple[float, Array, Array]:
        """Mass, centre of mass and inertia about it."""
        mass, *numbers = (self._number(place, cell, formula) for cell, formula in cells(body))
        moments, (xx, xy, xz, yy, yz, zz) = np.array(numbers[:3]), numbers[3:]
        inertia = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        if body.central:
            return mass, moments, inertia
        if not mass:
            if moments.any():
                raise self.machine.error(place, "first moments without mass: URDF has a mass and its centre")
            return mass, moments, inertia
        center = moments / mass
        return mass, center, inertia - mass * (center @ center * np.eye(3) - np.outer(center, center))

    def _joint(self, robot: Element, j: int, row: Joint) -> None:
        place = place_of(j, row)
        followed = self._followed(j, row)
        limits = self.limits.of(row.name)
        types = {0: "revolute" if limits.position else "continuous", 1: "prismatic", 2: "fixed"}
        joint = SubElement(robot, "joint", name=row.name, type=types[row.sigma])
        origin = self._origin(row, place, followed.offset if followed else None)
        SubElement(joint, "origin", xyz=_text(origin.translation), rpy=_text(rpy_of(origin.rotation)))
        SubElement(joint, "parent", link=self.machine.joint(row.antecedent).name if row.antecedent else self.base)
        SubElement(joint, "child", link=row.name)
        if row.sigma == 2:
            return
        SubElement(joint, "axis", xyz="0 0 1")
        if row.sigma == 1 or limits:
            SubElement(joint, "limit", self._limit(limits, place, is_endless=not (row.sigma or limits.position)))
        friction = {cell.name: self._number(place, cell, formula) for cell, formula in cells(row.friction)}
        if any(friction.values()):
            SubElement(joint, "dynamics", damping=_text([friction["viscous"]]), friction=_text([friction["coulomb"]]))
        if followed:
            leader = self.machine.joint(self.machine.variables[followed.variable]).name
            SubElement(joint, "mimic", joint=leader, multiplier=_text([followed.factor]), offset="0")

    def _limit(self, limits: JointLimits, place: str, is_endless: bool) -> dict[str, str]:
        """The attributes of a limit: those that URDF demands, and what else there is."""
        found = {"lower": -FAR, "upper": FAR, "effort": FAR, "velocity": FAR}
        if is_endless:
            del found["lower"], found["upper"]
        if limits.position:
            found |= {"lower": limits.position.low, "upper": limits.position.high}
        for key, quantity in EITHER_WAY.items():
            given = getattr(limits, quantity)
            if given is None:
                continue
            if not given.is_symmetric:
                what = f"[{given.low:g}, {given.high:g}]: URDF has one number either way: give one, or write .toml"
                raise self.machine.error(f"{place}, limits, {quantity}", what)
            found[key] = given.high
        return {key: _text([x]) for key, x in found.items()}

    def _origin(self, row: Joint, place: str, offset: float | None) -> Placement:
        """Placement of the row at position 0; `offset` stands for a formula in the cell that sigma selects."""
        found = {}
        for cell, formula in cells(row):
            if cell.column.section == "joints":
                given = offset is not None and cell.column.key == SELECTED[row.sigma]
                found[cell.column.key] = offset if given else self._number(place, cell, formula)
        gamma, b, alpha, d, theta, r = (float(found[key] or 0.0) for key in ("gamma", "b", "alpha", "d", "theta", "r"))
        return about_z(gamma, b) * about_x(alpha, d) * about_z(theta, r)

    def _followed(self, j: int, row: Joint) -> Following | None:
        """What a coupled joint follows; None for others.

        Raises `InputError` where it is not one variable in proportion, or stands beside a variable of its own.
        """
        names = row.selected.names & self.machine.variables.keys()
        if not names:
            return None
        found = _linear(row.selected.tree, self.values, names) if row.kind is Kind.COUPLED and len(names) == 1 else None
        if found is None:
            what = f"{quote(row.selected)}: URDF has joints that follow one other in proportion, no other couplings"
            raise self.machine.error(place_of(j, row, SELECTED[row.sigma]), what)
        (variable,), (factor, offset) = names, found
        return Following(variable, factor, offset)


def _linear(tree: Tree, values: Mapping[str, float], names: frozenset[str]) -> tuple[float, float] | None:
    """Factor and offset of a formula that is linear in the only one of these names; None for others."""
    if tree[0] == "name" and tree[1] in names:
        return 1.0, 0.0
    if tree[0] in ("+", "-", "neg", "*", "/"):
        parts = [_linear(part, values, names) for part in tree[1:]]
        if None in parts:
            return None
        return _combined(tree[0], *(part for part in parts if part))
    if any(name in names for name in _names(tree)):
        return None
    try:
        return 0.0, Formula("", tree).value(values)
    except (FormulaError, KeyError):
        return None


def _combined(
    operation: str, first: tuple[float, float], second: tuple[float, float] = (0.0, 0.0)
) -> tuple[float, float] | None:
    (m, c), (n, e) = first, second
    if operation == "neg":
        return -m, -c
    if operation in "+-":
        sign = 1.0 if operation == "+" else -1.0
        return m + sign * n, c + sign * e
    if operation == "*":
        return None if m and n else (m * e + n * c, c * e)
    return None if n or not e else (m / e, c / e)


def _names(tree: Tree) -> Iterator[str]:
    if tree[0] == "name":
        yield tree[1]
    for part in tree[1:]:
        if isinstance(part, tuple):
            yield from _names(part)


def rpy_of(rotation: Array) -> tuple[float, float, float]:
    """Roll, pitch and yaw, rad, of a rotation (3, 3): Rot(z, yaw) Rot(y, pitch) Rot(x, roll).

    Roll is that of what is left after yaw and pitch, so the three are right together where the pitch is a quarter turn.
    """
    (xx, _, _), (yx, _, _), (zx, _, _) = rotation
    level = math.hypot(xx, yx)
    yaw = math.atan2(yx, xx) if level > ROUNDING else 0.0
    pitch = math.atan2(-zx, level)
    left = about_z(-yaw, 0.0).rotation @ rotation
    return math.atan2(-left[1, 2], left[1, 1]), pitch, yaw


def _text(numbers: Array | list[float] | tuple[float, ...]) -> str:
    return " ".join(repr(float(x) + 0.0) for x in numbers)
