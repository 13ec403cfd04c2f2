"""The reference of machines whose joints are coupled: own variables, springs by them, motors on dependent joints.

dx/du and gam are those of the traced equations, in many digits; `coupled_disagreement` compares them, once, with
differences of assembled positions.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from typing import TYPE_CHECKING, Any

from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.machine import Given, Machine
from symoro_elastic.models.bind import Bound
from symoro_elastic.numerics.linear_systems import Numbers, Singular, dot, solve
from symoro_elastic.symbolic.arithmetic import evaluate

if TYPE_CHECKING:
    from symoro_elastic.models.catalogue import TracedModel
    from symoro_elastic.numerics.reference import StateReference

Row = Mapping[int, Any]
STEP = Fraction(1, 10**17)
"""Of differences by which a stiffness is differentiated."""
PARALLEL = 1e-12
"""Of a row of dx/du, relative, that is no combination of others."""


@dataclass(frozen=True)
class CoupledNumbers:
    """Own variables, rows of dx/du over the independent variables, gam and rates, by the joint that owns them."""

    x: Row
    S_x: Mapping[int, Row]
    gam_x: Row
    rates: Row


class CoupledPrograms:
    """Own variables, dx/du and gam of a machine as expressions."""

    def __init__(self, machine: Machine) -> None:
        self.machine, self.bound = machine, Bound(machine)
        self.entries = self.bound.arguments()

    def at(self, point: StateReference) -> CoupledNumbers:
        """Return their values at a state."""
        owners, moving, coordinates = self.machine.owners, self.machine.moving, self.bound.coordinates
        x = {j: self.bound.variables[j] for j in owners}
        S_x = {j: {k: coordinates.S_x[j].get(k, 0) for k in moving} for j in owners}
        gam_x = {j: coordinates.gam_x[j] for j in owners}
        symbols = dict(point.names)
        for argument in ("q", "qd", *(("q_dep",) if self.bound.takes_dependent else ())):
            symbols |= zip(self.entries[argument], point.numbers(argument), strict=True)
        leaves = [*x.values(), *gam_x.values(), *(entry for row in S_x.values() for entry in row.values())]
        value = evaluate(leaves, symbols, point.arithmetic)
        rows = {j: {k: value(entry) for k, entry in row.items()} for j, row in S_x.items()}
        rates = {j: dot([*row.values()], point.qd) for j, row in rows.items()}
        return CoupledNumbers({j: value(v) for j, v in x.items()}, rows, {j: value(v) for j, v in gam_x.items()}, rates)


def passive_forces(point: StateReference) -> dict[int, Any]:
    """Return what springs and dampers exert on own variables: -k (x - x0) - d xd, and what a change of k takes."""
    machine, numbers = point.reference.machine, point.coupled
    found = dict.fromkeys(machine.owners, point.arithmetic.number(0))
    for j in machine.elastic:
        spring = machine.joint(j).spring
        stretch = numbers.x[j] - point.cell(spring.neutral)
        found[j] += (
            -point.cell(spring.stiffness, point.variables) * stretch - point.cell(spring.damping) * numbers.rates[j]
        )
        for name in spring.stiffness.names & machine.variables.keys():
            found[machine.variables[name]] -= _slope(point, spring.stiffness, name) * stretch * stretch / 2
    return found


def _slope(point: StateReference, formula: Formula, name: str) -> Any:
    """Return the derivative of a formula by a variable."""
    h = point.arithmetic.number(STEP)
    after, before = ({**point.variables, name: point.variables[name] + way * h} for way in (1, -1))
    return (point.cell(formula, after) - point.cell(formula, before)) / (2 * h)


def on_independent(point: StateReference, forces: Row) -> Numbers:
    """Return S_x^T Gamma_x (L3)."""
    zero, S_x = point.arithmetic.number(0), point.coupled.S_x
    return [sum((S_x[j][k] * x for j, x in forces.items()), zero) for k in point.reference.machine.moving]


def exerted(point: StateReference) -> Numbers:
    """Return what motors, springs and dampers exert on the independent variables."""
    forces = passive_forces(point)
    for j, tau in zip(point.reference.machine.motors, point.numbers("tau"), strict=True):
        forces[j] += tau
    return on_independent(point, forces)


def driven(point: StateReference, traced: TracedModel) -> dict[str, Numbers]:
    """Return torques of motors and accelerations of independent variables for accelerations of the motors (L30)."""
    machine, numbers = point.reference.machine, point.coupled
    motors = dict(zip(machine.motors, point.numbers("qdd_motor"), strict=True))
    rows = {m: [*numbers.S_x[m].values()] for m in motors}
    kept = _independent(rows)
    known = point.numbers("V0d") if machine.floating and machine.floating.known is Given.ACCELERATION else []
    on_base = point.numbers("f0") if machine.floating and not known else []
    of_base, zero = len(known) + len(on_base), point.arithmetic.number(0)
    pushed = [*([zero] * len(known)), *on_base, *on_independent(point, passive_forces(point))]
    size = len(point.A)
    matrix = [[*row, *(-rows[m][k - of_base] if k >= of_base else zero for m in kept)] for k, row in enumerate(point.A)]
    matrix += [[*([zero] * of_base), *rows[m], *([zero] * len(kept))] for m in kept]
    right = [x - h for x, h in zip(pushed, point.H, strict=True)]
    right += [motors[m] - numbers.gam_x[m] for m in kept]
    held = len(known)
    right = [x - dot(row[:held], known) for x, row in zip(right, matrix, strict=True)][held:]
    found = solve([row[held:] for row in matrix[held:]], right)
    udd = [*known, *found[: size - held]]
    tau = _shared(machine, point, rows, dict(zip(kept, found[size - held :], strict=True)))
    force = [dot(row, udd) + h for row, h in zip(point.A[:of_base], point.H, strict=False)]
    given = {"V0d": udd[:of_base], "f0": force}
    by_joint = {"tau": tau, "qdd": dict(zip(machine.moving, udd[of_base:], strict=True))}
    return {
        name: given[name] if name in given else [by_joint[name][j] for j in asked]
        for name, asked in traced.rows.items()
    }


def _independent(rows: Mapping[int, Numbers]) -> list[int]:
    """Return the joints whose rows are no combination of those before them."""
    kept: list[int] = []
    reduced: list[Numbers] = []
    for j, row in rows.items():
        left = row
        for other in reduced:
            factor = dot(left, other) / dot(other, other)
            left = [x - factor * y for x, y in zip(left, other, strict=True)]
        if max(map(abs, left), default=0) > PARALLEL * max(map(abs, row), default=0):
            kept.append(j)
            reduced.append(left)
    return kept


def _shared(machine: Machine, point: StateReference, rows: Mapping[int, Numbers], tau: Row) -> Row:
    """Return torques of all motors with the effect of those of independent ones, least in sum of tau^2/share (L31)."""
    if len(tau) == len(rows):
        return tau
    shares = {m: _share(machine.joint(m).sharing, point) for m in rows}
    columns = [list(column) for column in zip(*rows.values(), strict=True)]
    Gamma = [sum(rows[m][k] * x for m, x in tau.items()) for k in range(len(columns))]
    basis = [*tau]
    gram = [[dot(rows[m], rows[n]) for n in basis] for m in basis]
    mixing = {m: solve(gram, [dot(rows[m], rows[n]) for n in basis]) for m in rows}
    weighted = [
        [sum(shares[m] * mixing[m][a] * mixing[m][b] for m in rows) for a in range(len(basis))]
        for b in range(len(basis))
    ]
    y = solve(weighted, [tau[m] for m in basis])
    found = {m: shares[m] * dot(mixing[m], y) for m in rows}
    if any(
        abs(dot([*found.values()], column) - x) > PARALLEL * (abs(x) + 1)
        for column, x in zip(columns, Gamma, strict=True)
    ):
        raise Singular("the torques of the motors are not determined here")
    return found


def _share(sharing: Formula, point: StateReference) -> Any:
    return point.arithmetic.number(1) if sharing.is_zero else point.cell(sharing)
