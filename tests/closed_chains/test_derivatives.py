"""Derivatives and parts of generated models of machines with couplings and loops, against differences in 70 digits."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from mpmath import mpf

from symoro_elastic.machine.formula import ZERO
from symoro_elastic.machine.machine import NO_VECTOR, Base, Body, Friction, Machine, Wrench
from tests.closed_chains.machines import machine, situations
from tests.closed_chains.test_models import assert_near, computed, independent, reference
from tests.references.closed_chains import Array, State, in_many_digits, nearest_double
from tests.references.constraint_multipliers import Multipliers

pytestmark = pytest.mark.sampled(6)

DIFFERENTIATED = (
    "cam",
    "delta",
    "differential",
    "four_bar",
    "gantry",
    "gantry_rigid",
    "geared_five_bar",
    "press",
    "screw",
    "spatial_four_bar",
)
DIVIDED = ("cam", "coupled_wrist", "four_bar", "gantry", "geared_five_bar", "ring", "screw", "spatial_four_bar")
STEP = mpf(10) ** -20
TOLERANCE = 1e-12

Function = Callable[[Multipliers], Array]


@cache
@in_many_digits
def displaced(name: str, by: str) -> list[tuple[Multipliers, Multipliers]]:
    """The machine a step after and before, by each u or ud; loops closed anew."""
    state, at = situations(name)[0].state, reference(name, 0).at
    pairs = []
    for k in range(len(state.u)):
        steps = [[mpf(x) + sign * STEP * (i == k) for i, x in enumerate(getattr(state, by))] for sign in (1, -1)]
        after, before = (replace(state, guess=at, **{by: step}) for step in steps)
        pairs.append(
            (Multipliers(machine(name), after, nearest_double), Multipliers(machine(name), before, nearest_double))
        )
    return pairs


@in_many_digits
def differences(name: str, function: Function, by: str) -> Array:
    """Central differences of a function of the state by u or ud: [entry][variable]."""
    columns = [(function(after) - function(before)) / (2 * STEP) for after, before in displaced(name, by)]
    return np.array(columns, dtype=object).T


@pytest.mark.sampled(1000)
@pytest.mark.parametrize("name", DIFFERENTIATED)
def test_derivatives_of_the_direct_model(name: str) -> None:
    tau = situations(name)[0].tau
    results = computed(name, 0, "direct_dynamics_derivatives")
    for result, by in (("dqdd_dq", "u"), ("dqdd_dqd", "ud")):
        wanted = differences(name, lambda found: independent(found, found.direct(tau)), by)
        assert_near(name, results[result], wanted, TOLERANCE)
    found = reference(name, 0)
    unit = [[float(k == m) for m in range(len(tau))] for k in range(len(tau))]
    columns = [independent(found, found.direct(one) - found.direct([0] * len(tau))) for one in unit]
    assert_near(name, results["dqdd_dtau"], np.array(columns, dtype=object).T, TOLERANCE)


@pytest.mark.sampled(12)
@pytest.mark.parametrize("name", DIFFERENTIATED)
def test_derivatives_of_the_inverse_model(name: str) -> None:
    wanted_motion = situations(name)[0].qdd_motor
    results = computed(name, 0, "inverse_dynamics_derivatives")
    for result, by in (("dtau_dq", "u"), ("dtau_dqd", "ud")):
        wanted = differences(name, lambda found: found.inverse(wanted_motion)[0], by)
        assert_near(name, results[result], wanted, TOLERANCE)
    found = reference(name, 0)
    unit = [[float(k == m) for m in range(len(wanted_motion))] for k in range(len(wanted_motion))]
    columns = [found.inverse(one)[0] - found.inverse([0] * len(wanted_motion))[0] for one in unit]
    assert_near(name, results["dtau_dqdd_motor"], np.array(columns, dtype=object).T, TOLERANCE)


# Parts of H


def with_rows(described: Machine, **changes: Any) -> Machine:
    return replace(described, joints=tuple(replace(joint, **changes) for joint in described.joints))


def on(described: Machine, base: Base) -> Machine:
    return replace(described, base=base)


@pytest.mark.thorough
@pytest.mark.parametrize("name", DIVIDED)
def test_parts_of_the_bias_forces(name: str) -> None:
    """Gravity, wrenches, friction, centrifugal and Coriolis forces, each on a machine that has nothing else."""
    whole, state = machine(name), situations(name)[0].state
    still = State(state.u, [0] * len(state.u), state.guess)
    idle = with_rows(whole, friction=Friction())
    unloaded, weight = with_rows(idle, wrench=Wrench()), Base(gravity=whole.base.gravity)
    massless = with_rows(whole, body=Body(), wrench=Wrench(), rotor_inertia=ZERO)
    parts = {
        "gravity_forces": (on(unloaded, weight), still),
        "external_forces": (on(idle, Base()), still),
        "friction_forces": (on(massless, Base()), state),
        "coriolis_forces": (on(unloaded, replace(whole.base, gravity=NO_VECTOR)), state),
    }
    largest = max([mpf(1), *map(abs, reference(name, 0).bias())])
    for model, (described, place) in parts.items():
        wanted = Multipliers(described, place, nearest_double).bias()
        assert_near(name, computed(name, 0, model)["H"], wanted, scale=largest)
