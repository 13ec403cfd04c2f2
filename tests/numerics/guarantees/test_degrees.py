"""Degrees by syntax, beside degrees that sampled values have, and what is refused."""

from __future__ import annotations

import re
from fractions import Fraction

import pytest

from symoro_elastic.foundation.scalar import Scalar
from symoro_elastic.numerics.guarantees.polynomials import NotPolynomial, degrees
from symoro_elastic.symbolic.expression import Graph, Level, Operand
from symoro_elastic.symbolic.operations import ATAN2, COS, COSPI, SIGN, SIN, SQRT

GRAPH = Graph()
Q1, Q2, X, V, A = map(GRAPH.symbol, ("q1", "q2", "x", "v", "a"))
M = GRAPH.symbol("m", Level.PARAMETER)


def function(name: str, *operands: Operand) -> Operand:
    return GRAPH.node(name, *operands)


S1, C1, C12 = function(SIN, Q1), function(COS, Q1), function(COS, Q1 + 2 * Q2)


@pytest.mark.parametrize(
    ("expression", "angles", "powers"),
    [
        (S1, {"q1": 1}, {}),
        (C12, {"q1": 1, "q2": 2}, {}),
        (S1 * C12 + C1, {"q1": 2, "q2": 2}, {}),
        (function(SIN, 3 * Q1 - (Q1 - Q2)), {"q1": 2, "q2": 1}, {}),
        (function(SIN, -(Q2 + GRAPH.pi / 2)), {"q2": 1}, {}),
        (S1 * (V * V + A) - X * X * X, {"q1": 1}, {"v": 2, "a": 1, "x": 3}),
        (V / M + A * function(SQRT, M), {}, {"v": 1, "a": 1}),
        (function(SIN, Q1 - Q1 + M) * X, {}, {"x": 1}),
        (function(COSPI, Fraction(1, 3)) * X, {}, {"x": 1}),
        (7, {}, {}),
    ],
)
def test_degrees(expression: Operand, angles: dict[str, int], powers: dict[str, int]) -> None:
    (found,) = degrees([expression], ["m"])
    assert (dict(found.angles), dict(found.powers)) == (angles, powers)


@pytest.mark.parametrize(
    ("expression", "reason"),
    [
        (X / C1, "a quotient by what depends on q1"),
        (1 / (M + V), "a quotient by what depends on v"),
        (function(SQRT, X), "a square root of what depends on x"),
        (function(SIGN, V), "a sign of what depends on v"),
        (function(ATAN2, S1, C1), "an arc tangent of what depends on q1"),
        (function(SIN, Q1 * Q2), "a sine or cosine of more than a sum of multiples of q1, q2"),
        (function(SIN, 7 / M * Q1), "a sine or cosine of more than a sum of multiples of q1"),
        (function(SIN, S1), "a sine or cosine of more than a sum of multiples of q1"),
        (function(COS, Q1 / 2), "a sine or cosine of 1/2 q1"),
        (function(COS, M * Q1), "a sine or cosine of more than a sum of multiples of q1"),
        (Q1 * 1000 + S1, "q1 occurs inside of a sine or cosine and outside of it"),
    ],
)
def test_refusals(expression: Scalar, reason: str) -> None:
    with pytest.raises(NotPolynomial, match=f"^{re.escape(reason)}$"):
        degrees([expression], ["m"])


def test_a_parameter_without_a_value_is_a_variable() -> None:
    assert dict(degrees([M * X])[0].powers) == {"m": 1, "x": 1}
