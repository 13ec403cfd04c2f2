"""The linear system A x = right that a direct model solves: its parts among the nodes of the emitted program."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.scalar import Scalar
from symoro_elastic.machine.machine import Machine
from symoro_elastic.mechanics.elimination import SingularPivot
from symoro_elastic.mechanics.factorization import (
    Factorization,
    by_minimum_degree,
    factorization,
    share,
    share_or_one,
    solution,
)
from symoro_elastic.models.model import Joints
from symoro_elastic.symbolic.expression import Expression, Operand, is_constant, operand
from symoro_elastic.symbolic.factoring import NewValues, Uses, divisions, factor_graph, remade
from symoro_elastic.symbolic.program import Program

OF_TERM = 4
"""Roundings of a term, such as (A_ji (1/D_j)) A_jk: of the reciprocal, of two products, and of a number of the text."""


@dataclass(frozen=True)
class LinearSystem:
    """A x = right, rows in the order in which they are eliminated: A = L^T D L (`mechanics/factorization.py`).

    `pivots` are the D_j. `shared` (n, n) counts the terms that are subtracted from an entry of A, `forward` those from
    the right side, `backward` those from x; each is rounded at most `roundings` times beside the sums.
    """

    joints: Joints
    A: Sequence[Sequence[Operand]] = field(repr=False)
    right: Sequence[Operand] = field(repr=False)
    x: Sequence[Operand] = field(repr=False)
    pivots: Sequence[Operand] = field(repr=False)
    shared: Array
    forward: Array
    backward: Array
    roundings: int

    @property
    def given(self) -> list[Operand]:
        """All entries of A and of the right side."""
        return [*(x for row in self.A for x in row), *self.right]

    def moved(self, to: Callable[[Operand], Operand]) -> LinearSystem:
        """The system of a program with other nodes, whose sums have another order."""
        right, x, pivots = ([*map(to, part)] for part in (self.right, self.x, self.pivots))
        return replace(self, A=[[*map(to, row)] for row in self.A], right=right, x=x, pivots=pivots)


def linear_system(machine: Machine, program: Program) -> LinearSystem | None:
    """The system that a program through the inertia matrix solves; None where its nodes are not this elimination.

    The elimination is carried out again on the entries of A and the right side that the program has. Its solution must
    be the very nodes of the results: as they were traced, quotients in place of products with a reciprocal, or with
    products and sums of the elimination in another order.
    """
    joints = machine.independent
    present = {node.id for node in program.nodes}
    values = {one.label.name: one.value for one in program.named_constants} | dict(program.quantities)
    A = {i: {j: values.get(f"A{min(i, j)}_{max(i, j)}", 0) for j in joints} for i in joints}
    right: dict[int, Scalar] = {j: values.get(f"Gb{j}", 0) for j in joints}
    if not all(_is_present(x, present) for x in (*right.values(), *(x for row in A.values() for x in row.values()))):
        return None  # a number in an entry of A is one with what elimination subtracts
    order, by = joints[::-1], share
    if machine.is_coupled:
        order, by = by_minimum_degree(order, A, is_constant), share_or_one
    try:
        factors = factorization(order, A, by)
    except SingularPivot:
        return None
    x = solution(factors, right)
    found = _emitted(program, {j: operand(x[j]) for j in order})
    if found is None:
        return None
    emitted, is_reordered = found
    place = {j: k for k, j in enumerate(order)}
    return LinearSystem(
        tuple(order),
        [[A[i][k] for k in order] for i in order],
        [operand(right[j]) for j in order],
        [emitted(operand(x[j])) for j in order],
        [emitted(operand(factors.pivots[j])) for j in order],
        *_counts(factors, place),
        OF_TERM + is_reordered * 3 * len(order),
    )


def _is_present(x: Scalar, nodes: Collection[int]) -> bool:
    return not isinstance(x, Expression) or x.positive.id in nodes


def _emitted(program: Program, x: Mapping[int, Operand]) -> tuple[NewValues, bool] | None:
    """From nodes of the elimination to those of the program, and whether products and sums have another order.

    None where the results of the program are others.
    """
    results = [entry for output in program.outputs if output.name == "qdd" for entry in output.entries]
    named = {node.positive.id for node in program.quantities.values() if isinstance(node, Expression)}
    uses = Uses(x.values(), named)
    plain = remade(uses.nodes, divisions(uses))
    if _holds(results, [plain(one) for one in x.values()]):
        return plain, False
    values = NewValues()
    values.changed.update(factor_graph([*x.values()], named)[0])
    return (values, True) if _holds(results, [values(one) for one in x.values()]) else None


def _holds(results: Sequence[Operand], x: Sequence[Operand]) -> bool:
    """Whether all results are among the entries of x: the same nodes, or the same constants."""
    nodes = {one.id for one in x if isinstance(one, Expression)}
    constants = [one for one in x if not isinstance(one, Expression)]
    return bool(results) and all(
        one.id in nodes if isinstance(one, Expression) else one in constants for one in results
    )


def _counts(factors: Factorization, place: Mapping[int, int]) -> tuple[Array, Array, Array]:
    """How many terms are subtracted from entries of A, of the right side, and of x."""
    below = np.zeros((len(place), len(place)))
    for j, row in factors.L.items():
        below[place[j], [place[i] for i in row]] = 1
    shared: Array = below.T @ below
    return shared, below.sum(axis=0), below.sum(axis=1)
