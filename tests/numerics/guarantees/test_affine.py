"""Affine forms: they hold what they must, are narrow where terms cancel, and prove errors of loops."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from symoro_elastic.codegen.precision import PRECISIONS
from symoro_elastic.generation.pipeline import certificates, programs
from symoro_elastic.machine.described import DescribedMachine
from symoro_elastic.machine.scene import Scene
from symoro_elastic.numerics.guarantees.affine import AFFINE, Affine, of_interval, variable
from symoro_elastic.numerics.guarantees.intervals import Interval
from symoro_elastic.numerics.guarantees.mean_value import MOST_NUMBERS, forms_of
from symoro_elastic.numerics.guarantees.running_error import ROUNDINGS, running_errors
from symoro_elastic.symbolic.expression import Graph, reachable
from tests.examples import example
from tests.numerics.guarantees.attack import SLACK, Attack, results_as_printed
from tests.numerics.guarantees.boxes import limits_of_test

COUNT, VARIABLES = 300, 3
FUNCTIONS = {
    "+": np.add,
    "-": np.subtract,
    "*": np.multiply,
    "/": np.divide,
    "sin": np.sin,
    "cos": np.cos,
    "sqrt": np.sqrt,
    "atan2": np.arctan2,
    "minimum": np.minimum,
    "maximum": np.maximum,
    "sign": np.sign,
}
POSITIVE = ("sqrt",)


def drawn(rng: np.random.Generator, least: float) -> Affine:
    """Forms of all sizes, whose values have at least this magnitude."""
    slopes = rng.normal(size=(COUNT, VARIABLES)) * 10.0 ** rng.integers(-4, 2, (COUNT, 1))
    error = np.abs(rng.normal(size=COUNT)) * 10.0 ** rng.integers(-6, 1, COUNT) * (rng.random(COUNT) < 0.7)
    radius = np.abs(slopes).sum(axis=1) + error
    center = rng.normal(size=COUNT) * 3
    center = np.where(np.abs(center) < radius + least, np.sign(center) * (1.01 * radius + least), center)
    return Affine(center, slopes, error)


def values(x: Affine, at: np.ndarray, error: np.ndarray) -> np.ndarray:
    """Those of forms at e = `at` and a part of their rests, in a wider type."""
    wide = np.longdouble
    return x.center.astype(wide) + (x.slopes.astype(wide) * at.astype(wide)).sum(axis=-1) + x.error.astype(wide) * error


@pytest.mark.sampled(12)
@pytest.mark.parametrize("name", FUNCTIONS)
@pytest.mark.parametrize("least", [0.0, 0.3])
def test_forms_hold_all_values(name: str, least: float) -> None:
    rng = np.random.default_rng(len(name))
    if name in ("/", "sqrt") and not least:
        least = 1e-3
    operands = [drawn(rng, least) for _ in range(1 if name in ("sin", "cos", "sqrt", "sign") else 2)]
    if name in POSITIVE:
        operands = [Affine(np.abs(x.center), x.slopes, x.error) for x in operands]
    found, worst = AFFINE.operations[name](*operands), np.zeros(COUNT)
    assert np.isfinite(found.error).all()
    for k in range(300):
        at = rng.choice([-1.0, 1.0], (COUNT, VARIABLES)) if k % 2 else rng.uniform(-1, 1, (COUNT, VARIABLES))
        parts = [rng.choice([-1.0, 1.0, rng.uniform(-1, 1)], COUNT) for _ in operands]
        exact = FUNCTIONS[name](*(values(x, at, part) for x, part in zip(operands, parts, strict=True)))
        off = np.abs(exact - values(found, at, np.zeros(COUNT)))
        assert (off <= found.error).all(), k
        within = found.range
        assert ((within.low <= exact) & (exact <= within.high)).all()
        worst = np.maximum(worst, off.astype(float))
    assert name in ("atan2", "minimum", "maximum", "sign") or np.median(worst / found.error) > 0.1


@pytest.mark.parametrize("half", [1e-3, 0.3, 2.0, 3.1])
def test_sine_and_cosine_of_an_angle_share_their_variables(half: float) -> None:
    middles = np.linspace(-8, 8, 33)
    x = variable(Interval(middles - half, middles + half), 0, 3)
    x.of_circle = 1, 2
    forms = {name: AFFINE.operations[name](x) for name in ("sin", "cos")}
    for t in np.linspace(-half, half, 41).astype(np.longdouble):
        exact = np.array([np.sin(middles + t), np.cos(middles + t)]) - np.array(
            [forms[name].center + forms[name].slopes[:, 0] * float(t / half) for name in ("sin", "cos")]
        )
        shared = np.array([forms[name].slopes[:, 1:] for name in ("sin", "cos")]).transpose(1, 0, 2)
        e = np.linalg.lstsq(shared[0], exact[:, 0].astype(float), rcond=1e-9)[0]
        assert (np.abs(e) <= 1 + 1e-9).all()
        left = exact.T - shared @ e
        assert (np.abs(left) <= np.array([forms["sin"].error, forms["cos"].error]).T + 1e-12).all()
    assert max(float(f.error.max()) for f in forms.values()) < 1e-11
    assert (forms["sin"] * forms["sin"] + forms["cos"] * forms["cos"]).range.magnitude.max() < 1 + 2 * half**2


@np.errstate(all="ignore")
def test_what_is_not_bounded_stays_so() -> None:
    zero = variable(Interval(np.array([-1.0]), np.array([1.0])), 0, 1)
    for x in (zero.reciprocal(), AFFINE.operations["sqrt"](zero), of_interval(zero.reciprocal().range)):
        for found in (x, x * zero, x - x, zero / x, -x):
            assert np.isinf(found.range.magnitude).all()
    assert np.isfinite(zero.reciprocal().at_most(Interval(np.array([2.0]), np.array([3.0]))).range.magnitude).all()


def test_what_cancels_at_every_state_cancels() -> None:
    force = Interval(np.array([-10.0]), np.array([10.0]))
    near = Interval(np.array([1.0]), np.array([1.001]))
    by_intervals = (force * near - force * near).magnitude
    f, x = variable(force, 0, 2), variable(near, 1, 2)
    assert by_intervals[0] > 20
    assert (f * x - f * x).magnitude[0] < 2e-2
    assert (f * x / x - f).magnitude[0] < 1e-1


def test_ranges_and_errors_of_a_program_become_smaller_never_larger() -> None:
    graph = Graph()
    x, y = graph.symbol("x"), graph.symbol("y")
    root = (x * y - x) / (y * y + x * x)
    nodes, parts = reachable([root]), {n: Interval(np.array([1.0, 1.5]), np.array([1.5, 2.0])) for n in "xy"}
    bounds = running_errors(nodes, parts, ROUNDINGS["double"])
    forms = forms_of(nodes, bounds, parts)
    assert forms
    closer = running_errors(nodes, parts, ROUNDINGS["double"], narrowings=forms.narrowing())
    for node in nodes:
        old, new = bounds.range[node.id], closer.range[node.id]
        assert (old.low <= new.low).all() and (new.high <= old.high).all()
        assert (closer.error[node.id] <= bounds.error[node.id]).all()
    before, after = (x.range[root.id].high - x.range[root.id].low for x in (bounds, closer))
    assert (after < 0.8 * before).all()
    assert forms_of(nodes, bounds, parts, results=int(MOST_NUMBERS)) is None


@pytest.mark.thorough
@pytest.mark.parametrize(("name", "most"), [("four_bar.par", 30), ("palletizer.toml", 100)])
def test_direct_models_of_loops_are_bounded_near_what_is_found(name: str, most: float) -> None:
    """By intervals alone these are 700 and 500 times what is found."""
    machine = DescribedMachine.of(example(name))
    machine = replace(machine, limits=limits_of_test(machine, 0.2))
    scene = Scene(models=("direct_dynamics",))
    (found,) = certificates(machine, scene, [PRECISIONS["double"]]).certificates
    worst = Attack(results_as_printed(programs(machine, scene).package.functions[0].program), found.box, "double").run(
        4000
    )
    for entry, error in zip(found.entries, worst.error, strict=True):
        assert error <= entry.error * (1 + SLACK["double"]) + 2.0**-63 * entry.magnitude
        assert entry.error <= most * error
