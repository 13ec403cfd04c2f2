"""Friction that rises with load in linear models of motions, against two masses by hand; substitutions in steps."""

from __future__ import annotations

import sys
from collections import Counter
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
import pytest

from symoro_elastic.analysis.simulation.prediction.path import linear_path
from symoro_elastic.analysis.simulation.simulate import StepCost
from symoro_elastic.codegen.integration.tableaus import METHODS, nodes_of
from symoro_elastic.machine.machine import Friction, Machine
from symoro_elastic.models.steps.implicit_steps import Motors
from tests.analysis.ladder.generated_steps import with_steps
from tests.analysis.ladder.motions import moved
from tests.analysis.vibration.machines import drive
from tests.compiled_models import cell

M1, M2, K, D = 3.0, 5.0, 2e4, 30.0
ROTOR, VISCOUS, COULOMB, STATIC, STRIBECK, CREEP, SHARE = 2.0, 4.0, 6.0, 9.0, 0.3, 0.05, 0.3


def machine() -> Machine:
    """Two masses on a line, a spring between; friction of the motor rises with what it passes on."""
    law = {
        "viscous": VISCOUS,
        "coulomb": COULOMB,
        "static": STATIC,
        "stribeck": STRIBECK,
        "creep": CREEP,
        "load": SHARE,
    }
    motor, load = drive(M1, M2, K, D).joints
    motor = replace(motor, friction=Friction(**{key: cell(x) for key, x in law.items()}), rotor_inertia=cell(ROTOR))
    return replace(drive(M1, M2, K, D), joints=(motor, load))


def forces(q: Any, v: Any, a: Any) -> Any:
    """Forces on motor and load, friction with the torque that is passed on among them."""
    passed = M1 * a[0] + M2 * (a[0] + a[1])
    level = COULOMB + (STATIC - COULOMB) / (1 + (v[0] / STRIBECK) ** 2) + SHARE * abs(passed)
    friction = level * v[0] / np.hypot(v[0], CREEP) + VISCOUS * v[0]
    return np.array([passed + ROTOR * a[0] + friction, M2 * (a[0] + a[1]) + K * q[1] + D * v[1]])


def test_rows_are_those_of_two_masses() -> None:
    """M, D, K by central differences of the forces, and what drives the motion."""
    path = linear_path(moved(machine(), 0.5, {"motor": (0.1, 0.4)}), ("load.z",), 40, newton_steps=1)
    for k in (3, 11, 20, 27):
        state = np.array([x[k] for x in path.states(path.t)])
        for number, found in enumerate((path.K, path.D, path.M)):
            for column in range(2):
                change = np.zeros((3, 2))
                change[number, column] = 1e-5
                slope = (forces(*(state + change)) - forces(*(state - change))) / 2e-5
                np.testing.assert_allclose(found[k][:, column], slope, rtol=1e-6, atol=1e-5)
        np.testing.assert_allclose(path.R[k], -forces(*state), rtol=1e-12, atol=1e-12)
    assert path.of_loads is not None
    np.testing.assert_allclose((path.M - path.of_loads)[20], [[M1 + M2 + ROTOR, M2], [M2, M2]], rtol=1e-12)


def calls(work: Any) -> Counter[str]:
    """How often each function is called."""
    found: Counter[str] = Counter()

    def count(frame: Any, event: str, _: Any) -> None:
        found[frame.f_code.co_name] += event == "call"

    before = sys.getprofile()
    sys.setprofile(count)
    try:
        work()
    finally:
        sys.setprofile(before)
    return found


@pytest.mark.sampled(5)
@pytest.mark.parametrize("method", ["w2", "w3", "rk4"])
def test_the_cost_of_a_step_counts_substitutions(method: str) -> None:
    """Calls of the right side, and of the torques that are passed, in steps from random states."""
    described, rng, steps = machine(), np.random.default_rng(4), 20
    module, nodes = with_steps(described, method), len(nodes_of(METHODS[method]))
    found: Counter[str] = Counter()
    for _ in range(steps):
        tau, q, qd = rng.normal(0, 20, (nodes, 1)), rng.normal(0, 1e-3, 2), rng.normal(0, 0.3, 2)
        found += calls(partial(getattr(module, f"step_{method}"), tau, 1e-3, q, qd))
    (passed, _), (right, _), *_ = StepCost(described, Motors.TORQUE).programs(METHODS[method])
    assert passed == right
    assert found["direct_dynamics"] == found["passed_torques"] == pytest.approx(steps * right, rel=0.25)
