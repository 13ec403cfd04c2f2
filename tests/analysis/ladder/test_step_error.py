"""The error of a method at a step is predicted: against generated steps on the nonlinear machine."""

from __future__ import annotations

from functools import cache
from types import ModuleType

import numpy as np
import pytest

from symoro_elastic.analysis.simulation.prediction.path import LinearPath, linear_path
from symoro_elastic.analysis.simulation.prediction.spring_errors import relative
from symoro_elastic.analysis.simulation.prediction.step_error import StepErrors, fewest_steps
from symoro_elastic.analysis.simulation.reference_motion import Reference
from symoro_elastic.analysis.simulation.simulate import Request as Simulated
from symoro_elastic.analysis.simulation.simulate import simulate
from symoro_elastic.codegen.integration.tableaus import METHODS
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.machine.formula import ZERO
from symoro_elastic.machine.prescribed_motion import Bandwidth
from symoro_elastic.machine.restrict import restrict
from symoro_elastic.machine.scene import Scene as Request
from tests.analysis.ladder.generated_steps import stepped_motion, with_steps
from tests.analysis.ladder.motions import moved
from tests.analysis.ladder.scenes import all_motors, flex4, tuned
from tests.analysis.ladder.truth import Truth, generated_dynamics
from tests.analysis.vibration.machines import drive

pytestmark = pytest.mark.sampled(5)

OUTPUTS = ("j4.x", "j4.y")
SAMPLES, EVENLY = 400, 80
"""Samples of the model; times of the true motion."""
SERVO = Bandwidth(20, 0.7)
CASES = [
    *((name, False) for name in ("w3", "rk4", "rodas4", "midpoint")),
    *((name, True) for name in ("w2", "rodas4", "midpoint")),
]


@cache
def reference(servo: bool) -> Reference:
    machine = tuned(flex4(), (40, 60), damping=0.01)
    servos = {joint.name: SERVO for joint in machine.motor_joints} if servo else None
    return moved(machine, 0.12, all_motors(machine, 0.2, 0.1), {"j3": 0.5}, servos)


@cache
def path(servo: bool) -> LinearPath:
    return linear_path(reference(servo), OUTPUTS, SAMPLES)


@cache
def true_positions(servo: bool) -> Array:
    moving = reference(servo)
    truth = Truth(moving, [[]], np.linspace(0, moving.duration, EVENLY + 1), generated_dynamics(moving.machine), 1e-10)
    return truth.outputs(OUTPUTS, truth.q)[:, 0]


@cache
def generated(servo: bool) -> ModuleType:
    return with_steps(reference(servo).machine, *(name for name, with_servo in CASES if with_servo is servo))


def measured(name: str, servo: bool, steps: int) -> Array:
    module = generated(servo)
    q = stepped_motion(module, METHODS[name], reference(servo), steps)
    placed = module.geometric_model(q)[:, -1, :2, 3]
    every = max(EVENLY // steps, 1)
    return np.abs(placed[:: max(steps // EVENLY, 1)] - true_positions(servo)[::every]).max(axis=0)


@pytest.mark.sampled(1000)
@pytest.mark.parametrize(("name", "servo"), CASES)
def test_predictions_hold_for_generated_steps(name: str, servo: bool) -> None:
    """On every output, at two steps: to a fifth, as servos let motors deviate by some mm."""
    for steps in (40, 80):
        predicted = list(StepErrors(path(servo)).errors(METHODS[name], steps).values())
        np.testing.assert_allclose(predicted, measured(name, servo, steps), rtol=0.2)


@pytest.mark.parametrize("name", METHODS)
def test_errors_fall_by_the_order_of_the_method(name: str) -> None:
    """Over one halving; of rodas4 over three, for at 160 steps it is near the 2e-10 of the solution compared with."""
    errors, halvings = StepErrors(path(True)), 3 if name == "rodas4" else 1
    several = (160 // 2**halvings, 160)
    coarse, fine = (np.array(list(errors.errors(METHODS[name], steps).values())) for steps in several)
    observed = np.log2(coarse / fine) / halvings
    assert (np.abs(observed - METHODS[name].order) < 0.3).all()


@pytest.mark.thorough
def test_springs_that_are_left_out_stay_out() -> None:
    """Errors with a spring left out are those of the machine that has it locked."""
    whole = reference(False)
    stiff = restrict(whole.machine, Request(locked={"j2": ZERO}))
    alone = linear_path(moved(stiff, 0.12, all_motors(stiff, 0.2, 0.1), {"j3": 0.5}), OUTPUTS, SAMPLES)
    found = StepErrors(path(False), (1,)).errors(METHODS["w3"], 60)
    exact = StepErrors(alone).errors(METHODS["w3"], 60)
    for name in OUTPUTS:
        assert found[name] == pytest.approx(exact[name], rel=0.05)


@pytest.mark.thorough
def test_static_springs_deflect_by_the_errors_of_accelerations() -> None:
    """Rows from M, D, K of the whole machine are those from the reactions of the machine that has the spring static.

    Without the deflections the errors are others; the two are linear about motions that differ by a deflection.
    """
    whole = reference(True)
    static = restrict(whole.machine, Request(static={"j2": ZERO}))
    servos = {joint.name: SERVO for joint in static.motor_joints}
    moving = moved(static, 0.12, all_motors(static, 0.2, 0.1), {"j3": 0.5}, servos)
    found = StepErrors(path(True).recovering((1,)), (1,)).errors(METHODS["w2"], 60)
    exact = StepErrors(linear_path(moving, OUTPUTS, SAMPLES)).errors(METHODS["w2"], 60)
    held = StepErrors(path(True), (1,)).errors(METHODS["w2"], 60)
    for name in OUTPUTS:
        assert found[name] == pytest.approx(exact[name], rel=0.05)
    assert any(held[name] != pytest.approx(exact[name], rel=0.2) for name in OUTPUTS)


def test_predictions_hold_for_static_springs() -> None:
    """A load on a static spring behind a motor with a servo: most of its error is that of the deflection."""
    servo = {"motor": Bandwidth(20.0, 0.8)}
    static, locked = (
        simulate(
            moved(restrict(drive(), scene), 0.5, {"motor": (0.1, 0.2)}, servo=servo),
            Simulated(("load.z",), method="w2", step=0.5 / 40),
        )
        for scene in (Request(static={"load": None}), Request(locked={"load": ZERO}))
    )
    for found in (static, locked):
        assert found.predicted["load.z"] == pytest.approx(found.errors["load.z"], rel=0.25)
    assert static.errors["load.z"] > 3 * locked.errors["load.z"]


@pytest.mark.parametrize("name", ["w3", "rk4"])
def test_the_fewest_steps_are_enough_and_fewer_are_not(name: str) -> None:
    errors, tolerance = StepErrors(path(False)), dict.fromkeys(OUTPUTS, 1e-7)
    choice = fewest_steps(errors, METHODS[name], tolerance, 0.25)
    assert choice.is_tried and relative(choice.errors, tolerance) <= 0.25
    assert relative(errors.errors(METHODS[name], int(choice.steps / 1.2)), tolerance) > 0.25


@pytest.mark.parametrize("enough", range(10, 40))
def test_the_search_ends_wherever_errors_get_small_enough(enough: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Errors that fall at one number of steps, from 10 to 39: the next ones are found in a few tries."""
    tried: list[int] = []

    def errors(of: StepErrors, method: object, steps: int) -> dict[str, float]:
        tried.append(steps)
        assert len(tried) < 20
        return {"x": 0.9 if steps >= enough else 1.1}

    monkeypatch.setattr(StepErrors, "errors", errors)
    choice = fewest_steps(StepErrors(path(False)), METHODS["w3"], {"x": 1.0}, 1.0)
    assert enough <= choice.steps <= max(1.15 * enough + 1, enough + 1)


def test_steps_beyond_those_tried_follow_from_the_order(monkeypatch: pytest.MonkeyPatch) -> None:
    errors, tolerance = StepErrors(path(False)), dict.fromkeys(OUTPUTS, 1e-6)
    tried = fewest_steps(errors, METHODS["w2"], tolerance, 0.25)
    monkeypatch.setattr("symoro_elastic.analysis.simulation.prediction.step_error.MOST_STEPS", tried.steps // 2)
    choice = fewest_steps(errors, METHODS["w2"], tolerance, 0.25)
    assert not choice.is_tried and choice.steps == pytest.approx(tried.steps, rel=0.2)


@pytest.mark.thorough
def test_unstable_steps_have_no_error_that_is_a_number() -> None:
    assert set(StepErrors(path(False)).errors(METHODS["rk4"], 3).values()) != {0.0}
    stiff = linear_path(moved(tuned(flex4(), (4e4,)), 0.15, {"j1": (0.2, 0.12)}), OUTPUTS, SAMPLES)
    assert set(StepErrors(stiff).errors(METHODS["rk4"], 500).values()) == {np.inf}
    assert max(StepErrors(stiff).errors(METHODS["w3"], 500).values()) < 1e-9
