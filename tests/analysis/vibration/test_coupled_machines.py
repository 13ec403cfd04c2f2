"""Small motions of machines whose joints depend on others: equilibria, modes, energies, responses, refusals."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from mpmath import mpf

from symoro_elastic.analysis.vibration.comparison import Compared, compare, rigid_limit
from symoro_elastic.analysis.vibration.linearization import Linearization, linearize, with_motors
from symoro_elastic.analysis.vibration.modes import Modes, kinetic_shares, modes, sensitivity, strain_shares
from symoro_elastic.analysis.vibration.responses import frequency_response
from symoro_elastic.formats import read_machine
from symoro_elastic.foundation.array_types import AnyArray
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.formula import ZERO, Formula
from symoro_elastic.machine.machine import Base, Friction, Kind, Machine, Parameter, Spring, Wrench
from symoro_elastic.machine.restrict import rigid
from symoro_elastic.models.programs.catalogue import trace
from symoro_elastic.numerics.evaluation.assembled_states import start_of
from symoro_elastic.numerics.motion.equations_of_motion import EquationsOfMotion
from symoro_elastic.numerics.motion.equilibrium import equilibrium, given_state
from symoro_elastic.numerics.motion.independent_joints import with_independent_motors
from symoro_elastic.symbolic.arithmetic import FLOATS, evaluate
from tests.closed_chains.machines import WITH_RESULTS, data, machine, situations, without_closed_form
from tests.references.closed_chains import Chain, State, in_many_digits
from tests.references.virtual_work import VirtualWork, small_motions

pytestmark = pytest.mark.sampled(5)

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


@pytest.mark.thorough
def test_sensitivity_to_a_length_of_an_assembled_loop() -> None:
    joints = list(without_closed_form().joints)
    row = next(j for j, joint in enumerate(joints) if joint.name == "cross")
    length = Parameter("length", joints[row].d)
    joints[row] = replace(joints[row], d=Formula.parse(length.name))
    described = replace(without_closed_form(), joints=tuple(joints), parameters=(length,))
    assert_differences(described, "length")


ROD = "rod_1"


def driven_at_the_rod() -> Machine:
    """A five-bar with rigid cranks and three motors, of which that of a rod follows from the others: S_m varies."""
    five_bar = rigid(machine("five_bar"))
    joints = [replace(x, kind=Kind.MOTOR) if x.name == ROD else x for x in five_bar.joints]
    loop = replace(five_bar.loops[0], dependent=tuple(five_bar.joint(j).name for j in five_bar.dependent))
    return replace(five_bar, joints=tuple(joints), loops=(loop,))


def test_torques_of_motors_that_move_each_other_act_on_the_stiffness() -> None:
    """M, D, K about a motion, F = S_m^T and encoders of dependent motors, of d'Alembert's principle in 70 digits."""
    described = driven_at_the_rod()
    joints = tuple(replace(joint, friction=Friction(joint.friction.viscous)) for joint in described.joints)
    motion = EquationsOfMotion(replace(described, joints=joints))
    state = State([x + 0.05 for x in start_of(described).q], [0.7, -1.1], _start(described))
    named = (dict(zip(motion.names, numbers, strict=True)) for numbers in (state.u, state.ud))
    torques = dict(zip(motion.motor_names, (37.0, -12.0, 25.0), strict=True))
    linear = linearize(motion, given_state(motion, *named, torques))
    wanted = small_motions(motion.machine, state, list(torques.values()))
    for ours, matrix in zip((linear.M, linear.D, linear.K), wanted, strict=True):
        exact = np.array(matrix, dtype=float)
        np.testing.assert_allclose(ours, exact, rtol=0, atol=1e-14 * np.abs(exact).max())
    reference = VirtualWork(motion.machine, state)
    S_m = reference.S_x[[reference.chain.own.index(motor) for motor in reference.chain.motors]].astype(float)
    np.testing.assert_allclose(linear.F.T, S_m, rtol=0, atol=1e-14)
    np.testing.assert_allclose(linear.Cq, S_m, rtol=0, atol=1e-14)


@in_many_digits
def test_rates_and_accelerations_of_dependent_joints_are_outputs() -> None:
    """Of the rocker of a four-bar, against differences of a step of 1e-20 of the motion in 70 digits."""
    described, situation = machine("four_bar"), situations("four_bar")[0]
    x, udd, h = np.array([*map(mpf, (*situation.state.u, *situation.state.ud))]), [1.5, -0.5], mpf(10) ** -20

    def moved(x: AnyArray) -> AnyArray:
        at = VirtualWork(described, State([*x[:2]], [*x[2:]], situation.state.guess))
        row = at.chain.own.index("q3")
        return np.array([at.xd[row], at.accelerations(np.array([*map(mpf, udd)]))[row]])

    motion = EquationsOfMotion(described)
    named = (dict(zip(motion.names, numbers, strict=True)) for numbers in (situation.state.u, situation.state.ud))
    state = replace(given_state(motion, *named), qdd=np.array(udd))
    linear = linearize(motion, state, (), ("rocker.qd", "rocker.qdd"))
    ours = np.hstack([linear.Cq, linear.Cv])
    for k in range(4):
        step = np.array([h if i == k else mpf(0) for i in range(4)])
        slopes = ((moved(x + step) - moved(x - step)) / (2 * h)).astype(float)
        np.testing.assert_allclose(ours[:, k], slopes, rtol=1e-13, atol=1e-15)


def test_holding_a_motor_holds_those_that_move_with_it() -> None:
    motion = EquationsOfMotion(machine("gantry_rigid"))
    linear = linearize(motion, equilibrium(motion))
    for name in ("carriage_1", "carriage_2"):
        found = with_motors(linear, [name])
        assert found.held == ("carriage_1", "carriage_2") and found.coordinates == ("cross_slide", "ram")
        assert found.inputs == ("cross_slide.tau", "ram.tau")
    stiff = with_motors(linear, gains={"carriage_1": (100.0, 1.0), "carriage_2": (50.0, 2.0)})
    assert stiff.K[0, 0] - linear.K[0, 0] == pytest.approx(150.0)
    assert stiff.D[0, 0] - linear.D[0, 0] == pytest.approx(3.0)
    assert strain_shares(modes(stiff)).names[:2] == ("carriage_1 (controller)", "carriage_2 (controller)")


def test_motors_that_move_each_other_share_what_holds_the_machine() -> None:
    """Gravity along the ways; the file's shares are two to one, and without any squares of torques are least."""
    tilted = replace(machine("gantry_rigid"), base=Base(gravity=(Formula.parse(0), Formula.parse(-9.81), ZERO)))
    unweighed = replace(tilted, joints=tuple(replace(joint, sharing=ZERO) for joint in tilted.joints))
    for described, share in ((tilted, 2 / 3), (unweighed, 1 / 2)):
        motion = EquationsOfMotion(described)
        linear = linearize(motion, equilibrium(motion), (), ())
        torques = dict(zip(motion.motor_names, linear.state.torques, strict=True))
        whole = 9.81 * (45 + 40 + 120 + 60 + 35)
        assert torques["carriage_1"] == pytest.approx(share * whole, rel=1e-12)
        assert torques["carriage_2"] == pytest.approx((1 - share) * whole, rel=1e-12)
        assert any("carriage_1, carriage_2 move each other" in line for line in linear.notes) == (share == 1 / 2)


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


@pytest.mark.thorough
@pytest.mark.parametrize("given", [without_closed_form(), machine("gantry")], ids=["assembled", "gantry"])
def test_compared_torques_obey_the_virtual_work(given: Machine) -> None:
    """Where loops are assembled along the motion; where two motors move as one in the rigid limit."""
    frictions = (replace(joint, friction=Friction(joint.friction.viscous)) for joint in given.joints)
    described = replace(given, joints=tuple(frictions))
    found = compare(described, stroke=0.1, duration=0.5)
    tau = [loss for loss in found.losses if loss.quantity is Compared.TORQUE]
    whole, sample = with_independent_motors(described), 180
    variables = [str(joint.variable) for joint in whole.independent_joints]
    for model, by_model in ((whole, "by_full"), (rigid_limit(whole), "by_rigid")):
        at = [
            dict(zip(variables, x[sample].tolist(), strict=True))
            for x in (found.trajectory.q, found.trajectory.qd, found.trajectory.qdd)
        ]
        names = [str(joint.variable) for joint in model.independent_joints]
        q, qd, qdd = ([x[variable] for variable in names] for x in at)
        torques = [float(getattr(loss, by_model)[sample]) for loss in tau]
        left = VirtualWork(model, State(q, qd, _start(model))).residual(qdd, torques).astype(float)
        driven = [names.index(str(joint.variable)) for joint in model.motor_joints if str(joint.variable) in names]
        assert np.abs(left[driven]).max() < 1e-11 * np.abs(torques).max()
    assert bool(found.notes) == (given.name == "gantry")


def test_no_rigid_limit_is_said_by_the_joint() -> None:
    """A loop of one freedom: the spring of the coupler is all that lets the crank move."""
    described, dependent = machine("four_bar"), ("coupler", "rocker")
    spring = Spring(Formula.parse(50))
    joints = [replace(x, kind=Kind.ELASTIC, spring=spring) if x.name == "coupler" else x for x in described.joints]
    sprung = replace(described, joints=tuple(joints), loops=(replace(described.loops[0], dependent=dependent),))
    with pytest.raises(
        InputError, match="joint crank: only springs let its motor move, so the rigid limit cannot move"
    ):
        compare(sprung)
    both = [replace(x, kind=Kind.ELASTIC, spring=spring) if x.name in dependent else x for x in described.joints]
    with pytest.raises(InputError, match="joint rocker: in the rigid limit it would be locked, and nothing else in"):
        compare(replace(sprung, joints=tuple(both)))


def test_dry_friction_on_a_dependent_joint_is_not_followed() -> None:
    with pytest.raises(InputError, match="friction: rod has no motor, so dry friction holds it at times"):
        compare(machine("gas_spring"))


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


@pytest.mark.sampled(1000)
@pytest.mark.parametrize(("name", "motors"), [("gantry", ["carriage_2"]), ("delta", ["arm_1", "arm_2", "arm_3"])])
def test_motors_on_dependent_joints_become_independent(name: str, motors: list[str]) -> None:
    """The modes are those of the coordinates of the file, in which these motors follow from the loops."""
    described = machine(name)
    assert {described.joint(j).name for j in described.motors if j in described.dependent} == {*motors}
    found = vibrations(described, held=False)
    assert found.linear.held == () and {*motors} <= {*found.linear.coordinates}
    motion, state, n = found.linear.motion, found.linear.state, len(described.independent)
    at = VirtualWork(motion.machine, State(state.q.tolist(), [0.0] * n, _start(described))).at
    symbols = {p.name: p.value.value() for p in described.parameters if p.value}
    symbols |= {variable: float(x) for variable, x in at.items()}
    program = trace(described, "linearization").program
    rest = {"qd": [0.0] * n, "qdd": [0.0] * n, "tau": state.torques}
    for entries in program.inputs:
        symbols |= dict(zip(entries.symbols, rest.get(entries.name, ()), strict=entries.name in rest))
    value = evaluate((x for output in program.outputs for x in output.entries), symbols, FLOATS)
    M, D, K = (np.array([float(value(x)) for x in o.entries]).reshape(n, n) for o in program.outputs)
    wanted = np.sort(np.linalg.eigvals(np.linalg.solve(M, K)).real)
    np.testing.assert_allclose(found.eigenvalues, wanted, rtol=0, atol=1e-11 * np.abs(wanted).max())
    A = np.block([[np.zeros((n, n)), np.eye(n)], [-np.linalg.solve(M, K), -np.linalg.solve(M, D)]])
    poles = np.linalg.eigvals(A)
    for pole in found.poles:
        assert np.abs(poles - pole).min() < 1e-10 * np.abs(poles).max()


def _start(described: Machine) -> dict[str, float]:
    chain = Chain(described)
    start = {variable: x.value() for loop in described.loops for variable, x in loop.start.items()}
    return dict.fromkeys((*chain.own, *chain.cuts), 0.0) | start


def test_motors_that_move_each_other_are_free_together_only() -> None:
    motion = EquationsOfMotion(driven_at_the_rod())
    with pytest.raises(InputError, match="--torque: motor_1, motor_2, rod_1 move each other, so none is free by it"):
        equilibrium(motion, torques={"motor_1": 1.0})
    linear = linearize(motion, equilibrium(motion))
    with pytest.raises(InputError, match="--hold: rod_1 alone would leave motor_1, motor_2 free to move together"):
        with_motors(linear, ["rod_1"])
    assert with_motors(linear, ["motor_1", "rod_1"]).held == tuple(motion.motor_names)


@pytest.mark.parametrize(
    ("name", "values", "at", "what"),
    [
        ("ring", {}, {"drive": 0.6, "link_1": 1e4}, "loop ring: it does not close at drive=0.6"),
        ("five_bar", {}, {"rod_1": 0.1}, "rod_1 does not move by itself: independent joints are"),
        ("five_bar", {"L2": 0.4}, {"motor_1": 3.1, "motor_2": 0.0}, "loop diamond: it does not close at motor_1=3.1"),
    ],
)
def test_what_is_refused(name: str, values: dict[str, float], at: dict[str, float], what: str) -> None:
    with pytest.raises(InputError) as error:
        motion = EquationsOfMotion(machine(name), values)
        equilibrium(motion, at)
    assert what in str(error.value)
