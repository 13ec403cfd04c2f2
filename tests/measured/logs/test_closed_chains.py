"""Identification of machines with couplings and loops, from the motion of their independent joints."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

pytest.importorskip("scipy")

from symoro_elastic.analysis.simulation.simulated_measurements import Controller, Sensors, measure, simulate
from symoro_elastic.analysis.time_series.measurements import Measurements, from_columns, write_measurements
from symoro_elastic.formats import read_machine, write_machine
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.machine import Friction, Joint, Kind, Machine
from symoro_elastic.measured.logs.excitation import ExcitationSettings, excite
from symoro_elastic.measured.logs.fourier_motion import FourierMotion, Limits, random_motion
from symoro_elastic.measured.logs.identified import machine_with_estimates
from symoro_elastic.measured.logs.identify import LogSettings, identify
from symoro_elastic.measured.logs.result import Identification
from symoro_elastic.measured.logs.validation import own_fit, validation_of
from symoro_elastic.numerics.evaluation.assembled_states import start_of
from symoro_elastic.numerics.linear.regressor import regressor
from symoro_elastic.numerics.motion.independent_joints import with_independent_motors
from symoro_elastic.numerics.verification.implementations import numpy_model
from tests.closed_chains.machines import FILES, machine, situations, without_closed_form
from tests.closed_chains.test_regressors import inputs_of
from tests.command_line import ended
from tests.references.closed_chains import State
from tests.references.random_machines import planar_2r
from tests.references.virtual_work import VirtualWork

pytestmark = pytest.mark.sampled(5)

Array = NDArray[np.float64]
SAMPLING = 500.0


def limits_of(described: Machine, angle: float = 0.6, slide: float = 0.1) -> Limits:
    """About the position at which the loops start."""
    far = np.array([slide if joint.sigma == 1 else angle for joint in described.motor_joints])
    middle = start_of(described).q[list(described.motor_entries)]
    n = len(far)
    return Limits.of(list(middle - far), list(middle + far), [3.0] * n, [20.0] * n)


def measured(described: Machine, periods: int, noise: float = 0.0, seed: int = 0) -> Measurements:
    """A machine whose independent joints all have motors: torques of its inverse model, by generated code."""
    motion = random_motion(limits_of(described), 0.2, 6, seed)
    t = np.arange(round(motion.period * SAMPLING)) / SAMPLING
    q, qd, qdd = motion.at(t)
    tau = np.asarray(numpy_model(described, ("inverse_dynamics",)).inverse_dynamics(q, qd, qdd)[0])
    if not noise:
        return Measurements(t, q, tau, qd, qdd)
    true = Measurements(np.arange(periods * len(t)) / SAMPLING, np.tile(q, (periods, 1)), np.tile(tau, (periods, 1)))
    steps = np.full(q.shape[1], 2e-5)
    return measure(true, Sensors(steps, steps / 2, noise * np.abs(tau).max(axis=0)), seed + 1)


def geared_2r() -> Machine:
    """Two links; the second motor's rotor, on the base, drives the second link by a belt: q2 is relative to the base.

    The elbow then turns by q2 - q1, against friction of its own; a rotor on the first link turns 30 times as fast.
    """
    arm = planar_2r()
    first, second = arm.joints
    elbow = replace(second, kind=Kind.COUPLED, variable=None, antecedent=3, theta=Formula.parse("q2 - q1"))
    elbow = replace(
        elbow, friction=Friction(Formula.parse("0.3"), Formula.parse("0.8")), rotor_inertia=Formula.parse(0)
    )
    motor = Joint("belt", 0, Kind.MOTOR, 0, "q2", rotor_inertia=Formula.parse("0.4"))
    inertia = [Formula.parse(x) for x in ("0.002", 0, 0, "0.002", 0, "0.003")]
    body = replace(first.body, mass=Formula.parse(2), moments=(Formula.parse(0),) * 3, inertia=tuple(inertia))
    rotor = Joint("rotor", 3, Kind.COUPLED, 0, None, d=Formula.parse("0.1"), theta=Formula.parse("30*(q2 - q1)"))
    rows = (motor, replace(first, name="upper_arm"), Joint("wrist", 2, Kind.FIXED, 2), elbow, replace(rotor, body=body))
    return replace(arm, joints=rows)


def rigid(name: str) -> Machine:
    return geared_2r() if name == "geared_2r" else machine(name)


def test_columns_are_those_of_unit_parameters() -> None:
    """Of a tree, where what acts on a joint alone can be written out."""
    tree = planar_2r(elastic=(2,))
    Y = regressor(tree, {parameter.name: 1.0 for parameter in tree.parameters})
    assert {column.quantity for column in Y.columns} >= {"K", "DA", "KQ", "IA", "FV", "FS"}
    state = np.random.default_rng(0).uniform(-1, 1, (3, 20, 2))
    for c in range(len(Y.columns)):
        by_units = Y.torques(*state, [c], np.ones(1))
        np.testing.assert_allclose(Y.evaluate(*state, [c])[:, :, 0], by_units, atol=1e-13)


@pytest.mark.parametrize("name", ["sr400", "geared_6r", "geared_2r"])
def test_columns_times_values_are_the_torques(name: str) -> None:
    described = rigid(name)
    record = measured(described, 1)
    assert record.qd is not None and record.qdd is not None
    found = torques(described, record.q, record.qd, record.qdd)
    np.testing.assert_allclose(found, record.tau, atol=1e-12 * np.abs(record.tau).max())


@pytest.mark.sampled(1000)
@pytest.mark.parametrize("name", ["five_bar", "gas_spring", "spatial_four_bar", "gantry", "gantry_rigid", "delta"])
def test_columns_times_values_are_the_forces_of_virtual_work(name: str) -> None:
    """Springs, friction and wrenches in loops of every form; torques of motors on dependent joints act by S_m^T."""
    described = machine(name)
    for situation in situations(name)[: 1 if name == "delta" else 2]:
        reference = VirtualWork(described, situation.state)
        inputs = inputs_of(described, situation, reference.at)
        left = reference.residual(inputs["qdd"], [0.0] * len(described.motors)).astype(float)
        (found,) = torques(described, *(np.array([inputs[x]], dtype=float) for x in ("q", "qd", "qdd")))
        np.testing.assert_allclose(found, left, atol=1e-11 * np.abs(left).max())
        (driven,) = regressor(described).joint_torques(np.array([inputs["q"]], dtype=float), np.array([situation.tau]))
        on_motors = reference.S_x.T @ reference.chain.spread_motors(situation.tau)
        np.testing.assert_allclose(driven, on_motors.astype(float), atol=1e-12 * np.abs(situation.tau).max())


@pytest.mark.thorough
def test_a_spring_may_be_on_a_dependent_joint() -> None:
    """A gantry whose two motors are independent, so that the beam between them gives way."""
    given, situation = machine("gantry"), situations("gantry")[0]
    at = VirtualWork(given, situation.state).at
    described = replace(given, loops=(replace(given.loops[0], dependent=("beam", "pivot", "guide")),))
    u = [float(at[str(joint.variable)]) for joint in described.independent_joints]
    ud, udd = [0.1, -0.2, 0.3, 0.12], [1.0, -0.5, 0.3, 0.7]
    reference = VirtualWork(described, State(u, ud, {name: float(x) for name, x in at.items()}))
    wanted = reference.residual(udd, [0.0] * 4).astype(float)
    (found,) = torques(described, *(np.array([x]) for x in (u, ud, udd)))
    np.testing.assert_allclose(found, wanted, atol=1e-12 * np.abs(wanted).max())


def torques(described: Machine, q: Array, qd: Array, qdd: Array) -> Array:
    """Y X of all columns with the values of the machine's file."""
    Y = regressor(described)
    X = np.array([column.value for column in Y.columns])
    found: Array = Y.evaluate(q, qd, qdd, range(len(X))) @ X + Y.loads(q)
    return found


@pytest.mark.thorough
@pytest.mark.parametrize("name", ["sr400", "geared_2r"])
def test_truth_lies_within_the_standard_deviations(name: str) -> None:
    """Encoders of 2e-5 rad, torques with noise of 1 %: as a normal distribution of half as many independent draws."""
    described = rigid(name)
    result = identify(described, measured(described, 4, noise=0.01, seed=3))
    found = [e for e in result.estimates if np.isfinite(e.std)]
    z = np.array([(e.value - np.nan_to_num(e.unknown.nominal)) / e.std for e in found])  # offsets are 0
    least = {"sr400": 44 + 8, "geared_2r": 6}[name]
    assert len(z) >= least
    spread = 3 * math.sqrt(1 / len(z))
    assert abs(math.sqrt(float(np.mean(z**2))) - 1) < spread
    assert float((abs(z) < 3).mean()) > 1 - 2 / len(z)


@pytest.mark.thorough
@pytest.mark.parametrize("name", ["sr400", "geared_2r"])
def test_the_saved_machine_has_the_torques_of_the_measured_one(name: str, tmp_path: Path) -> None:
    """Without noise; and another record is explained."""
    described = rigid(name)
    record = measured(described, 1)
    few = Measurements(record.t[::10], *(_given(x)[::10] for x in (record.q, record.tau, record.qd, record.qdd)))
    frictionless = [c for c in regressor(described).columns if c.quantity in ("FV", "FS") and c.value == 0.0]
    result = identify(described, few, LogSettings(known={column.label: 0.0 for column in frictionless}, filtered=False))
    path = tmp_path / "identified.toml"
    write_machine(machine_with_estimates(result), path)
    saved, _ = read_machine(path)
    other = measured(described, 1, seed=7)
    found = np.asarray(
        numpy_model(saved, ("inverse_dynamics",)).inverse_dynamics(other.q, other.qd, _given(other.qdd))[0]
    )
    np.testing.assert_allclose(found, other.tau, atol=1e-8 * np.abs(other.tau).max())
    assert max(validation_of(result, other).percent.values()) < 1e-6
    _same_friction(result, described)


def _given(x: Array | None) -> Array:
    assert x is not None
    return x


def _same_friction(result: Identification, described: Machine) -> None:
    """Friction of coupled joints is found, in the rows of all the joints that move them."""
    values = {e.unknown.label: e.value for e in result.estimates}
    for j, joint in enumerate(described.joints, start=1):
        if joint.kind is Kind.COUPLED and not joint.friction.coulomb.is_zero:
            assert values[f"FS{j}"] == pytest.approx(joint.friction.coulomb.value(), rel=1e-6)
            assert values[f"FV{j}"] == pytest.approx(joint.friction.viscous.value(), rel=1e-6)


@pytest.mark.thorough
def test_reversals_of_a_coupled_joint_are_left_out_of_all_rows_that_feel_it() -> None:
    described = geared_2r()
    result = identify(described, measured(described, 2, noise=1e-6))
    elbow = next(e for e in result.estimates if e.unknown.label == "FS4")
    assert elbow.value == pytest.approx(0.8, abs=4 * elbow.std) and elbow.std < 0.01


@pytest.mark.thorough
def test_motion_is_excited_about_the_start_of_loops() -> None:
    described = machine("gas_spring")
    found = excite(described, limits_of(described, 0.2), 0.2, ExcitationSettings(3, evaluations=30))
    assert found.condition < found.before * 1.000001 and np.isfinite(found.condition)
    wide = Limits.of([-1, 0.1, 0.1], [1, 3, 3], [50] * 3, [900] * 3)
    with pytest.raises(InputError, match="limits: loops do not close all along a motion within them"):
        excite(machine("two_jack_arm"), wide, 0.2, ExcitationSettings(3, evaluations=5))


@pytest.mark.thorough
def test_simulation_starts_where_loops_do() -> None:
    """A held motor; the spring settles, and the recorded motion obeys the equations."""
    described = machine("gas_spring")
    hold = start_of(described).q[:1]
    still = FourierMotion(0.5, hold, np.zeros((1, 1)), np.zeros((1, 1)))
    true = simulate(described, {}, still.at, Controller.of_bandwidth([4.0], 3.0), 0.5, 2000.0)
    h, q = 1 / 2000.0, true.q
    qdd = (16 * (q[3:-1] + q[1:-3]) - (q[4:] + q[:-4]) - 30 * q[2:-2]) / (12 * h * h)
    found = torques(described, q[2:-2], _given(true.qd)[2:-2], qdd)
    assert np.abs(found[:, 0] - true.tau[2:-2, 0]).max() < 1e-3 * np.abs(true.tau).max()
    rigid = machine("gantry_rigid")
    for refused, what in ((without_closed_form(), "no closed form"), (rigid, "motors moved by loops")):
        with pytest.raises(InputError, match=what):
            simulate(refused, {}, still.at, Controller.of_bandwidth([4.0], 3.0), 0.5, 2000.0)


@pytest.mark.parametrize(("name", "what"), [("screw", r"joint 2 \(screw\), stiffness: it varies with qm")])
def test_what_no_regressor_has_is_refused(name: str, what: str) -> None:
    with pytest.raises(InputError, match=what):
        regressor(machine(name))


def test_motors_that_move_as_one_are_identified_by_what_they_do_together() -> None:
    """Four motors of three freedoms, which share torques as the file says."""
    described = machine("gantry_rigid")
    motors = [0, 1, 2, 0]
    motion = random_motion(Limits.of([-0.1] * 3, [0.1] * 3, [1.0] * 3, [9.0] * 3), 0.2, 6)
    t = np.arange(0.0, motion.period, 0.02)
    q, qd, qdd = motion.at(t)
    tau = np.asarray(numpy_model(described, ("inverse_dynamics",)).inverse_dynamics(q, qd, qdd[:, motors])[0])
    result = identify(described, Measurements(t, q, tau, qd, qdd), LogSettings(filtered=False))
    carriage = result.estimation["M1"]
    assert "M5" in carriage.unknown.formula and carriage.value == pytest.approx(carriage.unknown.nominal, rel=1e-6)
    fit = own_fit(result)
    assert set(fit.residual) == {"carriage_1", "cross_slide", "ram"} and max(fit.percent.values()) < 1e-6
    with pytest.raises(InputError, match="motors: carriage_2 follow from other joints, so no motion of their own"):
        excite(described, Limits.of([-1] * 4, [1] * 4, [1] * 4, [9] * 4), 0.2, ExcitationSettings(3, evaluations=5))


def test_the_saved_file_keeps_its_dependent_joints(tmp_path: Path) -> None:
    """Encoders are on motors, so these are the measured joints, whatever joints the file calls dependent."""
    given = machine("gantry")
    driven = with_independent_motors(given)
    data, saved = tmp_path / "log.csv", tmp_path / "identified.toml"
    write_measurements(measured(driven, 2, noise=1e-4), driven, data)
    done = ended("identify", FILES["gantry"], data, "--save", saved)
    assert done.code == 0, done
    found, _ = read_machine(saved)
    assert found.loops == given.loops
    model, other = numpy_model(with_independent_motors(found), ("inverse_dynamics",)), measured(driven, 1, seed=7)
    tau = np.asarray(model.inverse_dynamics(other.q, other.qd, _given(other.qdd))[0])
    assert np.abs(tau - other.tau).max() < 1e-2 * np.abs(other.tau).max()


def test_positions_at_which_loops_do_not_close_are_refused() -> None:
    described, t = machine("two_jack_arm"), np.arange(1000) / SAMPLING
    q, tau = np.tile(start_of(described).q, (1000, 1)) + 1e-3 * np.sin(20 * t)[:, None], np.ones((1000, 3))
    q[500:, 1] += 3.0 * (t[500:] - t[500])
    with pytest.raises(InputError, match=r"measurements: q: loops do not close, or jump to another branch, at \d+ of"):
        identify(described, Measurements(t, q, tau), LogSettings(filtered=False))


def test_columns_of_joints_that_follow_are_skipped_with_a_warning() -> None:
    described, t = machine("sr400"), np.arange(100) / SAMPLING
    columns = {"t": t, **{f"q_{joint.name}": np.sin(t) for joint in described.independent_joints}}
    columns |= {f"tau_{joint.name}": np.cos(t) for joint in described.motor_joints}
    record = from_columns({**columns, "q_th3": np.sin(t), "q_b8": np.sin(t)}, described, "log.csv")
    wanted = [f"column q_{name} is skipped: the joint follows others" for name in ("b3", "b8")]
    assert list(record.warnings) == wanted
    with pytest.raises(InputError, match="no moving joint 'pin'"):
        from_columns({**columns, "q_pin": np.sin(t)}, described, "log.csv")
