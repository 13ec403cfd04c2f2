"""Sine, cosine, square root and the like of expressions, exact wherever an angle allows it.

An angle is split into multiples of pi, a constant in radians, and one term for each variable;
sine and cosine of the sum come from the addition theorem, so an offset costs no accuracy at
large angles, and quarter turns are exact. Variables times factors that are rounded, as slopes of modes, are one term.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from fractions import Fraction
from typing import TypeAlias

from symoro_elastic.foundation.scalar import Scalar
from symoro_elastic.symbolic import operations as op
from symoro_elastic.symbolic.expression import Expression, Graph, Operand, operand

QUARTERS = ((1, 0), (0, 1), (-1, 0), (0, -1))
RATIONAL_COSINES: Mapping[Fraction, Operand] = {Fraction(0): 1, Fraction(1, 3): Fraction(1, 2), Fraction(1, 2): 0}
"""cos(pi x) by x."""
Circle: TypeAlias = tuple[Operand, Operand]


def cosine_sine(graph: Graph, angle: Scalar) -> Circle:
    """Cosine and sine of an angle in radians."""
    terms, radians = _linear_terms(operand(angle))
    terms = _with_one_rounded(terms)
    halves = _half_turns(radians)
    turns = Fraction(0) if halves is None else halves
    point: Circle = (1, 0)
    for base, factor in terms:
        if base.operation == op.PI:
            turns += factor
        else:
            point = _rotate(point, _circle_of(graph, base * abs(factor), factor))
    point = _rotate(point, _rational_turn(graph, turns))
    return point if halves is not None else _rotate(point, _circle_of(graph, abs(radians), radians))


def square_root(graph: Graph, x: Scalar) -> Operand:
    """Square root; exact for squares of rationals."""
    square = operand(x)
    if isinstance(square, Expression):
        return graph.node(op.SQRT, square)
    if square < 0:
        raise ValueError("the square root of a negative number")
    over, under = math.isqrt(Fraction(square).numerator), math.isqrt(Fraction(square).denominator)
    root = Fraction(over, under)
    return root if root * root == square else graph.node(op.SQRT, square)


def logarithm(graph: Graph, x: Scalar) -> Operand:
    """Natural logarithm of a number from 1 to 1e9, to 1e-13: of arithmetic and roots, which every target has.

    ln x = 128 artanh t, t = (x^(1/64) - 1)/(x^(1/64) + 1) < 0.17, by its series to t^13.
    """
    root = operand(x)
    for _ in range(6):
        root = square_root(graph, root)
    t = (root - 1) / (root + 1)
    square: Scalar = t * t
    total: Scalar = Fraction(1, 13)
    for n in (11, 9, 7, 5, 3, 1):
        total = total * square + Fraction(1, n)
    return operand(128 * t * total)


def sign(graph: Graph, x: Scalar) -> Operand:
    """-1, 0 or 1."""
    of = operand(x)
    if isinstance(of, Expression):
        return -graph.node(op.SIGN, of.operands[0]) if of.operation == op.NEGATE else graph.node(op.SIGN, of)
    return (of > 0) - (of < 0)


def minimum(graph: Graph, x: Scalar, y: Scalar) -> Operand:
    """The lesser of two numbers, exactly; NaN where one is NaN, in every language."""
    return _extremum(graph, op.MINIMUM, operand(x), operand(y))


def maximum(graph: Graph, x: Scalar, y: Scalar) -> Operand:
    """The larger of two numbers, exactly; NaN where one is NaN, in every language."""
    return _extremum(graph, op.MAXIMUM, operand(x), operand(y))


def _extremum(graph: Graph, name: str, x: Operand, y: Operand) -> Operand:
    if isinstance(x, Expression) or isinstance(y, Expression):
        return x if x is y else graph.node(name, x, y)
    extremum: Operand = x if (x < y) == (name == op.MINIMUM) else y
    return extremum


def amount(graph: Graph, x: Scalar) -> Operand:
    """|x|."""
    of = operand(x)
    if isinstance(of, Expression):
        return maximum(graph, of.positive, -of.positive)
    return of if of >= 0 else -of


def clamp(graph: Graph, x: Scalar, least: Scalar, most: Scalar) -> Operand:
    """The number from `least` to `most` that is nearest to x, exactly."""
    return minimum(graph, maximum(graph, x, least), most)


def arc_tangent(graph: Graph, y: Scalar, x: Scalar) -> Operand:
    """Angle of the point (x, y)."""
    over, under = operand(y), operand(x)
    return 0 if over == 0 and under == 1 else graph.node(op.ATAN2, over, under)


def turns_of(angle: Scalar) -> tuple[dict[Expression, Fraction], Fraction] | None:
    """Factors of an angle's variable terms, and its half turns; None if it has a number that is no multiple of pi/2."""
    terms, radians = _linear_terms(operand(angle))
    terms = _with_one_rounded(terms)
    halves = _half_turns(radians)
    if halves is None:
        return None
    halves += sum((factor for base, factor in terms if base.operation == op.PI), Fraction(0))
    return {base: factor for base, factor in terms if base.operation != op.PI}, halves


def _linear_terms(angle: Operand) -> tuple[list[tuple[Expression, Fraction]], Fraction]:
    terms: dict[Expression, Fraction] = {}
    radians = Fraction(0)
    stack: list[tuple[Operand, Fraction]] = [(angle, Fraction(1))]
    while stack:
        x, factor = stack.pop()
        if not isinstance(x, Expression):
            radians += factor * x
        elif x.operation in (op.ADD, op.SUBTRACT):
            first, second = x.operands
            stack += [(second, -factor if x.operation == op.SUBTRACT else factor), (first, factor)]
        elif x.operation == op.NEGATE:
            stack.append((x.operands[0], -factor))
        elif x.operation == op.MULTIPLY and not isinstance(x.operands[1], Expression):
            stack.append((x.operands[0], factor * x.operands[1]))
        else:
            terms[x] = terms.get(x, Fraction(0)) + factor
    return [(x, factor) for x, factor in terms.items() if factor], radians


def _with_one_rounded(terms: list[tuple[Expression, Fraction]]) -> list[tuple[Expression, Fraction]]:
    """The terms with one sum in place of those that are products, of which double precision rounds each."""
    is_rounded = {x: x.operation == op.MULTIPLY or f.denominator & (f.denominator - 1) for x, f in terms}
    rounded = [(x, factor) for x, factor in terms if is_rounded[x] and x.operation != op.PI]
    sense = Fraction(1 if not rounded or rounded[0][1] > 0 else -1)
    total = operand(sum((x * (sense * factor) for x, factor in rounded), start=Fraction(0)))
    if len(rounded) < 2 or not isinstance(total, Expression):
        return terms
    return [*(term for term in terms if term not in rounded), (total, sense)]


def _half_turns(radians: Fraction) -> Fraction | None:
    """Radians in half turns where they are a multiple of pi/2 to one unit in the last place; else None."""
    if not radians:
        return Fraction(0)
    quarters = round(radians / Fraction(math.pi) * 2)
    nearest = quarters * math.pi / 2
    if quarters and abs(float(radians) - nearest) <= math.ulp(nearest):
        return Fraction(quarters, 2)
    return None


def _rational_turn(graph: Graph, halves: Fraction) -> Circle:
    if not halves:
        return QUARTERS[0]
    quarters, rest = divmod(halves * 2, 1)
    cosine = _cospi(graph, rest / 2)
    sine = _cospi(graph, Fraction(1, 2) - rest / 2)
    return _rotate((cosine, sine), QUARTERS[int(quarters) % 4])


def _cospi(graph: Graph, halves: Fraction) -> Operand:
    """cos(pi x) for 0 <= x <= 1/2."""
    return RATIONAL_COSINES[halves] if halves in RATIONAL_COSINES else graph.node(op.COSPI, halves)


def _circle_of(graph: Graph, angle: Operand, sense: Fraction) -> Circle:
    sine = graph.node(op.SIN, angle)
    return graph.node(op.COS, angle), sine if sense > 0 else -sine


def _rotate(point: Circle, by: Circle) -> Circle:
    (c, s), (cosine, sine) = point, by
    return c * cosine - s * sine, s * cosine + c * sine
