"""Links in parallel: their axes differ by quarter turns about z at every position.

The bodies at opposite sides of a parallelogram are such links: they have the same angular motion.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any

from symoro_elastic.foundation.scalar import Scalar
from symoro_elastic.mechanics.mechanism import Mechanism, Parallel
from symoro_elastic.mechanics.spatial import AxialTransform, Axis, Z, is_zero
from symoro_elastic.models.tree.tree import Tree
from symoro_elastic.symbolic.functions import QUARTERS, turns_of


@dataclass(frozen=True)
class Orientation:
    """Directions of z that lead to a link, and its angle about the last: terms that vary, and half turns."""

    along: Any
    terms: frozenset[Any]
    halves: Fraction


BASE = Orientation((), frozenset(), Fraction(0))


def with_parallel_links(tree: Tree, mechanism: Mechanism) -> Mechanism:
    """The mechanism with a parallel link of smaller number for links on revolute joints that have one."""
    oriented: list[Orientation | None] = [BASE]
    links = list(mechanism.links)
    for j in range(1, len(tree.machine.joints) + 1):
        oriented.append(here := _orientation(tree, j, oriented))
        if here is None or links[j - 1].axis is not Axis.REVOLUTE:
            continue
        for i, other in enumerate(oriented[1:j], start=1):
            if other is None or (other.along, other.terms) != (here.along, here.terms):
                continue
            quarters = (here.halves - other.halves) * 2
            if quarters.denominator == 1 and links[i - 1].axis is Axis.REVOLUTE:
                turn = AxialTransform(Z, *QUARTERS[int(quarters) % 4], 0)
                links[j - 1] = replace(links[j - 1], parallel=Parallel(i, turn))
                break
    return replace(mechanism, links=tuple(links))


def _orientation(tree: Tree, j: int, oriented: list[Orientation | None]) -> Orientation | None:
    """Orientation of a link; None where an angle is not a sum of variables and quarter turns."""
    joint = tree.machine.joint(j)
    before = oriented[joint.antecedent]
    gamma, alpha = _turn(tree.cell(joint.gamma)), _turn(tree.cell(joint.alpha))
    has_closed_form = j in tree.placed
    theta = (frozenset([(("joint", j), Fraction(1))]), Fraction(0)) if has_closed_form else _turn(_angle(tree, j))
    if before is None or gamma is None or alpha is None or theta is None:
        return None
    here = _sum_of_turns((before.terms, before.halves), gamma)
    if not alpha[0] and alpha[1] % 2 == 0:
        return Orientation(before.along, *_sum_of_turns(here, theta))
    return Orientation((before.along, here, alpha), *theta)


def _angle(tree: Tree, j: int) -> Scalar:
    joint = tree.machine.joint(j)
    turns = joint.sigma == 0 and j in tree.machine.articulated
    return tree.angle(j) if turns else tree.cell(joint.theta)


Turn = tuple[frozenset[Any], Fraction]


def _turn(angle: Scalar) -> Turn | None:
    if is_zero(angle):
        return frozenset(), Fraction(0)
    sum_of_turns = turns_of(angle)
    return None if sum_of_turns is None else (frozenset(sum_of_turns[0].items()), sum_of_turns[1])


def _sum_of_turns(first: Turn, second: Turn) -> Turn:
    terms: dict[Any, Fraction] = dict(first[0])
    for term, factor in second[0]:
        terms[term] = terms.get(term, Fraction(0)) + factor
    return frozenset((term, factor) for term, factor in terms.items() if factor), first[1] + second[1]
