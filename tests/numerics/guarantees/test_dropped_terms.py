"""Dropped terms: the difference of two programs is within the bound, wherever it is looked for."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction

import numpy as np
import pytest
from numpy.typing import NDArray

from symoro_elastic.generation.pipeline import programs
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.scene import Scene
from symoro_elastic.numerics.evaluation.arrays import arithmetic
from symoro_elastic.numerics.guarantees.box import box_of, halves_along, parameter_box
from symoro_elastic.numerics.guarantees.certificate import Subject
from symoro_elastic.numerics.guarantees.dropped_terms import ChangedNodes, errors_of_changes
from symoro_elastic.numerics.guarantees.intervals import Interval
from symoro_elastic.numerics.guarantees.pivots import PivotKnowledge
from symoro_elastic.numerics.guarantees.running_error import ROUNDINGS, running_errors
from symoro_elastic.symbolic.expression import Expression, Graph, Level, Operand, reachable
from symoro_elastic.symbolic.operations import ADD, SIN, SUBTRACT, SYMBOL
from tests.numerics.guarantees.boxes import limits_of_test
from tests.references.random_machines import chain, planar_2r

Array = NDArray[np.float64]
FLOATS = arithmetic(np.float64)


def values(nodes: list[Expression], states: Mapping[str, Array], left_out: ChangedNodes) -> dict[int, Array]:
    """The values of all nodes of the changed program, written out once more."""
    found: dict[int, Array] = {}

    def of(x: Operand) -> Array:
        return found[x.id] if isinstance(x, Expression) else np.array(float(x))

    for node in nodes:
        operands = [] if node.operation == SYMBOL else [of(x) for x in node.operands]
        operands = [0.0 * x if (node.id, k) in left_out.dropped else x for k, x in enumerate(operands)]
        if node.id in left_out.frozen:
            found[node.id] = np.array(float(left_out.frozen[node.id]))
        elif node.operation == SYMBOL:
            found[node.id] = states[node.operands[0]]
        elif node.id in left_out.straightened:
            found[node.id] = operands[0]
        else:
            found[node.id] = FLOATS.operations[node.operation](*operands)
    return found


def drawn(nodes: list[Expression], rng: np.random.Generator, positions: set[str]) -> ChangedNodes:
    """Some changes: a tenth of the addends, some nodes of positions only, some sines."""
    moving = [x for x in nodes if x.level == Level.STATE]
    still: dict[int, bool] = {}
    for node in nodes:
        own = [still[x.id] for x in node.operands if isinstance(x, Expression)]
        still[node.id] = node.operands[0] in positions if node.operation == SYMBOL else all(own)
    sums = [x for x in moving if x.operation in (ADD, SUBTRACT)]
    dropped = {(x.id, int(rng.integers(2))) for x in sums if rng.random() < 0.1}
    kept = [x for x in moving if still[x.id] and x.operation not in (SYMBOL, ADD, SUBTRACT)]
    frozen = {x.id: Fraction(int(rng.integers(-8, 8)), 16) for x in kept if rng.random() < 0.03}
    sines = {x.id for x in moving if x.operation == SIN and rng.random() < 0.3} - frozen.keys()
    return ChangedNodes(frozenset(dropped), frozen, frozenset(sines))


def subject(machine: Machine, model: str) -> Subject:
    asked = programs(machine, Scene(models=(model,)))
    function, limits = asked.package.functions[0], limits_of_test(machine, 0.2)
    box = box_of(asked.machine, limits, function.program.inputs, function.program.used)
    knowledge = PivotKnowledge(asked, machine, parameter_box(machine, limits), function)
    return Subject(function, box, ROUNDINGS["double"], knowledge)


@pytest.mark.sampled(12)
@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("model", ["inverse_dynamics", "direct_dynamics"])
def test_differences_are_within_the_bound(model: str, seed: int) -> None:
    machine = chain(3, elastic=(2,), symbolic=False) if seed else planar_2r()
    whole = subject(machine, model)
    nodes, results, box = whole.nodes, whole.results, whole.box
    rng = np.random.default_rng(seed)
    bounded = 0
    for _ in range(6):
        left_out = drawn(nodes, rng, set(box.positions))
        parts = halves_along(box.whole, sorted(box.positions)[-1])
        bounds = whole.bounds(parts)
        most = errors_of_changes(nodes, results, bounds, left_out).max(axis=1)
        states = box.states(3000, rng)
        exact, changed = (values(nodes, states, x) for x in (ChangedNodes(), left_out))
        for x, bound in zip(results, most, strict=True):
            if isinstance(x, Expression) and np.isfinite(bound):
                worst = np.max(np.abs(changed[x.id] - exact[x.id]))
                assert worst <= bound * (1 + 1e-9) + 1e-9
                bounded += bool(bound)
    assert bounded > 2


def test_signs_are_kept() -> None:
    """x + y less both of two equal terms of opposite sign: they cancel, and the bound knows."""
    graph = Graph()
    x, y, z = map(graph.symbol, "xyz")
    product = x * y
    first, second = z + product, z * z + product
    root = (first - second).positive
    nodes = reachable([root])
    box = dict.fromkeys("xyz", Interval(np.array([1.0]), np.array([2.0])))
    bounds = running_errors(nodes, box, ROUNDINGS["double"])
    gone = {(node.id, k) for node in (first, second) for k, one in enumerate(node.operands) if one is product}
    assert errors_of_changes(nodes, [root], bounds, ChangedNodes(frozenset(gone)))[0, 0] < 3.1
    one = ChangedNodes(frozenset(sorted(gone)[:1]))
    assert errors_of_changes(nodes, [root], bounds, one)[0, 0] == pytest.approx(4, rel=1e-9)


def test_nothing_left_out_is_exact() -> None:
    whole = subject(planar_2r(), "inverse_dynamics")
    bounds = whole.bounds(whole.box.whole)
    assert not errors_of_changes(whole.nodes, whole.results, bounds, ChangedNodes()).any()


def test_a_divisor_that_a_dropped_term_may_cancel_is_not_bounded() -> None:
    graph = Graph()
    x, y = map(graph.symbol, "xy")
    root = 1 / (x + y)
    nodes = reachable([root])
    box = {"x": Interval(np.array([-1.0]), np.array([1.0])), "y": Interval(np.array([2.0]), np.array([3.0]))}
    bounds = running_errors(nodes, box, ROUNDINGS["double"])
    total = nodes[-2]
    for k, one in enumerate(total.operands):
        found = errors_of_changes(nodes, [root], bounds, ChangedNodes(frozenset({(total.id, k)})))[0, 0]
        assert np.isfinite(found) == (one is x)
