"""Regressors of machines with couplings and loops: Y X is what virtual work says, h X is the energy."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.machine import Machine
from symoro_elastic.models.bound.bind import Bound
from symoro_elastic.models.dynamics.identification import linear_parameters
from symoro_elastic.models.programs.catalogue import trace
from symoro_elastic.symbolic.arithmetic import FLOATS, evaluate
from tests.closed_chains.machines import FILES, Situation, machine, situations
from tests.references.constraint_multipliers import Multipliers
from tests.references.virtual_work import VirtualWork

pytestmark = pytest.mark.sampled(6)

LINEAR = [
    name
    for name in FILES
    if all(joint.spring.stiffness.names.isdisjoint(machine(name).variables) for joint in machine(name).joints)
]
"""Machines without a stiffness that depends on a position."""
DOUBLE = 1e-14


def times_parameters(described: Machine, model: str, inputs: dict[str, Any]) -> Any:
    """A regressor at a state, times the values that the table gives."""
    traced = trace(described, model)
    (output,), (result,) = traced.program.outputs, traced.results.values()
    symbols = {p.name: p.value.value() for p in described.parameters if p.value}
    for argument in traced.program.inputs:
        symbols |= dict(zip(argument.symbols, map(float, inputs[argument.name]), strict=True))
    values = {parameter.label: parameter.value for parameter in linear_parameters(Bound(described))}
    X = [values[label] for label in result.column_labels]
    value = evaluate([*output.entries, *X], symbols, FLOATS)
    entries = np.array([value(x) for x in output.entries], dtype=float).reshape(output.shape)
    return entries @ np.array([value(x) for x in X], dtype=float)


def inputs_of(described: Machine, situation: Situation, at: dict[str, Any]) -> dict[str, Any]:
    dependent = [at[str(described.joint(j).variable)] for j in described.dependent]
    udd = np.random.default_rng(3).uniform(-3, 3, len(described.independent)).tolist()
    return {"q": situation.state.u, "q_dep": dependent, "qd": situation.state.ud, "qdd": udd}


@pytest.mark.sampled(30)
@pytest.mark.parametrize("name", LINEAR)
def test_regressor_times_parameters_is_the_force(name: str) -> None:
    """Inertia, gravity, rotors, friction of own variables and of coupled joints, springs, dampers and wrenches."""
    described = machine(name)
    for situation in situations(name):
        reference = VirtualWork(described, situation.state)
        inputs = inputs_of(described, situation, reference.at)
        wanted = reference.residual(inputs["qdd"], [0.0] * len(described.motors)).astype(float)
        found = times_parameters(described, "regressor", inputs)
        assert np.abs(found - wanted).max() < DOUBLE * np.abs(wanted).max()


@pytest.mark.thorough
@pytest.mark.parametrize("name", [name for name in LINEAR if len(situations(name)) > 1])
def test_energy_regressor_times_parameters_is_the_energy(name: str) -> None:
    """Differences of energy between two states."""
    described = machine(name)
    one, other = (Multipliers(described, situation.state) for situation in situations(name)[:2])
    found = [
        times_parameters(described, "energy_regressor", inputs_of(described, situation, reference.at))
        for situation, reference in zip(situations(name), (one, other), strict=False)
    ]
    energies = [[float(x) for x in reference.energies()] for reference in (one, other)]
    scale = max(abs(x) for some in energies for x in some)
    assert found[1] - found[0] == pytest.approx(sum(energies[1]) - sum(energies[0]), abs=DOUBLE * scale)


@pytest.mark.parametrize("model", ["regressor", "energy_regressor"])
def test_a_stiffness_that_varies_is_refused(model: str) -> None:
    with pytest.raises(InputError, match=r"screw\), stiffness: it varies with qm"):
        trace(machine("screw"), model)
