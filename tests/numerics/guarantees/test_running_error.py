"""Running errors and adjoints: no computed value is further off than they say, and little closer."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pytest

from symoro_elastic.generation.pipeline import programs
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.scene import Scene
from symoro_elastic.numerics.evaluation.arrays import arithmetic
from symoro_elastic.numerics.guarantees.box import Box, box_of, points
from symoro_elastic.numerics.guarantees.certificate import Subject
from symoro_elastic.numerics.guarantees.intervals import Interval
from symoro_elastic.numerics.guarantees.mean_value import errors_by_adjoints
from symoro_elastic.numerics.guarantees.running_error import ROUNDINGS, running_errors, ufp
from symoro_elastic.symbolic.arithmetic import evaluate, multiprecision
from symoro_elastic.symbolic.expression import Graph, Operand, reachable
from symoro_elastic.symbolic.operations import COS, SIN, SQRT
from tests.numerics.guarantees.attack import SLACK, TYPES, computed
from tests.numerics.guarantees.boxes import limits_of_test
from tests.references.random_machines import random_machine

STATES = 400


def off(roots: Sequence[Operand], states: Mapping[str, Any], dtype: type) -> np.ndarray:
    """How far computed results are off at each state: against 50 digits."""
    found, exact = computed(roots, states, dtype), multiprecision()
    count = len(next(iter(states.values())))
    errors = np.zeros((len(roots), count))
    for k in range(count):
        value = evaluate(roots, {name: exact.number(float(x[k])) for name, x in states.items()}, exact)
        for row, x, one in zip(errors, roots, found, strict=True):
            row[k] = abs(float(exact.number(float(np.broadcast_to(one, count)[k])) - value(x)))
    return errors


def subject_of(machine: Machine, model: str, precision: str) -> Subject:
    asked = programs(machine, Scene(models=(model,)))
    function = asked.package.functions[0]
    box = box_of(asked.machine, limits_of_test(machine), function.program.inputs, function.program.used)
    return Subject(function, box, ROUNDINGS[precision])


def states_of(box: Box, precision: str, seed: int = 0, count: int = STATES) -> dict[str, Any]:
    """States as arrays of the precision hold them; they may be an ulp out of the box, which is widened by it."""
    drawn = box.states(count, np.random.default_rng(seed))
    return {name: x.astype(TYPES[precision]).astype(float) for name, x in drawn.items()}


@pytest.mark.sampled(2)
@pytest.mark.parametrize("precision", TYPES)
@pytest.mark.parametrize("model", ["inverse_dynamics", "inertia_matrix", "direct_dynamics"])
def test_errors_at_states_are_below_both_bounds_there(model: str, precision: str) -> None:
    machine = random_machine(3, joints=3, kinds=("motor", "elastic"))
    subject = subject_of(machine, model, precision)
    states = states_of(subject.box, precision, count=60)
    found = off(subject.results, states, TYPES[precision])
    bounds = subject.bounds(points(states))
    running = np.array([np.broadcast_to(bounds.error_of(x), 60) for x in subject.results])
    adjoint = errors_by_adjoints(subject.nodes, subject.results, bounds)
    assert np.all(found <= running)
    assert np.all(found <= adjoint)
    moving = found.max(axis=1) > 0
    assert np.all(np.minimum(running, adjoint).max(axis=1)[moving] < 100 * found.max(axis=1)[moving])


@pytest.mark.thorough
@pytest.mark.parametrize("seed", range(4))
def test_errors_in_a_box_are_below_those_of_the_box(seed: int) -> None:
    machine = random_machine(seed, joints=4, kinds=("motor", "elastic"))
    for model in ("inverse_dynamics", "inertia_matrix"):
        subject = subject_of(machine, model, "single")
        states = states_of(subject.box, "single", seed, 4000)
        exact = evaluate(subject.results, states, arithmetic(np.float64))
        found = computed(subject.results, states, np.float32)
        bound = subject.errors(subject.bounds(subject.box.whole))[:, 0]
        for x, one, most in zip(subject.results, found, bound, strict=True):
            assert np.max(np.abs(one.astype(float) - exact(x))) <= most * (1 + SLACK["single"])


def test_a_hand_worked_bound() -> None:
    """x y + z in [1, 2]^3: the product is at most 4, its rounding u 4; the sum at most 6, u 4; together 8 u."""
    graph = Graph()
    x, y, z = map(graph.symbol, "xyz")
    root = x * y + z
    one_to_two = Interval(np.array([1.0]), np.array([2.0]))
    nodes = [x, y, z, root.operands[0] if root.operands[0].operation == "*" else root.operands[1], root]
    bounds = running_errors(nodes, dict.fromkeys("xyz", one_to_two), ROUNDINGS["double"])
    assert bounds.error_of(root)[0] == pytest.approx(8 * 2.0**-53, rel=1e-12)


def test_a_quotient_that_may_divide_by_zero_is_not_bounded() -> None:
    graph = Graph()
    x, y = map(graph.symbol, "xy")
    box = {"x": Interval(np.array([1.0]), np.array([2.0])), "y": Interval(np.array([-1e-9]), np.array([1.0]))}
    bounds = running_errors([x, y, root := x / y], box, ROUNDINGS["double"])
    assert np.isinf(bounds.error_of(root)[0])
    assert not bounds.range_of(root).is_bounded[0]


def test_an_error_that_reaches_zero_of_a_divisor_is_not_bounded() -> None:
    """y - 1 is at least 1e-20, but it is computed to 1e-16 only."""
    graph = Graph()
    y = graph.symbol("y")
    shifted = y * y - 1
    box = {"y": Interval(np.array([1.0 + 2.0**-52]), np.array([2.0]))}
    nodes = [y, y * y, shifted, root := 1 / shifted]
    assert np.isinf(running_errors(nodes, box, ROUNDINGS["single"]).error_of(root)[0])


def test_roots_and_signs_near_zero() -> None:
    graph = Graph()
    x = graph.symbol("x")
    square = x * x
    root, sign = graph.node(SQRT, square), graph.node("sign", square - 1)
    nodes = [x, square, square - 1, root, sign]
    box = {"x": Interval(np.array([0.0]), np.array([2.0]))}
    bounds = running_errors(nodes, box, ROUNDINGS["double"])
    assert np.isinf(bounds.error_of(root)[0])
    assert bounds.error_of(sign)[0] >= 2


def test_mixed_precision_keeps_angles_in_double() -> None:
    """The sine of 1000 rad to an ulp of single: an angle in single would be off by 3e-5."""
    graph = Graph()
    x = graph.symbol("x")
    nodes = [x, sine := graph.node(SIN, x), cosine := graph.node(COS, x)]
    box = {"x": Interval(np.array([1000.0]), np.array([1000.1]))}
    bounds = running_errors(nodes, box, ROUNDINGS["mixed"], angles={x.id})
    assert bounds.error_of(sine)[0] < 2.0**-24 and bounds.error_of(cosine)[0] < 2.0**-24
    assert bounds.error_of(x)[0] == pytest.approx(512 * 2.0**-24, rel=1e-6)


def test_ufp() -> None:
    assert list(ufp(np.array([0.0, 1.0, 1.5, 2.0, 0.75, 3e-323]))) == [0, 1, 1, 2, 0.5, 2.0**-1072]
    assert np.isinf(ufp(np.array(np.inf)))


def test_adjoints_see_what_cancels() -> None:
    """(p + z) - p with p = x y: lemma 1 counts the rounding of p twice, lemma 2 knows that it cancels."""
    graph = Graph()
    x, y, z = map(graph.symbol, "xyz")
    product = x * y
    total = product + z
    root = (total - product).positive  # signs are carried outwards
    nodes = reachable([root])
    box = dict.fromkeys("xyz", Interval(np.array([1.0]), np.array([2.0])))
    bounds = running_errors(nodes, box, ROUNDINGS["double"])
    of_product, of_total, of_root = (bounds.local[node.id][0] for node in (product, total, root))
    assert bounds.error_of(root)[0] == pytest.approx(2 * of_product + of_total + of_root, rel=1e-9)
    assert errors_by_adjoints(nodes, [root], bounds)[0, 0] == pytest.approx(of_total + of_root, rel=1e-6)
