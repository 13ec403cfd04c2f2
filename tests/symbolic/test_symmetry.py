"""Lanes of vectors: what their vectors compute from their operands, number by number, is what their nodes are."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from typing import Any

import numpy as np
import pytest

from symoro_elastic.machine.scene import ALL, Scene
from symoro_elastic.models.packaging import trace_models
from symoro_elastic.symbolic.arithmetic import FLOATS, evaluate
from symoro_elastic.symbolic.expression import Expression, Graph, reachable
from symoro_elastic.symbolic.symmetry import Vector, lanes_of
from tests.references.limbs import with_limbs

APPLIED = {"+": lambda x, y: x + y, "-": lambda x, y: x - y, "*": lambda x, y: x * y, "/": lambda x, y: x / y}


def value_of(vector: Vector, lane: int, values: Mapping[int, float], constants: Any) -> float:
    """A lane of a vector from its operands."""
    first = vector.nodes[0]
    if not vector.operands:
        return values[vector.nodes[lane].id] * vector.signs[lane]
    numbers = []
    for x in vector.operands:
        if isinstance(x, Vector):
            numbers.append(value_of(x, lane, values, constants))
        elif isinstance(x, tuple):
            numbers.append(constants(x[lane]))
        else:
            numbers.append(constants(x))
    if vector.flips:
        numbers[1] *= vector.flips[lane]
    return -numbers[0] if first.operation == "neg" else APPLIED[first.operation](*numbers)


@pytest.mark.thorough
@pytest.mark.sampled(8)
@pytest.mark.parametrize("symbolic", [False, True])
@pytest.mark.parametrize("copies", [2, 4, 6])
@pytest.mark.parametrize("seed", range(4))
def test_vectors_compute_the_numbers_of_their_lanes(seed: int, copies: int, symbolic: bool) -> None:
    machine = with_limbs(seed, copies, symbolic=symbolic)
    total = 0
    for fold in (), ALL:
        package = trace_models(machine, Scene(models=("inverse_dynamics", "inertia_matrix"), fold=fold)).package
        for function in package.functions:
            nodes = function.program.nodes
            lanes = lanes_of(nodes, package.congruent)
            rng = np.random.default_rng(seed)
            names = {node.operands[0] for node in nodes if node.operation == "symbol"}
            value = evaluate(nodes, {name: float(rng.uniform(0.5, 2)) for name in sorted(names)}, FLOATS)
            values = {node.id: value(node) for node in nodes}
            total += len(lanes)
            for number, lane in lanes.items():
                sign = lane.vector.signs[lane.number]
                found = value_of(lane.vector, lane.number, values, value)
                assert lane.vector.nodes[lane.number].id == number
                assert found == pytest.approx(sign * values[number], rel=1e-13, abs=1e-300)
    assert total


def test_signs_and_constants_may_differ() -> None:
    graph = Graph()
    a, b, c, d, t = map(graph.symbol, "abcdt")
    left, right = (a + Fraction(1, 2) * b) * t, (c - Fraction(1, 3) * d) * t
    assert isinstance(left, Expression)
    lanes = lanes_of(reachable([left, right]), [("a", "c"), ("b", "d")])
    assert lanes[left.id].vector is lanes[right.id].vector
    (product,) = (x for x in lanes[left.id].vector.operands if isinstance(x, Vector))
    assert product.flips == (1, -1)


def test_a_sum_of_both_limbs_is_a_number() -> None:
    graph = Graph()
    a, c, t = map(graph.symbol, "act")
    both = a * t + c * t + t
    lanes = lanes_of(reachable([both]), [("a", "c")])
    assert lanes.keys() == {a.id, c.id, (a * t).id, (c * t).id}


def test_symbols_that_are_none_make_no_lanes() -> None:
    graph = Graph()
    a, c = map(graph.symbol, "ac")
    x, y = a * a + 1, c * 2
    assert lanes_of(reachable([x, y]), [("a", "e")]) == {}
    assert {node.operation for node in reachable([x, y]) if node.id in lanes_of(reachable([x, y]), [("a", "c")])} == {
        "symbol"
    }
