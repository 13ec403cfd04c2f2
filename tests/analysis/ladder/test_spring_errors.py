"""Errors of springs that are left out are predicted: against the nonlinear machine, Pinocchio's A and H, DOP853."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

import numpy as np
import pytest

from symoro_elastic.analysis.ladder.greedy import backward_greedy
from symoro_elastic.analysis.simulation.prediction.path import linear_path
from symoro_elastic.analysis.simulation.prediction.spring_errors import Deviations, relative, spring_errors
from symoro_elastic.machine.formula import ZERO
from symoro_elastic.machine.prescribed_motion import AppliedForce, Bandwidth
from symoro_elastic.machine.restrict import restrict
from symoro_elastic.machine.scene import Scene as Request
from tests.analysis.ladder.motions import moved
from tests.analysis.ladder.scenes import Scene, arm, flex4, moving, random_springs, tuned, two_axis
from tests.analysis.ladder.truth import Truth, pinocchio_dynamics

pytestmark = pytest.mark.sampled(5)

SERVO = Bandwidth(15, 0.7)
SMALLEST = 1e-11
"""Errors of positions that are compared, m."""


def slow_tool() -> Scene:
    """The two-axis machine without its fastest springs, pushed while it moves."""
    machine = restrict(two_axis(), Request(locked=dict.fromkeys(("sensor_head", "y_chain_1", "ram"), ZERO)))
    push = AppliedForce("tool", (200.0, 0.0, 100.0, 0.0, 0.0, 0.0), 0.01, 0.03)
    moves = {"motor_x": (0.03, 0.04), "motor_y": (0.02, 0.04)}
    reference = moved(machine, 0.06, moves, {"motor_y": 0.1}, forces=[push])
    return Scene("two_axis", reference, ("tool.x", "tool.y", "motor_x.tau"), 1e-5)


SCENES: dict[str, Callable[[], Scene]] = {
    "flex4": lambda: moving("flex4", tuned(flex4(), (40,)), 0.2, 0.07, 1e-5),
    "flex4, servos": lambda: moving("flex4", tuned(flex4(), (40,)), 0.2, 0.15, 1e-5, SERVO),
    "rx90": lambda: moving("rx90", arm("rx90.par", (40, 60), 0.01), 0.1, 0.06, 1e-5),
    "random 1": lambda: moving("random", random_springs(1, 6, (30, 50, 70)), 0.1, 0.06, 1e-5),
    "random 3": lambda: moving("random", random_springs(3, 7, (20, 80, 50), 0.02), 0.1, 0.06, 1e-5),
    "two_axis": slow_tool,
}


@cache
def ratios(name: str) -> tuple[float, ...]:
    """Predicted errors over measured ones: some rungs, locked and static, all outputs."""
    scene = SCENES[name]()
    path = linear_path(scene.reference, scene.outputs, 400)
    rungs = backward_greedy([path], scene.tolerances)
    chosen = [rungs[0], rungs[1], rungs[-1]]
    sets = [[path.joints.index(spring) for spring in rung.left_out] for rung in chosen]
    t = np.linspace(0.0, scene.reference.duration, 61)
    truth = Truth(scene.reference, sets, t, pinocchio_dynamics(scene.reference.machine), 1e-8)
    found = []
    for rung, *kinds in zip(chosen[1:], *(x[1:] for x in truth.errors(scene.outputs)), strict=True):
        for predicted, measured in zip((rung.locked, rung.static), kinds, strict=True):
            for output, error in zip(scene.outputs, measured.tolist(), strict=True):
                if error > SMALLEST:
                    found.append(predicted[output] / error)
    return tuple(found)


@pytest.mark.thorough
@pytest.mark.parametrize("name", SCENES)
def test_predictions_hold_on_the_nonlinear_machine(name: str) -> None:
    """Within a factor 2: springs locked and static, positions and torques."""
    assert len(ratios(name)) > 4 and min(ratios(name)) > 1 / 2 and max(ratios(name)) < 2


@pytest.mark.thorough
def test_nine_of_ten_predictions_are_within_a_tenth() -> None:
    assert np.mean([1 / 1.1 < ratio < 1.1 for name in SCENES for ratio in ratios(name)]) >= 0.9


def test_several_motions_count_by_the_worst() -> None:
    """A slow move is cheap, and the same springs are not when it is fast."""
    machine = tuned(flex4(), (40,))
    paths = [
        Deviations(linear_path(scene.reference, scene.outputs, 200))
        for scene in (moving("slow", machine, 0.1, 0.6, 1e-5), moving("fast", machine, 0.1, 0.1, 1e-5))
    ]
    (both,), (slow,), (fast,) = (spring_errors(chosen, [(1, 3)]) for chosen in (paths, paths[:1], paths[1:]))
    for kind in ("locked", "static"):
        found = [getattr(errors, kind) for errors in (both, slow, fast)]
        assert found[0] == {name: max(found[1][name], found[2][name]) for name in found[0]}
    assert fast.static["j4.x"] > 10 * slow.static["j4.x"]


def test_relative_errors_are_those_of_the_worst_output() -> None:
    assert relative({"a": 3.0, "b": 4.0, "c": 1e9}, {"a": 1.0, "b": 8.0}) == 3.0
