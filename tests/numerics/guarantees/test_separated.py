"""Angles that stand inside of sines and outside of them: bounds hold, and are near what is found."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from symoro_elastic.numerics.evaluation.arrays import EXTENDED, HAS_EXTENDED, arithmetic
from symoro_elastic.numerics.guarantees.largest_value import largest, value_at
from symoro_elastic.numerics.guarantees.polynomial_rounding import rounding_bound
from symoro_elastic.numerics.guarantees.polynomials import OF_SIGN, OUTSIDE, separate_sides
from symoro_elastic.numerics.guarantees.running_error import ROUNDINGS, Rounding
from symoro_elastic.symbolic.arithmetic import evaluate
from symoro_elastic.symbolic.expression import Expression, Graph, Operand, reachable
from symoro_elastic.symbolic.operations import COS, SIGN, SIN, SYMBOL
from tests.numerics.guarantees.attacked import box_of
from tests.numerics.guarantees.test_polynomial_rounding import measured

SINGLE, DOUBLE, MIXED = (ROUNDINGS[name] for name in ("single", "double", "mixed"))
PI = math.pi


def spring(graph: Graph) -> Operand:
    """k (q_m - q) - m g l sin(q) - c sin(q_m + q): the torque of a spring between two angles."""
    motor, q = graph.symbol("motor"), graph.symbol("q")
    return 7.3 * (motor - q) - 3.1 * graph.node(SIN, q) - 0.7 * graph.node(SIN, motor + q)


def test_what_stands_outside_has_another_name() -> None:
    root, box = spring(Graph()), box_of("motor q", motor=(-PI, PI), q=(-1, 1))
    (copy,), wider = separate_sides([root], box)
    assert isinstance(copy, Expression)
    names = {node.operands[0] for node in reachable([copy]) if node.operation == SYMBOL}
    assert names == {"motor", "q", f"motor{OUTSIDE}", f"q{OUTSIDE}"}
    assert wider.ranges[f"q{OUTSIDE}"] == box.ranges["q"] and f"q{OUTSIDE}" not in wider.positions
    state = {"motor": 0.7, "q": -0.4}
    both = state | {name + OUTSIDE: x for name, x in state.items()}
    assert value_at(copy, both, wider) == value_at(root, state, box)


def test_nothing_changes_where_all_stand_on_one_side() -> None:
    graph = Graph()
    q, x = graph.symbol("q"), graph.symbol("x")
    root = graph.node(SIN, q) * x
    assert separate_sides([root], box_of("q x", q=(-1, 1), x=(-1, 1)))[0] == [root]
    point = q + graph.node(SIN, q)
    assert separate_sides([point], box_of("q", q=(1, 1)))[0] == [point]


def test_two_programs_share_the_second_name() -> None:
    one, other = Graph(), Graph()
    difference = one.node(SIN, one.symbol("q")), other.symbol("q") * 1
    box = box_of("q", q=(-0.1, 0.1))
    found = largest(difference, box)
    assert max(abs(math.sin(x) - x) for x in np.linspace(-0.1, 0.1, 99)) <= found.bound
    assert found.bound <= 0.21


@pytest.mark.parametrize("precision", [np.float64, np.float32])
def test_the_torque_of_a_spring(precision: type) -> None:
    root, box = spring(Graph()), box_of("motor q", motor=(-PI, PI), q=(-0.5, 0.5))
    rounding = DOUBLE if precision is np.float64 else SINGLE
    found = rounding_bound(root, box, rounding)
    worst = measured(root, box, 50_000, precision)
    assert worst <= found.bound <= 4 * worst and found.reason == ""
    most = largest(root, box)
    states = box.states(50_000, np.random.default_rng(1))
    value = evaluate([root], states, arithmetic(np.float64))(root)
    assert np.abs(value).max() <= most.bound <= 1.2 * np.abs(value).max()
    assert most.found == pytest.approx(value_at(root, most.state, box))


@st.composite
def mixtures(draw: st.DrawFn) -> Operand:
    """A random polynomial of angles, their sums, and of sines of both."""
    graph = Graph()
    q1, q2 = map(graph.symbol, ("q1", "q2"))
    parts: list[Operand] = [q1, q1 + q2, graph.node(SIN, q1), graph.node(COS, q1 + q2), graph.node(SIN, q2)]
    for _ in range(draw(st.integers(1, 6))):
        one, two = (draw(st.sampled_from(parts)) for _ in range(2))
        factor = draw(st.sampled_from([0.1, -0.3, 7.7, 1.0]))
        parts.append(one * two if draw(st.booleans()) else factor * one - two)
    return parts[-1]


@pytest.mark.thorough
@settings(max_examples=60, deadline=None)
@given(mixtures(), st.floats(0.1, 4), st.booleans())
def test_random_mixtures(x: Operand, half: float, mixed: bool) -> None:
    if isinstance(x, int):
        return
    box = box_of("q1 q2", q1=(-half, half), q2=(0.2, 0.2 + half))
    assert measured(x, box, 3000, np.float32) <= rounding_bound(x, box, SINGLE).bound < math.inf
    most = largest(x, box, work=1e9)
    values = evaluate([x], box.states(3000, np.random.default_rng(0)), arithmetic(np.float64))(x)
    assert max(np.abs(values).max(), most.found) <= most.bound * (1 + 1e-12)
    if mixed:
        assert in_mixed(x, box_states(box)) <= rounding_bound(x, box, MIXED).bound


def box_states(box: object) -> dict[str, np.ndarray]:
    return box.states(3000, np.random.default_rng(7))  # type: ignore[attr-defined,no-any-return]


def in_mixed(x: Operand, states: dict[str, np.ndarray]) -> float:
    """The largest error where sines are those of angles in double, rounded to single, and all else is single."""
    nodes = reachable([x])
    exact = evaluate([x], {name: v.astype(EXTENDED) for name, v in states.items()}, arithmetic(EXTENDED))(x)
    doubles = evaluate(nodes, states, arithmetic(np.float64))
    known = {node.id: np.float32(doubles(node)) for node in nodes if node.operation in (SIN, COS)}
    narrow = {name: v.astype(np.float32) for name, v in states.items()}
    found = evaluate([x], narrow, arithmetic(np.float32), known)(x)
    return float(np.abs(found.astype(EXTENDED) - exact).max())


def rubbing(graph: Graph) -> Operand:
    """c sign(v) + m v v sin(q) - d v."""
    q, v = graph.symbol("q"), graph.symbol("v")
    return 5.3 * graph.node(SIGN, v) + 1.9 * v * v * graph.node(SIN, q) - 0.7 * v


@pytest.mark.skipif(not HAS_EXTENDED, reason="no type is wider than double")
@pytest.mark.parametrize(("rounding", "precision"), [(DOUBLE, np.float64), (SINGLE, np.float32)])
def test_signs_of_variables_are_variables(rounding: Rounding, precision: type) -> None:
    root, box = rubbing(Graph()), box_of("q", q=(-PI, PI), v=(-2.0, 2.0))
    assert largest(root, box).bound == pytest.approx(5.3 + 1.9 * 4 + 1.4, rel=0.02)
    found = rounding_bound(root, box, rounding)
    worst = measured(root, box, 20_000, precision)
    assert found.reason == "" and worst <= found.bound <= 6 * worst


def test_the_sign_of_what_moves_one_way_is_a_number() -> None:
    one_way = box_of("q", q=(-PI, PI), v=(0.5, 2.0))
    (_,), wider = separate_sides([rubbing(Graph())], one_way)
    assert (wider.ranges[f"v{OF_SIGN}"].low, wider.ranges[f"v{OF_SIGN}"].high) == (1.0, 1.0)
    assert largest(rubbing(Graph()), one_way).bound == pytest.approx(5.3 + 1.9 * 4 - 0.7 * 2, rel=0.08)


def test_signs_of_what_is_rounded_are_no_variables() -> None:
    graph = Graph()
    v, box = graph.symbol("v"), box_of("", v=(-2.0, 2.0))
    for root, rounding in ((rubbing(Graph()), MIXED), (3.7 * graph.node(SIGN, 0.3 * v - 0.1), DOUBLE)):
        found = rounding_bound(root, box_of("q", q=(-PI, PI), v=(-2.0, 2.0)) if rounding is MIXED else box, rounding)
        assert found.bound == math.inf and found.reason == "a sign of what depends on v"
