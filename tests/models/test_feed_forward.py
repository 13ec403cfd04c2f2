"""Feed-forward through springs: its motion put back into all equations of motion, in many digits and as code."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mpmath import mp, mpf, workdps

from symoro_elastic.codegen.latex import solution
from symoro_elastic.formats import read_machine
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.foundation.output_files import write_files
from symoro_elastic.generation.pipeline import generate, programs, render
from symoro_elastic.machine.formula import ZERO
from symoro_elastic.machine.machine import Base, Body, Friction, Joint, Kind, Machine, Parameter, Spring
from symoro_elastic.machine.restrict import restrict
from symoro_elastic.machine.scene import Scene
from symoro_elastic.models.programs.catalogue import TracedModel, trace, trace_scene
from symoro_elastic.numerics.evaluation.values import parameter_values
from symoro_elastic.pages.equations.page import html_page
from symoro_elastic.symbolic.arithmetic import RATIONAL, Arithmetic, evaluate
from symoro_elastic.symbolic.expression import Graph
from symoro_elastic.symbolic.operations import ATAN2, COS, COSPI, PI, SIGN, SIN, SQRT
from symoro_elastic.symbolic.time_series import TimeSeries
from tests.compiled_models import cell
from tests.generated_code import COMPILERS, call, compiled, imported
from tests.references.multiprecision import generalized_forces
from tests.references.random_machines import WEIGHT, chain, first_joint_elastic, random_machine

pytestmark = pytest.mark.sampled(5)

EXAMPLES = Path(__file__).parents[2] / "examples"
FLEX4, TWO_AXIS = EXAMPLES / "flex4.par", EXAMPLES / "two_axis.toml"
DIGITS, STEP, EXACT, ROUNDED = 120, "1e-24", 1e-40, 1e-14
AT = "0.37"

Motion = Callable[[int, Any], list[Any]]
"""Derivative k of the outboard coordinates at a time."""


def number(x: Any) -> Any:
    return mpf(Fraction(x).numerator) / Fraction(x).denominator


MANY_DIGITS = Arithmetic(
    number,
    {
        **RATIONAL,
        SIN: mp.sin,
        COS: mp.cos,
        SQRT: mp.sqrt,
        ATAN2: mp.atan2,
        SIGN: mp.sign,
        PI: lambda: +mp.pi,
        COSPI: mp.cospi,
    },
)
EXACTLY = Arithmetic(Fraction, RATIONAL)


def swinging(motors: int) -> Motion:
    """Coordinate j is c_j sin(w_j t + p_j)."""

    def motion(k: int, t: Any) -> list[Any]:
        rates = [mpf(7 + 3 * j) / 10 for j in range(motors)]
        return [(mpf(5) - j) / 8 * w**k * mp.sin(w * t + j + k * mp.pi / 2) for j, w in enumerate(rates)]

    return motion


def results(traced: TracedModel, motion: Motion, t: Any, values: Mapping[str, Any]) -> dict[str, list[Any]]:
    """Results of a feed-forward along a motion, in many digits."""
    symbols = {name: number(x) for name, x in values.items()}
    for k, argument in enumerate(traced.program.inputs):
        symbols |= zip(argument.symbols, motion(k, t), strict=True)
    value = evaluate([x for o in traced.program.outputs for x in o.entries], symbols, MANY_DIGITS)
    return {o.name: [value(x) for x in o.entries] for o in traced.program.outputs}


def worst_residual(machine: Machine) -> tuple[float, int]:
    """How far the equations of motion are from being met, relative, and the derivatives that were needed.

    q is differentiated along the motion by differences, and all torques come from another method.
    """
    values, traced = parameter_values(machine, 3), trace(machine, "feed_forward")
    motors = [j for j in machine.independent if machine.joints[j - 1].kind is Kind.MOTOR]
    with workdps(DIGITS):
        t, h = mpf(AT), mpf(STEP)
        before, now, after = (results(traced, swinging(len(motors)), at, values) for at in (t - h, t, t + h))
        qd = [(a - b) / (2 * h) for a, b in zip(after["q"], before["q"], strict=True)]
        qdd = [(a - 2 * x + b) / (h * h) for a, x, b in zip(after["q"], now["q"], before["q"], strict=True)]
        asked = generalized_forces(machine, now["q"], now["qd"], qdd, {n: number(x) for n, x in values.items()})
        tau = iter(now["tau"])
        given = [
            next(tau) if j in motors else spring_torque(machine.joints[j - 1], q, values)
            for j, q in zip(machine.independent, now["q"], strict=True)
        ]
        scale = max(1, *map(abs, asked))
        off = [abs(a - b) / scale for a, b in zip(asked, given, strict=True)]
        off += [abs(a - b) for a, b in zip(qd, now["qd"], strict=True)]
        return float(max(off)), len(traced.program.inputs) - 1


def spring_torque(joint: Joint, q: Any, values: Mapping[str, float]) -> Any:
    stiffness, neutral = (
        formula.evaluate({name: number(x) for name, x in values.items()}, {}, number)
        for formula in (joint.spring.stiffness, joint.spring.neutral)
    )
    return -stiffness * (q - neutral)


# Machines


def with_springs(machine: Machine, rows: Sequence[int], seed: int) -> Machine:
    """The machine with a spring and one more body behind each of these motors, two behind the last of them.

    Axes point in either sense; a fixed frame with a body of its own may lie between; what hung on the body of a
    motor may stay there.
    """
    rng = np.random.default_rng(seed)
    body = random_machine(seed, joints=1, kinds=[Kind.MOTOR]).joints[0].body
    table: list[Joint] = []
    place = {0: 0}  # where what hung on an old row hangs now
    for j, joint in enumerate(machine.joints, start=1):
        table.append(replace(joint, antecedent=place[joint.antecedent]))
        place[j] = len(table)
        if j not in rows:
            continue
        if rng.random() < 0.4:
            frame = Joint(f"between{j}", len(table), Kind.FIXED, 2, alpha=cell("pi"), r=cell("0.07"), body=body)
            table.append(frame)
        for _ in range(2 if j == rows[-1] else 1):
            table.append(replace(spring(rng, len(table), joint.sigma), body=body))
        if rng.random() < 0.7:
            place[j] = len(table)
    return replace(machine, joints=tuple(table))


def spring(rng: np.random.Generator, antecedent: int, sigma: int) -> Joint:
    """On the axis of its antecedent, which it may shift and turn about."""
    law = Spring(cell(round(rng.uniform(50, 2000), 1)), neutral=cell(round(rng.uniform(-0.3, 0.3), 2)))
    cells = {"gamma": "0.4", "b": "0.1", "alpha": str(rng.choice(["0", "pi"])), "theta": "0.3", "r": "-0.15"}
    cells |= {"d": "0.2"} if sigma else {}
    table = {key: cell(x) for key, x in cells.items()}
    return Joint(f"spring{antecedent}", antecedent, Kind.ELASTIC, sigma, f"e{antecedent}", spring=law, **table)


def drive(sigma: int, springs: int, *, inertia: bool = True) -> Machine:
    """A motor and springs in a row along z, gravity along it; the last body is heavy."""
    body = Body(cell("M"), inertia=(*[ZERO] * 5, cell("J"))) if inertia else Body()
    motor = Joint("motor", 0, Kind.MOTOR, sigma, "x", body=body, rotor_inertia=cell("Ia"))
    rows = [
        Joint(
            f"spring{i}",
            i,
            Kind.ELASTIC,
            sigma,
            f"x{i}",
            body=Body(cell(f"m{i}"), inertia=(*[ZERO] * 5, cell(f"i{i}"))),
            spring=Spring(cell(f"k{i}"), neutral=cell("0.01")),
        )
        for i in range(1, springs + 1)
    ]
    names = ["Ia", "M", "J", *(f"{letter}{i}" for i in range(1, springs + 1) for letter in "mik")]
    used = [name for name in names if inertia or name not in "MJ"]
    return Machine("drive", (motor, *rows), tuple(Parameter(name) for name in used), WEIGHT)


# What is computed


def exactly(machine: Machine, symbols: Mapping[str, Fraction]) -> dict[str, list[Fraction]]:
    traced = trace(machine, "feed_forward")
    value = evaluate([x for o in traced.program.outputs for x in o.entries], symbols, EXACTLY)
    return {o.name: [value(x) for x in o.entries] for o in traced.program.outputs}


@pytest.mark.parametrize("sigma", [0, 1])
def test_two_masses_and_a_spring(sigma: int) -> None:
    """k (y - q_m - q0) = -m (ydd + g) and Gamma = (M + Ia) qdd_m + M g + m (ydd + g), in fractions."""
    Ia, M, J, m, i, k, *y = map(Fraction, ("2/7", "3", "5", "11/3", "13/5", "170", "0.3", "-1.5", "0.7", "2.2", "-9.1"))
    g = Fraction("9.81") if sigma else 0
    inner, outer = (M, m) if sigma else (J, i)
    found = exactly(
        drive(sigma, 1), {"Ia": Ia, "M": M, "J": J, "m1": m, "i1": i, "k1": k} | {f"y1_{n}": x for n, x in enumerate(y)}
    )
    deflection = Fraction("0.01") - outer * (y[2] + g) / k
    rate = -outer * y[3] / k
    assert found["q"] == [y[0] - deflection, deflection]
    assert found["qd"] == [y[1] - rate, rate]
    qdd_motor = y[2] + outer * y[4] / k
    assert found["tau"] == [(inner + Ia) * qdd_motor + inner * g + outer * (y[2] + g)]


@pytest.mark.parametrize(("springs", "order"), [(0, 2), (1, 4), (2, 6), (3, 8)])
def test_each_spring_asks_for_two_more_derivatives(springs: int, order: int) -> None:
    for sigma in (0, 1):
        residual, needed = worst_residual(drive(sigma, springs))
        assert residual < EXACT and needed == order


def test_a_motor_without_inertia_needs_less() -> None:
    """Its velocity is a result, its acceleration is not needed."""
    machine = drive(1, 1, inertia=False)
    weightless = replace(machine, joints=(replace(machine.joints[0], rotor_inertia=ZERO), machine.joints[1]))
    residual, needed = worst_residual(weightless)
    assert residual < EXACT and needed == 3


def test_flex4() -> None:
    """Body 3 is carried by spring 2, so that the acceleration of motor 3 bends it: six derivatives."""
    residual, needed = worst_residual(read_machine(FLEX4)[0])
    assert residual < EXACT and needed == 6


def test_virtual_bodies_need_four_derivatives() -> None:
    """Nothing but rotors between motors and springs: order 4, however long the chain."""
    flex4 = read_machine(FLEX4)[0]
    rows = [replace(joint, body=Body()) if joint.kind is Kind.MOTOR else joint for joint in flex4.joints]
    residual, needed = worst_residual(replace(flex4, joints=tuple(rows)))
    assert residual < EXACT and needed == 4


@pytest.mark.sampled(6)
@pytest.mark.parametrize("seed", range(12))
def test_all_equations_of_motion_are_met(seed: int) -> None:
    """Trees with springs behind some motors: slides, turns, both senses, friction, wrenches, fixed frames."""
    kinds = (Kind.MOTOR, Kind.FIXED) if seed % 2 else (Kind.MOTOR,)
    rigid = random_machine(seed, joints=2 + seed % 4, kinds=kinds, branching=0.3, prismatic=0.4, symbolic=seed % 3 == 0)
    motors = [j for j in rigid.independent if (j + seed) % 3]
    machine = with_springs(rigid, motors, seed)
    residual, needed = worst_residual(machine)
    assert residual < EXACT
    assert needed >= (3 if motors else 2)


def test_the_two_axis_machine_with_locked_supports(tmp_path: Path) -> None:
    """It has no feed-forward as a whole, so there is nothing to compare the operations with."""
    machine, _ = read_machine(TWO_AXIS)
    free = ("motor_x", "motor_y", "y_chain_1", "ram", "tool")
    locked = {joint.name: ZERO for joint in machine.joints if joint.name not in free}
    scene = Scene(models=("feed_forward",), locked=locked)
    residual, needed = worst_residual(restrict(machine, scene))
    assert residual < EXACT and needed == 6
    made = generate(machine, scene, ("numpy",), tmp_path)
    assert made.whole == made.models
    with pytest.raises(InputError, match=r"joint 1 \(bed_yaw\), kind: feed_forward: .*lock it in a scene"):
        generate(machine, Scene(models=scene.models), ("numpy",), tmp_path)


def test_without_springs_it_is_the_inverse_model() -> None:
    machine = chain(3, symbolic=False)
    forward, inverse = trace(machine, "feed_forward").program, trace(machine, "inverse_dynamics").program
    assert [a.name for a in forward.inputs] == ["y", "yd", "ydd"]
    assert forward.count == inverse.count


# Code


def floats(machine: Machine) -> tuple[list[Any], list[list[Any]]]:
    """Arguments in double precision, and what they give in many digits."""
    traced, values = trace(machine, "feed_forward"), parameter_values(machine, 3)
    motors = sum(joint.kind is Kind.MOTOR for joint in machine.joints)
    with workdps(DIGITS):
        rounded = [list(map(float, swinging(motors)(k, mpf(AT)))) for k in range(len(traced.program.inputs))]
        found = results(traced, lambda k, _: [mpf(x) for x in rounded[k]], 0, values)
    return [np.array(x) for x in rounded], list(found.values())


@pytest.mark.sampled(2)
@pytest.mark.parametrize("compiler", COMPILERS)
def test_generated_code(compiler: str, tmp_path: Path) -> None:
    machine = read_machine(FLEX4)[0]
    values, (arguments, wanted) = parameter_values(machine, 3), floats(machine)
    files = render(programs(machine, Scene(models=("feed_forward",))).package, ("numpy", "c"), "")
    write_files(tmp_path / "flex4", files)
    module = imported(tmp_path / "flex4")
    p = module.parameters(**values)
    library = compiled(tmp_path / "flex4", tmp_path, compiler)
    ways = [
        call(library, "flex4", "feed_forward", arguments, p, [(2,), (4,), (4,)]),
        module.feed_forward(*arguments, p),
    ]
    for found in ways:
        for got, right in zip(found, wanted, strict=True):
            exact = np.array([float(x) for x in right])
            assert np.allclose(got, exact, rtol=0, atol=ROUNDED * abs(exact).max())
    with pytest.raises(TypeError, match="missing 2 required positional arguments: 'yddddd' and 'ydddddd'"):
        module.feed_forward(*arguments[:5], p=p)


def test_equations_in_latex() -> None:
    package = programs(read_machine(FLEX4)[0], Scene(models=("feed_forward",))).package
    solved = solution(package, package.functions[0])
    left = [x.left for stretch in (*solved.once, *solved.steps) for x in stretch.equations]
    assert left and not [x for x in left if x.startswith(r"\mathit{rate")]
    assert "y" in html_page(package, package.functions[0])


# Refusals


def changed(machine: Machine, j: int, **cells: Any) -> Machine:
    rows = list(machine.joints)
    rows[j - 1] = replace(rows[j - 1], **cells)
    return replace(machine, joints=tuple(rows))


def refusals() -> list[tuple[str, Machine, str]]:
    one, flex4 = drive(0, 1), read_machine(FLEX4)[0]
    spring = one.joints[1].spring
    return [
        (
            "damped",
            changed(one, 2, spring=replace(spring, damping=cell("k1"))),
            r"joint 2 \(spring1\), damping: .*make it 0",
        ),
        ("friction", changed(one, 2, friction=Friction(coulomb=cell("1"))), r"joint 2 .*coulomb friction: .*make it 0"),
        ("rotor", changed(one, 2, rotor_inertia=cell("1")), r"joint 2 .*rotor_inertia: "),
        ("loose", changed(one, 2, spring=replace(spring, stiffness=ZERO)), r"joint 2 .*stiffness: "),
        ("passive", changed(one, 2, kind=Kind.PASSIVE, spring=Spring()), r"joint 2 .*kind: .*nothing drives it"),
        ("parallel", changed(flex4, 4, d=cell("0.1")), r"joint 4 .*vibrates by itself"),
        ("bending", changed(flex4, 4, alpha=cell("pi/2")), r"joint 4 .*lock it in a scene"),
        ("first", first_joint_elastic(3), r"joint 1 .*vibrates by itself"),
        ("no motor", changed(drive(1, 0), 1, kind=Kind.PASSIVE), "no joint has a motor"),
        ("moved", replace(one, base=Base(angular_velocity=(ZERO, ZERO, cell("1")))), "base: .*base at rest"),
        ("long", drive(1, 6), r"joint 7 .*14 derivatives of its motion are needed, at most 12"),
    ]


@pytest.mark.parametrize(("machine", "message"), [x[1:] for x in refusals()], ids=[x[0] for x in refusals()])
def test_refusals(machine: Machine, message: str) -> None:
    with pytest.raises(InputError, match=message) as refused:
        trace_scene(machine, Scene(models=("feed_forward",)))
    assert "\n" not in str(refused.value) and "feed_forward" in str(refused.value)


def test_two_springs_behind_one_motor() -> None:
    """Side by side, neither tells what the motor must do."""
    one = drive(1, 1)
    twin = replace(one.joints[1], name="twin", variable="twin")
    with pytest.raises(InputError, match=r"joint 2 .*not the single spring"):
        trace(replace(one, joints=(*one.joints, twin)), "feed_forward")


# Time series


def test_time_series() -> None:
    """Every operation, by mpmath's Taylor coefficients."""
    graph = Graph()
    x, y = graph.symbol("x"), graph.symbol("y")
    root = graph.node(SQRT, x * x + 2)
    made = (graph.node(COS, 2 * x) - x / root) * graph.node(SIN, -y * y) + 1 / (y - root) - 3 * y * graph.node(SIGN, x)
    made = made + graph.node(ATAN2, y - 2, x * y)
    with workdps(50):
        series = TimeSeries({"x": lambda k: graph.symbol(f"x{k}"), "y": lambda k: graph.symbol(f"y{k}")})
        found = series.of(made, 5)
        xs, ys = mp.taylor(mp.exp, mpf("0.2"), 5), mp.taylor(mp.atan, mpf("0.3"), 5)
        symbols = {f"x{k}": c for k, c in enumerate(xs)} | {f"y{k}": c for k, c in enumerate(ys)}
        value = evaluate(found, symbols, MANY_DIGITS)

        def function(t: Any) -> Any:
            x, y = mp.exp(t + mpf("0.2")), mp.atan(t + mpf("0.3"))
            root = mp.sqrt(x * x + 2)
            made = (mp.cos(2 * x) - x / root) * mp.sin(-y * y) + 1 / (y - root) - 3 * y * mp.sign(x)
            return made + mp.atan2(y - 2, x * y)

        for got, wanted in zip(found, mp.taylor(function, 0, 5), strict=True):
            assert abs(value(got) - wanted) < mpf("1e-25")
