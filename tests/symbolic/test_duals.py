"""Exact derivatives at a point: first and second, against differences in 50 digits and against formulas."""

from __future__ import annotations

import math
import operator
from fractions import Fraction

import mpmath
import numpy as np
import pytest

from symoro_elastic.foundation.scalar import Scalar
from symoro_elastic.numerics.motion.equations_of_motion import EquationsOfMotion, State
from symoro_elastic.symbolic.arithmetic import FLOATS, RATIONAL, evaluate, multiprecision
from symoro_elastic.symbolic.differentiation import gradient
from symoro_elastic.symbolic.duals import Dual, _apply, differentiating
from symoro_elastic.symbolic.expression import Graph
from symoro_elastic.symbolic.functions import arc_tangent, cosine_sine, sign, square_root
from symoro_elastic.symbolic.operations import ADD, MULTIPLY, SUBTRACT
from tests.references.random_machines import random_machine, random_state
from tests.references.small_motions import as_floats, differences, forces


def every_operation(graph: Graph) -> list[Scalar]:
    x, y = graph.symbol("x"), graph.symbol("y")
    cosine, sine = cosine_sine(graph, x + y + Fraction(1, 3))
    return [
        x + y, x - y, 3 - x, x * y, x / y, 2 / x, x / 3, -x, x * x * x,
        cosine, sine, square_root(graph, x * x + y), arc_tangent(graph, x, y), arc_tangent(graph, 1, y),
        sign(graph, x) * y, graph.pi * x + 1, cosine_sine(graph, graph.pi / 7)[0] * y,
    ]  # fmt: skip


def test_every_operation_against_differences_in_50_digits() -> None:
    graph, arithmetic = Graph(), multiprecision(50)
    roots = every_operation(graph)
    at = (mpmath.mpf("0.7"), mpmath.mpf("1.9"))

    def values(point: list[mpmath.mpf]) -> list[mpmath.mpf]:
        value = evaluate(roots, dict(zip("xy", point, strict=True)), arithmetic)
        return [value(root) for root in roots]

    wanted = differences(values, at)
    with mpmath.workdps(50):
        for column, direction in enumerate(((1, 0), (0, 1))):
            seeded = {name: Dual(x, mpmath.mpf(d)) for name, x, d in zip("xy", at, direction, strict=True)}
            value = evaluate(roots, seeded, differentiating(arithmetic))
            for row, root in enumerate(roots):
                found = value(root)
                assert abs(found.tangent - wanted[row][column]) < 1e-28


def test_duals_of_duals_give_second_derivatives() -> None:
    graph = Graph()
    x, y = graph.symbol("x"), graph.symbol("y")
    _, sine = cosine_sine(graph, x)
    roots = [y * sine / x, square_root(graph, x) * y * y, arc_tangent(graph, y, x)]
    a, b = 0.8, 1.3
    seeded = {
        "x": Dual(Dual(a, np.array([1.0, 0.0])), np.array([[1.0], [0.0]])),
        "y": Dual(Dual(b, np.array([0.0, 1.0])), np.array([[0.0], [1.0]])),
    }
    value = evaluate(roots, seeded, differentiating(FLOATS))
    s, c, w = math.sin(a), math.cos(a), a * a + b * b
    wanted = [
        [[b * (2 * s / a**3 - 2 * c / a**2 - s / a), c / a - s / a**2], [c / a - s / a**2, 0.0]],
        [[-b * b / 4 * a**-1.5, b / math.sqrt(a)], [b / math.sqrt(a), 2 * math.sqrt(a)]],
        [[2 * a * b / w**2, (b * b - a * a) / w**2], [(b * b - a * a) / w**2, -2 * a * b / w**2]],
    ]
    for root, hessian in zip(roots, wanted, strict=True):
        np.testing.assert_allclose(value(root).tangent.tangent, hessian, rtol=1e-14, atol=1e-15)


@pytest.mark.sampled(5)
@pytest.mark.parametrize("seed", range(4))
def test_jacobians_of_random_trees_against_differences_in_50_digits(seed: int) -> None:
    machine = random_machine(seed, joints=5, symbolic=True, moving_base=seed == 3)
    motion = EquationsOfMotion(machine)
    q, qd, _ = random_state(machine, seed)
    qdd = np.random.default_rng(seed).uniform(-3, 3, len(q)).tolist()
    found = motion.jacobians(
        motion.residual, State(*map(np.array, (q, qd, qdd)), np.zeros(len(q)), np.zeros(len(machine.motors)))
    )
    wanted = [
        differences(lambda x: forces(machine, x, qd, qdd), q),
        differences(lambda x: forces(machine, q, x, qdd), qd),
        differences(lambda x: forces(machine, q, qd, x), qdd),
    ]
    for block, exact in zip(found, map(as_floats, wanted), strict=True):
        np.testing.assert_allclose(block, exact, rtol=0, atol=1e-13 * max(np.abs(exact).max(), 1.0))


def test_one_sweep_back_gives_the_derivatives_of_every_operation() -> None:
    graph, arithmetic = Graph(), multiprecision(50)
    roots = every_operation(graph)
    at = (mpmath.mpf("0.7"), mpmath.mpf("1.9"))
    with mpmath.workdps(50):
        for root in roots:
            weights, place = [mpmath.mpf(2), mpmath.mpf(-1)], dict(zip("xy", at, strict=True))
            found = gradient([root, root], weights, place, arithmetic)
            for name, direction in (("x", (1, 0)), ("y", (0, 1))):
                seeded = {n: Dual(x, mpmath.mpf(d)) for n, x, d in zip("xy", at, direction, strict=True)}
                forward = evaluate([root], seeded, differentiating(arithmetic))(root)
                assert abs(found.get(name, 0) - forward.tangent) < 1e-48


@pytest.mark.thorough
def test_slopes_by_parameters_against_differences_in_50_digits() -> None:
    """Of forces, and of their changes along a direction: second derivatives by parameters and by positions."""
    machine = random_machine(7, joints=3, symbolic=True, friction=False)
    motion = EquationsOfMotion(machine)
    names = [parameter.name for parameter in machine.parameters][::3]
    q, _, _ = random_state(machine, 7)
    n, rest = len(q), [0.0] * len(q)
    left, right = np.random.default_rng(7).uniform(-1, 1, (2, n, 2))
    state = State(np.array(q), np.zeros(n), np.zeros(n), np.zeros(n), np.zeros(len(machine.motors)))
    given = [motion.parameters[name] for name in names]
    by_symbol = motion.work_slopes(state, left)
    by_q, changed = motion.change_slopes(state, left, right, 0 * right, -2 * right)

    def work(x: list[mpmath.mpf], place: list[mpmath.mpf], k: int) -> list[mpmath.mpf]:
        found = forces(machine, place, rest, rest, dict(zip(names, x, strict=True)))
        return [mpmath.fdot(map(mpmath.mpf, left[:, k]), found)]

    def change(x: list[mpmath.mpf], place: list[mpmath.mpf], k: int) -> list[mpmath.mpf]:
        step = [mpmath.mpf("1e-10") * mpmath.mpf(d) for d in right[:, k]]
        values = dict(zip(names, x, strict=True))
        up = forces(machine, [a + s for a, s in zip(place, step, strict=True)], rest, [-2 * s for s in step], values)
        down = forces(machine, [a - s for a, s in zip(place, step, strict=True)], rest, [2 * s for s in step], values)
        weighted = [mpmath.mpf(w) * (a - b) for w, a, b in zip(left[:, k], up, down, strict=True)]
        return [mpmath.fsum(weighted) / mpmath.mpf("2e-10")]

    with mpmath.workdps(50):
        for k in range(2):
            wanted = (
                (by_symbol, names, differences(lambda x, k=k: work(x, q, k), given)),
                (changed, names, differences(lambda x, k=k: change(x, q, k), given)),
                (dict(enumerate(by_q)), range(n), differences(lambda x, k=k: change(given, x, k), q)),
            )
            for found, keys, exact in wanted:
                row = [found[key][k] if key in found else 0.0 for key in keys]
                np.testing.assert_allclose(
                    row, as_floats(exact[0]), rtol=0, atol=1e-12 * np.abs(as_floats(exact)).max()
                )


def test_sums_multiply_no_tangents() -> None:
    class Unmultiplied(float):
        """A tangent that fails where it is multiplied."""

        def __mul__(self, other: object) -> float:
            raise AssertionError(f"multiplied by {other}")

        __rmul__ = __mul__

    x, y = Dual(2.0, Unmultiplied(3.0)), Dual(5.0, Unmultiplied(7.0))
    assert (x + y).tangent == 10.0
    assert (x - 1).tangent == 3.0
    assert (x / 2).tangent == 1.5


def test_sums_and_products_of_moving_duals_are_those_of_the_partial_derivatives_to_the_last_bit() -> None:
    source = np.random.default_rng(25)
    a, b, c = (Dual(float(source.normal()), source.normal(size=5)) for _ in range(3))
    nested = (Dual(a, b), Dual(c, a))
    for x, y in ((a, b), (b, 3.7), nested, (nested[0], c.value)):
        for made, name in ((operator.add, ADD), (operator.sub, SUBTRACT), (operator.mul, MULTIPLY)):
            for pair in ((x, y), (y, x)):
                with np.printoptions(floatmode="unique"):
                    assert repr(made(*pair)) == repr(_apply(name, RATIONAL, pair))
