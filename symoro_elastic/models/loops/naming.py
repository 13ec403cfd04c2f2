"""Names of what closes loops, and the sections of a program it belongs to."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from symoro_elastic.foundation.scalar import Scalar, quotient
from symoro_elastic.mechanics.coordinates import Row
from symoro_elastic.mechanics.loops.linear import BY_COFACTORS, Column, determinant
from symoro_elastic.mechanics.loops.planar import Closed, Complex
from symoro_elastic.mechanics.spatial import AxialTransform, Twist
from symoro_elastic.models.loops.plan import Form, LoopPlan
from symoro_elastic.symbolic.program import Names, Section

AXES = "xyz"
EQUATIONS = {
    Form.TRIANGLE: "(L12)",
    Form.SLIDE: "(L16), (L17)",
    Form.SLIDES: "(L9)",
    Form.ONE: "(L9)",
    Form.INVERSE: "(L9)",
}


def reserve_sections(names: Names, loops: Iterable[LoopPlan]) -> None:
    """Put positions and rates of each loop before all else, in the order in which loops are closed."""
    for one in loops:
        names.reserve(_positions(one))
        names.reserve(_rates(one))


def _positions(one: LoopPlan) -> Section:
    return Section("Closed loop: positions", one.loop.cut, EQUATIONS.get(one.form, "(L9)"))


def _rates(one: LoopPlan) -> Section:
    return Section("Closed loop: rates", one.loop.cut, "(L10), (L11)")


def name_positions(names: Names, one: LoopPlan, closed: Closed) -> None:
    """Name sides and roots of a closed form by the joint they belong to, the cut joint for 0."""
    here = _positions(one)
    for j, side in closed.sides.items():
        number = j or one.loop.cut
        for axis, x in zip(AXES, side, strict=False):
            names.give(x, f"side{number}_{axis}", here)
        if isinstance(side, Complex):
            names.give(side.square, f"side{number}_squared", here)
    for j, root in closed.roots.items():
        names.give(root, f"root{j or one.loop.cut}_loop", here)


def name_turns(names: Names, one: LoopPlan, turns: Mapping[int, AxialTransform]) -> None:
    """Name cosines and sines of dependent joints."""
    if one.form is Form.MAP or one.is_assembled:
        return
    for j, step in turns.items():
        names.give(step.cosine, f"cos{j}_theta", _positions(one))
        names.give(step.sine, f"sin{j}_theta", _positions(one))


def name_equations(names: Names, one: LoopPlan, columns: Mapping[int, Twist]) -> None:
    """Name the entries of W, columns by joint (L10)."""
    for j, column in columns.items():
        for row in one.rows:
            names.give(column.entries[row], f"W{one.loop.cut}_{row + 1}_{j}", _rates(one))


def name_determinant(names: Names, one: LoopPlan, W_d: Sequence[Column]) -> None:
    """Name 1 / det W_d of a block of loops by its first one, where it is what solves them."""
    if len(W_d) <= BY_COFACTORS:
        names.give(quotient(1, determinant(W_d)), f"W{one.loop.cut}_inverse", _rates(one))


def name_partials(names: Names, one: LoopPlan, rows: Mapping[int, Row]) -> None:
    """Name the entries of dx/du of dependent joints (L10)."""
    for j in one.dependent:
        for k, x in rows[j].items():
            names.give(x, f"S{j}_{k}", _rates(one))


def name_rates(names: Names, one: LoopPlan, rates: Mapping[int, Scalar]) -> None:
    """Name the rates of dependent joints."""
    for j in one.dependent:
        names.give(rates[j], f"rate{j}_x", _rates(one))


def name_accelerations(
    names: Names, block: Sequence[LoopPlan], phi: Iterable[Scalar], gam: Mapping[int, Scalar]
) -> None:
    """Name phi, and the accelerations of dependent joints where independent ones have none (L11)."""
    entries = ((one, row) for one in block for row in one.rows)
    for (one, row), x in zip(entries, phi, strict=True):
        names.give(x, f"phi{one.loop.cut}_{row + 1}", _rates(one))
    for one in block:
        for j in one.dependent:
            names.give(gam[j], f"gam{j}_x", _rates(one))


def name_newton_step(names: Names, step: int, found: Mapping[int, Scalar]) -> None:
    """Name dependent variables after a step of Newton's method."""
    for j, x in found.items():
        names.give(x, f"newton{j}_{step}", Section(f"Newton's method (L18), step {step}"))
