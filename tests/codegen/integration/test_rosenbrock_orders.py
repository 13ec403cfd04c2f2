"""Order conditions of W-methods for any matrix T, and of Rosenbrock methods for the exact one, in exact rationals.

Tables are decimals of irrational numbers, so conditions hold to the digits that are printed.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from fractions import Fraction
from functools import partial

import pytest

from symoro_elastic.codegen.integration.tableaus import RODAS4, W2, W3, Coefficients, WMethod
from tests.codegen.integration.test_tableaus import Tree as PlainTree
from tests.codegen.integration.test_tableaus import density as plain_density
from tests.codegen.integration.test_tableaus import trees as plain_trees

Matrix = list[list[Fraction]]
Tree = tuple[bool, tuple["Tree", ...]]
"""A rooted tree: whether its root stands for T, which has one branch, instead of for f; the branches."""
W_METHODS = {"w2": (W2, 1e-19), "w3": (W3, 1e-15)}
"""Methods, and the rounding of their printed digits in a condition."""


def trees(order: int) -> Iterator[Tree]:
    """Trees of f and T with so many nodes, each once."""
    yield from ((False, forest) for forest in forests(order - 1, order - 1))
    if order > 1:
        yield from ((True, (tree,)) for tree in trees(order - 1))


def forests(nodes: int, largest: int) -> Iterator[tuple[Tree, ...]]:
    if nodes == 0:
        yield ()
    for first in range(min(nodes, largest), 0, -1):
        for tree in trees(first):
            for rest in forests(nodes - first, first):
                if not rest or size(rest[0]) < first or tree >= rest[0]:
                    yield (tree, *rest)


def size(tree: Tree) -> int:
    return 1 + sum(map(size, tree[1]))


def holds_t(tree: Tree) -> bool:
    return tree[0] or any(map(holds_t, tree[1]))


def density(tree: Tree) -> int:
    found = size(tree)
    for branch in tree[1]:
        found *= density(branch)
    return found


def square(rows: Sequence[Coefficients], diagonal: Fraction = Fraction(0)) -> Matrix:
    """A lower triangular matrix of its rows below the diagonal."""
    count = len(rows)
    return [[*row, *([diagonal] if k < count else []), *[Fraction(0)] * (count - k - 1)] for k, row in enumerate(rows)]


def elementary_weights(tree: Tree, a: Matrix, g: Matrix) -> list[Fraction]:
    branches = [elementary_weights(branch, a, g) for branch in tree[1]]
    return products(g if tree[0] else a, branches)


def products(matrix: Matrix, branches: Sequence[Sequence[Fraction]]) -> list[Fraction]:
    """By stage, the product over the branches of the row of the matrix times the weights of the branch."""
    found = [Fraction(1)] * len(matrix)
    for branch in branches:
        sums = [sum((x * y for x, y in zip(row, branch, strict=True)), Fraction(0)) for row in matrix]
        found = [x * y for x, y in zip(found, sums, strict=True)]
    return found


def worst(method: WMethod, weights: Coefficients, order: int) -> Fraction:
    """The largest error of a condition: elementary differentials with T vanish, others are those of the solution."""
    a, g = square(method.a), square(method.g, method.gamma)
    errors = []
    for tree in trees(order):
        total = sum((b * x for b, x in zip(weights, elementary_weights(tree, a, g), strict=True)), Fraction(0))
        errors.append(abs(total - (0 if holds_t(tree) else Fraction(1, density(tree)))))
    return max(errors)


def test_there_are_as_many_conditions_as_trees_of_two_colours() -> None:
    """Orders 1 to 3: 1, 2, 5 + 1 where T stands on T, as Steihaug and Wolfbrandt count them."""
    assert [len(list(trees(order))) for order in (1, 2, 3)] == [1, 2, 5]
    assert [len([t for t in trees(order) if not holds_t(t)]) for order in (1, 2, 3, 4)] == [1, 1, 2, 4]


@pytest.mark.parametrize("name", W_METHODS)
def test_w_methods_have_their_order_whatever_t_is(name: str) -> None:
    method, rounding = W_METHODS[name]
    assert all(worst(method, method.b, order) < rounding for order in range(1, method.order + 1))
    assert worst(method, method.b, method.order + 1) > 1e-3


def test_embedded_weights_have_an_order_less() -> None:
    assert all(worst(W3, W3.embedded, order) < 1e-15 for order in (1, 2))
    assert worst(W3, W3.embedded, 3) > 1e-3


@pytest.mark.parametrize("name", W_METHODS)
def test_the_last_stage_of_a_stiff_machine_is_damped(name: str) -> None:
    """R(infinity) = 1 - b (a + g)^-1 1 is zero: the methods are L-stable."""
    method, rounding = W_METHODS[name]
    x = solved(added(square(method.a), square(method.g, method.gamma)), [Fraction(1)] * len(method.b))
    assert abs(1 - sum(b * y for b, y in zip(method.b, x, strict=True))) < 100 * rounding


def solved(lower: Matrix, right: Sequence[Fraction]) -> list[Fraction]:
    """x of L x = r."""
    x: list[Fraction] = []
    for row, r in zip(lower, right, strict=True):
        x.append((r - sum((a * b for a, b in zip(row, x, strict=False)), Fraction(0))) / row[len(x)])
    return x


# RODAS: its printed form is u = G k, so a = a_printed G, b = m G with G = (1/gamma - c)^-1


def columns_of(lower: Matrix) -> Matrix:
    """The inverse of a lower triangular matrix."""
    count = len(lower)
    columns = [solved(lower, [Fraction(i == k) for i in range(count)]) for k in range(count)]
    return [[columns[k][i] for k in range(count)] for i in range(count)]


def times(A: Matrix, B: Matrix) -> Matrix:
    columns = list(zip(*B, strict=True))
    return [[sum((x * y for x, y in zip(row, c, strict=True)), Fraction(0)) for c in columns] for row in A]


def added(A: Matrix, B: Matrix) -> Matrix:
    return [[x + y for x, y in zip(*rows, strict=True)] for rows in zip(A, B, strict=True)]


def usual_form() -> tuple[Matrix, Matrix, Callable[[Coefficients], list[Fraction]]]:
    """Coefficients alpha and gamma of the stages k, and the way from printed weights to those of k."""
    lower = [[-x for x in row] for row in square(RODAS4.c)]
    for k, row in enumerate(lower):
        row[k] += 1 / RODAS4.gamma
    G = columns_of(lower)
    return times(square(RODAS4.a), G), G, lambda m: times([list(m)], G)[0]


def plain_weights(tree: PlainTree, alpha: Matrix, beta: Matrix) -> list[Fraction]:
    """With the exact matrix, a node with one branch has beta = alpha + gamma, others have alpha."""
    return products(beta if len(tree) == 1 else alpha, [plain_weights(branch, alpha, beta) for branch in tree])


def test_rodas4_has_order_4_with_the_exact_matrix_and_its_embedded_method_order_3() -> None:
    alpha, G, weights = usual_form()
    beta = added(alpha, G)

    def error(m: Coefficients, tree: PlainTree) -> Fraction:
        found = zip(weights(m), plain_weights(tree, alpha, beta), strict=True)
        return abs(sum((b * x for b, x in found), Fraction(0)) - Fraction(1, plain_density(tree)))

    main, embedded = partial(error, RODAS4.m), partial(error, RODAS4.embedded)
    assert max(main(tree) for order in range(1, 5) for tree in plain_trees(order)) < 1e-13
    assert max(embedded(tree) for order in range(1, 4) for tree in plain_trees(order)) < 1e-13
    assert max(map(main, plain_trees(5))) > 1e-4 and max(map(embedded, plain_trees(4))) > 1e-4


def test_times_of_rodas4_are_the_sums_of_its_rows() -> None:
    alpha, G, _ = usual_form()
    for row, gammas, time, rate in zip(alpha, G, RODAS4.alpha, RODAS4.gammas, strict=True):
        assert abs(sum(row) - time) < 1e-13 and abs(sum(gammas) - rate) < 1e-4
