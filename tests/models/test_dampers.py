"""Dampers of floating bases and of ball joints: powers, parts of forces, derivatives."""

from __future__ import annotations

import inspect
from collections.abc import Sequence
from fractions import Fraction
from typing import Any

import mpmath
import numpy as np
import pytest

from symoro_elastic.formats.toml.reading import read
from symoro_elastic.machine.machine import Machine
from symoro_elastic.numerics.verification.implementations import numpy_model
from tests.models.test_derivatives import EXACT, assert_close, numbers

STEP = Fraction(1, 10**16)
PARTS = ("coriolis_forces", "gravity_forces", "friction_forces", "external_forces")
BALL = """
name = "ball"
gravity = [0.4, 0, -9.81]
joints = [
  { name = "a", kind = "motor", sigma = 0, alpha = 0.3, theta = "q1" },
  { name = "x", kind = "passive", sigma = 0, d = 0.2, alpha = "pi/2", theta = "q2" },
  { name = "y", kind = "passive", sigma = 0, alpha = "pi/2", theta = "q3" },
  { name = "z", kind = "passive", sigma = 0, alpha = "pi/2", theta = "q4" },
]
[bodies]
a = { mass = 2, center_of_mass = [0.1, 0.2, 0], inertia = [0.1, 0.2, 0.25] }
z = { mass = 1, center_of_mass = [0.1, 0, 0.2], inertia = [0.1, 0.12, 0.15] }
[friction]
z = { ball = 0.4 }
[wrenches]
z = { force = [1, 2, 3], moment = [0.1, 0, 0.2] }
"""
FLYING = (
    BALL
    + """
[base]
floating = "rotation"
body = { mass = 3, center_of_mass = [0.1, 0, 0], inertia = [0.2, 0.3, 0.4] }
linear_damping = 0.7
angular_damping = 0.2
"""
)
STATE: dict[str, Any] = {
    "q": np.array([0.3, -0.5, 0.7, 1.1]),
    "qd": np.array([1.0, -0.4, 0.6, 0.9]),
    "R0": np.array([[0.36, 0.48, -0.8], [-0.8, 0.6, 0.0], [0.48, 0.64, 0.6]]),
    "V0": np.array([0.3, -0.2, 0.5, 1.0, -0.7, 0.4]),
}


@pytest.mark.parametrize("text", [BALL, FLYING])
def test_parts_of_forces_are_the_whole(text: str) -> None:
    model = numpy_model(read(text, "m.toml"), ("bias_forces", *PARTS))

    def forces(name: str) -> Any:
        function = getattr(model, name)
        return function(**{key: STATE[key] for key in inspect.signature(function).parameters if key in STATE})

    whole = forces("bias_forces")
    assert sum(map(forces, PARTS)) == pytest.approx(whole, abs=1e-14 * np.abs(whole).max())


def test_dampers_take_power_in_proportion_to_the_square_of_velocities() -> None:
    """c w . w of the bodies that the ball joint is between, and of the base, d v . v."""
    machine = read(FLYING, "m.toml")
    model = numpy_model(machine, ("friction_forces", "velocities"), {"velocities": ("z in a",)})
    q, qd, V0 = STATE["q"], STATE["qd"].copy(), STATE["V0"]
    forces = model.friction_forces(q, qd, V0)
    qd[0] = 0
    w = model.velocities(q, qd, 0 * V0)[0][3:]
    power = 0.7 * V0[:3] @ V0[:3] + 0.2 * V0[3:] @ V0[3:] + 0.4 * w @ w
    assert forces @ [*V0, *STATE["qd"]] == pytest.approx(power, rel=1e-14)


@pytest.mark.sampled(2)
@pytest.mark.parametrize("name", ["inverse_dynamics", "direct_dynamics"])
def test_derivatives_of_ball_dampers_are_differences(name: str) -> None:
    machine: Machine = read(BALL, "m.toml")
    state = [[*map(Fraction, row)] for row in (STATE["q"].tolist(), STATE["qd"].tolist(), [0.7])]
    for of, found in numbers(machine, f"{name}_derivatives", state).items():
        result, _, by = of.removeprefix("d").partition("_d")
        k = ("q", "qd").index(by) if by in ("q", "qd") else 2
        columns = []
        for entry in range(len(state[k])):
            ahead, behind = (moved(machine, name, state, (k, entry), sign * STEP)[result] for sign in (1, -1))
            with mpmath.workdps(50):
                columns.append((ahead - behind) * STEP.denominator / 2)
        assert_close(found, np.array(columns, dtype=object).T[-found.shape[0] :], EXACT)


def moved(machine: Machine, name: str, state: Sequence[Sequence[Fraction]], at: tuple[int, int], by: Fraction) -> Any:
    """The results of a model where one entry of its arguments is another."""
    entries = [[x + by * ((k, i) == at) for i, x in enumerate(row)] for k, row in enumerate(state)]
    return numbers(machine, name, entries)
