"""Springs with backlash: (D3) and its integral in mpmath, derivatives, verification, and what is refused."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import mpmath
import numpy as np
import pytest

from symoro_elastic.formats import read_machine
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.checks import check
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.named_cells import with_values
from symoro_elastic.machine.restrict import restrict
from symoro_elastic.machine.scene import Scene
from symoro_elastic.models.programs.catalogue import trace
from symoro_elastic.numerics.motion.equations_of_motion import EquationsOfMotion
from symoro_elastic.numerics.motion.equilibrium import equilibrium
from symoro_elastic.numerics.verification.implementations import numpy_model
from symoro_elastic.numerics.verification.verify import verify
from symoro_elastic.symbolic.arithmetic import FLOATS, evaluate
from symoro_elastic.symbolic.expression import Graph
from symoro_elastic.symbolic.functions import logarithm

EXAMPLE = Path(__file__).parents[2] / "examples" / "backlash.toml"
K, C, B, E = 2.0e4, 0.5, 2e-3, 4e-5


def geared(selected: str = "q2", **cells: str) -> Machine:
    """The example; the coordinate of its gear may follow the motor."""
    machine = read_machine(EXAMPLE)[0]
    motor, gear, tool = machine.joints
    spring = replace(gear.spring, **{key: Formula.parse(x) for key, x in cells.items()})
    own = selected.removesuffix("q2").removesuffix(" + ") or "0"
    return replace(machine, joints=(motor, replace(gear, theta=Formula.parse(own), spring=spring), tool))


def root(u: Any) -> Any:
    return mpmath.sqrt(u * u + mpmath.mpf(E) ** 2)


def pressed(x: Any) -> Any:
    """D(x)."""
    return x - (root(x + mpmath.mpf(B) / 2) - root(x - mpmath.mpf(B) / 2)) / 2


def integral(x: Any) -> Any:
    """U(x) with arc sines, from 0."""

    def part(u: Any) -> Any:
        return u * root(u) + mpmath.mpf(E) ** 2 * mpmath.asinh(u / mpmath.mpf(E))

    half = mpmath.mpf(B) / 2
    return x * x / 2 - (part(x + half) - part(x - half)) / 4 + part(half) / 2


DEFLECTIONS = np.array([0.0, 1e-5, -3e-4, 9.6e-4, 1e-3, -1.04e-3, 2e-3, -0.02, 0.7])


def test_force_and_energy_are_the_closed_form() -> None:
    q, qd = np.zeros((len(DEFLECTIONS), 2)), np.zeros((len(DEFLECTIONS), 2))
    q[:, 1], qd[:, 1] = DEFLECTIONS, 0.3
    model = numpy_model(geared(), ("inverse_dynamics", "bias_forces", "inertia_matrix", "energy"))
    _, qdd = model.inverse_dynamics(q, qd, np.zeros((len(q), 1)))
    exerted = model.inertia_matrix(q)[:, 1, 1] * qdd[:, -1] + model.bias_forces(q, qd)[:, 1]
    elastic = model.energy(q, qd)[:, 2]
    with mpmath.workdps(40):
        for k, x in enumerate(map(mpmath.mpf, DEFLECTIONS)):
            wanted = -K * pressed(x) - C * mpmath.diff(pressed, x) * 0.3
            assert abs(exerted[k] - wanted) < 1e-13 * (10 + K * abs(x))
            assert abs(elastic[k] - K * integral(x)) < 1e-15 * K * (B * B + 4 * x * x)
            assert abs(mpmath.diff(integral, x) - pressed(x)) < 1e-12 * B


@pytest.mark.parametrize("selected", ["q2", "q1/10 + q2"])
def test_slopes_are_those_of_the_closed_form(selected: str) -> None:
    """K and D by recursion and by the graph: k D' + c D'' v and c D' beyond those of a straight spring."""
    names = ("linearization",)
    own, straight = (
        numpy_model(geared(selected), names),
        numpy_model(geared(selected, backlash="0", rounding="0"), names),
    )
    for x in DEFLECTIONS:
        given = {"q": np.array([0.2, x]), "qd": np.array([0.1, 0.4]), "qdd": np.zeros(2)}
        (M, D, stiffness), (M_0, D_0, K_0) = own.linearization(**given), straight.linearization(**given)
        with mpmath.workdps(40):
            first, second = mpmath.diff(pressed, x), mpmath.diff(pressed, x, 2)
        assert 0 < first < 1 and np.array_equal(M, M_0)
        assert abs((stiffness - K_0)[1, 1] - float(K * (first - 1) + C * second * 0.4)) < 1e-9 * K
        assert abs((D - D_0)[1, 1] - float(C * (first - 1))) < 1e-12
        assert np.abs((stiffness - K_0).ravel()[:3]).max() < 1e-9


def test_derivatives_are_slopes_of_the_direct_model() -> None:
    model = numpy_model(geared(), ("direct_dynamics", "direct_dynamics_derivatives"))
    names = model.OUTPUTS["direct_dynamics_derivatives"]
    for x in DEFLECTIONS:
        q, qd, tau, h = np.array([0.2, x]), np.array([0.1, -0.4]), np.array([1.0]), 1e-8
        found = dict(zip(names, model.direct_dynamics_derivatives(q, qd, tau), strict=True))
        for k in range(2):
            step = h * np.eye(2)[k]
            slope = (model.direct_dynamics(q + step, qd, tau) - model.direct_dynamics(q - step, qd, tau)) / (2 * h)
            assert np.abs(found["dqdd_dq"][:, k] - slope).max() < 1e-5 * np.abs(found["dqdd_dq"]).max() + 1e-3


def test_the_equilibrium_is_on_a_flank() -> None:
    """The weight 2 * 9.81 * 0.15 N m presses the gear against its lower flank; backlash does not soften it there."""
    for factor in (1.0, -1.0):
        machine = replace(geared(), base=replace(geared().base, gravity=(*map(Formula.parse, (0, -9.81 * factor, 0)),)))
        motion = EquationsOfMotion(machine)
        x = equilibrium(motion).q[1]
        assert abs(factor * x + B / 2 + 2.943 / K) < E
        assert abs(float(K * pressed(x)) + factor * 2.943 * np.cos(x)) < 1e-9
        assert 0.9 * K < motion.spring_stiffnesses(np.array([0, x]))[0] < K


def test_models_are_verified() -> None:
    """C, numpy and floats against the law in 50 digits, at moderate and extreme states."""
    assert verify(geared(), states=(4, 4)).ok


@pytest.mark.parametrize(
    ("cells", "says"),
    [
        ({"backlash": "0"}, "rounding: it rounds the edges of a backlash"),
        ({"backlash": "-1e-3"}, "backlash: '-1e-3' is negative"),
        ({"rounding": "1e-8"}, "rounding: 1e-08 is sharper than 0.0001 of the backlash 0.002"),
        ({"stiffness": "2e4 + q1"}, "backlash: its stiffness changes with q1"),
    ],
)
def test_laws_that_are_refused(cells: dict[str, str], says: str) -> None:
    with pytest.raises(InputError) as refused:
        check(geared(**cells))
    assert f"joint 2 (gear), {says}" in str(refused.value)


@pytest.mark.parametrize("model", ["regressor", "feed_forward"])
def test_models_of_straight_springs_are_refused(model: str) -> None:
    with pytest.raises(InputError) as refused:
        trace(geared(damping="0"), model)
    assert "joint 2 (gear), backlash" in str(refused.value)


def test_a_value_of_zero_is_refused() -> None:
    with pytest.raises(InputError) as refused:
        with_values(geared(), {"gear.backlash": 0.0})
    assert "gear.backlash" in str(refused.value)


def test_logarithms_of_energies() -> None:
    graph = Graph()
    found = logarithm(graph, graph.symbol("x"))
    for x in (1.0, 1 + 1e-9, 1.5, 50.0, 2500.0, 1e8):
        assert abs(evaluate([found], {"x": x}, FLOATS)(found) - math.log(x)) < 1e-13 + 1e-13 * math.log(x)


def test_static_springs_are_straight() -> None:
    with pytest.raises(InputError) as refused:
        restrict(geared(), Scene(static={"gear": None}))
    assert "static, gear: its spring has backlash" in str(refused.value)
