"""The linear model of small motions about any motion: M dqdd + D dqd + K dq = dtau.

K and D are derivatives of the forces that the motion asks of the independent variables: S^T NE less springs, dampers,
friction and motors. Where joints are coupled these are total derivatives: S and gam move along, so that K holds the
tangent stiffness of the constraint forces (L40).
"""

from __future__ import annotations

from symoro_elastic.mechanics.derivatives.torques import Entries
from symoro_elastic.mechanics.dynamics import dynamics
from symoro_elastic.models.bind import Bound
from symoro_elastic.models.coordinate_inertia import coordinate_inertia
from symoro_elastic.models.derivative_ways import has_recursion, of_graph, torque_changes
from symoro_elastic.models.model import Joints, Model, Result, Results
from symoro_elastic.models.naming import name_composites, name_dynamics
from symoro_elastic.scalar import Scalar

FAMILY = "derivatives"


def _linearization(bound: Bound, asked: Joints) -> Results:
    """M, D, K of M dqdd + D dqd + K dq = dtau along any motion, springs and friction included."""
    by_q, by_qd, by_qdd = _by_recursion(bound) if has_recursion(bound) else _of_graph(bound)
    moving = bound.machine.moving
    return {
        name: Result(asked, tuple(entries.get((i, c), 0) for i in asked for c in moving), (len(moving),))
        for name, entries in (("M", by_qdd), ("D", by_qd), ("K", by_q))
    }


def _by_recursion(bound: Bound) -> tuple[Entries, Entries, Entries]:
    return torque_changes(bound, dynamics(bound.mechanism, bound.rates(), bound.given_rules()))


def _of_graph(bound: Bound) -> tuple[Entries, Entries, Entries]:
    """K, D of the forces that are left, and M = S^T A S (L38), (L40)."""
    left = {"forces": forces_left(bound)}
    made = of_graph(bound, left, {"dq": bound.q, "dqd": bound.qd}).entries
    matrix = coordinate_inertia(bound)
    name_composites(bound, matrix)
    M = {(i, j): matrix.A[i][j] for i in bound.machine.moving for j in bound.machine.moving}
    return made["dforces_dq"], made["dforces_dqd"], M


def forces_left(bound: Bound) -> dict[int, Scalar]:
    """What is left of S^T NE (L20) less all that is exerted on the independent variables: zero along a motion.

    Torques of motors on dependent joints are in K, since S moves.
    """
    found = dynamics(bound.without_tip_angles, bound.rates(), bound.given_rules())
    name_dynamics(bound, found, "[15]", "[61]")
    needed, exerted = bound.on_independent(found.Gamma), bound.exerted_forces()
    return {j: needed[j] - exerted[j] for j in bound.machine.moving}


LINEARIZATION = Model(
    "linearization",
    "linear model of small motions about a given one: M dqdd + D dqd + K dq = dtau",
    "[8], [12]-[15]",
    ("q", "qd", "qdd"),
    ("M", "D", "K"),
    _linearization,
    FAMILY,
    has_loop_forces=True,
)
