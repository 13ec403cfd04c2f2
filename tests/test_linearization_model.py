"""The generated linear model, M dqdd + D dqd + K dq = dtau: a recursion, against slopes of the equations of motion."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from symoro_elastic.errors import InputError
from symoro_elastic.machine.machine import Floating, Machine
from symoro_elastic.machine.scene import Scene
from symoro_elastic.models.catalogue import trace, trace_scene
from symoro_elastic.numerics.arrays import evaluated
from symoro_elastic.numerics.states import moderate_states
from symoro_elastic.numerics.values import parameter_values
from symoro_elastic.vibration.equations_of_motion import EquationsOfMotion, State
from tests.references.random_machines import random_machine

MODEL = "linearization"
SEEDS = range(8)


@pytest.mark.parametrize("seed", SEEDS)
def test_it_is_the_slope_of_the_equations_of_motion(seed: int) -> None:
    """Springs, dampers, friction, prismatic joints, trees; numbers of dual arithmetic, another way to differentiate."""
    machine = random_machine(seed, joints=6, massless=0.0)
    states = moderate_states(machine, 3)
    found = evaluated(trace(machine, MODEL), states, parameter_values(machine), np.float64)
    motion, n = EquationsOfMotion(machine), len(machine.moving)
    for k in range(len(states)):
        state = State(states.q[k], states.qd[k], states.qdd[k], np.zeros(n))
        for name, wanted in zip("KDM", motion.jacobians(motion.residual, state), strict=True):
            own = found[name][k].reshape(n, n)
            np.testing.assert_allclose(own, wanted, rtol=0, atol=1e-13 * np.abs(wanted).max(initial=1.0))


def test_rows_of_a_scene() -> None:
    machine: Machine = random_machine(1, joints=5)
    last = machine.joints[machine.moving[-1] - 1].name
    (part,) = trace_scene(machine, Scene((MODEL,), {MODEL: (last,)}))
    assert {name: result.shape for name, result in part.results.items()} == dict.fromkeys(
        "MDK", (1, len(machine.moving))
    )


def test_not_on_a_floating_base() -> None:
    with pytest.raises(InputError, match="not offered on a floating base"):
        trace(replace(random_machine(2), floating=Floating()), MODEL)
