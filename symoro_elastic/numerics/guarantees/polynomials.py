"""A result as a polynomial over a box: its degrees, its variables, and the coefficients of its motion.

**Degrees by syntax.** An expression is a trigonometric polynomial of angles and a polynomial of all else. A sine or
cosine of k q + ... has the trigonometric degree |k| in q; a product has the sum of its factors' degrees, a sum the
largest of its terms'. The true degree is that or less, as cancellation is ignored. `NotPolynomial` is raised for a
quotient, a root, a sign or an arc tangent of what depends on the state, and for a variable that occurs inside of a sine
and outside of it.

**Variables on both sides of sines.** A spring between a motor and a joint that turns has tau = k (q_m - q): the angle q
stands outside of sines there, and inside of them in all else. *Lemma.* Let f(q) = F(q, q) with F(q, p) a trigonometric
polynomial of q and a polynomial of p. What bounds |F| for all q and p of the range of q bounds |f| there. An operation
on q that is used both ways is two operations of F; its error is counted for both, which is at least its share
|a + b| |e| of the sum of errors. F is written by copying what stands outside of sines, with p in place of q. In the
same way dry friction, a multiple of sign(v), is F(v, s) with s in [sign(low), sign(high)] in place of the sign, which
has no rounding as v has none: where arguments are rounded before their use (mixed precision), small ones may become
zero, and the sign stays one.

**Coefficients of the motion.** At each position the result is a polynomial of velocities and accelerations. Each of
them is middle + half s with s in [-1, 1]; the polynomial is a dictionary from products of s to the values of their
coefficient at all positions.

**Rounding.** Written out, a coefficient is a sum of products of constants, sines and cosines that are rounded at most
k times each: |computed - exact| <= ((1 + u)^k - 1) m, where m is the sum of the magnitudes of these
products. Both follow the operations: k adds up in products, m is that of the operation on magnitudes.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import partial
from typing import Any, TypeAlias

import numpy as np

from symoro_elastic.foundation.scalar import Scalar
from symoro_elastic.machine.limits import Range
from symoro_elastic.numerics.guarantees.axes import UNIT
from symoro_elastic.numerics.guarantees.box import Box
from symoro_elastic.symbolic.arithmetic import RATIONAL, Arithmetic, Library, evaluate, evaluate_nodes, multiprecision
from symoro_elastic.symbolic.expression import Expression, Graph, Operand, reachable
from symoro_elastic.symbolic.operations import ATAN2, COS, COSPI, MAXIMUM, MINIMUM, PI, SIGN, SIN, SQRT, SYMBOL

Monomial: TypeAlias = tuple[int, ...]
"""A product of s: their numbers, sorted; of a power as often as the exponent says."""
OUTSIDE, OF_SIGN = " outside of sines", ", its sign"
"""Suffixes of the names of separated variables."""


class NotPolynomial(Exception):
    """Raised for an expression that is not a polynomial of sines, cosines and other variables; the message says why."""


@dataclass(frozen=True)
class Degrees:
    """Degrees of an expression: trigonometric degree by angle, degree by other variable.

    `multiples` are the factors of variables where the expression is a sum of multiples of them and of a constant,
    `number` is its value where it is a rational number.
    """

    angles: Mapping[str, int] = field(default_factory=dict)
    powers: Mapping[str, int] = field(default_factory=dict)
    multiples: Mapping[str, Fraction] | None = None
    number: Fraction | None = None

    @property
    def is_constant(self) -> bool:
        """Whether it depends on no variable."""
        return not self.angles and not self.powers

    def __add__(self, other: Degrees) -> Degrees:
        return self._sum(other, 1)

    def __sub__(self, other: Degrees) -> Degrees:
        return self._sum(other, -1)

    def __neg__(self) -> Degrees:
        return self._times(Fraction(-1))

    def __mul__(self, other: Degrees) -> Degrees:
        if self.number is not None:
            return other._times(self.number)
        if other.number is not None:
            return self._times(other.number)
        constant = self._constant if other.is_constant else None
        return Degrees(_sum_of_degrees(self.angles, other.angles), _sum_of_degrees(self.powers, other.powers), constant)

    def __truediv__(self, other: Degrees) -> Degrees:
        if not other.is_constant:
            raise NotPolynomial(f"a quotient by what depends on {', '.join(other.variables)}")
        if other.number:
            return self._times(1 / other.number)
        return Degrees(self.angles, self.powers, self._constant)

    @property
    def variables(self) -> list[str]:
        """Names of all variables that it depends on."""
        return sorted({*self.angles, *self.powers})

    @property
    def _constant(self) -> Mapping[str, Fraction] | None:
        """Multiples of variables in a constant: an empty mapping; None for other expressions."""
        return {} if self.is_constant else None

    def _times(self, factor: Fraction) -> Degrees:
        multiples = None if self.multiples is None else {name: factor * x for name, x in self.multiples.items()}
        return Degrees(self.angles, self.powers, multiples, None if self.number is None else factor * self.number)

    def _sum(self, other: Degrees, sense: int) -> Degrees:
        multiples = None
        if self.multiples is not None and other.multiples is not None:
            names, zero = {*self.multiples, *other.multiples}, Fraction(0)
            multiples = {x: self.multiples.get(x, zero) + sense * other.multiples.get(x, zero) for x in names}
        number = None if self.number is None or other.number is None else self.number + sense * other.number
        return Degrees(_largest(self.angles, other.angles), _largest(self.powers, other.powers), multiples, number)


def degrees(roots: Iterable[Scalar], numbers: Iterable[str] = ()) -> list[Degrees]:
    """Return the degrees of expressions; variables in `numbers` are constants. Raises `NotPolynomial`."""
    roots, constants = list(roots), frozenset(numbers)
    nodes = reachable(roots)
    names = [node.operands[0] for node in nodes if node.operation == SYMBOL]
    symbols = {x: Degrees(multiples={}) if x in constants else Degrees({}, {x: 1}, {x: Fraction(1)}) for x in names}
    value = evaluate_nodes(nodes, symbols, _ARITHMETIC)
    return [_one_sided(value(root)) for root in roots]


def degrees_of(roots: Iterable[Scalar], box: Box) -> Degrees:
    """Return the degrees of a sum of expressions, of any graphs, over a box; raises `NotPolynomial`."""
    total = _one_sided(sum((degrees([root], box.numbers)[0] for root in roots), Degrees(multiples={})))
    if missing := sorted({*total.variables} - box.ranges.keys()):
        raise NotPolynomial(f"the box has no range for {', '.join(missing)}")
    return total


def _one_sided(x: Degrees) -> Degrees:
    if both := sorted(x.angles.keys() & x.powers.keys()):
        raise NotPolynomial(f"{both[0]} occurs inside of a sine or cosine and outside of it")
    return x


def _circular(x: Degrees) -> Degrees:
    if x.multiples is None:
        raise NotPolynomial(f"a sine or cosine of more than a sum of multiples of {', '.join(x.variables)}")
    for name, factor in sorted(x.multiples.items()):
        if factor.denominator != 1:
            raise NotPolynomial(f"a sine or cosine of {factor} {name}")
    return Degrees({name: abs(int(factor)) for name, factor in x.multiples.items() if factor}, multiples=x._constant)


def _function(name: str) -> Callable[..., Degrees]:
    def of_constants(*operands: Degrees) -> Degrees:
        for x in operands:
            if not x.is_constant:
                raise NotPolynomial(f"{name} of what depends on {', '.join(x.variables)}")
        return Degrees(multiples={})

    return of_constants


def _sum_of_degrees(x: Mapping[str, int], y: Mapping[str, int]) -> Mapping[str, int]:
    return {name: x.get(name, 0) + y.get(name, 0) for name in {*x, *y}} if x and y else x or y


def _largest(x: Mapping[str, int], y: Mapping[str, int]) -> Mapping[str, int]:
    return {name: max(x.get(name, 0), y.get(name, 0)) for name in {*x, *y}} if x and y else x or y


_FUNCTIONS = {
    SIN: _circular,
    COS: _circular,
    PI: _function("pi"),
    COSPI: _function("a cosine"),
    SQRT: _function("a square root"),
    SIGN: _function("a sign"),
    ATAN2: _function("an arc tangent"),
    MINIMUM: _function("a minimum"),
    MAXIMUM: _function("a maximum"),
}
_ARITHMETIC: Arithmetic[Degrees] = Arithmetic(
    lambda x: Degrees(multiples={}, number=Fraction(x)), Library(_function, _FUNCTIONS)
)


@dataclass(frozen=True)
class Polynomial:
    """Coefficients of products of s, with what bounds their rounding: sum of magnitudes m and number of roundings k."""

    terms: Mapping[Monomial, Any]
    size: float
    roundings: float

    @property
    def error(self) -> float:
        """Bound of the rounding errors of coefficients."""
        return self.size * self.roundings * UNIT * (1 + 1e-6) + 1e-300

    def __add__(self, other: Polynomial) -> Polynomial:
        return self._sum(other, 1)

    def __sub__(self, other: Polynomial) -> Polynomial:
        return self._sum(other, -1)

    def __neg__(self) -> Polynomial:
        return Polynomial({key: -x for key, x in self.terms.items()}, self.size, self.roundings)

    def __mul__(self, other: Polynomial) -> Polynomial:
        terms: dict[Monomial, Any] = {}
        for key_of_x, x in self.terms.items():
            for key_of_y, y in other.terms.items():
                key = tuple(sorted(key_of_x + key_of_y))
                terms[key] = terms[key] + x * y if key in terms else x * y
        added = min(len(self.terms), len(other.terms))
        return Polynomial(terms, self.size * other.size, self.roundings + other.roundings + added)

    def __truediv__(self, other: Polynomial) -> Polynomial:
        inverse = float(1 / Fraction(float(other.terms[()])))
        return self * Polynomial({(): np.float64(inverse)}, abs(inverse), other.roundings + 1)

    def _sum(self, other: Polynomial, sense: int) -> Polynomial:
        terms = dict(self.terms)
        for key, y in other.terms.items():
            added = y if sense > 0 else -y
            terms[key] = terms[key] + added if key in terms else added
        return Polynomial(terms, self.size + other.size, max(self.roundings, other.roundings) + 1)


def number(x: float, roundings: int = 1) -> Polynomial:
    """Return the polynomial of a number with a given number of roundings."""
    return Polynomial({(): np.float64(x)} if x else {}, abs(x), roundings)


def circular(operation: str, x: Polynomial) -> Polynomial:
    """Return the sine or cosine of an angle, to 4 ulp, including the error of the angle."""
    angle = x.terms.get((), np.float64(0))
    values = np.sin(angle) if operation == SIN else np.cos(angle)
    return Polynomial({(): values}, 1.0, 8 + x.size * x.roundings)


def variable(number_of: int, span: Range) -> Polynomial:
    """Return a variable of the motion as middle + half s."""
    low, high = span.low, span.high
    middle = low + (high - low) / 2
    half = max(high - middle, middle - low) * (1 + 4 * UNIT)
    terms: dict[Monomial, Any] = {(number_of,): np.float64(half)} | ({(): np.float64(middle)} if middle else {})
    return Polynomial(terms, abs(middle) + half, 0)


def constants(nodes: Sequence[Expression], numbers: Mapping[str, float]) -> dict[int, float]:
    """Return the values of nodes that depend on numbers only, from 60 digits, by node."""
    constant_nodes: dict[int, Expression] = {}
    for node in nodes:
        if node.operation == SYMBOL:
            is_constant = node.operands[0] in numbers
        else:
            is_constant = all(type(x) is not Expression or x.id in constant_nodes for x in node.operands)
        if is_constant:
            constant_nodes[node.id] = node
    digits = multiprecision(60)
    value = evaluate(constant_nodes.values(), {name: digits.number(Fraction(x)) for name, x in numbers.items()}, digits)
    return {key: float(value(node)) for key, node in constant_nodes.items()}


def polynomials(
    roots: Sequence[Operand], symbols: Mapping[str, Polynomial], numbers: Mapping[str, float]
) -> list[Polynomial]:
    """Return the polynomials of expressions without quotients; values of nodes are freed after their last use."""
    nodes = reachable(roots)
    uses = Counter(x.id for node in nodes for x in node.needs)
    uses.update(root.id for root in roots if type(root) is Expression)
    values = values_of(nodes, symbols, constants(nodes, numbers), uses)
    return [polynomial_of(root, values) for root in roots]


def values_of(
    nodes: Sequence[Expression],
    symbols: Mapping[str, Polynomial],
    constant_values: Mapping[int, float],
    uses: Counter[int] | None = None,
) -> dict[int, Polynomial]:
    """Return the polynomials of nodes, operands before their users, by node; `constant_values` are numbers by node.

    A variable that is not in `symbols` is zero. With `uses`, numbers of users by node, values are freed.
    """
    values: dict[int, Polynomial] = {}
    for node in nodes:
        if node.id in constant_values:
            values[node.id] = number(constant_values[node.id])
        elif node.operation == SYMBOL:
            values[node.id] = symbols.get(node.operands[0]) or number(0.0)
        else:
            operands = [polynomial_of(x, values) for x in node.operands]
            values[node.id] = _FUNCTIONS_OF_POLYNOMIALS[node.operation](*operands)
        if uses:
            for x in node.needs:
                uses[x.id] -= 1
                if not uses[x.id]:
                    del values[x.id]
    return values


def polynomial_of(x: Operand, values: Mapping[int, Polynomial]) -> Polynomial:
    """Return the polynomial of a node or of a number."""
    return values[x.id] if type(x) is Expression else number(float(x))


_FUNCTIONS_OF_POLYNOMIALS: Mapping[str, Callable[..., Polynomial]] = {
    **RATIONAL,
    SIN: partial(circular, SIN),
    COS: partial(circular, COS),
}


def separate_sides(roots: Sequence[Operand], box: Box, signs: bool = True) -> tuple[Sequence[Operand], Box]:
    """Return expressions and their box, with other names outside of sines for variables that are also inside of some.

    The expressions may belong to several graphs. With `signs` signs of variables become variables, too.
    """
    names = on_both_sides(roots, box)
    nodes = (node for root in roots for node in reachable([root])) if signs else ()
    arguments = (x for node in nodes if node.operation == SIGN for x in node.needs)
    of_signs = {str(x.operands[0]) for x in arguments if x.operation == SYMBOL} & box.ranges.keys()
    if not names and not of_signs:
        return roots, box
    ranges = {**box.ranges, **{name + OUTSIDE: box.ranges[name] for name in names}}
    for name in of_signs:
        low, high = np.sign([box.ranges[name].low, box.ranges[name].high])
        ranges[name + OF_SIGN] = Range(float(low), float(high))
    return [_separate(root, names, of_signs) for root in roots], replace(box, ranges=ranges)


def on_both_sides(roots: Sequence[Operand], box: Box) -> frozenset[str]:
    """Return the variables that occur both inside and outside of sines."""
    sides = [_sides(root) for root in roots]
    inside, outside = (frozenset[str]().union(*names) for names in zip(*sides, strict=True))
    return inside & outside & {*box.open}


def _sides(root: Operand) -> tuple[frozenset[str], frozenset[str]]:
    """Return the variables that occur inside of sines and cosines, and the variables that occur outside."""
    if type(root) is not Expression:
        return frozenset(), frozenset()
    nodes = reachable([root])
    inside, outside = set[int](), {root.id}
    for node in reversed(nodes):
        for x in node.needs:
            if node.id in outside and node.operation not in (SIN, COS):
                outside.add(x.id)
            if node.id in inside or node.operation in (SIN, COS):
                inside.add(x.id)
    names = {node.id: str(node.operands[0]) for node in nodes if node.operation == SYMBOL}
    return frozenset(names[k] for k in names.keys() & inside), frozenset(names[k] for k in names.keys() & outside)


def _separate(root: Operand, names: Collection[str], of_signs: Collection[str]) -> Operand:
    """A copy of an expression in a new graph, in which nodes have separate copies inside and outside of sines."""
    if type(root) is not Expression:
        return root
    graph = Graph()
    inside: dict[int, Operand] = {}
    outside: dict[int, Operand] = {}
    for node in reachable([root]):
        if node.operation == SYMBOL:
            name = node.operands[0]
            inside[node.id] = graph.symbol(name, node.level)
            outside[node.id] = graph.symbol(name + OUTSIDE, node.level) if name in names else inside[node.id]
            continue
        if node.operation == SIGN and node.needs and node.needs[0].operation == SYMBOL:
            name = str(node.needs[0].operands[0])
            if name in of_signs:
                inside[node.id] = outside[node.id] = graph.symbol(name + OF_SIGN, node.level)
                continue
        beyond = inside if node.operation in (SIN, COS) else outside
        inside[node.id] = graph.node(node.operation, *(_copy_of(x, inside) for x in node.operands))
        outside[node.id] = graph.node(node.operation, *(_copy_of(x, beyond) for x in node.operands))
    return outside[root.id]


def _copy_of(x: Operand, copies: Mapping[int, Operand]) -> Operand:
    return copies[x.id] if type(x) is Expression else x
