"""The scalar operations: one row each, for all that traces, counts, evaluates, differentiates or prints them.

To add an operation, add its row to `OPERATIONS`. An arithmetic (`arithmetic.py`) looks for a function of that name in
the library that it is made of, a printer (`codegen/printers.py`) prints a call of that name; what differs from this is
an entry in their tables.
"""

from __future__ import annotations

import operator
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import reduce
from typing import Any, NamedTuple, TypeAlias

ADD, SUBTRACT, MULTIPLY, DIVIDE, NEGATE = "+", "-", "*", "/", "neg"
SYMBOL, PI, COSPI = "symbol", "pi", "cospi"
SIN, COS, SQRT, SIGN, ATAN2 = "sin", "cos", "sqrt", "sign", "atan2"
MINIMUM, MAXIMUM = "minimum", "maximum"

ONE = 1
"""The partial derivative of a term: its products, arrays among them, need not be formed."""

Value: TypeAlias = Any
"""A number of any arithmetic: of Python, numpy, mpmath or flint, an array, a residue, a dual, an expression."""
Functions: TypeAlias = Mapping[str, Callable[..., Value]]
"""Functions of the operations in an arithmetic, by name."""


class Partials(NamedTuple):
    """Partial derivatives of an operation by its operands, over a denominator where they share one."""

    numerators: tuple[Value, ...]
    denominator: Value = None

    def along(self, tangents: Sequence[Value]) -> Value:
        """The derivative along a direction, from those of the operands; the exact 0 denotes a constant operand."""
        pairs = zip(self.numerators, tangents, strict=True)
        moving = [(partial, tangent) for partial, tangent in pairs if type(tangent) is not int or tangent]
        terms = [tangent if partial is ONE else partial * tangent for partial, tangent in moving]
        total = reduce(operator.add, terms) if terms else 0
        return total if self.denominator is None else total / self.denominator

    def back(self, weight: Value) -> tuple[Value, ...]:
        """Contributions of a result to the derivatives by its operands, from the derivative `weight` by the result."""
        over = weight if self.denominator is None else weight / self.denominator
        return tuple(over if partial is ONE else partial * over for partial in self.numerators)


PartialsRule: TypeAlias = Callable[[Functions, Value, Sequence[Value]], Partials]
"""Partial derivatives of an operation from the functions of an arithmetic, its value z and its operands x."""


@dataclass(frozen=True)
class Operation:
    """A kind of operation: name, number of operands, kind of work that it is counted as, partial derivatives.

    `counted_as` is a field of `OperationCount`, or empty. Without `partials` the derivative is zero: steps, and
    functions of constants.
    """

    name: str
    arity: int
    counted_as: str = ""
    partials: PartialsRule | None = None


def _arc_tangent(functions: Functions, z: Value, x: Sequence[Value]) -> Partials:
    return Partials((x[1], -x[0]), x[1] * x[1] + x[0] * x[0])


def _least(functions: Functions, z: Value, x: Sequence[Value]) -> Partials:
    """Partial derivatives of the minimum: 1 and 0 by the smaller operand, half and half of equal ones."""
    side = functions[SIGN](x[0] - x[1])
    return Partials((1 - side, 1 + side), 2)


def _largest(functions: Functions, z: Value, x: Sequence[Value]) -> Partials:
    return Partials(_least(functions, z, x).numerators[::-1], 2)


OPERATIONS: dict[str, Operation] = {
    row.name: row
    for row in (
        Operation(ADD, 2, "add", lambda functions, z, x: Partials((ONE, ONE))),
        Operation(SUBTRACT, 2, "add", lambda functions, z, x: Partials((ONE, -1))),
        Operation(NEGATE, 1, "", lambda functions, z, x: Partials((-1,))),
        Operation(MULTIPLY, 2, "mul", lambda functions, z, x: Partials((x[1], x[0]))),
        Operation(DIVIDE, 2, "div", lambda functions, z, x: Partials((ONE, -z), x[1])),
        Operation(SIN, 1, "sincos", lambda functions, z, x: Partials((functions[COS](x[0]),))),
        Operation(COS, 1, "sincos", lambda functions, z, x: Partials((-functions[SIN](x[0]),))),
        Operation(SQRT, 1, "", lambda functions, z, x: Partials((ONE,), 2 * z)),
        Operation(ATAN2, 2, "", _arc_tangent),
        Operation(SIGN, 1),
        Operation(MINIMUM, 2, "", _least),
        Operation(MAXIMUM, 2, "", _largest),
        Operation(PI, 0),
        Operation(COSPI, 1),
    )
}
"""All operations by name; a symbol is not an operation."""
