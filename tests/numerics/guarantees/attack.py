"""Attacks on certificates: errors and values of programs at random states, at corners, and where climbing ends."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from symoro_elastic.codegen.printed_order import in_printed_order
from symoro_elastic.codegen.printers import constant_values
from symoro_elastic.numerics.evaluation.arrays import EXTENDED, arithmetic
from symoro_elastic.numerics.guarantees.box import Box
from symoro_elastic.symbolic.arithmetic import evaluate
from symoro_elastic.symbolic.expression import Operand
from symoro_elastic.symbolic.program import Program

Array = NDArray[np.float64]
States = dict[str, Array]
TYPES: Mapping[str, type] = {"double": np.float64, "single": np.float32}
EXACT = {"double": EXTENDED, "single": np.float64}
"""Types in which what the precision computes is taken as exact: 11 and 29 bits more."""
SLACK = {"double": 2.0**-10, "single": 2.0**-24}
"""Of an error: what the exact type may be off."""
ROUNDED = {"double": 2.0**-63, "single": 2.0**-52}
"""Of a value: the rounding of the exact type, which the error of a number may show."""


@dataclass(frozen=True)
class Worst:
    """The largest error, and the least and largest value, of each result that an attack has found."""

    error: Array
    low: Array
    high: Array


def results_as_printed(program: Program) -> list[Operand]:
    """The entries of all results, sums carried out from left to right as the text of the program has them."""
    printed, _ = in_printed_order(program)
    return [x for output in printed.outputs for x in output.entries]


def computed(roots: Sequence[Operand], states: Mapping[str, Array], dtype: type) -> list[Array]:
    """Results as generated code computes them: constants rounded once, every operation in this type."""
    known = {number: dtype(x) for number, x in constant_values(roots).items()}
    value = evaluate(roots, {name: x.astype(dtype) for name, x in states.items()}, arithmetic(dtype), known)
    return [np.asarray(value(x)) for x in roots]


class Attack:
    """Programs of one precision over one box."""

    def __init__(self, roots: Sequence[Operand], box: Box, precision: str, seed: int = 0) -> None:
        self.roots, self.box, self.precision = roots, box, precision
        self.rng = np.random.default_rng(seed)

    def errors(self, states: States) -> tuple[Array, Array]:
        """Errors and exact values, results x states."""
        count = len(next(iter(states.values())))
        with np.errstate(all="ignore"):
            found = computed(self.roots, states, TYPES[self.precision])
            exact = evaluate(
                self.roots,
                {name: x.astype(EXACT[self.precision]) for name, x in states.items()},
                arithmetic(EXACT[self.precision]),
            )
            pairs = [
                (np.broadcast_to(x, count), np.broadcast_to(exact(r), count))
                for x, r in zip(found, self.roots, strict=True)
            ]
            off = [np.abs(x.astype(EXACT[self.precision]) - true) for x, true in pairs]
        return np.array(off, float), np.array([true for _, true in pairs], float)

    def run(self, drawn: int, rounds: int = 20, kept: int = 20) -> Worst:
        """The worst of random states, half of them at corners, and of climbing from the worst of these."""
        states = self.held(self.box.states(drawn, self.rng))
        errors, values = self.errors(states)
        worst = Worst(errors.max(axis=1), values.min(axis=1), values.max(axis=1))
        for kind in range(len(self._measures(errors, values))):
            worst = self._climb(states, kind, worst, rounds, min(kept, drawn))
        return worst

    def _climb(self, states: States, kind: int, worst: Worst, rounds: int, kept: int) -> Worst:
        """Move some variables of the worst states of each result, less and less, where that makes it worse."""
        measure = self._measures(*self.errors(states))[kind]
        chosen = np.argsort(measure, axis=1)[:, -kept:].ravel()
        rows = np.repeat(np.arange(len(self.roots)), kept)
        best, here = measure[rows, chosen], {name: x[chosen] for name, x in states.items()}
        for step in np.geomspace(0.5, 1e-6, rounds):
            moved = self._moved(here, step)
            errors, values = self.errors(moved)
            found = self._measures(errors, values)[kind][rows, np.arange(len(rows))]
            better = found > best
            best = np.where(better, found, best)
            here = {name: np.where(better, moved[name], x) for name, x in here.items()}
            worst = Worst(
                np.maximum(worst.error, errors.max(axis=1)),
                np.minimum(worst.low, values.min(axis=1)),
                np.maximum(worst.high, values.max(axis=1)),
            )
        return worst

    @staticmethod
    def _measures(errors: Array, values: Array) -> tuple[Array, ...]:
        """What is climbed: errors, values both ways."""
        return errors, values, -values

    def _moved(self, states: States, step: float) -> States:
        """States of which a third of the variables have moved by so much of their ranges, some of them to ends."""
        moved = {}
        for name, x in states.items():
            found = self.box.ranges[name]
            change = self.rng.normal(size=len(x)) * step * (found.high - found.low) * (self.rng.random(len(x)) < 0.3)
            ends = self.rng.choice([found.low, found.high], len(x))
            moved[name] = np.where(self.rng.random(len(x)) < 0.05, ends, x + change)
        return self.held(moved)

    def held(self, states: States) -> States:
        """States as arrays of the precision hold them, within the box."""
        held = {}
        for name, x in states.items():
            low, high = self._ends(name)
            held[name] = np.clip(x.astype(TYPES[self.precision]).astype(float), low, high)
        return held

    def _ends(self, name: str) -> tuple[float, float]:
        """The least and the largest number of the precision in a range; its middle as it is, where it is a point."""
        found, dtype = self.box.ranges[name], TYPES[self.precision]
        low, high = dtype(found.low), dtype(found.high)
        low = np.nextafter(low, dtype(np.inf)) if float(low) < found.low else low
        high = np.nextafter(high, dtype(-np.inf)) if float(high) > found.high else high
        return (float(low), float(high)) if low <= high else (found.low, found.high)
