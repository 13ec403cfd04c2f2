"""Small motions of machines whose joints depend on others: equilibria, modes, energies, responses, refusals."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from symoro_elastic.errors import InputError
from symoro_elastic.machine.formats import read_machine
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.machine import Friction, Machine, Parameter, Wrench
from symoro_elastic.models.catalogue import trace
from symoro_elastic.symbolic.arithmetic import FLOATS, evaluate
from symoro_elastic.vibration.comparison import compare
from symoro_elastic.vibration.energies import kinetic_shares, strain_shares
from symoro_elastic.vibration.equations_of_motion import EquationsOfMotion
from symoro_elastic.vibration.equilibrium import equilibrium, given_state
from symoro_elastic.vibration.linearization import Linearization, linearize, with_motors
from symoro_elastic.vibration.modes import Modes, modes
from symoro_elastic.vibration.responses import frequency_response
from symoro_elastic.vibration.sensitivity import sensitivity
from tests.closed_chains.machines import WITH_RESULTS, data, machine, situations, without_closed_form
from tests.references.virtual_work import small_motions

GEARED_PENDULUM = """
name = "geared_pendulum"
joints = [
  { name = "motor", antecedent = 0, kind = "motor", sigma = 0, theta = "qm" },
  { name = "arm", antecedent = 0, kind = "elastic", sigma = 0, theta = "qm/N + twist", variable = "twist" },
]
[parameters]
N = { value = 50 }
[bodies]
motor = { mass = 1, inertia = [0, 0, 0, 0, 0, 0.001] }
arm = { mass = 2, inertia = [0, 0, 0, 0, 0, 0.5] }
[springs]
arm = { stiffness = 2000 }
"""


def at_rest(described: Machine, held: bool = True) -> Linearization:
    motion = EquationsOfMotion(described)
    linear = linearize(motion, equilibrium(motion), (), ())
    return with_motors(linear, [joint.name for joint in described.motor_joints] if held else [])


def vibrations(described: Machine, held: bool = True) -> Modes:
    return modes(at_rest(described, held))


def test_loops_without_closed_form_are_assembled() -> None:
    """M, D, K about a motion are those of d'Alembert's principle, whose loops are closed in 70 digits."""
    situation, joints = situations("spatial_four_bar")[0], without_closed_form().joints
    viscous = tuple(replace(joint, friction=Friction(joint.friction.viscous)) for joint in joints)
    described = replace(without_closed_form(), joints=viscous)
    motion = EquationsOfMotion(described)
    named = (dict(zip(motion.names, numbers, strict=True)) for numbers in (situation.state.u, situation.state.ud))
    torques = {joint.name: x for joint, x in zip(described.motor_joints, situation.tau, strict=True)}
    linear = linearize(motion, given_state(motion, *named, torques))
    wanted = small_motions(described, situation.state, situation.tau)
    for ours, matrix in zip((linear.M, linear.D, linear.K), wanted, strict=True):
        exact = np.array(matrix, dtype=float)
        np.testing.assert_allclose(ours, exact, rtol=0, atol=1e-11 * np.abs(exact).max())


def test_sensitivity_to_a_length_of_an_assembled_loop() -> None:
    joints = list(without_closed_form().joints)
    row = next(j for j, joint in enumerate(joints) if joint.name == "cross")
    length = Parameter("length", joints[row].d)
    joints[row] = replace(joints[row], d=Formula.parse(length.name))
    described = replace(without_closed_form(), joints=tuple(joints), parameters=(length,))
    assert_differences(described, "length")


def test_compare_needs_closed_forms() -> None:
    with pytest.raises(InputError, match="loop linkage: not offered where a loop has no closed form"):
        compare(without_closed_form())


@pytest.mark.parametrize("name", WITH_RESULTS)
def test_about_a_motion_against_many_digits(name: str) -> None:
    """M, D, K of another program, tangent stiffness of constraint forces included; its torques give its motion."""
    described, situation, known = machine(name), situations(name)[0], data(name)["linearization"]
    motion = EquationsOfMotion(described)
    named = (dict(zip(motion.names, numbers, strict=True)) for numbers in (situation.state.u, situation.state.ud))
    torques = {joint.name: x for joint, x in zip(described.motor_joints, situation.tau, strict=True)}
    linear = linearize(motion, given_state(motion, *named, torques))
    for label, ours in (("M", linear.M), ("D", linear.D), ("K", linear.K)):
        wanted = np.array(known[label], dtype=float)
        np.testing.assert_allclose(ours, wanted, rtol=0, atol=1e-13 * np.abs(wanted).max(initial=1e-12))


def test_a_pendulum_behind_an_elastic_gear(tmp_path: Path) -> None:
    """Held: sqrt(k / J). Free: rotor and arm against each other through the ratio, J Jr N^2 / (J + Jr N^2)."""
    path = tmp_path / "geared_pendulum.toml"
    path.write_text(GEARED_PENDULUM, encoding="utf-8")
    described = read_machine(path)[0]
    J, k, reflected = 0.5, 2000.0, 50**2 * 0.001
    (held,) = vibrations(described).frequencies
    assert held == pytest.approx(np.sqrt(k / J) / (2 * np.pi), rel=1e-13)
    rigid, free = vibrations(described, held=False).frequencies
    assert rigid == 0
    assert free == pytest.approx(np.sqrt(k / (J * reflected / (J + reflected))) / (2 * np.pi), rel=1e-13)


def test_springs_of_a_ball_screw_are_in_series() -> None:
    """What is turned counts with the square of the pitch, and before the belt with that of the ratio of pulleys."""
    described, pitch, ratio = machine("ball_screw"), 0.02 / (2 * np.pi), 0.03 / 0.045
    turned = 1 / 40200 + 1 / (2 * 1.6e6 * 0.045**2) + ratio**2 / 45000
    compliance = 1 / 1.7e8 + pitch**2 * turned + 1 / 5e8 + 1 / 4e8
    motion = EquationsOfMotion(described)
    linear = linearize(motion, equilibrium(motion), ["table.fx"], ["table.x"])
    response = frequency_response(with_motors(linear, ["motor"]), np.array([0.0]))
    assert response.values[0, 0, 0].real == pytest.approx(compliance, rel=1e-12)
    pushed = [replace(j, wrench=_along_x(-100.0)) if j.name == "table" else j for j in described.joints]
    motion = EquationsOfMotion(replace(described, joints=tuple(pushed)))
    q = dict(zip(motion.names, equilibrium(motion).q, strict=True))
    moved = q["screw_axial"] + pitch * (ratio * q["motor_pulley"] + q["screw_pulley"] + q["screw"]) + q["nut"]
    assert moved + q["table"] == pytest.approx(100 * compliance, rel=1e-12)


def _along_x(force: float) -> Wrench:
    """The frame of the table has its z axis along x of frame 0."""
    zero = Formula.parse(0.0)
    return Wrench((zero, zero, Formula.parse(force)))


@pytest.mark.parametrize("name", ["five_bar", "press", "ball_screw", "parallelogram_loop", "gas_spring"])
def test_shares_of_energy(name: str) -> None:
    """Kinetic energies of bodies and rotors add up to phi^T M phi = 1, elastic ones with the rest to the eigenvalue."""
    found = vibrations(machine(name))
    linear, kinetic, strain = found.linear, kinetic_shares(found), strain_shares(found)
    np.testing.assert_allclose(kinetic.shares.sum(axis=0), 1, rtol=1e-12)
    np.testing.assert_allclose(strain.shares.sum(axis=0), 1, rtol=1e-12)
    springs = [row for row, owner in enumerate(strain.names) if owner in linear.motion.springs]
    for row in springs:
        if strain.names[row] in linear.coordinates:
            k = list(linear.motion.springs).index(strain.names[row])
            stiffness = linear.motion.spring_stiffnesses(linear.state.q)[k]
            shape = found.shapes[linear.coordinates.index(strain.names[row])]
            np.testing.assert_allclose(strain.shares[row], stiffness * shape**2 / found.eigenvalues, atol=1e-9)


def test_the_share_of_a_rotor_is_of_the_whole_energy() -> None:
    """phi^T M phi = 1, so that its share is Ia phi^2."""
    described = machine("five_bar")
    found = vibrations(described, held=False)
    kinetic = kinetic_shares(found)
    row = kinetic.names.index("motor_1 (rotor)")
    np.testing.assert_allclose(kinetic.shares[row], 0.05 * found.shapes[0] ** 2, rtol=1e-9)


@pytest.mark.parametrize(("name", "parameter"), [("five_bar", "L1"), ("press", "R"), ("screw", "pitch")])
def test_sensitivities_are_differences(name: str, parameter: str) -> None:
    """Lengths of a loop move its dependent joints too."""
    assert_differences(machine(name), parameter)


def assert_differences(described: Machine, parameter: str) -> None:
    """Differences of step 1e-5 lose five digits, and are off by the square of it."""
    found = vibrations(described)
    slopes = sensitivity(found, [parameter]).slopes[0]
    value, step = EquationsOfMotion(described).parameters[parameter], 1e-5

    def frequencies(x: float) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
        motion = EquationsOfMotion(described, {parameter: x})
        motors = [joint.name for joint in motion.machine.motor_joints]
        return modes(with_motors(linearize(motion, equilibrium(motion), (), ()), motors)).frequencies

    wanted = (frequencies(value * (1 + step)) - frequencies(value * (1 - step))) / (2 * step * value)
    np.testing.assert_allclose(slopes, wanted, rtol=0, atol=1e-6 * np.abs(wanted).max())


def test_a_parallelogram_by_loop_or_by_hand() -> None:
    by_hand, by_loop = EquationsOfMotion(machine("parallelogram")), EquationsOfMotion(machine("parallelogram_loop"))
    at = {"yaw": 0.3, "arm": -0.8, "crank": 0.4}
    one, other = (modes(linearize(m, equilibrium(m, at), (), ())) for m in (by_hand, by_loop))
    np.testing.assert_allclose(one.eigenvalues, other.eigenvalues, rtol=0, atol=1e-9 * np.abs(one.eigenvalues).max())


def test_motors_on_dependent_joints_become_independent() -> None:
    """The modes are those of the coordinates of the file, in which the second motor follows from the loop."""
    described = machine("gantry")
    found = vibrations(described, held=False)
    assert found.linear.held == () and "carriage_2" in found.linear.coordinates
    at = dict(zip(found.linear.motion.names, found.linear.state.q, strict=True))
    program = trace(described, "linearization").program
    q = [at.get(joint.name, 0.0) for joint in described.moving_joints]
    holding = dict(zip(found.linear.motion.names, found.linear.state.tau, strict=True))
    tau = [holding[joint.name] for joint in described.motor_joints]
    given = {"q": q, "qd": [0.0] * 4, "qdd": [0.0] * 4, "tau": tau}
    symbols = {p.name: p.value.value() for p in described.parameters if p.value}
    for entries in program.inputs:
        symbols |= dict(zip(entries.symbols, given[entries.name], strict=True))
    value = evaluate((x for output in program.outputs for x in output.entries), symbols, FLOATS)
    M, _, K = (np.array([float(value(x)) for x in o.entries]).reshape(4, 4) for o in program.outputs)
    wanted = np.sort(np.linalg.eigvals(np.linalg.solve(M, K)).real)
    np.testing.assert_allclose(found.eigenvalues, wanted, rtol=0, atol=1e-11 * wanted.max())


@pytest.mark.parametrize(
    ("name", "values", "at", "what"),
    [
        ("gantry_rigid", {}, {}, "joint carriage_2: not offered where a motor is on a dependent joint"),
        ("ring", {}, {"drive": 0.6, "link_1": 1e4}, "loop ring: it does not close at drive=0.6"),
        ("five_bar", {}, {"rod_1": 0.1}, "rod_1 follows from a loop: name an independent joint"),
        ("five_bar", {"L2": 0.4}, {"motor_1": 3.1, "motor_2": 0.0}, "loop diamond: it does not close at motor_1=3.1"),
    ],
)
def test_what_is_refused(name: str, values: dict[str, float], at: dict[str, float], what: str) -> None:
    with pytest.raises(InputError) as error:
        motion = EquationsOfMotion(machine(name), values)
        equilibrium(motion, at)
    assert what in str(error.value)
