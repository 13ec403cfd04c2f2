"""Elastic joints in series with massless bodies between, condensed: one spring in place of two.

Where axes j and k coincide (revolute joints) or are parallel (prismatic ones), the tool sees their sum only,
x_k = q_k + s q_j with s = z_j . z_k, and a massless body between passes on one force F:

    F = -k_j (q_j - n_j) - d_j qd_j = -s k_k (q_k - n_k) - s d_k qd_k

Eliminated where d_j / k_j = d_k / k_k; at once without dampers, with them when exp(-t k_j / d_j) has died out:
    k = k_j k_k / (k_j + k_k),    d = d_j k_k / (k_j + k_k),    n = n_k + s n_j

The joint nearer to the tool keeps its variable, which becomes x_k; the other is a fixed frame, its variable zero.
"""

from __future__ import annotations

import math
import random
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Generic

from symoro_elastic.machine.columns import cells
from symoro_elastic.machine.described import AnyMachine
from symoro_elastic.machine.formula import ZERO, Formula, FormulaError
from symoro_elastic.machine.machine import Friction, Joint, Kind, Machine, Spring, Wrench

SAME = 1e-12
TRIALS = 5
SEED = 20261


@dataclass(frozen=True)
class Condensed(Generic[AnyMachine]):
    """A machine with springs in series condensed, and a note on each.

    `variables` are the joints whose variables are gone or other ones, `between` those whose frames are at other places.
    """

    machine: AnyMachine
    notes: tuple[str, ...] = ()
    variables: frozenset[str] = frozenset()
    between: frozenset[str] = frozenset()


@dataclass(frozen=True)
class Series:
    """Elastic joints `first` and `last`, by number, with massless bodies between them.

    `sign` is z_first . z_last; `obstacle` says why they cannot be condensed exactly, empty where they can.
    """

    first: int
    last: int
    sign: int
    obstacle: str = ""


def condense(machine: AnyMachine) -> Condensed[AnyMachine]:
    """The machine with springs in series replaced by one spring wherever that is exact."""
    condensed = Condensed(machine)
    while exact := [pair for pair in springs_in_series(condensed.machine) if not pair.obstacle]:
        machine, pair = condensed.machine, exact[0]
        ends = {machine.joint(j).name for j in (pair.first, pair.last)}
        inner = {machine.joint(j).name for j in (pair.first, *(_massless_rows_beyond(machine, pair.first) or ())[:-1])}
        notes = (*condensed.notes, _note(machine, pair))
        machine = _condensed_pair(machine, pair)
        condensed = Condensed(machine, notes, condensed.variables | ends, condensed.between | inner)
    return condensed


def springs_in_series(machine: Machine) -> Iterator[Series]:
    """Neighbouring elastic joints on one axis, or parallel ones, with massless bodies between."""
    for j in machine.elastic:
        rows = _massless_rows_beyond(machine, j)
        if rows is None:
            continue
        first, last = machine.joint(j), machine.joint(rows[-1])
        signs = [_sign(machine.joint(k), first.sigma) for k in rows]
        rotorless = first.rotor_inertia.is_zero and last.rotor_inertia.is_zero
        if last.kind is Kind.ELASTIC and last.sigma == first.sigma and all(signs) and rotorless:
            yield Series(j, rows[-1], math.prod(signs), _obstacle(machine, j, rows[-1]))


def _massless_rows_beyond(machine: Machine, j: int) -> tuple[int, ...] | None:
    """Rows from the only one that joint j carries to the next joint; None if another body is carried."""
    rows: list[int] = []
    while True:
        here = rows[-1] if rows else j
        carried = [k for k, antecedent in enumerate(machine.antecedents, start=1) if antecedent == here]
        joint = machine.joint(here)
        is_massless = all(formula.is_zero for _, formula in cells(joint.body))
        if len(carried) != 1 or not is_massless or joint.wrench != Wrench():
            return None
        rows.append(carried[0])
        if machine.joint(carried[0]).kind is not Kind.FIXED:
            return tuple(rows)


def _sign(joint: Joint, sigma: int) -> int:
    """Return the sign of z of the antecedent times z of a row; 0 for axes that are not parallel."""
    if joint.alpha.names or (sigma == 0 and not joint.d.is_zero):
        return 0
    try:
        angle = abs(joint.alpha.value())
    except FormulaError:
        return 0
    if abs(angle - math.pi) <= math.ulp(math.pi):
        return -1
    return 1 if angle == 0.0 else 0


def _obstacle(machine: Machine, j: int, k: int) -> str:
    """Return why two springs in series have no equivalent spring; empty if they have."""
    first, last = machine.joint(j), machine.joint(k)
    variables = {str(first.variable), str(last.variable)}
    for i, joint in enumerate(machine.joints, start=1):
        if any(not variables.isdisjoint(formula.names) for _, formula in cells(joint)):
            return f"the cells of joint {i} ({joint.name}) hold {' or '.join(sorted(variables))}"
    for joint in (first, last):
        if not machine.variables.keys().isdisjoint(joint.selected.names | joint.spring.stiffness.names):
            return f"{joint.name} or its spring follows other joints"
        if not joint.spring.backlash.is_zero:
            return f"the spring of {joint.name} has backlash"
        if joint.friction != Friction():
            return f"friction acts on {joint.name}"
        if _is_zero(machine, joint.spring.stiffness):
            return f"the spring of {joint.name} has no stiffness"
    for loop in machine.loops:
        if not {j, k}.isdisjoint((*machine.around(loop), loop.cut, loop.meets)):
            return f"they are part of loop {loop.name}"
    if not _in_proportion(machine, first.spring, last.spring):
        return f"damping over stiffness is not the same at {first.name} and at {last.name}"
    return ""


def _is_zero(machine: Machine, formula: Formula) -> bool:
    values = {p.name: p.value.value() for p in machine.parameters if p.name in formula.names and p.value is not None}
    try:
        return formula.names <= values.keys() and formula.value(values) == 0.0
    except FormulaError:
        return False


def _in_proportion(machine: Machine, first: Spring, last: Spring) -> bool:
    """Whether d_j k_k = d_k k_j for all values of the parameters."""
    if first.damping.is_zero and last.damping.is_zero:
        return True
    source = random.Random(SEED)
    for _ in range(TRIALS):
        values = {p.name: source.uniform(0.5, 1.5) for p in machine.parameters}
        try:
            first_product = first.damping.value(values) * last.stiffness.value(values)
            other = last.damping.value(values) * first.stiffness.value(values)
        except FormulaError:
            return False
        if not math.isclose(first_product, other, rel_tol=SAME):
            return False
    return True


def _condensed_pair(machine: AnyMachine, pair: Series) -> AnyMachine:
    """The machine with both springs condensed at the last joint; the first is a fixed frame."""
    joints = list(machine.joints)
    first, last = machine.joint(pair.first), machine.joint(pair.last)
    joints[pair.first - 1] = replace(first, kind=Kind.FIXED, sigma=2, variable=None, spring=Spring())
    joints[pair.last - 1] = replace(last, spring=_spring(first.spring, last.spring, pair.sign))
    return replace(machine, joints=tuple(joints))


def _spring(first: Spring, last: Spring, sign: int) -> Spring:
    """Return the equivalent spring of two in series."""
    both = _operation("+", first.stiffness, last.stiffness)
    stiffness = _operation("/", _operation("*", first.stiffness, last.stiffness), both)
    damping = ZERO
    if not first.damping.is_zero:
        damping = _operation("/", _operation("*", first.damping, last.stiffness), both)
    neutral = last.neutral
    if not first.neutral.is_zero:
        neutral = _operation("+" if sign > 0 else "-", last.neutral, first.neutral)
    return Spring(stiffness, damping, neutral)


def _operation(sign: str, first: Formula, second: Formula) -> Formula:
    return Formula(f"({first}) {sign} ({second})", (sign, first.tree, second.tree))


def _note(machine: Machine, pair: Series) -> str:
    first, last = machine.joint(pair.first).name, machine.joint(pair.last).name
    total = f"{last} {'+' if pair.sign > 0 else '-'} {first}"
    return f"{first} and {last} are in series: {last} is {total} with k1 k2/(k1 + k2), {first} is fixed"
