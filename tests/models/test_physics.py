"""What the generated models must do because physics says so, and how they are called."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from symoro_elastic.codegen.integration.tableaus import RK4, step
from symoro_elastic.machine.formula import ZERO, Formula
from symoro_elastic.machine.machine import Base, Body, Friction, Joint, Kind, Machine, Spring, Wrench
from symoro_elastic.machine.scene import Scene
from tests.compiled_models import Array, Built, built, cell, vector, worst
from tests.references.numbers_of_machine import numbers_of
from tests.references.random_machines import chain, random_state, two_children

WEIGHT = Base(gravity=(ZERO, ZERO, Formula.parse("-9.81")))

# Physics


def conservative() -> Machine:
    """A tree whose energy nothing takes: no friction, no damping, no wrench."""
    machine = two_children()
    undamped = (replace(j, spring=replace(j.spring, damping=ZERO)) for j in machine.joints)
    return replace(machine, joints=tuple(undamped))


def energy(machine: Machine, code: Built, q: Array, qd: Array) -> float:
    """1/2 qd^T A qd - sum g (M p + R MS) + 1/2 k (q - q0)^2, J."""
    numbers = numbers_of(machine)
    total = 0.5 * qd @ code.c("inertia_matrix", q=q)[0] @ qd
    for joint, frame in zip(numbers.joints, code.c("geometric_model", q=q)[0], strict=True):
        weighed = joint.body.mass * frame[:3, 3] + frame[:3, :3] @ joint.body.first_moment
        total -= numbers.base.gravity @ weighed
    for x, j in zip(q, numbers.moving, strict=True):
        joint = numbers.joints[j]
        total += 0.5 * joint.stiffness * (x - joint.neutral) ** 2
    return float(total)


def simulated(code: Built, q: Array, qd: Array, h: float, steps: int) -> tuple[Array, Array]:
    """RK4 with motors that exert nothing."""
    tau = np.zeros(len(code.module.MOTORS))

    def rate(t: float, y: Array) -> Array:
        return np.array([y[1], code.c("direct_dynamics", q=y[0], qd=y[1], tau=tau)[0]])

    y = np.array([q, qd])
    for _ in range(steps):
        y = step(RK4, rate, 0.0, y, h)
    return y[0], y[1]


def test_energy_is_conserved(tmp_path: Path) -> None:
    """Over half a second, to the order of the integrator, and to 1e-9 of what is exchanged."""
    machine = conservative()
    code = built(machine, tmp_path)
    q, qd, _ = map(np.array, random_state(machine, 1))
    q = q / 3
    before = energy(machine, code, q, qd)
    drifts = []
    for steps in (500, 1000, 2000):
        after = energy(machine, code, *simulated(code, q, qd, 0.5 / steps, steps))
        drifts.append(abs(after - before))
    kinetic = 0.5 * float(qd @ code.c("inertia_matrix", q=q)[0] @ qd)
    assert drifts[2] < 1e-9 * kinetic
    assert drifts[1] < drifts[0] / 10 and drifts[2] < drifts[1] / 10


@pytest.mark.thorough
def test_stiff_springs_make_a_rigid_machine(tmp_path: Path) -> None:
    """At the deflection that carries the load, motor accelerations tend to the rigid machine's as 1/k."""
    machine = chain(4, elastic=(2, 4))
    locked = {"joint2": cell("Q02"), "joint4": cell("Q04")}
    rigid = built(machine, tmp_path / "rigid", Scene(locked=locked))
    soft = built(machine, tmp_path / "soft")
    values = dict(zip(soft.module.PARAMETERS, soft.module.DEFAULTS.tolist(), strict=True))
    q = np.array([0.4, values["Q02"], -0.7, values["Q04"]])
    qd, tau, motors, springs = np.array([0.5, 0.0, -0.9, 0.0]), np.array([3.0, -4.0]), [0, 2], [1, 3]
    (wanted,) = rigid.c("direct_dynamics", q=q[motors], qd=qd[motors], tau=tau)
    qdd = np.zeros(4)
    qdd[motors] = wanted
    loads = soft.c("inertia_matrix", q=q)[0] @ qdd + soft.c("bias_forces", q=q, qd=qd)[0]
    errors = []
    for k in (1e5, 1e7, 1e9):
        deflected = q.copy()
        deflected[springs] -= loads[springs] / k
        (found,) = soft.c("direct_dynamics", q=deflected, qd=qd, tau=tau, p=soft.module.parameters(K2=k, K4=k))
        errors.append(np.max(np.abs(found - qdd)))
    assert errors[0] < 1e-2 * np.max(np.abs(qdd))
    assert errors[1] < errors[0] / 50 and errors[2] < errors[1] / 50


def slide(**changed: Any) -> Machine:
    """A vertical slide of 2 kg with a rotor of 1 kg."""
    joint = Joint("z", 0, Kind.MOTOR, 1, "q1", body=Body(cell(2)), rotor_inertia=cell(1))
    return Machine("slide", (replace(joint, **changed),), base=Base(gravity=vector(0, 0, -10)))


@pytest.mark.parametrize(("velocity", "force"), [(-2.0, -1.25), (3.0, 1.75), (0.0, 0.0)])
def test_friction_opposes_motion(velocity: float, force: float, tmp_path: Path) -> None:
    """Fs sign(qd) + Fv qd, none at rest."""
    code = built(slide(friction=Friction(viscous=cell(0.5), coulomb=cell(0.25))), tmp_path)
    for run in code.both():
        qdd = run("direct_dynamics", q=[0], qd=[velocity], tau=[50])[0]
        assert qdd == pytest.approx([(50 - 20 - force) / 3], rel=1e-15)
        assert run("inverse_dynamics", q=[0], qd=[velocity], qdd_motor=[4])[0] == [12 + 20 + force]
        assert run("bias_forces", q=[0], qd=[velocity])[0] == [20 + force]


def test_wrench_is_exerted_on_the_surroundings(tmp_path: Path) -> None:
    code = built(slide(wrench=Wrench(force=vector(0, 0, 7))), tmp_path)
    for run in code.both():
        assert run("direct_dynamics", q=[0], qd=[0], tau=[33])[0] == pytest.approx([2], rel=1e-15)
        assert run("inverse_dynamics", q=[0], qd=[0], qdd_motor=[2])[0] == [33]


def test_elastic_law(tmp_path: Path) -> None:
    """-k (q - q0) - d qd; the inverse model finds the same acceleration without a motor."""
    law = Spring(stiffness=cell(600), damping=cell(3), neutral=cell(0.5))
    code = built(slide(kind=Kind.ELASTIC, spring=law), tmp_path)
    wanted = [(-600 * 0.25 - 3 * 2 - 20) / 3]
    for run in code.both():
        assert run("direct_dynamics", q=[0.75], qd=[2], tau=[])[0] == pytest.approx(wanted, rel=1e-15)
        torques, qdd = run("inverse_dynamics", q=[0.75], qd=[2], qdd_motor=[])
        assert torques.shape == (0,) and qdd == pytest.approx(wanted, rel=1e-15)


@pytest.mark.thorough
def test_moving_base(tmp_path: Path) -> None:
    """A base that accelerates feels heavier; a uniform velocity is not felt; a turning base adds to joint 1."""
    machine = two_children(symbolic=False)
    q, qd, tau = map(np.array, random_state(machine, 4))
    state = {"q": q, "qd": qd, "tau": tau}

    def qdd(name: str, base: Base, **changed: Any) -> Array:
        return built(replace(machine, base=base), tmp_path / name).c("direct_dynamics", **{**state, **changed})[0]

    lifted = qdd("lifted", Base(gravity=vector(0, 0, -9.81), acceleration=vector(1, -2, 3)))
    assert worst(lifted, qdd("heavy", Base(gravity=vector(-1, 2, -12.81)))) < 1e-13
    sailing = qdd("sailing", replace(WEIGHT, velocity=vector(3, -1, 2)))
    assert worst(sailing, qdd("still", WEIGHT)) == 0
    turning = qdd("turning", replace(WEIGHT, angular_velocity=vector(0, 0, 0.7)))
    faster = qdd("faster", WEIGHT, qd=qd + 0.7 * np.eye(6)[0])
    assert worst(turning, faster) < 1e-13


# Calling conventions


def test_nan_in_gives_nan_out(tmp_path: Path) -> None:
    """On one state, and on one of several stacked ones; the others are as they were."""
    machine = chain(3, elastic=(2,))
    code = built(machine, tmp_path)
    q, qd, u = (np.tile(np.array(row), (3, 1)) for row in random_state(machine, 1))
    for run in code.both():
        good = run("direct_dynamics", q=q, qd=qd, tau=u)[0]
        for name in ("q", "qd", "tau"):
            arrays = {"q": q.copy(), "qd": qd.copy(), "tau": u.copy()}
            arrays[name][1] = np.nan
            found = run("direct_dynamics", **arrays)[0]
            assert np.isnan(found[1]).all() and np.array_equal(found[[0, 2]], good[[0, 2]])
            one = {key: array[1] for key, array in arrays.items()}
            assert np.isnan(run("direct_dynamics", **one)[0]).all()
        poisoned = {"q": np.full(3, np.nan), "qd": qd[0]}
        assert all(np.isnan(x).all() for x in run("inverse_dynamics", **poisoned, qdd_motor=u[0])[:1])
        assert np.isnan(run("bias_forces", **poisoned)[0]).all()
        p = np.full(len(code.module.PARAMETERS), np.nan)
        assert np.isnan(run("direct_dynamics", q=q[0], qd=qd[0], tau=u[0], p=p)[0]).all()


def test_wrong_shapes_are_refused(tmp_path: Path) -> None:
    code = built(chain(3, elastic=(2,)), tmp_path)
    for run in code.both():
        with pytest.raises(ValueError, match=r"tau has shape \(3,\): \(\.\.\., 2\) is expected"):
            run("direct_dynamics", q=np.zeros(3), qd=np.zeros(3), tau=np.zeros(3))
        with pytest.raises(ValueError, match=r"q has shape \(5, 2\): \(\.\.\., 3\) is expected"):
            run("inertia_matrix", q=np.zeros((5, 2)))
        with pytest.raises(ValueError, match=r"q has shape \(\)"):
            run("inertia_matrix", q=0.0)
        with pytest.raises(ValueError, match=r"p has shape \(1,\)"):
            run("inertia_matrix", q=np.zeros(3), p=[1.0])
        with pytest.raises(ValueError, match="broadcast"):
            run("bias_forces", q=np.zeros((2, 3)), qd=np.zeros((4, 3)))
        with pytest.raises(TypeError):
            run("bias_forces", q=np.zeros(3), speed=np.zeros(3))


def test_states_broadcast(tmp_path: Path) -> None:
    machine = chain(3, elastic=(2,))
    code = built(machine, tmp_path)
    q, qd, u = map(np.array, random_state(machine, 1))
    many = q + np.linspace(0, 1, 8).reshape(4, 2, 1)
    for run in code.both():
        found = run("direct_dynamics", q=many, qd=qd, tau=np.tile(u, (2, 1)))[0]
        assert found.shape == (4, 2, 3)
        for i, k in np.ndindex(4, 2):
            assert found[i, k] == pytest.approx(run("direct_dynamics", q=many[i, k], qd=qd, tau=u)[0], rel=1e-13)
        assert run("inertia_matrix", q=many)[0].shape == (4, 2, 3, 3)
        assert run("geometric_model", q=np.zeros((0, 3)))[0].shape == (0, 3, 4, 4)
        p = code.module.DEFAULTS * np.array([[1.0], [1.1]])
        scaled = run("inertia_matrix", q=q, p=p)[0]
        assert scaled.shape == (2, 3, 3) and not np.allclose(scaled[0], scaled[1])
