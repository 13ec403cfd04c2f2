"""Derivatives of the dynamic models, at the same arguments: dtau_dq is that of tau by q.

Rows follow the joints of the result, columns those of the argument or the parameters that still have a
name; where a scene names columns, these only. A sign of a velocity, in dry friction, counts as constant.
Where every joint has a motor, and for direct models, a recursion over composite bodies gives them; where
motors drive springs, the graph of the model is differentiated: nothing cancels there between stiff
springs. Slides take the shorter way. Where joints are coupled, the graph of the model is differentiated too:
derivatives are total ones, dependent variables move along.

On a floating base they are also taken by its velocity V0, by what is known of it, V0d or f0, and by its
pose: a displacement d and a rotation vector r, both small and in its axes, whether R0 or Q0 tells how it
is turned: P0 + R0 d, R0 (1 + hat(r)). V0, V0d and f0 keep their components, in the axes that turn.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from symoro_elastic.machine.arguments import PARAMETERS
from symoro_elastic.mechanics.derivatives.accelerations import changes
from symoro_elastic.mechanics.derivatives.torques import Entries
from symoro_elastic.mechanics.dynamics import Dynamics, dynamics
from symoro_elastic.mechanics.floating_base import DEGREES
from symoro_elastic.models.bind import Bound
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
    of_graph,
    shorter_way,
    split_by_result,
    torque_changes,
    unknown_accelerations,
    values_of,
    with_pose,
)
from symoro_elastic.models.driving import inverse_by_motors
from symoro_elastic.models.floating_base import found_of_base
from symoro_elastic.models.linearization import FAMILY, LINEARIZATION
from symoro_elastic.models.model import MOVING, Joints, Model, Pivots, Result, Results
from symoro_elastic.models.naming import name_dynamics
from symoro_elastic.models.naming_derivatives import name_acceleration_derivatives, name_tangents
from symoro_elastic.models.rules import Motion
from symoro_elastic.quantities import derivative, quantity
from symoro_elastic.scalar import Scalar
from symoro_elastic.symbolic.differentiation import substituted

OF_BASE = ("dV0d", "df0")


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
    by = all_columns(bound, {"dqdd_motor": bound.qdd_motor})
    if len(bound.motors) == len(bound.machine.moving) and has_recursion(bound):
        solved = _inverse(bound)
        outputs = _inverse_outputs(bound, solved)
        made = by_recursion(bound, solved.found, outputs, by)
    else:
        columns, outputs = needed_columns(bound, by), _found_by_inverse(bound)
        made = of_graph(bound, outputs, columns)
        if "dqdd_motor" in columns and _motors_are_independent(bound):
            made.entries["dtau_dqdd_motor"] = _mirrored(made.entries["dtau_dqdd_motor"])
    return _results(bound, with_pose(bound, made, outputs), asked, chosen_columns(bound, by))


def _direct_dynamics_derivatives(bound: Bound, asked: Joints) -> Results:
    solved, by = _direct(bound), all_columns(bound, {"dtau": bound.tau})
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
    given = dynamics(bound.mechanism, bound.rates(), bound.given_rules())
    torques = {j: given.Gamma[j] - bound.exerted(j) for j in bound.machine.moving}
    torques |= zip(DEGREES, given.f[0].entries, strict=True) if bound.machine.floating else ()
    symbols = {x.operands[0]: found.qdd[j] for j, x in bound.qdd.items()}
    if bound.base_rule:
        symbols |= zip(quantity("V0d").entries, outputs["V0d"].values(), strict=True)
    A = torque_changes(bound, found)[2]
    free, solve = unknown_accelerations(bound, A, found, bound.machine.moving)
    graph = of_graph(bound, {"torques": torques}, by).entries["dtorques_dp"]
    right: Entries = {}
    for c in by["dp"]:
        column = substituted(bound.graph, [graph[i, c] for i in torques], symbols)
        right |= {(i, c): x for i, x in zip(torques, column, strict=True)}
    solved = split_by_result(bound, changes(right, A, tuple(torques), free, solve), outputs, {"dp": by["dp"]})
    return _results(bound, shorter_way(bound, Derivatives(solved), outputs, by), asked, by)


def _inverse(bound: Bound) -> Solved:
    motion = bound.inverse_motion()
    found = motion.solved(bound.without_tip_angles)
    name_dynamics(bound, found, "[50]-[56]", "[57]-[61]")
    return Solved(motion, found)


def _direct(bound: Bound) -> Solved:
    motion = bound.direct_motion()
    found = motion.solved(bound.without_tip_angles)
    name_dynamics(bound, found, "[28]-[32]", "[33]-[36]")
    return Solved(motion, found)


def _motors_are_independent(bound: Bound) -> bool:
    return all(j in bound.machine.moving for j in bound.motors)


def _found_by_inverse(bound: Bound) -> Outputs:
    """Results of the inverse model; on a machine with motors on dependent joints by a linear system (L30)."""
    if _motors_are_independent(bound):
        return _inverse_outputs(bound, _inverse(bound))
    found = inverse_by_motors(bound)
    free = [j for j in bound.machine.moving if j not in bound.motors]
    return {"tau": found.tau, **({"qdd": {j: found.udd[j] for j in free}} if free else {})}


def _inverse_outputs(bound: Bound, solved: Solved) -> Outputs:
    free = [j for j in bound.machine.moving if j not in bound.motors]
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
    """The entries of the joints that are asked for, named."""
    name_tangents(bound, made.tangents)
    made = made.only(by)
    name_acceleration_derivatives(bound, made.entries)
    joints = bound.machine.owners if asked == bound.machine.moving else asked
    results: Results = {}
    for of in dict.fromkeys(name.partition("_")[0] for name in made.entries):
        found = {argument: made.entries[f"{of}_{argument}"] for argument in by if f"{of}_{argument}" in made.entries}
        numbers = {i for entries in found.values() for i, _ in entries}
        rows = tuple(DEGREES) if of in OF_BASE else tuple(j for j in joints if j in numbers)
        for argument, entries in found.items():
            values = tuple(entries.get((i, c), 0) for i in rows for c in by[argument])
            labels = tuple(x.operands[0] for x in by[argument].values()) if bound.by or argument == "dp" else ()
            size = (len(by[argument]),)
            where, shape = (None, (6, *size)) if of in OF_BASE else (rows, size)
            results[f"{of}_{argument}"] = Result(where, values, shape, column_labels=labels)
    return results


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
    LINEARIZATION,
)
