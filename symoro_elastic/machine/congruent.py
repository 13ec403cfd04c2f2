"""Congruent limbs of a machine: branches on one body with equal joints, springs and zeros; numbers and signs differ."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from itertools import groupby
from typing import TypeAlias

from symoro_elastic.machine.arguments import entries_by_joint
from symoro_elastic.machine.columns import Dimension, cells
from symoro_elastic.machine.joints import Joint
from symoro_elastic.machine.machine import Machine

GROUPS = (4, 2)
"""Numbers of limbs that are grouped: six are four and two."""
ANGLE_DECIMALS = 12
"""Of angles that are compared, rad: beyond, quarter turns as decimal numbers differ."""
NAMES, VALUES = re.compile(r"'name', '(\w+)'"), re.compile(r"Fraction\(.*?\)|(?<='name', )'\w+'")
"""Names, and names and numbers, in the text of the tree of a formula."""
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
    cycles: dict[str, tuple[str, ...]] = {}
    for names in (names for joints in limbs for names in _names(machine, joints)):
        if len({*names}) == len(names) and cycles.keys().isdisjoint(names):
            cycles |= dict.fromkeys(names, names)
    return tuple(dict.fromkeys(cycles.values()))


def _names(machine: Machine, joints: tuple[int, ...]) -> Iterator[tuple[str, ...]]:
    for entries in entries_by_joint(machine).values():
        if entries.keys() >= {*joints}:
            yield from zip(*(entries[j] for j in joints), strict=True)
    for formulas in zip(*(cells(machine.joint(j)) for j in joints), strict=True):
        yield from zip(*(NAMES.findall(repr(formula.tree)) for _, formula in formulas), strict=True)


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
        else formula.is_zero or VALUES.sub("", repr(formula.tree[1] if formula.tree[0] == "neg" else formula.tree))
        for cell, formula in cells(joint)
    )
    return (joint.sigma, joint.kind, joint.variable is None, joint.body.central, *values)
