"""Exact values of programs, enclosed in balls: numbers with a proven bound of their error (python-flint's arb)."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from fractions import Fraction
from functools import cache
from typing import Any

from symoro_elastic.packages import imported
from symoro_elastic.symbolic.arithmetic import Arithmetic, evaluate_nodes, library
from symoro_elastic.symbolic.operations import COSPI, SIGN
from symoro_elastic.symbolic.program import Program

Balls = list[Any]

FIRST_BITS, MOST_BITS = 160, 20_480
PROVEN_ZERO = 1e-100
"""Results that are proven smaller are zero."""


class NoEnclosure(ArithmeticError):
    """No finite enclosure exists: the model divides by zero at this state, or by a number within rounding of it."""


def enclosures(program: Program, symbols: Mapping[str, float], negligible: float) -> dict[str, Balls]:
    """Return results of a program by name, entry by entry, for these exact inputs.

    Precision is raised until every radius is below `negligible` times the largest entry of its result, or the
    result is proven zero. Raises `NoEnclosure`, and `InputError` where python-flint is missing.
    """
    flint = _flint()
    bits = FIRST_BITS
    while bits <= MOST_BITS:
        with flint.ctx.workprec(bits):
            results = _evaluated(program, symbols)
            if all(_is_tight(entries, negligible) for entries in results.values()):
                return results
        bits *= 2
    raise NoEnclosure(f"no enclosure with {MOST_BITS} bits: the model divides by a number within rounding of zero")


def sums(parts: Sequence[Sequence[float]]) -> Balls:
    """Return the exact sums of numbers given in parts."""
    flint = _flint()
    with flint.ctx.workprec(FIRST_BITS):
        return [sum(map(flint.arb, entry), flint.arb(0)) for entry in zip(*parts, strict=True)]


def distance(computed: Balls, entries: Balls) -> float:
    """Return the largest difference from enclosed entries over the largest of these, or over 1 where all are zero.

    A proven upper bound, infinite where an entry found is not finite.
    """
    flint = _flint()
    if not all(x.is_finite() for x in computed):
        return math.inf
    with flint.ctx.workprec(2 * FIRST_BITS):
        difference = max((abs(x - y).upper() for x, y in zip(computed, entries, strict=True)), default=flint.arb(0))
        return float((difference / scale(entries)).upper())


def scale(entries: Balls) -> Any:
    """Return the largest entry, from below; 1 where all are zero."""
    largest = max((entry.abs_lower() for entry in entries), default=0)
    return largest if largest > PROVEN_ZERO else _flint().arb(1)


def is_out_of_range(entries: Balls, most: float) -> bool:
    """Return whether an entry is surely larger than the largest number of a precision."""
    return any(entry.abs_lower() > most for entry in entries)


def _is_tight(entries: Balls, negligible: float) -> bool:
    if not all(entry.is_finite() for entry in entries):
        return False
    largest = max((entry.abs_lower() for entry in entries), default=0)
    allowed = largest * negligible if largest > PROVEN_ZERO else PROVEN_ZERO
    return all(entry.rad() <= allowed for entry in entries)


def _evaluated(program: Program, symbols: Mapping[str, float]) -> dict[str, Balls]:
    balls, arb = _arithmetic(), _flint().arb
    value = evaluate_nodes(program.nodes, {name: arb(x) for name, x in symbols.items()}, balls)
    return {output.name: [value(x) for x in output.entries] for output in program.outputs}


@cache
def _arithmetic() -> Arithmetic[Any]:
    flint = _flint()
    arb = flint.arb

    def number(x: Fraction | int) -> Any:
        return arb(flint.fmpq(*Fraction(x).as_integer_ratio()))

    return Arithmetic(number, library(arb, {SIGN: arb.sgn, COSPI: arb.cos_pi}))


@cache
def _flint() -> Any:
    return imported("flint", "an error bound", "accuracy")
