"""The table of operations: complete everywhere, and all that it takes to add a row."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import fields
from fractions import Fraction
from typing import Any

import mpmath
import numpy as np
import pytest

from symoro_elastic.codegen.body import PYTHON
from symoro_elastic.codegen.printers import OPERATORS, Printer
from symoro_elastic.models.parameters.base_parameters import POLYNOMIALS
from symoro_elastic.numerics.evaluation.arrays import EXTENDED, arithmetic
from symoro_elastic.symbolic.arithmetic import (
    FLOATS,
    RATIONAL,
    Arithmetic,
    ModularAngles,
    evaluate,
    multiprecision,
    nodes,
)
from symoro_elastic.symbolic.differentiation import Differentiation, gradient, substitute
from symoro_elastic.symbolic.duals import Dual, differentiating
from symoro_elastic.symbolic.expression import Graph, Level
from symoro_elastic.symbolic.operations import OPERATIONS, Operation, Partials
from symoro_elastic.symbolic.program import Input, Names, OperationCount, Output, Program, Section, build
from symoro_elastic.symbolic.time_series import RECURRENCES


def arithmetics() -> Iterator[tuple[str, Arithmetic[Any]]]:
    yield "floats", FLOATS
    yield "50 digits", multiprecision(50)
    yield "numpy, double", arithmetic(np.float64)
    yield "numpy, extended", arithmetic(EXTENDED)
    yield "polynomials", POLYNOMIALS
    yield "expressions", nodes(Graph())
    yield "duals of floats", differentiating(FLOATS)
    yield "duals of duals of 50 digits", differentiating(differentiating(multiprecision(50)))


ARITHMETICS = dict(arithmetics())
ARGUMENTS = {"cospi": (Fraction(1, 5),), "pi": ()}
"""Of the operations that stand for constants of a graph."""


def arguments(row: Operation) -> tuple[Fraction, ...]:
    return ARGUMENTS.get(row.name, (Fraction(3, 7), Fraction(5, 4))[: row.arity])


@pytest.mark.parametrize("row", OPERATIONS.values(), ids=list(OPERATIONS))
@pytest.mark.parametrize("kind", ARITHMETICS)
def test_every_arithmetic_knows_every_operation(kind: str, row: Operation) -> None:
    found = ARITHMETICS[kind]
    assert found.operations[row.name](*map(found.number, arguments(row))) is not None


def test_balls_know_every_operation() -> None:
    pytest.importorskip("flint")
    from symoro_elastic.numerics.verification import accuracy

    found = accuracy._arithmetic()
    for row in OPERATIONS.values():
        exact = multiprecision(40).operations[row.name](*map(multiprecision(40).number, arguments(row)))
        assert abs(float(found.operations[row.name](*map(found.number, arguments(row)))) - float(exact)) < 1e-15


@pytest.mark.parametrize("row", [row for row in OPERATIONS.values() if row.partials], ids=lambda row: row.name)
def test_partial_derivatives_against_differences_in_50_digits(row: Operation) -> None:
    many = multiprecision(50)
    function, at = many.operations[row.name], [many.number(x) for x in arguments(row)]
    assert row.partials is not None
    found = row.partials(many.operations, function(*at), at)
    for k in range(row.arity):
        one = [int(k == j) for j in range(row.arity)]
        step = mpmath.mpf(10) ** -15
        up, down = ([x + sense * step * e for x, e in zip(at, one, strict=True)] for sense in (1, -1))
        difference = (function(*up) - function(*down)) / (2 * step)
        assert abs(found.along(one) - difference) < 1e-25
        assert abs(found.back(3)[k] - 3 * difference) < 1e-25


def test_kinds_of_work_are_those_that_are_counted() -> None:
    kinds = {field.name for field in fields(OperationCount)}
    assert {row.counted_as for row in OPERATIONS.values()} == {"", *kinds}


def test_which_operations_have_no_time_series() -> None:
    assert OPERATIONS.keys() - RECURRENCES.keys() == {"sin", "cos", "pi", "cospi"}  # sine and cosine together
    assert RECURRENCES.keys() <= OPERATIONS.keys()


def test_operators_of_languages_are_those_of_all_numbers() -> None:
    assert OPERATORS.keys() == RATIONAL.keys()


# A new operation


@pytest.fixture
def tanh(monkeypatch: pytest.MonkeyPatch) -> Operation:
    """All that it takes: a row, and how Python spells it; C spells it so too."""
    row = Operation("tanh", 1, "sincos", lambda functions, z, x: Partials((1 - z * z,)))
    monkeypatch.setitem(OPERATIONS, row.name, row)
    monkeypatch.setitem(PYTHON.functions, row.name, f"_f.{row.name}")
    return row


def program_of(entry: Any) -> Program:
    names = Names()
    names.give(entry, "y", Section("Toy"))
    return build([Input("q", ("x",))], [Output("y", (1,), (entry,))], names)


def texts(program: Program, functions: Mapping[str, str]) -> list[str]:
    printer = Printer(program, functions=functions)
    return [f"{s.name} = {printer.right_side(s)}" for s in (*program.once, *program.statements)]


def test_a_row_and_its_printers_add_an_operation(tanh: Operation) -> None:
    graph = Graph()
    x, a = graph.symbol("x"), graph.symbol("a", Level.PARAMETER)
    y = 2 * graph.node("tanh", x * a) + graph.node("tanh", a)
    program = program_of(y)
    assert (program.count, program.count_once) == (OperationCount(2, 1, 0, 1), OperationCount(sincos=1))
    assert texts(program, {}) == ["ya = tanh(a)", "y = 2.0*tanh(x*a) + ya"]
    assert texts(program, PYTHON.functions) == ["ya = _f.tanh(a)", "y = 2.0*_f.tanh(x*a) + ya"]

    at = {"x": 0.3, "a": 1.7}
    assert evaluate([y], at, FLOATS)(y) == 2 * math.tanh(0.3 * 1.7) + math.tanh(1.7)
    with mpmath.workdps(50):
        many = {name: mpmath.mpf(value) for name, value in at.items()}
        exact = 2 * mpmath.tanh(many["x"] * many["a"]) + mpmath.tanh(many["a"])
        assert abs(evaluate([y], many, multiprecision(50))(y) - exact) < 1e-48
        slope = 2 * many["a"] / mpmath.cosh(many["x"] * many["a"]) ** 2
        derivative = Differentiation([y]).by(x).of(y)
        assert abs(evaluate([derivative], many, multiprecision(50))(derivative) - slope) < 1e-48
        dual = evaluate([y], {**many, "x": Dual(many["x"], 1)}, differentiating(multiprecision(50)))(y)
        assert abs(dual.tangent - slope) < 1e-48
        assert abs(gradient([y], [1], many, multiprecision(50))["x"] - slope) < 1e-48
    assert substitute(graph, [y], {"x": x}) == [y]
    assert POLYNOMIALS.operations["tanh"](POLYNOMIALS.number(2)).terms == {("tanh(2)",): 1}
    assert ModularAngles(1).values([y])(y)


def test_an_operation_without_a_row_is_refused_where_it_is_needed() -> None:
    graph = Graph()
    y = graph.node("unheard", graph.symbol("x"))
    with pytest.raises(AttributeError, match="unheard"):
        evaluate([y], {"x": 1.0}, FLOATS)
    with pytest.raises(KeyError, match="unheard"):
        Differentiation([y]).by(graph.symbol("x"))
    with pytest.raises(KeyError, match="unheard"):
        program_of(y)
