"""Ways to the derivatives of a model: a recursion over composite bodies, or its graph differentiated."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from symoro_elastic.foundation.scalar import Scalar
from symoro_elastic.mechanics.base_body import DEGREES
from symoro_elastic.mechanics.bias_acceleration import with_tips_in_frames_before
from symoro_elastic.mechanics.derivatives.accelerations import (
    Solve,
    accelerated,
    changes,
    changes_by_known,
    factors_of,
    is_short,
    solving,
    solving_with_base,
)
from symoro_elastic.mechanics.derivatives.base import add_base, by_pose, falling_by_pose
from symoro_elastic.mechanics.derivatives.torques import (
    Entries,
    TorqueDerivatives,
    add_motion,
    by_accelerations,
    torque_derivatives,
)
from symoro_elastic.mechanics.dynamics import Dynamics, dynamics
from symoro_elastic.mechanics.factorization import solution
from symoro_elastic.mechanics.mechanism import Mechanism
from symoro_elastic.mechanics.spatial import Axis
from symoro_elastic.models.bind import Bound
from symoro_elastic.models.derivative_columns import Variables, moved_with
from symoro_elastic.models.model import Joints
from symoro_elastic.models.naming import name_accelerated, name_factors, name_known
from symoro_elastic.models.naming_derivatives import name_by_accelerations, name_torque_derivatives
from symoro_elastic.models.rules import base_rule, direct_motion, held_rules
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


def with_tips_turned(bound: Bound) -> Mechanism:
    """The mechanism with its tips in the frames before their joints' rotations: bodies turn, not rows and columns."""
    if bound.machine.is_coupled:
        return bound.without_tip_angles
    return with_tips_in_frames_before(bound.mechanism, bound.machine.independent)


def is_solved_by_factors(bound: Bound) -> bool:
    """Whether the factors of A give the accelerations of the direct model in fewer operations than its recursion.

    Between stiff springs these lose digits that the recursion keeps; slides may take the graph of the recursion.
    """
    machine = bound.machine
    return not (machine.degrees_of_base or machine.elastic or _has_slides(bound)) and is_short(bound.mechanism)


def solved_by_factors(bound: Bound) -> tuple[Dynamics, TorqueDerivatives]:
    """The motion under the torques, by the factors of A, and what velocities give of the derivatives."""
    held = dynamics(with_tips_turned(bound), bound.rates(), held_rules(bound))
    made = by_accelerations(held.mechanism, bound.rates(), held.w)
    torques = direct_motion(bound).Gamma_u
    right = {j: torques[j] - held.Gamma[j] for j in bound.machine.independent}
    factors = factors_of(held.mechanism, made.by_qdd)
    qdd = solution(factors, right)  # (8)
    found = accelerated(held, made, qdd)
    name_known(bound, held)
    name_by_accelerations(bound, made)
    name_factors(bound, factors, right, qdd)
    name_accelerated(bound, found)
    return found, made


def by_recursion(
    bound: Bound, found: Dynamics, outputs: Outputs, by: Variables, made: TorqueDerivatives | None = None
) -> Derivatives:
    """By composite bodies and, where accelerations of joints or of the base are to be found, linear systems."""
    by_q, by_qd, A = torque_changes(bound, found, made)
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


def torque_changes(
    bound: Bound, found: Dynamics, made: TorqueDerivatives | None = None
) -> tuple[Entries, Entries, Entries]:
    """Derivatives by q, qd and qdd of the torques that a motion asks of motors, springs and friction included.

    Rows and columns of the base are those of its wrench, its velocity and its acceleration. `made` is what velocities
    give of them, where it is known.
    """
    if made is None:
        made = torque_derivatives(found.mechanism, bound.rates(), found)
    else:
        add_motion(found.mechanism, found, made)
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
    if not _has_slides(bound):
        return solved
    return min(solved, of_graph(bound, outputs, by), key=lambda made: made.size)


def _has_slides(bound: Bound) -> bool:
    return any(link.axis is Axis.PRISMATIC for link in bound.mechanism.links)
