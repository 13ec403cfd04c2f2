"""Upper bounds on the largest of many future errors, from a sample of errors.

Above a high threshold errors have a tail P(e > x) = c x^-a. Of n errors, u is the one of rank k + 1 and
S = sum ln(e_i / u) over the k above it. With G = a S of a gamma distribution of shape k, the largest of m more errors
is below x with the probability

    E[(1 + m/n (x/u)^-a)^-(k + 1)],    a = G / S,

whatever c and a are; lighter tails are within the bound more often.

An error relative to a result of d entries has another tail further out, where all entries cancel: a result below y has
the probability c y^a, a being about d, and the absolute error is what it is at the smallest results. With u the result
of rank k + 1 from below, S = sum ln(u / y_i), and N the mean of (absolute error)^a at the smallest results, the same
holds with (x/u)^-a replaced by N (x u)^-a.

Bounds are fitted to a higher probability (`FITTED`) than what they promise (`CONFIDENCE`), which tests draw.

Whatever the distribution, no bound holds for the largest of m > n more errors: n states show nothing of peaks that one
state in m has. But where a share s of all states has larger errors than any drawn, all n draws miss them with the
probability (1 - s)^n (Wilks 1941): this bounds s. No bound here is below the largest error drawn, so s holds for it.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from symoro_elastic.foundation.array_types import Array

MOST_IN_TAIL, SHARE_IN_TAIL, SHARE_SMALL = 50, 20, 50
"""The tail is a twentieth of the errors, at most fifty of them; small results are a fiftieth, and at least the tail."""
FEWEST_IN_TAIL = 2
CONFIDENCE, FITTED = 0.95, 0.99
GRID, SPREAD, HALVINGS = 201, 8.0, 60
FARTHEST = 300.0
"""Largest distance of ln x from ln u that is searched."""


def share_beyond(drawn: int, judged: int = 1) -> float:
    """Return an upper bound, with `CONFIDENCE`, of the fraction of states whose errors exceed all `drawn` ones.

    It holds for errors of any distribution. `judged` is how many programs were judged at as many states each until
    one was accepted.
    """
    return -math.expm1(math.log((1 - FITTED) / judged) / drawn)


def bound_of_more(errors: Array, more: int) -> float:
    """Return a bound on the largest of `more` errors that are not drawn yet.

    `errors` (n,) are drawn at random, positive; infinite where one of them is, or where they are fewer than 40.
    """
    tail = _tail(errors)
    if tail < FEWEST_IN_TAIL:
        return math.inf
    logs = np.log(np.sort(errors)[-tail - 1 :])
    spread = float((logs[1:] - logs[0]).sum())
    largest = float(errors.max())
    return max(largest, _bound(tail, more / len(errors), spread, float(logs[0]), np.zeros_like)) if spread else largest


def bound_of_quotients(errors: Array, results: Array, more: int) -> float:
    """Return a bound on the largest of `more` quotients error / result, by how often results are small.

    `errors` and `results` (n,) are absolute, drawn at random, positive.
    """
    tail = _tail(errors / results)
    if tail < FEWEST_IN_TAIL:
        return math.inf
    small = np.argsort(results)[: max(tail + 1, len(results) // SHARE_SMALL)]
    logs, absolute = np.log(results[small[: tail + 1]]), np.log(errors[small])
    spread, most = float((logs[-1] - logs[:-1]).sum()), float(absolute.max())
    largest = float((errors / results).max())
    if not spread:
        return largest

    def moments(a: Array) -> Array:
        return np.asarray(np.log(np.exp(a[:, None] * (absolute - most)).mean(axis=1)))

    return max(largest, _bound(tail, more / len(errors), spread, most - float(logs[-1]), moments))


def _tail(errors: Array) -> int:
    """Return how many errors are the tail; none where one of them is infinite."""
    return min(MOST_IN_TAIL, len(errors) // SHARE_IN_TAIL) if np.isfinite(errors).all() else 0


def _bound(tail: int, ratio: float, spread: float, log_u: float, log_moments: Callable[[Array], Array]) -> float:
    """Return a bound on the largest of m further errors that holds with probability `FITTED`; `ratio` is m/n."""
    width = SPREAD * math.sqrt(tail)
    shape = np.linspace(max(tail - width, 0.0), tail + width + SPREAD, GRID)[1:]
    density = np.exp((tail - 1) * np.log(shape / tail) - (shape - tail))
    density, a = density / density.sum(), shape / spread
    moments = log_moments(a) + math.log(ratio)
    low, high = -FARTHEST, FARTHEST
    for _ in range(HALVINGS):
        middle = (low + high) / 2
        expected = np.exp(np.minimum(moments - a * middle, FARTHEST))
        within = float(density @ np.exp(-(tail + 1) * np.log1p(expected)))
        low, high = (middle, high) if within < FITTED else (low, middle)
    return math.exp(high + log_u) if high + log_u < FARTHEST else math.inf
