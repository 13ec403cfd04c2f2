"""Exact first derivatives along with values: numbers `value + tangent e` with e^2 = 0.

A tangent is a number for one direction, or an array for many. Duals nest: where value and tangent are
duals themselves, the tangent of the tangent is a second derivative.
"""

from __future__ import annotations

from collections.abc import Callable
from numbers import Number

from symoro_elastic.symbolic.arithmetic import RATIONAL, Arithmetic, Library
from symoro_elastic.symbolic.operations import ADD, DIVIDE, MULTIPLY, NEGATE, OPERATIONS, SUBTRACT, Functions, Value

PLAIN = (float, int)
"""Plain numbers, whose products with duals are written out."""


class Dual:
    """A value and its derivative along a direction, the tangent; other numbers are constants."""

    __slots__ = ("tangent", "value")
    __array_ufunc__ = None  # an array beside a dual is a constant, and no array of duals

    def __init__(self, value: Value, tangent: Value) -> None:
        self.value, self.tangent = value, tangent

    def __add__(self, other: Value) -> Dual:
        if _both_move(self, other):
            return Dual(self.value + other.value, self.tangent + other.tangent)
        return _operator(ADD, self, other) if self._may_meet(other) else NotImplemented

    def __radd__(self, other: Value) -> Dual:
        return _operator(ADD, other, self) if self._may_meet(other) else NotImplemented

    def __sub__(self, other: Value) -> Dual:
        if _both_move(self, other):
            return Dual(self.value - other.value, self.tangent - other.tangent)
        return _operator(SUBTRACT, self, other) if self._may_meet(other) else NotImplemented

    def __rsub__(self, other: Value) -> Dual:
        return _operator(SUBTRACT, other, self) if self._may_meet(other) else NotImplemented

    def __mul__(self, other: Value) -> Dual:
        if _both_move(self, other):
            return Dual(self.value * other.value, other.value * self.tangent + self.value * other.tangent)
        if type(other) in PLAIN and type(self.tangent) is not int:
            return Dual(self.value * other, other * self.tangent)
        return _operator(MULTIPLY, self, other) if self._may_meet(other) else NotImplemented

    def __rmul__(self, other: Value) -> Dual:
        if type(other) in PLAIN and type(self.tangent) is not int:
            return Dual(other * self.value, other * self.tangent)
        return _operator(MULTIPLY, other, self) if self._may_meet(other) else NotImplemented

    def __truediv__(self, other: Value) -> Dual:
        return _operator(DIVIDE, self, other) if self._may_meet(other) else NotImplemented

    def __rtruediv__(self, other: Value) -> Dual:
        return _operator(DIVIDE, other, self) if self._may_meet(other) else NotImplemented

    def __neg__(self) -> Dual:
        return _operator(NEGATE, self)

    def __repr__(self) -> str:
        return f"Dual({self.value!r}, {self.tangent!r})"

    def _may_meet(self, other: Value) -> bool:
        """Whether another operand is a dual or a constant: a number, an array, or of the value's type."""
        is_number = isinstance(other, Dual | Number) or hasattr(other, "__array_ufunc__")
        return is_number or type(other) is type(innermost(self))


def differentiating(arithmetic: Arithmetic[Value]) -> Arithmetic[Value]:
    """An arithmetic of duals over another one; steps such as `sign` have tangent zero, at a jump too.

    Constants stay numbers of the other arithmetic. Symbols may be given as numbers, or as duals, all of
    one depth. Raises `ZeroDivisionError` for the tangent of a square root or of an angle at zero.
    """
    functions = Library(lambda operation: _on_duals(operation, arithmetic.operations, functions))
    return Arithmetic(arithmetic.number, functions)


def _on_duals(operation: str, base: Functions, functions: Functions) -> Callable[..., Value]:
    """A function of numbers as one of numbers and duals."""
    function, is_step = base[operation], OPERATIONS[operation].partials is None

    def of(*operands: Value) -> Value:
        if is_step:
            return function(*map(innermost, operands))
        if not any(type(x) is Dual for x in operands):
            return function(*operands)
        return _apply(operation, functions, operands)

    return of


def _both_move(x: Dual, y: Value) -> bool:
    """Whether two operands are duals with tangents other than the exact 0, as in most sums and products.

    Their derivatives are written out above, because `Partials` are slower by more than half.
    """
    return type(y) is Dual and type(x.tangent) is not int and type(y.tangent) is not int


def _operator(operation: str, *operands: Value) -> Dual:
    return _apply(operation, RATIONAL, operands)


def _apply(operation: str, functions: Functions, operands: tuple[Value, ...]) -> Dual:
    """Value and tangent of an operation, by its partial derivatives."""
    values = [x.value if type(x) is Dual else x for x in operands]
    tangents = [x.tangent if type(x) is Dual else 0 for x in operands]
    value, partials = functions[operation](*values), OPERATIONS[operation].partials
    return Dual(value, partials(functions, value, values).along(tangents) if partials else 0)


def innermost(x: Value) -> Value:
    """The value of a dual, of duals the value of their value."""
    while type(x) is Dual:
        x = x.value
    return x
