"""Unknowns of a fit, their estimates with verdicts, and the directions in which data do not determine them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum
from statistics import NormalDist

import numpy as np

from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.errors import enumeration
from symoro_elastic.foundation.packages import for_vibrations

SIGNIFICANT = 4.0  # standard deviations from zero of an effect that is not chance: 6e-5 of normal noise is beyond
ALARM = 1e-3  # probability with which chance alone raises an alarm
OUTLYING = 6.0  # robust standard deviations beyond which a value is an outlier
CAUCHY = 2.5
"""c of Cauchy's weights 1 / (1 + (r / c)^2), in standard deviations: 95 % efficient (Holland and Welsch 1977)."""
TO_DEVIATION = 1.4826  # standard deviation of normal noise over the median of its absolute values
CORRELATED = 0.3
"""Correlation that counts: of neighbouring residuals beyond that of averages; an offset of twice its standard deviation
pulls an estimate that is so correlated with it by 0.6 of that one's."""
WELL_KNOWN = 0.1  # standard deviation of an identified parameter, over its size or over the prior standard deviation
HARDLY_KNOWN = 0.5  # fraction of the prior standard deviation, or of noise, above which a parameter is undetermined
SMALL_PART = 0.1  # of the largest entry of a direction, below which a parameter does not belong to it
SAME_SLOPE = 0.15  # relative difference of slopes that are called equal
TEN_PERCENT = math.log(1.1)
MOST_STEPS = 60  # of Gauss-Newton or Levenberg-Marquardt to a minimum
ROUNDING = 1e-9  # of the largest of such numbers: smaller ones are rounding


class Verdict(StrEnum):
    """Quality of an estimate."""

    IDENTIFIED = "identified"
    POOR = "poorly identified"
    NOT = "not identifiable from these data"


@dataclass(frozen=True)
class Unknown:
    """A parameter or group to estimate, its unit and its value in the file (`nominal`, NaN where it gives none).

    `formula` is the group over parameters, `joint` and `quantity` (`K`, `FV`, `M` ...) what it belongs to, `about` the
    value about which its column is linear. Positive unknowns are estimated by their logarithms, with `nominal` as the
    initial value and `prior_std` of the logarithm; `of_file` is false where that value is a guess. `is_nuisance` for
    what is fitted and not reported, `is_gain` for gains of a controller.
    """

    label: str
    unit: str
    nominal: float = math.nan
    prior_std: float = math.inf
    formula: str = ""
    joint: str = ""
    quantity: str = ""
    about: float = 0.0
    is_nuisance: bool = False
    of_file: bool = True
    is_gain: bool = False


@dataclass(frozen=True)
class Estimate:
    """Value and standard deviation of an unknown in its unit (NaN if not identifiable), and the verdict."""

    unknown: Unknown
    value: float
    std: float
    verdict: Verdict
    reason: str = ""

    @property
    def relative(self) -> float:
        """std / |value|."""
        return self.std / abs(self.value) if self.value else math.inf


def largest_of_chance(count: int = 1) -> float:
    """Return the one-sided bound, in standard deviations, that none of `count` estimates exceeds by chance."""
    return NormalDist().inv_cdf(1 - ALARM / max(count, 1))


def is_identified(value: float, std: float) -> bool:
    """Whether the standard deviation of an estimate is at most a tenth of its value."""
    return std <= WELL_KNOWN * abs(value)


def estimates_of_logarithms(unknowns: Sequence[Unknown], x: Array, std: Array, factor: float) -> tuple[Estimate, ...]:
    """Return the estimates exp(x), whose logarithms have standard deviations `std`, judged by a prior of ln(factor)."""
    verdicts = [_verdict(s / math.log(factor)) for s in std.tolist()]
    values = np.exp(x).tolist()
    return tuple(
        Estimate(unknown, value, value * s, verdict)
        for unknown, value, s, verdict in zip(unknowns, values, std.tolist(), verdicts, strict=True)
    )


def _verdict(fraction: float) -> Verdict:
    return Verdict.IDENTIFIED if fraction < WELL_KNOWN else Verdict.POOR if fraction < HARDLY_KNOWN else Verdict.NOT


def undetermined_directions(unknowns: Sequence[Unknown], x: Array, covariance: Array, factor: float) -> list[str]:
    """Return sentences on directions of ln p that data do not determine, each with its parameters.

    These are eigenvectors of the `covariance` of x = ln p with more than half of the prior's standard deviation.
    """
    reported = [k for k, unknown in enumerate(unknowns) if not unknown.is_nuisance]
    values, vectors = np.linalg.eigh(covariance[np.ix_(reported, reported)])
    null = vectors[:, values > (HARDLY_KNOWN * math.log(factor)) ** 2]
    labels, sizes = [unknowns[k].label for k in reported], np.exp(x[reported])
    single, sentences = [], []
    for direction in directions(null):
        large = np.abs(direction) > SMALL_PART * np.abs(direction).max()
        members = [k for k in np.argsort(-np.abs(direction)) if large[k]]
        if len(members) == 1:
            single.append(labels[members[0]])
        else:
            sentences.append(_sentence([labels[k] for k in members], direction[members], sizes[members]))
    if single:
        what = f"these tests do not determine {enumeration(single)}"
        sentences.insert(
            0, f"{what}: {'its value is' if len(single) == 1 else 'their values are'} close to the initial"
        )
    return sentences


def directions(null: Array) -> list[Array]:
    """Return a basis of a space (p, k) of directions, each with a parameter that no other direction contains."""
    if not null.size:
        return []
    pivots = for_vibrations("scipy.linalg").qr(null.T, mode="r", pivoting=True)[1][: null.shape[1]]
    return list((null @ np.linalg.inv(null[pivots])).T)


def _sentence(labels: Sequence[str], direction: Array, sizes: Array) -> str:
    """Return a sentence on which combination of two or more parameters the tests determine."""
    named = enumeration(labels)
    if len(labels) == 2:
        # Along it d ln p1 / d ln p2 = ratio: 1/p1 + 1/p2, p1 + p2, p1 p2 or p1 / p2 stays.
        ratio, (p1, p2) = float(direction[0] / direction[1]), sizes
        for wanted, what in (
            (-p1 / p2, f"in series: these tests determine only 1/{labels[0]} + 1/{labels[1]}"),
            (-p2 / p1, f"in parallel: these tests determine only {labels[0]} + {labels[1]}"),
            (1.0, f"together: these tests determine only {labels[0]}/{labels[1]}"),
        ):
            if abs(ratio - wanted) <= SAME_SLOPE * abs(wanted):
                return f"{named} {what}"
    changes = ", ".join(f"{_percent(x / direction[0])} {label}" for x, label in zip(direction, labels, strict=True))
    return f"{named} are not distinguishable: {changes} together change nothing in these tests"


def _percent(fraction: float) -> str:
    return f"{100 * math.expm1(TEN_PERCENT * float(np.clip(fraction, -20, 20))):+.2g} %"
