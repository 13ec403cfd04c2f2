"""The linear model M dqdd + D dqd + K dq = dtau: its recursion against dual numbers in the equations of motion."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.machine import Floating, Machine
from symoro_elastic.machine.scene import Scene
from symoro_elastic.models.programs.catalogue import trace, trace_scene
from symoro_elastic.numerics.evaluation.arrays import evaluate_arrays
from symoro_elastic.numerics.evaluation.values import parameter_values
from symoro_elastic.numerics.motion.equations_of_motion import EquationsOfMotion, State
from symoro_elastic.numerics.verification.states import moderate_states
from tests.references.random_machines import random_machine, with_springs_beside_motors

pytestmark = pytest.mark.sampled(5)

MODEL = "linearization"
SEEDS = range(8)


@pytest.mark.parametrize("seed", SEEDS)
def test_matrices_against_dual_numbers(seed: int) -> None:
    """Springs, beside motors too, dampers, friction, wrenches, prismatic joints, trees.

    Both ways sum at most some hundred products along a chain of 6 bodies, each rounded by 1.1e-16 of its size: the
    random sum of 500 such errors is 2.5e-15 of the largest entry. 1e-14 leaves four times that.
    """
    machine = random_machine(seed, joints=6, massless=0.0)
    machine = with_springs_beside_motors(machine) if seed % 2 else machine
    states = moderate_states(machine, 3)
    found = evaluate_arrays(trace(machine, MODEL), states, parameter_values(machine), np.float64)
    motion, n = EquationsOfMotion(machine), len(machine.independent)
    for k in range(len(states)):
        state = State(states.q[k], states.qd[k], states.qdd[k], np.zeros(n), np.zeros(len(machine.motors)))
        analysed = motion.matrices("KDM", state.q, state.qd, state.qdd)
        by_duals = motion.jacobians(motion.residual, state)
        for name, ours, wanted in zip("KDM", analysed, by_duals, strict=True):
            tolerance = 1e-14 * np.abs(wanted).max(initial=1.0)
            np.testing.assert_allclose(ours, wanted, rtol=0, atol=tolerance)
            np.testing.assert_allclose(found[name][k].reshape(n, n), wanted, rtol=0, atol=tolerance)


def test_rows_of_a_scene() -> None:
    machine: Machine = random_machine(1, joints=5)
    last = machine.joints[machine.independent[-1] - 1].name
    (part,) = trace_scene(machine, Scene((MODEL,), {MODEL: (last,)}))
    assert {name: result.shape for name, result in part.results.items()} == dict.fromkeys(
        "MDK", (1, len(machine.independent))
    )


def test_not_on_a_floating_base() -> None:
    with pytest.raises(InputError, match="not offered on a floating base"):
        trace(replace(random_machine(2), floating=Floating()), MODEL)
