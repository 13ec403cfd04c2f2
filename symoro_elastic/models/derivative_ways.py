"""Ways to the derivatives of a model: a recursion over composite bodies, or its graph differentiated."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from symoro_elastic.foundation.scalar import Scalar
from symoro_elastic.mechanics.base_body import DEGREES
from symoro_elastic.mechanics.derivatives.accelerations import (
    Solve,
    changes,
    changes_by_known,
    solving,
    solving_with_base,
)
from symoro_elastic.mechanics.derivatives.base import add_base, by_pose, falling_by_pose
from symoro_elastic.mechanics.derivatives.torques import Entries, torque_derivatives
from symoro_elastic.mechanics.dynamics import Dynamics
from symoro_elastic.mechanics.spatial import Axis
from symoro_elastic.models.bind import Bound
from symoro_elastic.models.derivative_columns import Variables, moved_with
from symoro_elastic.models.model import Joints
from symoro_elastic.models.naming_derivatives import name_torque_derivatives
from symoro_elastic.models.rules import base_rule
from symoro_elastic.symbolic.differentiation import Differentiation, Tangents
from symoro_elastic.symbolic.expression import reachable

Outputs = Mapping[str, Mapping[int, Scalar]]
"""Entries of each result of a model, by joint."""
Which = tuple[str, str]
"""A derivative: the result, and the argument that it is taken by."""


def values_of(outputs: Outputs) -> list[Scalar]:
    """All entries of the results of a model."""
    return [x for entries in outputs.values() for x in entries.values()]


@dataclass(frozen=True)
class Derivatives:
    """Entries of each derivative; those of quantities on the way, by name of the variable."""

    entries: dict[Which, Entries]
    tangents: dict[str, Tangents] = field(default_factory=dict)

    @property
    def size(self) -> int:
        """Expressions that they need."""
        return len(reachable(x for entries in self.entries.values() for x in entries.values()))

    def only(self, by: Variables) -> Derivatives:
        """The columns of these variables."""
        entries = {
            (result, argument): {(j, c): x for (j, c), x in entries.items() if c in by[argument]}
            for (result, argument), entries in self.entries.items()
            if argument in by
        }
        return Derivatives(entries, self.tangents)


def has_recursion(bound: Bound) -> bool:
    """Whether composite bodies give the derivatives: no joint follows another, no stiffness or wrench on positions."""
    if bound.machine.forces:
        return False
    varying = (bound.machine.joint(j).spring.stiffness.names for j in bound.machine.elastic)
    return not bound.machine.is_coupled and all(map(bound.machine.variables.keys().isdisjoint, varying))


def by_recursion(bound: Bound, found: Dynamics, outputs: Outputs, by: Variables) -> Derivatives:
    """By composite bodies and, where accelerations of joints or of the base are to be found, linear systems."""
    by_q, by_qd, A = torque_changes(bound, found)
    free, solve = unknown_accelerations(bound, A, found, bound.machine.independent if "qdd" in outputs else ())
    numbers = (*DEGREES[: bound.machine.degrees_of_base], *bound.machine.independent)
    tables = {"driven": changes_by_known(A, numbers, free, solve)} if free else {"driven": A}
    tables |= {"q": changes(by_q, A, numbers, free, solve), "qd": changes(by_qd, A, numbers, free, solve)}
    of = {"q": "q", "qd": "qd", "V0": "qd"}
    entries: dict[Which, Entries] = {}
    for result in outputs:
        for name, columns in by.items():
            if name != "pose":
                table = tables[of.get(name, "driven")]
                entries |= split_by_result(bound, table, {result: outputs[result]}, {name: columns})
    return Derivatives(entries)


def unknown_accelerations(bound: Bound, A: Entries, found: Dynamics, joints: Joints) -> tuple[Joints, Solve]:
    """Numbers of the unknown accelerations, and the solver for them."""
    solve: Solve = solving(found.mechanism, A, found) if joints else lambda right: {}
    if base_rule(bound) is None:
        return joints, solve
    return (*DEGREES, *joints), solving_with_base(A, found.Js[0], joints, solve)


def split_by_result(bound: Bound, table: Entries, outputs: Outputs, by: Variables) -> dict[Which, Entries]:
    """The rows of each result and the columns of each argument in a table of all of them."""
    return {
        (result, name): {(i, c): table[i, c] for i in rows for c in columns if (i, c) in table}
        for result, rows in outputs.items()
        for name, columns in by.items()
    }


def with_pose(bound: Bound, made: Derivatives, outputs: Outputs) -> Derivatives:
    """With the columns of the pose of the base."""
    if not bound.machine.degrees_of_base:
        return made
    posed: dict[Which, Entries] = {}
    for result in outputs:
        if base_rule(bound):
            still: Entries = {(i, m): 0 for i in outputs[result] for m in DEGREES}
            posed[result, "pose"] = falling_by_pose(bound.gravity) if result == "V0d" else still
        elif (result, "V0d") in made.entries:
            posed[result, "pose"] = by_pose(made.entries[result, "V0d"], bound.gravity)
    return replace(made, entries=made.entries | posed)


def torque_changes(bound: Bound, found: Dynamics) -> tuple[Entries, Entries, Entries]:
    """Derivatives by q, qd and qdd of the torques that a motion asks of motors, springs and friction included.

    Rows and columns of the base are those of its wrench, its velocity and its acceleration.
    """
    made = torque_derivatives(found.mechanism, bound.rates(), found)
    if bound.machine.degrees_of_base:
        add_base(made, found.w[0])
    name_torque_derivatives(bound, made)
    by_q, by_qd = dict(made.by_q), dict(made.by_qd)
    for j in bound.machine.independent:
        spring = bound.spring_of(j)
        by_q[j, j] = by_q[j, j] + spring.change(bound.rate(j))
        by_qd[j, j] = by_qd[j, j] + bound.friction_slope(j) + spring.damper
    return by_q, by_qd, made.by_qdd


def of_graph(bound: Bound, outputs: Outputs, by: Variables) -> Derivatives:
    """By differentiating the graph of a model: total derivatives, along what moves with a variable (L42)."""
    graph = Differentiation(values_of(outputs))
    made = Derivatives({(result, name): {} for result in outputs for name in by})
    for name, variables in by.items():
        for c, variable in variables.items():
            made.tangents[variable.operands[0]] = tangents = graph.along(moved_with(bound, name, c, variable))
            for result, entries in outputs.items():
                made.entries[result, name] |= {(j, c): tangents.of(x) for j, x in entries.items()}
    return made


def shorter_way(bound: Bound, solved: Derivatives, outputs: Outputs, by: Variables) -> Derivatives:
    """Derivatives by recursion and linear systems or, with slides, those of the graph if they are shorter."""
    if all(link.axis is not Axis.PRISMATIC for link in bound.mechanism.links):
        return solved
    return min(solved, of_graph(bound, outputs, by), key=lambda made: made.size)
