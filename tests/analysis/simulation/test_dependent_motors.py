"""Motions of machines whose motors follow from loops: a delta whose platform's coordinates are independent, gantries.

References: the tree with its loops cut, by multipliers and DOP853 at 1e-11; multipliers in 70 digits; energy.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from symoro_elastic.analysis.simulation.adaptive import simulate_adaptively
from symoro_elastic.analysis.simulation.compiled_steps import refuse_turned
from symoro_elastic.analysis.simulation.reference_motion import Reference, reference_of
from symoro_elastic.analysis.simulation.simulate import Request, simulate
from symoro_elastic.analysis.simulation.simulated import Simulation
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.machine import Kind, Machine
from symoro_elastic.machine.prescribed_motion import Bandwidth, Gains, PrescribedMotion
from symoro_elastic.numerics.evaluation.assembled_states import start_of
from symoro_elastic.numerics.evaluation.closed_positions import JointCoordinates
from tests.analysis.ladder.motions import moved
from tests.closed_chains.machines import machine as closed_chain
from tests.models.test_creep import creeping
from tests.references.closed_chains import State
from tests.references.constraint_multipliers import Multipliers
from tests.references.cut_tree import CutTree

ARMS = ("arm_1", "arm_2", "arm_3")
MOVES = {"arm_1": (0.06, 0.03), "arm_2": (-0.03, 0.05), "arm_3": (0.03, 0.04)}
SERVOS = {"arm_1": Gains(2000.0, 20.0), "arm_2": Gains(2000.0, 20.0), "arm_3": Bandwidth(20, 0.7)}
DURATION = 0.06
OUTPUTS = ("along_x.q", "along_y.q", "platform.q", "arm_1.q", "arm_2.qd", "cross_3.q")


@cache
def delta() -> Machine:
    return creeping(closed_chain("delta"))


@cache
def driven_at_the_rocker() -> Machine:
    """A four-bar whose motor is on the rocker, which follows from the crank, and a load on a spring."""
    four_bar = creeping(closed_chain("four_bar"))
    kinds = {"crank": Kind.PASSIVE, "rocker": Kind.MOTOR}
    joints = (replace(x, kind=kinds.get(x.name, x.kind)) for x in four_bar.joints)
    loop = replace(four_bar.loops[0], dependent=("coupler", "rocker"))
    return replace(four_bar, joints=tuple(joints), loops=(loop,))


@cache
def under_servos() -> Reference:
    return moved(delta(), DURATION, MOVES, {"along_x": 0.02, "platform": -0.72}, SERVOS)


def by_multipliers(reference: Reference, machine: Machine) -> dict[str, float]:
    """The state of every joint of the cut tree at the end, and the torques of the motors."""
    cut, motors = CutTree(machine), [joint.name for joint in machine.motor_joints]
    own = JointCoordinates(
        reference.machine, [machine.variables[str(joint.variable)] for joint in cut.tree.independent_joints]
    )
    y = np.concatenate(own(reference.at_start.map(lambda block: block[None]))[:, 0])
    entries, n = np.array([cut.names.index(name) for name in motors]), len(cut.names)

    def pushed(t: float, y: Array) -> tuple[Array, Array]:
        wanted, rate, acceleration = (x[0] for x in reference.at(np.array([t])))
        tau, q, qd = np.zeros(n), *np.split(y, 2)
        if reference.servo is None:
            return cut.accelerations(q, qd, tau, entries, acceleration)
        kp, kd = reference.servo
        tau[entries] = reference.start.torques + kp * (wanted - q[entries]) + kd * (rate - qd[entries])
        qdd, _ = cut.accelerations(q, qd, tau, entries[:0], np.zeros(0))
        return qdd, tau[entries]

    def rates(t: float, y: Array) -> Array:
        return np.concatenate([y[n:], pushed(t, y)[0]])

    found = solve_ivp(rates, (0, reference.duration), y, "DOP853", rtol=1e-11, atol=1e-13)
    assert found.success
    last = found.y[:, -1]
    named = {f"{name}.q": last[k] for k, name in enumerate(cut.names)}
    named |= {f"{name}.qd": last[n + k] for k, name in enumerate(cut.names)}
    return named | {f"{name}.tau": x for name, x in zip(motors, pushed(reference.duration, last)[1], strict=True)}


@cache
def of_delta() -> dict[str, float]:
    return by_multipliers(under_servos(), delta())


@pytest.mark.thorough
def test_servos_move_the_platform_as_multipliers_say() -> None:
    """Dependent joints, motors among them, are outputs; errors are true within a factor of two."""
    found = simulate(under_servos(), Request(OUTPUTS, None, "w3", 5e-4))
    for k, name in enumerate(OUTPUTS):
        wrong = abs(found.outputs[-1, k] - of_delta()[name])
        assert wrong < 2 * found.errors[name] + 1e-9, name
        assert found.errors[name] < 1e-3 * np.abs(np.ptp(found.outputs[:, k])), name


@cache
def adapted() -> Simulation:
    return simulate_adaptively(under_servos(), Request((*OUTPUTS, "arm_3.tau"), {"along_x.q": 1e-9}), {})


@pytest.mark.thorough
def test_adapted_steps_move_it_so_too() -> None:
    for k, name in enumerate((*OUTPUTS, "arm_3.tau")):
        wrong = abs(adapted().outputs[-1, k] - of_delta()[name])
        assert wrong < 1e-7 * max(1.0, np.ptp(adapted().outputs[:, k])), name


@pytest.mark.thorough
def test_energy_is_that_of_the_motors() -> None:
    """The power of a motor is its torque times the rate of its own joint."""
    energy = adapted().energy
    assert abs(energy.left_over) < 1e-8 * energy.largest and energy.put_in > 0.1 * energy.largest


@pytest.mark.thorough
def test_what_is_written_holds_the_motors_too() -> None:
    columns = adapted().arrays()
    at = JointCoordinates(delta(), delta().motors)(adapted().motion)
    for k, name in enumerate(ARMS):
        for order, quantity in enumerate(("q", "qd", "qdd")):
            np.testing.assert_array_equal(columns[f"{quantity}_{name}"], at[order, :, k] + 0.0)
    assert {"q_along_x", "tau_arm_3"} <= columns.keys()


@pytest.mark.thorough
def test_motors_that_follow_exactly_become_the_independent_joints() -> None:
    """The crank then follows from the rocker; the load swings; the torque is the force that multipliers need."""
    machine = driven_at_the_rocker()
    assert [joint.name for joint in machine.independent_joints] == ["crank", "load"]
    reference = moved(machine, DURATION, {"rocker": (0.15, 0.05)}, {"crank": 0.9})
    assert [joint.name for joint in reference.machine.independent_joints] == ["rocker", "load"]
    names = ("load.q", "load.qd", "crank.q", "crank.qd", "rocker.tau")
    found = simulate(reference, Request(names, None, "w3", 5e-4))
    wanted = by_multipliers(reference, machine)
    for k, name in enumerate(names):
        wrong = abs(found.outputs[-1, k] - wanted[name])
        assert wrong < 2 * found.errors[name] + 1e-8 * np.abs(found.outputs[:, k]).max(), name


# More motors than freedoms


@cache
def gantry() -> Reference:
    machine = creeping(closed_chain("gantry_rigid"))
    servos = {name: Gains(1e5, 2e3) for name in ("carriage_1", "carriage_2", "cross_slide", "ram")}
    moves = {"carriage_1": (0.1, 0.1), "carriage_2": (0.12, 0.1), "ram": (0.05, 0.08)}
    return moved(machine, 0.15, moves, servo=servos)  # type: ignore[arg-type]


def test_motors_that_move_each_other_have_servos_of_their_own() -> None:
    """Torques are those of the law at the motors' positions, accelerations those of multipliers in 70 digits."""
    found, machine = simulate(gantry(), Request(("carriage_2.q",), None, "w3", 5e-4)), gantry().machine
    guess = start_of(machine).by_variable
    kp, kd = gantry().servo or (0, 0)
    for k in (60, 150):
        motion, t = found.motion, found.motion.t[k : k + 1]
        reference = Multipliers(machine, State(list(motion.q[k]), list(motion.qd[k]), guess))
        motors = [reference.chain.own.index(name) for name in reference.chain.motors]
        x, xd = (block[motors].astype(float) for block in (reference.x, reference.xd))
        y, yd, _ = (rows[0] for rows in gantry().at(t))
        law = gantry().start.torques + kp * (y - x) + kd * (yd - xd)
        np.testing.assert_allclose(motion.tau[k], law, rtol=1e-12, atol=1e-12 * np.abs(law).max())
        xdd = reference.direct(list(motion.tau[k])).astype(float)
        own = [reference.chain.own.index(name) for name in reference.chain.independent]
        np.testing.assert_allclose(motion.qdd[k], xdd[own], rtol=1e-11, atol=1e-11 * np.abs(xdd).max())
    assert abs(found.energy.left_over) < 1e-4 * found.energy.largest


# Starts


@pytest.mark.thorough
def test_the_start_names_independent_joints_of_the_file() -> None:
    """Motors are where they put the platform; torques hold it there; a bandwidth is that of the inertia that moves."""
    found = under_servos()
    np.testing.assert_allclose(found.start.q, [0.02, -0.03, -0.72], rtol=0, atol=1e-13)
    at = Multipliers(delta(), State(list(found.start.q), [0.0] * 3, start_of(delta()).by_variable))
    motors = [at.chain.own.index(name) for name in at.chain.motors]
    np.testing.assert_allclose(found.at(np.zeros(1))[0][0], at.x[motors].astype(float), rtol=0, atol=1e-12)
    np.testing.assert_allclose(at.direct(list(found.start.torques)).astype(float), 0, atol=1e-9)
    inverse = np.linalg.inv(at.S_x[motors].astype(float))
    seen, omega = inverse.T @ at.inertia().astype(float) @ inverse, 2 * np.pi * 20
    assert found.servo is not None and found.servo[0][0] == 2000
    np.testing.assert_allclose([x[2] for x in found.servo], seen[2, 2] * np.array([omega**2, 1.4 * omega]), rtol=1e-11)


# Refusals


@pytest.mark.thorough
def test_a_start_that_is_not_that_of_the_record_is_refused(tmp_path: Path) -> None:
    """The record of the motors says where the platform is."""
    t, first = np.linspace(0, DURATION, 30), under_servos().at(np.zeros(1))[0][0]
    columns = {"t": t} | {f"y_{name}": x + 0 * t for name, x in zip(ARMS, first, strict=True)}
    np.savez(tmp_path / "still.npz", **columns)
    given = PrescribedMotion(DURATION, servo=SERVOS, file="still.npz", source=str(tmp_path / "scene.toml"))
    np.testing.assert_allclose(reference_of(delta(), given).start.q, under_servos().start.q, rtol=0, atol=1e-12)
    with pytest.raises(InputError, match=r"start, along_x: 0.5 is not where still.npz puts it, 0.02: leave it out"):
        reference_of(delta(), replace(given, start={"along_x": 0.5, "platform": -0.72}))


def test_what_cannot_be_prescribed_is_refused_by_name() -> None:
    rigid = creeping(closed_chain("gantry_rigid"))
    moves = {"carriage_1": (0.1, 0.05)}
    with pytest.raises(InputError, match=r"carriage_2: simulate: carriage_1 moves it, .*: give all motors servos"):
        moved(rigid, DURATION, moves)
    servos = dict.fromkeys([joint.name for joint in rigid.motor_joints], Bandwidth(20, 0.7))
    with pytest.raises(InputError, match="servo, carriage_1: other motors move the same inertia: give kp and kd"):
        moved(rigid, DURATION, moves, servo=servos)  # type: ignore[arg-type]


def test_a_motor_that_gets_half_a_turn_away_is_refused() -> None:
    """Its angle by a closed form would go on a turn before."""
    angles = np.array([[3.0, 0.0, 0.0], [-3.1, 0.0, 0.0]])
    turning = SimpleNamespace(machine=delta(), of_motors=lambda *_: (angles, angles))
    run = SimpleNamespace(t=np.array([0.1, 0.2]), q=angles, qd=angles, q_dep=None)
    with pytest.raises(InputError, match=r"arm_1: simulate: at 0.1 s it is half a turn away .*: make it independent"):
        refuse_turned(turning, run)  # type: ignore[arg-type]


@pytest.mark.thorough
def test_exact_derivatives_are_refused_where_motors_follow() -> None:
    with pytest.raises(InputError, match=r"rodas4 is not offered where the motor is on a joint that follows .*use w3"):
        simulate(under_servos(), Request(method="rodas4"))
