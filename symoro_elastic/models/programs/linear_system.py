"""The linear system A x = right that a direct model solves, as nodes of its program."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
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
from symoro_elastic.models.bound.model import Joints
from symoro_elastic.symbolic.expression import Expression, Operand, is_constant, operand
from symoro_elastic.symbolic.factoring import NewValues, Uses, divisions, factor_graph, remade
from symoro_elastic.symbolic.program import Program

OF_TERM = 4
"""Roundings of a term, such as (A_ji (1/D_j)) A_jk: the reciprocal, two products, and a literal number."""


@dataclass(frozen=True)
class LinearSystem:
    """A x = right, rows in the order in which they are eliminated: A = L^T D L (`mechanics/factorization.py`).

    `pivots` are the D_j. `shared` (n, n) counts the terms that are subtracted from an entry of A, `forward` those from
    the right side, `backward` those from x; a term has at most `roundings` roundings in addition to the sums.
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
    def entries(self) -> list[Operand]:
        """All entries of A and of the right side."""
        return [*(x for row in self.A for x in row), *self.right]

    def map(self, to: Callable[[Operand], Operand]) -> LinearSystem:
        """The system of a program whose nodes `to` maps from these."""
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
    values = {constant.label.name: constant.value for constant in program.named_constants} | dict(program.quantities)
    A = {i: {j: values.get(f"A{min(i, j)}_{max(i, j)}", 0) for j in joints} for i in joints}
    right: dict[int, Scalar] = {j: values.get(f"Gb{j}", 0) for j in joints}
    entries = (*right.values(), *(x for row in A.values() for x in row.values()))
    if any(isinstance(x, Expression) and x.positive.id not in present for x in entries):
        return None  # a number in an entry of A is one with what elimination subtracts
    order, by = joints[::-1], share
    if machine.is_coupled:
        order, by = by_minimum_degree(order, A, is_constant), share_or_one
    try:
        factors = factorization(order, A, by)
    except SingularPivot:
        return None
    x = solution(factors, right)
    emission = _emission(program, {j: operand(x[j]) for j in order})
    if emission is None:
        return None
    emitted, is_reordered = emission
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


def _emission(program: Program, x: Mapping[int, Operand]) -> tuple[NewValues, bool] | None:
    """The map from nodes of the elimination to those of the program, and whether operations were reordered.

    None where the results of the program are not those of the elimination.
    """
    results = [entry for output in program.outputs if output.name == "qdd" for entry in output.entries]
    constants = {node.positive.id for node in program.quantities.values() if isinstance(node, Expression)}
    uses = Uses(x.values(), constants)
    plain = remade(uses.nodes, divisions(uses))
    if _holds(results, [plain(entry) for entry in x.values()]):
        return plain, False
    values = NewValues()
    values.changed.update(factor_graph([*x.values()], constants)[0])
    return (values, True) if _holds(results, [values(entry) for entry in x.values()]) else None


def _holds(results: Sequence[Operand], x: Sequence[Operand]) -> bool:
    """Whether all results are among the entries of x: the same nodes, or the same constants."""
    nodes = {entry.id for entry in x if isinstance(entry, Expression)}
    constants = [entry for entry in x if not isinstance(entry, Expression)]
    return bool(results) and all(
        entry.id in nodes if isinstance(entry, Expression) else entry in constants for entry in results
    )


def _counts(factors: Factorization, place: Mapping[int, int]) -> tuple[Array, Array, Array]:
    """Numbers of products subtracted in the elimination, from entries of A, of the right side, and of x."""
    below = np.zeros((len(place), len(place)))
    for j, row in factors.L.items():
        below[place[j], [place[i] for i in row]] = 1
    shared: Array = below.T @ below
    return shared, below.sum(axis=0), below.sum(axis=1)
