"""The reference of machines whose joints are coupled: joint coordinates x and dx/du, motors on dependent joints.

dx/du and gam are those of the traced equations, in many digits; `newton_euler_disagreement` compares them, once, with
differences of assembled positions. Symbols are those of docs/loop_equations.md.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from symoro_elastic.machine.machine import Machine
from symoro_elastic.models.bind import Bound
from symoro_elastic.models.state import position_blocks
from symoro_elastic.numerics.verification.linear_systems import NumberMatrix, Numbers, Singular, dot, solve
from symoro_elastic.symbolic.arithmetic import Arithmetic, evaluate

Column = Mapping[int, Any]
Rows = Mapping[int, Numbers]
"""Rows of a matrix by the joint that owns the variable."""
PARALLEL = 1e-12
"""Of a row of dx/du, relative, that is not a combination of others."""


@dataclass(frozen=True)
class CoupledNumbers:
    """Joint coordinates x, rows of S_x = dx/du, gam_x and rates xd, by the joint that owns them."""

    x: Column
    S_x: Rows
    gam_x: Column
    xd: Column


class CoupledPrograms:
    """Joint coordinates, dx/du and gam of a machine as expressions, of the `arguments` by name."""

    def __init__(self, machine: Machine) -> None:
        self.machine, self.bound = machine, Bound(machine)
        self.entries = self.bound.arguments()
        self.arguments = (*position_blocks(machine), "qd")

    def at(self, arithmetic: Arithmetic[Any], symbols: Mapping[str, Any], ud: Numbers) -> CoupledNumbers:
        """Return their values; `symbols` are those of the arguments and of the parameters, `ud` independent rates."""
        owners, coordinates = self.machine.with_variable, self.bound.coordinates
        x = {j: self.bound.variables[j] for j in owners}
        S_x = {j: [coordinates.S_x[j].get(k, 0) for k in self.machine.independent] for j in owners}
        gam_x = {j: coordinates.gam_x[j] for j in owners}
        value = evaluate([*x.values(), *gam_x.values(), *(s for row in S_x.values() for s in row)], symbols, arithmetic)
        rows = {j: [value(s) for s in row] for j, row in S_x.items()}
        rates = {j: dot(row, ud) for j, row in rows.items()}
        return CoupledNumbers(_values(value, x), rows, _values(value, gam_x), rates)


def _values(value: Any, expressions: Column) -> Column:
    return {j: value(x) for j, x in expressions.items()}


def projection(S: Rows, Gamma: Column, zero: Any) -> Numbers:
    """Return Gamma_u = S^T Gamma (L3), entry by entry from `zero`."""
    columns = range(len(next(iter(S.values()), [])))
    return [sum((S[j][k] * force for j, force in Gamma.items()), zero) for k in columns]


def driven_motion(
    A: NumberMatrix, rest: Numbers, S_m: Rows, wanted: Column, known: Numbers
) -> tuple[Numbers, Mapping[int, Any]]:
    """Return accelerations and torques for accelerations of the motors, less gam_m, that are `wanted` (L30).

        [ A   -S_m^T ] [udd]   [  -rest ]
        [ S_m    0   ] [tau] = [ wanted ]

    `rest` is H less all forces but those of motors. The first accelerations may be `known`, as those of a base, in the
    place of the forces there. Torques are those of motors whose rows of S_m are not a combination of rows before them.
    """
    S_n = {m: S_m[m] for m in _independent(S_m)}
    matrix = [[*row, *(-s[k] for s in S_n.values())] for k, row in enumerate(A)]
    matrix += [[*s, *([0] * len(S_n))] for s in S_n.values()]
    unknown = _solution(matrix, [*(-x for x in rest), *(wanted[m] for m in S_n)], known)
    return unknown[: len(A)], dict(zip(S_n, unknown[len(A) :], strict=True))


def _solution(matrix: NumberMatrix, right: Numbers, known: Numbers) -> Numbers:
    """Return all unknowns of a linear system of which the first are known, in the place of as many equations."""
    n = len(known)
    left = [x - dot(row[:n], known) for row, x in zip(matrix[n:], right[n:], strict=True)]
    return [*known, *solve([row[n:] for row in matrix[n:]], left)]


def _independent(rows: Rows) -> list[int]:
    """Return the joints whose rows are not a combination of those before them."""
    kept: list[int] = []
    orthogonal: list[Numbers] = []
    for j, row in rows.items():
        across = row
        for other in orthogonal:
            factor = dot(across, other) / dot(other, other)
            across = [x - factor * y for x, y in zip(across, other, strict=True)]
        if max(map(abs, across), default=0) > PARALLEL * float(max(map(abs, row), default=0)):
            kept.append(j)
            orthogonal.append(across)
    return kept


def shared_torques(S_m: Rows, tau_n: Column, w: Column) -> Column:
    """Return torques of all motors with the effect of those tau_n of some, least in the sum of tau^2 / w (L31).

    tau = w B (B^T w B)^-1 tau_n, where S_m = B S_n. Raises `Singular` where rows of S_m are not a combination of S_n.
    """
    gram = [[dot(S_m[m], S_m[n]) for n in tau_n] for m in tau_n]
    B = {m: solve(gram, [dot(row, S_m[n]) for n in tau_n]) for m, row in S_m.items()}
    size = range(len(tau_n))
    BwB = [[sum(w[m] * B[m][a] * B[m][b] for m in S_m) for a in size] for b in size]
    y = solve(BwB, [*tau_n.values()])
    tau = {m: w[m] * dot(B[m], y) for m in S_m}
    for k in range(len(next(iter(S_m.values())))):
        Gamma = sum(S_m[m][k] * x for m, x in tau_n.items())
        if abs(sum(S_m[m][k] * x for m, x in tau.items()) - Gamma) > PARALLEL * float(abs(Gamma) + 1):
            raise Singular("the torques of the motors are not determined here")
    return tau
