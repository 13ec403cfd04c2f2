"""The linear model along a motion is the linearization at each place, by dual numbers; outputs and forces too."""

from __future__ import annotations

import numpy as np
import pytest

from symoro_elastic.analysis.simulation.prediction.path import LinearPath, linear_path
from symoro_elastic.analysis.simulation.reference_motion import Reference
from symoro_elastic.analysis.vibration.linearization import Linearization, linearize
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.machine.machine import Kind
from symoro_elastic.machine.prescribed_motion import AppliedForce, Gains
from symoro_elastic.numerics.motion.equations_of_motion import State, motion_of
from tests.analysis.ladder.motions import moved
from tests.analysis.ladder.scenes import all_motors, flex4, tuned
from tests.analysis.vibration.machines import machine_of, slide

SIGNALS = ("j4.x", "j3 at (0.1, 0.2, 0).z", "j4.rx", "j4.vy", "j4.wz", "j4.ax", "j4.wdy")
SAMPLES, PLACE = 8, 3


def bent() -> Reference:
    machine = tuned(flex4(), (40,), damping=0.05)
    return moved(machine, 0.4, all_motors(machine, 0.8, 0.3), {"j1": 0.3, "j3": -0.4})


def state_of(q: Array, qd: Array, qdd: Array) -> State:
    return State(q, qd, qdd, 0 * q, np.zeros(2))


def state_at(path: LinearPath, place: int) -> State:
    q, v, a = (x[0] for x in path.states(path.t[place : place + 1]))
    return state_of(q, v, a)


def by_duals(path: LinearPath, place: int, outputs: tuple[str, ...] = ()) -> Linearization:
    motion = motion_of(path.reference.machine, outs=outputs)
    return linearize(motion, state_at(path, place), (), outputs)


@pytest.mark.thorough
def test_the_next_step_is_about_the_motion_that_the_first_gave() -> None:
    """M, D, K and the forces are those of the deviated place; without springs left out d hardly changes."""
    first, path = linear_path(bent(), (), 200, newton_steps=1), linear_path(bent(), (), 200)
    d, place = first.without([()]), 60
    q, v, a = (x[0] for x in first.states(first.t[place : place + 1]))
    at = state_of(q + d.d[place, 0], v + d.dd[place, 0], a + d.ddd[place, 0])
    motion = motion_of(path.reference.machine)
    linear = linearize(motion, at, (), ())
    for found, exact in zip((path.M, path.D, path.K), (linear.M, linear.D, linear.K), strict=True):
        np.testing.assert_allclose(found[place], exact, rtol=1e-12, atol=1e-12 * np.abs(exact).max())
    driven = linear.M @ d.ddd[place, 0] + linear.D @ d.dd[place, 0] + linear.K @ d.d[place, 0]
    exact = path.reference.start.tau - motion.forces(at.q, at.qd, at.qdd) + driven
    np.testing.assert_allclose(path.R[place], exact, rtol=1e-10, atol=1e-10 * np.abs(exact).max())
    change, largest = path.without([()]).d - d.d, np.abs(d.d).max()
    assert 0 < np.abs(change).max() < 0.05 * largest


def test_motions_that_leave_the_linear_model_are_about_the_reference() -> None:
    """A mass without a spring is left behind by 12 m."""
    machine = machine_of("cart", slide("motor", 0, Kind.MOTOR, 3.0), slide("load", 1, Kind.PASSIVE, 5.0))
    far, near = (moved(machine, 1.0, {"motor": (by, 1.0)}) for by in (12.0, 2.0))
    path = linear_path(far, ("load.z",), 50)
    np.testing.assert_allclose(path.without([()]).d[-1, 0], [0.0, -12.0], rtol=1e-3)
    np.testing.assert_allclose(linear_path(near, ("load.z",), 50).without([()]).d[-1, 0], [0.0, -2.0], rtol=1e-3)


def names_of(reference: Reference) -> tuple[str, ...]:
    return tuple(joint.name for joint in reference.machine.independent_joints)


def test_matrices_are_those_of_the_place() -> None:
    path = linear_path(bent(), (), SAMPLES, newton_steps=1)
    for place in (0, PLACE):
        linear = by_duals(path, place)
        for found, exact in zip((path.M, path.D, path.K), (linear.M, linear.D, linear.K), strict=True):
            np.testing.assert_allclose(found[place], exact, rtol=1e-12, atol=1e-12 * np.abs(exact).max())


def test_rows_of_outputs_are_those_of_the_place() -> None:
    """Positions exactly; velocities and accelerations up to the rounding of central differences."""
    path = linear_path(bent(), SIGNALS, SAMPLES, newton_steps=1)
    linear = by_duals(path, PLACE, SIGNALS)
    outputs = path.outputs
    for found, exact in zip((outputs.Cq, outputs.Cv, outputs.Ca), (linear.Cq, linear.Cv, linear.Ca), strict=True):
        np.testing.assert_allclose(found[PLACE], exact, rtol=0, atol=1e-8 * np.abs(exact).max())


def test_forces_are_what_the_reference_takes_and_vanish_at_the_start() -> None:
    path = linear_path(bent(), (), SAMPLES, newton_steps=1)
    state = state_at(path, PLACE)
    motion = motion_of(path.reference.machine)
    exact = path.reference.start.tau - motion.forces(state.q, state.qd, state.qdd)
    np.testing.assert_allclose(path.R[PLACE], exact, rtol=1e-11, atol=1e-11 * np.abs(exact).max())
    assert np.abs(path.R[0]).max() < 1e-9 * np.abs(exact).max()


def test_motors_without_servo_do_not_deviate_and_take_torque() -> None:
    """The torque of a motor changes by its row of M d'' + D d' + K d."""
    reference = bent()
    path = linear_path(reference, ("j3.tau", "j2.q", "j4.qdd"), SAMPLES, newton_steps=1)
    assert path.names(path.moved) == ("j2", "j4") == path.names(path.springs)
    k = names_of(reference).index("j3")
    outputs = path.outputs
    for rows, matrix in ((outputs.Cq, path.K), (outputs.Cv, path.D), (outputs.Ca, path.M)):
        np.testing.assert_array_equal(rows[:, 0], matrix[:, k])
    assert outputs.Cq[PLACE, 1].tolist() == [0, 1, 0, 0] and outputs.Ca[PLACE, 2].tolist() == [0, 0, 0, 1]
    assert outputs.follows.tolist() == [False, True, True]


@pytest.mark.thorough
def test_servos_are_springs_and_dampers_of_motors() -> None:
    reference = bent()
    machine = reference.machine
    gains = {"j1": Gains(2e4, 300.0), "j3": Gains(1e4, 200.0)}
    served = moved(machine, 0.4, all_motors(machine, 0.8, 0.3), {"j1": 0.3, "j3": -0.4}, gains)
    free, path = (
        linear_path(reference, (), SAMPLES, newton_steps=1),
        linear_path(served, ("j3.tau",), SAMPLES, newton_steps=1),
    )
    kp, kd = (np.diag([x, 0.0, y, 0.0]) for x, y in ((2e4, 1e4), (300.0, 200.0)))
    np.testing.assert_allclose(path.K[PLACE], free.K[PLACE] + kp, rtol=1e-13, atol=1e-9)
    np.testing.assert_allclose(path.D[PLACE], free.D[PLACE] + kd, rtol=1e-13, atol=1e-9)
    assert path.moved == (0, 1, 2, 3) and path.springs == (1, 3)
    assert path.outputs.Cq[PLACE, 0].tolist() == [0, 0, -1e4, 0]
    assert path.outputs.Cv[PLACE, 0].tolist() == [0, 0, -200, 0]
    np.testing.assert_allclose(path.stiffness - free.stiffness, np.diag(kp))


@pytest.mark.thorough
@pytest.mark.parametrize("frame", ["j4", "j4 at (0.1, 0.2, 0)"])
def test_applied_forces_drive_and_soften(frame: str) -> None:
    """They are those of the model at a wrench that the machine has, whose direction stays in frame 0."""
    reference = bent()
    machine = reference.machine
    wrench = (30.0, -50.0, 20.0, 1.0, 2.0, 3.0)
    push = AppliedForce(frame, wrench, 0.0, 0.1)
    pushed = moved(machine, 0.4, all_motors(machine, 0.8, 0.3), {"j1": 0.3, "j3": -0.4}, forces=[push])
    free, path = linear_path(reference, (), SAMPLES, newton_steps=1), linear_path(pushed, (), SAMPLES, newton_steps=1)
    signals = tuple(f"{frame}.{axis}" for axis in ("x", "y", "z", "rx", "ry", "rz"))
    q = state_at(path, PLACE).q

    def force(q: np.ndarray) -> np.ndarray:
        motion = motion_of(machine, outs=signals)
        return np.array(wrench) @ linearize(motion, state_of(q, 0 * q, 0 * q), (), signals).Cq

    np.testing.assert_allclose(path.R[PLACE] - free.R[PLACE], force(q), rtol=1e-9)
    changes = [(force(q + x) - force(q - x)) / 2e-5 for x in 1e-5 * np.eye(4)]
    np.testing.assert_allclose(free.K[PLACE] - path.K[PLACE], np.transpose(changes), atol=1e-5 * np.abs(changes).max())
