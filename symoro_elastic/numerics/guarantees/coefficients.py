"""Coefficients of polynomials of the motion, at many positions at once.

At each position a result of the inverse model is a polynomial of velocities and accelerations. Each is written as
middle + half s with s in [-1, 1], and the polynomial is calculated with as such: a dictionary from products of s to the
values of their coefficient at all positions.

**Rounding.** Written out, a coefficient is a sum of products of constants, sines and cosines of which each is rounded
at most k times on its way: |computed - exact| <= ((1 + u)^k - 1) m, where m is the sum of the magnitudes of these
products. Both follow the operations: k adds up in products, m is that of the operation on magnitudes.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, TypeAlias

import numpy as np

from symoro_elastic.machine.limits import Range
from symoro_elastic.numerics.guarantees.axes import UNIT
from symoro_elastic.symbolic.arithmetic import RATIONAL, evaluate, multiprecision
from symoro_elastic.symbolic.expression import Expression, Operand, reachable
from symoro_elastic.symbolic.operations import COS, SIN, SYMBOL

Monomial: TypeAlias = tuple[int, ...]
"""A product of s: their numbers, sorted; of a power as often as the exponent says."""


@dataclass(frozen=True)
class Polynomial:
    """Coefficients of products of s, with what bounds their rounding: sum of magnitudes m and number of roundings k."""

    terms: Mapping[Monomial, Any]
    size: float
    roundings: float

    @property
    def error(self) -> float:
        """At least the rounding error of each coefficient."""
        return self.size * self.roundings * UNIT * (1 + 1e-6) + 1e-300

    def __add__(self, other: Polynomial) -> Polynomial:
        return self._sum(other, 1)

    def __sub__(self, other: Polynomial) -> Polynomial:
        return self._sum(other, -1)

    def __neg__(self) -> Polynomial:
        return Polynomial({key: -x for key, x in self.terms.items()}, self.size, self.roundings)

    def __mul__(self, other: Polynomial) -> Polynomial:
        terms: dict[Monomial, Any] = {}
        for one, x in self.terms.items():
            for two, y in other.terms.items():
                key = tuple(sorted(one + two))
                terms[key] = terms[key] + x * y if key in terms else x * y
        added = min(len(self.terms), len(other.terms))
        return Polynomial(terms, self.size * other.size, self.roundings + other.roundings + added)

    def __truediv__(self, other: Polynomial) -> Polynomial:
        inverse = float(1 / Fraction(float(other.terms[()])))
        return self * Polynomial({(): np.float64(inverse)}, abs(inverse), other.roundings + 1)

    def _sum(self, other: Polynomial, sense: int) -> Polynomial:
        terms = dict(self.terms)
        for key, y in other.terms.items():
            own = y if sense > 0 else -y
            terms[key] = terms[key] + own if key in terms else own
        return Polynomial(terms, self.size + other.size, max(self.roundings, other.roundings) + 1)


def number(x: float, roundings: int = 1) -> Polynomial:
    """Return the polynomial of a number, rounded once or as often as given."""
    return Polynomial({(): np.float64(x)} if x else {}, abs(x), roundings)


def circular(operation: str, x: Polynomial) -> Polynomial:
    """Return the sine or cosine of an angle, right to 4 ulp; the error of the angle is one of the function."""
    angle = x.terms.get((), np.float64(0))
    values = np.sin(angle) if operation == SIN else np.cos(angle)
    return Polynomial({(): values}, 1.0, 8 + x.size * x.roundings)


def variable(number_of: int, found: Range) -> Polynomial:
    """Return a variable of the motion as middle + half s."""
    low, high = found.low, found.high
    middle = low + (high - low) / 2
    half = max(high - middle, middle - low) * (1 + 4 * UNIT)
    terms: dict[Monomial, Any] = {(number_of,): np.float64(half)} | ({(): np.float64(middle)} if middle else {})
    return Polynomial(terms, abs(middle) + half, 0)


def constants(nodes: Sequence[Expression], numbers: Mapping[str, float]) -> dict[int, float]:
    """Return the double next to each node that depends on numbers only, computed in 60 digits, by node."""
    found: dict[int, Expression] = {}
    for node in nodes:
        if node.operation == SYMBOL:
            constant = node.operands[0] in numbers
        else:
            constant = all(type(x) is not Expression or x.id in found for x in node.operands)
        if constant:
            found[node.id] = node
    digits = multiprecision(60)
    value = evaluate(found.values(), {name: digits.number(Fraction(x)) for name, x in numbers.items()}, digits)
    return {key: float(value(node)) for key, node in found.items()}


def symbols_of(roots: Sequence[Operand]) -> list[str]:
    """Return the names of the variables in expressions."""
    return [str(node.operands[0]) for node in reachable(roots) if node.operation == SYMBOL]


def polynomials(
    roots: Sequence[Operand], symbols: Mapping[str, Polynomial], numbers: Mapping[str, float]
) -> list[Polynomial]:
    """Return the polynomials of expressions without quotients; nodes are forgotten after their last use."""
    nodes = reachable(roots)
    known = constants(nodes, numbers)
    uses = Counter(x.id for node in nodes for x in node.operands if type(x) is Expression)
    uses.update(root.id for root in roots if type(root) is Expression)
    values: dict[int, Polynomial] = {}

    def of(x: Operand) -> Polynomial:
        return values[x.id] if type(x) is Expression else number(float(x))

    for node in nodes:
        if node.id in known:
            values[node.id] = number(known[node.id])
        else:
            values[node.id] = _applied(node, [*map(of, _operands(node))], symbols)
        for x in node.operands:
            if type(x) is Expression:
                uses[x.id] -= 1
                if not uses[x.id]:
                    del values[x.id]
    return [of(root) for root in roots]


def values_of(
    nodes: Sequence[Expression], symbols: Mapping[str, Polynomial], known: Mapping[int, float]
) -> dict[int, Polynomial]:
    """Return the polynomials of all nodes, operands before their users, by node; `known` are those that are numbers."""
    values: dict[int, Polynomial] = {}

    def of(x: Operand) -> Polynomial:
        return values[x.id] if type(x) is Expression else number(float(x))

    for node in nodes:
        if node.id in known:
            values[node.id] = number(known[node.id])
        else:
            values[node.id] = _applied(node, [*map(of, _operands(node))], symbols)
    return values


def _operands(node: Expression) -> Sequence[Operand]:
    return () if node.operation == SYMBOL else node.operands


def _applied(node: Expression, x: Sequence[Polynomial], symbols: Mapping[str, Polynomial]) -> Polynomial:
    if node.operation == SYMBOL:
        return symbols[node.operands[0]]
    if node.operation in (SIN, COS):
        return circular(node.operation, x[0])
    found: Polynomial = RATIONAL[node.operation](*x)
    return found
