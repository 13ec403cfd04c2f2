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

from symoro_elastic.foundation.scalar import Scalar, quotient
from symoro_elastic.mechanics.coordinates import Row, combination, product
from symoro_elastic.mechanics.loops.closing import closing_acceleration, closing_columns, closing_error
from symoro_elastic.mechanics.loops.linear import BY_COFACTORS, determinant, solve
from symoro_elastic.mechanics.loops.planar import Closed, Complex
from symoro_elastic.mechanics.spatial import AxialTransform, Twist
from symoro_elastic.models.loops.assembly import loop_branches
from symoro_elastic.models.loops.plan import Form, LoopPlan
from symoro_elastic.models.tree.tree import Tree
from symoro_elastic.symbolic.differentiation import Differentiation
from symoro_elastic.symbolic.expression import Expression
from symoro_elastic.symbolic.program import Names, Section

AXES = "xyz"
EQUATIONS = {
    Form.TRIANGLE: "(L12)",
    Form.SLIDE: "(L16), (L17)",
    Form.SLIDES: "(L9)",
    Form.ONE: "(L9)",
    Form.INVERSE: "(L9)",
}


class Coordinates:
    """S = dq/du, gam and the same of joint coordinates, of a machine bound to the equations."""

    def __init__(self, tree: Tree, loops: Iterable[LoopPlan] = ()) -> None:
        self.tree, self.machine = tree, tree.machine
        self.loops = tuple(loop for loop in loops if loop.dependent)
        self._columns: dict[tuple[str, int | None], dict[int, Twist]] = {}
        self.couplings = tree.couplings

    @cached_property
    def S_x(self) -> dict[int, Row]:
        """Rows of dx/du by the joints that own variables."""
        S_x: dict[int, Row] = {j: {j: 1} for j in self.machine.independent}
        for j, x in self.tree.variables.items():
            if isinstance(x, Expression) and j in self._mapped_joints:
                tangents = Differentiation([x])
                entries = ((k, tangents.by(q).of(x)) for k, q in self.tree.q.items())
                S_x[j] = combination((entry, {k: 1}) for k, entry in entries)
        for block in self.blocks:
            S_x |= self._dependent_rows(block, S_x)
        return S_x

    @cached_property
    def S(self) -> dict[int, Row]:
        """dq/du: rows by the joints of the tree (L1)."""
        return {j: self.tree.row(j, self.S_x) for j in self.machine.articulated}

    @cached_property
    def rates_x(self) -> dict[int, Scalar]:
        """Time derivatives of all joint coordinates."""
        rates = {j: product(row, self.tree.qd) for j, row in self.S_x.items()}
        for loop in (loop for block in self.blocks for loop in block):
            for j in loop.dependent:
                self.tree.names.give(rates[j], f"rate{j}_x", _rates(loop))
        return rates

    @cached_property
    def gam_x(self) -> dict[int, Scalar]:
        """Second time derivatives of joint coordinates at zero acceleration of the independent variables."""
        gam: dict[int, Scalar] = dict.fromkeys((*self.machine.independent, *self._mapped_joints), 0)
        for block in self.blocks:
            gam |= self._dependent_accelerations(block, gam)
        return gam

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
    def _mapped_joints(self) -> tuple[int, ...]:
        """Dependent joints of parallelograms."""
        return tuple(j for loop in self.loops if loop.form is Form.MAP for j in loop.dependent)

    @cached_property
    def blocks_with_maps(self) -> list[list[LoopPlan]]:
        """Blocks of all loops in the order in which they are closed; loops that share dependent joints are in one."""
        return self._blocks_of(self.loops)

    @cached_property
    def blocks(self) -> list[list[LoopPlan]]:
        """Blocks of all loops except parallelograms, in the order in which they are closed."""
        return self._blocks_of(loop for loop in self.loops if loop.form is not Form.MAP)

    @property
    def assembled_blocks(self) -> list[list[LoopPlan]]:
        """Blocks whose dependent variables are arguments of the models."""
        return [block for block in self.blocks if any(loop.is_assembled for loop in block)]

    def _blocks_of(self, loops: Iterable[LoopPlan]) -> list[list[LoopPlan]]:
        """Blocks of loops: loops are merged where an earlier one depends on joints that a later one determines."""
        blocks = [[loop] for loop in loops]
        while pair := next((pair for pair in combinations(blocks, 2) if self._needs(*pair)), None):
            first, later = pair
            blocks = [[*first, *later] if block is later else block for block in blocks if block is not first]
        return blocks

    def _needs(self, first: Iterable[LoopPlan], later: Sequence[LoopPlan]) -> bool:
        needed = {j for loop in first for j in (*loop.dependent, *self.machine.with_variable_in(loop.loop))}
        return any(not needed.isdisjoint(loop.dependent) for loop in later)

    def _dependent_rows(self, block: list[LoopPlan], S_x: Mapping[int, Row]) -> dict[int, Row]:
        """Rows of dx/du of a block of loops: -W_d^-1 W_u S (L10)."""
        unknown = self.unknown(block)
        right = self._rows(block, {v: row for v, row in S_x.items() if v not in unknown})  # W_u over the independent
        k = sorted({k for row in right for k in row})
        W_d = self._W_d(block)
        columns = solve(W_d, [[-row.get(i, 0) for row in right] for i in k])
        rows: dict[int, Row] = {
            d: combination((column[m], {i: 1}) for i, column in zip(k, columns, strict=True))
            for m, d in enumerate(unknown)
        }
        for loop in block:
            name_equations(self.tree.names, loop, self._closing_columns(loop))
            name_partials(self.tree.names, loop, rows)
        if len(W_d) <= BY_COFACTORS:
            self.tree.names.give(quotient(1, determinant(W_d)), f"W{block[0].loop.cut}_inverse", _rates(block[0]))
        return rows

    def _dependent_accelerations(self, block: list[LoopPlan], gam_x: Mapping[int, Scalar]) -> dict[int, Scalar]:
        """gam of the variables of a block of loops: -W_d^-1 phi (L11)."""
        unknown = self.unknown(block)
        rates = {j: product(row, self.tree.qd) for j, row in self.S.items()}
        gam_of_joints = {j: self._gam(j, gam_x) for j in self.machine.articulated}
        phi: list[Scalar] = []
        for loop in block:
            relative = closing_acceleration(
                loop_branches(self.tree, loop.loop, loop.view, loop.pivot), rates, gam_of_joints
            ).entries
            phi += [relative[row] for row in loop.rows]
        (accelerations,) = solve(self._W_d(block), [[-x for x in phi]])
        gam_dependent = dict(zip(unknown, accelerations, strict=True))
        name_accelerations(self.tree.names, block, phi, gam_dependent)
        return gam_dependent

    def unknown(self, block: Sequence[LoopPlan]) -> list[int]:
        """Dependent joints of a block of loops."""
        return sorted({j for loop in block for j in loop.dependent})

    def errors_of(self, block: Iterable[LoopPlan]) -> list[Scalar]:
        """Closing errors of the loops of a block, in the selected rows (L18)."""
        return [closing_error(loop_branches(self.tree, loop.loop)).entries[row] for loop in block for row in loop.kept]

    def columns_of(self, block: list[LoopPlan]) -> list[list[Scalar]]:
        """Columns of W_d of a block of loops, in axes of the frames met (L10)."""
        seen_from_m = [replace(loop, view=None, pivot=None) for loop in block]
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

    def _rows(self, block: Iterable[LoopPlan], S_x: Mapping[int, Row]) -> list[dict[int, Scalar]]:
        """Rows of W times S, where only these joint coordinates move (L10)."""
        return [
            combination((column.entries[i], self.tree.row(j, S_x)) for j, column in self._closing_columns(loop).items())
            for loop in block
            for i in loop.rows
        ]

    def _closing_columns(self, loop: LoopPlan) -> dict[int, Twist]:
        key = loop.loop.name, loop.view
        if key not in self._columns:
            self._columns[key] = closing_columns(loop_branches(self.tree, loop.loop, loop.view, loop.pivot))
        return self._columns[key]


def reserve_sections(names: Names, loops: Iterable[LoopPlan]) -> None:
    """Reserve sections for positions and rates of loops before all others, in the order in which loops close."""
    for loop in loops:
        names.reserve(_positions(loop))
        names.reserve(_rates(loop))


def _positions(loop: LoopPlan) -> Section:
    return Section("Closed loop: positions", loop.loop.cut, EQUATIONS.get(loop.form, "(L9)"))


def _rates(loop: LoopPlan) -> Section:
    return Section("Closed loop: rates", loop.loop.cut, "(L10), (L11)")


def name_positions(names: Names, loop: LoopPlan, closed: Closed) -> None:
    """Name sides and roots of a closed form by the joint they belong to, the cut joint for 0."""
    here = _positions(loop)
    for j, side in closed.sides.items():
        number = j or loop.loop.cut
        for axis, x in zip(AXES, side, strict=False):
            names.give(x, f"side{number}_{axis}", here)
        if isinstance(side, Complex):
            names.give(side.square, f"side{number}_squared", here)
    for j, root in closed.roots.items():
        names.give(root, f"root{j or loop.loop.cut}_loop", here)


def name_turns(names: Names, loop: LoopPlan, turns: Mapping[int, AxialTransform]) -> None:
    """Name cosines and sines of dependent joints."""
    if loop.form is Form.MAP or loop.is_assembled:
        return
    for j, step in turns.items():
        names.give(step.cosine, f"cos{j}_theta", _positions(loop))
        names.give(step.sine, f"sin{j}_theta", _positions(loop))


def name_equations(names: Names, loop: LoopPlan, columns: Mapping[int, Twist]) -> None:
    """Name the entries of W, columns by joint (L10)."""
    for j, column in columns.items():
        for row in loop.rows:
            names.give(column.entries[row], f"W{loop.loop.cut}_{row + 1}_{j}", _rates(loop))


def name_partials(names: Names, loop: LoopPlan, rows: Mapping[int, Row]) -> None:
    """Name the entries of dx/du of dependent joints (L10)."""
    for j in loop.dependent:
        for k, x in rows[j].items():
            names.give(x, f"S{j}_{k}", _rates(loop))


def name_accelerations(
    names: Names, block: Sequence[LoopPlan], phi: Iterable[Scalar], gam: Mapping[int, Scalar]
) -> None:
    """Name phi, and the accelerations of dependent joints where independent ones have none (L11)."""
    entries = ((loop, row) for loop in block for row in loop.rows)
    for (loop, row), x in zip(entries, phi, strict=True):
        names.give(x, f"phi{loop.loop.cut}_{row + 1}", _rates(loop))
    for loop in block:
        for j in loop.dependent:
            names.give(gam[j], f"gam{j}_x", _rates(loop))


def name_newton_step(names: Names, step: int, values: Mapping[int, Scalar]) -> None:
    """Name dependent variables after a step of Newton's method."""
    for j, x in values.items():
        names.give(x, f"newton{j}_{step}", Section(f"Newton's method (L18), step {step}"))
