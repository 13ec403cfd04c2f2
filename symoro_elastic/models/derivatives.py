"""Derivatives of the dynamic models, at the same arguments: dtau_dq is that of tau by q.

Rows follow the joints of the result, columns those of the argument or the parameters that still have a
name; where a scene names columns, these only. A sign of a velocity, in dry friction, counts as constant.
Where every joint has a motor, and for direct models, a recursion over composite bodies gives them; where
motors drive springs, the graph of the model is differentiated: nothing cancels there between stiff
springs. Slides take the shorter way. Where no joint has a spring, the factors of the inertia matrix, which
derivatives of direct models need, give the accelerations, too. Where joints are coupled, the graph of the
model is differentiated too: derivatives are total ones, dependent variables move along.

On a base that moves freely they are also taken by its velocity V0, by what is known of it, V0d or f0, and by its
pose: a displacement d and a rotation vector r, both small and in its axes, whether R0 or Q0 tells how it
is turned: P0 + R0 d, R0 (1 + hat(r)). V0, V0d and f0 keep their components, in the axes that turn.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from symoro_elastic.foundation.scalar import Scalar
from symoro_elastic.machine.arguments import PARAMETERS
from symoro_elastic.mechanics.base_body import DEGREES
from symoro_elastic.mechanics.derivatives.accelerations import changes
from symoro_elastic.mechanics.derivatives.torques import Entries
from symoro_elastic.mechanics.dynamics import Dynamics, dynamics
from symoro_elastic.models.bind import Bound
from symoro_elastic.models.coordinate_inertia import coordinate_inertia
from symoro_elastic.models.derivative_columns import (
    Variables,
    all_columns,
    chosen_columns,
    needed_columns,
    parameter_columns,
)
from symoro_elastic.models.derivative_ways import (
    Derivatives,
    Outputs,
    by_recursion,
    has_recursion,
    is_solved_by_factors,
    of_graph,
    shorter_way,
    solved_by_factors,
    split_by_result,
    torque_changes,
    unknown_accelerations,
    values_of,
    with_pose,
    with_tips_turned,
)
from symoro_elastic.models.driving import inverse_by_motors
from symoro_elastic.models.floating_base import found_of_base
from symoro_elastic.models.model import MOVING, Joints, Model, Pivots, Result, Results
from symoro_elastic.models.naming import name_composites, name_dynamics
from symoro_elastic.models.naming_derivatives import name_acceleration_derivatives, name_tangents
from symoro_elastic.models.rules import Motion, base_rule, direct_motion, given_rules, inverse_motion
from symoro_elastic.quantities import derivative, quantity
from symoro_elastic.symbolic.differentiation import substitute

FAMILY = "derivatives"

OF_BASE = ("V0d", "f0")


@dataclass(frozen=True)
class Solved:
    """A motion and the dynamics that it has."""

    motion: Motion
    found: Dynamics

    @property
    def accelerations(self) -> dict[int, Scalar]:
        """Accelerations of the independent variables."""
        return self.motion.accelerations(self.found)


def _inverse_dynamics_derivatives(bound: Bound, asked: Joints) -> Results:
    by = all_columns(bound, {"qdd_motor": bound.qdd_motor})
    if len(bound.motors) == len(bound.machine.independent) and has_recursion(bound):
        solved = _inverse(bound)
        outputs = _inverse_outputs(bound, solved)
        made = by_recursion(bound, solved.found, outputs, by)
    else:
        columns, outputs = needed_columns(bound, by), _found_by_inverse(bound)
        made = of_graph(bound, outputs, columns)
        if "qdd_motor" in columns and _motors_are_independent(bound):
            made.entries["tau", "qdd_motor"] = _mirrored(made.entries["tau", "qdd_motor"])
    return _results(bound, with_pose(bound, made, outputs), asked, chosen_columns(bound, by))


def _direct_dynamics_derivatives(bound: Bound, asked: Joints) -> Results:
    by = all_columns(bound, {"tau": bound.tau})
    if has_recursion(bound) and is_solved_by_factors(bound):
        found, known = solved_by_factors(bound)
        by_factors = by_recursion(bound, found, {"qdd": found.qdd}, by, known)
        return _results(bound, by_factors, asked, chosen_columns(bound, by))
    solved = _direct(bound)
    outputs, columns = _direct_outputs(bound, solved), needed_columns(bound, by)
    if has_recursion(bound):
        made = shorter_way(bound, by_recursion(bound, solved.found, outputs, by).only(columns), outputs, columns)
    else:
        made = of_graph(bound, outputs, columns)
    return _results(bound, with_pose(bound, made, outputs), asked, chosen_columns(bound, by))


def _inverse_dynamics_parameter_derivatives(bound: Bound, asked: Joints) -> Results:
    outputs = _found_by_inverse(bound)
    by = parameter_columns(bound, values_of(outputs))
    return _results(bound, of_graph(bound, outputs, by), asked, by)


def _direct_dynamics_parameter_derivatives(bound: Bound, asked: Joints) -> Results:
    direct = _direct(bound)
    found, outputs = direct.found, _direct_outputs(bound, direct)
    by = parameter_columns(bound, values_of(outputs))
    if not has_recursion(bound):
        return _results(bound, of_graph(bound, outputs, by), asked, by)
    given = dynamics(bound.mechanism, bound.rates(), given_rules(bound))
    torques = {j: given.Gamma[j] - bound.exerted_torque(j) for j in bound.machine.independent}
    torques |= zip(DEGREES, given.f[0].entries, strict=True) if bound.machine.degrees_of_base else ()
    symbols = {x.operands[0]: found.qdd[j] for j, x in bound.qdd.items()}
    if base_rule(bound):
        symbols |= zip(quantity("V0d").entries, outputs["V0d"].values(), strict=True)
    A = torque_changes(bound, found)[2]
    free, solve = unknown_accelerations(bound, A, found, bound.machine.independent)
    graph = of_graph(bound, {"torques": torques}, by).entries["torques", PARAMETERS]
    right: Entries = {}
    for c in by[PARAMETERS]:
        column = substitute(bound.graph, [graph[i, c] for i in torques], symbols)
        right |= {(i, c): x for i, x in zip(torques, column, strict=True)}
    solved = split_by_result(
        bound, changes(right, A, tuple(torques), free, solve), outputs, {PARAMETERS: by[PARAMETERS]}
    )
    return _results(bound, shorter_way(bound, Derivatives(solved), outputs, by), asked, by)


def _inverse(bound: Bound) -> Solved:
    motion = inverse_motion(bound)
    found = motion.dynamics_of(with_tips_turned(bound))
    name_dynamics(bound, found, "[50]-[56]", "[57]-[61]")
    return Solved(motion, found)


def _direct(bound: Bound) -> Solved:
    motion = direct_motion(bound)
    found = motion.dynamics_of(bound.without_tip_angles)
    name_dynamics(bound, found, "[28]-[32]", "[33]-[36]")
    return Solved(motion, found)


def _motors_are_independent(bound: Bound) -> bool:
    return all(j in bound.machine.independent for j in bound.motors)


def _found_by_inverse(bound: Bound) -> Outputs:
    """Results of the inverse model; on a machine with motors on dependent joints by a linear system (L30)."""
    if _motors_are_independent(bound):
        return _inverse_outputs(bound, _inverse(bound))
    found = inverse_by_motors(bound)
    free = [j for j in bound.machine.independent if j not in bound.motors]
    return {"tau": found.tau, **({"qdd": {j: found.udd[j] for j in free}} if free else {})}


def _inverse_outputs(bound: Bound, solved: Solved) -> Outputs:
    free = [j for j in bound.machine.independent if j not in bound.motors]
    needed, passive, udd = solved.motion.forces(solved.found), bound.passive_forces(), solved.accelerations
    tau = {j: needed[j] - passive[j] for j in bound.motors}
    qdd = {"qdd": {j: udd[j] for j in free}} if free else {}
    return {"tau": tau, **qdd, **_base_outputs(bound, solved.found)}


def _direct_outputs(bound: Bound, solved: Solved) -> Outputs:
    return {"qdd": solved.accelerations, **_base_outputs(bound, solved.found)}


def _base_outputs(bound: Bound, found: Dynamics) -> Outputs:
    results = found_of_base(bound, found).items()
    return {name: dict(zip(DEGREES, result.entries, strict=True)) for name, result in results}


def _mirrored(symmetric: Entries) -> Entries:
    """One triangle, twice."""
    return {(i, j): symmetric[max(i, j), min(i, j)] for i, j in symmetric}


def _results(bound: Bound, made: Derivatives, asked: Joints, by: Variables) -> Results:
    """The entries of the requested joints, named."""
    name_tangents(bound, made.tangents)
    made = made.only(by)
    name_acceleration_derivatives(bound, made.entries)
    joints = bound.machine.with_variable if asked == bound.machine.independent else asked
    results: Results = {}
    for of in dict.fromkeys(result for result, _ in made.entries):
        found = {argument: made.entries[of, argument] for argument in by if (of, argument) in made.entries}
        numbers = {i for entries in found.values() for i, _ in entries}
        rows = tuple(DEGREES) if of in OF_BASE else tuple(j for j in joints if j in numbers)
        for argument, entries in found.items():
            values = tuple(entries.get((i, c), 0) for i in rows for c in by[argument])
            labels = tuple(x.operands[0] for x in by[argument].values()) if bound.by or argument == PARAMETERS else ()
            size = (len(by[argument]),)
            where, shape = (None, (6, *size)) if of in OF_BASE else (rows, size)
            results[f"d{of}_d{argument}"] = Result(where, values, shape, column_labels=labels)
    return results


# The linear model of small motions about any motion: M dqdd + D dqd + K dq = dtau.
#
# K and D are derivatives of the forces that the motion asks of the independent variables: S^T NE less springs, dampers,
# friction and motors. Where joints are coupled these are total derivatives: S and gam move along, so that K holds the
# tangent stiffness of the constraint forces (L40).
def _linearization(bound: Bound, asked: Joints) -> Results:
    """M, D, K of M dqdd + D dqd + K dq = dtau along any motion, springs and friction included."""
    by_q, by_qd, by_qdd = _by_recursion(bound) if has_recursion(bound) else _of_graph(bound)
    independent = bound.machine.independent
    return {
        name: Result(asked, tuple(entries.get((i, c), 0) for i in asked for c in independent), (len(independent),))
        for name, entries in (("M", by_qdd), ("D", by_qd), ("K", by_q))
    }


def _by_recursion(bound: Bound) -> tuple[Entries, Entries, Entries]:
    return torque_changes(bound, dynamics(with_tips_turned(bound), bound.rates(), given_rules(bound)))


def _of_graph(bound: Bound) -> tuple[Entries, Entries, Entries]:
    """K, D of the forces that are left, and M = S^T A S (L38), (L40)."""
    left = {"forces": forces_left(bound)}
    made = of_graph(bound, left, {"q": bound.q, "qd": bound.qd}).entries
    matrix = coordinate_inertia(bound)
    name_composites(bound, matrix)
    M = {(i, j): matrix.A[i][j] for i in bound.machine.independent for j in bound.machine.independent}
    return made["forces", "q"], made["forces", "qd"], M


def forces_left(bound: Bound) -> dict[int, Scalar]:
    """What is left of S^T NE (L20) less all that is exerted on the independent variables: zero along a motion.

    Torques of motors on dependent joints are in K, since S moves.
    """
    found = dynamics(bound.without_tip_angles, bound.rates(), given_rules(bound))
    name_dynamics(bound, found, "[15]", "[61]")
    needed, exerted = bound.on_independent(found.Gamma), bound.exerted_forces()
    return {j: needed[j] - exerted[j] for j in bound.machine.independent}


_INVERSE, _DIRECT = ("q", "qd", "qdd_motor"), ("q", "qd", "tau")
_OF_OTHERS = replace(quantity("qdd"), plural="accelerations of elastic and passive joints", shape="(n - m)")
DERIVATIVES = (
    Model(
        "inverse_dynamics_derivatives",
        "derivatives of the inverse dynamic model",
        "[37]-[61]",
        _INVERSE,
        ("dtau_dq", "dtau_dqd", "dtau_dqdd_motor", "dqdd_dq", "dqdd_dqd", "dqdd_dqdd_motor"),
        _inverse_dynamics_derivatives,
        FAMILY,
        own=(
            _OF_OTHERS,
            derivative(quantity("tau"), quantity("q"), ", springs and friction included"),
            derivative(quantity("tau"), quantity("qdd_motor"), ": the inertia matrix where every joint has a motor"),
        ),
        columns=_INVERSE,
        on_base=MOVING,
        pivots=Pivots.WITHOUT_MOTOR,
    ),
    Model(
        "direct_dynamics_derivatives",
        "derivatives of the direct dynamic model",
        "[8], [12]-[36]",
        _DIRECT,
        ("dqdd_dq", "dqdd_dqd", "dqdd_dtau"),
        _direct_dynamics_derivatives,
        FAMILY,
        own=(derivative(quantity("qdd"), quantity("tau"), ": columns of the inverse of the inertia matrix"),),
        columns=_DIRECT,
        on_base=MOVING,
        pivots=Pivots.ALL,
    ),
    Model(
        "inverse_dynamics_parameter_derivatives",
        "derivatives of the inverse dynamic model by the parameters",
        "[37]-[61]",
        _INVERSE,
        ("dtau_dp", "dqdd_dp"),
        _inverse_dynamics_parameter_derivatives,
        FAMILY,
        own=(_OF_OTHERS,),
        columns=(PARAMETERS,),
        on_base=MOVING,
        pivots=Pivots.WITHOUT_MOTOR,
    ),
    Model(
        "direct_dynamics_parameter_derivatives",
        "derivatives of the direct dynamic model by the parameters",
        "[8], [12]-[36]",
        _DIRECT,
        ("dqdd_dp",),
        _direct_dynamics_parameter_derivatives,
        FAMILY,
        columns=(PARAMETERS,),
        on_base=MOVING,
        pivots=Pivots.ALL,
    ),
    Model(
        "linearization",
        "linear model of small motions about a given one: M dqdd + D dqd + K dq = dtau",
        "[8], [12]-[15]",
        ("q", "qd", "qdd"),
        ("M", "D", "K"),
        _linearization,
        FAMILY,
        has_loop_forces=True,
    ),
)
