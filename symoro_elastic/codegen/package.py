"""What a target renders: a machine's names and its functions, in words that code needs."""

from __future__ import annotations

from dataclasses import dataclass

from symoro_elastic.symbolic.program import Program


@dataclass(frozen=True)
class Axis:
    """An entry of q: joint name, kind, unit."""

    name: str
    kind: str
    unit: str


@dataclass(frozen=True)
class ParameterValue:
    """An entry of p; `value` is NaN where the machine gives none."""

    name: str
    value: float
    unit: str


@dataclass(frozen=True)
class Argument:
    """An array of a function's signature: entries along its last axis, and what it is."""

    name: str
    size: int
    meaning: str


@dataclass(frozen=True)
class Result:
    """An array that a function gives: shape, what it is, and the names its first and last axes follow.

    `whole` is False where its rows are those that a scene has chosen.
    """

    name: str
    shape: tuple[int, ...]
    meaning: str
    rows: tuple[str, ...]
    columns: tuple[str, ...] = ()
    whole: bool = True


@dataclass(frozen=True)
class Function:
    """A generated function."""

    name: str
    title: str
    equations: str
    program: Program
    arguments: tuple[Argument, ...]
    results: tuple[Result, ...]

    @property
    def columns(self) -> tuple[str, ...]:
        """What columns belong to, where all results that say so say the same."""
        labels = {result.columns for result in self.results if result.columns}
        return labels.pop() if len(labels) == 1 else ()


@dataclass(frozen=True)
class Package:
    """Everything generated for one machine; `joint_names` are the rows of its table, then points that are asked for."""

    name: str
    scene: str
    axes: tuple[Axis, ...]
    motors: tuple[int, ...]
    elastic: tuple[int, ...]
    frames: tuple[str, ...]
    joint_names: tuple[str, ...]
    parameters: tuple[ParameterValue, ...]
    functions: tuple[Function, ...]
