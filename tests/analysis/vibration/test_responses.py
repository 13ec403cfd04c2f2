"""Frequency responses, poles and zeros: closed forms, the state space, the nonlinear machine at small amplitudes."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.integrate
import scipy.linalg

from symoro_elastic.analysis.vibration.linearization import Linearization
from symoro_elastic.analysis.vibration.modes import modes
from symoro_elastic.analysis.vibration.responses import frequency_grid, frequency_response, with_modal_damping
from symoro_elastic.analysis.vibration.zeros import poles_and_zeros
from symoro_elastic.machine.machine import Kind
from symoro_elastic.numerics.verification.implementations import numpy_model
from tests.analysis.vibration.machines import drive, linearized, machine_of, slide, spring, twins
from tests.analysis.vibration.test_modes import PLACE, two_axis
from tests.references.random_machines import planar_2r, random_machine

pytestmark = pytest.mark.sampled(4)

M1, M2, K, D, FV = 3.0, 5.0, 2e4, 7.0, 4.0


def test_transfer_functions_of_a_drive() -> None:
    """Motor to encoder, motor to load, force on the load to load, and their velocities and accelerations."""
    outs = ["motor", "load.z", "load.vz", "load.az", "load.q"]
    linear = linearized(drive(M1, M2, K, D, FV), {"motor": 0.2}, ["motor", "load.fz"], outs)
    f = np.geomspace(0.1, 100, 300)
    s = 2j * np.pi * f
    G = frequency_response(linear, f).values
    spring = D * s + K
    determinant = (M1 * s**2 + FV * s) * (M2 * s**2 + spring) + spring * M2 * s**2
    motor, load, driven = (M2 * s**2 + spring) / determinant, spring / determinant, None
    driven = (M1 * s**2 + FV * s + spring) / determinant
    wanted = np.stack([motor, load, s * load, s**2 * load, load - motor], axis=1)
    np.testing.assert_allclose(G[:, :, 0], wanted, rtol=1e-10)
    np.testing.assert_allclose(G[:, 1, 1], driven, rtol=1e-10)
    np.testing.assert_allclose(G[:, 0, 1], load, rtol=1e-10)


def by_height(roots: np.ndarray) -> np.ndarray:
    return roots[np.lexsort((roots.real, roots.imag.round(6)))]


def test_the_antiresonance_of_a_drive() -> None:
    """Motor to encoder has a zero where the load swings on its spring; motor to load has none."""
    linear = linearized(drive(M1, M2, K), None, ["motor", "load.fz"], ["motor", "load.z", "load.az"])
    encoder = poles_and_zeros(linear, "motor.tau", "motor.q")
    np.testing.assert_allclose(encoder.antiresonances, [np.sqrt(K / M2) / (2 * np.pi)], rtol=1e-12)
    np.testing.assert_allclose(encoder.resonances, [np.sqrt(K * (M1 + M2) / (M1 * M2)) / (2 * np.pi)], rtol=1e-12)
    assert len(encoder.zeros) == 2 and np.sum(encoder.poles == 0) == 2
    assert len(poles_and_zeros(linear, "motor.tau", "load.z").zeros) == 0
    np.testing.assert_allclose(
        poles_and_zeros(linear, "load.fz", "load.z").antiresonances, [np.sqrt(K / M1) / (2 * np.pi)], rtol=1e-12
    )
    lossy = poles_and_zeros(linearized(drive(M1, M2, K, D, FV), None), "motor.tau", "motor.q")
    np.testing.assert_allclose(by_height(lossy.zeros), by_height(np.roots([M2, D, K])), rtol=1e-10)
    quartic = np.roots([M1 * M2, (M1 + M2) * D + M2 * FV, (M1 + M2) * K + FV * D, FV * K, 0])
    np.testing.assert_allclose(by_height(lossy.poles), by_height(quartic), rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize(("output", "count"), [("load.z", 0), ("load.vz", 1), ("load.az", 2)])
def test_zeros_at_0_are_exact(output: str, count: int) -> None:
    """A mass on a wall's spring; beside it a motor that the force does not move, whose zeros cancel its poles."""
    wall = slide("wall", 0, Kind.ELASTIC, 3, spring=spring(1e6, 4))
    load = slide("load", 1, Kind.ELASTIC, 2, spring=spring(2e4, 1))
    machine = machine_of("beside", wall, load, slide("motor", 0, Kind.MOTOR, 1))
    found = poles_and_zeros(linearized(machine, ins=["wall.fz"], outs=[output]), "wall.fz", output)
    assert found.zeros[:count].tolist() == [0] * count and len(found.poles) == 4
    assert found.zeros[count:] == pytest.approx([-2e4], rel=1e-9), "k + d s"


def test_exact_zeros_at_0_are_left_where_computed_ones_cancel() -> None:
    """Two poles at 0, of an axis that the force does not move, cancel two of four zeros at 0."""
    found = poles_and_zeros(linearized(two_axis(), ins=["motor_x.tau"], outs=["ram.ax"]), "motor_x.tau", "ram.ax")
    assert found.zeros[:2].tolist() == [0, 0] and np.abs(found.zeros[2:]).min() > 100


def test_antiresonances_of_an_encoder_are_modes_of_the_held_motor() -> None:
    linear = linearized(two_axis(), PLACE)
    held = linearized(two_axis(), PLACE, held=["motor_y"])
    found = poles_and_zeros(linear, "motor_y.tau", "motor_y.q").antiresonances
    wanted = modes(held).frequencies
    distances = np.abs(wanted[:, None] - found).min(axis=0)
    assert len(found) >= 5 and (distances <= 1e-6 * found).all()


def test_the_response_is_that_of_the_state_space() -> None:
    outs = ["motor_x", "tool.x", "tool.ay", "sensor_head.qd"]
    linear = with_modal_damping(linearized(two_axis(), PLACE, ["motor_x", "tool.fy"], outs), 0.01)
    space, f = linear.space, np.geomspace(5, 2000, 40)
    found = frequency_response(linear, f).values
    A = space.A.astype(complex)
    wanted = [space.C @ np.linalg.solve(2j * np.pi * x * np.eye(24) - A, space.B) + space.D for x in f]
    scale = np.abs(found).max(axis=0)
    np.testing.assert_allclose(found / scale, np.array(wanted) / scale, atol=1e-9)


def test_modal_damping_is_what_was_asked_for() -> None:
    linear = with_modal_damping(linearized(two_axis(), PLACE), 0.02)
    found = modes(linear)
    np.testing.assert_allclose(found.damping_ratios[2:], 0.02, rtol=1e-6)
    assert with_modal_damping(linear, 0.0) is linear


def test_an_undamped_resonance_in_the_grid_is_passed_over() -> None:
    linear = linearized(drive(M1, M2, K))
    f = modes(linear).frequencies[1]
    found = frequency_response(linear, np.array([0.0, f / 2, f, 2 * f]))
    assert np.isnan(found.values[[0, 2]]).all() and np.isfinite(found.values[[1, 3]]).all()
    assert [note.split(":")[0] for note in found.notes] == ["0 Hz is skipped", f"{f:.9g} Hz is skipped"]
    assert "rigid-body motion" in found.notes[0] and "undamped resonance" in found.notes[1]
    damped = frequency_response(linearized(drive(M1, M2, K, D)), np.array([f]))
    assert np.isfinite(damped.values).all() and not damped.notes


def test_the_default_grid_covers_all_modes() -> None:
    linear = linearized(two_axis(), PLACE)
    grid, found = frequency_grid(linear), modes(linear).frequencies
    assert grid[0] == pytest.approx(found[2] / 10, rel=1e-9) and grid[-1] == pytest.approx(2 * found[-1], rel=1e-9)


def test_what_moves_nothing_has_no_resonance() -> None:
    """A force on one of two twins at right angles moves it alone; a spring as weak as can be still moves a load."""
    linear = linearized(twins(), None, ["one.fy", "table"], ["one.q", "other.q", "table"], held=["table"])
    assert (linear.inputs, linear.outputs) == (("one.fy",), ("one.q", "other.q"))
    one, other = (poles_and_zeros(linear, "one.fy", out) for out in linear.outputs)
    assert not one.is_zero and one.resonances == pytest.approx([np.sqrt(1e4 / 4) / (2 * np.pi)])
    assert other.is_zero and len(other.poles) == len(other.zeros) == 0
    weak = linearized(drive(M1, M2, 1e-9 * K), None, ["motor"], ["load.z"])
    assert not poles_and_zeros(weak, "motor.tau", "load.z").is_zero
    for seed in (501, 505):
        linear = linearized(random_machine(seed, joints=4, kinds=("motor", "elastic", "fixed"), wrenches=False))
        pairs = [poles_and_zeros(linear, i, o) for i in linear.inputs for o in linear.outputs]
        values = np.abs(frequency_response(linear, np.array([0.37, 3.1])).values).max(axis=0).T.ravel()
        assert [pair.is_zero for pair in pairs] == [bool(x < 1e-12 * values.max()) for x in values]


@pytest.mark.parametrize("seed", [501, 505, 509])
def test_poles_zeros_and_a_gain_are_the_response(seed: int) -> None:
    machine = random_machine(seed, joints=4, kinds=("motor", "elastic", "fixed"), wrenches=False)
    linear = with_modal_damping(linearized(machine), 0.02)
    found = poles_and_zeros(linear, linear.inputs[0], linear.outputs[0])
    f = frequency_grid(linear, points=50)
    s = 2j * np.pi * f[:, None]
    gain = (
        frequency_response(linear, f).values[:, 0, 0]
        * np.prod(s - found.poles, axis=1)
        / np.prod(s - found.zeros, axis=1)
    )
    np.testing.assert_allclose(gain / gain[0], 1.0, rtol=1e-6)


def simulated(
    linear: Linearization, amplitude: float, times: np.ndarray, omega: float
) -> tuple[np.ndarray, np.ndarray]:
    """Deflections of the nonlinear machine and of its linear model under amplitude sin(omega t) on motor 1."""
    model, state = numpy_model(linear.motion.given), linear.state
    n, space = len(state.q), linear.space
    motor = linear.motion.motors[0]

    def force(t: float) -> float:
        return amplitude * float(np.sin(omega * t))

    def nonlinear(t: float, y: np.ndarray) -> np.ndarray:
        return np.concatenate([y[n:], model.direct_dynamics(y[:n], y[n:], [state.tau[motor] + force(t)])])

    def linearly(t: float, x: np.ndarray) -> np.ndarray:
        return space.A @ x + space.B[:, 0] * force(t)

    start, small = np.concatenate([state.q, np.zeros(n)]), 1e-9 * amplitude
    options = {"t_eval": times, "rtol": 1e-10, "atol": small, "method": "DOP853"}
    far = scipy.integrate.solve_ivp(nonlinear, (0, times[-1]), start, **options).y.T
    near = scipy.integrate.solve_ivp(linearly, (0, times[-1]), np.zeros(2 * n), **options).y.T
    return far - start, near


def test_the_nonlinear_machine_is_linear_at_small_amplitudes() -> None:
    """A loaded arm with an elastic joint: what the linear model misses falls with the square of the amplitude."""
    machine = planar_2r(elastic=(2,))
    assert machine.joints[0].kind is Kind.MOTOR
    linear = linearized(machine, {"joint1": 0.4}, ["joint1"])
    times = np.linspace(0, 0.5, 51)
    missed = []
    for amplitude in (1e-1, 1e-2, 1e-3):
        far, near = simulated(linear, amplitude, times, omega=30.0)
        missed.append(np.abs(far - near).max() / np.abs(near).max())
    assert missed[2] < 1e-5
    np.testing.assert_allclose([missed[0] / missed[1], missed[1] / missed[2]], 10.0, rtol=0.1)
