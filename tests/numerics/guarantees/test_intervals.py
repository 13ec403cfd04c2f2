"""Intervals: they hold what they must, and are not wider than their rounding."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import flint
import numpy as np
import pytest

from symoro_elastic.generation.pipeline import programs
from symoro_elastic.machine.scene import Scene
from symoro_elastic.numerics.guarantees.box import Box, box_of
from symoro_elastic.numerics.guarantees.intervals import INTERVALS, Interval, interval
from symoro_elastic.symbolic.arithmetic import RATIONAL, Arithmetic, Library, evaluate
from symoro_elastic.symbolic.expression import Expression
from symoro_elastic.symbolic.operations import COSPI, PI
from tests.numerics.guarantees.boxes import limits_of_test
from tests.references.random_machines import random_machine

SAMPLES = 400
BINARY = ("+", "-", "*", "/")
UNARY = ("sin", "cos", "sqrt", "sign")


def arb(x: float | Fraction | int) -> Any:
    return flint.arb(flint.fmpq(*Fraction(x).as_integer_ratio()))


FUNCTIONS: Mapping[str, Callable[..., Any]] = {
    "sin": lambda x: x.sin(),
    "cos": lambda x: x.cos(),
    "sqrt": lambda x: x.sqrt(),
    "sign": lambda x: x.sgn(),
    "atan2": flint.arb.atan2,
    PI: flint.arb.pi,
    COSPI: lambda x: (flint.arb.pi() * x).cos(),
}
BALLS: Arithmetic[Any] = Arithmetic(arb, Library(FUNCTIONS.__getitem__, RATIONAL))


@pytest.fixture(autouse=True)
def many_digits() -> Any:
    before, flint.ctx.prec = flint.ctx.prec, 200
    yield
    flint.ctx.prec = before


def drawn(rng: np.random.Generator, count: int = SAMPLES) -> Interval:
    """Intervals of all sizes: about zero, beside it, points, and many turns long."""
    middle = rng.normal(size=count) * 10.0 ** rng.integers(-3, 3, count)
    half = np.abs(rng.normal(size=count)) * 10.0 ** rng.integers(-6, 2, count) * (rng.random(count) < 0.8)
    return Interval(middle - half, middle + half)


def inside(x: Interval, rng: np.random.Generator) -> np.ndarray:
    """A value of each interval: an end, or one between."""
    return np.clip(x.low + rng.choice([0.0, 1.0, rng.random()], len(x.low)) * (x.high - x.low), x.low, x.high)


@pytest.mark.sampled(12)
@pytest.mark.parametrize("operation", [*BINARY, "atan2", *UNARY])
def test_results_of_values_are_in_the_interval_of_the_results(operation: str) -> None:
    rng = np.random.default_rng(len(operation))
    operands = [drawn(rng) for _ in range(1 if operation in UNARY else 2)]
    with np.errstate(all="ignore"):
        found = INTERVALS.operations[operation](*operands)
    for _ in range(20):
        values = [inside(x, rng) for x in operands]
        for k in range(SAMPLES):
            if operation == "sqrt" and operands[0].low[k] < 0:
                assert found.low[k] == -np.inf
                continue
            exact = BALLS.operations[operation](*(arb(x[k]) for x in values))
            if exact.is_finite():
                assert not exact < arb_end(found.low[k]), (operation, k)
                assert not exact > arb_end(found.high[k]), (operation, k)


def arb_end(x: float) -> Any:
    return arb(x) if np.isfinite(x) else flint.arb("inf") * int(np.sign(x))


def test_a_square_is_never_negative() -> None:
    x = Interval(np.array([-3.0, -2.0, 1.0]), np.array([2.0, -1.0, 4.0]))
    assert list((x * x).low >= 0) == [True] * 3
    assert (x * x).high == pytest.approx([9, 4, 16])


def test_what_is_not_bounded_stays_so() -> None:
    zero = Interval(np.array([-1.0]), np.array([1.0]))
    with np.errstate(all="ignore"):
        quotient = 1 / zero
        for found in (quotient, quotient * 0, quotient - quotient, -quotient, INTERVALS.operations["sin"](quotient)):
            assert (found.low[0], found.high[0]) == (-np.inf, np.inf)


def test_a_fraction_is_between_its_ends() -> None:
    third = interval(Fraction(1, 3))
    assert Fraction(float(third.low)) < Fraction(1, 3) < Fraction(float(third.high))
    assert float(interval(Fraction(1, 4)).low) == float(interval(Fraction(1, 4)).high) == 0.25


@dataclass(frozen=True)
class ExactEnds:
    """An interval whose ends have 200 bits: what intervals of doubles are compared with."""

    low: Any
    high: Any

    def of(self, *ends: Any) -> ExactEnds:
        points = [end.mid() for end in ends]
        return ExactEnds(min(points), max(points))

    def __add__(self, other: ExactEnds) -> ExactEnds:
        return self.of(self.low + other.low, self.high + other.high)

    def __sub__(self, other: ExactEnds) -> ExactEnds:
        return self.of(self.low - other.high, self.high - other.low)

    def __neg__(self) -> ExactEnds:
        return self.of(-self.high, -self.low)

    def __mul__(self, other: ExactEnds) -> ExactEnds:
        products = [x * y for x in (self.low, self.high) for y in (other.low, other.high)]
        found = self.of(*products)
        return self.of(found.high, flint.arb(0)) if other is self and self.low < 0 < self.high else found

    def __truediv__(self, other: ExactEnds) -> ExactEnds:
        assert other.low * other.high > 0
        return self * self.of(1 / other.low, 1 / other.high)

    def circle(self, function: str, top: Any) -> ExactEnds:
        """Ends of a sine or cosine, largest at `top`."""
        ends = [BALLS.operations[function](end) for end in (self.low, self.high)]
        for value, angle in ((1, top), (-1, top + flint.arb.pi())):
            turns = ((self.low - angle) / (2 * flint.arb.pi())).ceil()
            if angle + 2 * flint.arb.pi() * turns < self.high:
                ends.append(flint.arb(value))
        return self.of(*ends)


EXACT_ENDS: Arithmetic[ExactEnds] = Arithmetic(
    lambda x: ExactEnds(arb(x), arb(x)),
    Library(
        {
            "sin": lambda x: x.circle("sin", flint.arb.pi() / 2),
            "cos": lambda x: x.circle("cos", flint.arb(0)),
            "sqrt": lambda x: x.of(x.low.sqrt(), x.high.sqrt()),
            "atan2": lambda y, x: x.of(*(flint.arb.atan2(a, b) for a in (y.low, y.high) for b in (x.low, x.high))),
            "sign": lambda x: x.of(x.low.sgn(), x.high.sgn()),
            PI: lambda: ExactEnds(flint.arb.pi(), flint.arb.pi()),
            COSPI: lambda x: x.of(BALLS.operations[COSPI](x.low)),
        }.__getitem__
    ),
)


@pytest.mark.sampled(1000)
@pytest.mark.parametrize("seed", range(5))
def test_intervals_of_programs_are_those_of_exact_ends(seed: int) -> None:
    """In 200 sub-boxes of a model each: the ends are outside of those in 200 bits, by 1e-12 at most."""
    machine = random_machine(seed, joints=4, kinds=("motor", "elastic"))
    asked = programs(machine, Scene(models=("inverse_dynamics",) if seed % 2 else ("inertia_matrix",)))
    program = asked.package.functions[0].program
    box = box_of(asked.machine, limits_of_test(machine), program.inputs, program.used)
    roots = [x for output in program.outputs for x in output.entries if isinstance(x, Expression)]
    rng = np.random.default_rng(seed)
    for _ in range(200):
        part = sub_box(box, rng)
        ours = evaluate(roots, part, INTERVALS)
        exact = evaluate(roots, {name: ends(x) for name, x in part.items()}, EXACT_ENDS)
        for x in roots:
            low, high = float(ours(x).low[0]), float(ours(x).high[0])
            size = max(abs(low), abs(high))
            assert arb(low) <= exact(x).low and exact(x).high <= arb(high)
            assert exact(x).low - arb(low) < 1e-12 * size and arb(high) - exact(x).high < 1e-12 * size


def ends(x: Interval) -> ExactEnds:
    return ExactEnds(arb(float(x.low[0])), arb(float(x.high[0])))


def sub_box(box: Box, rng: np.random.Generator) -> dict[str, Interval]:
    """A part of a box: each range cut at two random places."""
    parts = {}
    for name, found in box.ranges.items():
        low, high = np.sort(rng.uniform(found.low, found.high, 2))
        parts[name] = Interval(np.array([low]), np.array([high]))
    return parts
