"""Coefficients of time series of each operation are those of its Taylor series."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import mpmath
import pytest

from symoro_elastic.symbolic.arithmetic import evaluate, multiprecision
from symoro_elastic.symbolic.expression import Graph
from symoro_elastic.symbolic.operations import (
    ADD,
    ATAN2,
    DIVIDE,
    MAXIMUM,
    MINIMUM,
    MULTIPLY,
    NEGATE,
    SIGN,
    SQRT,
    SUBTRACT,
)
from symoro_elastic.symbolic.time_series import RECURRENCES

FUNCTIONS: dict[str, Callable[..., Any]] = {
    ADD: lambda x, y: x + y,
    SUBTRACT: lambda x, y: x - y,
    NEGATE: lambda x: -x,
    MULTIPLY: lambda x, y: x * y,
    DIVIDE: lambda x, y: x / y,
    SQRT: mpmath.sqrt,
    ATAN2: mpmath.atan2,
    SIGN: mpmath.sign,
    MINIMUM: min,
    MAXIMUM: max,
}
SERIES = (("1.3", "0.7", "-0.4", "0.2", "0.6"), ("0.9", "-1.1", "0.3", "0.8", "-0.5"))


def test_every_operation_is_tested() -> None:
    assert FUNCTIONS.keys() == RECURRENCES.keys()


@pytest.mark.parametrize("exchanged", [False, True])
@pytest.mark.parametrize("operation", FUNCTIONS)
def test_coefficients_are_those_of_taylor(operation: str, exchanged: bool) -> None:
    function, operands = FUNCTIONS[operation], 1 if operation in (NEGATE, SQRT, SIGN) else 2
    with mpmath.workdps(60):
        series = [[mpmath.mpf(x) for x in row] for row in (SERIES[::-1] if exchanged else SERIES)][:operands]
        graph, known = Graph(), []
        symbols = [[graph.symbol(f"{letter}{k}") for k in range(5)] for letter in "xy"[:operands]]
        for k in range(5):
            known.append(RECURRENCES[operation](graph, k, known, *(row.__getitem__ for row in symbols)))
        numbers = {f"{letter}{k}": x for letter, row in zip("xy", series, strict=False) for k, x in enumerate(row)}
        value = evaluate(known, numbers, multiprecision(60))
        found = [value(x) for x in known]
        wanted = mpmath.taylor(lambda t: function(*(mpmath.polyval(row[::-1], t) for row in series)), 0, 4)
        assert max(abs(a - b) for a, b in zip(found, wanted, strict=True)) < 1e-10
