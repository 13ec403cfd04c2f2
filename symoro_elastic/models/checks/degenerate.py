"""Machines that no dynamic model can move: pivots H_j that are zero for every value of the variables.

The recursion is run modulo a large prime on random values, so zero means identically zero. The
motion without inertia names the joints that cause it. Where joints depend on others, null directions of the inertia
matrix are found instead: closed forms and assembled positions are not rational numbers, so this is decided in double
precision, at several assembled positions and with random values for the parameters that no position depends on.
"""

from __future__ import annotations

import random
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np

from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.errors import enumeration
from symoro_elastic.machine.columns import cells
from symoro_elastic.machine.domain import Domain
from symoro_elastic.machine.machine import Joint, Kind, Machine
from symoro_elastic.machine.series_springs import springs_in_series
from symoro_elastic.mechanics.base_body import WrenchKnown
from symoro_elastic.mechanics.dynamics import AccelerationKnown, Rule, SingularPivot, TorqueKnown, dynamics
from symoro_elastic.mechanics.mechanism import Mechanism
from symoro_elastic.mechanics.spatial import AT_REST, NO_WRENCH
from symoro_elastic.models.bound.bind import Bound
from symoro_elastic.models.bound.position import Position
from symoro_elastic.models.bound.rules import base_rule
from symoro_elastic.models.loops.open_loops import SINGULAR_START
from symoro_elastic.models.loops.plan import Plan, plan_of
from symoro_elastic.models.tree.modular import modulo_prime

__all__ = ["Degeneracy", "SingularPivot", "degeneracies"]


@dataclass(frozen=True)
class Degeneracy:
    """A joint whose pivot is zero, and all joints of the motion that meets no inertia."""

    joint: int
    moving_together: tuple[int, ...]

    def message(self, machine: Machine) -> str:
        """The fault and its remedies, naming the joints."""
        if not self.joint:
            return "with all that it carries it has a motion without inertia: give it a body"
        names = [_name(machine, j) for j in self.moving_together]
        joints = [machine.joint(j) for j in self.moving_together]
        if len(joints) == 1:
            lacking = "mass" if joints[0].sigma == 1 else "inertia about this axis"
            return (
                f"H{self.joint} is zero at every position: {names[0]} moves no inertia; "
                f"give a body beyond it {lacking}, lock it in a scene, or remove the row"
            )
        if not {*self.moving_together} <= {*machine.independent}:
            return (
                f"H{self.joint} is zero at every position: {enumeration(names)} move together without moving any mass; "
                "give one of their bodies inertia, or the motor that drives them a rotor inertia"
            )
        return (
            f"H{self.joint} is zero at every position: {enumeration(names)} can move against each other without moving "
            f"any mass, {_reason(joints)}; give a body between them inertia, {_merge(joints)}{self._offer(machine)}, "
            "or check alpha and theta of these rows"
        )

    def _offer(self, machine: Machine) -> str:
        """Hint whether condensing springs in series would help here, or why not; empty for other joints."""
        pairs = [pair for pair in springs_in_series(machine) if {pair.first, pair.last} == {*self.moving_together}]
        if not pairs:
            return ""
        return (
            f" (not by condense: {pairs[0].obstacle})" if pairs[0].obstacle else " (condense = true in a scene does it)"
        )


def _name(machine: Machine, j: int) -> str:
    return f"joint {j} ({machine.joint(j).name})"


def _reason(joints: Sequence[Joint]) -> str:
    if len(joints) == 2 and joints[0].sigma == joints[1].sigma:
        return "for their axes are parallel and what lies between is massless"
    return "for what lies between is massless"


def _merge(joints: Sequence[Joint]) -> str:
    if all(joint.kind is Kind.ELASTIC for joint in joints) and len(joints) == 2:
        return "replace the two springs by one of stiffness k1 k2/(k1 + k2)"
    return "merge them"


def degeneracies(machine: Machine, known_motors: bool, folded: Sequence[str] = ()) -> list[Degeneracy]:
    """Joints whose pivot vanishes in the direct model or, with `known_motors`, in the inverse model."""
    if machine.is_coupled:
        together = motions_without_inertia(machine, known_motors, folded)
        return [Degeneracy(min((j for j in joints if j), default=0), joints) for joints in together]
    rules: list[Rule | None] = [None] * (len(machine.joints) + 1)
    motors = {*machine.motors} if known_motors else set()
    for j in machine.independent:
        rules[j] = AccelerationKnown(0) if j in motors else TorqueKnown(0)
    if not machine.floating and TorqueKnown(0) not in rules:
        return []  # all accelerations are known: nothing is divided by
    bound = Bound(machine, folded)
    base = WrenchKnown(NO_WRENCH) if base_rule(bound) else None
    at_rest = replace(bound.mechanism, velocity=AT_REST, acceleration=AT_REST)
    return list(_singular_joints(modulo_prime(at_rest), rules, base))


def _singular_joints(mechanism: Mechanism, rules: list[Rule | None], base: WrenchKnown | None) -> Iterator[Degeneracy]:
    at_rest = [0] * len(rules)
    while True:
        try:
            dynamics(mechanism, at_rest, rules, base)
        except SingularPivot as pivot:
            if not pivot.joint:
                yield Degeneracy(0, (0,))
                return
            rules[pivot.joint] = AccelerationKnown(1)
            together = _moving(mechanism, rules)
            rules[pivot.joint] = AccelerationKnown(0)
            yield Degeneracy(pivot.joint, together)
        else:
            return


def _moving(mechanism: Mechanism, rules: list[Rule | None]) -> tuple[int, ...]:
    """Joints that move when a singular joint is driven; joints nearer to the base are locked."""
    driven = max(j for j, rule in enumerate(rules) if rule == AccelerationKnown(1))
    locked: list[Rule | None] = [AccelerationKnown(0) if rule and j < driven else rule for j, rule in enumerate(rules)]
    recursion = dynamics(mechanism, [0] * len(rules), locked)
    return tuple(j for j, qdd in recursion.qdd.items() if bool(qdd))


SEED = 20261
VANISHING = 1e-9
"""Eigenvalue of the inertia matrix scaled to a unit diagonal, or entry of a direction, that counts as zero."""
PLACING = "joints"
"""The section of a machine's file with the cells that place its frames."""


def motions_without_inertia(machine: Machine, known_motors: bool, folded: Sequence[str]) -> Iterator[tuple[int, ...]]:
    """Joints that move in the motions without inertia, 0 for the base; with `known_motors` no motor moves.

    Positions at which loops are singular are skipped; raises `InputError` where all of them are, and for a cell that
    has a value at none of them.
    """
    bound, plan = Bound(machine, folded), plan_of(machine)
    kernels = []
    for symbols in _symbols(machine, plan):
        with suppress(ZeroDivisionError):
            kernels.append(_directions(bound, symbols, known_motors))
    if not kernels and not machine.loops:
        raise machine.error("joints", "no position was found at which all their formulas have a value")
    if not kernels:
        loops = ", ".join(loop.name for loop in machine.loops)
        raise machine.error(f"loop {loops}", SINGULAR_START)
    directions, S = min(kernels, key=lambda kernel: kernel[0].shape[1])
    of_base = len(directions) - S.shape[1]
    for direction in _sparse_directions(directions):
        rates = S @ direction[of_base:]
        base = (0,) if np.any(np.abs(direction[:of_base]) > VANISHING) else ()
        yield (*base, *(j for j, x in zip(machine.articulated, rates, strict=True) if abs(x) > VANISHING))


def _symbols(machine: Machine, plan: Plan) -> Iterator[dict[str, float]]:
    """Values of all parameters and variables at assembled positions."""
    source = random.Random(SEED)
    placing = {
        name
        for joint in machine.joints
        for cell, formula in cells(joint)
        if cell.column.section == PLACING
        for name in formula.names
    }
    values = {p.name: source.uniform(0.5, 1.5) for p in machine.parameters if p.name not in placing}
    domain = Domain(machine)
    for position in plan.positions:
        symbols = plan.assembly.symbols(position) | values
        defined = domain.nearest_defined(symbols, source)
        if defined is not None:
            yield defined
        elif refusal := domain.refusal(symbols):
            raise refusal


def _directions(bound: Bound, symbols: Mapping[str, float], known_motors: bool) -> tuple[Array, Array]:
    """Basis (columns) of the velocities of base and coordinates without inertia, and S, at one position."""
    machine, here = bound.machine, Position(bound, symbols)
    A, of_base = here.inertia(), machine.degrees_of_base
    locked = here.rows([bound.coordinates.S_x[j] for j in (bound.motors if known_motors else ())])
    still = np.pad(locked, ((0, 0), (of_base, 0)))
    if machine.floating and base_rule(bound) is None:
        still = np.vstack([still, np.eye(6, len(A))])
    return _null(A, _kernel(still)), here.S[list(machine.articulated)]


def _kernel(rows: Array) -> Array:
    """Basis (columns) of the null space of the rows."""
    if not len(rows):
        return np.eye(rows.shape[1])
    _, sizes, V = np.linalg.svd(rows)
    return V[int(np.sum(sizes > VANISHING * max(1.0, sizes.max(initial=0)))) :].T


def _null(A: Array, free: Array) -> Array:
    """Basis (columns) of the null space of a positive semidefinite A within the span of `free`."""
    inner = free.T @ A @ free
    lengths = np.sqrt(np.abs(np.diag(inner)))
    scale = np.where(lengths > VANISHING * max(1e-300, lengths.max(initial=0)), lengths, 1.0)
    sizes, V = np.linalg.eigh(inner / np.outer(scale, scale))
    kernel: Array = free @ (V[:, np.abs(sizes) < VANISHING] / scale[:, None])
    return kernel


def _sparse_directions(directions: Array) -> Iterator[Array]:
    """A basis of the same space made sparse by elimination, the largest entry of every direction being 1."""
    remaining = directions.copy()
    for column in range(remaining.shape[1]):
        row = int(np.argmax(np.abs(remaining[:, column:]).max(axis=1, initial=0)))
        pivot = column + int(np.argmax(np.abs(remaining[row, column:])))
        remaining[:, [column, pivot]] = remaining[:, [pivot, column]]
        remaining[:, column] /= remaining[row, column]
        other_columns = np.arange(remaining.shape[1]) != column
        remaining[:, other_columns] -= np.outer(remaining[:, column], remaining[row, other_columns])
    yield from (x / np.abs(x).max() for x in remaining.T)
