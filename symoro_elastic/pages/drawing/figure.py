"""The machine as a figure in space: bodies as boxes of equal inertia, joints, springs, rails, frames, names.

Every shape is fixed to a frame, so the placements of the frames are all that is needed to draw it anywhere.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from symoro_elastic.array_types import Array
from symoro_elastic.drawing.bodies import Box, box_of
from symoro_elastic.drawing.joint_shapes import base_shapes, joint_shapes
from symoro_elastic.drawing.placements import Placements
from symoro_elastic.drawing.shapes import Shape, Solid, Wire
from symoro_elastic.errors import InputError
from symoro_elastic.machine.checks import parameter_values
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.free_base import COORDINATES
from symoro_elastic.machine.machine import Joint, Machine

BODY = "body"
UNIT, SHARE, LEAST = 0.02, 0.2, 0.004
"""The unit of the shapes of joints: this much of the extent, at most so much of a usual link, at least so much."""
THIN = 0.8
"""Of the unit: the least edge of a body that is drawn."""
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
    `up` (3,) is against gravity, `extent` the size of the machine and `unit` that of a joint, m. `remarks` are
    lines about what is not shown as it is.
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
    extent = _extent(machine, T, boxes)
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
        yield "base parameters are those of no bodies: none is drawn"
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
    """Whether the first rows are the coordinates of a floating base."""
    return machine.joints[:1] != () and machine.joints[0].name == COORDINATES[0]


def _marks(machine: Machine) -> Iterator[Mark]:
    if not _floats(machine):
        yield Mark(0, "base", "base")
    for j, joint in _numbered(machine):
        if joint.name not in COORDINATES:
            yield Mark(j, joint.name, joint.kind)


def _extent(machine: Machine, T: Array, boxes: Mapping[int, Box]) -> float:
    """Return the diagonal of the space around all origins and bodies, m; 1 where all is in one point."""
    points = [T[:, :3, 3]]
    for j, box in boxes.items():
        centred = T[j] @ box.placement
        points.append((CORNERS * box.edges) @ centred[:3, :3].T + centred[:3, 3])
    spread = np.ptp(np.concatenate(points), axis=0)
    extent = math.hypot(*spread.tolist())
    if not extent <= LARGEST:
        what = f"the machine is {extent:.3g} m large: {LARGEST:g} m is the most that is drawn, check units"
        raise InputError(machine.label, "joints", what)
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
