"""Modes of flexible bodies as steps of the ladder: predicted errors against simulations of all modes."""

from __future__ import annotations

import re
from collections.abc import Mapping

import numpy as np
import pytest

from symoro_elastic.analysis.ladder.greedy import backward_greedy
from symoro_elastic.analysis.ladder.rung import Measured, Rung
from symoro_elastic.analysis.ladder.rungs import Ladder, Measurement, measured_ladder, prediction_of
from symoro_elastic.analysis.simulation.prediction.spring_errors import relative
from symoro_elastic.formats import read_machine
from symoro_elastic.formats.toml.reading import read
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.prescribed_motion import Move, PrescribedMotion
from tests.command_line import EXAMPLES

ARM = """
name = "drawn_arm"
gravity = [0, 0, -9.81]
joints = [
  { name = "shoulder", antecedent = 0, kind = "motor", sigma = 0, axis = "z", at = [0, 0, 0] },
  { name = "elbow", antecedent = "shoulder", kind = "motor", sigma = 0, axis = "AXIS", at = [L1, 0, 0] },
  { name = "tool", antecedent = "elbow", kind = "fixed" },
]
[beams]
shoulder = { along = "x", length = L1, section = { bar = [A1, 0.05] }, E = 7e10, density = 2700, damping = 0.01, MORE }
elbow = { along = "x", length = L2, section = { bar = [A2, 0.04] }, E = 7e10, density = 2700, damping = 0.01, modes = 3}
[bodies]
tool = { mass = MASS, inertia = [1e-4, 2e-4, 2e-4] }
"""
MORE = ('modes = 3, bends = ["y", "z"]', "modes = 2, stiffening = true", "modes = 3")


def drawn_arm(seed: int) -> tuple[Machine, PrescribedMotion]:
    """Two links of drawn length, thickness and load that turn within some periods of their first mode."""
    rng = np.random.default_rng(seed)
    low_high = {"L1": (0.5, 0.9), "L2": (0.4, 0.7), "A1": (0.015, 0.025), "A2": (0.01, 0.016), "MASS": (0.2, 0.6)}
    cells = {name: repr(float(rng.uniform(*pair))) for name, pair in low_high.items()}
    cells |= {"AXIS": "yz"[seed % 2], "MORE": MORE[seed % 3]}
    machine = read(re.sub("|".join(cells), lambda match: cells[match[0]], ARM), f"arm_{seed}.toml")
    lasts = rng.uniform(0.12, 0.3, 2)
    moves = tuple(Move(name, *x) for name, x in (("shoulder", (0.5, 0.0, lasts[0])), ("elbow", (-0.6, 0.0, lasts[1]))))
    return machine, PrescribedMotion(float(lasts.max()) + 0.1, {"shoulder": 0.0, "elbow": 0.4}, moves)


TOLERANCE = dict.fromkeys(("tool.x", "tool.y", "tool.z"), 1e-3)
RESOLVED = 0.1
"""Of the tolerance: smaller errors are below what samples of the linear model resolve (`resolution.py`)."""


def ratio(rung: Rung, measured: Measured, tolerance: Mapping[str, float]) -> float:
    return relative(rung.predicted, tolerance) / relative(measured.model, tolerance)


@pytest.mark.thorough
def test_errors_without_modes_are_those_predicted() -> None:
    machine, motion = drawn_arm(0)
    prediction = prediction_of(machine, [motion], TOLERANCE)
    rungs = [Rung(x.left_out, False, x.static) for x in backward_greedy(prediction.paths, TOLERANCE)]
    rung = next(x for x in rungs if relative(x.predicted, TOLERANCE) > RESOLVED)
    assert ratio(rung, Measurement(prediction).errors(rung), TOLERANCE) == pytest.approx(1, abs=0.1)


def refuse_wrong_ladder(machine: Machine, motion: PrescribedMotion, tolerance: Mapping[str, float]) -> Ladder:
    """The ladder, whose cheapest rung that fits holds what was predicted, as two more rungs do."""
    prediction = prediction_of(machine, [motion], tolerance)
    measurement = Measurement(prediction)
    ladder = measured_ladder(measurement, prediction.rungs())
    assert ladder.chosen and not ladder.distrusted
    between = [x for x in ladder.rungs if RESOLVED < relative(x.predicted, tolerance) < 3 and not x.locked]
    for rung in (ladder.rungs[ladder.chosen], *between[:: max(1, len(between) // 2)]):
        measured = measurement.errors(rung)
        print(
            machine.name, len(rung.left_out), relative(rung.predicted, tolerance), relative(measured.model, tolerance)
        )
        assert relative(rung.predicted, tolerance) < RESOLVED or 0.8 < ratio(rung, measured, tolerance) < 1.25
    return ladder


@pytest.mark.thorough
@pytest.mark.parametrize("seed", range(1, 4))
def test_ladders_of_drawn_arms(seed: int) -> None:
    refuse_wrong_ladder(*drawn_arm(seed), TOLERANCE)


@pytest.mark.thorough
def test_ladder_of_a_carriage_on_a_beam() -> None:
    """A carriage crosses half of the bridge in 0.2 s."""
    machine, _ = read_machine(EXAMPLES / "flexible_gantry.toml")
    moves = (Move("x_axis", 0.5, 0.0, 0.2), Move("y_axis", 0.1, 0.0, 0.2))
    motion = PrescribedMotion(0.3, {"x_axis": 0.1, "y_axis": 0.0, "z_axis": 0.0}, moves)
    ladder = refuse_wrong_ladder(machine, motion, dict.fromkeys(TOLERANCE, 5e-6))
    assert any(name.startswith("bridge_") for name in ladder.rungs[ladder.chosen or 0].left_out)
