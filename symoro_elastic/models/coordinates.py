"""The joints of a machine as functions of its independent variables u: joint coordinates x, S = dq/du and gam.

The cell of a joint is its coordinate x, or that and a formula of other joints' variables, or a formula only. Variables
that loops give come from closed forms where there are any, else they are arguments; their rates come from the loops'
equations, but for parallelograms, whose angles are sums of angles.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from itertools import combinations

from symoro_elastic.foundation.scalar import Scalar
from symoro_elastic.mechanics.coordinates import Row, combination, product
from symoro_elastic.mechanics.loops.closing import closing_acceleration, closing_columns, closing_error
from symoro_elastic.mechanics.loops.linear import solve
from symoro_elastic.mechanics.spatial import Twist
from symoro_elastic.models.loops.assembly import loop_branches
from symoro_elastic.models.loops.naming import (
    name_accelerations,
    name_determinant,
    name_equations,
    name_partials,
    name_rates,
)
from symoro_elastic.models.loops.plan import Form, LoopPlan
from symoro_elastic.models.tree import Tree
from symoro_elastic.symbolic.differentiation import Differentiation
from symoro_elastic.symbolic.expression import Expression


class Coordinates:
    """S = dq/du, gam and the same of joint coordinates, of a machine bound to the equations."""

    def __init__(self, tree: Tree, loops: Iterable[LoopPlan] = ()) -> None:
        self.tree, self.machine = tree, tree.machine
        self.loops = tuple(one for one in loops if one.dependent)
        self._columns: dict[tuple[str, int | None], dict[int, Twist]] = {}
        self.couplings = tree.couplings

    @cached_property
    def S_x(self) -> dict[int, Row]:
        """dx/du: rows by the joints that own variables."""
        found: dict[int, Row] = {j: {j: 1} for j in self.machine.independent}
        for j, x in self.tree.variables.items():
            if isinstance(x, Expression) and j in self._mapped:
                tangents = Differentiation([x])
                rows = ((k, tangents.by(q).of(x)) for k, q in self.tree.q.items())
                found[j] = combination((entry, {k: 1}) for k, entry in rows)
        for block in self.blocks:
            found |= self._dependent_rows(block, found)
        return found

    @cached_property
    def S(self) -> dict[int, Row]:
        """dq/du: rows by the joints of the tree (L1)."""
        return {j: self.tree.row(j, self.S_x) for j in self.machine.articulated}

    @cached_property
    def rates_x(self) -> dict[int, Scalar]:
        """Rates of joint coordinates."""
        rates = {j: product(row, self.tree.qd) for j, row in self.S_x.items()}
        for one in (one for block in self.blocks for one in block):
            name_rates(self.tree.names, one, rates)
        return rates

    @cached_property
    def gam_x(self) -> dict[int, Scalar]:
        """Second derivatives of joint coordinates where those of the independent ones are zero."""
        found: dict[int, Scalar] = dict.fromkeys((*self.machine.independent, *self._mapped), 0)
        for block in self.blocks:
            found |= self._dependent_accelerations(block, found)
        return found

    @cached_property
    def gam(self) -> dict[int, Scalar]:
        """Second derivatives of joint positions where those of the independent variables are zero (L2)."""
        return {j: self._gam(j, self.gam_x) for j in self.machine.articulated}

    def _gam(self, j: int, gam_x: Mapping[int, Scalar]) -> Scalar:
        own = gam_x.get(j, 0)
        if j not in self.couplings:
            return own
        return own + product(self.couplings[j].partials, gam_x) + self.couplings[j].second(self.rates_x)  # (L4)

    @property
    def _mapped(self) -> tuple[int, ...]:
        """Dependent joints of parallelograms."""
        return tuple(j for one in self.loops if one.form is Form.MAP for j in one.dependent)

    @cached_property
    def blocks_with_maps(self) -> list[list[LoopPlan]]:
        """All loops in the order in which they are closed, those that share dependent joints together."""
        return self._united(self.loops)

    @cached_property
    def blocks(self) -> list[list[LoopPlan]]:
        """The same without parallelograms."""
        return self._united(one for one in self.loops if one.form is not Form.MAP)

    @property
    def assembled_blocks(self) -> list[list[LoopPlan]]:
        """Those whose dependent variables are arguments."""
        return [block for block in self.blocks if any(one.is_assembled for one in block)]

    def _united(self, loops: Iterable[LoopPlan]) -> list[list[LoopPlan]]:
        """Blocks of loops: those together of which one needs dependent joints that only a later one gives."""
        blocks = [[one] for one in loops]
        while pair := next((pair for pair in combinations(blocks, 2) if self._needs(*pair)), None):
            first, later = pair
            blocks = [[*first, *later] if block is later else block for block in blocks if block is not first]
        return blocks

    def _needs(self, first: Iterable[LoopPlan], later: Sequence[LoopPlan]) -> bool:
        given = {j for one in later for j in one.dependent}
        return any(not given.isdisjoint((*one.dependent, *self.machine.with_variable_in(one.loop))) for one in first)

    def _dependent_rows(self, block: list[LoopPlan], S_x: Mapping[int, Row]) -> dict[int, Row]:
        """Rows of dx/du of a block of loops: -W_d^-1 W_u S (L10)."""
        unknown, known = self.unknown(block), self._W_u(block, S_x)
        k = sorted({k for row in known for k in row})
        W_d = self._W_d(block)
        columns = solve(W_d, [[-row.get(i, 0) for row in known] for i in k])
        rows: dict[int, Row] = {
            d: combination((column[m], {i: 1}) for i, column in zip(k, columns, strict=True))
            for m, d in enumerate(unknown)
        }
        for one in block:
            name_equations(self.tree.names, one, self._closing_columns(one))
            name_partials(self.tree.names, one, rows)
        name_determinant(self.tree.names, block[0], W_d)
        return rows

    def _dependent_accelerations(self, block: list[LoopPlan], gam_x: Mapping[int, Scalar]) -> dict[int, Scalar]:
        """gam of the variables of a block of loops: -W_d^-1 phi (L11)."""
        unknown = self.unknown(block)
        rates = {j: product(row, self.tree.qd) for j, row in self.S.items()}
        known = {j: self._gam(j, gam_x) for j in self.machine.articulated}
        phi: list[Scalar] = []
        for one in block:
            relative = closing_acceleration(
                loop_branches(self.tree, one.loop, one.view, one.pivot), rates, known
            ).entries
            phi += [relative[row] for row in one.rows]
        (found,) = solve(self._W_d(block), [[-x for x in phi]])
        gam = dict(zip(unknown, found, strict=True))
        name_accelerations(self.tree.names, block, phi, gam)
        return gam

    def unknown(self, block: Sequence[LoopPlan]) -> list[int]:
        """Dependent joints of a block of loops."""
        return sorted({j for one in block for j in one.dependent})

    def errors_of(self, block: Iterable[LoopPlan]) -> list[Scalar]:
        """How far the loops of a block are from being closed, in the rows kept (L18)."""
        return [closing_error(loop_branches(self.tree, one.loop)).entries[row] for one in block for row in one.kept]

    def columns_of(self, block: list[LoopPlan]) -> list[list[Scalar]]:
        """Columns of W_d of a block of loops, in axes of the frames met (L10)."""
        seen_from_m = [replace(one, view=None, pivot=None) for one in block]
        return self._W_d(seen_from_m)

    def partial(self, j: int, v: int) -> Scalar:
        """dq_j/dx_v of joint j by the coordinate of joint v (L1)."""
        own = int(j == v)
        return own + self.couplings[j].partials.get(v, 0) if j in self.couplings else own

    def _W_d(self, block: list[LoopPlan]) -> list[list[Scalar]]:
        """Columns of W by the dependent variables of a block."""
        unknown = self.unknown(block)
        rows = self._rows(block, {v: {v: 1} for v in unknown})
        return [[row.get(d, 0) for row in rows] for d in unknown]

    def _W_u(self, block: list[LoopPlan], S_x: Mapping[int, Row]) -> list[dict[int, Scalar]]:
        """Rows of W_u over the independent variables."""
        unknown = self.unknown(block)
        return self._rows(block, {v: row for v, row in S_x.items() if v not in unknown})

    def _rows(self, block: Iterable[LoopPlan], S_x: Mapping[int, Row]) -> list[dict[int, Scalar]]:
        """Rows of W times S, where only these joint coordinates move (L10)."""
        return [
            combination((column.entries[i], self.tree.row(j, S_x)) for j, column in self._closing_columns(one).items())
            for one in block
            for i in one.rows
        ]

    def _closing_columns(self, one: LoopPlan) -> dict[int, Twist]:
        key = one.loop.name, one.view
        if key not in self._columns:
            self._columns[key] = closing_columns(loop_branches(self.tree, one.loop, one.view, one.pivot))
        return self._columns[key]
