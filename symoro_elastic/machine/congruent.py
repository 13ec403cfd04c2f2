"""Congruent limbs of a machine: branches on one body with equal joints, springs and zeros; numbers and signs differ."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import groupby
from typing import TypeAlias

from symoro_elastic.machine.arguments import entries_by_joint
from symoro_elastic.machine.columns import Dimension, cells
from symoro_elastic.machine.formula import Formula, Tree
from symoro_elastic.machine.joints import Joint
from symoro_elastic.machine.machine import Machine

GROUPS = (4, 2)
"""Numbers of limbs that are grouped: six are four and two."""
ANGLE_DECIMALS = 12
"""Of angles that are compared, rad: beyond, quarter turns as decimal numbers differ."""
Limbs: TypeAlias = tuple[tuple[int, ...], ...]
"""Numbers of congruent joints: a tuple for each joint of a limb, with an entry for each limb."""


def congruent_joints(machine: Machine) -> Limbs:
    """Return the joints of congruent limbs, by number, the largest limbs where some are within others.

    Limbs are trees with joints that move; what loops add to them is not compared.
    """
    carried: dict[int, list[int]] = {}
    for j, joint in enumerate(machine.joints, start=1):
        carried.setdefault(joint.antecedent, []).append(j)
    kinds = _kinds(machine, carried)
    groups: list[tuple[int, ...]] = []
    bodies = [0]
    for body in bodies:
        branches = sorted(carried.get(body, ()), key=lambda j: (kinds[j], j))
        for _, group in groupby(branches, key=kinds.__getitem__):
            limbs = [*group]
            for size in GROUPS:
                while len(limbs) >= size:
                    rows = [*_corresponding(limbs[:size], carried, kinds)]
                    groups += rows if any(joints[0] in machine.articulated for joints in rows) else []
                    del limbs[:size]
            bodies += limbs
    return tuple(groups)


def congruent_symbols(machine: Machine, limbs: Limbs) -> tuple[tuple[str, ...], ...]:
    """Return the names of arguments and parameters that congruent joints have in the place of each other."""
    cycles = [names for joints in limbs for names in _names(machine, joints)]
    used: set[str] = set()
    result = []
    for names in cycles:
        if len({*names}) == len(names) and used.isdisjoint(names):
            used |= {*names}
            result.append(names)
    return tuple(result)


def _names(machine: Machine, joints: tuple[int, ...]) -> Iterator[tuple[str, ...]]:
    for entries in entries_by_joint(machine).values():
        if entries.keys() >= {*joints}:
            yield from zip(*(entries[j] for j in joints), strict=True)
    for formulas in zip(*(cells(machine.joint(j)) for j in joints), strict=True):
        yield from zip(*(_names_in(formula.tree) for _, formula in formulas), strict=True)


def _kinds(machine: Machine, carried: Mapping[int, Sequence[int]]) -> dict[int, int]:
    """A number for each joint, equal where it and all that it carries are congruent."""
    numbers: dict[object, int] = {}
    kinds: dict[int, int] = {}
    for j in range(len(machine.joints), 0, -1):
        key = _pattern(machine.joint(j)), tuple(sorted(kinds[k] for k in carried.get(j, ())))
        kinds[j] = numbers.setdefault(key, len(numbers))
    return kinds


def _corresponding(
    limbs: Sequence[int], carried: Mapping[int, Sequence[int]], kinds: Mapping[int, int]
) -> Iterator[tuple[int, ...]]:
    """The joints of limbs that begin with these, each with those in its place in the other limbs."""
    rows = [tuple(limbs)]
    for row in rows:
        yield row
        rows += zip(*(sorted(carried.get(j, ()), key=lambda k: (kinds[k], k)) for j in row), strict=True)


def _pattern(joint: Joint) -> tuple[object, ...]:
    """What congruent joints have in common: kind, angles aside from their signs, zeros and names in all cells."""
    values = (
        round(abs(formula.value()), ANGLE_DECIMALS)
        if cell.column.dimension is Dimension.ANGLE and not formula.names
        else _form(formula)
        for cell, formula in cells(joint)
    )
    return (joint.sigma, joint.kind, joint.variable is None, joint.body.central, *values)


def _form(formula: Formula) -> object:
    """A formula without its numbers, names and sign; 0 where it is zero."""
    return 0 if formula.is_zero else _without_values(formula.tree[1] if formula.tree[0] == "neg" else formula.tree)


def _without_values(tree: Tree) -> object:
    parts = [_without_values(part) if isinstance(part, tuple) else part for part in tree[1:]]
    return tree[0] if tree[0] in ("number", "name") else (tree[0], *parts)


def _names_in(tree: Tree) -> list[str]:
    """The names in a tree, in order."""
    if tree[0] == "name":
        return [tree[1]]
    return [name for part in tree[1:] if isinstance(part, tuple) for name in _names_in(part)]
