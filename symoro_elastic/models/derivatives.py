"""Derivatives of the dynamic models, at the same arguments: dtau_dq is that of tau by q.

Rows follow the joints of the result, columns those of the argument or the parameters that still have a
name; where a scene names columns, these only. A sign of a velocity, in dry friction, counts as constant.
Where every joint has a motor, and for direct models, a recursion over composite bodies gives them; where
motors drive springs, the graph of the model is differentiated: nothing cancels there between stiff
springs. Slides take the shorter way.

On a floating base they are also taken by its velocity V0, by what is known of it, V0d or f0, and by its
pose: a displacement d and a rotation vector r, both small and in its axes, whether R0 or Q0 tells how it
is turned: P0 + R0 d, R0 (1 + hat(r)). V0, V0d and f0 keep their components, in the axes that turn.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from symoro_elastic.equations.derivatives.accelerations import (
    Solve,
    changes,
    changes_by_known,
    solving,
    solving_with_base,
)
from symoro_elastic.equations.derivatives.base import add_base, by_pose, falling_by_pose
from symoro_elastic.equations.derivatives.torques import Entries, torque_derivatives
from symoro_elastic.equations.dynamics import Dynamics, dynamics
from symoro_elastic.equations.floating_base import DEGREES
from symoro_elastic.equations.spatial import Axis
from symoro_elastic.errors import InputError
from symoro_elastic.machine.arguments import PARAMETERS, arguments, columns_of_base
from symoro_elastic.models.bind import Bound
from symoro_elastic.models.floating_base import found_of_base
from symoro_elastic.models.model import MOVING, Joints, Model, Pivots, Result, Results
from symoro_elastic.models.naming import name_dynamics
from symoro_elastic.models.naming_derivatives import (
    name_acceleration_derivatives,
    name_tangents,
    name_torque_derivatives,
)
from symoro_elastic.models.rules import Motion
from symoro_elastic.quantities import derivative, quantity
from symoro_elastic.scalar import Scalar
from symoro_elastic.symbolic.differentiation import Differentiation, Tangents, substituted
from symoro_elastic.symbolic.expression import Expression, Level, reachable
from symoro_elastic.symbolic.operations import SYMBOL

Outputs = Mapping[str, Mapping[int, Scalar]]
"""Entries of each result of a model, by joint."""
Variables = Mapping[str, Mapping[int, Expression]]
"""What is differentiated by, array by array, by joint, degree of freedom of the base or number of the parameter."""
OF_BASE = ("dV0d", "df0")


@dataclass(frozen=True)
class Derivatives:
    """Entries of each derivative, as `dqdd_dq`; those of quantities on the way, by name of the variable."""

    entries: dict[str, Entries]
    tangents: dict[str, Tangents] = field(default_factory=dict)

    @property
    def size(self) -> int:
        """Expressions that they need."""
        return len(reachable(x for entries in self.entries.values() for x in entries.values()))

    def only(self, by: Variables) -> Derivatives:
        """The columns of these variables."""
        kept = {name: by[argument] for name in self.entries if (argument := name.partition("_")[2]) in by}
        entries = {
            name: {(j, c): x for (j, c), x in self.entries[name].items() if c in columns}
            for name, columns in kept.items()
        }
        return Derivatives(entries, self.tangents)


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
    solved, by = _inverse(bound), _variables(bound, {"dqdd_motor": bound.qdd_motor})
    outputs = _inverse_outputs(bound, solved)
    if len(bound.motors) == len(bound.machine.moving) and not bound.machine.is_coupled:
        made = _by_recursion(bound, solved.found, outputs, by)
    else:
        needed = _needed(bound, by)
        made = _of_graph(outputs, needed)
        if "dqdd_motor" in needed:
            made.entries["dtau_dqdd_motor"] = _mirrored(made.entries["dtau_dqdd_motor"])
    return _results(bound, _posed(bound, made, outputs), asked, _chosen(bound, by))


def _direct_dynamics_derivatives(bound: Bound, asked: Joints) -> Results:
    solved, by = _direct(bound), _variables(bound, {"dtau": bound.tau})
    outputs, needed = _direct_outputs(bound, solved), _needed(bound, by)
    if bound.machine.is_coupled:
        made = _of_graph(outputs, needed)
    else:
        made = _shorter(bound, _by_recursion(bound, solved.found, outputs, by).only(needed), outputs, needed)
    return _results(bound, _posed(bound, made, outputs), asked, _chosen(bound, by))


def _inverse_dynamics_parameter_derivatives(bound: Bound, asked: Joints) -> Results:
    outputs = _inverse_outputs(bound, _inverse(bound))
    by = _parameters(bound, outputs)
    return _results(bound, _of_graph(outputs, by), asked, by)


def _direct_dynamics_parameter_derivatives(bound: Bound, asked: Joints) -> Results:
    direct = _direct(bound)
    found, outputs = direct.found, _direct_outputs(bound, direct)
    by = _parameters(bound, outputs)
    if bound.machine.is_coupled:
        return _results(bound, _of_graph(outputs, by), asked, by)
    given = dynamics(bound.mechanism, bound.rates(), bound.given_rules())
    torques = {j: given.Gamma[j] - bound.exerted(j) for j in bound.machine.moving}
    torques |= zip(DEGREES, given.f[0].entries, strict=True) if bound.machine.floating else ()
    symbols = {x.operands[0]: found.qdd[j] for j, x in bound.qdd.items()}
    if bound.base_rule:
        symbols |= zip(quantity("V0d").entries, outputs["V0d"].values(), strict=True)
    A = _asked_torques(bound, found)[2]
    free, solve = _free(bound, A, found, bound.machine.moving)
    graph = _of_graph({"torques": torques}, by).entries["dtorques_dp"]
    right: Entries = {}
    for c in by["dp"]:
        column = substituted(bound.graph, [graph[i, c] for i in torques], symbols)
        right |= {(i, c): x for i, x in zip(torques, column, strict=True)}
    solved = _split(bound, changes(right, A, tuple(torques), free, solve), outputs, {"dp": by["dp"]})
    return _results(bound, _shorter(bound, Derivatives(solved), outputs, by), asked, by)


def _linearization(bound: Bound, asked: Joints) -> Results:
    """M, D, K of M dqdd + D dqd + K dq = dtau along any motion, springs and friction included."""
    found, moving = dynamics(bound.mechanism, bound.rates(), bound.given_rules()), bound.machine.moving
    by_q, by_qd, by_qdd = _asked_torques(bound, found)
    return {
        name: Result(asked, tuple(entries.get((i, c), 0) for i in asked for c in moving), (len(moving),))
        for name, entries in (("M", by_qdd), ("D", by_qd), ("K", by_q))
    }


def _variables(bound: Bound, driving: Variables) -> Variables:
    """Variables by which the dynamic models are differentiated."""
    on_base = {
        f"d{name}": dict(zip(DEGREES, map(bound.graph.symbol, arguments(bound.machine)[name]), strict=True))
        for name in columns_of_base(bound.machine)
    }
    return {"dq": bound.q, "dqd": bound.qd, **driving, **on_base}


def _by_recursion(bound: Bound, found: Dynamics, outputs: Outputs, by: Variables) -> Derivatives:
    """By composite bodies and, where accelerations of joints or of the base are to be found, linear systems."""
    by_q, by_qd, A = _asked_torques(bound, found)
    free, solve = _free(bound, A, found, bound.machine.moving if "qdd" in outputs else ())
    numbers = (*(DEGREES if bound.machine.floating else ()), *bound.machine.moving)
    tables = {"driven": changes_by_known(A, numbers, free, solve)} if free else {"driven": A}
    tables |= {"q": changes(by_q, A, numbers, free, solve), "qd": changes(by_qd, A, numbers, free, solve)}
    of = {"dq": "q", "dqd": "qd", "dV0": "qd"}
    entries: dict[str, Entries] = {}
    for result in outputs:
        for name, columns in by.items():
            if name != "dpose":
                table = tables[of.get(name, "driven")]
                entries |= _split(bound, table, {result: outputs[result]}, {name: columns})
    return Derivatives(entries)


def _free(bound: Bound, A: Entries, found: Dynamics, joints: Joints) -> tuple[Joints, Solve]:
    """Numbers of the unknown accelerations, and the solver for them."""
    solve: Solve = solving(found.mechanism, A, found) if joints else lambda right: {}
    if bound.base_rule is None:
        return joints, solve
    return (*DEGREES, *joints), solving_with_base(A, found.Js[0], joints, solve)


def _split(bound: Bound, table: Entries, outputs: Outputs, by: Variables) -> dict[str, Entries]:
    """The rows of each result and the columns of each argument in a table of all of them."""
    return {
        f"d{result}_{name}": {(i, c): table[i, c] for i in rows for c in columns if (i, c) in table}
        for result, rows in outputs.items()
        for name, columns in by.items()
    }


def _posed(bound: Bound, made: Derivatives, outputs: Outputs) -> Derivatives:
    """With the columns of the pose of a floating base."""
    if bound.machine.floating is None:
        return made
    posed: dict[str, Entries] = {}
    for result in outputs:
        if bound.base_rule:
            still: Entries = {(i, m): 0 for i in outputs[result] for m in DEGREES}
            posed[f"d{result}_dpose"] = falling_by_pose(bound.gravity) if result == "V0d" else still
        elif f"d{result}_dV0d" in made.entries:
            posed[f"d{result}_dpose"] = by_pose(made.entries[f"d{result}_dV0d"], bound.gravity)
    return replace(made, entries=made.entries | posed)


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


def _asked_torques(bound: Bound, found: Dynamics) -> tuple[Entries, Entries, Entries]:
    """Derivatives by q, qd and qdd of the torques that a motion asks of motors, springs and friction included.

    Rows and columns of a floating base are those of its wrench, its velocity and its acceleration.
    """
    made = torque_derivatives(found.mechanism, bound.rates(), found)
    if bound.machine.floating:
        add_base(made, found.w[0])
    name_torque_derivatives(bound, made)
    by_q, by_qd = dict(made.by_q), dict(made.by_qd)
    for j in bound.machine.moving:
        joint, (stiffness, _) = bound.machine.joint(j), bound.spring(j)
        by_q[j, j] = by_q[j, j] + stiffness
        by_qd[j, j] = by_qd[j, j] + bound.cell(joint.friction.viscous) + bound.cell(joint.spring.damping)
    return by_q, by_qd, made.by_qdd


def _chosen(bound: Bound, by: Variables) -> Variables:
    """Variables that a scene names, whole arguments or entries, in its order; all where it names none."""
    if not bound.by:
        return by
    chosen = {}
    for name, variables in by.items():
        columns = [c for word in bound.by for c, x in variables.items() if word in (name[1:], x.operands[0])]
        if columns:
            chosen[name] = {c: variables[c] for c in columns}
    return chosen


def _needed(bound: Bound, by: Variables) -> Variables:
    """Variables that a scene names, and those of which the columns of the pose are made."""
    chosen = _chosen(bound, by)
    posed = "dpose" in chosen and "dV0d" in by
    whole = {"dqdd_motor"} | ({"dV0d"} if posed else set())
    named = {*chosen, *(("dV0d",) if posed else ())} - {"dpose"}
    return {name: by[name] if name in whole else chosen[name] for name in by if name in named}


def _mirrored(symmetric: Entries) -> Entries:
    """One triangle, twice."""
    return {(i, j): symmetric[max(i, j), min(i, j)] for i, j in symmetric}


def _parameters(bound: Bound, outputs: Outputs) -> Variables:
    """The parameters that a scene names, or else those that results are made of, numbered as in the table."""
    if bound.by:
        numbers = {p.name: c for c, p in enumerate(bound.machine.parameters)}
        return {"dp": {numbers[name]: bound.graph.symbol(name, Level.PARAMETER) for name in bound.by}}
    used = {x for x in reachable(x for entries in outputs.values() for x in entries.values()) if x.operation == SYMBOL}
    names = {x.operands[0]: x for x in used if x.level is Level.PARAMETER}
    if not names:
        source = bound.machine.label
        raise InputError(source, "parameters", "nothing depends on a parameter that has a name: fold fewer of them")
    return {"dp": {c: names[p.name] for c, p in enumerate(bound.machine.parameters) if p.name in names}}


def _of_graph(outputs: Outputs, by: Variables) -> Derivatives:
    """By differentiating the graph of a model."""
    graph = Differentiation(x for entries in outputs.values() for x in entries.values())
    made = Derivatives({f"d{result}_{name}": {} for result in outputs for name in by})
    for name, variables in by.items():
        for c, variable in variables.items():
            made.tangents[variable.operands[0]] = tangents = graph.by(variable)
            for result, entries in outputs.items():
                made.entries[f"d{result}_{name}"] |= {(j, c): tangents.of(x) for j, x in entries.items()}
    return made


def _shorter(bound: Bound, solved: Derivatives, outputs: Outputs, by: Variables) -> Derivatives:
    """Derivatives by recursion and linear systems or, with slides, those of the graph if they are shorter."""
    if all(link.axis is not Axis.PRISMATIC for link in bound.mechanism.links):
        return solved
    return min(solved, _of_graph(outputs, by), key=lambda made: made.size)


def _results(bound: Bound, made: Derivatives, asked: Joints, by: Variables) -> Results:
    """The entries of the joints that are asked for, named."""
    name_tangents(bound, made.tangents)
    made = made.only(by)
    name_acceleration_derivatives(bound, made.entries)
    results: Results = {}
    for of in dict.fromkeys(name.partition("_")[0] for name in made.entries):
        found = {argument: made.entries[f"{of}_{argument}"] for argument in by if f"{of}_{argument}" in made.entries}
        numbers = {i for entries in found.values() for i, _ in entries}
        rows = tuple(DEGREES) if of in OF_BASE else tuple(j for j in asked if j in numbers)
        for argument, entries in found.items():
            values = tuple(entries.get((i, c), 0) for i in rows for c in by[argument])
            labels = tuple(x.operands[0] for x in by[argument].values()) if bound.by or argument == "dp" else ()
            size = (len(by[argument]),)
            where, shape = (None, (6, *size)) if of in OF_BASE else (rows, size)
            results[f"{of}_{argument}"] = Result(where, values, shape, column_labels=labels)
    return results


_INVERSE, _DIRECT = ("q", "qd", "qdd_motor"), ("q", "qd", "tau")
_OF_OTHERS = replace(quantity("qdd"), plural="accelerations of elastic and passive joints", shape="(n - m)")
FAMILY = "derivatives"
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
    ),
)
