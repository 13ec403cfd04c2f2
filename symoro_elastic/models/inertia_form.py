"""A direct model in two parts: A and the right side of A qdd = right [8], and qdd of both.

Between the two A and the right side may be changed. Each entry of A stands once, so that A stays symmetric.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from symoro_elastic.machine.machine import Machine
from symoro_elastic.mechanics.dynamics import dynamics
from symoro_elastic.mechanics.factorization import factorization, solution
from symoro_elastic.models.bind import Bound
from symoro_elastic.models.catalogue import MODELS, trace_of
from symoro_elastic.models.coordinate_inertia import coordinate_inertia
from symoro_elastic.models.model import Joints, Result
from symoro_elastic.models.naming import name_composites, name_dynamics, name_factors_in
from symoro_elastic.models.rules import held_rules
from symoro_elastic.models.tracing import prune
from symoro_elastic.symbolic.expression import Operand, operand, reachable
from symoro_elastic.symbolic.program import Input, Names, Output, Program, Pruned, build, schedule

DIRECT = "direct_dynamics"


@dataclass(frozen=True)
class InertiaForm:
    """Entries of A on and below its diagonal, row by row, and the right side: outputs of a program of q, qd, tau."""

    joints: Joints
    program: Program
    names: Names

    def matrix(self, entries: Sequence[Operand]) -> dict[int, dict[int, Operand]]:
        """Return the whole matrix by joint numbers, from the entries of its lower triangle."""
        A: dict[int, dict[int, Operand]] = {i: {} for i in self.joints}
        places = ((i, j) for k, i in enumerate(self.joints) for j in self.joints[: k + 1])
        for (i, j), x in zip(places, entries, strict=True):
            A[i][j] = A[j][i] = x
        return A

    @property
    def accelerations(self) -> tuple[str, ...]:
        """Names of the symbols of given accelerations."""
        return tuple(f"qdd{j}" for j in self.joints)

    def residual(self) -> Program:
        """Return A qdd - right as a program of given accelerations, too: the parts in it are those of `program`."""
        entries, right = (output.entries for output in self.program.outputs)
        A, graph = self.matrix(entries), self.program.nodes[0].graph
        rows = []
        for i, known in zip(self.joints, right, strict=True):
            row: Operand = 0
            for j, name in zip(self.joints, self.accelerations, strict=True):
                row = row + A[i][j] * graph.symbol(name)
            rows.append(row - known)
        output = Output("Gamma", (len(rows),), tuple(rows))
        inputs = (*self.program.inputs, Input("qdd", self.accelerations))
        return schedule(inputs, Pruned((output,), Names(), reachable(rows)))

    def solved(self, outputs: Sequence[Output], names: Names, asked: Joints) -> Program:
        """Return the direct model for new `outputs` of the program, whose quantities have `names`."""
        entries, right = (output.entries for output in outputs)
        factors = factorization(self.joints[::-1], self.matrix(entries))
        known: Mapping[int, Operand] = dict(zip(self.joints, right, strict=True))
        qdd = solution(factors, known)
        name_factors_in(names, factors, known, qdd)
        return build(self.program.inputs, [Output("qdd", (len(asked),), tuple(operand(qdd[j]) for j in asked))], names)


def has_inertia_form(machine: Machine) -> bool:
    """Whether A and the right side are found for a machine here: for trees on a base that is given."""
    return not machine.is_coupled and not machine.degrees_of_base and not machine.loops


def inertia_form(machine: Machine, folded: Sequence[str]) -> InertiaForm:
    """Return both parts for a machine that is restricted to its scene; `folded` parameters are constants."""
    bound = Bound(machine, folded)
    held = dynamics(bound.without_tip_angles, bound.rates(), held_rules(bound))
    found = coordinate_inertia(bound)
    exerted, bias, joints = bound.exerted_forces(), bound.on_independent(held.Gamma), machine.independent
    name_dynamics(bound, held, "[15]", "[61]")
    name_composites(bound, found)
    entries = tuple(found.A[i][j] for k, i in enumerate(joints) for j in joints[: k + 1])
    right = tuple(exerted[j] - bias[j] for j in joints)
    results = {"A": Result(None, entries, (len(entries),)), "right": Result(joints, right)}
    pruned = prune(trace_of(MODELS[DIRECT], bound, results))
    return InertiaForm(joints, schedule(pruned.trace.inputs, pruned.needed), pruned.needed.names)
