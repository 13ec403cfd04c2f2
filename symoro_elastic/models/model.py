"""What a model is: a function from a bound machine to results, and its trace as a program."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from symoro_elastic.machine.scene import Point
from symoro_elastic.models.bind import Bound, Points
from symoro_elastic.scalar import Scalar
from symoro_elastic.symbolic.program import Program

Joints = tuple[int, ...]


@dataclass(frozen=True)
class Frame:
    """A frame that is asked for, the frame it is seen from where a scene names one (0 is the base).

    `at` moves its origin to a point of its body: coordinates in the frame's own axes, m.
    """

    number: int
    seen_from: int | None = None
    at: Point | None = None


Frames = tuple[Frame, ...]
JOINTS, FRAMES = "joints", "frames"


@dataclass(frozen=True)
class Result:
    """A result of a model: the joints (or frames) along its first axis, its entries, its other axes.

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


@dataclass(frozen=True)
class Model:
    """A model that can be generated: what it gives, by which equations, from which arguments.

    `rows` tells whether its results follow the joints that move or all frames; `own_arguments` gives the
    arguments and the names of their entries where they depend on the machine.
    """

    name: str
    title: str
    equations: str
    arguments: tuple[str, ...]
    results: tuple[str, ...]
    run: Callable[[Bound, Any], Results]
    rows: str = JOINTS
    own_arguments: Callable[[Bound, Results], dict[str, tuple[str, ...]]] | None = None


@dataclass(frozen=True)
class TracedModel:
    """A model of one machine as a program; `results` are as in its trace, `rows` their joints (or frames).

    `whole` tells that no joints or frames were chosen, `points` which ones have equations, numbered after the joints,
    `merged` that it sums angles.
    """

    model: Model
    results: Results
    program: Program
    whole: bool = True
    points: Points = ()
    merged: bool = False

    @property
    def rows(self) -> dict[str, tuple[int, ...]]:
        """Numbers of the joints (or frames) along the first axis of each result."""
        return {name: result.rows or () for name, result in self.results.items()}
