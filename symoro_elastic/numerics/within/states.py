"""States of a box of arguments: drawn at random, half of them with all but positions at corners of the box."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from symoro_elastic.foundation.array_types import Array, BoolArray
from symoro_elastic.numerics.guarantees.box import drawn
from symoro_elastic.numerics.within.tape import Tape


class Interval(Protocol):
    """The values of an argument."""

    @property
    def low(self) -> float:
        """The least one."""

    @property
    def high(self) -> float:
        """The largest one."""


@dataclass(frozen=True)
class Point:
    """A single value."""

    low: float

    @property
    def high(self) -> float:
        """The same."""
        return self.low


Box = Mapping[str, Interval]
"""By the name of a symbol."""


@dataclass(frozen=True)
class Bounds:
    """The box in the order of the symbols of a tape, (symbols, 1)."""

    low: Array
    high: Array
    is_position: BoolArray

    @classmethod
    def of(cls, tape: Tape, box: Box) -> Bounds:
        """Raise `ValueError` for a symbol without an interval, or an interval without end."""
        missing = [name for name in tape.symbols if name not in box]
        if missing:
            raise ValueError(f"no values over the box: {', '.join(missing)}; give them, and numbers to all parameters")
        ends = np.array([(box[name].low, box[name].high) for name in tape.symbols], dtype=float).reshape(-1, 2)
        for name, (low, high) in zip(tape.symbols, ends, strict=True):
            if not (np.isfinite([low, high]).all() and low <= high):
                raise ValueError(f"{name}: from {low} to {high} is not an interval")
        return cls(ends[:, :1], ends[:, 1:], np.array(tape.is_position, dtype=bool)[:, None])

    @property
    def is_moving(self) -> BoolArray:
        """Where symbols are neither positions nor points."""
        found: BoolArray = (~self.is_position & (self.low < self.high))[:, 0]
        return found

    def draw(self, states: int, rng: np.random.Generator) -> Array:
        """Return states (symbols, states)."""
        return drawn(self.low, self.high, self.is_position, states, rng)

    def at_rest(self, states: int, rng: np.random.Generator) -> Array:
        """Return states at random positions, the first at the origin; zero, or what is nearest to it, for all else."""
        found = self.draw(states, rng)
        rest = np.clip(0.0, self.low, self.high)
        found[:, :1] = rest
        found = np.where(self.is_position, found, rest)
        return found

    def inside(self, states: Array) -> Array:
        """Return states moved into the box."""
        return np.clip(states, self.low, self.high)


def joined(parts: Sequence[Array]) -> Array:
    """Return states side by side."""
    return np.concatenate(parts, axis=1)
