"""Derivatives of the dynamic models, at the same arguments: dtau_dq is that of tau by q.

Rows follow the joints of the result, columns those of the argument or the parameters that still have a
name. A sign of a velocity, in dry friction, counts as constant. Where every joint has a motor, and for
direct models, a recursion over composite bodies gives them; where motors drive springs, the graph of the
model is differentiated: nothing cancels there between stiff springs. Slides take the shorter way.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from symoro_elastic.equations.acceleration_derivatives import inverse, solving
from symoro_elastic.equations.derivatives import Entries, torque_derivatives
from symoro_elastic.equations.dynamics import Dynamics, dynamics
from symoro_elastic.equations.mechanism import Axis
from symoro_elastic.errors import InputError
from symoro_elastic.models.bind import Bound
from symoro_elastic.models.model import Joints, Model, Result, Results
from symoro_elastic.models.naming import name_dynamics
from symoro_elastic.models.naming_derivatives import (
    name_acceleration_derivatives,
    name_tangents,
    name_torque_derivatives,
)
from symoro_elastic.symbolic.differentiation import Differentiation, Tangents, substituted
from symoro_elastic.symbolic.expression import SYMBOL, Expression, Level, Scalar, reachable

Outputs = Mapping[str, Mapping[int, Scalar]]
"""Entries of each result of a model, by joint."""
Variables = Mapping[str, Mapping[int, Expression]]
"""What is differentiated by, array by array, by joint or by number of the parameter."""


@dataclass(frozen=True)
class Derivatives:
    """Entries of each derivative, as `dqdd_dq`; those of quantities on the way, by name of the variable."""

    entries: dict[str, Entries]
    tangents: dict[str, Tangents] = field(default_factory=dict)

    @property
    def size(self) -> int:
        """Expressions that they need."""
        return len(reachable(x for entries in self.entries.values() for x in entries.values()))


def _inverse_dynamics_derivatives(bound: Bound, asked: Joints) -> Results:
    found = _inverse(bound)
    by: Variables = {"dq": bound.q, "dqd": bound.qd, "dqdd_motor": bound.qdd_motor}
    if len(bound.motors) == len(bound.machine.moving):
        by_q, by_qd, A = _asked_torques(bound, found)
        made = Derivatives({"dtau_dq": by_q, "dtau_dqd": by_qd, "dtau_dqdd_motor": A})
    else:
        made = _of_graph(_inverse_outputs(bound, found), by)
        made.entries["dtau_dqdd_motor"] = _mirrored(made.entries["dtau_dqdd_motor"])
    return _results(bound, made, asked, by)


def _direct_dynamics_derivatives(bound: Bound, asked: Joints) -> Results:
    found = _direct(bound)
    by: Variables = {"dq": bound.q, "dqd": bound.qd, "dtau": bound.tau}
    by_q, by_qd, A = _asked_torques(bound, found)
    moving, solve = bound.machine.moving, solving(found.mechanism, A, found)
    solved = {"dqdd_dq": Entries(), "dqdd_dqd": Entries(), "dqdd_dtau": inverse(moving, solve)}
    for name, torques in (("dqdd_dq", by_q), ("dqdd_dqd", by_qd)):
        columns = {c: solve({j: -torques.get((j, c), 0) for j in moving}) for c in moving}
        solved[name] = {(j, c): x for c, column in columns.items() for j, x in column.items()}
    made = _shorter(bound, Derivatives(solved), {"qdd": found.qdd}, by)
    return _results(bound, made, asked, by)


def _inverse_dynamics_parameter_derivatives(bound: Bound, asked: Joints) -> Results:
    outputs = _inverse_outputs(bound, _inverse(bound))
    by = _parameters(bound, outputs)
    return _results(bound, _of_graph(outputs, by), asked, by)


def _direct_dynamics_parameter_derivatives(bound: Bound, asked: Joints) -> Results:
    found = _direct(bound)
    outputs = {"qdd": found.qdd}
    by = _parameters(bound, outputs)
    given = dynamics(bound.mechanism, bound.rates(), bound.given_rules())
    torques = {j: given.Gamma[j] - bound.exerted(j) for j in bound.machine.moving}
    symbols = {x.operands[0]: found.qdd[j] for j, x in bound.qdd.items()}
    solve = solving(found.mechanism, _asked_torques(bound, found)[2], found)
    asking, solved = _of_graph({"torques": torques}, by).entries["dtorques_dp"], Entries()
    for c in by["dp"]:
        right = substituted(bound.graph, [-asking[j, c] for j in torques], symbols)
        solved |= {(j, c): x for j, x in solve(dict(zip(torques, right, strict=True))).items()}
    return _results(bound, _shorter(bound, Derivatives({"dqdd_dp": solved}), outputs, by), asked, by)


def _inverse(bound: Bound) -> Dynamics:
    found = dynamics(bound.mechanism, bound.rates(), bound.inverse_rules())
    name_dynamics(bound, found, "[50]-[56]", "[57]-[61]")
    return found


def _direct(bound: Bound) -> Dynamics:
    found = dynamics(bound.mechanism, bound.rates(), bound.direct_rules())
    name_dynamics(bound, found, "[28]-[32]", "[33]-[36]")
    return found


def _inverse_outputs(bound: Bound, found: Dynamics) -> Outputs:
    free = [j for j in bound.machine.moving if j not in bound.motors]
    tau = {"tau": {j: found.Gamma[j] + bound.friction(j) for j in bound.motors}}
    return tau | ({"qdd": {j: found.qdd[j] for j in free}} if free else {})


def _asked_torques(bound: Bound, found: Dynamics) -> tuple[Entries, Entries, Entries]:
    """Derivatives by q, qd and qdd of the torques that a motion asks of motors, springs and friction included."""
    made = torque_derivatives(found.mechanism, bound.rates(), found)
    name_torque_derivatives(bound, made)
    by_q, by_qd = dict(made.by_q), dict(made.by_qd)
    for j in bound.machine.moving:
        joint, (stiffness, _) = bound.machine.joints[j - 1], bound.spring(j)
        by_q[j, j] = by_q[j, j] + stiffness
        by_qd[j, j] = by_qd[j, j] + bound.cell(joint.friction.viscous) + bound.cell(joint.spring.damping)
    return by_q, by_qd, made.by_qdd


def _mirrored(symmetric: Entries) -> Entries:
    """One triangle, twice."""
    return {(i, j): symmetric[max(i, j), min(i, j)] for i, j in symmetric}


def _parameters(bound: Bound, outputs: Outputs) -> Variables:
    """The parameters that results are made of, numbered as in the table."""
    used = {x for x in reachable(x for entries in outputs.values() for x in entries.values()) if x.operation == SYMBOL}
    names = {x.operands[0]: x for x in used if x.level is Level.PARAMETER}
    if not names:
        source = bound.machine.source or bound.machine.name
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
    """What a recursion and linear systems gave or, on a machine with slides where this is less, that of the graph."""
    if all(link.axis is not Axis.PRISMATIC for link in bound.mechanism.links):
        return solved
    return min(solved, _of_graph(outputs, by), key=lambda made: made.size)


def _results(bound: Bound, made: Derivatives, asked: Joints, by: Variables) -> Results:
    """The entries of the joints that are asked for, named."""
    name_tangents(bound, made.tangents)
    name_acceleration_derivatives(bound, made.entries)
    results: Results = {}
    for name, entries in made.entries.items():
        argument = name.partition("_")[2]
        rows = tuple(j for j in asked if any(j == i for i, _ in entries))
        values = tuple(entries.get((i, c), 0) for i in rows for c in by[argument])
        labels = tuple(x.operands[0] for x in by[argument].values()) if argument == "dp" else ()
        results[name] = Result(rows, values, (len(by[argument]),), column_labels=labels)
    return results


_INVERSE, _DIRECT = ("q", "qd", "qdd_motor"), ("q", "qd", "tau")

DERIVATIVES = (
    Model(
        "inverse_dynamics_derivatives",
        "derivatives of the inverse dynamic model",
        "[37]-[61]",
        _INVERSE,
        ("dtau_dq", "dtau_dqd", "dtau_dqdd_motor", "dqdd_dq", "dqdd_dqd", "dqdd_dqdd_motor"),
        _inverse_dynamics_derivatives,
    ),
    Model(
        "direct_dynamics_derivatives",
        "derivatives of the direct dynamic model",
        "[8], [12]-[36]",
        _DIRECT,
        ("dqdd_dq", "dqdd_dqd", "dqdd_dtau"),
        _direct_dynamics_derivatives,
    ),
    Model(
        "inverse_dynamics_parameter_derivatives",
        "derivatives of the inverse dynamic model by the parameters",
        "[37]-[61]",
        _INVERSE,
        ("dtau_dp", "dqdd_dp"),
        _inverse_dynamics_parameter_derivatives,
    ),
    Model(
        "direct_dynamics_parameter_derivatives",
        "derivatives of the direct dynamic model by the parameters",
        "[8], [12]-[36]",
        _DIRECT,
        ("dqdd_dp",),
        _direct_dynamics_parameter_derivatives,
    ),
)
