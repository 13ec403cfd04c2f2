"""Simulated motions against Pinocchio and DOP853, closed forms, impulse and energy, and the errors that they claim."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest
from numpy.polynomial import Polynomial

from symoro_elastic.analysis.simulation.adaptive import CompiledMotion, integrate, simulate_adaptively
from symoro_elastic.analysis.simulation.compiled_steps import CompiledSteps
from symoro_elastic.analysis.simulation.observed import Observer
from symoro_elastic.analysis.simulation.reference_motion import RISE, Reference
from symoro_elastic.analysis.simulation.simulate import Request, Runs, Simulating, simulate
from symoro_elastic.codegen.integration.tableaus import METHODS
from symoro_elastic.formats import read_machine
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.foundation.progress import no_progress
from symoro_elastic.machine.machine import Body, Joint, Kind, Machine
from symoro_elastic.machine.prescribed_motion import AppliedForce, Bandwidth, Gains
from symoro_elastic.machine.restrict import restrict
from symoro_elastic.machine.scene import Scene
from symoro_elastic.numerics.evaluation.closed_positions import Followed
from symoro_elastic.numerics.evaluation.values import given_values
from tests.analysis.ladder.motions import moved
from tests.analysis.ladder.scenes import two_axis
from tests.analysis.ladder.truth import Truth, generated_dynamics, pinocchio_dynamics
from tests.analysis.vibration.machines import ZERO, drive, machine_of, spring
from tests.closed_chains.machines import machine as closed_chain
from tests.command_line import EXAMPLES
from tests.compiled_models import cell, vector

pytestmark = pytest.mark.sampled(4)

BY, LASTS, LONG = 0.05, 0.15, 0.25
SERVO = {"motor": Gains(5e4, 600.0)}


def driven(servo: bool = False, **of_drive: float) -> Reference:
    """The motor of the drive moves, and stays for a while."""
    return moved(drive(**of_drive), LONG, {"motor": (BY, LASTS)}, servo=SERVO if servo else None)


def arm() -> Machine:
    """Two bars in a plane, the second behind a spring: centrifugal and Coriolis forces, 10 Hz."""
    masses = ((4, 0.25), (2, 0.4))
    one, other = (Body(cell(m), vector(m * x, 0, 0), (*[ZERO] * 5, cell(m * x**2 * 1.2))) for m, x in masses)
    shoulder = Joint("shoulder", 0, Kind.MOTOR, 0, "q1", body=one)
    elbow = Joint("elbow", 1, Kind.ELASTIC, 0, "q2", d=cell(0.5), body=other, spring=spring(600, 0.2))
    return machine_of("arm", shoulder, elbow)


def swung(servo: bool = False, forces: Sequence[AppliedForce] = ()) -> Reference:
    gains = {"shoulder": Gains(4e3, 60.0)} if servo else None
    return moved(arm(), LONG, {"shoulder": (0.8, LASTS)}, {"shoulder": 0.3}, gains, forces)  # type: ignore[arg-type]


# Independent references


@pytest.mark.thorough
def test_pinocchio_and_dop853_give_the_same_motion() -> None:
    """To the error that is measured, twelve joints, motors under servos."""
    pytest.importorskip("pinocchio")
    servos = dict.fromkeys(("motor_x", "motor_y"), Bandwidth(25, 0.8))
    moves = {"motor_x": (0.002, 0.01), "motor_y": (0.001, 0.01)}
    reference = moved(two_axis(), 0.012, moves, {"motor_y": 0.1}, servos)  # type: ignore[arg-type]
    found = simulate(reference, Request(("tool.x", "tool.y"), None, "w3", 1e-4))
    truth = Truth(reference, [()], np.linspace(0, 0.012, 7), pinocchio_dynamics(reference.machine))
    wrong = np.abs(found.outputs[::20] - truth.outputs(found.names, truth.q)[:, 0]).max(axis=0)
    assert (wrong <= 1.2 * np.array([found.errors[name] for name in found.names])).all()
    assert max(found.errors.values()) < 1e-7 < np.abs(found.deviation).max()


def exact_deflection(t: Array, w: float) -> Array:
    """x'' + w^2 x = -y'' from rest, y the rise of 7th degree: a polynomial and a vibration, free afterwards."""
    scale = Polynomial([0, 1 / LASTS])
    forcing = -BY * RISE(scale).deriv(2)
    particular = sum((forcing.deriv(2 * k) * (-1) ** k / w ** (2 * k + 2) for k in range(3)), Polynomial([0.0]))

    def vibration(since: Array, x: float, v: float) -> Array:
        found: Array = x * np.cos(w * since) + v / w * np.sin(w * since)
        return found

    x, v = -particular(0), -particular.deriv()(0)
    during = particular(t) + vibration(t, x, v)
    x1 = particular(LASTS) + vibration(np.array(LASTS), x, v)
    v1 = particular.deriv()(LASTS) - x * w * np.sin(w * LASTS) + v * np.cos(w * LASTS)
    return np.where(t <= LASTS, during, vibration(t - LASTS, float(x1), float(v1)))


def test_an_oscillator_moves_as_in_closed_form() -> None:
    """m x'' + k x = -m y'': motor prescribed, spring of 10 Hz without damper; within the measured error."""
    found = simulate(driven(), Request(("load.q",), {"load.q": 1e-8}, "rk4"))
    w = np.sqrt(2e4 / 5)
    wrong = np.abs(found.outputs[:, 0] - exact_deflection(found.motion.t, w)).max()
    assert 0.5 < found.errors["load.q"] / wrong < 2 and found.is_within


@pytest.mark.thorough
def test_static_springs_deflect_by_the_inertia_that_they_carry() -> None:
    """q_load = -m a / k, and the tool is there; the motor moves as with a rigid drive."""
    rigid = restrict(drive(), Scene(static={"load": None}))
    reference = moved(rigid, LONG, {"motor": (BY, LASTS)}, servo=SERVO)
    found = simulate(reference, Request(("load.z",), None, "w3", 1e-3))
    q, qdd = found.motion.q[:, 0], found.motion.qdd[:, 0]
    np.testing.assert_allclose(found.outputs[:, 0], q - 5 * qdd / 2e4, rtol=0, atol=1e-15)
    np.testing.assert_allclose(qdd, found.motion.tau[:, 0] / 8, rtol=1e-12, atol=1e-12)


# Errors that are claimed


@cache
def compiled(name: str) -> CompiledSteps:
    machine = drive(d=30) if name == "drive" else arm()
    with TemporaryDirectory() as folder:
        return CompiledSteps(machine, list(METHODS), Path(folder))


@cache
def truth(name: str, servo: bool, samples: int) -> Truth:
    reference = driven(servo, d=30) if name == "drive" else swung(servo)
    t = np.linspace(0, LONG, samples + 1)
    return Truth(reference, [()], t, generated_dynamics(reference.machine))


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("name", "servo", "method", "steps"),
    [
        ("drive", False, "rk4", 50),
        ("drive", False, "w2", 100),
        ("drive", False, "w3", 100),
        ("drive", False, "rodas4", 50),
        ("drive", False, "midpoint", 200),
        ("drive", True, "rk4", 100),
        ("drive", True, "w2", 200),
        ("drive", True, "w3", 100),
        ("drive", True, "rodas4", 50),
        ("drive", True, "midpoint", 200),
        ("arm", False, "w2", 200),
        ("arm", False, "w3", 100),
        ("arm", False, "rodas4", 100),
        ("arm", False, "midpoint", 200),
        ("arm", True, "w3", 200),
        ("arm", True, "rodas4", 100),
    ],
)
def test_errors_by_halving_are_true_within_a_factor_of_two(name: str, servo: bool, method: str, steps: int) -> None:
    of = truth(name, servo, 200)
    names = tuple(f"{joint.name}.q" for joint in of.reference.machine.independent_joints)[0 if servo else 1 :]
    runs = Runs(Simulating(of.reference, Request(names)), compiled(name), method, no_progress)
    _, _, outputs = runs.run(steps)
    exact = of.outputs(names, of.q)[:: 200 // steps, 0] if steps < 200 else of.outputs(names, of.q)[:, 0]
    wrong = np.abs(outputs - exact).max(axis=0)
    claimed = np.array(list(runs.errors(steps).values()))
    seen = wrong > 1e-12
    assert seen.any() and (claimed[seen] <= 2 * wrong[seen]).all() and (wrong[seen] <= 2 * claimed[seen]).all()


@pytest.mark.thorough
def test_outputs_without_tolerance_may_miss_a_thousandth_of_their_deviation() -> None:
    """The largest deflection of the spring is found by the linear model, exactly for a linear machine."""
    found = simulate(driven(), Request())
    times = np.linspace(0.0, found.motion.t[-1], 4001)
    largest = np.abs(exact_deflection(times, np.sqrt(2e4 / 5))).max()
    assert found.names == ("load.q",) and found.is_within
    assert found.tolerance["load.q"] == pytest.approx(1e-3 * largest, rel=2e-3)


# Impulse and energy


def test_momentum_is_the_impulse_of_the_motor() -> None:
    """3 v + 5 (v + v_load) = integral of tau, by Simpson's rule over steps of 1/4000 s."""
    from scipy.integrate import simpson

    found = simulate(driven(servo=True), Request(("load.q",), None, "w3", LONG / 1000))
    motor, load = found.motion.qd.T
    momentum = 8 * motor + 5 * load
    halfway = 601
    impulse = simpson(found.motion.tau[:halfway, 0], x=found.motion.t[:halfway])
    assert momentum[halfway - 1] == pytest.approx(impulse, abs=1e-6 * np.abs(momentum).max())


@pytest.mark.sampled(2)
@pytest.mark.parametrize(("damping", "method"), [(30.0, "w3"), (0.0, "midpoint")])
def test_energy_is_balanced(damping: float, method: str) -> None:
    """What is left over goes down with the square or more of the step; dampers take what they do in truth."""
    reference = driven(servo=True, d=damping)
    coarse, fine = (simulate(reference, Request(("load.q",), None, method, LONG / n)).energy for n in (200, 800))
    assert abs(fine.left_over) < abs(coarse.left_over) / 12 and abs(fine.left_over) < 1e-3 * fine.largest
    assert (fine.dissipated > 0.1) == (damping > 0)
    assert coarse.dissipated == pytest.approx(fine.dissipated, rel=1e-2)


@pytest.mark.thorough
def test_loops_without_closed_form_are_assembled_along_the_motion(tmp_path: Path) -> None:
    """Both integrators agree, one of them by derivatives; the dependent joints are those at each position."""
    sticking = closed_chain("ring")
    loose = (replace(j, friction=replace(j.friction, coulomb=ZERO)) for j in sticking.joints)
    machine = replace(sticking, joints=tuple(loose))
    system = CompiledMotion(moved(machine, 0.05, {"drive": (0.02, 0.04)}), tmp_path)
    t = np.linspace(0, 0.05, 6)
    one, other = (integrate(system, name, 1e-6).trajectory(t) for name in ("DOP853", "Radau"))
    assert (np.abs(one.q - other.q) <= 1e-4 * np.ptp(one.q, axis=0)).all()
    np.testing.assert_allclose(one.q_dep, Followed(machine, given_values(machine)).at(one.q), rtol=0, atol=1e-12)


@pytest.mark.thorough
def test_the_right_side_of_assembled_loops_is_the_same_whatever_was_called_before(tmp_path: Path) -> None:
    """It depends on the time, the state and the position that loops are closed from, and on nothing else."""
    system = CompiledMotion(moved(closed_chain("ring"), 0.05, {"drive": (0.02, 0.04)}), tmp_path)
    y, near = system.start, system.reference.at_start
    before = system.rate(0.02, y, near), system.jacobian(0.02, y, near)
    for k in range(1, 4):
        system.rate(0.03, y + 0.02 * k, near)
        system.jacobian(0.01, y - 0.02 * k, near)
    assert np.array_equal(system.rate(0.02, y, near), before[0])
    assert np.array_equal(system.jacobian(0.02, y, near), before[1])


# Adapted steps


def adapted(reference: Reference, method: str, precision: float, tmp_path: Path, t: Array) -> Array:
    system = CompiledMotion(reference, tmp_path / method)
    trajectory = integrate(system, method, precision).trajectory(t)
    return Observer(reference.machine, reference, ("shoulder.q", "elbow.q")).outputs(
        Observer(reference.machine, reference, ()).motion(trajectory)
    )


def test_both_integrators_agree_with_an_independent_motion(tmp_path: Path) -> None:
    of = truth("arm", True, 200)
    exact = of.outputs(("shoulder.q", "elbow.q"), of.q)[:, 0]
    for method in ("DOP853", "Radau"):
        wrong = np.abs(adapted(of.reference, method, 1e-7, tmp_path, of.t) - exact).max()
        assert wrong < 1e-5 * np.abs(exact).max()


@pytest.mark.sampled(2)
@pytest.mark.parametrize("servo", [False, True])
def test_derivatives_of_the_right_side_are_differences(servo: bool, tmp_path: Path) -> None:
    system = CompiledMotion(swung(servo), tmp_path)
    y = system.start + 0.01 * np.arange(1, len(system.start) + 1)
    steps = 1e-5 * np.eye(len(y))
    near = system.reference.at_start
    slopes = [(system.rate(0.07, y + s, near) - system.rate(0.07, y - s, near)) / 2e-5 for s in steps]
    np.testing.assert_allclose(system.jacobian(0.07, y, near), np.array(slopes).T, rtol=1e-6, atol=1e-4)


FORCE = AppliedForce("elbow", (30.0, -20.0, 10.0, 0.0, 0.0, 2.0), 0.02, 0.1)


@cache
def pushed() -> tuple[Reference, Array, Array]:
    """A motion under a force; positions of the elbow and torques of the shoulder, by the transposed Jacobian."""
    reference = swung(forces=[FORCE])
    of = Truth(reference, [()], np.linspace(0, LONG, 21), generated_dynamics(reference.machine))
    motors = list(reference.machine.motor_entries)
    return reference, of.outputs(("elbow.q",), of.q)[:, 0, 0], of.motor_torques()[:, 0, motors]


@pytest.mark.sampled(1000)
@pytest.mark.parametrize("method", [None, "w3", "rk4", "rodas4"])
def test_forces_on_frames_move_the_machine(method: str | None) -> None:
    """By even steps, and by adapted ones (no method); torques of motors that follow exactly hold them too."""
    reference, positions, held = pushed()
    request = Request(("elbow.q", "shoulder.tau"), {"elbow.q": 1e-6}, method, LONG / 800 if method else None)
    found = simulate(reference, request) if method else simulate_adaptively(reference, request, {})
    every = (len(found.motion.t) - 1) // 20
    np.testing.assert_allclose(found.outputs[::every, 0], positions, rtol=0, atol=1e-6)
    np.testing.assert_allclose(found.outputs[::every, 1:], held, rtol=1e-4, atol=1e-2)
    assert abs(found.energy.left_over) < 1e-5 * found.energy.largest


@pytest.mark.thorough
def test_predicted_errors_of_steps_hold_under_forces() -> None:
    reference, *_ = pushed()
    found = simulate(reference, Request(("elbow.q",), {"elbow.q": 1e-6}, "w3", LONG / 100))
    assert found.errors["elbow.q"] == pytest.approx(found.predicted["elbow.q"], rel=0.05)


def test_static_springs_feel_forces() -> None:
    """z of the tool with the spring static: that of the motor, F / k beyond it, less m a / k."""
    rigid = restrict(drive(), Scene(static={"load": None}))
    force = AppliedForce("load", (0.0, 0.0, 100.0, 0.0, 0.0, 0.0), 0.0, 0.05)
    reference = moved(rigid, LONG, {"motor": (BY, LASTS)}, servo=SERVO, forces=[force])
    found = simulate(reference, Request(("load.z",), None, "w3", 1e-3))
    q, qdd, t = found.motion.q[:, 0], found.motion.qdd[:, 0], found.motion.t
    push = reference.wrenches(t)[0][:, 2]
    np.testing.assert_allclose(found.outputs[:, 0], q + (push - 5 * qdd) / 2e4, rtol=0, atol=1e-15)
    np.testing.assert_allclose(qdd, (found.motion.tau[:, 0] + push) / 8, rtol=1e-12, atol=1e-12)


@pytest.mark.thorough
def test_steps_of_a_machine_without_forces_are_not_taken_under_forces(tmp_path: Path) -> None:
    force = AppliedForce("load", (0.0, 0.0, 1.0, 0.0, 0.0, 0.0), 0.0, 0.1)
    reference = moved(drive(), LONG, {"motor": (BY, LASTS)}, forces=[force])
    with pytest.raises(InputError, match="motion, forces: these steps were generated for a machine under other forces"):
        CompiledSteps(drive(), ["w3"], tmp_path).run(reference, "w3", 10)


@pytest.mark.thorough
def test_examples_with_couplings_are_simulated() -> None:
    """A linkage that is coupled and closed; its spring is free, its motors follow exactly."""
    machine, _ = read_machine(EXAMPLES / "linkage.toml")
    moves = {joint.name: (0.05, 0.1) for joint in machine.motor_joints}
    found = simulate(moved(machine, 0.15, moves), Request())
    assert found.is_within and abs(found.energy.left_over) < 1e-4 * found.energy.largest
