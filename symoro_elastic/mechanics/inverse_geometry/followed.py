"""Joints of a chain that follow independent variables: x = S u with constant S, and back.

x are positions of joints against those at u = 0. Where the joints are more than the variables, some of them give u, and
the others must stand where u puts them.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from fractions import Fraction
from itertools import combinations
from typing import NamedTuple

from symoro_elastic.foundation.scalar import quotient
from symoro_elastic.mechanics.coordinates import Row, Rows, combination, product
from symoro_elastic.mechanics.spatial import Scalar

IsZero = Callable[[Scalar], bool]


class Followed(NamedTuple):
    """Rows that give the variables u from joint positions x, and the positions of redundant joints from the others."""

    variables: Rows
    followers: Rows

    def values(self, x: Mapping[int, Scalar]) -> dict[int, Scalar]:
        """Values of the independent variables u, by number, at joint positions x = S u."""
        return {v: product(row, x) for v, row in self.variables.items()}


def angles_of_followers(is_zero: IsZero, S: Rows, slides: Collection[int]) -> Followed | None:
    """Solve x = S u for u, S of full column rank; None where u is ambiguous by whole turns of joints.

    An angle is known but for whole turns, so what follows it must turn a whole number of times as far; `slides` are
    joints that are not angles.
    """
    exact = {j: _without_zeros(is_zero, row) for j, row in S.items()}
    size = len({v for row in exact.values() for v in row})
    for joints in combinations(exact, size):
        variables = inverse(is_zero, {j: exact[j] for j in joints})
        followers_of = (j for j in exact if j not in joints)
        followers = {j: combination((x, variables[v]) for v, x in exact[j].items()) for j in followers_of if variables}
        if variables and all(j in slides or _is_whole(x) for row in followers.values() for j, x in row.items()):
            return Followed(variables, followers)
    return None


def inverse(is_zero: IsZero, S: Rows) -> dict[int, Row]:
    """Rows of the inverse of a square S, by its columns; none where it is singular.

    The shortest row is eliminated first: a gear is one quotient, a coupled wrist is followed from its first joint.
    """
    remaining: dict[int, tuple[Row, Row]] = {j: (row, {j: 1}) for j, row in S.items()}
    steps: list[tuple[int, Row, Row]] = []
    while remaining:
        row, x = remaining.pop(min(remaining, key=lambda j: len(remaining[j][0])))
        if not row:
            return {}
        v = min(row)
        unit = quotient(1, row[v])
        after, right = combination([(unit, _without(v, row))]), combination([(unit, x)])
        steps.append((v, after, right))
        for j, (other, side) in remaining.items():
            factor = -other.get(v, 0)
            reduced = combination([(1, _without(v, other)), (factor, after)])
            remaining[j] = _without_zeros(is_zero, reduced), combination([(1, side), (factor, right)])
    variables: dict[int, Row] = {}
    for v, row, x in reversed(steps):
        variables[v] = combination([(1, x), *((-entry, variables[k]) for k, entry in row.items())])
    return {v: variables[v] for v in sorted(variables)}


def _without(v: int, row: Row) -> Row:
    return {k: x for k, x in row.items() if k != v}


def _without_zeros(is_zero: IsZero, row: Row) -> Row:
    return {k: x for k, x in row.items() if not is_zero(x)}


def _is_whole(x: Scalar) -> bool:
    return isinstance(x, int | Fraction) and x.denominator == 1
