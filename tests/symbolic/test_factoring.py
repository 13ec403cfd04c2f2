"""Rewritings: their examples, and the values, which stay the same."""

from __future__ import annotations

import doctest
import random
from collections.abc import Callable, Iterable
from fractions import Fraction

import pytest

from symoro_elastic.symbolic import factoring
from symoro_elastic.symbolic.arithmetic import RATIONAL, Arithmetic, evaluate
from symoro_elastic.symbolic.expression import Expression, Graph, Operand, reachable
from symoro_elastic.symbolic.factoring import REWRITINGS, Recipes, Rewriting, Uses, factor_graph, remade
from symoro_elastic.symbolic.operations import MULTIPLY

pytestmark = pytest.mark.sampled(6)

EXACT: Arithmetic[Fraction] = Arithmetic(Fraction, RATIONAL)


def rewritten(
    recipes: Callable[[Uses], Recipes], *roots: Operand, named: Iterable[Expression] = ()
) -> tuple[Operand, ...]:
    """Roots after one rewriting; expressions that are `named` stay whole."""
    uses = Uses(roots, {x.id for x in named})
    return tuple(map(remade(uses.nodes, recipes(uses)), roots))


def test_examples_in_the_docstrings() -> None:
    graph = Graph()
    names = {name: graph.symbol(name) for name in "wxyz"}
    found = doctest.testmod(factoring, extraglobs={"rewritten": rewritten, **names})
    assert found.attempted >= 9 and not found.failed


def polynomial(source: random.Random, graph: Graph) -> Expression:
    """A sum of products with shared factors, quotients and signs."""
    symbols = [graph.symbol(name) for name in "uvwxyz"]
    total: Operand = 0
    for _ in range(source.randrange(2, 7)):
        product: Operand = source.choice((1, 1, 2, Fraction(1, 3)))
        for factor in source.choices(symbols, k=source.randrange(1, 5)):
            product = product * (1 / factor if source.random() < 0.2 else factor)
        total = total + product if source.random() < 0.7 else total - product
    assert isinstance(total, Expression)
    return total


@pytest.mark.parametrize("rewriting", REWRITINGS, ids=[rewriting.name for rewriting in REWRITINGS])
@pytest.mark.parametrize("seed", range(20))
def test_values_stay_and_no_product_is_added(rewriting: Rewriting, seed: int) -> None:
    source, graph = random.Random(seed), Graph()
    roots = [polynomial(source, graph) for _ in range(4)]
    symbols = {name: Fraction(source.randrange(1, 99), source.randrange(1, 99)) for name in "uvwxyz"}
    made = rewritten(rewriting.recipes, *roots)
    before, after = evaluate(roots, symbols, EXACT), evaluate(made, symbols, EXACT)
    assert list(map(before, roots)) == list(map(after, made))
    assert products(made) <= products(roots)


def products(roots: Iterable[Operand]) -> int:
    return sum(node.operation == MULTIPLY for node in reachable(roots))


def test_all_of_them_save_products() -> None:
    graph = Graph()
    w, x, y, z = (graph.symbol(name) for name in "wxyz")
    roots = [x * y * w + x * z * w, y * (1 / z) * w]
    values, nodes = factor_graph(roots, ())
    assert [str(values[root.id]) for root in roots] == ["((w*x)*(y + z))", "(w*(y/z))"]
    assert [node.id for node in nodes] == sorted(node.id for node in nodes)
