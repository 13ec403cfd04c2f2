"""Scalars of all kinds: what they calculate with, and what they leave to others."""

from __future__ import annotations

import operator
from collections.abc import Callable
from fractions import Fraction
from typing import Any

import pytest

from symoro_elastic.foundation.scalar import Element
from symoro_elastic.models.parameters.base_parameters import Polynomial
from symoro_elastic.symbolic.duals import Dual
from symoro_elastic.symbolic.expression import Expression, Graph, operand
from symoro_elastic.symbolic.finite_field import Residue

GRAPH = Graph()
SCALARS: dict[str, Element] = {
    "expression": GRAPH.symbol("x"),
    "negative expression": -GRAPH.symbol("x"),
    "residue": Residue(7),
    "dual": Dual(2.0, 1.0),
    "polynomial": Polynomial.factor("m"),
}
OPERATORS = (operator.add, operator.sub, operator.mul, operator.truediv)
scalars = pytest.mark.parametrize("scalar", SCALARS.values(), ids=list(SCALARS))
operators = pytest.mark.parametrize("operation", OPERATORS)


class Vector:
    """Has operators of its own for scalars on its left and on its right."""

    def _met(self, other: Any) -> tuple[Vector, Any]:
        return self, other

    __add__ = __radd__ = __sub__ = __rsub__ = __mul__ = __rmul__ = __truediv__ = __rtruediv__ = _met


@scalars
@operators
def test_objects_without_operators_are_a_type_error(scalar: Element, operation: Callable[..., Any]) -> None:
    for pair in ((scalar, object()), (object(), scalar), (scalar, {}), (scalar, None)):
        with pytest.raises(TypeError, match="unsupported operand type"):
            operation(*pair)


@scalars
@operators
def test_others_are_asked_for_their_own_operator(scalar: Element, operation: Callable[..., Any]) -> None:
    vector = Vector()
    assert operation(scalar, vector) == (vector, scalar)
    assert operation(vector, scalar) == (vector, scalar)


@pytest.mark.parametrize("scalar", [x for name, x in SCALARS.items() if name != "dual"])
@operators
def test_exact_numbers_are_taken_on_both_sides(scalar: Element, operation: Callable[..., Any]) -> None:
    for constant in (3, Fraction(2, 7)):
        assert type(operation(scalar, constant)) is type(operation(constant, scalar)) is type(scalar)


def test_scalars_of_two_kinds_do_not_mix() -> None:
    exact = [SCALARS[name] for name in ("expression", "residue", "polynomial")]
    for operation in OPERATORS:
        for first in exact:
            for second in exact:
                if first is not second:
                    with pytest.raises(TypeError, match="unsupported operand type"):
                        operation(first, second)


def test_floats_become_the_rational_numbers_that_they_are() -> None:
    """No float is an operand of a node; residues, which no float has an image in, refuse them."""
    x = GRAPH.symbol("x")
    assert x * 0.5 is x * Fraction(1, 2)
    assert x + 0.1 is x + Fraction(0.1)
    assert (x * 0.5).operands[1] == Fraction(1, 2) and type((x * 0.5).operands[1]) is Fraction
    assert type(operand(0.25)) is Fraction
    for wrong in (float("nan"), float("inf")):
        with pytest.raises((ValueError, OverflowError)):
            x + wrong
    with pytest.raises(TypeError):
        Residue(2) * 0.5


def test_what_is_no_operand_of_a_graph_is_refused() -> None:
    for wrong in (Residue(1), Polynomial.factor("m"), "x"):
        with pytest.raises(TypeError, match="no expression and no exact constant"):
            operand(wrong)


def test_expressions_are_shown_as_written() -> None:
    x, y = (GRAPH.symbol(name) for name in "xy")
    assert str(x - 2 * y) == "(x - (y*2))"
    assert str(-(x / y) + 1) == "-((x/y) + -1)"
    assert isinstance(x + 1, Expression)
