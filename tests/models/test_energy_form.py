"""Equations of motion from A and V: those of the recursions, and passive whatever is left out of A and V."""

from __future__ import annotations

from functools import cache

import mpmath
import numpy as np
import pytest

from symoro_elastic.generation.pipeline import prepare, programs
from symoro_elastic.machine.described import DescribedMachine
from symoro_elastic.machine.scene import ALL, Scene
from symoro_elastic.models.programs.forms import DIRECT, INVERSE, EnergyForm, energy_form, has_energy_form
from symoro_elastic.numerics.within.tape import with_switches
from symoro_elastic.symbolic.arithmetic import evaluate, multiprecision
from symoro_elastic.symbolic.expression import Operand
from symoro_elastic.symbolic.program import Names
from tests.numerics.within.cases import EXAMPLES, values_of
from tests.references.random_machines import chain, random_machine

STATES = 50
STEP = mpmath.mpf(10) ** -15
FILES = ("planar_2r.toml", "puma560_measured.toml", "two_axis.toml")


@cache
def machine(name: str) -> DescribedMachine:
    if name.endswith(".toml"):
        return prepare(EXAMPLES / name, lambda line: None, base=name.startswith("puma"))
    if name == "chain":
        return DescribedMachine.of(chain(3, elastic=(2,), symbolic=False))
    found = random_machine(11, joints=5, kinds=("motor",), wrenches=False)
    return DescribedMachine.of(found)


def form_of(name: str) -> EnergyForm:
    return energy_form(machine(name), tuple(p.name for p in machine(name).parameters))


def entries_of(form: EnergyForm) -> list[Operand]:
    return [x for output in form.program.outputs for x in output.entries]


@pytest.mark.sampled(2)
@pytest.mark.parametrize("model", [DIRECT, INVERSE])
@pytest.mark.parametrize("name", [*FILES, "chain", "tree"])
def test_they_are_those_of_the_recursions(name: str, model: str) -> None:
    form = form_of(name)
    assert has_energy_form(machine(name))
    program = programs(machine(name), Scene((model,), fold=ALL)).package.functions[0].program
    rng = np.random.default_rng(0)
    states = {s: rng.uniform(-1, 1, STATES) for argument in program.inputs for s in argument.symbols}
    found = form.results(model, entries_of(form), Names())
    exact = values_of([x for output in program.outputs for x in output.entries], states)
    derived = values_of([x for output in program.outputs for x in found[output.name]], states)
    assert np.abs(derived - exact).max() <= 1e-10 * np.abs(exact).max()


@pytest.mark.parametrize("name", ["planar_2r.toml", "puma560_measured.toml", "tree"])
@pytest.mark.parametrize("seed", range(2))
@mpmath.workdps(50)
def test_whatever_is_left_out_nothing_is_made_from_nothing(name: str, seed: int) -> None:
    """qd' H is the rate of T + V without accelerations, by differences in 50 digits."""
    form, rng = form_of(name), np.random.default_rng(seed)
    switches = with_switches(form.program)
    off = [one for one in switches.changes if rng.random() < 0.2]
    entries = [x for output in switches.without(off) for x in output.entries]
    joints, arithmetic = form.joints, multiprecision()
    state = {f"{s}{j}": mpmath.mpf(rng.uniform(-1, 1)) for s in ("q", "qd", "tau", "qdd") for j in joints}
    still = {f"{s}{j}": mpmath.mpf(0) for s in ("qdd",) for j in joints}
    qd = [state[f"qd{j}"] for j in joints]

    def energy(step: mpmath.mpf) -> mpmath.mpf:
        at = {**state, **{f"q{j}": state[f"q{j}"] + step * state[f"qd{j}"] for j in joints}}
        value = evaluate(entries, at, arithmetic)
        A = form.matrix(entries[:-1])
        pairs = ((i, j) for i in range(len(joints)) for j in range(len(joints)))
        kinetic = sum(value(A[joints[i]][joints[j]]) * qd[i] * qd[j] for i, j in pairs) / 2
        return kinetic + value(entries[-1])

    tau = form.results(INVERSE, entries, Names())["tau"]
    value = evaluate(tau, state | still, arithmetic)
    friction = evaluate([form.exerted[j] for j in joints], state | still, arithmetic)
    power = sum(x * (value(t) + friction(form.exerted[j])) for x, t, j in zip(qd, tau, joints, strict=True))
    rate = (energy(STEP) - energy(-STEP)) / (2 * STEP)
    assert off and form.motors == joints
    assert abs(power - rate) <= 1e-14 * (1 + abs(rate))


def test_not_all_machines_have_one() -> None:
    floating = DescribedMachine.of(prepare(EXAMPLES / "floating_arm.toml", lambda line: None))
    assert not has_energy_form(floating)
    assert not has_energy_form(prepare(EXAMPLES / "palletizer.toml", lambda line: None))
