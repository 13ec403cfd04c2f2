"""Equations of motion from energies: A(q) and the potential V(q), which may be changed, give all else by derivatives.

With T = qd' A qd / 2 Lagrange's equations are

    A qdd + H = Gamma,    H = Ad qd - d(T - V)/dq,

Ad along the motion. Whatever is left out of A, each entry of which stands once, and of V: A stays symmetric, Ad - 2 C
skew, and qd' H is the rate of T + V, so that nothing is made from nothing. Springs, dampers and friction stay whole.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction

from symoro_elastic.machine.machine import Machine
from symoro_elastic.mechanics.energy import gravity_energy
from symoro_elastic.mechanics.factorization import factorization, solution
from symoro_elastic.models.bind import Bound
from symoro_elastic.models.catalogue import MODELS, trace_of
from symoro_elastic.models.coordinate_inertia import coordinate_inertia
from symoro_elastic.models.model import Joints, Result
from symoro_elastic.models.naming import name_composites, name_factors_in
from symoro_elastic.models.tracing import prune
from symoro_elastic.symbolic.arithmetic import nodes
from symoro_elastic.symbolic.differentiation import Differentiation
from symoro_elastic.symbolic.expression import Expression, Graph, Operand, operand, reachable
from symoro_elastic.symbolic.gradient import gradient
from symoro_elastic.symbolic.operations import SYMBOL
from symoro_elastic.symbolic.program import Names, Program, Section, schedule

DIRECT, INVERSE = "direct_dynamics", "inverse_dynamics"
OFFERED = (DIRECT, INVERSE)
Matrix = dict[int, dict[int, Operand]]


@dataclass(frozen=True)
class EnergyForm:
    """Entries of A on and below its diagonal, row by row, and V: outputs of a program of q.

    `exerted` are the forces on each joint beside those of inertia and gravity, with the torques of motors in `driven`.
    """

    joints: Joints
    motors: Joints
    program: Program
    names: Names
    exerted: Mapping[int, Operand]
    driven: Mapping[int, Operand]

    @property
    def graph(self) -> Graph:
        """The graph of all expressions."""
        return self.program.nodes[0].graph

    def results(self, model: str, entries: Sequence[Operand], names: Names) -> dict[str, tuple[Operand, ...]]:
        """Return the results of a model, by name, from the entries of A and V; quantities are named in `names`."""
        A, H = self.matrix(entries[:-1]), self._bias(entries)
        for j in self.joints:
            names.give(H[j], f"Gamma{j}", Section("Derivatives of the energies", j, "[8]"))
        if model == DIRECT:
            known = {j: operand(self.driven[j] - H[j]) for j in self.joints}
            return {"qdd": _in_order(self._solved(A, self.joints, known, names), self.joints)}
        passive = tuple(j for j in self.joints if j not in self.motors)
        qdd: dict[int, Operand] = {j: self._symbol(f"qdd{j}") for j in self.motors}
        known = {j: operand(self.exerted[j] - H[j] - _row(A[j], qdd)) for j in passive}
        qdd |= self._solved(A, passive, known, names)
        tau = {j: operand(_row(A[j], qdd) + H[j] - self.exerted[j]) for j in self.motors}
        return {"tau": _in_order(tau, self.motors), "qdd": _in_order(qdd, self.joints)}

    def _symbol(self, name: str) -> Expression:
        return self.graph.symbol(name)

    def matrix(self, entries: Sequence[Operand]) -> Matrix:
        """Return the whole matrix by joint numbers, from the entries of its lower triangle."""
        A: Matrix = {i: {} for i in self.joints}
        places = ((i, j) for k, i in enumerate(self.joints) for j in self.joints[: k + 1])
        for (i, j), x in zip(places, entries, strict=True):
            A[i][j] = A[j][i] = x
        return A

    def _bias(self, entries: Sequence[Operand]) -> dict[int, Operand]:
        """H = Ad qd - d(T - V)/dq."""
        q, qd = ({j: self._symbol(f"{name}{j}") for j in self.joints} for name in ("q", "qd"))
        change = Differentiation(entries[:-1]).along({q[j]: qd[j] for j in self.joints})
        rate = self.matrix([change.of(x) for x in entries[:-1]])
        pairs = [(i, j) for k, i in enumerate(self.joints) for j in self.joints[: k + 1]]
        weights = [qd[i] * qd[j] if i != j else qd[i] * qd[i] * Fraction(1, 2) for i, j in pairs]
        symbols = {x.operands[0]: x for x in reachable(entries) if x.operation == SYMBOL}
        slopes = gradient(entries, [*weights, -1], symbols, nodes(self.graph))
        return {j: operand(_row(rate[j], qd) - slopes.get(f"q{j}", 0)) for j in self.joints}

    def _solved(self, A: Matrix, joints: Joints, known: Mapping[int, Operand], names: Names) -> dict[int, Operand]:
        """The accelerations of some joints from their rows."""
        if not joints:
            return {}
        factors = factorization(joints[::-1], A)
        qdd = solution(factors, known)
        name_factors_in(names, factors, known, qdd)
        return {j: operand(x) for j, x in qdd.items()}


def _row(row: Mapping[int, Operand], x: Mapping[int, Operand]) -> Operand:
    total: Operand = 0
    for j, value in x.items():
        total = operand(total + row[j] * value)
    return total


def _in_order(found: Mapping[int, Operand], joints: Joints) -> tuple[Operand, ...]:
    return tuple(found[j] for j in joints)


def has_energy_form(machine: Machine) -> bool:
    """Whether the equations of a machine follow from energies here: of trees on a base at rest, without wrenches."""
    return not (machine.is_coupled or machine.degrees_of_base or machine.loops or machine.forces)


def energy_form(machine: Machine, folded: Sequence[str]) -> EnergyForm:
    """Return A and V of a machine that is restricted to its scene; `folded` parameters are constants."""
    bound = Bound(machine, folded)
    found, joints = coordinate_inertia(bound), machine.independent
    name_composites(bound, found)
    entries = tuple(found.A[i][j] for k, i in enumerate(joints) for j in joints[: k + 1])
    potential = gravity_energy(bound.mechanism, bound.gravity, bound.depth)
    results = {"A": Result(None, entries, (len(entries),)), "V": Result(None, (potential,), (1,))}
    pruned = prune(trace_of(MODELS["inertia_matrix"], bound, results))
    program = schedule(pruned.trace.inputs, pruned.needed)
    passive, driven = bound.passive_forces(), bound.exerted_forces()
    in_order = ({j: operand(x.get(j, 0)) for j in joints} for x in (passive, driven))
    return EnergyForm(joints, machine.motors, program, pruned.needed.names, *in_order)
