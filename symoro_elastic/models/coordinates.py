"""The joints of a machine as functions of its independent variables u: own variables x, S = dq/du and gam.

The cell of a joint is its own variable, or that and a formula of other joints' variables, or a formula only. Variables
that loops give come from closed forms where there are any, else they are arguments; their rates come from the loops'
equations, but for parallelograms, whose angles are sums of angles.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from itertools import combinations
from typing import TYPE_CHECKING

from symoro_elastic.machine.formula import Formula
from symoro_elastic.mechanics.coordinates import Row, combination, product
from symoro_elastic.mechanics.loops.closing import closing_acceleration, closing_columns, closing_error
from symoro_elastic.mechanics.loops.linear import solved
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
from symoro_elastic.scalar import Scalar
from symoro_elastic.symbolic.differentiation import Differentiation, substituted
from symoro_elastic.symbolic.expression import Expression

if TYPE_CHECKING:
    from symoro_elastic.models.bind import Bound


class Coupling:
    """A formula of own variables: its value, and its derivatives by them."""

    def __init__(self, bound: Bound, formula: Formula) -> None:
        self._bound = bound
        variables = bound.machine.variables
        self.by = {variables[name]: bound.graph.symbol(name) for name in sorted(formula.names & variables.keys())}
        self._formal = bound.cell(
            formula, bound.named({name: bound.graph.symbol(name) for name in formula.names & variables.keys()})
        )

    @property
    def value(self) -> Scalar:
        """The formula at the values of the variables."""
        return self._at(self._formal)

    @cached_property
    def partials(self) -> dict[int, Scalar]:
        """Derivatives by own variables, by number of the joint."""
        return {v: self._at(x) for v, x in self._formal_partials.items()}

    def second(self, rates: Mapping[int, Scalar]) -> Scalar:
        """Sum of second derivatives times rates: the second derivative by time at constant rates (L4)."""
        total: Scalar = 0
        found = Differentiation(self._formal_partials.values())
        for w, symbol in self.by.items():
            tangents = found.by(symbol)
            for v, x in self._formal_partials.items():
                total = total + self._at(tangents.of(x)) * (rates[v] * rates[w])
        return total

    @cached_property
    def _formal_partials(self) -> dict[int, Scalar]:
        found = Differentiation([self._formal])
        return {v: found.by(symbol).of(self._formal) for v, symbol in self.by.items()}

    def _at(self, x: Scalar) -> Scalar:
        """An expression over the variables' own symbols at their values."""
        values = {self.by[v].operands[0]: self._bound.variables[v] for v in self.by}
        changed = {name: value for name, value in values.items() if value is not self._bound.graph.symbol(name)}
        return substituted(self._bound.graph, [x], changed)[0] if changed and isinstance(x, Expression) else x


class Coordinates:
    """S = dq/du, gam and the same of own variables, of a machine bound to the equations."""

    def __init__(self, bound: Bound, loops: Iterable[LoopPlan] = ()) -> None:
        self.bound, self.machine = bound, bound.machine
        self.loops = tuple(one for one in loops if one.dependent)
        self._columns: dict[tuple[str, int | None], dict[int, Twist]] = {}
        self.couplings = {
            j: Coupling(bound, joint.selected)
            for j in self.machine.articulated
            if not (joint := self.machine.joint(j)).selected.names.isdisjoint(self.machine.variables)
        }

    @cached_property
    def S_x(self) -> dict[int, Row]:
        """dx/du: rows by the joints that own variables."""
        found: dict[int, Row] = {j: {j: 1} for j in self.machine.moving}
        for j, x in self.bound.variables.items():
            if isinstance(x, Expression) and j in self._mapped:
                tangents = Differentiation([x])
                rows = ((k, tangents.by(q).of(x)) for k, q in self.bound.q.items())
                found[j] = combination((entry, {k: 1}) for k, entry in rows)
        for block in self.blocks:
            found |= self._dependent_rows(block, found)
        return found

    @cached_property
    def S(self) -> dict[int, Row]:
        """dq/du: rows by the joints of the tree (L1)."""
        return {j: self._row(j, self.S_x) for j in self.machine.articulated}

    def _row(self, j: int, S_x: Mapping[int, Row]) -> Row:
        own = [(1, S_x[j])] if j in S_x else []
        if j not in self.couplings:
            return own[0][1] if own else {}
        followed = ((x, S_x[v]) for v, x in self.couplings[j].partials.items() if v in S_x)
        return combination([*own, *followed])

    @cached_property
    def rates_x(self) -> dict[int, Scalar]:
        """Rates of own variables."""
        rates = {j: product(row, self.bound.qd) for j, row in self.S_x.items()}
        for one in (one for block in self.blocks for one in block):
            name_rates(self.bound.names, one, rates)
        return rates

    @cached_property
    def gam_x(self) -> dict[int, Scalar]:
        """Second derivatives of own variables where those of the independent ones are zero."""
        found: dict[int, Scalar] = dict.fromkeys((*self.machine.moving, *self._mapped), 0)
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
        return any(not given.isdisjoint((*one.dependent, *self.machine.owners_in(one.loop))) for one in first)

    def _dependent_rows(self, block: list[LoopPlan], S_x: Mapping[int, Row]) -> dict[int, Row]:
        """Rows of dx/du of a block of loops: -W_d^-1 W_u S (L10)."""
        unknown, known = self.unknown(block), self._W_u(block, S_x)
        k = sorted({k for row in known for k in row})
        W_d = self._W_d(block)
        columns = solved(W_d, [[-row.get(i, 0) for row in known] for i in k])
        rows: dict[int, Row] = {
            d: combination((column[m], {i: 1}) for i, column in zip(k, columns, strict=True))
            for m, d in enumerate(unknown)
        }
        for one in block:
            name_equations(self.bound.names, one, self._closing_columns(one))
            name_partials(self.bound.names, one, rows)
        name_determinant(self.bound.names, block[0], W_d)
        return rows

    def _dependent_accelerations(self, block: list[LoopPlan], gam_x: Mapping[int, Scalar]) -> dict[int, Scalar]:
        """gam of the variables of a block of loops: -W_d^-1 phi (L11)."""
        unknown = self.unknown(block)
        rates = {j: product(row, self.bound.qd) for j, row in self.S.items()}
        known = {j: self._gam(j, gam_x) for j in self.machine.articulated}
        phi: list[Scalar] = []
        for one in block:
            relative = closing_acceleration(
                loop_branches(self.bound, one.loop, one.view, one.pivot), rates, known
            ).entries
            phi += [relative[row] for row in one.rows]
        (found,) = solved(self._W_d(block), [[-x for x in phi]])
        gam = dict(zip(unknown, found, strict=True))
        name_accelerations(self.bound.names, block, phi, gam)
        return gam

    def unknown(self, block: Sequence[LoopPlan]) -> list[int]:
        """Dependent joints of a block of loops."""
        return sorted({j for one in block for j in one.dependent})

    def errors_of(self, block: Iterable[LoopPlan]) -> list[Scalar]:
        """How far the loops of a block are from being closed, in the rows kept (L18)."""
        return [closing_error(loop_branches(self.bound, one.loop)).entries[row] for one in block for row in one.kept]

    def columns_of(self, block: list[LoopPlan]) -> list[list[Scalar]]:
        """Columns of W_d of a block of loops, in axes of the frames met (L10)."""
        seen_from_m = [replace(one, view=None, pivot=None) for one in block]
        return self._W_d(seen_from_m)

    def partial(self, j: int, v: int) -> Scalar:
        """dq_j/dx_v of joint j by the own variable of joint v (L1)."""
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
        """Rows of W times S, where only these own variables move (L10)."""
        return [
            combination((column.entries[i], self._row(j, S_x)) for j, column in self._closing_columns(one).items())
            for one in block
            for i in one.rows
        ]

    def _closing_columns(self, one: LoopPlan) -> dict[int, Twist]:
        key = one.loop.name, one.view
        if key not in self._columns:
            self._columns[key] = closing_columns(loop_branches(self.bound, one.loop, one.view, one.pivot))
        return self._columns[key]
