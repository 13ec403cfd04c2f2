"""Tables of standard (distal) Denavit-Hartenberg parameters as links and joints.

Row i: A_i = Rot(z, theta) Trans(z, d) Trans(x, a) Rot(x, alpha), joint i about or along z of frame i - 1, link i and
its inertia in frame i. Modified ones are A_i = Rot(x, alpha) Trans(x, a) Rot(z, theta) Trans(z, d). A flipped joint
moves about or along -z.
"""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from symoro_elastic.formats.files import name_of
from symoro_elastic.formats.robots.displacements import about_x, about_z
from symoro_elastic.formats.robots.distal_columns import COLUMNS, SCALES, TYPES, DistalColumn
from symoro_elastic.formats.robots.robot import Description, JointType, Link, LinkJoint, Placement
from symoro_elastic.formats.separated import COMMA, Decimals, separator_of
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine import formula
from symoro_elastic.machine.names import did_you_mean, quote

GRAVITY = (0.0, 0.0, -9.81)
BASE, TOOL = "base", "tool"
TENSOR = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
MOST_ROWS = 1000


@dataclass(frozen=True, eq=False)
class DistalLink:
    """A row: joint and link, SI units, rad.

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
        """Rot(z, theta) Trans(z, d)."""
        return about_z(self.theta, self.d)

    @property
    def along_x(self) -> Placement:
        """Rot(x, alpha) Trans(x, a)."""
        return about_x(self.alpha, self.a)

    @property
    def before(self) -> Placement:
        """Placement of the joint's axis, at position 0, in the frame of the link before."""
        return self.along_x * self.along_z if self.modified else self.along_z

    @property
    def after(self) -> Placement:
        """Placement of the link's frame in that of the joint's axis."""
        return Placement() if self.modified else self.along_x


def describe_links(
    name: str,
    rows: Iterable[DistalLink],
    base: Placement | None = None,
    tool: Placement | None = None,
    gravity: tuple[float, float, float] = GRAVITY,
) -> Description:
    """The robot with these rows; `base` places frame 0 in the world, `tool` the tool in the last frame.

    `gravity` is in axes of the world.
    """
    links, joints, after, parent = [Link(BASE)], [], base or Placement(), BASE
    for row in rows:
        place, child = row.after, f"link {len(links)}"
        inertia = place.rotation @ row.inertia @ place.rotation.T
        center = place.rotation @ row.center + place.translation
        links.append(Link(child, row.mass, center, inertia, frame_only=False))
        joints.append(_joint(row, parent, child, after * row.before))
        after, parent = place, child
    links.append(Link(TOOL))
    joints.append(LinkJoint("tool joint", JointType.FIXED, parent, TOOL, after * (tool or Placement())))
    return Description(name, tuple(links), tuple(joints), gravity=gravity)


def _joint(row: DistalLink, parent: str, child: str, place: Placement) -> LinkJoint:
    axis = np.array([0.0, 0.0, -1.0 if row.flipped else 1.0])
    return LinkJoint(
        *(row.name, row.type, parent, child, place, axis),
        damping=row.viscous,
        friction=row.coulomb,
        rotor_inertia=row.rotor_inertia,
    )


def describe(text: str, source: str) -> Description:
    """The robot in a CSV table: a header line, then a row for each joint; raises `InputError` that names the line."""
    written = [line for line in text.splitlines() if line.strip() and not line.lstrip().startswith("#")]
    separator = separator_of(written[0] if written else "")
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
            raise InputError(source, "line 1", f"the column {column} occurs twice")
    rows = [_row(cells, columns, k, source) for k, cells in enumerate(lines[1:], start=1)]
    return describe_links(name_of(Path(source).stem), rows)


def _with_points(rows: Iterable[Sequence[str]], source: str) -> Iterator[list[str]]:
    decimals = Decimals()
    for number, cells in enumerate(rows, start=1):
        try:
            yield decimals.with_points(cells)
        except ValueError as error:
            raise InputError(source, f"row {number}", str(error)) from None


def _column(word: str, source: str) -> tuple[DistalColumn, float]:
    """A column from its header, and what its numbers are multiplied by: its unit may stand in brackets."""
    match = re.fullmatch(r"\s*(\w+)\s*(?:\[\s*(\w+)\s*\])?\s*", word, re.ASCII)
    known = {column.name: column for column in COLUMNS}
    if not match or match[1] not in known:
        names = did_you_mean(match[1] if match else word, known)
        raise InputError(source, "line 1", f"{quote(word.strip())} is not a column of a table{names}")
    column, unit = known[match[1]], match[2] or ""
    if unit and unit not in {column.unit, *SCALES.get(column.unit, {})}:
        raise InputError(source, "line 1", f"{quote(word.strip())}: the unit is {column.unit or 'none'}")
    return column, SCALES.get(column.unit, {}).get(unit, 1.0)


def _row(cells: Sequence[str], columns: Sequence[tuple[DistalColumn, float]], number: int, source: str) -> DistalLink:
    place = f"row {number}"
    if len(cells) != len(columns):
        raise InputError(source, place, f"{len(cells)} cells under {len(columns)} columns")
    texts = {column.name: cell.strip() for (column, _), cell in zip(columns, cells, strict=True)}
    scales = {column.name: scale for column, scale in columns}
    type_ = texts.pop("type", "") or "R"
    if type_ not in TYPES:
        raise InputError(source, place, f"type = {quote(type_)} must be one of {', '.join(TYPES)}")
    name = texts.pop("name", "") or f"joint{number}"
    values: dict[str, Any] = dict(_numbers(texts, scales, place, source))
    center = np.array([values.pop(key, 0.0) for key in ("cx", "cy", "cz")])
    xx, xy, xz, yy, yz, zz = (values.pop(key, 0.0) for key in TENSOR)
    inertia = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    ratio = values.pop("ratio", 1.0)
    values["rotor_inertia"] = values.get("rotor_inertia", 0.0) * ratio * ratio
    prismatic = TYPES[type_]
    kind = JointType.PRISMATIC if prismatic else JointType.REVOLUTE
    return DistalLink(name, kind, center=center, inertia=inertia, **values)


def _numbers(
    texts: Mapping[str, str], scales: Mapping[str, float], place: str, source: str
) -> Iterator[tuple[str, float]]:
    """The numbers of a row in SI units; empty cells are left out."""
    nonnegative = {column.name for column in COLUMNS if column.is_nonnegative}
    for name, text in texts.items():
        if not text:
            continue
        try:
            value = formula.number(text)
        except formula.FormulaError as error:
            raise InputError(source, f"{place}, {name}", f"{quote(text)}: {error}") from None
        if value < 0 and name in nonnegative:
            raise InputError(source, f"{place}, {name}", f"it is negative: {value:g}")
        yield name, value * scales[name] if math.isfinite(value) else value
