"""Spong's reduced model, rotors behind gears, and the rigid limit."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import scipy.integrate

from symoro_elastic.analysis.time_series.measurements import Measurements, read_measurements, write_measurements
from symoro_elastic.analysis.vibration.comparison import along, compare, comparison_motion, move
from symoro_elastic.analysis.vibration.reference_trajectory import through
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.machine import Body, Joint, Kind, Machine
from symoro_elastic.machine.reduced import reduced_model, rotors, with_ratios
from symoro_elastic.machine.restrict import rigid
from tests.analysis.vibration.machines import drive, machine_of, spring
from tests.compiled_models import cell, vector
from tests.references.multiprecision import bias_forces, inertia_matrix
from tests.references.random_machines import random_machine, random_state
from tests.references.small_motions import as_floats

pytestmark = pytest.mark.sampled(4)

RATIO, INERTIA = 7.5, 0.6


def arm(rotor: float = 0.0, axial: float = 0.4, k: float = 900.0) -> Machine:
    """Two inclined axes, each a motor and a coaxial spring; the second motor is carried by the first link."""
    link = Body(cell(4), vector("4*0.2", "0.1", "0.2"), (cell(0.3), cell(0), cell(0), cell(0.5), cell(0), cell(0.6)))
    spinning = Body(cell(1.5), vector(0, 0, 0), (cell(0.2), cell(0), cell(0), cell(0.2), cell(0), cell(axial)))
    return machine_of(
        "arm",
        Joint("motor1", 0, Kind.MOTOR, 0, "q1", body=spinning, rotor_inertia=cell(rotor)),
        Joint("link1", 1, Kind.ELASTIC, 0, "q2", body=link, spring=spring(k)),
        Joint("motor2", 2, Kind.MOTOR, 0, "q3", gamma=cell(0.3), alpha=cell(0.8), d=cell(0.5), body=spinning,
              rotor_inertia=cell(rotor)),
        Joint("link2", 3, Kind.ELASTIC, 0, "q4", body=link, spring=spring(k)),
    )  # fmt: skip


@pytest.mark.parametrize("seed", range(3))
def test_a_rotor_behind_a_gear_is_a_body_of_its_own(seed: int) -> None:
    """A and H against a tree with the rotor as one more body on the carrier, its angle N times that of the joint."""
    machine = random_machine(seed + 3, joints=5, kinds=("motor", "elastic"), prismatic=0.0, friction=False)
    j = next(j for j, joint in enumerate(machine.joints, 1) if joint.kind is Kind.MOTOR and joint.antecedent)
    joint = replace(machine.joints[j - 1], rotor_inertia=cell(INERTIA))
    table = (*machine.joints[: j - 1], joint, *machine.joints[j:])
    geared = with_ratios(replace(machine, joints=table), {joint.name: RATIO})
    spun = Body(inertia=(*(cell(0),) * 5, cell(INERTIA / RATIO**2)))  # type: ignore[arg-type]
    rotor = replace(joint, name="rotor", variable="q_rotor", kind=Kind.PASSIVE, rotor_inertia=cell(0), body=spun)
    bare = replace(joint, rotor_inertia=cell(0))
    extended = replace(machine, joints=(*table[: j - 1], bare, *table[j:], replace(rotor, wrench=type(rotor.wrench)())))
    q, qd, _ = random_state(machine, seed)
    G = np.vstack([np.eye(len(q)), RATIO * np.eye(len(q))[j - 1]])
    all_q, all_qd = (G @ np.array(x) for x in (q, qd))
    wanted = G.T @ as_floats(inertia_matrix(extended, all_q.tolist())) @ G
    np.testing.assert_allclose(as_floats(inertia_matrix(geared, q)), wanted, rtol=0, atol=1e-14 * np.abs(wanted).max())
    forces = G.T @ as_floats(bias_forces(extended, all_q.tolist(), all_qd.tolist()))
    found = as_floats(bias_forces(geared, q, qd))
    np.testing.assert_allclose(found, forces, rtol=0, atol=1e-13 * np.abs(forces).max())


def test_the_reduced_model_neglects_what_rotors_owe_to_their_bodies() -> None:
    """A loses the axial inertia of each rotor but for the square of the joint's own rate."""
    axial, q = 0.4, [0.3, 0.1, -0.7, 0.2]
    machine = arm(axial=axial)
    assert rotors(machine) == (1, 3)
    less = as_floats(inertia_matrix(reduced_model(machine), q))
    without = as_floats(inertia_matrix(arm(axial=0), q)) + np.diag([axial, 0, axial, 0])
    np.testing.assert_allclose(less, without, atol=1e-15)
    full = as_floats(inertia_matrix(machine, q))
    z = np.cos(0.8)  # of the second axis along the first
    turned = np.zeros((4, 4))
    turned[:2, :2] = axial * z**2
    turned[2, :2] = turned[:2, 2] = axial * z
    np.testing.assert_allclose(full - less, turned, atol=1e-15)


def test_what_is_no_rotor_stays() -> None:
    assert rotors(drive()) == () and reduced_model(drive()) == drive()
    inclined = arm()
    joints = (*inclined.joints[:3], replace(inclined.joints[3], alpha=cell(0.1)))
    assert rotors(replace(inclined, joints=joints)) == (1,)


@pytest.mark.thorough
def test_three_models_side_by_side() -> None:
    """Ia of a geared rotor couples by 1/N; without gear ratio the table is reduced already."""
    machine = arm(rotor=5.0, axial=0.0)
    alike = compare(machine, at={"motor1": 0.2})
    np.testing.assert_array_equal(alike.full.frequencies, alike.reduced.frequencies)
    assert alike.alike and all(loss.reduced == (0.0, 0.0) for loss in alike.losses)
    rough, fine = (compare(machine, ratios={"motor2": N}, at={"motor1": 0.2}) for N in (10.0, 100.0))
    lost = [max(loss.reduced[0] for loss in each.losses if loss.quantity == "torque") for each in (rough, fine)]
    assert not rough.alike and lost[0] > 0
    assert lost[0] / lost[1] == pytest.approx(10.0, rel=0.2)
    free = compare(machine, ratios={"motor2": 10.0}, held=False)
    assert list(free.full.frequencies[:2]) == [0.0, 0.0] and free.rigid is not None
    assert list(free.rigid.frequencies) == [0.0, 0.0]


@pytest.mark.thorough
def test_stiffer_springs_come_near_the_rigid_limit() -> None:
    lost = []
    for k in (2e4, 2e5):
        found = compare(drive(k=k), stroke=0.3, duration=0.8)
        (torque,) = [loss for loss in found.losses if loss.quantity == "torque"]
        lost.append(torque.rigid[1] / torque.full[1])
    assert lost[0] / lost[1] == pytest.approx(10.0, rel=0.05) and lost[0] < 0.05
    assert [joint.kind for joint in rigid(drive()).joints] == [Kind.MOTOR, Kind.FIXED]


def test_a_move_is_the_solution_of_the_equations() -> None:
    """Deflection of the load by Duhamel's integral of the motor's acceleration."""
    m2, k, duration, stroke = 5.0, 2e4, 0.3, 0.1
    found = move(drive(m2=m2, k=k), stroke=stroke, duration=duration)
    assert found.q[-1, 0] == pytest.approx(stroke, rel=1e-12) and found.qd[-1, 0] == pytest.approx(0.0, abs=1e-12)
    omega = np.sqrt(k / m2)

    def pushed(s: float) -> float:
        x = s / duration
        shape = 420 * x**2 - 1680 * x**3 + 2100 * x**4 - 840 * x**5
        return stroke / duration**2 * shape * float(np.sin(omega * (duration - s)))

    wanted = -scipy.integrate.quad(pushed, 0, duration, limit=200, epsabs=1e-14)[0] / omega
    assert found.q[-1, 1] == pytest.approx(wanted, rel=1e-5)


@pytest.mark.thorough
def test_values_of_the_table_by_their_names() -> None:
    """`load.stiffness` is the number in the table, in `compare` as in `modes`."""
    changed, written = compare(drive(), {"load.stiffness": 3e4, "load.mass": 6.0}), compare(drive(m2=6.0, k=3e4))
    np.testing.assert_allclose(changed.full.frequencies, written.full.frequencies, rtol=1e-15)
    assert changed.losses[0].full == pytest.approx(written.losses[0].full, rel=1e-12)


@pytest.mark.thorough
def test_a_measured_motion(tmp_path: Path) -> None:
    """Losses on a record; velocities and accelerations by differences where it has none."""
    machine = drive()
    simulated = move(machine, stroke=0.2, duration=0.5)
    tau = np.zeros((len(simulated.t), 1))
    record = Measurements(simulated.t, simulated.q, tau, simulated.qd, simulated.qdd)
    write_measurements(record, machine, tmp_path / "m.csv")
    trajectory = comparison_motion(read_measurements(tmp_path / "m.csv", machine))
    np.testing.assert_allclose(trajectory.qdd, simulated.qdd, rtol=1e-9, atol=1e-9)
    bare = comparison_motion(replace(record, qd=None, qdd=None))
    h = simulated.t[1]
    np.testing.assert_allclose(bare.qd[1:-1], simulated.qd[1:-1], atol=h**2 * np.abs(simulated.qdd).max() * 100)
    losses = compare(machine, trajectory=trajectory).losses
    (torque,) = [loss for loss in losses if loss.quantity == "torque"]
    exact = 8.0 * simulated.qdd[:, 0] + 5.0 * simulated.qdd[:, 1]
    assert torque.full[1] == pytest.approx(np.abs(exact).max(), rel=1e-9)
    assert torque.rigid[1] == pytest.approx(np.abs(5.0 * simulated.qdd[:, 1]).max(), rel=1e-9)


@pytest.mark.thorough
def test_a_trajectory_of_the_motors_alone(tmp_path: Path) -> None:
    """Springs follow the model along it: the motion is that of the move it was taken from."""
    machine = drive()
    moved = move(machine, stroke=0.2, duration=0.5)
    columns = {"t": moved.t, "q_motor": moved.q[:, 0]}
    for rates in ({}, {"qd_motor": moved.qd[:, 0], "qdd_motor": moved.qdd[:, 0]}):
        np.savez(tmp_path / "m.npz", **columns, **rates)
        found, known = compare(machine, trajectory=tmp_path / "m.npz"), compare(machine, trajectory=moved)
        assert found.trajectory.source.endswith("m.npz, springs follow")
        np.testing.assert_allclose(found.trajectory.q, moved.q, atol=1e-7)
        for loss, same in zip(found.losses, known.losses, strict=True):
            assert loss.full == pytest.approx(same.full, rel=1e-3)


@pytest.mark.parametrize(
    ("columns", "word"),
    [
        ({"q_motor": 1.0, "q_load": 1.0}, "m.npz: tau_motor: missing; the file has t, q_motor, q_load: give all"),
        ({"q_load": 1.0}, "m.npz: q_motor, tau_motor: missing"),
        ({"qd_motor": 1.0}, "m.npz: q_motor: missing; the file has t, qd_motor: give it"),
    ],
)
def test_motions_that_are_refused(columns: dict[str, float], word: str, tmp_path: Path) -> None:
    t = np.linspace(0, 1, 101)
    np.savez(tmp_path / "m.npz", t=t, **{name: x * t for name, x in columns.items()})
    with pytest.raises(InputError) as error:
        compare(drive(), trajectory=tmp_path / "m.npz")
    assert word in str(error.value) and "\n" not in str(error.value)


def test_a_trajectory_too_long_to_follow() -> None:
    wanted = through(np.linspace(0, 1e6, 101), {"motor": np.zeros(101)}, 5, rate=1e-3)
    with pytest.raises(InputError, match="too long to integrate: cut it to "):
        along(drive(), wanted)


@pytest.mark.parametrize(
    ("ratios", "word"),
    [
        ({"nobody": 10.0}, "no joint 'nobody'"),
        ({"link1": 10.0}, "link1 is not a revolute motor with a rotor inertia"),
        ({"link1": 10.0}, "such motors are motor1, motor2"),
        ({"motor2": 0.0}, "0 is not a gear ratio"),
    ],
)
def test_ratios_that_are_refused(ratios: dict[str, float], word: str) -> None:
    with pytest.raises(InputError, match=r"arm\.toml: --ratio: ") as error:
        with_ratios(arm(rotor=5.0), ratios)
    assert word in str(error.value)
