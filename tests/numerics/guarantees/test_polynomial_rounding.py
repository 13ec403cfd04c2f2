"""Rounding errors of polynomials: bounds are never exceeded, and within 20 times what is measured."""

from __future__ import annotations

import math
from collections.abc import Mapping
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import symoro_elastic as se
from symoro_elastic.codegen.printers import constant_values
from symoro_elastic.generation.pipeline import prepare, programs
from symoro_elastic.machine.limits import Range
from symoro_elastic.machine.scene import Scene
from symoro_elastic.numerics.evaluation.arrays import EXTENDED, HAS_EXTENDED, arithmetic
from symoro_elastic.numerics.guarantees import polynomial_rounding
from symoro_elastic.numerics.guarantees.box import Box
from symoro_elastic.numerics.guarantees.box import box_of as box_of_machine
from symoro_elastic.numerics.guarantees.polynomial_rounding import rounding_bound
from symoro_elastic.numerics.guarantees.running_error import ROUNDINGS, running_errors
from symoro_elastic.symbolic.arithmetic import evaluate, multiprecision
from symoro_elastic.symbolic.expression import Graph, Level, Operand, reachable
from symoro_elastic.symbolic.operations import COS, SIN
from symoro_elastic.symbolic.program import Program
from tests.benchmarks.certificates import with_values
from tests.command_line import EXAMPLES
from tests.numerics.guarantees.attack import Attack
from tests.numerics.guarantees.attacked import box_of
from tests.numerics.guarantees.boxes import limits_of_test

DOUBLE, SINGLE, MIXED = (ROUNDINGS[name] for name in ("double", "single", "mixed"))
PI = math.pi
WIDER: Mapping[type, type] = {np.float64: EXTENDED, np.float32: np.float64}


def measured(x: Operand, box: Box, states: int, precision: type, seed: int = 0) -> float:
    """The largest error at random states, carried out as it stands in a precision, beside one that is wider."""
    draw = np.random.default_rng(seed)
    symbols = {name: found.astype(precision) for name, found in box.states(states, draw).items()}
    known = {node: precision(c) for node, c in constant_values([x]).items()}
    exact = evaluate(
        [x], {name: v.astype(WIDER[precision]) for name, v in symbols.items()}, arithmetic(WIDER[precision])
    )
    computed = evaluate([x], symbols, arithmetic(precision), known)
    return float(np.abs(computed(x) - exact(x)).max())


def model(name: str, asked: str) -> Program:
    """A model of an example, with numbers."""
    machine = prepare(EXAMPLES / name, lambda line: None, base=True)
    return programs(machine, Scene(models=(asked,), fold="all")).models[0].program


def box_in(program: Program, **half: float) -> Box:
    """A box with these half widths, by argument."""
    ranges = {s: Range(-half[x.name], half[x.name]) for x in program.inputs for s in x.symbols}
    return Box(ranges, frozenset(program.inputs[0].symbols))


@pytest.mark.sampled(12)
@pytest.mark.skipif(not HAS_EXTENDED, reason="no type is wider than double")
@pytest.mark.parametrize(
    ("name", "asked", "half", "ratio"),
    [
        ("planar_2r.toml", "inverse_dynamics", PI, 10),
        ("planar_2r.toml", "inverse_dynamics", 0.5, 12),
        pytest.param("puma560_measured.toml", "inertia_matrix", PI, 20, marks=pytest.mark.thorough),
        pytest.param("puma560_measured.toml", "inverse_dynamics", PI, 20, marks=pytest.mark.thorough),
        pytest.param("puma560_measured.toml", "inverse_dynamics", 0.5, 20, marks=pytest.mark.thorough),
    ],
)
@pytest.mark.parametrize(("rounding", "precision"), [(DOUBLE, np.float64), (SINGLE, np.float32)])
def test_models(name: str, asked: str, half: float, ratio: float, rounding: object, precision: type) -> None:
    program = model(name, asked)
    box = box_in(program, q=half, qd=2.0, qdd_motor=5.0)
    entries = program.outputs[0].entries
    for x in entries[:: 1 if len(entries) < 3 else 7 if asked == "inertia_matrix" else 2]:
        found = rounding_bound(x, box, ROUNDINGS["double" if precision is np.float64 else "single"])
        worst = measured(x, box, 20_000, precision)
        assert found.reason == ""
        assert worst <= found.bound * (1 + 2.0**-10)  # what the wider type may be off
        assert found.bound <= found.crude
        assert found.bound <= ratio * worst or worst == 0.0


@pytest.mark.thorough
@pytest.mark.skipif(not HAS_EXTENDED, reason="no type is wider than double")
@pytest.mark.parametrize(("scale", "ratio"), [(1.0, 20), (0.2, 12)])
def test_a_heavy_arm(scale: float, ratio: float) -> None:
    """The fourth torque of the RX90: the sum of errors is bounded at once, not that of the largest errors."""
    machine = with_values(se.read(EXAMPLES / "rx90.par"))
    program = programs(machine, Scene(models=("inverse_dynamics",))).models[0].program
    box = box_of_machine(machine, limits_of_test(machine, scale), program.inputs, program.used)
    x = program.outputs[0].entries[3]
    worst = Attack([x], box, "double").run(30_000, rounds=20, kept=200).error[0]
    assert worst <= rounding_bound(x, box, DOUBLE).bound <= ratio * worst


@st.composite
def sums(draw: st.DrawFn) -> Operand:
    """A random polynomial with constants that are not exact, sines of sums, and factors that are powers of two."""
    graph = Graph()
    q1, q2, v = map(graph.symbol, ("q1", "q2", "v"))
    parts: list[Operand] = [graph.node(SIN, q1), graph.node(COS, q1 + q2), graph.node(SIN, 2 * q2 + graph.pi / 3), v]
    numbers = st.sampled_from([0.5, 4.0, 0.1, -0.3, 7.7, 1.0])
    for _ in range(draw(st.integers(1, 7))):
        one, two = (draw(st.sampled_from(parts)) for _ in range(2))
        made: Operand = one * two if draw(st.booleans()) else draw(numbers) * one - two
        parts.append(made + draw(numbers) if draw(st.booleans()) else made)
    return parts[-1]


@pytest.mark.thorough
@settings(max_examples=60, deadline=None)
@given(sums(), st.floats(0.1, 4), st.booleans())
def test_random_polynomials(x: Operand, half: float, positive: bool) -> None:
    if isinstance(x, int):
        return
    box = box_of("q1 q2", q1=(-half, half), q2=(0.2, 0.2 + half), v=(0.5 if positive else -2, 2))
    found = rounding_bound(x, box, SINGLE)
    assert measured(x, box, 3000, np.float32) <= found.bound <= found.crude < math.inf


def test_beside_fifty_digits() -> None:
    """A sum that cancels: 1 + v - 1, whose error is that of 1 + v."""
    graph = Graph()
    q, v = graph.symbol("q"), graph.symbol("v")
    x = (graph.node(COS, q) + 1000 * v) - 1000 * v * graph.node(COS, q)
    box = box_of("q", q=(0.0, 0.01), v=(0.9, 1.0))
    found = rounding_bound(x, box, DOUBLE)
    digits = multiprecision()
    draw = np.random.default_rng(3)
    worst = 0.0
    for _ in range(300):
        state = {"q": float(draw.uniform(0, 0.01)), "v": float(draw.uniform(0.9, 1.0))}
        exact = evaluate([x], {name: digits.number(value) for name, value in state.items()}, digits)(x)
        computed = evaluate([x], {name: np.float64(value) for name, value in state.items()}, arithmetic(np.float64))(x)
        worst = max(worst, abs(float(exact - digits.number(float(computed)))))
    assert worst <= found.bound <= 20 * worst


def test_mixed_and_parameters() -> None:
    """Angles in double cost less than in single; a parameter that single rounds costs a rounding.

    Sines cost 3/2 units, half a one where they are only narrowed.
    """
    graph = Graph()
    q, m = graph.symbol("q"), graph.symbol("m", Level.PARAMETER)
    x = m * graph.node(SIN, q)
    box = box_of("q", q=(-PI, PI), m=(0.1, 0.1))
    units = [rounding_bound(x, box, rounding).bound / rounding.u for rounding in (DOUBLE, SINGLE, MIXED)]
    assert units == pytest.approx([0.15 + 0.0625, 0.15 + 2 * 0.0625, 0.05 + 2 * 0.0625], rel=1e-5)


def test_a_constant_factor_counts_with_the_value() -> None:
    """0.193 v: the error of the constant is multiplied by v, not by the power of two below the product."""
    graph = Graph()
    v, w = graph.symbol("v"), graph.symbol("w")
    x = v * Fraction(193, 1000) + w
    box = box_of(v=(4.99, 5), w=(0.0, 0.001))
    assert measured(x, box, 200_000, np.float64) <= rounding_bound(x, box, DOUBLE).bound


def test_a_divisor_that_is_rounded_counts() -> None:
    """0.4 p/(2 pi), the lead of a screw: pi is rounded, which moves the quotient."""
    graph = Graph()
    p = graph.symbol("p")
    x = p / (graph.pi * 2) * Fraction(2, 5)
    box = box_of(p=(0.02, 0.02))
    assert measured(x, box, 10, np.float64) <= rounding_bound(x, box, DOUBLE).bound <= 4e-19


def test_numbers_and_refusals() -> None:
    graph = Graph()
    q, x = graph.symbol("q"), graph.symbol("x")
    assert rounding_bound(3, box_of(), DOUBLE).bound == 0.0
    found = rounding_bound(x / graph.node(COS, q), box_of(q=(-1, 1), x=(-1, 1)), DOUBLE)
    assert (found.bound, found.reason) == (math.inf, "a quotient by what depends on q")
    divided = rounding_bound(q / graph.symbol("m", Level.PARAMETER), box_of(q=(-1, 1), m=(3, 3)), DOUBLE)
    assert divided.reason == "it divides by parameters: fold them to numbers"


def test_many_nodes_leave_the_crude_bound(monkeypatch: pytest.MonkeyPatch) -> None:
    program = model("planar_2r.toml", "inverse_dynamics")
    box = box_in(program, q=PI, qd=2.0, qdd_motor=5.0)
    x = program.outputs[0].entries[0]
    fine = rounding_bound(x, box, DOUBLE)
    monkeypatch.setattr(polynomial_rounding, "MOST_NODES", 1)
    crude = rounding_bound(x, box, DOUBLE)
    assert crude.bound == crude.crude == pytest.approx(fine.crude, rel=1e-12)
    assert fine.bound < crude.bound


@pytest.mark.thorough
def test_it_is_below_the_running_error() -> None:
    """Intervals see the magnitudes only of derivatives, and of their products with values."""
    program = model("puma560_measured.toml", "inverse_dynamics")
    box = box_in(program, q=PI, qd=2.0, qdd_motor=5.0)
    x = program.outputs[0].entries[4]
    by_intervals = float(running_errors(reachable([x]), box.whole, DOUBLE).error_of(x).max())
    assert rounding_bound(x, box, DOUBLE).bound < 0.9 * by_intervals
