"""Lemma 1 in shares: errors of a quotient by a divisor of variable size, such as sqrt(qd^2 + vs^2).

The error of a divisor where it is large, over the divisor where it is small, is a useless bound. Let
|x~ - x| <= r |x| + a: a share r of the value, and an absolute part a. Then, before the rounding of the operation,

    product    r = r_x + r_y + r_x r_y,        a = |x| a_y (1 + r_x) + |y| a_x (1 + r_y) + a_x a_y
    sum        r = max(r_x, r_y),              a = a_x + a_y,         of numbers of one sign; else r = 0, a = E_x + E_y
    quotient   r = (r_x + s_y)/(1 - s_y),      a = a_x/(min|y| (1 - s_y)),        s_y = r_y + a_y/min|y| < 1
    root       r = r_x/(1 + sqrt(1 - s_x)),    a = a_x/(sqrt(min x) (1 + sqrt(1 - s_x))),        s_x < 1

*Proof.* x~/y~ - x/y = (x~ - x - z (y~ - y))/y~ with |y~ - y| <= s_y |y|, and sqrt(x~) - sqrt(x) is x~ - x over the sum
of both roots, sqrt(x~) >= sqrt(x) sqrt(1 - s_x). Rounding adds u (|z| + its error), a share of u and u times the error,
and what is lost below the smallest numbers; arguments that are narrowed have u alone. Any node has r = 0, a = E, too:
operands are followed `DEPTH` operations down.

**A smooth sign** x/sqrt(x^2 + w), w >= 0, is at most 1 in magnitude, as x^2 <= x^2 + w: intervals, which take both x
for different ones, have |x|/sqrt(w).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TypeAlias

import numpy as np

from symoro_elastic.foundation.array_types import Array
from symoro_elastic.numerics.guarantees.intervals import Interval
from symoro_elastic.symbolic.expression import Expression, Level, Operand
from symoro_elastic.symbolic.operations import ADD, DIVIDE, MULTIPLY, NEGATE, SQRT, SUBTRACT, SYMBOL

DEPTH = 6
WIDE = 2.0
"""Ratio of magnitudes of a divisor above which shares are used."""
UPWARDS = 1 + 2.0**-46
Share: TypeAlias = "tuple[Array | float, Array]"
"""Relative part r and absolute part a of an error."""
Ranges: TypeAlias = Callable[[Operand], Interval]
Errors: TypeAlias = Callable[[Operand], Array]


def is_smooth_sign(node: Expression) -> bool:
    """Whether a node is x/sqrt(x x + w)."""
    x, root = node.operands if node.operation == DIVIDE else (0, 0)
    inside = root.operands[0] if isinstance(root, Expression) and root.operation == SQRT else None
    if not isinstance(x, Expression) or not isinstance(inside, Expression) or inside.operation != ADD:
        return False
    return any(_is_square_of(x, operand) for operand in inside.operands)


def _is_square_of(x: Expression, square: Operand) -> bool:
    return (
        isinstance(square, Expression)
        and square.operation == MULTIPLY
        and all(isinstance(factor, Expression) and factor.positive is x.positive for factor in square.operands)
    )


def of_smooth_sign(node: Expression, of: Ranges) -> Interval:
    """The range of x/sqrt(x x + w); no bound where w may be negative."""
    first, second = node.operands[1].operands[0].operands
    w = second if _is_square_of(node.operands[0], first) else first
    bounded = of(w).low >= 0
    return Interval(np.where(bounded, -1.0, -np.inf), np.where(bounded, 1.0, np.inf))


def is_wide(x: Interval) -> bool:
    """Whether the magnitudes of a nonzero divisor vary by more than `WIDE`."""
    least = x.least_magnitude
    return bool(np.any((least > 0) & (x.magnitude > WIDE * least)))


def error_in_shares(node: Expression, of: Ranges, error_of: Errors, u: float, lost: float) -> Array:
    """The error of a quotient or a root before its own rounding; infinite where it has no bound."""
    r, a = _Shares(of, error_of, u, lost).before_rounding(node, DEPTH)
    error = (r * of(node).magnitude + a) * UPWARDS
    return np.where(np.isfinite(error), error, np.inf)


class _Shares:
    """Relative and absolute parts of errors of operands."""

    def __init__(self, of: Ranges, error_of: Errors, u: float, lost: float) -> None:
        self._range, self._error, self._u, self._lost = of, error_of, u, lost

    def of(self, x: Operand, depth: int) -> Share:
        """Relative part r and absolute part a of the error of an operand, from `depth` levels of operations."""
        if not isinstance(x, Expression):
            return float(self._error(x)) / abs(float(x)) if x else 0.0, np.array(0.0)
        if x.operation == SYMBOL and np.any(self._error(x)):
            return self._u, np.array(self._lost)
        if not depth or x.level == Level.CONSTANT or x.operation not in (*_RULES, NEGATE):
            return 0.0, self._error(x)
        if x.operation == NEGATE:
            return self.of(x.operands[0], depth - 1)
        r, a = self.before_rounding(x, depth)
        absolute: Array = np.where(np.isnan(a), np.inf, (a * (1 + self._u) + self._lost) * UPWARDS)
        return (r + self._u * (1 + r)) * UPWARDS, absolute

    def before_rounding(self, node: Expression, depth: int) -> Share:
        """Relative part r and absolute part a of the error of a node before its own rounding."""
        ranges = [self._range(x) for x in node.operands]
        return _RULES[node.operation](ranges, [self.of(x, depth - 1) for x in node.operands])


def _of_product(x: Sequence[Interval], e: Sequence[Share]) -> Share:
    (r, a), (s, b) = e
    return r + s + r * s, x[0].magnitude * b * (1 + r) + x[1].magnitude * a * (1 + s) + a * b


def _of_sum(x: Sequence[Interval], e: Sequence[Share]) -> Share:
    one_sign = ((x[0].low >= 0) & (x[1].low >= 0)) | ((x[0].high <= 0) & (x[1].high <= 0))
    (r, a), (s, b) = e
    separate_errors = r * x[0].magnitude + a + s * x[1].magnitude + b
    return np.where(one_sign, np.maximum(r, s), 0.0), np.where(one_sign, a + b, separate_errors)


def _of_quotient(x: Sequence[Interval], e: Sequence[Share]) -> Share:
    (r, a), (s, b) = e
    least = x[1].least_magnitude
    off = (s + b / least) * UPWARDS
    remaining = np.where(off < 1, 1 - off, np.nan)
    return np.where(off < 1, (r + off) / remaining, np.inf), a / (least * remaining)


def _of_root(x: Sequence[Interval], e: Sequence[Share]) -> Share:
    r, a = e[0]
    off = (r + a / x[0].low) * UPWARDS
    both = 1 + np.sqrt(np.where((x[0].low > 0) & (off < 1), 1 - off, np.nan))
    return np.where(np.isnan(both), np.inf, r / both), a / (np.sqrt(np.maximum(x[0].low, 0.0)) * both)


_RULES: dict[str, Callable[[Sequence[Interval], Sequence[Share]], Share]] = {
    ADD: _of_sum,
    SUBTRACT: lambda x, e: _of_sum([x[0], -x[1]], e),
    MULTIPLY: _of_product,
    DIVIDE: _of_quotient,
    SQRT: _of_root,
}
