"""Lemma 1, the running error bound: how far each computed value is from the exact one.

A program computes z~ = op(x~, y~) + e where exact arithmetic has z = op(x, y); x~ and y~ are at most E_x and E_y off.
Then |z~ - z| <= E_z by recursion, with the products of errors kept:

    sum        E_x + E_y + l
    product    |x| E_y + |y| E_x + E_x E_y + l
    quotient   (E_x + |z| E_y)/(min |y| - E_y) + l,    not bounded where min |y| <= E_y

Proof: x~ y~ - x y = x (y~ - y) + y (x~ - x) + (x~ - x)(y~ - y), and x~/y~ - x/y = (x~ - x - z (y~ - y))/y~.
The rounding l of an operation is u ufp(|z~|): half the distance of neighbouring numbers, where ufp is the largest power
of two that is not larger. It is 3 times that for sines and cosines (1.5 ulp), zero for signs and powers of two.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, TypeAlias

import numpy as np

from symoro_elastic.codegen.precision import DOUBLE, MIXED, SINGLE
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.numerics.guarantees.intervals import INTERVALS, Interval, interval
from symoro_elastic.numerics.guarantees.shares import is_smooth_sign, is_wide, of_smooth_sign, passed_in_shares
from symoro_elastic.symbolic.arithmetic import evaluate, multiprecision
from symoro_elastic.symbolic.expression import Constant, Expression, Level, Operand
from symoro_elastic.symbolic.operations import (
    ADD,
    ATAN2,
    COS,
    DIVIDE,
    MAXIMUM,
    MINIMUM,
    MULTIPLY,
    NEGATE,
    SIGN,
    SIN,
    SQRT,
    SUBTRACT,
    SYMBOL,
)

UPWARDS = 1 + 2.0**-48
"""Errors are sums and products of at most ten numbers that are not negative: this covers their own rounding."""
NEARLY = Fraction(999, 1000)
EXACT = (NEGATE, SIGN, MINIMUM, MAXIMUM)
"""Operations that round nothing."""
OF_CIRCLE, OF_ARC = 3.0, 4.0
"""Roundings of a sine or cosine (1.5 ulp), and of an arc tangent (2 ulp), in units of u ufp."""


@dataclass(frozen=True)
class Rounding:
    """The rounding of a precision: half of the distance of numbers at 1, and that of the smallest numbers.

    `u_angle` is that of the arithmetic in which angles and their sines are computed; where it is not `u`, arguments are
    rounded before they are used for anything else.
    """

    name: str
    u: float
    u_angle: float
    least: float
    largest: float

    @property
    def is_mixed(self) -> bool:
        """Whether angles have another precision than the rest."""
        return self.u != self.u_angle

    @property
    def of_angles(self) -> Rounding:
        """That in which angles and their sines are computed."""
        return ROUNDINGS[DOUBLE.name] if self.is_mixed else self

    def error_of_constant(self, x: Constant) -> Array:
        """How far a number of the text is off."""
        return constant_error(x, self)


U_DOUBLE, U_SINGLE = 2.0**-53, 2.0**-24
ROUNDINGS: Mapping[str, Rounding] = {
    DOUBLE.name: Rounding(DOUBLE.name, U_DOUBLE, U_DOUBLE, 2.0**-1074, float(np.finfo(np.float64).max)),
    SINGLE.name: Rounding(SINGLE.name, U_SINGLE, U_SINGLE, 2.0**-150, float(np.finfo(np.float32).max)),
    MIXED.name: Rounding(MIXED.name, U_SINGLE, U_DOUBLE, 2.0**-150, float(np.finfo(np.float32).max)),
}
"""The roundings of the precisions that certificates are made for."""


@dataclass(frozen=True)
class Bounds:
    """Of each node, by number: the `range` of its exact value, its `error`, and the share `local` of its own rounding.

    Arrays have the `shape` of the sub-boxes, or are numbers where they are the same in all of them.
    """

    rounding: Rounding
    shape: tuple[int, ...]
    range: dict[int, Interval]
    error: dict[int, Array]
    local: dict[int, Array]

    def without(self, nodes: Iterable[Expression]) -> Bounds:
        """Those of all other nodes."""
        left_out = {node.id for node in nodes}
        kept = ({k: x for k, x in of.items() if k not in left_out} for of in (self.range, self.error, self.local))
        return Bounds(self.rounding, self.shape, *kept)  # type: ignore[arg-type]

    def range_of(self, x: Operand) -> Interval:
        """The values of a node or a constant in exact arithmetic."""
        return self.range[x.id] if type(x) is Expression else interval(x)

    def error_of(self, x: Operand) -> Array:
        """How far the computed value of a node or a constant is off."""
        return self.error[x.id] if type(x) is Expression else self.rounding.error_of_constant(x)

    def computed(self, x: Operand) -> Interval:
        """The values of a node or a constant as the program computes it."""
        return self.range_of(x).widened(self.error_of(x))


Narrowing: TypeAlias = Callable[[Interval], Interval]
Known: TypeAlias = Mapping[int, Narrowing]
"""What is known of nodes beside their intervals, by number: a function that makes the interval smaller."""


def running_errors(
    nodes: Iterable[Expression],
    box: Mapping[str, Interval],
    rounding: Rounding,
    angles: Collection[int] = (),
    known: Known | None = None,
    before: Bounds | None = None,
    proven: Mapping[int, Array] | None = None,
) -> Bounds:
    """Ranges and errors of nodes in order, where variables are in a box.

    `angles` are the numbers of nodes that are computed in the precision of angles, where that is another one; `known`
    makes ranges smaller, `proven` are errors that are known in another way. `before` has bounds of the nodes before.
    """
    shape = np.broadcast_shapes((1,), *(x.low.shape for x in box.values()))
    bounds = before or Bounds(rounding, shape, {}, {}, {})
    of_angles = Bounds(rounding.of_angles, shape, bounds.range, {}, {})
    with np.errstate(all="ignore"):
        for node in nodes:
            found = range_of_node(node, bounds, box)
            bounds.range[node.id] = (known or {}).get(node.id, _itself)(found)
            if rounding.is_mixed and node.id in angles:
                _add_error(node, of_angles, of_angles, False)
            _add_error(node, bounds, of_angles if rounding.is_mixed else bounds, rounding.is_mixed)
            if proven and node.id in proven:
                bounds.error[node.id] = np.minimum(bounds.error[node.id], proven[node.id])
    return bounds


def _itself(found: Interval) -> Interval:
    return found


def range_of_node(node: Expression, bounds: Bounds, box: Mapping[str, Interval]) -> Interval:
    """The values of a node in exact arithmetic, from those of its operands."""
    if node.operation == SYMBOL:
        return box[node.operands[0]]
    if node.level == Level.CONSTANT:
        return constant_interval(node)
    found: Interval = INTERVALS.operations[node.operation](*map(bounds.range_of, node.operands))
    return found.meeting(of_smooth_sign(node, bounds.range_of)) if is_smooth_sign(node) else found


def constant_interval(node: Expression) -> Interval:
    """The interval of an expression of numbers, from 50 digits."""
    exact = evaluate([node], {}, multiprecision())(node)
    nearest = np.array(float(exact))
    return Interval(np.nextafter(nearest, -np.inf), np.nextafter(nearest, np.inf))


def _add_error(node: Expression, bounds: Bounds, angles: Bounds, narrows: bool) -> None:
    """Add the error of one node, that of angles from their own bounds."""
    z, u = bounds.range[node.id], bounds.rounding.u
    if node.operation == SYMBOL or node.level == Level.CONSTANT:
        exact = node.operation == SYMBOL and not narrows
        twice = 0.0 if node.operation == SYMBOL or u == U_DOUBLE else U_DOUBLE * z.magnitude  # written as a double
        local = np.zeros_like(z.low) if exact else UPWARDS * (_roundoff(z.magnitude, bounds.rounding) + twice)
        bounds.local[node.id] = bounds.error[node.id] = local
        return
    of_circle = node.operation in (SIN, COS) and type(node.operands[0]) is Expression
    source = angles if of_circle and node.operands[0].id in angles.error else bounds
    errors = [source.error_of(x) for x in node.operands]
    ranges = [bounds.range_of(x) for x in node.operands]
    passed = PASSED[node.operation](z, ranges, errors)
    if node.operation == SIGN and _keeps_sign(node.operands[0], bounds):
        passed = np.zeros_like(passed)
    if node.operation in (DIVIDE, SQRT) and is_wide(ranges[-1]):
        in_shares = passed_in_shares(node, bounds.range_of, bounds.error_of, u, bounds.rounding.least)
        passed = np.fmin(passed, in_shares)
    is_narrowed = source.rounding.u < u
    local = _local(node, (z.magnitude + passed) * UPWARDS, bounds.rounding, is_narrowed)
    if is_narrowed:
        local = local + OF_CIRCLE * source.rounding.u
    bounds.local[node.id] = local * UPWARDS
    bounds.error[node.id] = _bounded((passed + local) * UPWARDS, z)


def _keeps_sign(x: Operand, bounds: Bounds) -> bool:
    """Whether the sign of a computed value is right: of exact numbers, their sums, and products with 1 or more.

    Rounding is monotonic, and sums of numbers do not underflow; smaller factors may make a zero of the least numbers.
    """
    if not np.any(bounds.error_of(x)):
        return True
    if type(x) is not Expression or x.operation not in (ADD, SUBTRACT, NEGATE, MULTIPLY):
        return False
    if x.operation in (ADD, SUBTRACT):
        return not any(np.any(bounds.error_of(one)) for one in x.operands)
    if x.operation == NEGATE:
        return _keeps_sign(x.operands[0], bounds)
    pairs = (x.operands, x.operands[::-1])
    return any(np.all(bounds.computed(b).least_magnitude >= 1) and _keeps_sign(a, bounds) for a, b in pairs)


def _bounded(error: Array, z: Interval) -> Array:
    return np.where(z.is_bounded & np.isfinite(error), error, np.inf)


def _local(node: Expression, magnitude: Array, rounding: Rounding, is_narrowed: bool) -> Array:
    """The rounding of one operation, whose result has at most this magnitude; of a sine that is narrowed only that."""
    if node.operation in EXACT or (node.operation in (MULTIPLY, DIVIDE) and is_power_of_two(node.operands[1])):
        return np.full_like(magnitude, rounding.least if node.operation in (MULTIPLY, DIVIDE) else 0.0)
    if node.operation in (SIN, COS):
        times = 1.0 if is_narrowed else OF_CIRCLE
        return times * _roundoff(np.minimum(magnitude, 1 - U_DOUBLE), rounding)
    return (OF_ARC if node.operation == ATAN2 else 1.0) * _roundoff(magnitude, rounding)


def is_power_of_two(x: Any) -> bool:
    """Whether a product with this, or a quotient by it, moves the exponent only."""
    if type(x) is Expression:
        return False
    return all(part & (part - 1) == 0 for part in map(int, abs(x).as_integer_ratio()))


def _roundoff(magnitude: Array, rounding: Rounding) -> Array:
    """u ufp(x), and what is lost below the smallest numbers."""
    return rounding.u * ufp(magnitude) + rounding.least


def ufp(magnitude: Array) -> Array:
    """The largest power of two that is not larger; of what is not finite, itself."""
    _, exponent = np.frexp(magnitude)
    return np.where(np.isfinite(magnitude), np.ldexp(np.sign(magnitude), exponent - 1), magnitude)


def constant_error(x: Constant, rounding: Rounding) -> Array:
    """How far a number of the text is off, which is a double or a single number."""
    single = rounding.u != U_DOUBLE
    off = abs(Fraction(float(np.float32(float(x))) if single else float(x)) - Fraction(x))
    most = UPWARDS * _roundoff(np.array(abs(float(x)) * UPWARDS), rounding) + U_DOUBLE * abs(float(x))
    tie = off > NEARLY * Fraction(float(most))  # single numbers are written as doubles: such a one may go either way
    return most if tie else np.array(float(off) * UPWARDS)


Passed: TypeAlias = Callable[[Interval, Sequence[Interval], Sequence[Array]], Array]
"""From the ranges of a result and of its operands, and from errors of these, to the error that it has from them."""


def _of_sum(z: Interval, x: Sequence[Interval], e: Sequence[Array]) -> Array:
    return e[0] + e[1]


def _of_product(z: Interval, x: Sequence[Interval], e: Sequence[Array]) -> Array:
    return x[0].magnitude * e[1] + x[1].magnitude * e[0] + e[0] * e[1]


def _of_quotient(z: Interval, x: Sequence[Interval], e: Sequence[Array]) -> Array:
    left = x[1].least_magnitude / UPWARDS - e[1]
    return np.where(left > 0, (e[0] + z.magnitude * e[1]) / np.where(left > 0, left, 1.0), np.inf)


def _of_circle(z: Interval, x: Sequence[Interval], e: Sequence[Array]) -> Array:
    """Sines and cosines have slopes of at most 1."""
    return e[0]


def _of_root(z: Interval, x: Sequence[Interval], e: Sequence[Array]) -> Array:
    left = x[0].low / UPWARDS - e[0]
    slope = np.sqrt(np.maximum(left, 0.0)) + np.sqrt(np.maximum(x[0].low, 0.0))
    return np.where(e[0] == 0, 0.0, np.where(left > 0, e[0] / np.where(left > 0, slope, 1.0), np.inf))


def _of_arc(z: Interval, x: Sequence[Interval], e: Sequence[Array]) -> Array:
    """The slope of an arc tangent is one over the distance from the origin."""
    moved = np.hypot(e[0], e[1])
    left = np.hypot(x[0].least_magnitude, x[1].least_magnitude) / UPWARDS - moved
    jumps = (x[1].low <= e[1]) & (x[0].low <= e[0]) & (x[0].high >= -e[0])  # without errors, too: by the sign of -0.0
    near = jumps | (moved > 0) & (left <= 0)
    return np.where(near, np.inf, moved / np.where(left > 0, left, 1.0))


def _of_sign(z: Interval, x: Sequence[Interval], e: Sequence[Array]) -> Array:
    """A sign is wrong by 2 where errors reach over zero."""
    return np.where((e[0] > 0) & (x[0].least_magnitude <= e[0]), 2.0, 0.0)


def _of_extremum(z: Interval, x: Sequence[Interval], e: Sequence[Array]) -> Array:
    return np.maximum(e[0], e[1])


PASSED: Mapping[str, Passed] = {
    ADD: _of_sum,
    SUBTRACT: _of_sum,
    NEGATE: _of_circle,
    MULTIPLY: _of_product,
    DIVIDE: _of_quotient,
    SIN: _of_circle,
    COS: _of_circle,
    SQRT: _of_root,
    ATAN2: _of_arc,
    SIGN: _of_sign,
    MINIMUM: _of_extremum,
    MAXIMUM: _of_extremum,
}
"""What each operation makes of the errors of its operands."""
