"""Tables of Denavit-Hartenberg parameters as links and joints.

Standard (distal) ones, row i: A_i = Rot(z, theta) Trans(z, d) Trans(x, a) Rot(x, alpha), joint i about or along z of
frame i - 1, link i and its inertia in frame i. Modified (proximal) ones are A_i = Rot(x, alpha) Trans(x, a)
Rot(z, theta) Trans(z, d), joint i about or along z of frame i. A flipped joint moves about or along -z.
"""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from symoro_elastic.formats.files import name_of
from symoro_elastic.formats.robots.joint_tree import about_x, about_z
from symoro_elastic.formats.robots.robot import Description, JointType, Link, LinkJoint, PlacedFrame, Placement
from symoro_elastic.formats.separated import COMMA, Decimals, separator_of
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.errors import TWICE, InputError, refusing
from symoro_elastic.machine import formula
from symoro_elastic.machine.names import did_you_mean, quote
from symoro_elastic.machine.rounded_angles import part_of_turn, remark_on
from symoro_elastic.quantities.frames import JOINT, LINK
from symoro_elastic.quantities.unit_reader import conversion

GRAVITY = (0.0, 0.0, -9.81)
BASE, TOOL = "base", "tool"
TENSOR = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
MOST_ROWS = 1000
CONVENTION = "convention"
SETTING = re.compile(r"\s*#\s*(?P<key>convention|gravity)\s*[=:]\s*(?P<value>.+?)\s*", re.IGNORECASE)
READ_AS_STANDARD = (
    "no convention is given: read as standard (distal) parameters, Rot(z, theta) Trans(z, d) Trans(x, a) "
    "Rot(x, alpha); write '# convention = standard' or '# convention = modified' above the table"
)


@dataclass(frozen=True, eq=False)
class DistalLink:
    """A row of a standard DH table: joint and link, SI units, rad.

    `theta` or `d`, whichever the joint varies, is the offset at position 0. `center` (3,) and `inertia` (3, 3), about
    the centre of mass, are in the frame of the link. `rotor_inertia`, `viscous` and `coulomb` are as the joint feels
    them.
    """

    name: str
    type: JointType = JointType.REVOLUTE
    theta: float = 0.0
    d: float = 0.0
    a: float = 0.0
    alpha: float = 0.0
    mass: float = 0.0
    center: Array = field(default_factory=lambda: np.zeros(3))
    inertia: Array = field(default_factory=lambda: np.zeros((3, 3)))
    rotor_inertia: float = 0.0
    viscous: float = 0.0
    coulomb: float = 0.0
    modified: bool = False
    flipped: bool = False

    @property
    def along_z(self) -> Placement:
        """Placement Rot(z, theta) Trans(z, d)."""
        return about_z(self.theta, self.d)

    @property
    def along_x(self) -> Placement:
        """Placement Rot(x, alpha) Trans(x, a)."""
        return about_x(self.alpha, self.a)

    @property
    def before(self) -> Placement:
        """Placement of the joint's axis, at position 0, in the frame of the preceding link."""
        return self.along_x * self.along_z if self.modified else self.along_z

    @property
    def after(self) -> Placement:
        """Placement of the link's frame in the frame of the joint's axis."""
        return Placement() if self.modified else self.along_x


def describe_links(
    name: str,
    rows: Iterable[DistalLink],
    base: Placement | None = None,
    tool: Placement | None = None,
    gravity: tuple[float, float, float] = GRAVITY,
) -> Description:
    """Robot with these rows; `base` is the placement of frame 0 in the world, `tool` of the tool in the last frame.

    The frame of a row has the name of its joint. `gravity` is in axes of the world.
    """
    links, joints, frames, after, parent = [Link(BASE)], [], [], base or Placement(), BASE
    for row in rows:
        place, child = row.after, f"link {len(links)}"
        inertia = place.rotation @ row.inertia @ place.rotation.T
        center = place.rotation @ row.center + place.translation
        links.append(Link(child, row.mass, center, inertia, frame_only=False))
        joints.append(_joint(row, parent, child, after * row.before))
        frames.append(PlacedFrame(row.name, JOINT, child, place))
        after, parent = place, child
    links.append(Link(TOOL))
    joints.append(LinkJoint("tool joint", JointType.FIXED, parent, TOOL, after * (tool or Placement())))
    frames.append(PlacedFrame(TOOL, LINK, TOOL))
    return Description(name, tuple(links), tuple(joints), gravity=gravity, frames=tuple(frames))


def _joint(row: DistalLink, parent: str, child: str, place: Placement) -> LinkJoint:
    if row.type is JointType.FIXED:
        return LinkJoint(row.name, row.type, parent, child, place)
    axis = np.array([0.0, 0.0, -1.0 if row.flipped else 1.0])
    return LinkJoint(
        *(row.name, row.type, parent, child, place, axis),
        damping=row.viscous,
        friction=row.coulomb,
        rotor_inertia=row.rotor_inertia,
    )


def describe(text: str, source: str) -> Description:
    """Read the robot in a CSV table: a header, then a row for each joint; raises `InputError` naming the line.

    Comments `# convention = modified` and `# gravity = 0, -9.81, 0` hold for the whole table.
    """
    settings = dict(_settings(text, source))
    written = [line for line in text.splitlines() if line.strip() and not line.lstrip().startswith("#")]
    separator = separator_of(written[0] if written else "")
    with refusing(source, "file", "is not a table of columns: ", csv.Error):
        lines = list(csv.reader(written, delimiter=separator))
    if separator != COMMA:
        lines = [*lines[:1], *_with_points(lines[1:], source)]
    if len(lines) < 2:
        raise InputError(source, "line 1", "the table needs a header line and a row for each joint")
    if len(lines) > MOST_ROWS:
        raise InputError(source, f"line {MOST_ROWS}", f"more than {MOST_ROWS} rows")
    columns = [_column(word, source) for word in lines[0]]
    names = [column.name for column, _ in columns]
    for required in ("d", "a", "alpha"):
        if required not in names:
            raise InputError(source, "line 1", f"the column {required} is missing")
    for column in names:
        if names.count(column) > 1:
            raise InputError(source, "line 1", f"the column {column} {TWICE}")
    convention = settings.get(CONVENTION, "")
    rows = [_row(cells, columns, k, source, convention) for k, cells in enumerate(lines[1:], start=1)]
    exact = [replace(row, theta=part_of_turn(row.theta), alpha=part_of_turn(row.alpha)) for row in rows]
    before, after = (np.array([(row.theta, row.alpha) for row in x]) for x in (rows, exact))
    errors = np.abs(after - before)
    remarks: tuple[str, ...] = () if convention or CONVENTION in names else (READ_AS_STANDARD,)
    remarks += (remark_on(errors[errors > 0]),) if errors.any() else ()
    robot = describe_links(name_of(Path(source).stem), exact, gravity=settings.get("gravity", GRAVITY))
    return replace(robot, remarks=(*robot.remarks, *remarks))


def _settings(text: str, source: str) -> Iterator[tuple[str, Any]]:
    """Settings in comments: the convention of all rows, and gravity in axes of frame 0, m/s2."""
    for number, line in enumerate(text.splitlines(), start=1):
        if not (setting := SETTING.fullmatch(line)):
            continue
        key, value = setting["key"].lower(), setting["value"]
        if key == CONVENTION:
            yield key, _convention(value, f"line {number}", source)
            continue
        try:
            x, y, z = map(formula.number, re.split(r"[,;\s]+", value.strip("[]{}() ")))
        except (formula.FormulaError, ValueError):
            what = f"{quote(value)}: gravity has three numbers, m/s2, as in # gravity = 0, 0, -9.81"
            raise InputError(source, f"line {number}", what) from None
        yield key, (x, y, z)


def _convention(text: str, place: str, source: str) -> str:
    word = text.strip().lower()
    if word not in CONVENTIONS:
        raise InputError(source, place, f"{CONVENTION} = {quote(text)} must be one of {', '.join(CONVENTIONS)}")
    return word


def _with_points(rows: Iterable[Sequence[str]], source: str) -> Iterator[list[str]]:
    decimals = Decimals()
    for number, cells in enumerate(rows, start=1):
        with refusing(source, f"row {number}"):
            row = decimals.with_points(cells)
        yield row


def _column(word: str, source: str) -> tuple[DistalColumn, float]:
    """Return a column from its header, and the factor of its numbers; a unit may follow in brackets."""
    match = re.fullmatch(r"(\w+)\s*(?:[\[(](.+)[\])])?", word.strip())
    by_name = {column.name: column for column in COLUMNS}
    if not match or match[1] not in by_name:
        names = did_you_mean(match[1] if match else word, by_name)
        raise InputError(source, "line 1", f"{quote(word.strip())} is not a column of a table{names}")
    column, unit = by_name[match[1]], (match[2] or "").strip()
    with refusing(source, "line 1", f"{quote(word.strip())}: "):
        return column, conversion(unit, column.unit).number if unit else 1.0


def _row(
    cells: Sequence[str], columns: Sequence[tuple[DistalColumn, float]], number: int, source: str, convention: str
) -> DistalLink:
    place = f"row {number}"
    if len(cells) != len(columns):
        raise InputError(source, place, f"{len(cells)} cells under {len(columns)} columns")
    texts = {column.name: cell.strip() for (column, _), cell in zip(columns, cells, strict=True)}
    scales = {column.name: scale for column, scale in columns}
    type_ = texts.pop("type", "") or "R"
    if type_ not in TYPES:
        raise InputError(source, place, f"type = {quote(type_)} must be one of {', '.join(TYPES)}")
    name = texts.pop("name", "") or f"joint{number}"
    stated = texts.pop(CONVENTION, "")
    word = _convention(stated, f"{place}, {CONVENTION}", source) if stated else convention
    values: dict[str, Any] = dict(_numbers(texts, scales, place, source))
    center = np.array([values.pop(key, 0.0) for key in ("cx", "cy", "cz")])
    xx, xy, xz, yy, yz, zz = (values.pop(key, 0.0) for key in TENSOR)
    inertia = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    ratio = values.pop("ratio", 1.0)
    values["rotor_inertia"] = values.get("rotor_inertia", 0.0) * ratio * ratio
    kind = (JointType.REVOLUTE, JointType.PRISMATIC, JointType.FIXED)[TYPES[type_]]
    values["modified"] = CONVENTIONS[word or "standard"]
    return DistalLink(name, kind, center=center, inertia=inertia, **values)


def _numbers(
    texts: Mapping[str, str], scales: Mapping[str, float], place: str, source: str
) -> Iterator[tuple[str, float]]:
    """Numbers of a row by key, in SI units; empty cells are omitted."""
    nonnegative = {column.name for column in COLUMNS if column.is_nonnegative}
    for name, text in texts.items():
        if not text:
            continue
        with refusing(source, f"{place}, {name}", f"{quote(text)}: "):
            value = formula.number(text)
        if value < 0 and name in nonnegative:
            raise InputError(source, f"{place}, {name}", f"it is negative: {value:g}")
        yield name, value * scales[name] if math.isfinite(value) else value


@dataclass(frozen=True)
class DistalColumn:
    """A column of a DH table: its meaning, unit and default, and an example of its cell."""

    name: str
    unit: str
    default: str
    meaning: str
    example: str
    is_nonnegative: bool = False


TYPES = {"R": 0, "P": 1, "F": 2, "revolute": 0, "prismatic": 1, "fixed": 2}
"""Words for the type of a joint, with its sigma."""
CONVENTIONS = {"standard": False, "distal": False, "modified": True, "proximal": True}
"""Words for the convention of a row, and whether it is the modified one."""


def _inertia(name: str) -> DistalColumn:
    what = f"entry {name[1:]} of the inertia tensor about the centre of mass, in the frame of the link"
    return DistalColumn(name, "kg m2", "0", what, "0.01")


def _center(name: str) -> DistalColumn:
    what = f"coordinate {name[1]} of the centre of mass, in the frame of the link"
    return DistalColumn(name, "m", "0", what, "-0.1")


COLUMNS = (
    DistalColumn("name", "", "joint1 ...", "name of the joint", "elbow"),
    DistalColumn("type", "", "R", f"type of the joint: {', '.join(TYPES)}; a fixed row places a base or a tool", "P"),
    DistalColumn("convention", "", "that of the table", f"of the row: {', '.join(CONVENTIONS)}", "modified"),
    DistalColumn("theta", "rad", "0", "angle about z; of a revolute joint the offset of its variable", "pi/2"),
    DistalColumn("d", "m", "must be given", "distance along z; of a prismatic joint the offset of its variable", "0.4"),
    DistalColumn("a", "m", "must be given", "distance along x", "0.425"),
    DistalColumn("alpha", "rad", "must be given", "angle about x", "-pi/2"),
    DistalColumn("mass", "kg", "0", "mass of the link", "8.4", is_nonnegative=True),
    *map(_center, ("cx", "cy", "cz")),
    *map(_inertia, ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")),
    DistalColumn("rotor_inertia", "kg m2", "0", "inertia of the rotor about its own axis", "2e-4", is_nonnegative=True),
    DistalColumn("ratio", "", "1", "rotor turns per joint turn, rad/m where it slides", "100"),
    DistalColumn("viscous", "N m s/rad", "0", "viscous friction of the joint", "0.8", is_nonnegative=True),
    DistalColumn("coulomb", "N m", "0", "dry friction of the joint", "1.5", is_nonnegative=True),
)
