"""Programs evaluated at many states at once, in any floating-point type of numpy."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction
from functools import cache
from typing import Any

import numpy as np

from symoro_elastic.codegen.printers import constant_values
from symoro_elastic.foundation.array_types import AnyArray, Array
from symoro_elastic.foundation.scalar import Scalar
from symoro_elastic.models.bound.state import State
from symoro_elastic.models.programs.catalogue import TracedModel
from symoro_elastic.symbolic.arithmetic import Arithmetic, evaluate, library
from symoro_elastic.symbolic.expression import reachable
from symoro_elastic.symbolic.operations import ATAN2, COSPI, PI

Parameters = Mapping[str, Any]
"""A number for each parameter, or one for each state."""

EXTENDED = np.longdouble
PI_TO_40_DIGITS = Fraction("3.141592653589793238462643383279502884197")
NUMBERS_AT_ONCE = 2_000_000
"""Most node values that are in memory at once where expressions are evaluated at many samples."""
HAS_EXTENDED = np.finfo(np.longdouble).nmant >= 63
"""Whether numpy's widest type holds at least 11 bits more than double precision."""


@cache
def arithmetic(dtype: type) -> Arithmetic[Any]:
    """Return the arithmetic of a floating-point type of numpy; constants are rounded once."""

    def number(x: Fraction | int) -> Any:
        high = float(x)
        return dtype(high) + dtype(float(Fraction(x) - Fraction(high)))

    pi = number(PI_TO_40_DIGITS)
    own: dict[str, Callable[..., Any]] = {ATAN2: np.arctan2, PI: lambda: pi, COSPI: lambda x: np.cos(pi * x)}
    return Arithmetic(number, library(np, own))


def evaluate_arrays(
    traced: TracedModel, states: State, values: Parameters, dtype: type, operations: Arithmetic[Any] | None = None
) -> dict[str, AnyArray]:
    """Return results of a model by name, (states, entries), in a type of numpy, by its own operations or by others.

    Constants are those of generated code, rounded once; where the type is wider, they are as exact as it allows.
    """
    symbols: dict[str, Any] = {name: np.asarray(values[name]).astype(dtype) for name in values}
    for argument in traced.program.inputs:
        columns = getattr(states, argument.name).T
        symbols |= {symbol: column.astype(dtype) for symbol, column in zip(argument.symbols, columns, strict=True)}
    outputs = traced.program.outputs
    entries = [x for output in outputs for x in output.entries]
    constants = {} if dtype is EXTENDED else {node: dtype(x) for node, x in constant_values(entries).items()}
    with np.errstate(all="ignore"):
        value = evaluate(entries, symbols, operations or arithmetic(dtype), constants)
        return {output.name: _stack([value(x) for x in output.entries], len(states), dtype) for output in outputs}


def _stack(entries: list[Any], states: int, dtype: type) -> AnyArray:
    if not entries:
        return np.empty((states, 0), dtype)
    return np.stack([np.broadcast_to(entry, states) for entry in entries], axis=1)


def values_along(roots: Sequence[Scalar], symbols: Mapping[str, Any], samples: int) -> Array:
    """Return the values of expressions at samples, (roots, samples); symbols have one number, or one for each."""
    rows = np.empty((len(roots), samples))
    step = max(1, NUMBERS_AT_ONCE // (1 + len(reachable(roots))))
    for start in range(0, samples, step):
        part = slice(start, start + step)
        here = {name: x[part] if isinstance(x, np.ndarray) else np.float64(x) for name, x in symbols.items()}
        with np.errstate(all="ignore"):
            value = evaluate(roots, here, arithmetic(np.float64))
        for row, x in zip(rows, roots, strict=True):
            row[part] = value(x)
    return rows
