"""Models: functions from a bound machine to results, with their arguments, equations and properties."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from enum import Enum
from typing import Any

from symoro_elastic.foundation.scalar import Scalar
from symoro_elastic.machine.frames import Points
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.scene import Parts, Point
from symoro_elastic.models.bound.bind import Bound
from symoro_elastic.quantities import Quantity, quantity
from symoro_elastic.symbolic.program import Program

Joints = tuple[int, ...]


@dataclass(frozen=True)
class Frame:
    """A requested frame, and the frame it is seen from where a scene names one (0 is the base).

    `at` moves its origin to a point of its body: coordinates in the frame's own axes, m. `component` is of a twist.
    """

    number: int
    seen_from: int | None = None
    at: Point | None = None
    component: str = ""


Frames = tuple[Frame, ...]
ORIENTATION, KNOWN = "orientation", "known"
"""Placeholders of base arguments that the file selects: R0 or Q0, V0d or f0."""
MOVING = (ORIENTATION, "V0", KNOWN)
"""Arguments of dynamic models on a floating base."""


class Pivots(Enum):
    """Joints by whose inertia H_j a model divides: all, or only joints without a motor."""

    ALL = "all"
    WITHOUT_MOTOR = "without motor"


class CheckedBy(Enum):
    """Reference in many digits with which results of a model are compared."""

    TRACE = "the traced equations themselves"
    FRAMES = "products of 4 x 4 matrices [2]"
    INERTIA = "the inertia matrix [8]"
    BIAS = "the bias forces [8]"
    DIRECT = "A qdd + H = Gamma, solved for qdd [8]"
    INVERSE = "the same, solved for Gamma of motors and qdd of other joints [11]"
    EQUATIONS_OF_MOTION = "the motion that it gives, put into A qdd + H [8]"


@dataclass(frozen=True)
class Result:
    """A result of a model: its entries, the joints or frames along its first axis, and its other axes.

    `rows` is None where no axis follows joints; `frames` are the frames of its rows where a model is of
    frames, `column_labels` the names along the last axis where they are parameters.
    """

    rows: Joints | None
    entries: tuple[Scalar, ...]
    columns: tuple[int, ...] = ()
    frames: Frames = ()
    column_labels: tuple[str, ...] = ()

    @property
    def shape(self) -> tuple[int, ...]:
        """Lengths of all axes."""
        return self.columns if self.rows is None else (len(self.rows), *self.columns)


Results = dict[str, Result]


def _traced_by_its_owner(bound: Bound, _: object) -> Results:
    """Raise an error: a model outside of the catalogue is traced by the module that defines it."""
    raise NotImplementedError("no model of the catalogue")


@dataclass(frozen=True)
class Model:
    """A model that can be generated: its results, equations and arguments."""

    name: str
    title: str
    equations: str
    arguments: tuple[str, ...]
    results: tuple[str, ...]
    """Names of results, which are rows of the table of quantities as arguments are."""
    run: Callable[[Bound, Any], Results] = _traced_by_its_owner
    parts: Parts = Parts.JOINTS
    """Parts of its results that a scene may request."""
    own: tuple[Quantity, ...] = ()
    """Rows of quantities that replace the table's rows for this model."""
    own_arguments: Callable[[Bound, Results], dict[str, tuple[str, ...]]] | None = None
    """Arguments and names of their entries, where they depend on the machine."""
    own_rows: Callable[[Bound, Results], tuple[Quantity, ...]] | None = None
    """Further rows that depend on the requested parts."""
    columns: tuple[str, ...] = ()
    """Arguments by which it differentiates."""
    on_base: tuple[str, ...] | None = None
    """Arguments that a floating base adds; None where the model is not offered on a floating base."""
    pivots: Pivots | None = None
    """Joints by whose inertia it divides."""
    least_bits: int = 0
    """Bits of the mantissa that its numbers need."""
    keeps_grouping: bool = True
    """Whether results stay the same when inertial parameters are grouped."""
    is_grouped: bool = False
    """Whether it needs the base inertial parameters of the machine."""
    checked_by: CheckedBy = CheckedBy.TRACE
    has_loop_forces: bool = False
    """Whether it includes forces of loops, which depend on torques of motors on dependent joints."""
    binds: Callable[[Machine], Machine] | None = None
    """Machine that it binds, where that is not the machine restricted to the scene."""
    other_way_of: str = ""
    """Model with the same results, computed in another way."""
    family: str = field(default="", compare=False)
    """Its family in the catalogue: where it is listed, not what it is."""

    @property
    def is_of_frames(self) -> bool:
        """Whether the first axis of the results lists frames, not joints."""
        return self.parts in (Parts.BODIES, Parts.FRAMES, Parts.POINTS, Parts.COMPONENTS)

    def quantity(self, name: str) -> Quantity:
        """The quantity (row of the table) of an argument or result."""
        return quantity(name, self.own)


@dataclass(frozen=True)
class TracedModel:
    """A model of one machine as a program; `results` are as in its trace, `rows` their joints (or frames).

    `whole`: no joints or frames were selected; `points`: frames with equations, numbered after the joints;
    `merged`: its equations use sums of angles.
    """

    model: Model
    results: Results = field(repr=False)
    program: Program
    whole: bool = True
    points: Points = ()
    merged: bool = False

    @property
    def rows(self) -> dict[str, tuple[int, ...]]:
        """Numbers of the joints (or frames) along the first axis, by result."""
        return {name: result.rows or () for name, result in self.results.items()}
