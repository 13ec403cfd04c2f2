"""verify() on machines with couplings and loops: what is right passes, a wrong coupling or branch is found."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import mpmath
import numpy as np
import pytest

from symoro_elastic.codegen import compile as compiling
from symoro_elastic.formats.toml.reading import read
from symoro_elastic.machine.scene import Scene
from symoro_elastic.models.bound.bind import Bound
from symoro_elastic.models.loops import plan as plans
from symoro_elastic.models.loops.coordinates import Coordinates
from symoro_elastic.models.programs.catalogue import trace
from symoro_elastic.numerics.evaluation.values import parameter_values
from symoro_elastic.numerics.verification.coupled_disagreement import branch_error
from symoro_elastic.numerics.verification.reference import Reference
from symoro_elastic.numerics.verification.states import extreme_states, moderate_states
from symoro_elastic.numerics.verification.verify import verify
from symoro_elastic.symbolic.decimals import in_digits
from tests.closed_chains.machines import FILES, machine
from tests.references.closed_chains import DIGITS, Chain, State
from tests.references.constraint_multipliers import Multipliers
from tests.references.random_machines import led_by_the_first, random_machine

pytestmark = pytest.mark.sampled(8)


@pytest.mark.sampled(30)
@pytest.mark.optimised
@pytest.mark.parametrize("name", FILES)
def test_all_machines_pass(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Only the C of the SR400 is optimised, as `check` does: compilers take half the time."""
    if name != "sr400":
        monkeypatch.setattr(compiling, "optimisation", lambda package: "-O0")
    found = verify(machine(name), Scene(), states=(4, 8))
    assert found.ok and not found.missing and found.disagreement < 1e-40
    for model in found.models:
        assert model.moderate == 4 and model.extreme >= 6
        for worst in (model.numpy, model.c, model.equations):
            assert worst is not None and worst.moderate < 1e-12


@pytest.mark.thorough
@pytest.mark.parametrize("seed", [43, 51, 58, *range(7)])
def test_random_transmissions_pass(seed: int) -> None:
    """The last joint follows the first one: fixed frames, springs and motors lie between them."""
    coupled = led_by_the_first(random_machine(seed, joints=5))
    found = verify(coupled, Scene(), states=(2, 4))
    assert found.ok and not found.missing and found.disagreement < 1e-40


@pytest.mark.sampled(30)
@pytest.mark.parametrize("name", FILES)
@in_digits(50)
def test_reference_is_that_of_multipliers(name: str) -> None:
    """The rounded q_dep leaves the loops open by 1e-16, so no more digits agree where they are an argument."""
    whole = machine(name)
    values, states = parameter_values(whole), moderate_states(whole, 1)
    reference = Reference(whole, values, (), solved=True)
    own = [str(whole.joint(j).variable) for j in whole.independent]
    dependent = [str(whole.joint(j).variable) for j in whole.dependent]
    for k in range(1):
        state = states[k].blocks
        guess = dict(zip(dependent, state.get("q_dep", np.empty(0)).tolist(), strict=True))
        exact = Multipliers(whole, State(state["q"].tolist(), state["qd"].tolist(), guess | _cuts(whole)))
        accelerations = dict(zip(exact.chain.own, exact.direct(state["tau"].tolist()), strict=True))
        wanted = [float(accelerations[name]) for name in own]
        found = reference.at(state).model(trace(whole, "direct_dynamics"))["qdd"]
        assert np.allclose([float(x) for x in found], wanted, rtol=1e-10, atol=1e-11 * max(map(abs, wanted)))


def _cuts(whole: Any) -> dict[str, float]:
    given = {name: value.value() for loop in whole.loops for name, value in loop.start.items()}
    return {name: given.get(name, 0.0) for name in Chain(whole).cuts}


@pytest.mark.sampled(16)
@pytest.mark.parametrize("draw", [moderate_states, extreme_states])
@pytest.mark.parametrize("name", [name for name in FILES if machine(name).loops])
def test_loops_close_at_every_state(name: str, draw: Any) -> None:
    whole, chain = machine(name), Chain(machine(name))
    states = draw(whole, 2)
    assert states.q_dep.shape == (2, len(whole.dependent)) and len(np.unique(states.q, axis=0)) == 2
    for k in range(2):
        guess = dict(zip(chain.dependent, states.q_dep[k].tolist(), strict=True))
        with mpmath.workdps(DIGITS):
            found = chain.assemble(State(states.q[k].tolist(), states.qd[k].tolist(), guess | _cuts(whole)))
            away = max(abs(found[name] - x) / max(abs(x), 1) for name, x in guess.items())
        assert away < 2e-16


@pytest.mark.sampled(2)
@pytest.mark.parametrize("quantity", ["gam_x", "S_x"])
def test_a_wrong_coupling_is_found(quantity: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """The code and the reference share the traced coupling, which differences of positions contradict."""
    right = getattr(Coordinates, quantity).func

    def wrong(self: Coordinates) -> Mapping[int, Any]:
        found = dict(right(self))
        if self.machine.loops:
            last = self.machine.dependent[-1]
            found[last] = {k: 2 * x for k, x in found[last].items()} if quantity == "S_x" else 2 * found[last]
        return found

    monkeypatch.setattr(Coordinates, quantity, property(wrong))
    found = verify(machine("four_bar"), Scene(), states=(2, 2))
    assert not found.ok and found.disagreement > 1e-6


def test_another_branch_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    whole = machine("four_bar")
    states = moderate_states(whole, 1)
    right = plans._with_form

    def mirrored(*given: Any) -> Any:
        plan = right(*given)
        return replace(plan, signs={j: -sign for j, sign in plan.signs.items()})

    assert branch_error(Reference(whole, {}, (), solved=True), states[0].blocks) == 0.0
    monkeypatch.setattr(plans, "_with_form", mirrored)
    again = replace(whole)  # plans are kept for each object
    assert Bound(again).loops[0].signs
    assert branch_error(Reference(again, {}, (), solved=True), states[0].blocks) == 1.0


BENT_SQUARE = """
name = "square"
gravity = [0, 0, 0]
joints = [
  { name = "a", antecedent = 0, kind = "motor", sigma = 0, axis = "z", at = [0, 0, 0], variable = "q1" },
  { name = "b", antecedent = "a", kind = "passive", sigma = 0, axis = "z", at = [0.5, 0, 0], variable = "q2" },
  { name = "c", antecedent = 0, kind = "passive", sigma = 0, axis = "z", at = [0, 0.5, 0], variable = "q3" },
  { name = "pin", antecedent = "c", kind = "cut", sigma = 0, axis = "z", at = [0.5, 0.5, 0], variable = "q4" },
  { name = "pin_end", antecedent = "b", kind = "fixed", at = [0.5, 0.5, 0] },
]
loops = { p = { cut = "pin", meets = "pin_end", dependent = ["b", "c"], start = { q1 = 0, q2 = 0, q3 = 0 } } }
beams = { a = { along = "x", length = 0.5, EI = 50, mass_per_length = 0.5, modes = 1, bends = ["y"] } }
bodies = { b = { mass = 0.5, inertia = [1, 2, 3] }, c = { mass = 0.5, inertia = [1, 2, 3] } }
"""


@pytest.mark.thorough
def test_what_rounded_sines_change_is_no_error_of_the_code() -> None:
    """Accelerations that vanish with the deflection of a beam are differences of sines: an ulp of these is larger."""
    found = verify(read(BENT_SQUARE, "square.toml"), Scene(models=("coupling_matrix",)))
    (model,) = found.models
    assert model.equations.extreme > 1e-12 and found.ok


def test_parameters_that_place_frames_close_the_loops() -> None:
    """Drawn values of other parameters do not change those with which the loops were closed."""
    whole = machine("press")
    assert parameter_values(whole, seed=3).keys() == {p.name for p in whole.parameters}
    for seed in (0, 3):
        states = moderate_states(whole, 2, seed)
        reference = Reference(whole, parameter_values(whole, seed), (), solved=True)
        assert branch_error(reference, states[1].blocks) == 0.0
