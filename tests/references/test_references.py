"""The references agree with each other and with closed forms; `models/test_dynamics.py` has Lagrange's."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from typing import Any

import mpmath
import numpy as np
import pytest
from mpmath import cos, mpf, sin

from symoro_elastic.machine.formula import ZERO, Formula
from symoro_elastic.machine.machine import Base, Body, Friction, Joint, Kind, Machine
from tests.references import multiprecision as reference
from tests.references.random_machines import (
    chain,
    first_joint_elastic,
    planar_2r,
    random_machine,
    random_state,
    two_children,
)

pytestmark = pytest.mark.sampled(6)

TOLERANCE_50_DIGITS = 1e-45


def formula(value: float | str) -> Formula:
    return Formula.parse(value)


def floats(entries: Any) -> np.ndarray[Any, Any]:
    return np.array(entries, dtype=object).astype(float)


def worst(entries: Any, wanted: Any) -> float:
    """Largest difference over the largest entry (or 1), in many digits."""
    with mpmath.workdps(60):
        differences = np.array(entries, dtype=object) - np.array(wanted, dtype=object)
        scale = max([mpf(1), *np.abs(np.array(wanted, dtype=object)).ravel()])
        return float(max([mpf(0), *np.abs(differences).ravel()]) / scale)


def various_machines() -> list[Machine]:
    trees = [
        random_machine(
            seed,
            joints=3 + seed % 8,
            symbolic=seed % 3 == 0,
            moving_base=seed % 4 == 3,
            gamma=seed % 5 != 0,
            branching=(0.0, 0.4, 0.8)[seed % 3],
        )
        for seed in range(30)
    ]
    return [*trees, chain(5), chain(4, prismatic=(2,), elastic=(3,)), first_joint_elastic(), two_children()]


VARIOUS = [pytest.param(machine, id=f"{machine.name}-{k}") for k, machine in enumerate(various_machines())]


@pytest.mark.parametrize("machine", VARIOUS)
def test_multiprecision_against_pinocchio(machine: Machine) -> None:
    pytest.importorskip("pinocchio")
    from tests.references import pinocchio_model

    q, qd, tau = random_state(machine, 1)
    inertia = floats(reference.inertia_matrix(machine, q))
    conditioning = max(
        1.0, np.linalg.cond(inertia) / 1e3
    )  # of A: amplifies rounding in the double precision of the library

    assert worst(pinocchio_model.frames(machine, q), floats(reference.geometric_model(machine, q))) < 1e-13
    assert worst(pinocchio_model.inertia_matrix(machine, q), inertia) < 1e-13
    assert worst(pinocchio_model.bias_forces(machine, q, qd), floats(reference.bias_forces(machine, q, qd))) < 1e-12
    qdd = floats(reference.direct_dynamics(machine, q, qd, tau))
    assert worst(pinocchio_model.direct_dynamics(machine, q, qd, tau), qdd) < 1e-12 * conditioning
    torques, accelerations = pinocchio_model.inverse_dynamics(machine, q, qd, tau)
    wanted_torques, wanted_accelerations = reference.inverse_dynamics(machine, q, qd, tau)
    assert worst(torques, floats(wanted_torques)) < 1e-12 * conditioning
    assert worst(accelerations, floats(wanted_accelerations)) < 1e-12 * conditioning


@pytest.mark.parametrize("machine", VARIOUS)
def test_multiprecision_is_consistent(machine: Machine) -> None:
    """Direct and inverse undo each other; A qdd + H is the projection of the wrenches of the whole motion."""
    q, qd, tau = random_state(machine, 2)
    motors = [k for k, j in enumerate(machine.independent) if machine.joints[j - 1].kind == Kind.MOTOR]
    qdd = reference.direct_dynamics(machine, q, qd, tau)
    torques, accelerations = reference.inverse_dynamics(machine, q, qd, [qdd[k] for k in motors])
    assert worst(torques, tau) < TOLERANCE_50_DIGITS
    assert worst(accelerations, qdd) < TOLERANCE_50_DIGITS

    with mpmath.workdps(50):
        inertia = np.array(reference.inertia_matrix(machine, q), dtype=object)
        forces = inertia @ np.array(qdd, dtype=object) + np.array(reference.bias_forces(machine, q, qd), dtype=object)
    assert worst(forces, reference.generalized_forces(machine, q, qd, qdd)) < TOLERANCE_50_DIGITS
    assert worst(inertia, inertia.T) < TOLERANCE_50_DIGITS
    assert [forces[k] for k in motors] == pytest.approx(tau, rel=1e-15, abs=1e-15)


@pytest.mark.parametrize("machine", VARIOUS)
def test_reaction_wrenches_hold_the_joint_forces(machine: Machine) -> None:
    """a.f + Ia qdd + friction = Gamma [61]."""
    q, qd, tau = random_state(machine, 3)
    qdd = reference.direct_dynamics(machine, q, qd, tau)
    wrenches = reference.reaction_wrenches(machine, q, qd, qdd)
    forces = reference.generalized_forces(machine, q, qd, qdd)
    rows = [machine.joints[j - 1] for j in machine.independent]
    values: dict[str, float] = {p.name: p.value.value() for p in machine.parameters if p.value}
    for row, j, force, rate, acceleration in zip(rows, machine.independent, forces, qd, qdd, strict=True):
        friction = row.friction.coulomb.value(values) * np.sign(rate) + row.friction.viscous.value(values) * rate
        through = wrenches[j - 1][2 if row.sigma == 1 else 5]
        total = float(through) + row.rotor_inertia.value(values) * float(acceleration) + friction
        assert total == pytest.approx(float(force), rel=1e-12, abs=1e-11)


@pytest.mark.parametrize("seed", range(10))
def test_velocities_and_accelerations_are_derivatives_of_positions(seed: int) -> None:
    """Central differences of the geometric model, in 50 digits, along q(t) = q + qd t + qdd t^2/2."""
    machine = random_machine(seed, joints=5)
    q, qd, _ = random_state(machine, seed)
    qdd = [0.3 * x for x in qd]
    step = Fraction(1, 10**12)

    def positions(t: Fraction) -> np.ndarray[Any, Any]:
        at = [Fraction(x) + Fraction(v) * t + Fraction(a) * t * t / 2 for x, v, a in zip(q, qd, qdd, strict=True)]
        return np.array(reference.geometric_model(machine, at), dtype=object)

    with mpmath.workdps(50):
        before, now, after = (positions(t) for t in (-step, Fraction(0), step))
        h = mpf(1) / 10**12
        first, second = (after - before) / (2 * h), (after - 2 * now + before) / h**2
        for j, rotation in enumerate(now[:, :3, :3]):
            v = reference.velocities(machine, q, qd)[j]
            a = reference.accelerations(machine, q, qd, qdd)[j]
            turning = rotation.T @ first[j, :3, :3]
            assert worst(v[:3], rotation.T @ first[j, :3, 3]) < 1e-20
            assert worst(v[3:], [turning[2, 1], turning[0, 2], turning[1, 0]]) < 1e-20
            assert worst(a[:3], rotation.T @ second[j, :3, 3]) < 1e-20
            spin = rotation.T @ second[j, :3, :3]
            assert worst(a[3:], [(spin[k, i] - spin[i, k]) / 2 for i, k in ((1, 2), (2, 0), (0, 1))]) < 1e-20


@pytest.mark.parametrize("elastic", [(), (2,), (1,)])
def test_planar_2r_in_closed_form(elastic: tuple[int, ...]) -> None:
    """Two links in a vertical plane, as every textbook has them."""
    machine = planar_2r(elastic=elastic)
    (q1, q2), (qd1, qd2) = (mpf(0.7), mpf(-1.1)), (mpf(1.3), mpf(-0.4))
    with mpmath.workdps(50):
        p = {x.name: mpf(x.value.text) for x in machine.parameters if x.value}
        ia1, ia2 = p.get("IA1", mpf(0)), p.get("IA2", mpf(0))
        reach = p["L1"] * (p["MX2"] * cos(q2) - p["MY2"] * sin(q2))
        swing = -p["L1"] * (p["MX2"] * sin(q2) + p["MY2"] * cos(q2))  # d reach / d q2
        a12 = p["ZZ2"] + reach
        a11 = p["ZZ1"] + p["ZZ2"] + p["M2"] * p["L1"] ** 2 + 2 * reach + ia1
        inertia = [[a11, a12], [a12, p["ZZ2"] + ia2]]
        weight2 = p["G"] * (p["MX2"] * cos(q1 + q2) - p["MY2"] * sin(q1 + q2))
        weight1 = p["G"] * ((p["MX1"] + p["M2"] * p["L1"]) * cos(q1) - p["MY1"] * sin(q1)) + weight2
        bias = [swing * qd2 * (2 * qd1 + qd2) + weight1, -swing * qd1**2 + weight2]
    assert worst(reference.inertia_matrix(machine, [q1, q2]), inertia) < TOLERANCE_50_DIGITS
    assert worst(reference.bias_forces(machine, [q1, q2], [qd1, qd2]), bias) < TOLERANCE_50_DIGITS

    with mpmath.workdps(50):
        forces = [mpf(3), mpf(-2)]
        for j in elastic:
            forces[j - 1] = -p[f"K{j}"] * (q1, q2)[j - 1] - p[f"DA{j}"] * (qd1, qd2)[j - 1]
        right1, right2 = forces[0] - bias[0], forces[1] - bias[1]
        determinant = a11 * inertia[1][1] - a12**2
        qdd = [(inertia[1][1] * right1 - a12 * right2) / determinant, (a11 * right2 - a12 * right1) / determinant]
    tau = [force for j, force in enumerate(forces, start=1) if j not in elastic]
    assert worst(reference.direct_dynamics(machine, [q1, q2], [qd1, qd2], tau), qdd) < TOLERANCE_50_DIGITS


def test_wrench_friction_and_centre_of_mass_on_a_slide() -> None:
    """One vertical slide: Gamma = (M + Ia) qdd + M g + FZ + Fs sign(qd) + Fv qd, with FZ on the surroundings."""
    body = Body(formula(2), (formula(0.1), ZERO, ZERO), central=True)
    wrench = replace(Joint("", 0, Kind.MOTOR, 1).wrench, force=(ZERO, ZERO, formula(7)))
    law = Friction(viscous=formula(0.5), coulomb=formula(0.25))
    joint = Joint("z", 0, Kind.MOTOR, 1, "q1", body=body, friction=law, rotor_inertia=formula(1), wrench=wrench)
    machine = Machine("slide", (joint,), base=Base(gravity=(ZERO, ZERO, formula(-10))))
    assert reference.generalized_forces(machine, [0], [-2], [4]) == [3 * 4 + 20 + 7 - mpf(0.25) - 1]
    assert reference.direct_dynamics(machine, [0], [0], [27]) == [0]


def test_central_inertia_is_moved_to_the_origin() -> None:
    """A point mass at (a, b, 0): XX = m b^2, XY = -m a b, ZZ = m (a^2 + b^2); as a pendulum about z, ZZ is felt."""
    point = Body(formula(2), (formula(0.5), formula(0.25), ZERO), central=True)
    at_origin = Body(
        formula(2),
        (formula(1), formula(0.5), ZERO),
        tuple(formula(x) for x in (0.125, -0.25, 0, 0.5, 0, 0.625)),  # type: ignore[arg-type]
    )
    joints = (
        Joint("one", 0, Kind.MOTOR, 0, "q1", alpha=formula(0.3)),
        Joint("two", 1, Kind.MOTOR, 0, "q2", alpha=formula("pi/2"), d=formula(0.2)),
    )
    central, plain = (Machine("m", (joints[0], replace(joints[1], body=body))) for body in (point, at_origin))
    assert reference.inertia_matrix(central, [0, 1])[1][1] == pytest.approx(0.625, abs=1e-30)
    assert reference.inertia_matrix(central, [0.1, 1]) == reference.inertia_matrix(plain, [0.1, 1])
    assert reference.bias_forces(central, [0.1, 1], [1, 2]) == reference.bias_forces(plain, [0.1, 1], [1, 2])


def test_values_override_defaults_and_missing_ones_are_named() -> None:
    machine = planar_2r()
    doubled = {"ZZ2": 0.22, "MX2": 0.0, "MY2": 0.0, "IA2": 0.0}
    assert reference.inertia_matrix(machine, [0, 0], doubled)[1][1] == mpf(0.22)
    bare = replace(machine, parameters=())
    with pytest.raises(ValueError, match="no value for G"):
        reference.geometric_model(bare, [0, 0])
    with pytest.raises(ValueError, match="1 entries for 2"):
        reference.geometric_model(machine, [0])


@pytest.mark.thorough
@pytest.mark.sampled(2)
@pytest.mark.parametrize("symbolic", [False, True])
def test_random_machines_are_equal_when_asked_equally_and_physical(symbolic: bool) -> None:
    for seed in range(40):
        machine = random_machine(seed, joints=8, symbolic=symbolic)
        assert machine == random_machine(seed, joints=8, symbolic=symbolic)
        names = {p.name for p in machine.parameters}
        assert bool(names) == symbolic and len(names) == len(machine.parameters)
        assert {joint.kind for joint in machine.joints} == {*Kind} - {Kind.COUPLED, Kind.CUT}
        assert all(joint.antecedent < j for j, joint in enumerate(machine.joints, start=1))
        assert all(
            (joint.sigma == 2) == (joint.kind == Kind.FIXED) == (joint.variable is None) for joint in machine.joints
        )


@pytest.mark.thorough
def test_random_machines_are_regular_even_when_aligned() -> None:
    """All joints at quarter turns is where axes meet; massless bodies must not make A singular there."""
    massless = 0
    for seed in range(60):
        machine = random_machine(seed, joints=7, massless=0.6)
        massless += sum(joint.body == Body() and joint.sigma != 2 for joint in machine.joints)
        for turn in (0.0, np.pi / 2):
            q = [turn if machine.joints[j - 1].sigma == 0 else 0.0 for j in machine.independent]
            inertia = floats(reference.inertia_matrix(machine, q))
            scale = 1 / np.sqrt(np.diag(inertia))
            assert np.linalg.eigvalsh(inertia * np.outer(scale, scale))[0] > 1e-5, machine
    assert massless > 30
