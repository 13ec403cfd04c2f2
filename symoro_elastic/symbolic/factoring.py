"""Fewer products for the same values.

The reciprocal of a quantity that is used once is a division. A product of three factors or more may
be carried out in any order: the pairs of factors that most products have in common come first, and
once. Terms of a sum that share a factor are added before they are multiplied.
"""

from __future__ import annotations

import heapq
from collections import Counter, defaultdict
from collections.abc import Callable, Container, Iterable, Sequence
from itertools import combinations
from typing import TypeAlias

from symoro_elastic.symbolic.arithmetic import RATIONAL
from symoro_elastic.symbolic.expression import (
    ADD,
    DIVIDE,
    MULTIPLY,
    NEGATE,
    SUBTRACT,
    Expression,
    Level,
    Scalar,
    reachable,
)

Values: TypeAlias = Callable[[Scalar], Scalar]
Recipes: TypeAlias = dict[int, Callable[[Values], Scalar]]
"""How nodes are made, by number, from the new values of older nodes."""
Atom: TypeAlias = int
"""Number of a factor or of a pair of factors."""


def factored(roots: Iterable[Scalar], named: Container[int]) -> dict[int, Scalar]:
    """New values of all nodes that the roots need, by number; the nodes with a name stay whole."""
    roots = list(roots)
    values: dict[int, Scalar] = {node.id: node for node in reachable(roots)}
    for rewriting in (_divisions, _shared_factors, _common_factors):
        now = [values[root.id] if isinstance(root, Expression) else root for root in roots]
        whole = {_positive(x).id for number, x in values.items() if number in named and isinstance(x, Expression)}
        uses = _Uses(now, whole)
        rebuilt = _rebuilt(uses, rewriting(uses))
        values = {number: rebuilt(x) for number, x in values.items()}
    return values


def _positive(x: Expression) -> Expression:
    positive: Expression = x.operands[0] if x.operation == NEGATE else x
    return positive


class _Uses:
    """The nodes that some roots need, and which of them serve one user only."""

    def __init__(self, roots: Sequence[Scalar], whole: Container[int]) -> None:
        self.nodes, self._whole = reachable(roots), whole
        self._times = Counter(o.id for node in self.nodes for o in node.operands if isinstance(o, Expression))
        self._times.update(root.id for root in roots if isinstance(root, Expression))

    def once(self, x: Scalar, *operations: str) -> bool:
        """Whether x is such an operation and is used once."""
        return isinstance(x, Expression) and x.operation in operations and self._times[x.id] == 1

    def inner(self, x: Scalar, *operations: str) -> bool:
        """Whether x is also free of a name, so that its user may take it apart."""
        return self.once(x, *operations) and x.id not in self._whole


def _rebuilt(uses: _Uses, recipes: Recipes) -> Values:
    """The new value of every node: by its recipe, or by its operation on new operands."""
    values: dict[int, Scalar] = {}

    def value(x: Scalar) -> Scalar:
        if not isinstance(x, Expression):
            return x
        if x.id in values:
            return values[x.id]
        return -values[x.operands[0].id] if x.operation == NEGATE and x.operands[0].id in values else x

    for node in uses.nodes:
        operands = [value(o) for o in node.operands]
        if node.id in recipes:
            values[node.id] = recipes[node.id](value)
        elif all(new is old for new, old in zip(operands, node.operands, strict=True)):
            values[node.id] = node
        elif node.operation in RATIONAL:
            values[node.id] = RATIONAL[node.operation](*operands)
        else:
            values[node.id] = node.graph.node(node.operation, *operands)
    return value


def _divisions(uses: _Uses) -> Recipes:
    """x (1/y) is x/y where 1/y has no other use."""
    recipes: Recipes = {}
    for node in uses.nodes:
        for x, other in (node.operands, node.operands[::-1]) if node.operation == MULTIPLY else ():
            if uses.once(other, DIVIDE) and other.operands[0] == 1:
                recipes[node.id] = lambda value, x=x, y=other.operands[1]: value(x) / value(y)  # type: ignore[misc]
    return recipes


def _shared_factors(uses: _Uses) -> Recipes:
    """Products of three factors or more, the pairs that most of them share first."""
    factors: dict[int, list[Scalar]] = {}
    inner: set[int] = set()
    for node in uses.nodes:
        if node.operation == MULTIPLY:
            found = [o for o in node.operands if uses.inner(o, MULTIPLY)]
            inner.update(o.id for o in found)
            factors[node.id] = [f for o in node.operands for f in (factors[o.id] if o in found else (o,))]
    return _Pairing({number: found for number, found in factors.items() if number not in inner}).recipes()


def _key(x: Scalar) -> tuple[bool, Scalar]:
    return (True, x.id) if isinstance(x, Expression) else (False, x)


class _Pairing:
    """Which factors of some products are multiplied first, so that as few products as possible are left."""

    def __init__(self, products: dict[int, list[Scalar]]) -> None:
        self._atoms: dict[tuple[bool, Scalar], Atom] = {}
        self._parts: list[Scalar | tuple[Atom, Atom]] = []
        self._once: list[bool] = []
        self._holders: dict[tuple[Atom, Atom], set[int]] = defaultdict(set)
        self._heap: list[tuple[int, tuple[Atom, Atom]]] = []
        atoms = {number: [self._atom(x) for x in factors] for number, factors in products.items()}
        self._made = {(min(pair), max(pair)) for pair in atoms.values() if len(pair) == 2}
        self._before = {number: found for number, found in atoms.items() if len(found) > 2}
        self._after = {number: list(found) for number, found in self._before.items()}
        for number in self._after:
            self._offer(number)

    def _atom(self, factor: Scalar) -> Atom:
        atom = self._atoms.setdefault(_key(factor), len(self._parts))
        if atom == len(self._parts):
            self._parts.append(factor)
            self._once.append(not isinstance(factor, Expression) or factor.level < Level.STATE)
        return atom

    def _pairs(self, number: int) -> set[tuple[Atom, Atom]]:
        return set(combinations(sorted(self._after[number]), 2))

    def _offer(self, number: int) -> None:
        """Enter a product that may still be carried out in more than one order."""
        if len(self._after[number]) == 2:
            self._made |= self._pairs(number)
            return
        for pair in self._pairs(number):
            self._holders[pair].add(number)
            heapq.heappush(self._heap, (-self._gain(pair), pair))

    def _gain(self, pair: tuple[Atom, Atom]) -> int:
        """Products saved by computing this pair once; for parameters only it costs nothing in a call."""
        free = pair in self._made or all(self._once[atom] for atom in pair)
        return len(self._holders[pair]) - (not free)

    def recipes(self) -> Recipes:
        """How to make the products whose order changes."""
        while self._heap:
            offered, pair = heapq.heappop(self._heap)
            gain = self._gain(pair)
            if gain > 0 and gain != -offered:
                heapq.heappush(self._heap, (-gain, pair))
            elif gain > 0:
                self._join(pair)
        return {
            number: lambda value, atoms=atoms: self._product(atoms, value)  # type: ignore[misc]
            for number, atoms in self._after.items()
            if atoms != self._before[number]
        }

    def _join(self, pair: tuple[Atom, Atom]) -> None:
        self._parts.append(pair)
        self._once.append(all(self._once[atom] for atom in pair))
        for number in sorted(self._holders[pair]):
            for other in self._pairs(number):
                self._holders[other].discard(number)
            for atom in pair:
                self._after[number].remove(atom)
            self._after[number].append(len(self._parts) - 1)
            self._offer(number)

    def _product(self, atoms: Iterable[Atom], value: Values) -> Scalar:
        product: Scalar = 1
        for atom in atoms:
            part = self._parts[atom]
            product = (self._product(part, value) if isinstance(part, tuple) else value(part)) * product
        return product


def _common_factors(uses: _Uses) -> Recipes:
    """Sums in which products share a factor: a b + a c is a (b + c)."""
    terms: dict[int, list[tuple[int, Scalar]]] = {}
    inner: set[int] = set()
    for node in uses.nodes:
        if node.operation in (ADD, SUBTRACT):
            terms[node.id] = []
            for sign, o in zip((1, -1 if node.operation == SUBTRACT else 1), node.operands, strict=True):
                taken_apart = uses.inner(o, ADD, SUBTRACT)
                inner.update({o.id} if taken_apart else ())
                terms[node.id] += [(sign * s, t) for s, t in terms[o.id]] if taken_apart else [(sign, o)]
    found = {number: _most_common_factor(uses, terms[number]) for number in terms if number not in inner}
    return {
        number: lambda value, factor=factor, terms=terms[number]: _taken_out(uses, factor, terms, value)  # type: ignore[misc]
        for number, factor in found.items()
        if factor is not None
    }


def _most_common_factor(uses: _Uses, terms: Iterable[tuple[int, Scalar]]) -> tuple[bool, Scalar] | None:
    times = Counter(_key(factor) for _, x in terms if uses.inner(x, MULTIPLY) for factor in set(x.operands))
    factor = max(times, key=lambda key: (times[key], key), default=None)
    return factor if factor and times[factor] > 1 else None


def _taken_out(uses: _Uses, factor: tuple[bool, Scalar], terms: Iterable[tuple[int, Scalar]], value: Values) -> Scalar:
    alone: Scalar = 0
    shared: Scalar = 0
    common: Scalar = 0
    for sign, x in terms:
        keys = [_key(o) for o in x.operands] if uses.inner(x, MULTIPLY) else []
        if factor in keys:
            place = keys.index(factor)
            common, shared = value(x.operands[place]), shared + sign * value(x.operands[1 - place])
        else:
            alone = alone + sign * value(x)
    return common * shared + alone
