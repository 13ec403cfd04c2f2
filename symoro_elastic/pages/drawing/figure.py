"""The machine as a figure in space: bodies as boxes of equal inertia, joints, springs, rails, frames, names.

Every shape is fixed to a frame, so the placements of the frames are all that is needed to draw it anywhere.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.checks import parameter_values
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.free_base import COORDINATES
from symoro_elastic.machine.machine import Body, Joint, Machine
from symoro_elastic.pages.drawing.joint_shapes import base_shapes, joint_shapes
from symoro_elastic.pages.drawing.placements import Placements
from symoro_elastic.pages.drawing.shapes import Shape, Solid, Wire

TENSOR = ((0, 1, 2), (1, 3, 4), (2, 4, 5))
"""Entries XX XY XZ YY YZ ZZ of a symmetric tensor, by row and column."""
ROUNDING = 1e-9
"""Of a principal moment, by the largest: what a square may be below zero."""

BODY = "body"
UNIT, SHARE, LEAST = 0.02, 0.2, 0.004
"""The unit of the shapes of joints: this much of the extent, at most so much of a usual link, at least so much."""
THIN = 0.8
"""Of the unit: the least edge of a body that is drawn."""
NEAR = 0.25
"""Of the diagonal around all origins: how far around them bodies count, so that a long bed hides no machine."""
LARGEST = 1e6
"""Of the extent, m."""
MOST_NAMED = 150
"""Frames whose names are drawn."""
CORNERS = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])


@dataclass(frozen=True)
class Mark:
    """A frame that has a name in the figure, and what it is: the kind of its joint, or base."""

    frame: int
    name: str
    role: str


@dataclass(frozen=True)
class Figure:
    """A machine to be drawn: shapes fixed to frames 0 (the base) and 1 to the number of rows, as it stands.

    `reference` (1 + rows, 4, 4) are the placements it was made at, `antecedents` and `slides` those of each frame,
    `up` (3,) is against gravity, `extent` the size of the machine and `unit` that of a joint, m. `room` (2, 3) are the
    corners, lowest and highest, of the space that a picture shows: bodies may be larger. `remarks` are lines about what
    is not shown as it is.
    """

    title: str
    marks: tuple[Mark, ...]
    shapes: tuple[Solid | Wire, ...]
    reference: Array
    antecedents: tuple[int, ...]
    slides: tuple[bool, ...]
    up: Array
    extent: float
    unit: float
    room: Array
    remarks: tuple[str, ...] = ()

    @property
    def solids(self) -> tuple[Solid, ...]:
        """The solids among the shapes."""
        return tuple(shape for shape in self.shapes if isinstance(shape, Solid))

    @property
    def wires(self) -> tuple[Wire, ...]:
        """The wires among the shapes."""
        return tuple(shape for shape in self.shapes if isinstance(shape, Wire))

    @property
    def is_crowded(self) -> bool:
        """Whether there are too many frames for names beside them."""
        return len(self.marks) > MOST_NAMED


def figure_of(placements: Placements, q: Array) -> Figure:
    """Return the figure of a machine at q (n,); raises `InputError` where a loop does not close, or for its size."""
    machine, T = placements.machine, placements.at(q)
    values = parameter_values(machine)
    boxes = {} if machine.is_grouped else _boxes(machine, values)
    room = _room(machine, T, boxes)
    extent = _extent(room)
    unit, up = _unit(machine, T, extent), upward(machine, values)
    shapes: list[Solid | Wire] = [] if _floats(machine) else list(base_shapes(up, unit))
    for j, joint in _numbered(machine):
        if joint.name not in COORDINATES:
            shapes += joint_shapes(j, joint, T, unit)
        shapes += [_body(j, boxes[j], unit)] if j in boxes else []
    return Figure(
        machine.name,
        tuple(_marks(machine)),
        tuple(shapes),
        T,
        (0, *machine.antecedents),
        (False, *(joint.sigma == 1 for joint in machine.joints)),
        up,
        extent,
        unit,
        room,
        tuple(_remarks(placements, boxes)),
    )


def _boxes(machine: Machine, values: Mapping[str, float]) -> dict[int, Box]:
    """The boxes of the bodies that have values, by the number of their joint."""
    found = {j: box_of(joint.body, values) for j, joint in _numbered(machine)}
    return {j: box for j, box in found.items() if box}


def _remarks(placements: Placements, boxes: Mapping[int, Box]) -> Iterator[str]:
    """Lines about what a figure does not show, or not as it is."""
    machine = placements.machine
    if placements.not_given:
        yield f"not to scale: {', '.join(placements.not_given)} without value"
    unknown = [joint.name for j, joint in _numbered(machine) if j not in boxes and not joint.body.mass.is_zero]
    if machine.is_grouped:
        yield "base parameters are those of no bodies: so no bodies are drawn"
    elif unknown:
        yield f"bodies without usable values are not drawn: {', '.join(unknown)}"
    flat = [machine.joint(j).name for j, box in boxes.items() if not box.is_exact]
    if flat:
        yield f"no evenly filled box has the inertia of these bodies, drawn flat: {', '.join(flat)}"
    if len(machine.joints) >= MOST_NAMED:
        yield f"more than {MOST_NAMED} frames: names are left out"


def upward(machine: Machine, values: Mapping[str, float]) -> Array:
    """Return the direction (3,) against gravity; z without gravity, and an axis whose gravity has no value."""
    gravity = np.array([_value(x, values) for x in machine.base.gravity])
    unknown = np.isnan(gravity)
    size = 0.0 if unknown.any() else float(np.linalg.norm(gravity))
    up: Array = 0.0 - gravity / size if size > 0 else np.eye(3)[int(np.argmax(unknown)) if unknown.any() else 2]
    return up


def _value(formula: Formula, values: Mapping[str, float]) -> float:
    return formula.value(values) if formula.names <= values.keys() else math.nan


def _numbered(machine: Machine) -> Iterator[tuple[int, Joint]]:
    return enumerate(machine.joints, start=1)


def _floats(machine: Machine) -> bool:
    """Whether the first rows are the coordinates of a base that moves freely."""
    return machine.joints[:1] != () and machine.joints[0].name == COORDINATES[0]


def _marks(machine: Machine) -> Iterator[Mark]:
    if not _floats(machine):
        yield Mark(0, "base", "base")
    for j, joint in _numbered(machine):
        if joint.name not in COORDINATES:
            yield Mark(j, joint.name, joint.kind)


def _room(machine: Machine, T: Array, boxes: Mapping[int, Box]) -> Array:
    """Return the corners (2, 3) of the space around all origins, and around bodies as far as they are near them."""
    origins = T[:, :3, 3]
    points = [origins]
    for j, box in boxes.items():
        centred = T[j] @ box.placement
        points.append((CORNERS * box.edges) @ centred[:3, :3].T + centred[:3, 3])
    around = _corners(np.concatenate(points))
    size = float(np.linalg.norm(around[1] - around[0]))
    if not size <= LARGEST:
        what = f"the machine is {size:.3g} m large: {LARGEST:g} m is the largest that is drawn: check units"
        raise InputError(machine.label, "joints", what)
    low, high = _corners(origins)
    aside = NEAR * float(np.linalg.norm(high - low))
    return np.clip(around, low - aside, high + aside) if aside > 0 else around


def _corners(points: Array) -> Array:
    return np.stack([points.min(axis=0), points.max(axis=0)])


def _extent(room: Array) -> float:
    """Return the diagonal of a space, m; 1 where all is in one point."""
    extent = float(np.linalg.norm(room[1] - room[0]))
    return extent if extent > 1 / LARGEST else 1.0


def _unit(machine: Machine, T: Array, extent: float) -> float:
    """Return the size of a joint, m: of long machines with many links it is less of the extent."""
    ways = np.linalg.norm(T[1:, :3, 3] - T[list(machine.antecedents), :3, 3], axis=1)
    links = ways[ways > LEAST * extent]
    usual = float(np.median(links)) if len(links) else extent
    return max(min(UNIT * extent, SHARE * usual), LEAST * extent)


def _body(j: int, box: Box, unit: float) -> Solid:
    a, b, c = np.maximum(box.edges, THIN * unit).tolist()
    return Solid(j, BODY, Shape.BOX, box.placement, (a, b, c))


# Bodies as boxes of equal inertia: the same mass, centre of mass and inertia tensor, evenly filled.
@dataclass(frozen=True)
class Box:
    """A box in the frame of its body: `placement` (4, 4) of its centre, its axes the principal ones, `edges` (3,) m.

    `is_exact` is False where no evenly filled box has this inertia; the edge that would be imaginary is then 0.
    """

    placement: Array
    edges: Array
    mass: float
    is_exact: bool = True


def box_of(body: Body, values: Mapping[str, float]) -> Box | None:
    """Return the box of equal inertia; None for a body without mass, or with values that are not finite.

    The edges a, b, c fulfil I_x = m (b^2 + c^2) / 12 and so on about the principal axes.
    """
    cells = (body.mass, *body.moments, *body.inertia)
    if not all(cell.names <= values.keys() for cell in cells):
        return None
    mass, *others = (_number(cell, values) for cell in cells)
    if not (mass > 0 and np.isfinite(others).all()):
        return None
    with np.errstate(over="ignore", invalid="ignore"):
        centre, tensor = _about_centre(body, mass, np.array(others))
    if not np.isfinite(tensor).all():
        return None
    moments, axes = np.linalg.eigh(tensor)
    squares = 6 * (moments.sum() - 2 * moments) / mass
    placement = np.eye(4)
    placement[:3, :3], placement[:3, 3] = _along_frame(axes), centre
    squares = squares[_order(axes)]
    least = -ROUNDING * float(np.abs(squares).max(initial=0.0))
    return Box(placement, np.sqrt(np.maximum(squares, 0.0)), mass, bool((squares >= least).all()))


def _number(formula: Formula, values: Mapping[str, float]) -> float:
    try:
        return formula.value(values)
    except (ArithmeticError, ValueError):
        return math.nan


def _about_centre(body: Body, mass: float, others: Array) -> tuple[Array, Array]:
    """Return the centre of mass (3,) and the inertia tensor (3, 3) about it, in the frame of the body."""
    tensor = others[3:][np.array(TENSOR)]
    if body.central:
        return others[:3], tensor
    centre: Array = others[:3] / mass
    shifted: Array = tensor - mass * (centre @ centre * np.eye(3) - np.outer(centre, centre))
    return centre, shifted


def _order(axes: Array) -> list[int]:
    """Return which principal axis is nearest to x, to y, to z of the frame."""
    order: list[int] = []
    for row in np.abs(np.round(axes, 9)):
        order.append(max((k for k in range(3) if k not in order), key=lambda k: (row[k], -k)))
    return order


def _along_frame(axes: Array) -> Array:
    """Return the principal axes (columns) in the order and the sense of those of the frame, right-handed."""
    ordered = axes[:, _order(axes)]
    ordered = ordered * np.where(np.diag(ordered) < 0, -1.0, 1.0)
    turned: Array = ordered * np.array([1.0, 1.0, np.sign(np.linalg.det(ordered))])
    return turned
