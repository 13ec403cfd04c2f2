"""One budget: what to leave out next, where everything that is left out adds to one error.

    gain of an item = what it saves / max(what it adds, NEGLIGIBLE),    errors and tolerances as one fraction

The next item is the one with the largest gain that fits; what adds nothing is ordered by what it saves. Springs of a
ladder, numbers of bodies, terms of a program, precisions and forms are items; `spend` is the loop over all of them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Generic, TypeVar

from symoro_elastic.machine.within import Evidence

NEGLIGIBLE = 1e-6
"""Of the tolerance: items that add less are ordered by what they save alone."""

What = TypeVar("What")
State = TypeVar("State")


@dataclass(frozen=True)
class Error:
    """An error as a fraction of its tolerance, and its evidence."""

    value: float
    evidence: Evidence


@dataclass(frozen=True)
class Item(Generic[What]):
    """A part that may be omitted (`what`), the operations that it saves, the fraction of the tolerance it uses."""

    what: What
    saves: float
    adds: float

    @property
    def gain(self) -> float:
        """Operations saved by error added."""
        return self.saves / max(self.adds, NEGLIGIBLE)


@dataclass(frozen=True)
class ErrorBudget:
    """Tolerances by output, and the fraction of them that may be spent."""

    tolerance: Mapping[str, float]
    fraction: float = 1.0

    def used_fraction(self, errors: Mapping[str, float]) -> float:
        """Return the largest error as a fraction of its tolerance."""
        return max(abs(error) / self.tolerance[name] for name, error in errors.items())

    def slack(self, errors: Mapping[str, float]) -> dict[str, float]:
        """Return the unused part of the tolerances, by output."""
        return {name: self.fraction * limit - errors.get(name, 0.0) for name, limit in self.tolerance.items()}

    def fits(self, *errors: Mapping[str, float]) -> bool:
        """Whether the sum of errors is within the tolerances for every output."""
        return all(sum(x.get(name, 0.0) for x in errors) <= limit for name, limit in self.slack({}).items())


def by_gain(items: Iterable[Item[What]]) -> list[Item[What]]:
    """Return items by gain, the largest first; of equal gain those that add less first."""
    return sorted(items, key=lambda item: (-item.gain, item.adds))


def spend(
    state: State, items: Callable[[State], Iterable[Item[What]]], accept: Callable[[State, What], State | None]
) -> Iterator[State]:
    """Yield the states of a greedy search: each is the one before without the item of largest gain that is accepted.

    `items` are those of a state, `accept` returns the state without an item, None where that does not fit. The search
    ends where no item of a state is accepted.
    """
    while True:
        states = (accept(state, item.what) for item in by_gain(items(state)))
        following = next((x for x in states if x is not None), None)
        if following is None:
            return
        yield (state := following)
