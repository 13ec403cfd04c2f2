"""Bounds of largest values: never exceeded by dense search and climbing, and close to what these find."""

from __future__ import annotations

import itertools
import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from symoro_elastic.generation.pipeline import prepare, programs
from symoro_elastic.machine.limits import Range
from symoro_elastic.machine.scene import Scene
from symoro_elastic.numerics.evaluation.arrays import values_along
from symoro_elastic.numerics.guarantees import largest_value as surface_module
from symoro_elastic.numerics.guarantees.box import Box
from symoro_elastic.numerics.guarantees.largest_value import CLOSENESS, Largest, largest, surface
from symoro_elastic.symbolic.expression import Graph, Operand
from symoro_elastic.symbolic.operations import COS, SIN
from symoro_elastic.symbolic.program import Program
from tests.command_line import EXAMPLES
from tests.numerics.guarantees.attacked import Array, box_of, worst_found

FLEXIBLE = 1.0001
"""Climbing stops this close to a largest value."""
PI = math.pi


def attack(target: Operand, box: Box, samples: int = 20_000) -> float:
    """The largest |f| found, by the expression itself."""
    names = list(box.ranges)

    def f(states: Array) -> Array:
        return values_along([target], dict(zip(names, states, strict=True)), states.shape[1])[0]

    return worst_found(f, box, samples, 0)


def assert_proven(found: Largest, attacked: float, closeness: float = CLOSENESS) -> None:
    """The bound is above what was found by whomever, and close to it."""
    assert found.reason == ""
    assert max(attacked, found.found) <= found.bound * (1 + 1e-12)
    assert found.finished
    assert found.bound <= closeness * FLEXIBLE * max(attacked, found.found) * 1.01


@st.composite
def polynomials(draw: st.DrawFn) -> tuple[Operand, Box]:
    """A random polynomial of two angles, a slide, two velocities and an acceleration, and a box."""
    graph = Graph()
    q1, q2, x, v1, v2, a = map(graph.symbol, ("q1", "q2", "x", "v1", "v2", "a"))
    numbers = st.integers(-9, 9)
    waves = [
        graph.node(name, k * q1 + m * q2)
        for name in (SIN, COS)
        for k, m in itertools.product((0, 1, 2), (-1, 0, 1))
        if k or m
    ]
    motions = (1, a, v1 * v1, v1 * v2, v2 * v2, v2, x, x * x, a * x)
    f: Operand = 0
    for _ in range(draw(st.integers(1, 5))):
        term = draw(numbers) * draw(st.sampled_from([1, *waves])) * draw(st.sampled_from(motions))
        f = f + term
    ends = st.tuples(st.floats(-4, 4), st.floats(0.01, 4)).map(lambda x: Range(x[0], x[0] + x[1]))
    box = {name: draw(ends) for name in ("q1", "q2", "x", "v1", "v2", "a")}
    if draw(st.booleans()):
        box["q1"] = Range(-PI, PI)
    return f, Box(box)


@pytest.mark.thorough
@settings(max_examples=30, deadline=None)
@given(polynomials())
def test_random_polynomials(drawn: tuple[Operand, Box]) -> None:
    f, box = drawn
    if isinstance(f, int):
        return
    for positions in ({"x"}, set()):
        found = largest(f, Box(box.ranges, frozenset(positions)))
        attacked = attack(f, box, 4000)
        assert attacked <= found.bound * (1 + 1e-12) and found.finished
        assert found.found <= found.bound * (1 + 1e-12)
        for name, value in found.state.items():
            assert box.ranges[name].low - 1e-12 <= value <= box.ranges[name].high + 1e-12


def test_a_wave_is_bounded_to_the_factor() -> None:
    graph = Graph()
    q = graph.symbol("q")
    f = 3 * graph.node(SIN, 2 * q) + graph.node(COS, q)
    for ends in ((-PI, PI), (-1.0, 1.0), (0.3, 0.31)):
        box = box_of(q=ends)
        assert_proven(largest(f, box, closeness=1.001), attack(f, box), 1.001)


def test_slides() -> None:
    """x^3 - x over a stroke, against its largest value there."""
    graph = Graph()
    x = graph.symbol("x")
    f = x * x * x - x
    found = largest(f, box_of("x", x=(-1, 0.5)), closeness=1.001)
    assert found.bound == pytest.approx(2 / (3 * math.sqrt(3)), rel=2e-3)
    assert found.bound >= 2 / (3 * math.sqrt(3))
    assert found.state["x"] == pytest.approx(-1 / math.sqrt(3), abs=0.05)


def test_signs_of_velocities_are_exact() -> None:
    """The largest value of a b + b c + c d - d a is 2; the sum of magnitudes is 4. Squares count with their sign."""
    graph = Graph()
    a, b, c, d = (graph.symbol(name) for name in "abcd")
    box = box_of(a=(-1, 1), b=(-1, 1), c=(-1, 1), d=(-1, 1))
    found = largest(a * b + b * c + c * d - d * a, box)
    assert found.found == 2.0 <= found.bound <= 2.0001
    found = largest(a * a - b * b, box)
    assert 1.0 <= found.bound <= 1.0001


def test_velocities_that_are_not_symmetric() -> None:
    graph = Graph()
    v = graph.symbol("v")
    found = largest(v * v - 2 * v, box_of(v=(1, 4)))
    assert found.found == 8.0
    assert 8.0 <= found.bound <= 8.0001


def test_difference_of_two_programs() -> None:
    """The same graph or two: f_S - f, small beside both."""
    one, other = Graph(), Graph()
    f, g = ((5 + graph.node(SIN, graph.symbol("q"))) * graph.symbol("v") for graph in (one, other))
    reduced = g - other.node(COS, other.symbol("q")) / 1024
    found = largest((reduced, f), box_of(q=(-PI, PI), v=(-2, 2)))
    assert 1 / 1024 <= found.bound <= CLOSENESS / 1024 * (1 + 1e-4)
    assert found.found == pytest.approx(1 / 1024, rel=0.05)
    assert largest((f, f), box_of(q=(-PI, PI), v=(-2, 2))).bound < 1e-9


def test_refusals() -> None:
    graph = Graph()
    q, x = graph.symbol("q"), graph.symbol("x")
    found = largest(x / graph.node(COS, q), box_of(q=(-1, 1), x=(-1, 1)))
    assert (found.bound, found.finished) == (math.inf, False)
    assert found.reason == "a quotient by what depends on q"
    assert largest(q + x, box_of(q=(-1, 1))).reason == "the box has no range for x"


def test_numbers_are_no_variables() -> None:
    graph = Graph()
    q, x = graph.symbol("q"), graph.symbol("x")
    found = largest(graph.node(SIN, q) / x, box_of(q=(-PI, PI), x=(4, 4)))
    assert 0.25 <= found.bound <= 0.25 * CLOSENESS
    assert largest(7, box_of()).bound == pytest.approx(7)


def inverse(name: str) -> Program:
    """The inverse model of an example, with numbers."""
    machine = prepare(EXAMPLES / name, lambda line: None, base=True)
    return programs(machine, Scene(models=("inverse_dynamics",), fold="all")).models[0].program


def box_in(program: Program, **half: float) -> Box:
    """A box with these half widths, by argument."""
    ranges = {s: Range(-half[x.name], half[x.name]) for x in program.inputs for s in x.symbols}
    return Box(ranges, frozenset(program.inputs[0].symbols))


@pytest.mark.sampled(2)
@pytest.mark.parametrize("half", [PI, 0.5])
def test_torques_of_planar_2r(half: float) -> None:
    program = inverse("planar_2r.toml")
    box = box_in(program, q=half, qd=2.0, qdd_motor=5.0)
    for f in program.outputs[0].entries:
        assert_proven(largest(f, box), attack(f, box))


@pytest.mark.thorough
@pytest.mark.parametrize(("half", "v", "a"), [(PI, 2.0, 5.0), (0.5, 1.0, 2.5)])
def test_torques_of_the_puma(half: float, v: float, a: float) -> None:
    program = inverse("puma560_measured.toml")
    box = box_in(program, q=half, qd=v, qdd_motor=a)
    entries = program.outputs[0].entries
    for f in entries[1::4]:
        assert_proven(largest(f, box), attack(f, box, 10_000))


@pytest.mark.thorough
def test_what_is_proven_is_kept_after_the_work() -> None:
    program = inverse("puma560_measured.toml")
    box = box_in(program, q=PI, qd=2.0, qdd_motor=5.0)
    f = program.outputs[0].entries[3]
    found = largest(f, box, work=0.0)
    assert not found.finished
    assert largest(f, box).found <= found.bound < math.inf


def test_true_degrees_are_found() -> None:
    """Syntax counts degree 3; forces in the base frame show 2."""
    program = inverse("puma560_measured.toml")
    box = box_in(program, q=PI, qd=2.0, qdd_motor=5.0)
    found = surface(program.outputs[0].entries[0], box)
    assert max(axis.degree for axis in found.axes) == 3
    assert max(found.orders) == 2


def test_left_out_orders_are_in_the_bound() -> None:
    """A small high wave that is left out counts in full."""
    graph = Graph()
    q = graph.symbol("q")
    f = graph.node(COS, q) + graph.node(COS, 5 * q) / 1000
    found = surface(f, box_of(q=(-PI, PI)))
    assert found.orders == (1,)
    assert found.left_out == pytest.approx(1e-3, rel=1e-6)
    assert largest(f, box_of(q=(-PI, PI))).bound >= 1.001


def test_too_many_positions_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    graph = Graph()
    monkeypatch.setattr(surface_module, "MOST_NODES", 4)
    f = graph.node(COS, 2 * graph.symbol("q"))
    assert largest(f, box_of(q=(-PI, PI))).reason == "5 positions determine it: 4 are the most"
