"""Lemma 1, the running error bound: bounds of the errors of all computed values.

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
from symoro_elastic.numerics.guarantees.shares import error_in_shares, is_smooth_sign, is_wide, of_smooth_sign
from symoro_elastic.symbolic import operations as op
from symoro_elastic.symbolic.arithmetic import evaluate, multiprecision
from symoro_elastic.symbolic.expression import Constant, Expression, Level, Operand

UPWARDS = 1 + 2.0**-48
"""Factor that covers the rounding of error bounds, which are sums and products of at most ten nonnegative numbers."""
NEARLY = Fraction(999, 1000)
EXACT = (op.NEGATE, op.SIGN, op.MINIMUM, op.MAXIMUM)
"""Operations without rounding."""
OF_CIRCLE, OF_ARC = 3.0, 4.0
"""Roundings of a sine or cosine (1.5 ulp), and of an arc tangent (2 ulp), in units of u ufp."""


@dataclass(frozen=True)
class Rounding:
    """The rounding of a precision: unit roundoff `u`, and half of the smallest number `least`.

    `u_angle` is the unit roundoff of angles and their sines; if it differs from `u`, arguments are rounded before any
    other use.
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
        """The rounding of angles and their sines."""
        return ROUNDINGS[DOUBLE.name] if self.is_mixed else self

    def error_of_constant(self, x: Constant) -> Array:
        """Error of a literal number."""
        return constant_error(x, self)


U_DOUBLE, U_SINGLE = 2.0**-53, 2.0**-24
ROUNDINGS: Mapping[str, Rounding] = {
    DOUBLE.name: Rounding(DOUBLE.name, U_DOUBLE, U_DOUBLE, 2.0**-1074, float(np.finfo(np.float64).max)),
    SINGLE.name: Rounding(SINGLE.name, U_SINGLE, U_SINGLE, 2.0**-150, float(np.finfo(np.float32).max)),
    MIXED.name: Rounding(MIXED.name, U_SINGLE, U_DOUBLE, 2.0**-150, float(np.finfo(np.float32).max)),
}
"""The roundings of the precisions of certificates."""


@dataclass(frozen=True)
class Bounds:
    """Bounds by number of the node: `range` of its exact value, its `error`, and the part `local` of its own rounding.

    Arrays have the `shape` of the sub-boxes, or are numbers where they are the same in all of them.
    """

    rounding: Rounding
    shape: tuple[int, ...]
    range: dict[int, Interval]
    error: dict[int, Array]
    local: dict[int, Array]

    def without(self, nodes: Iterable[Expression]) -> Bounds:
        """The bounds of all nodes but these."""
        left_out = {node.id for node in nodes}
        remaining = ({k: x for k, x in of.items() if k not in left_out} for of in (self.range, self.error, self.local))
        return Bounds(self.rounding, self.shape, *remaining)  # type: ignore[arg-type]

    def range_of(self, x: Operand) -> Interval:
        """The range of a node or a constant in exact arithmetic."""
        return self.range[x.id] if type(x) is Expression else interval(x)

    def error_of(self, x: Operand) -> Array:
        """The error of the computed value of a node or a constant."""
        return self.error[x.id] if type(x) is Expression else self.rounding.error_of_constant(x)

    def computed(self, x: Operand) -> Interval:
        """The range of a node or a constant as computed, with errors."""
        return self.range_of(x).widen(self.error_of(x))


Narrowing: TypeAlias = Callable[[Interval], Interval]
Known: TypeAlias = Mapping[int, Narrowing]
"""Functions that narrow the intervals of nodes, by number."""


def running_errors(
    nodes: Iterable[Expression],
    box: Mapping[str, Interval],
    rounding: Rounding,
    angles: Collection[int] = (),
    narrowings: Known | None = None,
) -> Bounds:
    """Ranges and errors of nodes in order, where variables are in a box.

    `angles` are the numbers of nodes that are computed in the precision of angles, if that differs; `narrowings` narrow
    ranges.
    """
    shape = np.broadcast_shapes((1,), *(x.low.shape for x in box.values()))
    bounds = Bounds(rounding, shape, {}, {}, {})
    extend_bounds(bounds, nodes, box, angles, narrowings)
    return bounds


def extend_bounds(
    bounds: Bounds,
    nodes: Iterable[Expression],
    box: Mapping[str, Interval],
    angles: Collection[int] = (),
    narrowings: Known | None = None,
    proven: Mapping[int, Array] | None = None,
) -> None:
    """Add the ranges and errors of more nodes to bounds; `proven` are errors of nodes from other bounds."""
    rounding = bounds.rounding
    of_angles = Bounds(rounding.of_angles, bounds.shape, bounds.range, {}, {})
    with np.errstate(all="ignore"):
        for node in nodes:
            values = range_of_node(node, bounds, box)
            bounds.range[node.id] = narrowings[node.id](values) if narrowings and node.id in narrowings else values
            if rounding.is_mixed and node.id in angles:
                _add_error(node, of_angles, of_angles, False)
            _add_error(node, bounds, of_angles if rounding.is_mixed else bounds, rounding.is_mixed)
            if proven and node.id in proven:
                bounds.error[node.id] = np.minimum(bounds.error[node.id], proven[node.id])


def range_of_node(node: Expression, bounds: Bounds, box: Mapping[str, Interval]) -> Interval:
    """The values of a node in exact arithmetic, from those of its operands."""
    if node.operation == op.SYMBOL:
        return box[node.operands[0]]
    if node.level == Level.CONSTANT:
        nearest = np.array(float(evaluate([node], {}, multiprecision())(node)))
        return Interval(np.nextafter(nearest, -np.inf), np.nextafter(nearest, np.inf))
    values: Interval = INTERVALS.operations[node.operation](*map(bounds.range_of, node.operands))
    return values.meeting(of_smooth_sign(node, bounds.range_of)) if is_smooth_sign(node) else values


def _add_error(node: Expression, bounds: Bounds, angles: Bounds, narrows: bool) -> None:
    """Add the error of a node, using the bounds of `angles` for operands that are angles."""
    z, u = bounds.range[node.id], bounds.rounding.u
    if node.operation == op.SYMBOL or node.level == Level.CONSTANT:
        exact = node.operation == op.SYMBOL and not narrows
        twice = 0.0 if node.operation == op.SYMBOL or u == U_DOUBLE else U_DOUBLE * z.magnitude  # written as a double
        local = np.zeros_like(z.low) if exact else UPWARDS * (_roundoff(z.magnitude, bounds.rounding) + twice)
        bounds.local[node.id] = bounds.error[node.id] = local
        return
    of_circle = node.operation in (op.SIN, op.COS) and type(node.operands[0]) is Expression
    source = angles if of_circle and node.operands[0].id in angles.error else bounds
    errors = [source.error_of(x) for x in node.operands]
    ranges = [bounds.range_of(x) for x in node.operands]
    propagated = PASSED[node.operation](z, ranges, errors)
    if node.operation == op.SIGN and _keeps_sign(node.operands[0], bounds):
        propagated = np.zeros_like(propagated)
    if node.operation in (op.DIVIDE, op.SQRT) and is_wide(ranges[-1]):
        in_shares = error_in_shares(node, bounds.range_of, bounds.error_of, u, bounds.rounding.least)
        propagated = np.fmin(propagated, in_shares)
    is_narrowed = source.rounding.u < u
    local = _local(node, (z.magnitude + propagated) * UPWARDS, bounds.rounding, is_narrowed)
    if is_narrowed:
        local = local + OF_CIRCLE * source.rounding.u
    bounds.local[node.id] = local * UPWARDS
    error = (propagated + local) * UPWARDS
    bounds.error[node.id] = np.where(z.is_bounded & np.isfinite(error), error, np.inf)


def _keeps_sign(x: Operand, bounds: Bounds) -> bool:
    """Whether the sign of a computed value is exact: of exact numbers, their sums, and products with 1 or more.

    Rounding is monotonic, and sums of numbers do not underflow; smaller factors may make a zero of the least numbers.
    """
    if not np.any(bounds.error_of(x)):
        return True
    if type(x) is not Expression or x.operation not in (op.ADD, op.SUBTRACT, op.NEGATE, op.MULTIPLY):
        return False
    if x.operation in (op.ADD, op.SUBTRACT):
        return not any(np.any(bounds.error_of(operand)) for operand in x.operands)
    if x.operation == op.NEGATE:
        return _keeps_sign(x.operands[0], bounds)
    pairs = (x.operands, x.operands[::-1])
    return any(np.all(bounds.computed(b).least_magnitude >= 1) and _keeps_sign(a, bounds) for a, b in pairs)


def _local(node: Expression, magnitude: Array, rounding: Rounding, is_narrowed: bool) -> Array:
    """The rounding of an operation with a result of at most this magnitude; for a narrowed sine only the narrowing."""
    if node.operation in EXACT or (node.operation in (op.MULTIPLY, op.DIVIDE) and is_power_of_two(node.operands[1])):
        return np.full_like(magnitude, rounding.least if node.operation in (op.MULTIPLY, op.DIVIDE) else 0.0)
    if node.operation in (op.SIN, op.COS):
        times = 1.0 if is_narrowed else OF_CIRCLE
        return times * _roundoff(np.minimum(magnitude, 1 - U_DOUBLE), rounding)
    return (OF_ARC if node.operation == op.ATAN2 else 1.0) * _roundoff(magnitude, rounding)


def is_power_of_two(x: Any) -> bool:
    """Whether a number is a power of two, so that products with it are exact."""
    if type(x) is Expression:
        return False
    return all(part & (part - 1) == 0 for part in map(int, abs(x).as_integer_ratio()))


def _roundoff(magnitude: Array, rounding: Rounding) -> Array:
    """Bound u ufp(x) plus underflow of the rounding error of a value x of this magnitude."""
    return rounding.u * ufp(magnitude) + rounding.least


def ufp(magnitude: Array) -> Array:
    """The largest power of two that is not larger (unit in the first place); infinities and NaN unchanged."""
    _, exponent = np.frexp(magnitude)
    return np.where(np.isfinite(magnitude), np.ldexp(np.sign(magnitude), exponent - 1), magnitude)


def constant_error(x: Constant, rounding: Rounding) -> Array:
    """Error of a literal number in double or single precision."""
    single = rounding.u != U_DOUBLE
    off = abs(Fraction(float(np.float32(float(x))) if single else float(x)) - Fraction(x))
    most = UPWARDS * _roundoff(np.array(abs(float(x)) * UPWARDS), rounding) + U_DOUBLE * abs(float(x))
    tie = off > NEARLY * Fraction(float(most))  # single numbers are written as doubles: such a one may go either way
    return most if tie else np.array(float(off) * UPWARDS)


Passed: TypeAlias = Callable[[Interval, Sequence[Interval], Sequence[Array]], Array]
"""Function from the ranges of result and operands, and errors of operands, to the propagated error."""


def _of_quotient(z: Interval, x: Sequence[Interval], e: Sequence[Array]) -> Array:
    least = x[1].least_magnitude / UPWARDS - e[1]
    return np.where(least > 0, (e[0] + z.magnitude * e[1]) / np.where(least > 0, least, 1.0), np.inf)


def _of_root(z: Interval, x: Sequence[Interval], e: Sequence[Array]) -> Array:
    least = x[0].low / UPWARDS - e[0]
    slope = np.sqrt(np.maximum(least, 0.0)) + np.sqrt(np.maximum(x[0].low, 0.0))
    return np.where(e[0] == 0, 0.0, np.where(least > 0, e[0] / np.where(least > 0, slope, 1.0), np.inf))


def _of_arc(z: Interval, x: Sequence[Interval], e: Sequence[Array]) -> Array:
    """Error of an arc tangent: error of the point over its least distance from the origin; infinite at a jump."""
    moved = np.hypot(e[0], e[1])
    distance = np.hypot(x[0].least_magnitude, x[1].least_magnitude) / UPWARDS - moved
    jumps = (x[1].low <= e[1]) & (x[0].low <= e[0]) & (x[0].high >= -e[0])  # without errors, too: by the sign of -0.0
    is_unbounded = jumps | (moved > 0) & (distance <= 0)
    return np.where(is_unbounded, np.inf, moved / np.where(distance > 0, distance, 1.0))


PASSED: Mapping[str, Passed] = {
    **dict.fromkeys((op.ADD, op.SUBTRACT), lambda z, x, e: e[0] + e[1]),
    op.MULTIPLY: lambda z, x, e: x[0].magnitude * e[1] + x[1].magnitude * e[0] + e[0] * e[1],
    op.DIVIDE: _of_quotient,
    **dict.fromkeys((op.NEGATE, op.SIN, op.COS), lambda z, x, e: e[0]),  # slopes of at most 1
    op.SQRT: _of_root,
    op.ATAN2: _of_arc,
    op.SIGN: lambda z, x, e: np.where((e[0] > 0) & (x[0].least_magnitude <= e[0]), 2.0, 0.0),  # over zero
    **dict.fromkeys((op.MINIMUM, op.MAXIMUM), lambda z, x, e: np.maximum(e[0], e[1])),
}
"""Propagation of errors, by operation."""
