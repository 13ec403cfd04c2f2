"""The machine as a figure in space: bodies as boxes of equal inertia, joints, springs, rails, frames, names.

Every shape is fixed to a frame, so the placements of the frames are all that is needed to draw it anywhere.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.checks import parameter_values
from symoro_elastic.machine.columns import UPPER
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.frames import COORDINATES, FrameNames, with_base_coordinates
from symoro_elastic.machine.machine import Body, Kind, Machine
from symoro_elastic.machine.scene import ALL, Scene
from symoro_elastic.models.bound.joint_axes import placed_machine
from symoro_elastic.models.bound.state import State, closing_models
from symoro_elastic.models.bound.viewing import number_or_nan, upward
from symoro_elastic.models.packaging import trace_models
from symoro_elastic.models.programs.catalogue import trace
from symoro_elastic.numerics.evaluation.closed_positions import drawn_values, with_dependent
from symoro_elastic.numerics.motion.independent_joints import with_independent_motors
from symoro_elastic.pages.drawing.bars import Bar, bars_of
from symoro_elastic.pages.drawing.joint_shapes import base_shapes, joint_shapes
from symoro_elastic.pages.drawing.shapes import Shape, Solid, Wire, inverse, transform
from symoro_elastic.pages.drawing.skins import Skin, skins_of
from symoro_elastic.symbolic.arithmetic import FLOATS, evaluate_nodes
from symoro_elastic.symbolic.program import Program

ROUNDING = 1e-9
"""Of a principal moment, by the largest: what a square may be below zero."""

BODY = "body"
UNIT, SHARE, LEAST = 0.02, 0.2, 0.004
"""The unit of the shapes of joints: this much of the extent, at most so much of a usual link, at least so much."""
THIN = 0.8
"""Of the unit: the least edge of a body that is drawn."""
LARGEST_BODY = 8.0
"""Of the machine's diagonal: longer bodies are drawn as balls, since joints would have an eighth of a picture."""
BALL = 3.0
"""Of the unit: the diameter of the ball at the centre of mass of a body without a box."""
LARGEST = 1e6
"""Of the extent, m."""
MOST_NAMED = 150
"""Frames whose names are drawn."""
CORNERS = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
STAND_IN = 1.0
"""Length, m, or angle, rad, that is drawn where the machine gives none."""


@dataclass(frozen=True)
class Mark:
    """A named frame of the figure, and its kind: that of its joint, or base."""

    frame: int
    name: str
    role: str


@dataclass(frozen=True)
class Figure:
    """A machine to draw: shapes fixed to frames 0 (the base) and 1 to the number of rows.

    `reference` (1 + rows, 4, 4) are the placements it was made at, `antecedents` and `slides` those of each frame,
    `up` (3,) is against gravity, `extent` the size of the machine and `unit` that of a joint, m. `room` (2, 3) are the
    corners, lowest and highest, of the space around all origins and bodies. `remarks` are lines about what is not shown
    as it is.
    """

    title: str
    marks: tuple[Mark, ...]
    shapes: tuple[Solid | Wire | Bar | Skin, ...]
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
    def bars(self) -> tuple[Bar, ...]:
        """The beams among the shapes."""
        return tuple(shape for shape in self.shapes if isinstance(shape, Bar))

    @property
    def skins(self) -> tuple[Skin, ...]:
        """The surfaces of bodies by modes among the shapes."""
        return tuple(shape for shape in self.shapes if isinstance(shape, Skin))

    @property
    def is_crowded(self) -> bool:
        """Whether the frames are too many for names."""
        return len(self.marks) > MOST_NAMED


def figure_of(placements: Placements, q: Array) -> Figure:
    """Return the figure of a machine at q (n,); raises `InputError` for an open loop, or for its size."""
    machine, T = placements.machine, placements.at(q)
    values = parameter_values(machine)
    boxes, giants = ({}, []) if machine.is_grouped else _boxes(machine, T, values)
    room = _room(machine, T, boxes)
    extent = _extent(room)
    unit, up = _unit(machine, T, extent), upward(machine, values)
    springs = [joint.kind is Kind.ELASTIC for joint in machine.independent_joints]
    bars = bars_of(machine, lambda: placements.at(np.where(springs, 0.0, q)), values)
    within = {j: bar for bar in bars for j in range(bar.root, bar.end + 1)}
    hidden = _rows_of_modes(machine) | {j for j, bar in within.items() if j != bar.end}
    skins = [*skins_of(machine)]
    covered = {skin.root for skin in skins}
    shapes: list[Solid | Wire | Bar | Skin] = [*([] if _floats(machine) else base_shapes(up, unit)), *bars, *skins]
    for j, joint in enumerate(machine.joints, start=1):
        if joint.name not in COORDINATES and j not in {*hidden, *within}:
            shapes += joint_shapes(j, joint, T, unit)
        if j in boxes and (j not in hidden or j not in within) and j not in covered:
            shapes += [_body(T, j, boxes[j], unit)]
    return Figure(
        machine.name,
        tuple(mark for mark in _marks(machine) if mark.frame not in hidden),
        tuple(shapes),
        T,
        (0, *machine.antecedents),
        (False, *(joint.sigma == 1 for joint in machine.joints)),
        up,
        extent,
        unit,
        room,
        tuple(_remarks(placements, boxes, giants)),
    )


def _rows_of_modes(machine: Machine) -> frozenset[int]:
    """Rows of modes, and those from a body that bends by modes to what it carries."""
    variables = {machine.joint(j).variable for j in machine.modal_rows}
    coupled = ((j, joint) for j, joint in enumerate(machine.joints, start=1) if joint.kind is Kind.COUPLED)
    return machine.modal_rows | {j for j, joint in coupled if variables & {*joint.theta.names, *joint.r.names}}


def _boxes(machine: Machine, T: Array, values: Mapping[str, float]) -> tuple[dict[int, Box], list[int]]:
    """Boxes of bodies with values, by joint number, and the joints with far too long bodies, reduced to points."""
    numbered = ((j, box_of(joint.body, values)) for j, joint in enumerate(machine.joints, start=1))
    boxes = {j: box for j, box in numbered if box}
    lengths = {j: float(np.linalg.norm(box.edges)) for j, box in boxes.items()}
    machine_length = max(float(np.linalg.norm(np.ptp(T[:, :3, 3], axis=0))), float(np.median([*lengths.values(), 0.0])))
    giants = [j for j, length in lengths.items() if length > LARGEST_BODY * machine_length > 0]
    return boxes | {j: replace(boxes[j], edges=np.zeros(3)) for j in giants}, giants


def _remarks(placements: Placements, boxes: Mapping[int, Box], giants: Sequence[int]) -> Iterator[str]:
    """Lines about parts that a figure omits or draws differently."""
    machine = placements.machine
    if placements.not_given:
        yield f"not to scale: {', '.join(placements.not_given)} without value"
    unknown = [
        joint.name for j, joint in enumerate(machine.joints, start=1) if j not in boxes and not joint.body.mass.is_zero
    ]
    if machine.is_grouped:
        yield "base parameters are those of no bodies: so no bodies are drawn"
    elif unknown:
        yield f"bodies without usable values are not drawn: {', '.join(unknown)}"
    if giants:
        names = ", ".join(machine.joint(j).name for j in giants)
        yield f"bodies over {LARGEST_BODY:g} times as long as the machine are drawn as balls: {names}"
    if len(machine.joints) >= MOST_NAMED:
        yield f"more than {MOST_NAMED} frames: names are left out"


def _floats(machine: Machine) -> bool:
    """Whether the first rows are the coordinates of a freely moving base."""
    return machine.joints[:1] != () and machine.joints[0].name == COORDINATES[0]


def _marks(machine: Machine) -> Iterator[Mark]:
    if not _floats(machine):
        yield Mark(0, "base", "base")
    for j, joint in enumerate(machine.joints, start=1):
        if joint.name not in COORDINATES:
            yield Mark(j, joint.name, joint.kind)


def _room(machine: Machine, T: Array, boxes: Mapping[int, Box]) -> Array:
    """Return the corners (2, 3) of the space around all origins and bodies."""
    points = np.concatenate(
        [T[:, :3, 3], *(transform(T[j] @ box.placement, CORNERS * box.edges) for j, box in boxes.items())]
    )
    size = float(np.linalg.norm(np.ptp(points, axis=0)))
    if not size <= LARGEST:
        what = f"the machine is {size:.3g} m large: {LARGEST:g} m is the largest that is drawn: check units"
        raise InputError(machine.label, "joints", what)
    return np.stack([points.min(axis=0), points.max(axis=0)])


def _extent(room: Array) -> float:
    """Return the diagonal of a space, m; 1 for a single point."""
    extent = float(np.linalg.norm(room[1] - room[0]))
    return extent if extent > 1 / LARGEST else 1.0


def _unit(machine: Machine, T: Array, extent: float) -> float:
    """Return the size of a joint, m: a smaller fraction of the extent for long machines with many links."""
    ways = np.linalg.norm(T[1:, :3, 3] - T[list(machine.antecedents), :3, 3], axis=1)
    links = ways[ways > LEAST * extent]
    usual = float(np.median(links)) if len(links) else extent
    return max(min(UNIT * extent, SHARE * usual), LEAST * extent)


def _body(T: Array, j: int, box: Box, unit: float) -> Solid:
    """The body of frame j: a box, outlined where it contains at least half of all origins; a ball for a point."""
    if not box.edges.any():
        return Solid(j, BODY, Shape.BALL, box.placement, (BALL * unit,) * 3)
    within = np.abs(transform(inverse(T[j] @ box.placement), T[:, :3, 3])) <= box.edges * (0.5 + ROUNDING)
    a, b, c = np.maximum(box.edges, THIN * unit).tolist()
    return Solid(j, BODY, Shape.BOX, box.placement, (a, b, c), 2 * int(within.all(axis=1).sum()) >= len(T))


# Bodies as boxes of equal inertia: the same mass, centre of mass and inertia tensor, evenly filled.
@dataclass(frozen=True)
class Box:
    """A box in the frame of its body: `placement` (4, 4) of its centre, its axes the principal ones, `edges` (3,) m.

    `edges` are 0 where no evenly filled box has this inertia.
    """

    placement: Array
    edges: Array
    mass: float


def box_of(body: Body, values: Mapping[str, float]) -> Box | None:
    """Return the box of equal inertia; None for a body without mass or centre of mass, or with infinite values.

    The edges a, b, c fulfil I_x = m (b^2 + c^2) / 12 and so on about the principal axes. A tensor without value counts
    as 0.
    """
    mass, *further = (number_or_nan(cell, values) for cell in (body.mass, *body.moments, *body.inertia))
    if not all(cell.names <= values.keys() for cell in body.inertia):
        further[3:] = [0.0] * 6
    if not (mass > 0 and np.isfinite(further).all()):
        return None
    with np.errstate(over="ignore", invalid="ignore"):
        centre, tensor = _about_centre(body, mass, np.array(further))
    if not np.isfinite(tensor).all():
        return None
    moments, axes = np.linalg.eigh(tensor)
    squares = 6 * (moments.sum() - 2 * moments) / mass
    placement = np.eye(4)
    placement[:3, :3], placement[:3, 3] = _along_frame(axes), centre
    squares = squares[_order(axes)]
    if squares.min() < -ROUNDING * float(np.abs(squares).max()):
        squares = np.zeros(3)
    return Box(placement, np.sqrt(np.maximum(squares, 0.0)), mass)


def _about_centre(body: Body, mass: float, moments: Array) -> tuple[Array, Array]:
    """Return the centre of mass (3,) and the inertia tensor (3, 3) about it, in the frame of the body."""
    tensor = moments[3:][np.array(UPPER)]
    if body.central:
        return moments[:3], tensor
    centre: Array = moments[:3] / mass
    shifted: Array = tensor - mass * (centre @ centre * np.eye(3) - np.outer(centre, centre))
    return centre, shifted


def _order(axes: Array) -> list[int]:
    """Return which principal axis is nearest to x, to y, to z of the frame."""
    order: list[int] = []
    for row in np.abs(np.round(axes, 9)):
        order.append(max((k for k in range(3) if k not in order), key=lambda k: (row[k], -k)))
    return order


def _along_frame(axes: Array) -> Array:
    """Return the principal axes (columns) in order and sense of the frame's axes, right-handed."""
    ordered = axes[:, _order(axes)]
    ordered = ordered * np.where(np.diag(ordered) < 0, -1.0, 1.0)
    return np.asarray(ordered * np.array([1.0, 1.0, np.sign(np.linalg.det(ordered))]))


@dataclass(frozen=True)
class Placements:
    """Placements of frames of `machine`, which has coordinates for its base and for independent motors.

    `not_given` are the parameters of its geometry that have no value; stand-ins are drawn for them.
    """

    machine: Machine
    not_given: tuple[str, ...]

    @cached_property
    def programs(self) -> dict[str, Program]:
        """Programs of the frames by the name of their model, with `assemble` for loops without closed form."""
        models = ("geometric_model", *closing_models(self.machine))
        programs = trace_models(self.machine, Scene(models=models, fold=ALL)).models
        return {function.model.name: function.program for function in programs}

    @cached_property
    def start(self) -> Array:
        """q (n,) with springs neutral, loops at their start, and other joints at zero, rad or m."""
        return self.position({})

    def position(self, at: Mapping[str, float]) -> Array:
        """Return q (n,) with joints at given positions, rad or m, others at their start; raises `InputError`."""
        positions = placed_machine(self.machine, at).q
        q = np.array([positions[joint.name] for joint in self.machine.independent_joints], dtype=float)
        return np.where(np.isnan(q), 0.0, q)

    def close_loops(self, q: Array) -> State:
        """Return all blocks of the position q (n,), NaN if the loops do not close."""
        return with_dependent(self.machine, State({"q": q[None]}), parameter_values(self.machine))[0]

    @property
    def _not_there(self) -> str:
        """Return why frames have no placement at a position."""
        loops = ", ".join(loop.name for loop in self.machine.loops)
        if loops:
            return f"loop {loops} does not close there: give another position"
        return "frames are out of the range of numbers there: check lengths and their units"

    def at(self, q: Array) -> Array:
        """Return the placements (1 + rows, 4, 4) of frame 0 and of the rows at q (n,) in frame 0, lengths in m.

        Raises `InputError` where a loop does not close.
        """
        program = self.programs["geometric_model"]
        state = self.close_loops(q)
        symbols: dict[str, float] = {}
        for block in program.inputs:
            symbols |= zip(block.symbols, map(float, getattr(state, block.name)), strict=True)
        try:
            value = evaluate_nodes(program.nodes, symbols, FLOATS)
            T = np.array([float(value(x)) for x in program.outputs[0].entries]).reshape(-1, 4, 4)
        except (ArithmeticError, ValueError):
            T = np.full((1, 4, 4), math.nan)
        if not np.isfinite(T).all():
            raise self.machine.error("--at", self._not_there)
        return self._of_all_rows(T)

    def _of_all_rows(self, T: Array) -> Array:
        """Placements of frame 0 and of all rows; a mode, which has no frame, is where its body is."""
        frames = dict(zip(FrameNames(self.machine).all(), T, strict=True)) | {0: np.eye(4)}
        for j, antecedent in enumerate(self.machine.antecedents, start=1):
            frames.setdefault(j, frames.get(antecedent, frames[0]))
        return np.array([frames[j] for j in range(len(self.machine.joints) + 1)])


def placements_of(machine: Machine) -> Placements:
    """Return the placements of a machine that a scene has restricted; raises `InputError`."""
    machine = replace(with_base_coordinates(machine), frames=())
    missing = _missing(machine)
    if missing:
        machine = _with_stand_ins(machine, missing)
    return Placements(with_independent_motors(machine), missing)


def _missing(machine: Machine) -> tuple[str, ...]:
    """Parameters without value on which the placements of frames depend."""
    without = [p.name for p in machine.parameters if p.value is None]
    used = trace(machine, "geometric_model").program.used if without else frozenset()
    return tuple(name for name in without if name in used)


def _with_stand_ins(machine: Machine, names: Sequence[str]) -> Machine:
    """The machine with substitute values of geometric parameters that close its loops."""
    values = drawn_values(machine) if machine.loops else dict.fromkeys(names, STAND_IN)
    parameters = (replace(p, value=Formula.parse(values[p.name])) if p.name in names else p for p in machine.parameters)
    return replace(machine, parameters=tuple(parameters))
