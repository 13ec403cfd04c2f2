"""Steps stay right, or say that they are not, where stiffness, speed, size and time are at their limits."""

from __future__ import annotations

import math
from collections.abc import Callable
from fractions import Fraction
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import mpmath
import numpy as np
import pytest
from scipy.integrate import solve_ivp

from symoro_elastic.analysis.ladder.rungs import ladder_of_prediction, prediction_of
from symoro_elastic.analysis.simulation.compiled_steps import CompiledSteps
from symoro_elastic.analysis.simulation.prediction.step_error import MOST_STEPS
from symoro_elastic.analysis.simulation.reference_motion import Reference, reference_of
from symoro_elastic.analysis.simulation.simulate import Request, Simulating, simulate
from symoro_elastic.codegen.integration.tableaus import METHODS, WMethod
from symoro_elastic.formats.toml import reading as toml
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.formula import ZERO
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.prescribed_motion import Bandwidth, Gains, Move, PrescribedMotion, Wobble
from symoro_elastic.machine.restrict import restrict
from symoro_elastic.machine.scene import Scene
from symoro_elastic.numerics.verification.implementations import numpy_model
from tests.analysis.simulation.carriage import carriage, moved, true_motion, values
from tests.analysis.simulation.with_parameters import StepsWithParameters

pytestmark = pytest.mark.sampled(5)

pytest.importorskip("pinocchio")
STIFFER = (1, 1e4, 1e8)
SERVO = Bandwidth(15, 0.8)
TIMES = np.linspace(0.0, 0.2, 41)
REFERENCE = 3e-9
"""Error of the reference, m and rad: 1e-7 relative, of 0.1 m."""
SPREAD = 2.5
"""Steps at one stiffness over those at another, for the same error."""
EPS = np.finfo(float).eps


@cache
def carriage_steps() -> StepsWithParameters:
    with TemporaryDirectory() as folder:
        return StepsWithParameters(carriage(), ("w2", "w3", "rodas4", "rk4", "midpoint"), Path(folder))


def compiled(machine: Machine, *methods: str) -> CompiledSteps:
    with TemporaryDirectory() as folder:
        return CompiledSteps(machine, methods, Path(folder))


# Stiffness


@cache
def exact(times: float, damping: float) -> tuple[Reference, Array]:
    given = values(times, damping)
    reference = moved(given, servo=SERVO)
    return reference, true_motion(reference, given, TIMES)


def error(method: str, steps: int, times: float, damping: float) -> float:
    reference, wanted = exact(times, damping)
    runner = carriage_steps()
    runner.p[:] = list(values(times, damping).values())
    found = runner.run(reference, method, steps).q[:: steps // (len(TIMES) - 1)]
    return float(np.abs(found - wanted).max())


@pytest.mark.sampled(1000)
@pytest.mark.parametrize("damping", [0.0, 0.05])
@pytest.mark.parametrize("method", ["w2", "w3"])
def test_the_same_steps_suffice_at_any_stiffness(method: str, damping: float) -> None:
    """Errors at 120 steps, in steps that they cost at the order of the method."""
    errors = np.array([error(method, 120, times, damping) for times in STIFFER])
    steps = errors ** (1 / METHODS[method].order)
    assert steps.max() / steps.min() < SPREAD


@pytest.mark.thorough
@pytest.mark.parametrize("times", STIFFER)
@pytest.mark.parametrize("damping", [0.0, 0.05])
@pytest.mark.parametrize("method", ["w2", "w3", "rodas4"])
def test_errors_go_down_by_the_order_at_any_stiffness(method: str, damping: float, times: float) -> None:
    """To those of the reference; rodas4 is there at once."""
    coarse, fine = (error(method, steps, times, damping) for steps in (160, 320))
    assert fine < REFERENCE or math.log2(coarse / fine) > METHODS[method].order - 0.3


@pytest.mark.thorough
@pytest.mark.parametrize("times", [1e4, 1e8])
def test_deflections_of_stiff_springs_are_those_of_statics(times: float) -> None:
    """Motors follow exactly: -reaction / k, with springs locked; inertia of the deflection is 1e-5 of it or less."""
    reference = moved(values(times, 0.0))
    runner = carriage_steps()
    runner.p[:] = given = list(values(times, 0.0).values())
    found = runner.run(reference, "w3", 400)
    y, yd, ydd = reference.at(found.t)
    held = np.zeros_like(found.q)
    q, v, a = (np.column_stack([x, held[:, 1:]]) for x in (y, yd, ydd))
    model = numpy_model(carriage(), ("inertia_matrix", "bias_forces"))
    reaction = (model.inertia_matrix(q) @ a[..., None])[..., 0] + model.bias_forces(q, v)
    wanted = -reaction[:, 1:] / np.array([given[0], given[2]])
    assert np.abs(found.q[:, 1:] - wanted).max() < 1e-4 * np.abs(wanted).max()


@pytest.mark.thorough
def test_an_explicit_method_at_any_stiffness_is_not_tried_step_by_step() -> None:
    """The steps that RK4 bears are said at once, however many; another method is taken."""
    machine = stiff_carriage(1e8)
    motion = PrescribedMotion(0.2, {}, (Move("motor", 0.1, 0.0, 0.15),))
    simulating = Simulating(reference_of(machine, motion), Request(tolerance={"arm.q": 1e-6}))
    steps, predicted = simulating.steps_of(METHODS["rk4"])
    assert steps > MOST_STEPS and all(map(math.isnan, predicted.values()))
    assert simulating.cheapest() in ("w2", "w3")
    with pytest.raises(InputError, match=r"beyond the limit of rk4 here: give at most .* s, or w3, w2"):
        simulate(simulating.reference, Request(tolerance={"arm.q": 1e-6}, method="rk4", step=1e-5))


def stiff_carriage(times: float, damping: float = 0.05) -> Machine:
    text = toml.write(carriage())
    for name, value in values(times, damping).items():
        text = text.replace(f'"{name}"', repr(value))
    return toml.read(text, "carriage.toml")


# Steps from 1e-9 to 1 s


OSCILLATOR = """
name = "oscillator"
gravity = [0, 0, 0]
joints = [
  {{ name = "motor", kind = "motor", sigma = 1, r = "q1" }},
  {{ name = "mass", kind = "elastic", sigma = 1, r = "q2" }},
]
[bodies]
motor = {{ mass = 1 }}
mass = {{ mass = 1 }}
[springs]
mass = {{ stiffness = {stiffness}, neutral = -0.25 }}
"""


def growth(name: str, z: mpmath.mpc) -> mpmath.mpc:
    """R(z) = 1 + z b^T (I - z B)^-1 1, B holding all coefficients of the stages."""
    method = METHODS[name]
    assert isinstance(method, WMethod)
    stages = range(len(method.b))
    rows = [[exactly(method.gamma if i == j else method.a[i][j] + method.g[i][j]) if j <= i else 0 for j in stages]
            for i in stages]  # fmt: skip
    Y = mpmath.lu_solve(mpmath.eye(len(stages)) - z * mpmath.matrix(rows), mpmath.ones(len(stages), 1))
    return 1 + z * sum((exactly(b) * Y[i] for i, b in enumerate(method.b)), mpmath.mpf(0))


def exactly(x: Fraction) -> mpmath.mpf:
    return mpmath.mpf(x.numerator) / x.denominator


@cache
def oscillator_steps(stiffness: float) -> CompiledSteps:
    return compiled(toml.read(OSCILLATOR.format(stiffness=stiffness), "o.toml"), "w2", "w3")


@pytest.mark.sampled(12)
@pytest.mark.parametrize("h", [1e-9, 1e-6, 1e-3, 1.0])
@pytest.mark.parametrize("name", ["w2", "w3"])
def test_steps_of_any_size_are_those_of_the_method(name: str, h: float) -> None:
    """A mass released beside its neutral point, omega = 1000 rad/s: ten steps are R(i omega h)^10, however long.

    A step carries the rounding of k_v = r_v - x, which is eps (omega h)^2 of q; steps that damp leave that of one.
    """
    runner, omega = oscillator_steps(1e6), 1000.0
    motion = PrescribedMotion(10 * h, {}, source="scene.toml")
    reference = reference_of(runner.machine, motion)
    reference.start.q[1] = -0.25 + 0.0625
    found = runner.run(reference, name, 10)
    with mpmath.workdps(50):
        steps = [growth(name, mpmath.mpc(0, mpmath.mpf(h) * 1000)) ** k for k in range(11)]
        q, v = (np.array([float(x) for x in parts]) for parts in zip(*((r.real, -r.imag) for r in steps), strict=True))
    z = omega * h
    allowed = 40 * EPS * (1 + z + z**2)
    np.testing.assert_allclose((found.q[:, 1] + 0.25) / 0.0625, q, rtol=0, atol=allowed)
    np.testing.assert_allclose(found.qd[:, 1] / (0.0625 * omega), v, rtol=0, atol=allowed)


# Massless bodies in series


SERIES = """
name = "series"
gravity = [0, 0, 0]
joints = [
  {{ name = "motor", kind = "motor", sigma = 1, r = "q1" }},
  {{ name = "first", kind = "elastic", sigma = 1, r = "q2" }},
  {{ name = "last", kind = "elastic", sigma = 1, r = "q3" }},
]
[bodies]
motor = {{ mass = 2 }}
last = {{ mass = 3 }}
[springs]
first = {{ stiffness = {first}, damping = 0 }}
last = {{ stiffness = 3e4, damping = 0 }}
"""


def pushed(machine: Machine) -> Reference:
    return reference_of(machine, PrescribedMotion(0.3, {}, (Move("motor", 0.05, 0.0, 0.1),), source="scene.toml"))


def test_massless_bodies_in_series_are_refused() -> None:
    machine = toml.read(SERIES.format(first=6e4), "series.toml")
    with pytest.raises(InputError) as caught:
        simulate(pushed(machine), Request(tolerance={"last.q": 1e-6}))
    assert "first" in str(caught.value) and "last" in str(caught.value) and "\n" not in str(caught.value)


@pytest.mark.thorough
@pytest.mark.parametrize("first", [6e4, 1e12])
def test_condensed_they_move_as_one_spring(first: float) -> None:
    """k1 k2/(k1 + k2) under the inertia force of the motion, against Duhamel's integral by the trapezoidal rule."""
    machine = restrict(toml.read(SERIES.format(first=first), "series.toml"), Scene(condense=True))
    reference = pushed(machine)
    (spring,) = (k for k, joint in enumerate(machine.independent_joints) if joint.spring.stiffness != ZERO)
    found = compiled(machine, "w3").run(reference, "w3", 6000)
    t, times = found.t, math.sqrt(first * 3e4 / (first + 3e4) / 3) * found.t
    parts = np.array([np.cos(times), np.sin(times)]) * reference.at(t)[2][:, 0]
    between = (parts[:, 1:] + parts[:, :-1]) / 2 * t[1]
    cosine, sine = np.concatenate([np.zeros((2, 1)), np.cumsum(between, axis=1)], axis=1)
    wanted = -(np.sin(times) * cosine - np.cos(times) * sine) * t[-1] / times[-1]
    assert np.abs(found.q[:, spring] - wanted).max() < 1e-4 * np.abs(wanted).max()


# Static springs that are softer than their load


@pytest.mark.thorough
@pytest.mark.parametrize(("part", "fits"), [(0.5, False), (5.0, True)])
def test_no_rung_has_a_spring_static_that_its_load_bends_further(part: float, fits: bool) -> None:
    """Half of the stiffness that holds the arm upright: it hangs at the start, and is upright in the middle."""
    machine = toml.read(PENDULUM.replace("400", repr(part * 9.81 * 0.3)), "pendulum.toml")
    motion = PrescribedMotion(0.8, {"motor": -math.pi / 2}, (Move("motor", math.pi, 0.0, 0.6),), source="scene.toml")
    (_, static, *_) = ladder_of_prediction(prediction_of(machine, [motion], {"arm.q": 1e6})).rungs
    assert static.left_out == ("arm",) and not static.locked
    assert (static.chosen is not None) == fits


# Stroke and speed


REFUSED: dict[str, Callable[[], Reference]] = {
    r"motor: its position reaches 1e\+10": lambda: moved(None, by=1e10),
    r"motor: its position reaches 1e\+300": lambda: moved(None, by=1e300, servo=SERVO),
    r"motor: its velocity reaches 1.46e\+09": lambda: moved(None, by=1e8),
    r"motor: its position reaches": lambda: wobbling(1e200),
    r"motor=1e\+300 is out of range": lambda: starting(1e300),
}


def wobbling(amplitude: float) -> Reference:
    motion = PrescribedMotion(0.2, {}, wobbles=(Wobble("motor", amplitude, 30.0),), source="scene.toml")
    return reference_of(carriage(), motion)


def starting(at: float) -> Reference:
    return reference_of(carriage(), PrescribedMotion(0.2, {"motor": at}, source="scene.toml"))


@pytest.mark.parametrize("words", REFUSED)
def test_strokes_and_speeds_without_measure_are_refused_by_name(words: str) -> None:
    with pytest.raises(InputError, match=words) as caught:
        REFUSED[words]()
    assert "\n" not in str(caught.value)


@pytest.mark.thorough
@pytest.mark.parametrize(("by", "servo"), [(1e5, None), (1e6, SERVO), (0.1, Gains(1e300, 1e300))])
@pytest.mark.filterwarnings("ignore::RuntimeWarning")
def test_what_overflows_is_said(by: float, servo: Bandwidth | Gains | None) -> None:
    """Either the motion is finite, or a line says which numbers grow out of range."""
    try:
        found = simulate(moved(None, by=by, servo=servo), Request(tolerance={"arm.q": 1e-5}, method="w3", step=1e-3))
    except InputError as refusal:
        assert "\n" not in str(refusal)
        assert "leaves the valid range" in str(refusal) or "no numbers" in str(refusal) or "too far" in str(refusal)
    else:
        assert np.isfinite(found.outputs).all() and not found.is_within


# Long free motions


def energy(runner: CompiledSteps, q: Array, qd: Array, kp: Array) -> Array:
    """Kinetic, potential and elastic energy, and that of the servo as a spring at 0, J."""
    given = dict(zip((p.name for p in runner.machine.parameters), values(1, 0.0).values(), strict=True))
    model = numpy_model(runner.machine, ("energy",))
    parameters = np.array([given[p.name] for p in runner.machine.parameters])
    return np.asarray(model.energy(q, qd, parameters).sum(axis=1) + kp[0] * q[:, 0] ** 2 / 2)


def swinging(duration: float) -> Reference:
    """The arm lifted by 0.5 rad and let go; the servo is a spring without damping."""
    motion = PrescribedMotion(duration, {}, servo={"motor": Gains(3e4, 0.0)}, source="scene.toml")
    reference = reference_of(carriage(), motion, values(1, 0.0))
    reference.start.q[2] += 0.5
    reference.start.tau[:] = reference.start.torques[:] = 0.0
    return reference


@pytest.mark.parametrize(
    ("method", "step", "steps", "part"),
    [
        ("midpoint", 2e-4, 1_000_000, 2e-5),
        ("rodas4", 2e-4, 10_000, 2e-8),
        ("rk4", 1e-4, 20_000, 3e-8),
    ],
)  # fmt: skip
def test_energy_of_a_free_motion_stays(method: str, step: float, steps: int, part: float) -> None:
    """2500 J, that of the midpoint rule bounded over a million steps: no larger error in the second half."""
    reference, runner = swinging(step * steps), carriage_steps()
    runner.p[:] = list(values(1, 0.0).values())
    found = runner.run(reference, method, steps)
    assert reference.servo is not None
    total = energy(runner, found.q, found.qd, reference.servo[0])
    wrong = np.abs(total - total[0]) / total[0]
    assert wrong.max() < part
    half = len(wrong) // 2
    assert method != "midpoint" or wrong[half:].max() < 1.2 * wrong[:half].max()


# Friction that changes its sign


SLIDE = """
name = "slide"
gravity = [0, 0, 0]
joints = [{ name = "motor", kind = "motor", sigma = 1, r = "q1" }]
[bodies]
motor = { mass = 10 }
[friction]
motor = { coulomb = 5, creep = 1e-4 }
"""


@pytest.mark.thorough
def test_reversals_of_dry_friction_need_no_smaller_steps() -> None:
    """200 steps of 1 ms under a servo, four reversals, 1e-6 m: 2 Fs h^2 / m: the one equation of motion by Radau."""
    machine = toml.read(SLIDE, "slide.toml")
    motion = PrescribedMotion(
        0.2, wobbles=(Wobble("motor", 1e-3, 10.0),), servo={"motor": Gains(4e5, 3e3)}, source="scene.toml"
    )
    reference = reference_of(machine, motion)
    found = compiled(machine, "w3").run(reference, "w3", 200)

    def rate(t: float, y: Array) -> list[float]:
        wanted, moving, _ = (x[0, 0] for x in reference.at(np.array([t])))
        friction = 5 * y[1] / math.hypot(y[1], 1e-4)
        return [y[1], (4e5 * (wanted - y[0]) + 3e3 * (moving - y[1]) - friction) / 10]

    wanted = solve_ivp(rate, (0, 0.2), [0.0, 0.0], "Radau", found.t, rtol=1e-8, atol=1e-11).y[0]
    assert (np.diff(np.sign(found.qd[:, 0])) != 0).sum() >= 4
    assert np.abs(found.q[:, 0] - wanted).max() < 1e-6


# Angles of many revolutions


PENDULUM = """
name = "pendulum"
gravity = [0, -9.81, 0]
joints = [
  { name = "motor", kind = "motor", sigma = 0, theta = "q1" },
  { name = "arm", kind = "elastic", sigma = 0, d = 0.4, theta = "q2" },
]
[bodies]
motor = { mass = 2, center_of_mass = [0.2, 0, 0], inertia = [0.1, 0.1, 0.1] }
arm = { mass = 1, center_of_mass = [0.3, 0, 0], inertia = [0.02, 0.02, 0.02] }
[springs]
arm = { stiffness = 400, damping = 0.1 }
"""


def test_a_million_revolutions_change_a_step_by_the_rounding_of_the_angle() -> None:
    """Deflections of the arm differ by a unit in the last place of the angle, of themselves, or less."""
    machine, turned = toml.read(PENDULUM, "pendulum.toml"), 2 * math.pi * 1e6
    runner = compiled(machine, "w3", "rk4")
    for method in ("w3", "rk4"):
        deflections = []
        for start in (0.3, 0.3 + turned):
            motion = PrescribedMotion(0.4, {"motor": start}, (Move("motor", 0.5, 0.0, 0.3),), source="scene.toml")
            found = runner.run(reference_of(machine, motion), method, 200)
            deflections.append(found.q[:, 1])
        apart = np.abs(deflections[1] - deflections[0]).max()
        assert apart < np.spacing(turned) * np.abs(deflections[0]).max()
