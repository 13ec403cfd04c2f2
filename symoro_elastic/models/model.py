"""What a model is: a function from a bound machine to results, and its trace as a program."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from symoro_elastic.models.bind import Bound
from symoro_elastic.symbolic.expression import Scalar
from symoro_elastic.symbolic.program import Program

Joints = tuple[int, ...]
JOINTS, FRAMES = "joints", "frames"


@dataclass(frozen=True)
class Result:
    """A result of a model: the joints (or frames) along its first axis, its entries, its other axes."""

    rows: Joints
    entries: tuple[Scalar, ...]
    columns: tuple[int, ...] = ()


Results = dict[str, Result]


@dataclass(frozen=True)
class Model:
    """A model that can be generated: what it gives, by which equations, from which arguments.

    `rows` tells whether its results follow the joints that move or all frames.
    """

    name: str
    title: str
    equations: str
    arguments: tuple[str, ...]
    results: tuple[str, ...]
    run: Callable[[Bound, Joints], Results]
    rows: str = JOINTS


@dataclass(frozen=True)
class TracedModel:
    """A model of one machine as a program; `rows` gives the joints (or frames) of each result."""

    model: Model
    rows: dict[str, tuple[int, ...]]
    program: Program
