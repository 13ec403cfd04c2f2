"""Derivatives of the dynamic models, at the same arguments: dtau_dq is that of tau by q.

Rows follow the joints of the result, columns those of the argument or the parameters that still have a
name; where a scene names columns, these only. A sign of a velocity, in dry friction, counts as constant.
Where every joint has a motor, and for direct models, a recursion over composite bodies gives them; where
motors drive springs, the graph of the model is differentiated: nothing cancels there between stiff
springs. For slides the shorter form is used. Where no joint has a spring, the factors of the inertia matrix, which
derivatives of direct models need, give the accelerations, too. Where joints are coupled, the graph of the
model is differentiated too: derivatives are total ones, dependent variables move along.

On a floating base they are also taken by its velocity V0, by its known acceleration V0d or wrench f0, and by its
pose: a displacement d and a rotation vector r, both small and in its axes, whether its orientation is R0
or Q0: P0 + R0 d, R0 (1 + hat(r)). V0, V0d and f0 keep their components, in the axes that turn.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from symoro_elastic.foundation.scalar import Scalar
from symoro_elastic.machine.arguments import PARAMETERS
from symoro_elastic.mechanics.base_body import DEGREES
from symoro_elastic.mechanics.bias_acceleration import with_tips_in_frames_before
from symoro_elastic.mechanics.derivatives.accelerations import (
    Solve,
    changes,
    changes_by_known,
    factors_of,
    is_short,
    solving,
    solving_with_base,
    with_accelerations,
)
from symoro_elastic.mechanics.derivatives.torques import (
    Entries,
    TorqueDerivatives,
    add_base,
    add_motion,
    by_accelerations,
    by_pose,
    falling_by_pose,
    torque_derivatives,
)
from symoro_elastic.mechanics.dynamics import Dynamics, dynamics
from symoro_elastic.mechanics.factorization import solution
from symoro_elastic.mechanics.mechanism import Mechanism
from symoro_elastic.mechanics.spatial import Axis
from symoro_elastic.models.bound.bind import Bound, coordinate_inertia
from symoro_elastic.models.bound.model import MOVING, Joints, Model, Pivots, Result, Results
from symoro_elastic.models.bound.naming import (
    name_accelerated,
    name_composites,
    name_dynamics,
    name_factors,
    name_known,
)
from symoro_elastic.models.bound.rules import (
    Motion,
    base_rule,
    direct_motion,
    given_rules,
    held_rules,
    inverse_by_motors,
    inverse_motion,
)
from symoro_elastic.models.derivatives.derivative_columns import (
    Variables,
    all_columns,
    chosen_columns,
    moved_with,
    needed_columns,
    parameter_columns,
)
from symoro_elastic.models.derivatives.naming_derivatives import (
    name_acceleration_derivatives,
    name_by_accelerations,
    name_tangents,
    name_torque_derivatives,
)
from symoro_elastic.models.dynamics.floating_base import found_of_base
from symoro_elastic.quantities import derivative, quantity
from symoro_elastic.symbolic.differentiation import Differentiation, Tangents, substitute
from symoro_elastic.symbolic.expression import reachable

Outputs = Mapping[str, Mapping[int, Scalar]]
"""Entries of the results of a model, by result and joint."""
Which = tuple[str, str]
"""A derivative: names of the result and of the argument."""

OF_BASE = ("V0d", "f0")


def values_of(outputs: Outputs) -> list[Scalar]:
    """All entries of the results of a model."""
    return [x for entries in outputs.values() for x in entries.values()]


@dataclass(frozen=True)
class Derivatives:
    """Derivatives of results, by result and argument; `tangents` of named quantities, by variable."""

    entries: dict[Which, Entries]
    tangents: dict[str, Tangents] = field(default_factory=dict)

    @property
    def size(self) -> int:
        """Number of expressions in all derivatives."""
        return len(reachable(x for entries in self.entries.values() for x in entries.values()))

    def only(self, by: Variables) -> Derivatives:
        """The derivatives by the given variables only."""
        entries = {
            (result, argument): {(j, c): x for (j, c), x in entries.items() if c in by[argument]}
            for (result, argument), entries in self.entries.items()
            if argument in by
        }
        return Derivatives(entries, self.tangents)


def has_recursion(bound: Bound) -> bool:
    """Whether the recursion over composite bodies gives the derivatives.

    No joint follows another, no stiffness or wrench changes with positions, and no ball joint has a damper.
    """
    if bound.machine.forces or bound.damping_of_balls:
        return False
    varying = (bound.machine.joint(j).spring.stiffness.names for j in bound.machine.elastic)
    return not bound.machine.is_coupled and all(map(bound.machine.variables.keys().isdisjoint, varying))


def with_tips_turned(bound: Bound) -> Mechanism:
    """The mechanism with tip bodies described before the rotation of their joints, which saves operations."""
    if bound.machine.is_coupled:
        return bound.without_tip_angles
    return with_tips_in_frames_before(bound.mechanism, bound.machine.independent)


def is_solved_by_factors(bound: Bound) -> bool:
    """Whether the factors of A give the accelerations of the direct model in fewer operations than its recursion.

    Between stiff springs the factors lose digits that the recursion keeps; slides may use the recursion's graph.
    """
    machine = bound.machine
    return not (machine.degrees_of_base or machine.elastic or _has_slides(bound)) and is_short(bound.mechanism)


def solved_by_factors(bound: Bound) -> tuple[Dynamics, TorqueDerivatives]:
    """The motion under the torques, by the factors of A, and the part of the derivatives that velocities give."""
    unaccelerated = dynamics(with_tips_turned(bound), bound.rates(), held_rules(bound))
    partials = by_accelerations(unaccelerated.mechanism, bound.rates(), unaccelerated.w)
    torques = direct_motion(bound).Gamma_u
    right = {j: torques[j] - unaccelerated.Gamma[j] for j in bound.machine.independent}
    factors = factors_of(unaccelerated.mechanism, partials.by_qdd)
    qdd = solution(factors, right)  # (8)
    recursion = with_accelerations(unaccelerated, partials, qdd)
    name_known(bound, unaccelerated)
    name_by_accelerations(bound, partials)
    name_factors(bound.names, factors, right, qdd)
    name_accelerated(bound, recursion)
    return recursion, partials


def by_recursion(
    bound: Bound, recursion: Dynamics, outputs: Outputs, by: Variables, partials: TorqueDerivatives | None = None
) -> Derivatives:
    """Derivatives by composite bodies and, for unknown accelerations of joints or base, by linear systems."""
    by_q, by_qd, A = torque_changes(bound, recursion, partials)
    free, solve = unknown_accelerations(bound, A, recursion, bound.machine.independent if "qdd" in outputs else ())
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


def unknown_accelerations(bound: Bound, A: Entries, recursion: Dynamics, joints: Joints) -> tuple[Joints, Solve]:
    """Numbers of the unknown accelerations, and the solver for them."""
    solve: Solve = solving(recursion.mechanism, A, recursion) if joints else lambda right: {}
    if base_rule(bound) is None:
        return joints, solve
    return (*DEGREES, *joints), solving_with_base(A, recursion.Js[0], joints, solve)


def split_by_result(bound: Bound, table: Entries, outputs: Outputs, by: Variables) -> dict[Which, Entries]:
    """Split a table of all entries by result (rows) and argument (columns)."""
    return {
        (result, name): {(i, c): table[i, c] for i in rows for c in columns if (i, c) in table}
        for result, rows in outputs.items()
        for name, columns in by.items()
    }


def with_pose(bound: Bound, derivatives: Derivatives, outputs: Outputs) -> Derivatives:
    """The derivatives with the columns of the pose of a floating base."""
    if not bound.machine.degrees_of_base:
        return derivatives
    posed: dict[Which, Entries] = {}
    for result in outputs:
        if base_rule(bound):
            still: Entries = {(i, m): 0 for i in outputs[result] for m in DEGREES}
            posed[result, "pose"] = falling_by_pose(bound.gravity) if result == "V0d" else still
        elif (result, "V0d") in derivatives.entries:
            posed[result, "pose"] = by_pose(derivatives.entries[result, "V0d"], bound.gravity)
    return replace(derivatives, entries=derivatives.entries | posed)


def torque_changes(
    bound: Bound, recursion: Dynamics, partials: TorqueDerivatives | None = None
) -> tuple[Entries, Entries, Entries]:
    """Derivatives by q, qd and qdd of the required torques, springs and friction included.

    Rows and columns of the base are those of its wrench, its velocity and its acceleration. `made` is what velocities
    give of them, where it is known.
    """
    if partials is None:
        partials = torque_derivatives(recursion.mechanism, bound.rates(), recursion)
    else:
        add_motion(recursion.mechanism, recursion, partials)
    if bound.machine.degrees_of_base:
        add_base(partials, recursion.w[0])
    name_torque_derivatives(bound, partials)
    by_q, by_qd = dict(partials.by_q), dict(partials.by_qd)
    for m, damping in zip(DEGREES, bound.cells(bound.machine.damping_of_base), strict=False):
        by_qd[m, m] = by_qd.get((m, m), 0) + damping
    for j in bound.machine.independent:
        spring = bound.spring_of(j)
        by_q[j, j] = by_q[j, j] + spring.change(bound.rate(j))
        by_qd[j, j] = by_qd[j, j] + bound.friction_slope(j) + spring.damper
    return by_q, by_qd, partials.by_qdd


def of_graph(bound: Bound, outputs: Outputs, by: Variables) -> Derivatives:
    """Total derivatives by differentiating the graph of a model (L42)."""
    graph = Differentiation(values_of(outputs))
    derivatives = Derivatives({(result, name): {} for result in outputs for name in by})
    for name, variables in by.items():
        for c, variable in variables.items():
            derivatives.tangents[variable.operands[0]] = tangents = graph.along(moved_with(bound, name, c, variable))
            for result, entries in outputs.items():
                derivatives.entries[result, name] |= {(j, c): tangents.of(x) for j, x in entries.items()}
    return derivatives


def shorter_way(bound: Bound, solved: Derivatives, outputs: Outputs, by: Variables) -> Derivatives:
    """The shorter of two sets of derivatives, `solved` or those of the graph; always `solved` without slides."""
    if not _has_slides(bound):
        return solved
    return min(solved, of_graph(bound, outputs, by), key=lambda way: way.size)


def _has_slides(bound: Bound) -> bool:
    return any(link.axis is Axis.PRISMATIC for link in bound.mechanism.links)


@dataclass(frozen=True)
class Solved:
    """A motion and its dynamics, solved for accelerations and forces."""

    motion: Motion
    found: Dynamics

    @property
    def accelerations(self) -> dict[int, Scalar]:
        """Accelerations of the independent variables."""
        return self.motion.accelerations(self.found)


def _inverse_dynamics_derivatives(bound: Bound, requested: Joints) -> Results:
    by = all_columns(bound, {"qdd_motor": bound.qdd_motor})
    if len(bound.motors) == len(bound.machine.independent) and has_recursion(bound):
        solved = _inverse(bound)
        outputs = _inverse_outputs(bound, solved)
        derivatives = by_recursion(bound, solved.found, outputs, by)
    else:
        columns, outputs = needed_columns(bound, by), _outputs_of_inverse(bound)
        derivatives = of_graph(bound, outputs, columns)
        if "qdd_motor" in columns and _motors_are_independent(bound):
            lower = derivatives.entries["tau", "qdd_motor"]
            derivatives.entries["tau", "qdd_motor"] = {(i, j): lower[max(i, j), min(i, j)] for i, j in lower}
    return _results(bound, with_pose(bound, derivatives, outputs), requested, chosen_columns(bound, by))


def _direct_dynamics_derivatives(bound: Bound, requested: Joints) -> Results:
    by = all_columns(bound, {"tau": bound.tau})
    if has_recursion(bound) and is_solved_by_factors(bound):
        recursion, partials = solved_by_factors(bound)
        by_factors = by_recursion(bound, recursion, {"qdd": recursion.qdd}, by, partials)
        return _results(bound, by_factors, requested, chosen_columns(bound, by))
    solved = _direct(bound)
    outputs, columns = _direct_outputs(bound, solved), needed_columns(bound, by)
    if has_recursion(bound):
        derivatives = shorter_way(bound, by_recursion(bound, solved.found, outputs, by).only(columns), outputs, columns)
    else:
        derivatives = of_graph(bound, outputs, columns)
    return _results(bound, with_pose(bound, derivatives, outputs), requested, chosen_columns(bound, by))


def _inverse_dynamics_parameter_derivatives(bound: Bound, requested: Joints) -> Results:
    outputs = _outputs_of_inverse(bound)
    by = parameter_columns(bound, values_of(outputs))
    return _results(bound, of_graph(bound, outputs, by), requested, by)


def _direct_dynamics_parameter_derivatives(bound: Bound, requested: Joints) -> Results:
    direct = _direct(bound)
    recursion, outputs = direct.found, _direct_outputs(bound, direct)
    by = parameter_columns(bound, values_of(outputs))
    if not has_recursion(bound):
        return _results(bound, of_graph(bound, outputs, by), requested, by)
    inverse = dynamics(bound.mechanism, bound.rates(), given_rules(bound))
    torques = {j: inverse.Gamma[j] - bound.exerted_torque(j) for j in bound.machine.independent}
    torques |= zip(DEGREES, inverse.f[0].entries, strict=True) if bound.machine.degrees_of_base else ()
    symbols = {x.operands[0]: recursion.qdd[j] for j, x in bound.qdd.items()}
    if base_rule(bound):
        symbols |= zip(quantity("V0d").entries, outputs["V0d"].values(), strict=True)
    A = torque_changes(bound, recursion)[2]
    free, solve = unknown_accelerations(bound, A, recursion, bound.machine.independent)
    graph = of_graph(bound, {"torques": torques}, by).entries["torques", PARAMETERS]
    right: Entries = {}
    for c in by[PARAMETERS]:
        column = substitute(bound.graph, [graph[i, c] for i in torques], symbols)
        right |= {(i, c): x for i, x in zip(torques, column, strict=True)}
    solved = split_by_result(
        bound, changes(right, A, tuple(torques), free, solve), outputs, {PARAMETERS: by[PARAMETERS]}
    )
    return _results(bound, shorter_way(bound, Derivatives(solved), outputs, by), requested, by)


def _inverse(bound: Bound) -> Solved:
    motion = inverse_motion(bound)
    recursion = motion.dynamics_of(with_tips_turned(bound))
    name_dynamics(bound, recursion, "[50]-[56]", "[57]-[61]")
    return Solved(motion, recursion)


def _direct(bound: Bound) -> Solved:
    motion = direct_motion(bound)
    recursion = motion.dynamics_of(bound.without_tip_angles)
    name_dynamics(bound, recursion, "[28]-[32]", "[33]-[36]")
    return Solved(motion, recursion)


def _motors_are_independent(bound: Bound) -> bool:
    return all(j in bound.machine.independent for j in bound.motors)


def _outputs_of_inverse(bound: Bound) -> Outputs:
    """Results of the inverse model; on a machine with motors on dependent joints by a linear system (L30)."""
    if _motors_are_independent(bound):
        return _inverse_outputs(bound, _inverse(bound))
    driven = inverse_by_motors(bound)
    free = [j for j in bound.machine.independent if j not in bound.motors]
    return {"tau": driven.tau, **({"qdd": {j: driven.udd[j] for j in free}} if free else {})}


def _inverse_outputs(bound: Bound, solved: Solved) -> Outputs:
    free = [j for j in bound.machine.independent if j not in bound.motors]
    needed, passive, udd = solved.motion.forces(solved.found), bound.passive_forces(), solved.accelerations
    tau = {j: needed[j] - passive[j] for j in bound.motors}
    qdd = {"qdd": {j: udd[j] for j in free}} if free else {}
    return {"tau": tau, **qdd, **_base_outputs(bound, solved.found)}


def _direct_outputs(bound: Bound, solved: Solved) -> Outputs:
    return {"qdd": solved.accelerations, **_base_outputs(bound, solved.found)}


def _base_outputs(bound: Bound, recursion: Dynamics) -> Outputs:
    results = found_of_base(bound, recursion).items()
    return {name: dict(zip(DEGREES, result.entries, strict=True)) for name, result in results}


def _results(bound: Bound, derivatives: Derivatives, requested: Joints, by: Variables) -> Results:
    """The derivatives for the requested joints as named results of the model."""
    name_tangents(bound, derivatives.tangents)
    derivatives = derivatives.only(by)
    name_acceleration_derivatives(bound, derivatives.entries)
    joints = bound.machine.with_variable if requested == bound.machine.independent else requested
    results: Results = {}
    for of in dict.fromkeys(result for result, _ in derivatives.entries):
        by_argument = {x: derivatives.entries[of, x] for x in by if (of, x) in derivatives.entries}
        numbers = {i for entries in by_argument.values() for i, _ in entries}
        rows = tuple(DEGREES) if of in OF_BASE else tuple(j for j in joints if j in numbers)
        for argument, entries in by_argument.items():
            values = tuple(entries.get((i, c), 0) for i in rows for c in by[argument])
            labels = tuple(x.operands[0] for x in by[argument].values()) if bound.by or argument == PARAMETERS else ()
            size = (len(by[argument]),)
            where, shape = (None, (6, *size)) if of in OF_BASE else (rows, size)
            results[f"d{of}_d{argument}"] = Result(where, values, shape, column_labels=labels)
    return results


# The linear model of small motions about any motion: M dqdd + D dqd + K dq = dtau.
#
# K and D are derivatives of the forces required on the independent variables: S^T NE less springs, dampers,
# friction and motors. Where joints are coupled these are total derivatives: S and gam move along, so that K holds the
# tangent stiffness of the constraint forces (L40).
def _linearization(bound: Bound, rows: Joints) -> Results:
    """M, D, K of M dqdd + D dqd + K dq = dtau along any motion, springs and friction included."""
    by_q, by_qd, by_qdd = _by_recursion(bound) if has_recursion(bound) else _of_graph(bound)
    independent = bound.machine.independent
    return {
        name: Result(rows, tuple(entries.get((i, c), 0) for i in rows for c in independent), (len(independent),))
        for name, entries in (("M", by_qdd), ("D", by_qd), ("K", by_q))
    }


def _by_recursion(bound: Bound) -> tuple[Entries, Entries, Entries]:
    return torque_changes(bound, dynamics(with_tips_turned(bound), bound.rates(), given_rules(bound)))


def _of_graph(bound: Bound) -> tuple[Entries, Entries, Entries]:
    """Matrices K, D and M of the linearization from the graph: residual forces, and M = S^T A S (L38), (L40)."""
    residual = {"forces": residual_forces(bound)}
    derivatives = of_graph(bound, residual, {"q": bound.q, "qd": bound.qd}).entries
    matrix = coordinate_inertia(bound)
    name_composites(bound, matrix)
    M = {(i, j): matrix.A[i][j] for i in bound.machine.independent for j in bound.machine.independent}
    return derivatives["forces", "q"], derivatives["forces", "qd"], M


def residual_forces(bound: Bound) -> dict[int, Scalar]:
    """S^T NE (L20) less all forces on the independent variables, which is zero along a motion.

    Torques of motors on dependent joints are in K, since S moves.
    """
    recursion = dynamics(bound.without_tip_angles, bound.rates(), given_rules(bound))
    name_dynamics(bound, recursion, "[15]", "[61]")
    needed, exerted = bound.on_independent(recursion.Gamma), bound.exerted_forces()
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
        has_loop_forces=True,
    ),
)
