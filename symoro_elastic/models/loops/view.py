"""Axes in which the equations of a loop are shortest."""

from __future__ import annotations

from collections.abc import Collection
from typing import TYPE_CHECKING

from symoro_elastic.machine.loops import Loop, branches
from symoro_elastic.mechanics.loops.closing import POINT, closing_columns
from symoro_elastic.mechanics.loops.linear import solved
from symoro_elastic.mechanics.spatial import Axis, is_zero
from symoro_elastic.models.loops.assembly import loop_branches
from symoro_elastic.symbolic.expression import Level, reachable
from symoro_elastic.symbolic.program import count

if TYPE_CHECKING:
    from symoro_elastic.models.bind import Bound


def view_of_triangle(bound: Bound, loop: Loop, dependent: Collection[int]) -> tuple[int | None, int | None]:
    """The link in whose axes the equations of a triangle are shortest, and the turn that it carries.

    It is a dependent turn of m's branch whose antecedent has the same normal.
    """
    _, to_end = branches(bound.machine.antecedents, loop)
    for j in to_end:
        link = bound.mechanism.link(j)
        if j in dependent and link.axis is Axis.REVOLUTE and is_zero(link.transform.steps[1].sine):
            return link.antecedent, j
    return None, None


def view_of_point(bound: Bound, loop: Loop, dependent: Collection[int]) -> int | None:
    """The link of a loop in whose axes the rates of three dependent joints take the fewest operations.

    Equations of a cut ball say the same in any axes. None stands for those of the frame met.
    """
    views = [None, *(j for branch in branches(bound.machine.antecedents, loop) for j in branch)]
    return min(views, key=lambda view: _operations(bound, loop, dependent, view))


def _operations(bound: Bound, loop: Loop, dependent: Collection[int], view: int | None) -> int:
    """Of -W_d^-1 W over the other joints of the loop that move."""
    columns = {j: [V.entries[i] for i in POINT] for j, V in closing_columns(loop_branches(bound, loop, view)).items()}
    moving = [j for j in columns if j not in dependent and bound.mechanism.link(j).axis is not Axis.NONE]
    rates = solved([columns[j] for j in dependent], [columns[j] for j in moving])
    found = count(reachable(x for column in rates for x in column), Level.STATE)
    return found.products + found.add
