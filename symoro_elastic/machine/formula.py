"""Arithmetic expressions of a machine file, read as data: parsed by a grammar, never evaluated as code.

sum     := product (('+' | '-') product)*
product := sign (('*' | '/') sign)*
sign    := ('+' | '-') sign | power
power   := atom (('^' | '**') sign)?
atom    := number | name | function '(' sum (',' sum)* ')' | '(' sum ')'
"""

from __future__ import annotations

import cmath
import math
import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from decimal import Decimal
from fractions import Fraction
from functools import cached_property, lru_cache
from numbers import Integral
from typing import Any, SupportsFloat

MAX_LENGTH = 1000
MAX_TOKENS = 300
MAX_DEPTH = 50
MAX_EXPONENT = 64
SMALLEST, LARGEST = 1e-100, 1e50
"""Of a number of a table that is not zero, in SI units: products of such numbers stay within double precision."""
FUNCTIONS = {"sin": 1, "cos": 1, "tan": 1, "sqrt": 1, "atan2": 2}
PI = ("pi", "Pi")
STEP = 1e-100
"""Imaginary part of a name: its square is below the rounding of any number."""
BINDING = {"+": 1, "-": 1, "*": 2, "/": 2, "neg": 3, "power": 4}
"""How strongly operations bind; numbers, names and functions bind most."""

_TOKEN = re.compile(
    r"\s*(?:(?P<number>(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)|(?P<name>[A-Za-z_]\w*)|(?P<sign>\*\*|[-+*/^(),]))",
    re.ASCII,
)

Tree = tuple[Any, ...]


class FormulaError(ValueError):
    """An invalid expression; the message says what is allowed."""


@dataclass(frozen=True, repr=False)
class Formula:
    """An arithmetic expression: its text as written and its syntax tree.

    Trees are `("number", Fraction)`, `("pi",)`, `("name", str)`, `(operation, tree...)` with
    operation one of + - * / neg, `("power", tree, int)`, or `(function, tree...)`.
    """

    text: str
    tree: Tree = field(repr=False)

    @classmethod
    def parse(cls, source: str | SupportsFloat) -> Formula:
        """Read a number, of numpy too, or a text; raises `FormulaError`."""
        if isinstance(source, bool):
            raise FormulaError(f"{source} is not a number")
        text = source if isinstance(source, str) else _plain_number(source)
        return cls(text.strip(), _tree(text))

    @cached_property
    def names(self) -> frozenset[str]:
        """Names of the parameters and variables that occur."""
        return frozenset(names_in(self.tree))

    @property
    def is_zero(self) -> bool:
        """Whether the expression is the number zero, as written."""
        return self.tree == ZERO.tree

    def evaluate(
        self,
        names: Mapping[str, Any],
        functions: Mapping[str, Callable[..., Any]],
        number: Callable[[Fraction], Any] = float,
    ) -> Any:
        """Value in any arithmetic: `names` must hold `pi`, `number` converts exact rationals."""
        return _evaluate(self.tree, names, functions, number)

    def value(self, names: Mapping[str, float] | None = None) -> float:
        """Value in double precision, rationals rounded once.

        Raises `KeyError` for a name without value, `FormulaError` without a finite value.
        """
        return self._value(names or {}) if self.names else self._number

    @cached_property
    def _number(self) -> float:
        return self._value({})

    def _value(self, names: Mapping[str, float]) -> float:
        values = {name: names[name] for name in self.names} if names else {}
        try:
            result = float(_evaluate(self.tree, {"pi": math.pi, **values}, _OF_FLOATS, lambda exact: exact))
        except (ArithmeticError, ValueError) as error:
            reason = "it divides by zero" if isinstance(error, ZeroDivisionError) else str(error)
            raise FormulaError(f"{self.text!r} has no value: {reason}") from None
        if not math.isfinite(result):
            raise FormulaError(f"{self.text!r} is not finite")
        return result

    def with_slope(self, names: Mapping[str, float], by: str) -> complex:
        """Value with its derivative by a name times `STEP` as imaginary part: complex numbers have it without error."""
        values = {name: names[name] for name in self.names} | {by: complex(names[by], STEP)}
        return complex(_evaluate(self.tree, {"pi": math.pi, **values}, _OF_COMPLEX, float))

    def table_value(self, names: Mapping[str, float] | None = None) -> float:
        """Value as a number of a table, as `value`; raises `FormulaError` for one that is out of range, too."""
        result = self.value(names)
        refuse_range(result)
        return result

    def known_value(self, names: Mapping[str, float]) -> float | None:
        """Value in double precision; None if a name has no value, or the formula is undefined."""
        if not self.names <= names.keys():
            return None
        try:
            return self.value(names)
        except FormulaError:
            return None

    def __repr__(self) -> str:
        return f"Formula({self.text!r})"

    def __str__(self) -> str:
        return self.text


def number(text: str) -> float:
    """Value of a number, or of a formula of numbers, in double precision; raises `FormulaError`."""
    formula = Formula.parse(text)
    for name in sorted(formula.names):
        raise FormulaError(f"{name} is not finite" if name in ("nan", "inf") else f"{name!r} is a name")
    return formula.value()


def refuse_range(x: float) -> None:
    """Raise `FormulaError` for a number that no table holds, since products of it leave double precision."""
    if not (x == 0.0 or SMALLEST <= abs(x) <= LARGEST):
        raise FormulaError(f"{x:g} is out of range ({SMALLEST:g} to {LARGEST:g}): check the units")


def text_of(tree: Tree, within: int = 0) -> str:
    """The text of a part of an expression for messages, numbers to six digits; in brackets where it binds weaker."""
    operation, *parts = tree
    strength = BINDING.get(operation, 5)
    match operation:
        case "number":
            text, strength = f"{float(parts[0]):g}", 5 if parts[0] >= 0 else 3
        case "pi" | "name":
            text = str(parts[0]) if parts else "pi"
        case "neg":
            text = f"-{text_of(parts[0], 4)}"
        case "power":
            text = f"{text_of(parts[0], 5)}^{parts[1] if parts[1] >= 0 else f'({parts[1]})'}"
        case "+" | "-" | "*" | "/":
            sign = f" {operation} " if strength == 1 else operation
            text = f"{text_of(parts[0], strength)}{sign}{text_of(parts[1], strength + 1)}"
        case _:
            text = f"{operation}({', '.join(map(text_of, parts))})"
    return f"({text})" if strength < within else text


def _plain_number(value: SupportsFloat) -> str:
    if isinstance(value, Fraction):
        return str(value)
    if isinstance(value, Integral):
        bits = int(value).bit_length()
        if bits > 4 * MAX_LENGTH:
            raise FormulaError(f"a whole number of {bits} bits is out of range")
        return str(int(value))
    if not math.isfinite(value):
        raise FormulaError(f"{value} is not finite")
    return str(value) if isinstance(value, Decimal) else repr(float(value))


def _function_of_floats(name: str) -> Callable[..., float]:
    return _tangent if name == "tan" else lambda *arguments: getattr(math, name)(*map(float, arguments))


def _tangent(angle: SupportsFloat) -> float:
    """The tangent of an angle that is not an odd multiple of pi/2, within rounding."""
    x = float(angle)
    if abs(math.cos(x)) <= 2 * math.ulp(x):
        raise ZeroDivisionError
    return math.tan(x)


def _atan2(y: complex, x: complex) -> complex:
    slope = (x.real * y.imag - y.real * x.imag) / (x.real * x.real + y.real * y.real)
    return complex(math.atan2(y.real, x.real), slope)


_OF_FLOATS = {name: _function_of_floats(name) for name in FUNCTIONS}
_OF_COMPLEX = {name: _atan2 if name == "atan2" else getattr(cmath, name) for name in FUNCTIONS}


def terms(tree: Tree) -> Iterator[Tree]:
    """The terms of a sum, without their signs."""
    if tree[0] in ("+", "-", "neg"):
        for part in tree[1:]:
            yield from terms(part)
    else:
        yield tree


def names_in(tree: Tree) -> set[str]:
    """Names in the tree of an expression."""
    if tree[0] == "name":
        return {tree[1]}
    return {name for part in tree[1:] if isinstance(part, tuple) for name in names_in(part)}


def _degree(tree: Tree) -> int:
    below = max((_degree(part) for part in tree[1:] if isinstance(part, tuple)), default=1)
    return below * abs(tree[2]) if tree[0] == "power" else below


def _evaluate(tree: Tree, names: Mapping[str, Any], functions: Mapping[str, Callable[..., Any]], number: Any) -> Any:
    match tree:
        case ("number", value):
            return number(value)
        case ("pi",):
            return names["pi"]
        case ("name", name):
            return names[name]
        case ("power", base, exponent):
            return _power(_evaluate(base, names, functions, number), exponent, number)
    operation, *parts = tree
    values = [_evaluate(part, names, functions, number) for part in parts]
    match operation:
        case "+":
            return values[0] + values[1]
        case "-":
            return values[0] - values[1]
        case "*":
            return values[0] * values[1]
        case "/":
            return values[0] / values[1]
        case "neg":
            return -values[0]
    return functions[operation](*values)


def _power(base: Any, exponent: int, number: Any) -> Any:
    if exponent < 0:
        return number(Fraction(1)) / _power(base, -exponent, number)
    result = number(Fraction(1))
    for _ in range(exponent):
        result = result * base
    return result


@lru_cache(maxsize=4096)
def _tree(text: str) -> Tree:
    """The tree of a text; tables repeat most of theirs."""
    return _Parser(text).parse()


class _Parser:
    def __init__(self, text: str) -> None:
        if len(text) > MAX_LENGTH:
            raise FormulaError(f"an expression of {len(text)} characters: at most {MAX_LENGTH} are read")
        self.tokens = _tokens(text)
        if len(self.tokens) > MAX_TOKENS:
            raise FormulaError(f"an expression of {len(self.tokens)} terms and signs: at most {MAX_TOKENS} are read")
        self.position = 0
        self.depth = 0

    def parse(self) -> Tree:
        tree = self.sum()
        if self.peek() is not None:
            raise FormulaError(f"{self.peek()!r} is not expected here")
        return tree

    def peek(self) -> str | None:
        return self.tokens[self.position][1] if self.position < len(self.tokens) else None

    def take(self) -> tuple[str, str]:
        if self.position >= len(self.tokens):
            raise FormulaError("the expression ends too early")
        self.position += 1
        return self.tokens[self.position - 1]

    def sum(self) -> Tree:
        self.depth += 1
        if self.depth > MAX_DEPTH:
            raise FormulaError(f"nested deeper than {MAX_DEPTH} levels")
        tree = self.product()
        while self.peek() in ("+", "-"):
            tree = (self.take()[1], tree, self.product())
        self.depth -= 1
        return tree

    def product(self) -> Tree:
        tree = self.sign()
        while self.peek() in ("*", "/"):
            tree = (self.take()[1], tree, self.sign())
        return tree

    def sign(self) -> Tree:
        negative = False
        while self.peek() in ("+", "-"):
            negative ^= self.take()[1] == "-"
        tree = self.power()
        if not negative:
            return tree
        return ("number", -tree[1]) if tree[0] == "number" else ("neg", tree)

    def power(self) -> Tree:
        tree = self.atom()
        if self.peek() not in ("^", "**"):
            return tree
        self.take()
        exponent = self.exponent()
        if _degree(tree) * abs(exponent) > MAX_EXPONENT:
            raise FormulaError(f"powers of powers beyond {MAX_EXPONENT} are not read")
        return ("sqrt", tree) if exponent == Fraction(1, 2) else ("power", tree, int(exponent))

    def exponent(self) -> Fraction:
        tree = self.sign()
        value: Fraction | None = tree[1] if tree[0] == "number" else None
        if tree[0] == "/" and tree[1][0] == tree[2][0] == "number" and tree[2][1]:
            value = tree[1][1] / tree[2][1]
        if value is None or (value.denominator != 1 and value != Fraction(1, 2)) or abs(value) > MAX_EXPONENT:
            raise FormulaError(f"an exponent must be a whole number up to {MAX_EXPONENT}, or 1/2 for a root")
        if self.peek() in ("^", "**"):
            raise FormulaError("towers of powers are not read: write the exponent as a number")
        return value

    def atom(self) -> Tree:
        kind, text = self.take()
        if kind == "number":
            return ("number", _exact(text))
        if kind == "name":
            return self.call(text) if self.peek() == "(" else ("pi",) if text in PI else ("name", text)
        if text == "(":
            tree = self.sum()
            self.expect(")")
            return tree
        raise FormulaError(f"{text!r} is not expected here")

    def call(self, name: str) -> Tree:
        if name not in FUNCTIONS:
            raise FormulaError(f"{name!r} is not a function here: there are {', '.join(FUNCTIONS)}")
        self.take()
        arguments = [self.sum()]
        while self.peek() == ",":
            self.take()
            arguments.append(self.sum())
        self.expect(")")
        if len(arguments) != FUNCTIONS[name]:
            raise FormulaError(f"{name} has {FUNCTIONS[name]} argument(s), not {len(arguments)}")
        return (name, *arguments)

    def expect(self, sign: str) -> None:
        if self.peek() != sign:
            raise FormulaError(f"{sign!r} is missing")
        self.take()


def _tokens(text: str) -> list[tuple[str, str]]:
    tokens, position, text = [], 0, text.rstrip()
    while position < len(text):
        match = _TOKEN.match(text, position)
        if not match:
            remainder = text[position:].lstrip()
            raise FormulaError(f"{remainder[:20]!r} is not arithmetic: numbers, names, + - * / ^ ( ) are")
        tokens.append((str(match.lastgroup), match[str(match.lastgroup)]))
        position = match.end()
    if not tokens:
        raise FormulaError("an empty expression")
    return tokens


def _exact(text: str) -> Fraction:
    """Return a number exactly; raises `FormulaError` for one out of the range of double precision."""
    size = float(text)
    mantissa = re.split("[eE]", text)[0]
    if not math.isfinite(size) or (size == 0.0 and re.search("[1-9]", mantissa)):
        raise FormulaError(f"{text[:30]} is out of the range of double precision")
    return Fraction(text) if size else Fraction(0)


ZERO = Formula.parse(0)
