"""A spring beside a motor: both turn about one axis, and the spring counts whole turns."""

from __future__ import annotations

import numpy as np
import pytest

from symoro_elastic.formats.toml import reading as toml
from symoro_elastic.numerics.verification.implementations import numpy_model

MACHINE = """
name = "balanced_arm"
gravity = [0, -9.81, 0]
joints = [
  { name = "column", antecedent = 0, kind = "motor", sigma = 0, theta = "q1 + 0.3", alpha = "pi/3", r = 0.1 },
  { name = "arm", kind = "motor", sigma = 0, d = 0.15, alpha = 0.3, theta = "q2" },
"""
BESIDE = """
  { name = "spring", antecedent = "column", kind = "elastic", sigma = 0, %s },
  { name = "weld", antecedent = "spring", kind = "cut", sigma = 2 },
  { name = "end", antecedent = "arm", kind = "fixed", sigma = 2, %s },
"""
REST = """
]
[bodies]
column = { mass = 1, center_of_mass = [0.07, 0, 0.01], inertia = [0.001, 0.003, 0.003] }
arm = { mass = 1, center_of_mass = [0.22, 0.1, 0], inertia = [0.001, 0.02, 0.02] }
"""
CLOSED = """
[loops]
balance = { cut = "weld", meets = "end", dependent = ["spring"], start = { q2 = 0, q3 = %s } }
[springs]
spring = { stiffness = 5, damping = 0.2, neutral = 0.4 }
"""
ALONG = 'd = 0.15, alpha = 0.3, theta = "q3"'
WAYS = {
    "along": (ALONG, "r = 0", "0", 1, 0.0),
    "shifted": ('d = 0.15, alpha = 0.3, r = 0.2, theta = "q3 + pi/2"', "r = 0.2", '"-pi/2"', 1, -np.pi / 2),
    "against": ('d = 0.15, alpha = "0.3 + pi", theta = "q3"', 'alpha = "pi"', "0", -1, 0.0),
    "turned": (ALONG, 'theta = "pi"', '"pi"', 1, np.pi),
}
"""Cells of the spring and of the frame that it meets, its position where the arm is at 0, and its sense and offset."""


@pytest.mark.parametrize("way", WAYS)
def test_the_spring_follows_over_whole_turns(way: str) -> None:
    spring, end, start, sense, offset = WAYS[way]
    alone = numpy_model(toml.read(MACHINE + REST, "alone.toml"), ("inverse_dynamics",))
    text = MACHINE + BESIDE % (spring, end) + REST + CLOSED % start
    sprung = numpy_model(toml.read(text, "sprung.toml"), ("inverse_dynamics",))
    q, qd, qdd = np.array([[0.3, 5.0], [0.3, -9.0], [0.1, 0.2]]), np.array([0.4, -2.0]), [0.5, 3.0]
    (without, _), (tau, _) = alone.inverse_dynamics(q, qd, qdd), sprung.inverse_dynamics(q, qd, qdd)
    of_spring = -5.0 * (sense * q[:, 1] + offset - 0.4) - 0.2 * sense * qd[1]
    assert np.abs(tau[:, 0] - without[:, 0]).max() < 1e-13
    assert np.abs(tau[:, 1] - (without[:, 1] - sense * of_spring)).max() < 1e-13
