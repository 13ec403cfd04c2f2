"""Dynamic models in forms from which terms may be dropped; all other quantities follow from these.

**Energies**: A(q) and the potential V(q) give the equations of motion by derivatives. With T = qd' A qd / 2 Lagrange's
equations are

    A qdd + H = Gamma,    H = Ad qd - d(T - V)/dq,

Ad along the motion. Whatever is dropped from A, whose entries occur once, and from V: A stays symmetric, Ad - 2 C
skew, and qd' H is the rate of T + V, so that energy is conserved. Springs, dampers and friction are not changed.

**Linear system**: a direct model is A and the right side of A qdd = right [8], and qdd of both. Between the two A and
the right side terms may be dropped. Entries of A occur once, so A stays symmetric.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction

from symoro_elastic.machine.machine import Machine
from symoro_elastic.mechanics.dynamics import dynamics
from symoro_elastic.mechanics.energy import gravity_energy
from symoro_elastic.mechanics.factorization import factorization, solution
from symoro_elastic.models.bound.bind import Bound, coordinate_inertia
from symoro_elastic.models.bound.model import Joints, Result
from symoro_elastic.models.bound.naming import name_composites, name_dynamics, name_factors
from symoro_elastic.models.bound.rules import held_rules
from symoro_elastic.models.bound.tracing import prune
from symoro_elastic.models.programs.catalogue import MODELS, trace_of
from symoro_elastic.symbolic.arithmetic import nodes
from symoro_elastic.symbolic.differentiation import Differentiation, gradient
from symoro_elastic.symbolic.expression import Expression, Graph, Operand, operand, reachable
from symoro_elastic.symbolic.operations import SYMBOL
from symoro_elastic.symbolic.program import Input, Names, Output, Program, Pruned, Section, build, schedule

DIRECT, INVERSE = "direct_dynamics", "inverse_dynamics"
OFFERED = (DIRECT, INVERSE)
Matrix = dict[int, dict[int, Operand]]


@dataclass(frozen=True)
class _Form:
    joints: Joints

    def matrix(self, entries: Sequence[Operand]) -> Matrix:
        """Return the symmetric matrix by joint numbers, from the entries of its lower triangle."""
        A: Matrix = {i: {} for i in self.joints}
        places = ((i, j) for k, i in enumerate(self.joints) for j in self.joints[: k + 1])
        for (i, j), x in zip(places, entries, strict=True):
            A[i][j] = A[j][i] = x
        return A


@dataclass(frozen=True)
class EnergyForm(_Form):
    """Entries of A on and below its diagonal, row by row, and V: outputs of a program of q.

    `exerted` are the passive forces on joints (springs, dampers, friction); `driven` includes the torques of motors.
    """

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
            right = {j: operand(self.driven[j] - H[j]) for j in self.joints}
            return {"qdd": _in_order(self._solve(A, self.joints, right, names), self.joints)}
        passive = tuple(j for j in self.joints if j not in self.motors)
        qdd: dict[int, Operand] = {j: self._symbol(f"qdd{j}") for j in self.motors}
        right = {j: operand(self.exerted[j] - H[j] - _row(A[j], qdd)) for j in passive}
        qdd |= self._solve(A, passive, right, names)
        tau = {j: operand(_row(A[j], qdd) + H[j] - self.exerted[j]) for j in self.motors}
        return {"tau": _in_order(tau, self.motors), "qdd": _in_order(qdd, self.joints)}

    def _symbol(self, name: str) -> Expression:
        return self.graph.symbol(name)

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

    def _solve(self, A: Matrix, joints: Joints, right: Mapping[int, Operand], names: Names) -> dict[int, Operand]:
        """Accelerations of joints that solve their rows of the equations of motion."""
        if not joints:
            return {}
        factors = factorization(joints[::-1], A)
        qdd = solution(factors, right)
        name_factors(names, factors, right, qdd)
        return {j: operand(x) for j, x in qdd.items()}


def _row(row: Mapping[int, Operand], x: Mapping[int, Operand]) -> Operand:
    total: Operand = 0
    for j, value in x.items():
        total = operand(total + row[j] * value)
    return total


def _in_order(values: Mapping[int, Operand], joints: Joints) -> tuple[Operand, ...]:
    return tuple(values[j] for j in joints)


def has_energy_form(machine: Machine) -> bool:
    """Whether `energy_form` supports a machine: a tree on a base at rest, without external wrenches."""
    return not (machine.is_coupled or machine.degrees_of_base or machine.loops or machine.forces)


def energy_form(machine: Machine, folded: Sequence[str]) -> EnergyForm:
    """Return the energy form of a machine restricted to its scene; `folded` parameters are constants."""
    bound = Bound(machine, folded)
    matrix, joints = coordinate_inertia(bound), machine.independent
    name_composites(bound, matrix)
    entries = tuple(matrix.A[i][j] for k, i in enumerate(joints) for j in joints[: k + 1])
    potential = gravity_energy(bound.mechanism, bound.gravity, bound.depth)
    results = {"A": Result(None, entries, (len(entries),)), "V": Result(None, (potential,), (1,))}
    pruned = prune(trace_of(MODELS["inertia_matrix"], bound, results))
    program = schedule(pruned.trace.inputs, pruned.needed)
    passive, driven = bound.passive_forces(), bound.exerted_forces()
    forces = ({j: operand(x.get(j, 0)) for j in joints} for x in (passive, driven))
    return EnergyForm(joints, machine.motors, program, pruned.needed.names, *forces)


@dataclass(frozen=True)
class InertiaForm(_Form):
    """Entries of A on and below its diagonal, row by row, and the right side: outputs of a program of q, qd, tau."""

    program: Program
    names: Names

    @property
    def accelerations(self) -> tuple[str, ...]:
        """Names of the symbols of accelerations."""
        return tuple(f"qdd{j}" for j in self.joints)

    def residual(self) -> Program:
        """Return the residual A qdd - right as a program, with accelerations as inputs and the nodes of `program`."""
        entries, loads = (output.entries for output in self.program.outputs)
        A, graph = self.matrix(entries), self.program.nodes[0].graph
        rows = []
        for i, load in zip(self.joints, loads, strict=True):
            row: Operand = 0
            for j, name in zip(self.joints, self.accelerations, strict=True):
                row = row + A[i][j] * graph.symbol(name)
            rows.append(row - load)
        output = Output("Gamma", (len(rows),), tuple(rows))
        inputs = (*self.program.inputs, Input("qdd", self.accelerations))
        return schedule(inputs, Pruned((output,), Names(), reachable(rows)))

    def solved(self, outputs: Sequence[Output], names: Names, joints: Joints) -> Program:
        """Return the direct model that solves the system with other `outputs`, whose quantities have `names`."""
        entries, right = (output.entries for output in outputs)
        factors = factorization(self.joints[::-1], self.matrix(entries))
        right_sides: Mapping[int, Operand] = dict(zip(self.joints, right, strict=True))
        qdd = solution(factors, right_sides)
        name_factors(names, factors, right_sides, qdd)
        return build(
            self.program.inputs, [Output("qdd", (len(joints),), tuple(operand(qdd[j]) for j in joints))], names
        )


def has_inertia_form(machine: Machine) -> bool:
    """Whether `inertia_form` supports a machine: a tree on a fixed base."""
    return not machine.is_coupled and not machine.degrees_of_base and not machine.loops


def inertia_form(machine: Machine, folded: Sequence[str]) -> InertiaForm:
    """Return A and the right side for a machine restricted to its scene; `folded` parameters are constants."""
    bound = Bound(machine, folded)
    recursion = dynamics(bound.without_tip_angles, bound.rates(), held_rules(bound))
    matrix = coordinate_inertia(bound)
    exerted, bias, joints = bound.exerted_forces(), bound.on_independent(recursion.Gamma), machine.independent
    name_dynamics(bound, recursion, "[15]", "[61]")
    name_composites(bound, matrix)
    entries = tuple(matrix.A[i][j] for k, i in enumerate(joints) for j in joints[: k + 1])
    right = tuple(exerted[j] - bias[j] for j in joints)
    results = {"A": Result(None, entries, (len(entries),)), "right": Result(joints, right)}
    pruned = prune(trace_of(MODELS[DIRECT], bound, results))
    return InertiaForm(joints, schedule(pruned.trace.inputs, pruned.needed), pruned.needed.names)
