"""Certificates whose errors and ranges are the smaller ones of intervals and of polynomials."""

from __future__ import annotations

import math
from dataclasses import replace
from fractions import Fraction

import numpy as np

from symoro_elastic.foundation.progress import Progress, no_progress
from symoro_elastic.numerics.arrays import arithmetic
from symoro_elastic.numerics.guarantees.box import Box
from symoro_elastic.numerics.guarantees.certificate import Certificate, EntryBound, Subject
from symoro_elastic.numerics.guarantees.grid import WORK, largest
from symoro_elastic.numerics.guarantees.polynomial_rounding import rounding_bound
from symoro_elastic.symbolic.arithmetic import evaluate
from symoro_elastic.symbolic.expression import Expression, Operand

DRAWN = 500
"""States whose middle value is where a range is looked for."""


def by_polynomials(certificate: Certificate, subject: Subject, progress: Progress = no_progress) -> Certificate:
    """Return the certificate of a subject with the errors and ranges that polynomials prove, where these are smaller.

    Results that are no polynomials, as those of direct models, keep theirs. `progress` is called after each result.
    """
    subject = subject.as_printed()
    entries: list[EntryBound] = []
    found: dict[int, tuple[float, float, float]] = {}
    for k, (entry, x) in enumerate(zip(certificate.entries, subject.results, strict=True)):
        if type(x) is Expression:
            if x.positive.id not in found:
                found[x.positive.id] = _proven(x.positive, subject)
            entry = _smaller(entry, found[x.positive.id], x is not x.positive)  # noqa: PLW2901
        entries.append(entry)
        progress(k + 1, len(certificate.entries))
    return replace(certificate, entries=tuple(entries))


def _proven(x: Operand, subject: Subject) -> tuple[float, float, float]:
    """Return the error, and the range, of an expression; infinite where it is no polynomial."""
    error = rounding_bound(x, subject.box, subject.rounding).bound
    if not math.isfinite(error):
        return math.inf, -math.inf, math.inf
    middle = _middle(x, subject.box)
    half = largest((x, Fraction(middle)), subject.box, work=WORK).bound
    return error, float(np.nextafter(middle - half, -math.inf)), float(np.nextafter(middle + half, math.inf))


def _smaller(entry: EntryBound, found: tuple[float, float, float], is_negative: bool) -> EntryBound:
    error, low, high = found
    low, high = (-high, -low) if is_negative else (low, high)
    error = min(entry.error, error)
    return replace(
        entry, error=error, likely=min(entry.likely, error), low=max(entry.low, low), high=min(entry.high, high)
    )


def _middle(x: Operand, box: Box) -> float:
    """Return the middle of the values at drawn states."""
    states = box.states(DRAWN, np.random.default_rng(0))
    value = evaluate([x], states, arithmetic(np.float64))(x)
    return float(np.min(value) / 2 + np.max(value) / 2)
