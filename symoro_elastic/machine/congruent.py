"""Congruent limbs of a machine: branches on one body with equal joints, springs and zeros; numbers and signs differ."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import groupby

from symoro_elastic.machine.columns import Dimension, cells
from symoro_elastic.machine.joints import Joint
from symoro_elastic.machine.machine import Machine
from symoro_elastic.quantities import QUANTITIES

OF_JOINTS = ("n", "m", "d", "b", "l", "s")
"""Letters of the joints that entries of arguments follow."""
GROUPS = (4, 2)
"""Numbers of limbs that are grouped: six are four and two."""
ANGLE_DECIMALS = 12
"""Of angles that are compared, rad: beyond, quarter turns as decimal numbers differ."""
NAMES, VALUES = re.compile(r"'name', '(\w+)'"), re.compile(r"Fraction\(.*?\)|(?<='name', )'\w+'")
"""Names, and names and numbers, in the text of the tree of a formula."""


def congruent_joints(machine: Machine) -> tuple[tuple[int, ...], ...]:
    """Return, for each joint of a limb, the numbers of the joints in its place in all congruent limbs.

    Limbs are the largest trees with joints that move; what loops add to them is not compared.
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


def congruent_symbols(machine: Machine, limbs: Iterable[tuple[int, ...]]) -> tuple[tuple[str, ...], ...]:
    """Return the names of corresponding arguments and parameters of congruent joints."""
    cycles: dict[str, tuple[str, ...]] = {}
    for names in (names for joints in limbs for names in _names(machine, joints)):
        if len({*names}) == len(names) and cycles.keys().isdisjoint(names):
            cycles |= dict.fromkeys(names, names)
    return tuple(dict.fromkeys(cycles.values()))


def _names(machine: Machine, joints: tuple[int, ...]) -> Iterator[tuple[str, ...]]:
    """Corresponding names, of arguments first, whether or not a model has them."""
    yield tuple(str(machine.joint(j).variable) for j in joints)
    for entries in (row.entries for row in QUANTITIES.values() if row.follows in OF_JOINTS):
        for entry in entries if isinstance(entries, tuple) else (entries,):
            yield tuple(entry.replace("@", str(j)) for j in joints)
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
    """Yield tuples of corresponding joints of congruent limbs, from the first joints `limbs` outwards."""
    rows = [tuple(limbs)]
    for row in rows:
        yield row
        rows += zip(*(sorted(carried.get(j, ()), key=lambda k: (kinds[k], k)) for j in row), strict=True)


def _pattern(joint: Joint) -> tuple[object, ...]:
    """A key that is equal for congruent joints: kind, zeros and names in all cells, angles without their signs."""
    values = (
        round(abs(formula.value()), ANGLE_DECIMALS)
        if cell.column.dimension is Dimension.ANGLE and not formula.names
        else formula.is_zero or VALUES.sub("", repr(formula.tree[1] if formula.tree[0] == "neg" else formula.tree))
        for cell, formula in cells(joint)
    )
    return (joint.sigma, joint.kind, joint.variable is None, joint.body.central, *values)
