"""What vibration tests tell: a verdict for each parameter, and sentences about what they cannot tell apart.

Verdicts compare the standard deviation of ln p with that of the prior. A direction of ln p, an eigenvector of the
covariance, with more than half the prior's is a sentence: of two parameters it says whether they act in series.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from symoro_elastic.analysis.updating.misfit import Fit
from symoro_elastic.analysis.updating.unknowns import Sought, Unknown
from symoro_elastic.foundation.array_types import Array

GOOD, TOLD = 0.1, 0.5
"""Of the prior standard deviation: identified below the first, told at all below the second."""
PART = 0.1
"""Of the largest entry of a direction, above which a parameter belongs to it."""
ALIKE = 0.15
"""Relative difference of slopes that are called equal."""
TEN_PERCENT = math.log(1.1)


class Verdict(StrEnum):
    """Quality of an estimate."""

    IDENTIFIED = "identified"
    POOR = "poorly identified"
    NOT = "not told by these tests"


@dataclass(frozen=True)
class Found:
    """Value of an unknown, and the standard deviation of its logarithm, about std / value."""

    unknown: Unknown
    value: float
    relative: float
    verdict: Verdict

    @property
    def std(self) -> float:
        """Standard deviation, in the unit of the parameter."""
        return self.value * self.relative


def found_of(sought: Sought, fit: Fit, factor: float) -> tuple[Found, ...]:
    """Return value, standard deviation and verdict of each unknown."""
    std = np.sqrt(np.diag(fit.covariance))
    return tuple(
        Found(one, float(np.exp(x)), float(s), _verdict(float(s) / math.log(factor)))
        for one, x, s in zip(sought.unknowns, fit.x, std, strict=True)
    )


def _verdict(share: float) -> Verdict:
    return Verdict.IDENTIFIED if share < GOOD else Verdict.POOR if share < TOLD else Verdict.NOT


def untold(sought: Sought, fit: Fit, factor: float) -> list[str]:
    """Return sentences about directions that these tests do not tell, each with its parameters."""
    kept = [k for k, one in enumerate(sought.unknowns) if not one.is_nuisance]
    values, vectors = np.linalg.eigh(fit.covariance[np.ix_(kept, kept)])
    null = vectors[:, values > (TOLD * math.log(factor)) ** 2]
    labels, sizes = [sought.labels[k] for k in kept], np.exp(fit.x[kept])
    alone, lines = [], []
    for direction in directions(null):
        members = [k for k in np.argsort(-np.abs(direction)) if abs(direction[k]) > PART * np.abs(direction).max()]
        if len(members) == 1:
            alone.append(labels[members[0]])
        else:
            lines.append(_sentence([labels[k] for k in members], direction[members], sizes[members]))
    if alone:
        lines.insert(0, f"these tests do not tell {_listed(alone)}: what stands there is near the start")
    return lines


def directions(null: Array) -> list[Array]:
    """Return a basis of a space (p, k) of directions: each has a parameter of its own, which others have not."""
    rest, found, pivots = null.copy(), [], []
    for _ in range(null.shape[1]):
        pivot = int(np.argmax(np.sum(rest**2, axis=1)))
        row = rest[pivot] / np.linalg.norm(rest[pivot])
        rest = rest - np.outer(rest @ row, row)
        pivots.append(pivot)
    if pivots:
        reduced = null @ np.linalg.inv(null[pivots])
        found = [reduced[:, k] for k in range(len(pivots))]
    return found


def _sentence(labels: Sequence[str], direction: Array, sizes: Array) -> str:
    """Return what a direction of two or more parameters means."""
    named = _listed(labels)
    if len(labels) == 2:
        # Along it d ln p1 / d ln p2 = ratio: 1/p1 + 1/p2, p1 + p2, p1 p2 or p1 / p2 stays.
        ratio, (p1, p2) = float(direction[0] / direction[1]), sizes
        for wanted, what in (
            (-p1 / p2, f"in series: these tests tell only 1/{labels[0]} + 1/{labels[1]}"),
            (-p2 / p1, f"in parallel: these tests tell only {labels[0]} + {labels[1]}"),
            (1.0, f"together: these tests tell only {labels[0]}/{labels[1]}"),
        ):
            if abs(ratio - wanted) <= ALIKE * abs(wanted):
                return f"{named} {what}"
    changes = ", ".join(f"{_percent(x / direction[0])} {label}" for x, label in zip(direction, labels, strict=True))
    return f"{named} are not told apart: {changes} together change nothing that these tests show"


def _percent(share: float) -> str:
    return f"{100 * math.expm1(TEN_PERCENT * float(np.clip(share, -20, 20))):+.2g} %"


def _listed(names: Sequence[str]) -> str:
    return ", ".join(names[:-1]) + f" and {names[-1]}" if len(names) > 1 else names[0]
