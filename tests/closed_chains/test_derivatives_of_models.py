"""Derivatives of dynamic models on machines with couplings and loops: differences of the models in many digits."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from mpmath import mpf

from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.machine import Kind, Machine, Parameter
from tests.closed_chains.machines import machine, situations, without_closed_form
from tests.closed_chains.test_references import worst
from tests.closed_chains.traced import Results, results, traced
from tests.references.closed_chains import Array, State, exact, in_many_digits

pytestmark = pytest.mark.sampled(6)

MACHINES = (
    "ball_screw",
    "cam",
    "five_bar",
    "gantry",
    "gas_spring",
    "parallelogram_loop",
    "press",
    "screw",
    "spatial_four_bar",
)
WITH_PARAMETERS = ("ball_screw", "cam", "five_bar", "press", "screw")
STEP, EXACT = mpf(10) ** -20, 1e-30
"""Differences of 70 digits over 1e-20 are exact to 40; stiff springs and heavy gears take some."""
DRIVING = {"direct_dynamics": "tau", "inverse_dynamics": "qdd_motor"}


@in_many_digits
def differences(described: Machine, model: str, arguments: dict[str, list[Any]], name: str) -> dict[str, Array]:
    """Derivatives of the results of a model by an argument, or by parameters p; loops stay closed."""
    columns: dict[str, list[Array]] = {}
    function = traced(described, model)
    for k in range(len(arguments[name])):
        ahead, behind = (_moved(function, described, arguments, name, k, sign * STEP) for sign in (1, -1))
        for result, x in ahead.items():
            columns.setdefault(result, []).append((x - behind[result]) / (2 * STEP))
    return {result: np.array(found, dtype=object).T for result, found in columns.items()}


def _moved(
    function: Callable[..., Results], described: Machine, arguments: dict[str, list[Any]], name: str, k: int, step: Any
) -> Results:
    given = {key: list(map(exact, entries)) for key, entries in arguments.items()}
    given[name][k] += step
    guess = situations(described.name)[0].state.guess
    values = {p.name: x for p, x in zip(described.parameters, given.pop("p"), strict=True)}
    state = State(given.pop("q"), given.pop("qd"), guess)
    return function(state, given, values)


@in_many_digits
def given(described: Machine, model: str) -> dict[str, list[Any]]:
    situation = situations(described.name)[0]
    drive = situation.tau if DRIVING[model] == "tau" else situation.qdd_motor
    parameters = [p.value.evaluate({}, {}, exact) for p in described.parameters if p.value]
    return {"q": list(situation.state.u), "qd": list(situation.state.ud), DRIVING[model]: drive, "p": parameters}


@pytest.mark.sampled(1000)
@pytest.mark.parametrize("model", DRIVING)
@pytest.mark.parametrize("name", MACHINES)
def test_by_the_state_and_what_drives(name: str, model: str) -> None:
    described, arguments = machine(name), given(machine(name), model)
    driving = {DRIVING[model]: arguments[DRIVING[model]]}
    found = results(described, f"{model}_derivatives", situations(name)[0].state, driving)
    for by in ("q", "qd", DRIVING[model]):
        for of, wanted in differences(described, model, arguments, by).items():
            if f"d{of}_d{by}" in found:
                assert worst(found[f"d{of}_d{by}"], _rows(described, model, of, wanted)) < EXACT, (of, by)


def _rows(described: Machine, model: str, of: str, wanted: Array) -> Array:
    """Derivatives of the inverse model have rows for the accelerations that it finds only."""
    if (model, of) != ("inverse_dynamics", "qdd"):
        return wanted
    return wanted[[k for k, j in enumerate(described.independent) if j not in described.motors]]


@pytest.mark.parametrize("model", DRIVING)
@pytest.mark.parametrize("name", WITH_PARAMETERS)
def test_by_parameters(name: str, model: str) -> None:
    """Dependent variables change with a length of the loop."""
    assert_differences_by_parameters(machine(name), model)


@pytest.mark.parametrize("model", DRIVING)
def test_by_a_length_of_a_loop_without_closed_form(model: str) -> None:
    described = without_closed_form()
    joints = list(described.joints)
    row = next(j for j, joint in enumerate(joints) if joint.kind is Kind.PASSIVE and not joint.d.is_zero)
    length = Parameter("length", joints[row].d)
    joints[row] = replace(joints[row], d=Formula.parse(length.name))
    assert_differences_by_parameters(replace(described, joints=tuple(joints), parameters=(length,)), model)


def assert_differences_by_parameters(described: Machine, model: str) -> None:
    arguments = given(described, model)
    driving = {DRIVING[model]: arguments[DRIVING[model]]}
    found = results(described, f"{model}_parameter_derivatives", situations(described.name)[0].state, driving)
    for of, wanted in differences(described, model, arguments, "p").items():
        if f"d{of}_dp" in found:
            assert worst(found[f"d{of}_dp"], _rows(described, model, of, wanted)) < EXACT, of
