"""From a tolerance at the tool to tolerances of torques: closed forms, and simulated worst cases."""

from __future__ import annotations

import numpy as np
import pytest

from symoro_elastic.analysis.ladder.torque_tolerances import (
    Gains,
    acceleration_tolerances,
    added_torques,
    torque_tolerances,
)
from symoro_elastic.analysis.simulation.prediction.path import LinearPath, linear_path
from symoro_elastic.machine.prescribed_motion import Gains as ServoGains
from tests.analysis.ladder.motions import moved
from tests.analysis.ladder.scenes import moving, random_springs
from tests.analysis.vibration.machines import drive

M, KP, ZETA = 7.0, 4e4, 0.3
SAMPLED = 0.01
"""Relative error that the doubling of steps leaves of a total variation."""
SAMPLES = 400


def under_servo() -> LinearPath:
    """A mass of 5 kg on a spring so stiff that it belongs to the motor of 2 kg, under a servo of damping ratio 0.3."""
    kd = 2 * ZETA * np.sqrt(KP * M)
    servo = {"motor": ServoGains(KP, kd)}
    reference = moved(drive(m1=2.0, m2=5.0, k=1e10, d=1e5), 3.0, {"motor": (0.1, 0.5)}, servo=servo)
    return linear_path(reference, ("load.z",), SAMPLES)


def test_gains_of_a_mass_under_a_servo_are_those_of_its_closed_forms() -> None:
    """1/kp times coth for any course, 1 + overshoot for a step, 1/(2 zeta sqrt(1 - zeta^2)) for a sinusoid."""
    gains = Gains(path := under_servo(), added_torques(path))
    halves = np.pi * ZETA / np.sqrt(1 - ZETA**2)
    assert gains.peak.item() == pytest.approx(1 / np.tanh(halves / 2) / KP, rel=SAMPLED)
    assert gains.constant.item() == pytest.approx((1 + np.exp(-halves)) / KP, rel=SAMPLED)
    assert gains.sinusoid.item() == pytest.approx(1 / (2 * ZETA * np.sqrt(1 - ZETA**2)) / KP, rel=SAMPLED)
    resonance = np.sqrt(KP / M * (1 - 2 * ZETA**2)) / (2 * np.pi)
    assert gains.frequency.item() == pytest.approx(resonance, rel=0.03)


@pytest.mark.thorough
def test_a_tolerance_is_that_of_the_output_over_the_gain() -> None:
    (motor,) = torque_tolerances([under_servo()], {"load.z": 1e-5}, np.array([200.0]))
    assert motor.any == pytest.approx(1e-5 * KP * np.tanh(np.pi * ZETA / np.sqrt(1 - ZETA**2) / 2), rel=SAMPLED)
    assert motor.share == motor.any and motor.output == "load.z"
    assert motor.relative == pytest.approx(motor.any / 200.0)


@pytest.mark.parametrize("seed", [20, 25])
def test_no_error_of_any_course_within_the_shares_exceeds_the_tolerance(seed: int) -> None:
    """All motors at once: the worst switching course at a frozen position, and a hundred random ones."""
    scene = moving("", random_springs(seed, 5, (20, 45), 0.02), 0.2, 0.3, 1e-5, ServoGains(3e3, 60.0))
    path = linear_path(scene.reference, scene.outputs, SAMPLES)
    shares = np.array([x.share for x in torque_tolerances([path], scene.tolerances)])
    source = np.random.default_rng(seed)
    added, worst = added_torques(path), 0.0
    for _ in range(100):
        length = source.integers(1, SAMPLES // 4)
        course = np.repeat(source.choice([-1.0, 1.0], (SAMPLES // length + 2, len(shares))), length, axis=0)
        forces = np.einsum("tnm,tm->tn", added, course[: len(path.t)] * shares)
        worst = max(worst, float(np.abs(path.outputs.of(path.without([()], forces))).max()))
    assert 0.1 * scene.tolerance < worst <= scene.tolerance * (1 + SAMPLED)


@pytest.mark.thorough
def test_without_control_accelerations_have_tolerances() -> None:
    """A spring of frequency w without damping: steps of its acceleration move it by 2 / w^2, there and back."""
    w, periods = 2 * np.pi * 10.0, 3.0
    reference = moved(drive(m1=2.0, m2=5.0, k=5.0 * w**2), periods / 10.0, {"motor": (0.1, 0.1)})
    path = linear_path(reference, ("load.z",), SAMPLES)
    (allowed,) = acceleration_tolerances(path, {"load.z": 1e-5}).values()
    assert allowed == pytest.approx(1e-5 * w**2 / (2 * 2 * periods), rel=SAMPLED)
