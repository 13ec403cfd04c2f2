"""Equilibrium, linearization and modes: the two-axis machine, closed forms, other ways to M and K, 50 digits."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.linalg

import symoro_elastic as se
from symoro_elastic.analysis.vibration.linearization import linearize
from symoro_elastic.analysis.vibration.modes import (
    GRAVITY_AND_LOADS,
    frame_shapes,
    kinetic_shares,
    sensitivity,
    strain_shares,
)
from symoro_elastic.formats import read_machine
from symoro_elastic.machine.machine import Base, Kind, Machine
from symoro_elastic.numerics.motion.equations_of_motion import EquationsOfMotion, motion_of
from symoro_elastic.numerics.motion.equilibrium import equilibrium, given_state
from tests.analysis.vibration.machines import drive, linearized, machine_of, modes_of, twins
from tests.analysis.vibration.test_equilibrium import pendulum
from tests.references import small_motions
from tests.references.lagrange import lagrange
from tests.references.multiprecision import geometric_model
from tests.references.random_machines import planar_2r, random_machine, random_state

pytestmark = pytest.mark.sampled(5)

EXAMPLES = Path(__file__).parents[3] / "examples"
PRINTED = [0, 0, 26.1, 34.4, 36.4, 93.8, 164.8, 285.6, 423.3, 482.2, 1035.8, 1107.8]  # Hz, at x = 0.3, y = 0.1 m
PLACE = {"motor_x": 0.3, "motor_y": 0.1}


@cache
def two_axis() -> Machine:
    return read_machine(EXAMPLES / "two_axis.toml")[0]


@pytest.mark.thorough
def test_the_two_axis_machine() -> None:
    found = modes_of(two_axis(), PLACE)
    assert [round(f, 1) for f in found.frequencies] == PRINTED
    assert found.linear.state.tau[8] == pytest.approx(1010, abs=0.5)
    assert round(modes_of(two_axis(), {"motor_x": 0.3, "motor_y": 0.0}).frequencies[5], 1) == 87.7
    assert modes_of(two_axis(), {"motor_x": 0.3, "motor_y": 0.4}).frequencies[5] == pytest.approx(103.2, abs=0.06)


def test_the_two_axis_machine_against_50_digits() -> None:
    """Gravity tilts the bed under a motor X that is away from it: this motion drifts, and does not swing."""
    found = modes_of(two_axis(), PLACE)
    assert list(found.frequencies[:2]) == [0.0, 0.0] and found.rigid == 1
    state = found.linear.state
    exact = small_motions.equilibrium(two_axis(), state.q.tolist(), state.sought)
    np.testing.assert_allclose(state.q, small_motions.as_floats(exact), rtol=0, atol=1e-17)
    wanted = small_motions.as_floats(small_motions.frequencies(two_axis(), exact, range(12)))
    np.testing.assert_allclose(found.frequencies[2:], wanted[2:], rtol=1e-12)
    assert found.growth[0] / (2 * np.pi) == pytest.approx(wanted[1], rel=1e-4)
    assert found.growth[1] == 0.0 and wanted[0] < 1e-5


def test_a_drive_of_two_masses() -> None:
    m1, m2, k, d = 3.0, 5.0, 2e4, 7.0
    found = modes_of(drive(m1, m2, k, d))
    reduced = m1 * m2 / (m1 + m2)
    omega = np.sqrt(k / reduced)
    assert list(found.eigenvalues[:1]) == [0.0]
    assert found.frequencies[1] == pytest.approx(omega / (2 * np.pi), rel=1e-15)
    assert found.damping_ratios[1] == pytest.approx(d / (2 * np.sqrt(k * reduced)), rel=1e-13)
    assert np.isnan(found.damping_ratios[0])
    assert np.sum(found.poles == 0) == 2
    np.testing.assert_allclose(found.shapes.T @ found.linear.M @ found.shapes, np.eye(2), atol=1e-15)
    held = modes_of(drive(m1, m2, k, d), held=["motor"])
    assert held.frequencies == pytest.approx([np.sqrt(k / m2) / (2 * np.pi)], rel=1e-15)


def test_a_position_controller_is_a_spring() -> None:
    """A motor under PD has the modes of two masses on two springs."""
    m1, m2, k, kp, kd = 3.0, 5.0, 2e4, 4e4, 11.0
    found = modes_of(drive(m1, m2, k), gains={"motor": (kp, kd)})
    M, K = np.diag([m1, m2]), np.array([[k + kp, -k], [-k, k]])
    wanted = np.sqrt(scipy.linalg.eigh(K, M, eigvals_only=True)) / (2 * np.pi)
    np.testing.assert_allclose(found.frequencies, wanted, rtol=1e-14)
    D = np.diag([kd, 0.0])
    poles = np.linalg.eigvals(np.block([[np.zeros((2, 2)), np.eye(2)], [-K / [[m1], [m2]], -D / [[m1], [m2]]]]))
    pairs = sorted(poles[poles.imag > 0], key=abs)
    np.testing.assert_allclose(found.damping_ratios, [-p.real / abs(p) for p in pairs], rtol=1e-10)
    shares = strain_shares(found)
    assert shares.names == ("load", "motor (controller)", GRAVITY_AND_LOADS)
    np.testing.assert_allclose(shares.shares.sum(axis=0), 1.0, rtol=1e-14)


@pytest.mark.parametrize("seed", range(3))
def test_machines_without_springs_are_at_exactly_0_hz(seed: int) -> None:
    """Free motors without gravity: every motion of relative coordinates is rigid."""
    machine = random_machine(seed, joints=5, kinds=("motor",), friction=False, wrenches=False)
    found = modes_of(machine_of("rigid", *machine.joints))
    assert list(found.eigenvalues) == [0.0] * 5
    np.testing.assert_allclose(found.shapes.T @ found.linear.M @ found.shapes, np.eye(5), atol=1e-12)


@pytest.mark.parametrize("seed", range(4))
def test_each_free_motor_is_at_exactly_0_hz(seed: int) -> None:
    machine = random_machine(seed, joints=6, kinds=("motor", "elastic"), friction=False, wrenches=False)
    machine = machine_of("soft", *machine.joints)
    found = modes_of(machine)
    motors = sum(joint.kind is Kind.MOTOR for joint in machine.joints)
    neutral = all(joint.spring.neutral.is_zero for joint in machine.joints)
    assert found.rigid == motors and (found.frequencies[motors:] > 0).all() and not neutral
    M, K = found.linear.M, found.linear.K
    wanted = scipy.linalg.eigh(K, M, eigvals_only=True)[motors:]
    np.testing.assert_allclose(found.eigenvalues[motors:], wanted, rtol=1e-9)


@pytest.mark.thorough
def test_modes_from_lagrange_equations() -> None:
    """M and K of a loaded arm assembled from energies; the eigenproblem by scipy."""
    machine = planar_2r(elastic=(1, 2))
    found = modes_of(machine)
    inertia, bias = lagrange(machine)
    q, rest = found.linear.state.q.tolist(), [0.0, 0.0]
    K = small_motions.as_floats(small_motions.differences(lambda x: bias(x, rest), q)) + np.diag([800.0, 800.0])
    squared = scipy.linalg.eigh(K, small_motions.as_floats(inertia(q)), eigvals_only=True)
    np.testing.assert_allclose(found.eigenvalues, squared, rtol=1e-12)
    assert abs(q[0]) > 0.01
    np.testing.assert_allclose(-800 * np.array(q), small_motions.as_floats(bias(q, rest)), rtol=1e-12)


@pytest.mark.thorough
@pytest.mark.parametrize("seed", [1, 4])
def test_equilibrium_and_frequencies_against_50_digits(seed: int) -> None:
    machine = random_machine(seed, joints=5, kinds=("motor", "elastic", "fixed"), friction=False, wrenches=False)
    motion = EquationsOfMotion(machine)
    at = {motion.names[k]: 0.3 for k in motion.motors}
    state = equilibrium(motion, at)
    exact = small_motions.equilibrium(machine, state.q.tolist(), state.sought)
    np.testing.assert_allclose(state.q, small_motions.as_floats(exact), rtol=0, atol=1e-14)
    held = [motion.names[k] for k in motion.motors]
    wanted = small_motions.as_floats(small_motions.frequencies(machine, exact, state.sought))
    np.testing.assert_allclose(modes_of(machine, at, held=held).frequencies, wanted, rtol=1e-11)


def test_shares_of_energy() -> None:
    """Without gravity, a spring's share of strain energy is twice the per cent of Hz by per cent of stiffness."""
    found = modes_of(replace(two_axis(), base=Base()), PLACE)
    kinetic, strain = kinetic_shares(found), strain_shares(found)
    np.testing.assert_allclose(kinetic.shares.sum(axis=0), 1.0, rtol=1e-13)
    np.testing.assert_allclose(strain.shares.sum(axis=0), [0.0] * 2 + [1.0] * 10, rtol=1e-13)
    assert (kinetic.shares >= -1e-15).all()
    assert strain.largest(2)[0] == "bed_yaw" and kinetic.largest(2)[0] == "bed_x"
    slopes = sensitivity(found, [f"{name}.stiffness" for name in strain.names[:-1]])
    np.testing.assert_allclose(2 * slopes.relative[:, 2:], strain.shares[:-1, 2:], rtol=1e-9, atol=1e-14)


def test_shapes_of_frames_follow_the_geometry() -> None:
    """The tool moves as the placement of its frame does."""
    found = modes_of(two_axis(), PLACE)
    q, phi, h = found.linear.state.q, found.shapes[:, 5], 1e-4
    up, down = (geometric_model(two_axis(), (q + s * h * phi).tolist())[11] for s in (1, -1))
    moved = [float(up[k][3] - down[k][3]) / (2 * h) for k in range(3)]
    np.testing.assert_allclose(frame_shapes(found)[11, :3, 5], moved, rtol=1e-6, atol=1e-9)


SENSITIVE = ("M2", "D2", "K2", "K3", "IA1", "MX3")


@pytest.mark.thorough
def test_sensitivities_against_differences_in_50_digits() -> None:
    """Along the equilibrium, which moves with masses, lengths and stiffnesses."""
    machine = random_machine(11, joints=3, kinds=("motor", "elastic"), friction=False, wrenches=False, symbolic=True)
    found = modes_of(machine, held=[j.name for j in machine.joints if j.kind is Kind.MOTOR])
    sought, start = found.linear.state.sought, found.linear.state.q.tolist()
    known = {parameter.name for parameter in machine.parameters}
    names = [name for name in SENSITIVE if name in known]
    assert len(names) >= 3

    def frequencies(given: list[object]) -> list[object]:
        values = dict(zip(names, given, strict=True))
        q = small_motions.equilibrium(machine, start, sought, values)
        return small_motions.frequencies(machine, q, sought, values)

    given = [found.linear.motion.parameters[name] for name in names]
    wanted = small_motions.as_floats(small_motions.differences(frequencies, given, "1e-8"))
    slopes = sensitivity(found, names).slopes
    np.testing.assert_allclose(slopes.T, wanted, rtol=1e-9, atol=1e-9 * np.abs(wanted).max())


def test_a_repeated_frequency_is_split_by_one_spring() -> None:
    """Of two equal oscillators, the stiffness of one moves one frequency, f / 2k, and leaves the other."""
    found = modes_of(twins(k1="K", k2=1e4, parameters={"K": 1e4}), held=["table"])
    assert found.frequencies[0] == pytest.approx(found.frequencies[1], rel=1e-15)
    slopes = sensitivity(found, ["K"]).slopes[0]
    np.testing.assert_allclose(slopes, [0.0, found.frequencies[0] / 2e4], atol=1e-18)


def test_a_pendulum_swings_by_gravity_alone() -> None:
    """A passive joint: sqrt(g / l), all strain energy that of gravity, whatever the mass."""
    found = modes_of(pendulum())
    assert found.frequencies[0] == pytest.approx(np.sqrt(9.81 / 0.7) / (2 * np.pi), rel=1e-12)
    assert strain_shares(found).largest(0) == (GRAVITY_AND_LOADS, pytest.approx(1.0, rel=1e-14))


@pytest.mark.parametrize("seed", range(3))
def test_a_given_state_is_linearized_along_its_motion(seed: int) -> None:
    """M, D, K at q, qd and the accelerations there, against differences of the reference."""
    machine = random_machine(seed + 20, joints=4, friction=False)
    motion = EquationsOfMotion(machine)
    q, qd, tau = random_state(machine, seed)
    torques = {motion.names[k]: x for k, x in zip(motion.motors, tau, strict=True)}
    state = given_state(
        motion, dict(zip(motion.names, q, strict=True)), dict(zip(motion.names, qd, strict=True)), torques
    )
    linear = linearize(motion, state)
    qdd = state.qdd.tolist()
    unbalanced = small_motions.as_floats(small_motions.forces(machine, q, qd, qdd)) - state.tau
    assert np.abs(unbalanced).max() < 1e-10 * max(np.abs(state.tau).max(), np.abs(state.qdd).max())
    K = small_motions.as_floats(small_motions.differences(lambda x: small_motions.forces(machine, x, qd, qdd), q))
    D = small_motions.as_floats(small_motions.differences(lambda x: small_motions.forces(machine, q, x, qdd), qd))
    np.testing.assert_allclose(linear.K, K, rtol=0, atol=1e-12 * np.abs(K).max())
    np.testing.assert_allclose(linear.D, D, rtol=0, atol=1e-12 * max(np.abs(D).max(), 1.0))


def test_the_state_space_is_that_of_the_matrices() -> None:
    linear = linearized(two_axis(), PLACE, ["motor_x", "tool.fx"], ["motor_x", "tool.x", "tool at (0.1, 0, D12).ay"])
    space, n = linear.space, 12
    assert space.A.shape == (2 * n, 2 * n) and space.states[0] == "bed_yaw.q" and space.states[-1] == "sensor_head.qd"
    np.testing.assert_array_equal(space.A[:n], np.hstack([np.zeros((n, n)), np.eye(n)]))
    np.testing.assert_allclose(linear.M @ space.A[n:, :n], -linear.K, atol=1e-6)
    np.testing.assert_allclose(linear.M @ space.B[n:], linear.F, atol=1e-12)
    np.testing.assert_allclose(space.C[:2, :n], linear.Cq[:2], atol=1e-15)
    assert space.D[2].any() and not space.D[:2].any()
    np.testing.assert_allclose(linear.F[:, 1], linear.Cq[1], atol=1e-15)
    assert motion_of(two_axis()).points == ()


def test_what_a_linear_model_lacks_is_said() -> None:
    """A spring within its backlash, and bristles of dry friction."""
    tables: dict[str, Any] = {
        "name": "drive",
        "joints": [
            {"name": "motor", "kind": "motor", "sigma": 0, "theta": "q1"},
            {"name": "arm", "antecedent": "motor", "kind": "elastic", "sigma": 0, "theta": "q2"},
        ],
        "bodies": {"arm": {"inertia_at_origin": [0, 0, 0.05]}},
        "motors": {"motor": {"rotor_inertia": 0.02}},
        "springs": {"arm": {"stiffness": 1000.0, "backlash": 1e-3}},
        "friction": {"motor": {"viscous": 0.5, "coulomb": 1.0, "bristle": 1e4, "bristle_damping": 0.5}},
    }
    found = [part for part in se.modes(tables).parts() if isinstance(part, str)]
    assert any(line.startswith("arm stands within its backlash") for line in found)
    assert any(line.startswith("bristles of dry friction are left out: motor") for line in found)
    tables["springs"]["arm"] = {"stiffness": 1000.0}
    del tables["friction"]
    assert not any(
        "backlash" in part or "bristle" in part for part in se.modes(tables).parts() if isinstance(part, str)
    )
