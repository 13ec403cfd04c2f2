"""Orders that are observed: generated steps of every method against DOP853 at 1e-12, under changing torques."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from types import ModuleType
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from symoro_elastic.codegen.integration.tableaus import METHODS, W3, nodes_of
from symoro_elastic.codegen.package import Package
from symoro_elastic.codegen.targets.numpy import render_numpy
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.machine import Base, Kind, Machine
from symoro_elastic.machine.restrict import under_forces
from symoro_elastic.machine.scene import Scene
from symoro_elastic.models.packaging import trace_models
from symoro_elastic.numerics.verification.implementations import import_package
from symoro_elastic.quantities.time_steps import TimeStep
from tests.closed_chains.machines import machine as of_loops
from tests.closed_chains.machines import situations
from tests.models.test_creep import creeping
from tests.references.random_machines import random_machine

pytestmark = pytest.mark.sampled(6)

GENTLE = Formula.parse("3")
DURATION = 0.08
TOLERANCE = 1e-12
VARIANTS = ("", "_servo", "_driven")
CASES = [
    *(("arm", name, variant) for name in TimeStep for variant in VARIANTS),
    *(("ring", name, "") for name in ("w3", "rodas4", "midpoint")),
    *(("pushed arm", name, "") for name in ("w3", "midpoint")),
    *(("pushed arm", "rodas4", variant) for variant in VARIANTS),
    *(("delta", name, "_servo") for name in ("w2", "w3", "midpoint")),
]


def machine(name: str) -> Machine:
    """An arm with springs, smooth friction, wrenches and weight; a loop that is assembled at every stage; a delta.

    The pushed arm is the arm under changing wrenches on two frames.
    """
    if name == "pushed arm":
        return under_forces(machine("arm"), [row.name for row in machine("arm").joints[2:4]])
    if name == "arm":
        kinds = (Kind.MOTOR, Kind.ELASTIC, Kind.MOTOR, Kind.PASSIVE)
        found = creeping(random_machine(11, joints=4, kinds=kinds, massless=0))
        laws = (
            replace(row.friction, creep=GENTLE) if not row.friction.creep.is_zero else row.friction
            for row in found.joints
        )
        return replace(
            found, joints=tuple(replace(row, friction=law) for row, law in zip(found.joints, laws, strict=True))
        )
    return creeping(of_loops(name))


@cache
def generated(name: str) -> tuple[Package, ModuleType]:
    steps = tuple(step for step in TimeStep if name != "delta" or step != "rodas4")
    models = ("direct_dynamics", "inverse_dynamics")
    models += ("dependent_coordinates", "coupling_matrix") if name == "delta" else ()
    package = trace_models(machine(name), Scene(models=models, steps=steps)).package
    with TemporaryDirectory() as folder:
        return package, import_package(render_numpy(package), Path(folder) / "numpy")


@cache
def start(name: str) -> tuple[Array, Array, Array | None]:
    package, module = generated(name)
    if name.endswith("arm"):
        rng = np.random.default_rng(4)
        return rng.uniform(-0.4, 0.4, len(package.axes)), rng.uniform(-1, 1, len(package.axes)), None
    state = situations(name)[0].state
    if not package.assembled:
        return np.array(state.u), np.array(state.ud), None
    variables = {row.name: str(row.variable) for row in machine(name).joints}
    guess = [float(state.guess[variables[axis.name]]) for axis in package.dependent or ()]
    return np.array(state.u), np.array(state.ud), module.assemble(state.u, guess)[0]


class Course:
    """What is given of the motors over time, with its derivatives."""

    def __init__(self, q: Array, qd: Array) -> None:
        self.q, self.qd, m = q, qd, len(q)
        self.kp, self.kd = 40 + 10.0 * np.arange(m), 3 + 1.0 * np.arange(m)

    def tau(self, t: float, order: int = 0) -> Array:
        return 4 * 20.0**order * np.sin(20 * t + 0.3 + order * np.pi / 2) * np.ones(len(self.q))

    def y(self, t: float, order: int = 0) -> Array:
        """From the start on, with velocity and acceleration."""
        wave = 0.05 * 25.0**order * np.cos(25 * t + order * np.pi / 2)
        still = self.q - 0.05 if order == 0 else np.zeros(len(self.q))
        return still + wave + (self.qd * (t if order == 0 else 1.0) if order < 2 else 0.0)

    def wrenches(self, t: float, order: int = 0) -> Array:
        return 3 * 30.0**order * np.sin(30 * t + np.arange(12) + order * np.pi / 2)

    def torque(self, t: float, q: Array, qd: Array) -> Array:
        return self.tau(t) + self.kp * (self.y(t) - q) + self.kd * (self.y(t, 1) - qd)


def of_motors(name: str, q: Array, qd: Array) -> tuple[Array, Array]:
    """Positions and velocities of the motors, which may follow from loops."""
    package, module = generated(name)
    if package.has_motors_in_q:
        return q[list(package.motors)], qd[list(package.motors)]
    described = machine(name)
    x = dict(zip(described.with_variable, module.dependent_coordinates(q), strict=True))
    rates = dict(zip(described.articulated, module.coupling_matrix(q, qd)[0] @ qd, strict=True))
    return np.array([x[j] for j in described.motors]), np.array([rates[j] for j in described.motors])


def course(name: str) -> Course:
    return Course(*of_motors(name, *start(name)[:2]))


@cache
def exact(name: str, variant: str) -> Array:
    """q, qd at the end, by DOP853."""
    (package, module), (q, qd, q_dep), given = generated(name), start(name), course(name)
    motors, n = list(package.motors), len(q)

    def rate(t: float, y: Array) -> Array:
        q, qd = y[:n].copy(), y[n:].copy()
        if variant == "_driven":
            q[motors], qd[motors] = given.y(t), given.y(t, 1)
        place = (q,) if q_dep is None else (q, module.assemble(q, q_dep)[0])
        forces = (given.wrenches(t),) if name == "pushed arm" else ()
        if variant == "_driven":
            return np.concatenate([qd, module.inverse_dynamics(*place, qd, given.y(t, 2), *forces)[1]])
        torque = given.torque(t, *of_motors(name, q, qd)) if variant else given.tau(t)
        return np.concatenate([qd, module.direct_dynamics(*place, qd, torque, *forces)])

    solved = solve_ivp(rate, (0, DURATION), np.concatenate([q, qd]), method="DOP853", rtol=TOLERANCE, atol=TOLERANCE)
    found: Array = solved.y[:, -1]
    return found


def taken(name: str, method: str, variant: str, count: int, error: str = "") -> tuple[Array, Array]:
    """q, qd at the end of so many steps, and the last results beside."""
    (_, module), (q, qd, q_dep), given = generated(name), start(name), course(name)
    function: Callable[..., Any] = getattr(module, f"step_{method}{variant}{error}")
    nodes = [float(x) for x in nodes_of(METHODS[method], driven=variant == "_driven")]
    h, rest = DURATION / count, () if q_dep is None else (q_dep,)
    for k in range(count):
        at, t = [h * (k + x) for x in nodes], h * k
        y = [[given.y(x, order) for x in at] for order in (0, 1, 2)]
        tau = [given.tau(x) for x in at]
        rows: list[Any] = {"": [tau], "_servo": [tau, y[0], y[1], given.kp, given.kd], "_driven": y}[variant]
        if name == "pushed arm":
            rows.insert(3 if variant else 1, [given.wrenches(x) for x in at])
        if method == "rodas4":
            follows = given.kp * given.y(t, 1) + given.kd * given.y(t, 2) if variant else 0.0
            rows = [*rows, given.y(t, 3) if variant == "_driven" else given.tau(t, 1) + follows]
        if method == "rodas4" and name == "pushed arm":
            rows.append(given.wrenches(t, 1))
        q, qd, *rest = function(*rows, h, q, qd, *rest)
        if error:
            return np.concatenate([q, qd]), np.asarray(rest[-1])
    return np.concatenate([q, qd]), np.array([])


@pytest.mark.parametrize(("name", "method", "variant"), CASES)
def test_orders_are_observed(name: str, method: str, variant: str) -> None:
    """The error falls by 2^p where steps are halved; velocities of some rad/s, errors of a hundredth at most."""
    counts = (32, 64)
    errors = [np.abs(taken(name, method, variant, n)[0] - exact(name, variant)).max() for n in counts]
    assert 100 * TOLERANCE < errors[1] < errors[0] < 0.02
    order = METHODS[method].order
    assert order - 0.5 < np.log2(errors[0] / errors[1]) < order + 0.5


@pytest.mark.parametrize("method", ["w3", "rodas4"])
def test_the_error_of_a_step_is_of_the_order_of_the_embedded_method(method: str) -> None:
    sizes = [np.abs(taken("arm", method, "", n, "_error")[1]).max() for n in (32, 64)]
    assert METHODS[method].order - 0.4 < np.log2(sizes[0] / sizes[1]) < METHODS[method].order + 1.0


def test_stiff_springs_leave_the_error_of_a_step_as_it_is() -> None:
    """Springs 1e8 times as stiff: long steps stay bounded, and follow the rigid arm."""
    stiff = machine("arm")
    rows = tuple(
        replace(
            row,
            spring=replace(
                row.spring, stiffness=Formula.parse("1e11"), damping=Formula.parse("0"), neutral=Formula.parse("0")
            ),
        )
        if row.kind is Kind.ELASTIC
        else row
        for row in stiff.joints
    )
    described = replace(stiff, joints=rows, base=Base())
    package = trace_models(described, Scene(models=("direct_dynamics",), steps=(W3.name,))).package
    with TemporaryDirectory() as folder:
        module = import_package(render_numpy(package), Path(folder) / "numpy")
    q, qd = np.zeros(len(package.axes)), np.zeros(len(package.axes))
    tau = np.ones((4, len(package.motors)))
    for _ in range(40):
        q, qd = module.step_w3(tau, 2e-3, q, qd)
    elastic = list(package.elastic)
    assert np.abs(q[elastic]).max() < 1e-8 and 1e-3 < np.abs(q).max() < 10
