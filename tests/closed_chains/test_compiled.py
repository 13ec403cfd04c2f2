"""Generated C of machines with couplings and loops, one state and many, against a reference in 70 digits."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import mpmath
import numpy as np
import pytest

from symoro_elastic.codegen.compile import CompiledPackage, compile_package
from symoro_elastic.machine.scene import Scene
from symoro_elastic.models.packaging import trace_models
from tests.closed_chains.machines import machine, situations
from tests.closed_chains.test_models import ASSEMBLED, assert_near, driven, independent
from tests.generated_code import COMPILERS
from tests.references.closed_chains import DIGITS, Array

MODELS = ("direct_dynamics", "inverse_dynamics", "constraint_forces", "energy")
COMPILED = ("coupled_wrist", "delta", "five_bar", "ring", "sr400")
STATES = range(2)

pytestmark = [pytest.mark.skipif(not COMPILERS, reason="no C compiler"), pytest.mark.sampled(6)]


@cache
def compiled(name: str) -> CompiledPackage:
    models = (*MODELS, "assemble") if name in ASSEMBLED else MODELS
    package = trace_models(machine(name), Scene(models=models)).package
    with TemporaryDirectory() as folder:
        return compile_package(package, Path(folder), flags=("-O0",))


@cache
def wanted(name: str, k: int, model: str) -> dict[str, Any]:
    """Results by name, of the reference."""
    found, tau, qdd = driven(name, k)
    situation = situations(name)[k]
    if model == "direct_dynamics":
        return {"qdd": independent(found, found.direct(situation.tau))}
    if model == "inverse_dynamics":
        torques, accelerations = found.inverse(situation.qdd_motor)
        return {"tau": torques, "qdd": independent(found, accelerations)}
    if model == "energy":
        return {"E": found.energies()}
    if model == "assemble":
        return {"q_dep": [found.at[variable] for variable in found.chain.dependent]}
    wrenches, on_coupled = found.constraint_forces(list(qdd), list(tau))
    return ({"mu": wrenches} if wrenches else {}) | ({"lam": on_coupled} if on_coupled else {})


def given(name: str, k: int, model: str) -> dict[str, Array]:
    """Arguments by name, as many as there may be; an assembly starts a tenth beside the position."""
    situation, (found, tau, qdd) = situations(name)[k], driven(name, k)
    beside = 0.1 if model == "assemble" else 0.0
    q_dep = [float(found.at[variable]) + beside for variable in found.chain.dependent]
    entries: dict[str, Any] = {
        "q": situation.state.u,
        "qd": situation.state.ud,
        "q_dep": q_dep,
        "tau": tau if model == "constraint_forces" else situation.tau,
        "qdd_motor": situation.qdd_motor,
        "qdd": qdd,
    }
    function = next(one for one in compiled(name).package.functions if one.name == model)
    taken = compiled(name).package.inputs(function)
    return {key: np.array(entries[key], dtype=float) for key in taken if key != "p"}


CASES = [(name, model) for name in COMPILED for model in (*MODELS, "assemble")]
CASES = [(name, model) for name, model in CASES if model != "assemble" or name in ASSEMBLED]


@pytest.mark.thorough
@pytest.mark.parametrize(("name", "model"), CASES)
def test_one_state(name: str, model: str) -> None:
    for k in STATES:
        found = compiled(name).call(model, **given(name, k, model))
        for result, entries in wanted(name, k, model).items():
            assert_near(name, found[result], entries)


@pytest.mark.sampled(30)
@pytest.mark.parametrize(("name", "model"), CASES)
def test_many_states(name: str, model: str) -> None:
    """More of them than a block of the batch holds."""
    states = [k for _ in range(37) for k in STATES]
    arguments = [given(name, k, model) for k in STATES]
    rows = {key: np.array([arguments[k][key] for k in states]) for key in arguments[0]}
    found = compiled(name).call_batch(model, **rows)
    for k in STATES:
        for result, entries in wanted(name, k, model).items():
            with mpmath.workdps(DIGITS):
                exact = np.array(entries, dtype=object)
            for row in found[result][k :: len(STATES)]:
                assert_near(name, row, exact)
