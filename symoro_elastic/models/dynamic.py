"""Dynamic models: direct, inverse, and the parts of the Lagrange form."""

from __future__ import annotations

from symoro_elastic.equations.dynamics import dynamics
from symoro_elastic.equations.lagrange import inertia_matrix
from symoro_elastic.models.bind import Bound
from symoro_elastic.models.model import Joints, Model, Result, Results
from symoro_elastic.models.naming import name_composites, name_dynamics


def _direct_dynamics(bound: Bound, asked: Joints) -> Results:
    found = dynamics(bound.mechanism, bound.rates(), bound.direct_rules())
    name_dynamics(bound, found, "[28]-[32]", "[33]-[36]")
    return {"qdd": Result(asked, tuple(found.qdd[j] for j in asked))}


def _inverse_dynamics(bound: Bound, asked: Joints) -> Results:
    found = dynamics(bound.mechanism, bound.rates(), bound.inverse_rules())
    name_dynamics(bound, found, "[50]-[56]", "[57]-[61]")
    motors = tuple(j for j in asked if j in bound.motors)
    others = asked if asked == bound.machine.moving else tuple(j for j in asked if j not in bound.motors)
    tau = tuple(found.Gamma[j] + bound.friction(j) for j in motors)
    return {"tau": Result(motors, tau), "qdd": Result(others, tuple(found.qdd[j] for j in others))}


def _bias_forces(bound: Bound, asked: Joints) -> Results:
    found = dynamics(bound.mechanism, bound.rates(), bound.held_rules())
    name_dynamics(bound, found, "[15]", "[61]")
    return {"H": Result(asked, tuple(found.Gamma[j] + bound.friction(j) for j in asked))}


def _inertia_matrix(bound: Bound, asked: Joints) -> Results:
    found = inertia_matrix(bound.mechanism)
    name_composites(bound, found)
    entries = tuple(found.A[i][j] for i in asked for j in asked)
    return {"A": Result(asked, entries, (len(asked),))}


DYNAMIC = (
    Model("direct_dynamics", "direct dynamic model", "[12]-[36]", ("q", "qd", "tau"), ("qdd",), _direct_dynamics),
    Model(
        "inverse_dynamics",
        "inverse dynamic model: motor torques and elastic accelerations",
        "[37]-[61]",
        ("q", "qd", "qdd_motor"),
        ("tau", "qdd"),
        _inverse_dynamics,
    ),
    Model("inertia_matrix", "inertia matrix", "[8]", ("q",), ("A",), _inertia_matrix),
    Model(
        "bias_forces",
        "forces at zero joint acceleration",
        "[8]",
        ("q", "qd"),
        ("H",),
        _bias_forces,
    ),
)
