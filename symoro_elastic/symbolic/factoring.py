"""Fewer products for the same values: three rewritings of the expressions of a program.

Notation: x, y, z are expressions, a, b, c parameters. The *uses* of a node are the operands and the roots that
refer to it. A node is *inner* when it has one use and no name: then only its user knows it, and may compute
the same value by another way. A node with a name (`H5`, `K5_33`) is a quantity of the paper and stays whole.

1. Division. The recursions compute 1/H once and multiply by it. Where 1/H has a single use,

       x (1/H)  ->  x/H                                               a product less.

2. Shared factors. An inner product that is an operand of a product is taken apart, so that a product is a bag of
   factors f1 f2 ... fn, n > 2, which costs n - 1 products in whatever order it is carried out. A pair {f, g} that
   occurs in m of the bags can be computed once and put into each of them as one factor. The gain is

       m - 1   products, or m where f g is computed anyway: as a product of its own, or from parameters only,
               once for a set of parameters and not in each call.

   The pair with the largest gain is joined first, of equal ones that whose factors come first in the program; gains
   of pairs that overlap with it fall, so they are computed anew when their turn comes, until none is positive.
   (To find the least number of products is a hard problem of covering; this greedy choice is the usual answer.)

       x y w,  x z w,  x w    ->   x w = p,  p y,  p z                 2 + 2 + 1 products become 3.

3. Common factors. An inner sum that is an operand of a sum is taken apart, so that a sum is a row of terms with
   signs. The factor that occurs in most of its inner products, if in two or more, is taken out:

       x w + y + z w  ->  w (x + z) + y                                m products become one.

   Of factors that occur equally often, the youngest expression is taken out; it is nearest to the result.

Each rewriting finds what it changes, then all nodes that depend on a change are made again from their new operands,
in their old order. Values are the same in exact arithmetic; rounding errors differ.
"""

from __future__ import annotations

import heapq
from collections import Counter, defaultdict
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from itertools import combinations
from operator import attrgetter
from typing import NamedTuple, Protocol, TypeAlias

from symoro_elastic.foundation.scalar import Scalar
from symoro_elastic.symbolic.arithmetic import EXACT
from symoro_elastic.symbolic.expression import Expression, Level, Operand, quotient
from symoro_elastic.symbolic.operations import ADD, DIVIDE, MULTIPLY, NEGATE, SUBTRACT


class Uses:
    """The nodes that some roots need, operands before their users, and how often each is used."""

    def __init__(self, roots: Iterable[Scalar], whole: Collection[int] = ()) -> None:
        self._whole = whole
        self.nodes: list[Expression] = []
        self._of: defaultdict[str, list[Expression]] = defaultdict(list)
        used = [x for x in roots if type(x) is Expression]
        older = used[0].graph.nodes[: 1 + max(x.id for x in used)] if used else []
        self._times = times = [0] * len(older)
        for x in used:
            times[x.id] += 1
        for node in reversed(older):
            if times[node.id]:
                self.nodes.append(node)
                for x in node.needs:
                    times[x.id] += 1
        self.nodes.reverse()
        for node in self.nodes:
            self._of[node.operation].append(node)

    def of(self, *operations: str) -> list[Expression]:
        """The nodes whose operation is one of these, in order."""
        nodes = [node for operation in operations for node in self._of[operation]]
        return sorted(nodes, key=attrgetter("id")) if len(operations) > 1 else nodes

    def once(self, x: Expression) -> bool:
        """Whether a node has a single use."""
        return self._times[x.id] == 1

    def inner(self, *operations: str) -> set[Expression]:
        """The nodes of some operations that have a single use and no name."""
        times, whole = self._times, self._whole
        nodes = (node for operation in operations for node in self._of[operation])
        return {node for node in nodes if times[node.id] == 1 and node.id not in whole}


class NewValues:
    """Replacements of nodes: `changed` by number; other nodes are unchanged."""

    def __init__(self) -> None:
        self.changed: dict[int, Operand] = {}

    def __call__(self, x: Operand) -> Operand:
        """The new value of an expression; a sign is carried over from -x to x."""
        if type(x) is not Expression:
            return x
        value = self.changed.get(x.id)
        if value is not None:
            return value
        if x.operation == NEGATE and x.operands[0].id in self.changed:
            return -self.changed[x.operands[0].id]
        return x


class Recipe(Protocol):
    """Another way to compute a node."""

    def rebuilt(self, value: NewValues) -> Operand:
        """The node computed again, from the new values of older nodes."""


Recipes: TypeAlias = Mapping[int, Recipe]
"""Recipes by the number of the node that they compute."""


class Rewriting(NamedTuple):
    """A method to save products: its name, and the recipes that it finds."""

    name: str
    recipes: Callable[[Uses], Recipes]


def factor_graph(roots: Sequence[Scalar], named: Collection[int]) -> tuple[dict[int, Operand], list[Expression]]:
    """New values of the roots and of the nodes whose number is `named`, and the nodes that the new roots need.

    Values are given for what the roots need, by number; nodes with a name stay whole.
    """
    uses = Uses(roots, named)
    values: dict[int, Operand] = {node.id: node for node in uses.nodes if node.id in named}
    values |= {root.id: root for root in roots if type(root) is Expression}
    for rewriting in REWRITINGS:
        recipes = rewriting.recipes(uses)
        if recipes:
            value = remade(uses.nodes, recipes)
            values = {number: value(x) for number, x in values.items()}
            undivided = {x.positive.id for number, x in values.items() if number in named and type(x) is Expression}
            uses = Uses((values[root.id] for root in roots if type(root) is Expression), undivided)
    return values, uses.nodes


def remade(nodes: Iterable[Expression], recipes: Recipes) -> NewValues:
    """New values of nodes: by recipe, or by their operation on new operands."""
    value = NewValues()
    changed = value.changed
    for node in nodes:
        if node.id in recipes:
            changed[node.id] = recipes[node.id].rebuilt(value)
            continue
        for x in node.needs:
            if x.id in changed:
                changed[node.id] = _apply(node, [value(o) for o in node.operands])
                break
    return value


def _apply(node: Expression, operands: Sequence[Operand]) -> Operand:
    """The operation of a node on other operands."""
    operation = EXACT.get(node.operation)
    value: Operand = operation(*operands) if operation else node.graph.node(node.operation, *operands)
    return value


# 1. Division


class Quotient(NamedTuple):
    """x/y, made in one operation."""

    x: Operand
    y: Operand

    def rebuilt(self, value: NewValues) -> Operand:
        """The quotient of the new values."""
        return quotient(value(self.x), value(self.y))


def divisions(uses: Uses) -> Recipes:
    """Recipes of products x (1/y) as quotients x/y, where 1/y has no other use.

    >>> before = x * (1 / y), z * (1 / w), y * (1 / w)
    >>> before
    ((x*(1/y)), (z*(1/w)), (y*(1/w)))
    >>> rewritten(divisions, *before)
    ((x/y), (z*(1/w)), (y*(1/w)))
    """
    recipes: dict[int, Recipe] = {}
    reciprocals = {node for node in uses.of(DIVIDE) if uses.once(node) and node.operands[0] == 1}
    for node in uses.of(MULTIPLY) if reciprocals else ():
        first, second = node.operands
        if first in reciprocals:
            recipes[node.id] = Quotient(second, first.operands[1])
        elif second in reciprocals:
            recipes[node.id] = Quotient(first, second.operands[1])
    return recipes


# 2. Shared factors

Atom: TypeAlias = int
"""Number of a factor, or of a pair of factors, in the order in which they first occur."""
Pair: TypeAlias = tuple[Atom, Atom]


class Product(NamedTuple):
    """A product of atoms, which are indices into `parts`: there, each is a factor, or a pair of atoms."""

    atoms: Sequence[Atom]
    parts: Sequence[Operand | Pair]

    def rebuilt(self, value: NewValues) -> Operand:
        """The product of the new values."""
        product: Operand = 1
        for atom in self.atoms:
            part = self.parts[atom]
            product = (Product(part, self.parts).rebuilt(value) if isinstance(part, tuple) else value(part)) * product
        return product


def shared_factors(uses: Uses) -> Recipes:
    """Products of three factors or more are carried out with the pairs first that most of them share.

    >>> before = x * y * w, x * z * w
    >>> before
    ((w*(x*y)), (w*(x*z)))
    >>> rewritten(shared_factors, *before)
    ((y*(w*x)), (z*(w*x)))
    >>> rewritten(shared_factors, *before, named=[x * y])
    ((w*(x*y)), (w*(x*z)))
    """
    inner = uses.inner(MULTIPLY)
    factors: dict[int, list[Operand]] = {}
    for node in uses.of(MULTIPLY):
        operands: list[Operand] = []
        for x in node.operands:
            operands += factors.pop(x.id) if x in inner else (x,)
        factors[node.id] = operands
    return _Pairing(factors).recipes()


class _Pairing:
    """Which pairs of factors of some products are multiplied first.

    `_bags` are the products of more than two factors, as they are after the pairs that have been joined;
    `_holders` the numbers of the products with a pair; `_made` the pairs that are products by themselves; `_free`
    whether an atom depends on parameters and constants only.
    """

    def __init__(self, products: Mapping[int, Sequence[Operand]]) -> None:
        self._atoms: dict[Operand, Atom] = {}
        self._parts: list[Operand | Pair] = []
        self._free: list[bool] = []
        bags = {number: [self._atom(x) for x in factors] for number, factors in products.items()}
        pairs = (bag for bag in bags.values() if len(bag) == 2)
        self._made = {(first, second) if first < second else (second, first) for first, second in pairs}
        self._bags = {number: bag for number, bag in bags.items() if len(bag) > 2}
        self._holders: defaultdict[Pair, set[int]] = defaultdict(set)
        self._heap: list[tuple[int, Pair]] = []
        self._changed: set[int] = set()
        for number in self._bags:
            self._offer(number)

    def _atom(self, factor: Operand) -> Atom:
        atom = self._atoms.get(factor)
        if atom is None:
            atom = self._atoms[factor] = len(self._parts)
            self._parts.append(factor)
            self._free.append(type(factor) is not Expression or factor.level < Level.STATE)
        return atom

    def _pairs(self, number: int) -> set[Pair]:
        return set(combinations(sorted(self._bags[number]), 2))

    def _offer(self, number: int) -> None:
        """Enter the pairs of a product that may be multiplied first, unless only one order remains."""
        pairs = self._pairs(number)
        if len(self._bags[number]) == 2:
            self._made |= pairs
            return
        for pair in pairs:
            self._holders[pair].add(number)
            heapq.heappush(self._heap, (-self._gain(pair), pair))

    def _gain(self, pair: Pair) -> int:
        """Products saved by computing this pair once."""
        first, second = pair
        costs = pair not in self._made and not (self._free[first] and self._free[second])
        return len(self._holders[pair]) - costs

    def recipes(self) -> Recipes:
        """Recipes of the products whose order changes."""
        while self._heap:
            offered, pair = heapq.heappop(self._heap)
            gain = self._gain(pair)
            if gain > 0 and gain != -offered:
                heapq.heappush(self._heap, (-gain, pair))
            elif gain > 0:
                self._join(pair)
        return {number: Product(bag, self._parts) for number, bag in self._bags.items() if number in self._changed}

    def _join(self, pair: Pair) -> None:
        """Make a pair one atom, in every product that holds it."""
        joined = len(self._parts)
        self._parts.append(pair)
        self._free.append(self._free[pair[0]] and self._free[pair[1]])
        for number in sorted(self._holders[pair]):
            for other in self._pairs(number):
                self._holders[other].discard(number)
            bag = self._bags[number]
            for atom in pair:
                bag.remove(atom)
            bag.append(joined)
            self._changed.add(number)
            self._offer(number)


# 3. Common factors

Term: TypeAlias = tuple[int, Operand]
"""Sign, 1 or -1, and addend."""


class FactoredSum(NamedTuple):
    """factor (sum of cofactors) + the other terms; `products` are the terms that may be split."""

    factor: Operand
    terms: Sequence[Term]
    products: Collection[Expression]

    def rebuilt(self, value: NewValues) -> Operand:
        """The sum of the new values."""
        factor, multiplied, others = value(self.factor), _Sum(), _Sum()
        for sign, x in self.terms:
            if isinstance(x, Expression) and x in self.products and self.factor in x.operands:
                first, second = x.operands
                multiplied.add(sign, value(second if first == self.factor else first))
            else:
                others.add(sign, value(x))
        return factor * multiplied.total + others.total


class _Sum:
    def __init__(self) -> None:
        self.total: Operand = 0

    def add(self, sign: int, x: Operand) -> None:
        self.total = self.total + (x if sign > 0 else -x)


def common_factors(uses: Uses) -> Recipes:
    """Products in a sum that share a factor are added before they are multiplied.

    >>> before = x * w + y - z * w
    >>> before
    ((y + (w*x)) - (w*z))
    >>> rewritten(common_factors, before)
    ((y + (w*(x - z))),)
    """
    inner, products = uses.inner(ADD, SUBTRACT), uses.inner(MULTIPLY)
    terms: dict[int, list[Term]] = {}
    for node in uses.of(ADD, SUBTRACT):
        first, second = node.operands
        sign = -1 if node.operation == SUBTRACT else 1
        addends = terms.pop(first.id) if first in inner else [(1, first)]
        addends += [(sign * s, x) for s, x in terms.pop(second.id)] if second in inner else [(sign, second)]
        terms[node.id] = addends
    recipes: dict[int, Recipe] = {}
    for number, addends in terms.items():
        factor = _most_common([x for _, x in addends if type(x) is Expression and x in products])
        if factor is not None:
            recipes[number] = FactoredSum(factor, addends, products)
    return recipes


def _most_common(products: Sequence[Expression]) -> Operand | None:
    """The factor that most products have; None if all factors are distinct."""
    if len(products) < 2:
        return None
    factors = [factor for x in products for factor in set(x.operands)]
    if len(set(factors)) == len(factors):
        return None
    times = Counter(factors)
    most = max(times.values())
    commonest: list[Operand] = [factor for factor, n in times.items() if n == most]
    return max(commonest, key=lambda x: (True, x.id) if type(x) is Expression else (False, x))


REWRITINGS = (
    Rewriting("divisions", divisions),
    Rewriting("shared factors", shared_factors),
    Rewriting("common factors", common_factors),
)
"""Rewritings in the order of their application, in which they find most."""
