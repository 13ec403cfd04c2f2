"""Which correction of data explains what a model does not: one search over rows, and one criterion.

A row undoes a usual mistake. Rows are screened by their distance from the model at known values, the nearest are
refitted, and a row is named if the model explains the data with it, and far better than without it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Generic, TypeVar

Data = TypeVar("Data")

VERY_STRONG = 5.0
"""Difference of negative log-likelihoods, half of a difference of BIC of 10: very strong (Kass and Raftery 1995)."""
MOST_REFITTED = 6  # rows or starts of a search that are refitted, which bounds its time
MOST_NAMED = 3  # corrections, times or frequencies that a message names


@dataclass(frozen=True, eq=False)
class Correction(Generic[Data]):
    """Data without a usual mistake: its name, its kind, and which parts of the data (by place) differ.

    Rows that differ by a `number` have the same `family`, and `vary` returns the row at another number.
    """

    name: str
    data: Data
    changed: tuple[int, ...] = ()
    kind: str = ""
    family: str = ""
    number: float = 0.0
    vary: Callable[[float], Correction[Data]] | None = None


@dataclass(frozen=True)
class Refit(Generic[Data]):
    """Negative log-likelihoods of a minimum with a correction that explains the data, and of the least without it."""

    correction: Correction[Data]
    cost: float
    uncorrected: float


def explanations(
    rows: Iterable[Correction[Data]],
    distance: Callable[[Correction[Data]], float],
    refit: Callable[[Correction[Data]], Refit[Data] | None],
    bound: float,
) -> list[Correction[Data]]:
    """Return the corrections that explain the data, the best one first; more than one if they explain them equally.

    Rows at a `distance` below `bound` are refitted, of a family the nearest; `refit` returns None where the model does
    not explain the data with the row.
    """
    nearest: dict[str, tuple[float, Correction[Data]]] = {}
    for number, row in enumerate(rows):
        size, key = distance(row), row.family or str(number)
        if size < nearest.get(key, (bound, row))[0]:
            nearest[key] = size, row
    candidates = [row for _, row in sorted(nearest.values(), key=lambda pair: pair[0])[:MOST_REFITTED]]
    refits = [fit for row in candidates if (fit := refit(row)) and fit.cost < fit.uncorrected - VERY_STRONG]
    refits.sort(key=lambda fit: fit.cost)
    return [fit.correction for fit in refits if fit.cost <= refits[0].cost + VERY_STRONG]


def names_of(corrections: Iterable[Correction[Data]]) -> str:
    """Return the names of corrections that explain data equally, for a message."""
    return ", or ".join(list(dict.fromkeys(correction.name for correction in corrections))[:MOST_NAMED])
