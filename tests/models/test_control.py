"""Sampled controllers as programs: the linear map of `control`, limits, starts, bits of C and numpy, refusals."""

from __future__ import annotations

import ctypes
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from symoro_elastic.analysis.control.cascade import Biquad, biquad_system, cascade_of
from symoro_elastic.analysis.control.sampled import VelocityLaw, by_tustin
from symoro_elastic.codegen.compile import compile_library, load_library
from symoro_elastic.codegen.targets.c import render_c
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.described import DescribedMachine
from symoro_elastic.machine.drives import TUNED, Average, Drive, Drives, LowPass, Notch
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.joints import Joint, Kind
from symoro_elastic.machine.machine import Parameter
from symoro_elastic.machine.scene import Scene
from symoro_elastic.models.packaging import trace_models
from symoro_elastic.numerics.verification.implementations import numpy_model
from tests.generated_code import COMPILERS
from tests.references.controlled import AVERAGED, PLAIN, controlled, drive

MODELS = ("control", "control_start")
f = Formula.parse
PERIOD = 1.25e-4
ROWS = ("measured", "speed", "r", "rd", "rdd", "tau")


class Code:
    """The generated numpy controller of a machine of one motor."""

    def __init__(self, machine: DescribedMachine) -> None:
        self.module = numpy_model(machine, MODELS)
        self.states = len(self.start())

    def __call__(self, zc: Array, **given: float) -> tuple[float, Array]:
        u, later = self.module.control(*([given.get(name, 0.0)] for name in ROWS), zc)
        return float(u[0]), np.asarray(later)

    def start(self, **given: float) -> Array:
        return np.asarray(self.module.control_start(*([given.get(name, 0.0)] for name in ROWS[2:])))

    def responses(self, name: str, count: int) -> Array:
        """What follows in u of 1 in one argument at the first sample."""
        zc, found = self.start(), []
        for k in range(count):
            u, zc = self(zc, **({name: 1.0} if k == 0 else {}))
            found.append(u)
        return np.array(found)


def impulse(A: Array, B: Array, C: Array, D: float, count: int) -> Array:
    found, x = [D], B
    for _ in range(count - 1):
        found.append(float(C @ x))
        x = A @ x
    return np.array(found)


def linear(**changes: Any) -> Drive:
    return drive(torque_limit=None, windup=None, **changes)


@pytest.mark.parametrize("one", [linear(), linear(Tn=None), PLAIN])
def test_its_linear_map_is_that_of_control(one: Drive) -> None:
    """Markov parameters from velocity and position to torque: those of backward Euler and Tustin by matrices."""
    code, cascade = Code(controlled(motor=one)), cascade_of(Joint("motor", 0, Kind.MOTOR, 0, "q1"), one, {}, "file")
    law = VelocityLaw.of(cascade, PERIOD, "file").law
    expected = impulse(law.A, law.B, law.C, law.D, 60)
    size = np.abs(expected).max()
    for name, factor in (("speed", -1.0), ("measured", -60.0)):
        assert np.abs(code.responses(name, 60) - factor * expected).max() <= 1e-12 * abs(factor) * size


def test_set_points_pass_their_filter_and_feed_forward_the_filters_of_the_torque() -> None:
    """F, then kfv and kfa, by systems in states of their own."""
    one = linear()
    code, cascade = Code(controlled(motor=one)), cascade_of(Joint("motor", 0, Kind.MOTOR, 0, "q1"), one, {}, "file")
    law = VelocityLaw.of(cascade, PERIOD, "file").law
    assert isinstance(cascade.set_point, Biquad)
    before = by_tustin(biquad_system(cascade.set_point), cascade.set_point.w, PERIOD)
    filtered = impulse(before.A, before.B, before.C, before.D, 60)
    of_error = impulse(law.A, law.B, law.C, law.D, 60)
    of_torque = code.responses("tau", 60)
    for name, expected in (("r", 60 * of_error), ("rd", 0.9 * of_error), ("rdd", 8e-3 * of_torque)):
        whole = np.convolve(filtered, expected)[:60]
        assert np.abs(code.responses(name, 60) - whole).max() <= 1e-12 * np.abs(whole).max(), name


def test_a_moving_average_is_that_of_the_last_samples() -> None:
    code = Code(controlled(motor=replace(AVERAGED, torque_limit=None, Tn=None)))
    u, zc = [], code.start()
    for k in range(9):
        force, zc = code(zc, r=float(k**2))
        u.append(force)
    means = [sum(max(i, 0) ** 2 for i in range(k - 3, k + 1)) / 4 for k in range(9)]
    assert np.allclose(u, [3.0 * 60 * mean for mean in means], rtol=1e-14)


@pytest.mark.parametrize("one", [drive(), AVERAGED, PLAIN, drive(Tn=None, windup=None)])
def test_it_starts_at_rest_with_the_torque_that_holds(one: Drive) -> None:
    code = Code(controlled(motor=one))
    at = {"r": 0.7, "rd": 0.2, "tau": -4.5}
    zc = first = code.start(**at)
    for _ in range(50):
        u, zc = code(zc, measured=0.7, speed=0.2 * one.velocity_forward.value({}), **at)
        assert u == pytest.approx(-4.5, rel=1e-12)
    assert np.allclose(zc, first, rtol=1e-12, atol=1e-15)


def test_limits_are_exact_and_the_integral_part_gives_way() -> None:
    """Against the law written out; within the limit the bits are those without one."""
    one = drive(filters=(), set_point=None, acceleration_forward=f(0))
    limited = Code(controlled(motor=one))
    free = Code(controlled(motor=replace(one, torque_limit=None, windup=None)))
    rng, xi, zc = np.random.default_rng(5), 0.0, limited.start()
    reached = set()
    for k in range(2000):
        speed = float(8 * np.sin(k / 150) + rng.normal())
        u, later = limited(zc, speed=speed)
        unlimited, same = free(zc, speed=speed)
        e = -speed
        xi = float(zc[0]) + PERIOD * e
        wanted = 3.0 * (e + xi / 5e-3)
        assert u == float(np.clip(unlimited, -15, 15))
        assert u == pytest.approx(np.clip(wanted, -15, 15), rel=1e-13)
        assert later[0] == pytest.approx(xi + PERIOD * (u - wanted) * 5e-3 / (3.0 * 8e-3), rel=1e-11, abs=1e-15)
        if abs(unlimited) < 15:
            assert later[0] == same[0]
        reached.add(np.sign(u) * (abs(u) == 15))
        zc = later
    assert reached == {-1, 0, 1}


@pytest.mark.thorough
def test_after_a_long_time_at_the_limit_it_comes_back_at_once() -> None:
    """The integral part is that at which the torque is at its limit plus what the error asks for beyond it, over Tt."""
    one = drive(filters=(), set_point=None, acceleration_forward=f(0))
    code, winding = Code(controlled(motor=one)), Code(controlled(motor=replace(one, windup=f(1e3))))
    zc, wound = code.start(), winding.start()
    for _ in range(4000):
        _, zc = code(zc, speed=-10.0)
        _, wound = winding(wound, speed=-10.0)
    assert back(code, zc) < 100 < back(winding, wound)


def back(code: Code, zc: Array) -> int:
    """The samples at a limit after the error has changed its sign."""
    for k in range(20000):
        u, zc = code(zc, speed=2.0)
        if u < 15:
            return k
    return 20000


# Bits


def compiled(machine: DescribedMachine, folder: Path) -> Any:
    package = trace_models(machine, Scene(models=MODELS)).package
    return load_library(compile_library(render_c(package), folder)), package


def pointer(x: Array) -> ctypes.c_void_p:
    return ctypes.c_void_p(x.ctypes.data)


@pytest.mark.sampled(5)
@pytest.mark.skipif(not COMPILERS, reason="needs a C compiler")
@pytest.mark.parametrize("one", [drive(), AVERAGED, PLAIN])
def test_c_has_the_bits_of_numpy_with_its_states_in_place(one: Drive, tmp_path: Path) -> None:
    machine = controlled(motor=one)
    (library, package), code = compiled(machine, tmp_path), Code(machine)
    p = np.array([x.value for x in package.parameters])
    rng, zc = np.random.default_rng(6), code.start(r=0.3, tau=2.0)
    own = zc.copy()
    for k in range(3000):
        given = dict(zip(ROWS, rng.normal(size=6) * (1, 5, 1, 5, 100, 10), strict=True))
        u, zc = code(zc, **given)
        found = np.empty(1)
        arrays = [np.array([given[name]]) for name in ROWS]
        library.ball_screw_control(*map(pointer, arrays), pointer(own), pointer(p), pointer(found), pointer(own))
        assert found[0] == u and np.array_equal(own, zc), k


def test_gains_may_be_parameters() -> None:
    """As numbers, with rounding; a parameter is read at each call."""
    one = drive(Kp=3.0, filters=(Notch(f("F"), f(0.1), f(0.5)),), period=f("T"), torque_limit=f("M"))
    machine = controlled(motor=one)
    values = {"F": 1300.0, "T": PERIOD, "M": 15.0}
    named = replace(machine, parameters=(*machine.parameters, *(Parameter(n, f(x)) for n, x in values.items())))
    by_name, by_number = Code(named), Code(controlled(motor=drive(filters=one.filters[:0] + drive().filters[:1])))
    zc = same = by_name.start()
    for k in range(300):
        u, zc = by_name(zc, r=0.1 * np.sin(k / 50))
        v, same = by_number(same, r=0.1 * np.sin(k / 50))
        assert u == pytest.approx(v, rel=1e-11, abs=1e-12)
    wide = by_name.module.parameters(M=2.0)
    assert by_name.module.control([0.0], [-50.0], [0.0], [0.0], [0.0], [0.0], by_name.start(), p=wide)[0][0] == 2.0


def test_it_takes_the_operations_that_the_page_says() -> None:
    """With a notch, a low-pass filter, a filter of order 2 for the set point, and a limit."""
    one = drive(filters=drive().filters[:2], velocity_forward=f(1), acceleration_forward=f(0), windup=None)
    (traced, _) = trace_models(controlled(motor=one), Scene(models=("control",))).models
    assert (traced.program.count.mul, traced.program.count.add, traced.program.count.div) == (19, 22, 0)


def test_each_motor_has_states_of_its_own() -> None:
    one, other = drive(3e4, lag=f(0)), replace(PLAIN, Kp=f(5e4))
    module = numpy_model(controlled("two_axis", motor_x=one, motor_y=other), MODELS)
    zeros, zc = np.zeros(2), np.zeros(len(module.control_start(*np.zeros((4, 2)))))
    speeds = np.array([0.0, 1e-5])
    u, later = module.control(zeros, speeds, zeros, zeros, zeros, zeros, zc)
    assert u[0] == 0 and u[1] == pytest.approx(-0.5) and not later.any()


@pytest.mark.parametrize(
    ("one", "place", "what"),
    [
        (drive(period=None), "drives, motor, period", "is missing: a controller is code that is called once"),
        (replace(drive(), Kp=TUNED), "drives, motor, Kp", 'is "tuned", which is no number: symoro-elastic tune'),
        (
            drive(filters=(LowPass(f(4000)),)),
            "filter 1, frequency",
            "4000 Hz is not below half the sampling rate, 4000",
        ),
        (drive(windup=f(1e-5)), "limits, windup", "1e-05 s is below the period, 0.000125 s"),
        (drive(set_point=Average(f(3e-4))), "set_point, average", "no whole number of periods of 0.000125 s"),
    ],
)
def test_what_is_no_code_is_refused(one: Drive, place: str, what: str) -> None:
    with pytest.raises(InputError) as error:
        trace_models(controlled(motor=one), Scene(models=("control",)))
    assert place in error.value.place and what in str(error.value)


def test_all_motors_have_one_period() -> None:
    two = {"motor_x": PLAIN, "motor_y": replace(PLAIN, period=f(2.5e-4))}
    for drives, what in ((two, "sampled drives have one period"), ({"motor_x": PLAIN}, "motor_y: is missing")):
        machine = replace(controlled("two_axis"), drives=Drives(drives))
        with pytest.raises(InputError, match=what):
            trace_models(machine, Scene(models=("control",)))


def test_clamps_are_exact() -> None:
    """At the limit, at zero and just beside them; of expressions and of numbers."""
    from symoro_elastic.symbolic.arithmetic import FLOATS, evaluate
    from symoro_elastic.symbolic.expression import Graph
    from symoro_elastic.symbolic.functions import clamp

    graph = Graph()
    x = graph.symbol("x")
    root = clamp(graph, x, -graph.symbol("L"), graph.symbol("L"))
    points = [0.0, -0.0, 1e-300, 0.1, 1 / 3, np.nextafter(0.7, 0), 0.7, np.nextafter(0.7, 1), 1e300]
    for one, other in pairwise(sorted([*points, *(-p for p in points)])):
        for at in (one, other):
            value = evaluate([root], {"x": at, "L": 0.7}, FLOATS)(root)
            assert value == min(max(at, -0.7), 0.7)
