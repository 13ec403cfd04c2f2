"""A robot with published results: the PUMA 560, as the tables and pages of the Robotics Toolbox have it.

B. Armstrong, O. Khatib, J. Burdick, The explicit dynamic model and inertial parameters of the PUMA 560 arm, ICRA 1986;
P. Corke, Robotics, Vision and Control, chapter 9: gravity torques, inertia matrix, velocity torques, four digits.
"""

from __future__ import annotations

import math
from functools import cache
from typing import Any

import numpy as np
import pytest

import symoro_elastic as se
from tests.formats.robots.puma import robot

pytestmark = pytest.mark.filterwarnings("ignore::symoro_elastic.api.machines.MachineWarning")

RIGHT = math.pi / 2
NOMINAL, READY = [0, math.pi / 4, math.pi, 0, math.pi / 4, 0], [0, RIGHT, -RIGHT, 0, 0, 0]
HOLDING = {"nominal": (NOMINAL, [0, 31.6399, 6.0351, 0, 0.0283, 0]), "ready": (READY, [0, -0.7752, 0.2489, 0, 0, 0])}
INERTIA = [
    [3.6594, -0.4044, 0.1006, -0.0025, 0, 0],
    [-0.4044, 4.4137, 0.3509, 0, 0.0024, 0],
    [0.1006, 0.3509, 0.9378, 0, 0.0015, 0],
    [-0.0025, 0, 0, 0.1925, 0, 0],
    [0, 0.0024, 0.0015, 0, 0.1713, 0],
    [0, 0, 0, 0, 0, 0.1941],
]
TURNING = [0.6280, -0.3607, -0.0003, 0, 0]
"""Torques of joints 2 to 6 where joint 1 turns by 1 rad/s at the nominal position, without gravity."""
DIGITS = 0.51e-4


@cache
def puma() -> Any:
    return se.load(robot(), "inverse_dynamics", "inertia_matrix")


def torques(q: list[float], qd: list[float]) -> np.ndarray:
    found = puma().inverse_dynamics(q, qd, [0.0] * 6)
    return np.asarray(found[0] if isinstance(found, tuple) else found)


@pytest.mark.parametrize("position", HOLDING)
def test_gravity_of_a_puma(position: str) -> None:
    q, published = HOLDING[position]
    np.testing.assert_allclose(torques(q, [0.0] * 6), published, atol=DIGITS)


def test_inertia_of_a_puma() -> None:
    np.testing.assert_allclose(puma().inertia_matrix(NOMINAL), INERTIA, atol=DIGITS)


def test_velocity_torques_of_a_puma() -> None:
    found = torques(NOMINAL, [1.0, 0, 0, 0, 0, 0]) - torques(NOMINAL, [0.0] * 6)
    np.testing.assert_allclose(found[1:], TURNING, atol=DIGITS)
