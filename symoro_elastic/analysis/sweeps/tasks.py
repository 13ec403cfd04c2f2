"""The results at one point of a sweep, or the reason of a failure."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from numbers import Real
from typing import TypeAlias

from symoro_elastic.analysis.sweeps.quantities import Quantity, impossible, split
from symoro_elastic.foundation.errors import InputError

Figures: TypeAlias = Callable[[dict[str, float], dict[str, float]], Mapping[str, float]]
"""Figures by name of a machine with these values of parameters, at these positions of joints."""
LONGEST_REASON = 300


@dataclass(frozen=True)
class Outcome:
    """Results at a point by name; if there are none, the reason of the failure."""

    figures: dict[str, float] = field(default_factory=dict)
    reason: str = ""


@dataclass(frozen=True)
class Task:
    """The computation at each point: results as functions of the swept quantities."""

    function: Figures
    quantities: tuple[Quantity, ...]

    def outcome(self, row: Sequence[float]) -> Outcome:
        """Return the results at a point; any error becomes its reason, and the sweep continues."""
        if reason := impossible(self.quantities, row):
            return Outcome({}, reason)
        try:
            return Outcome(_check(self.function(*split(self.quantities, row))))
        except InputError as error:
            return Outcome({}, _line(f"{error.place}: {error.what}"))
        except Exception as error:  # also those of a function of the user
            return Outcome({}, _line(f"{type(error).__name__}: {error}"))

    def outcomes(self, numbered: Sequence[tuple[int, Sequence[float]]]) -> list[tuple[int, Outcome]]:
        """Return the results at some points, by number."""
        return [(k, self.outcome(row)) for k, row in numbered]


def _check(figures: object) -> dict[str, float]:
    if not isinstance(figures, Mapping):
        raise TypeError(f"the function returns {type(figures).__name__}: return a dict of numbers by name")
    checked = {}
    for name, x in figures.items():
        if not isinstance(name, str) or isinstance(x, bool) or not isinstance(x, Real):
            what = f"{name!r}: {_line(repr(x))} is not a number by name"
            raise TypeError(f"{what}: return a dict such as {{'mass': 1.0}}")
        checked[name] = float(x) + 0.0
    if not checked:
        raise ValueError("no result has a value here")
    return checked


def _line(text: str) -> str:
    line = " ".join(text.split())
    return line if len(line) <= LONGEST_REASON else f"{line[: LONGEST_REASON - 3]}..."
