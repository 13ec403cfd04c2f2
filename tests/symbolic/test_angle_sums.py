"""Sums of angles in place of products: the same values, fewer operations, a bound that is said."""

from __future__ import annotations

import itertools
import math
from fractions import Fraction
from pathlib import Path

import mpmath
import numpy as np
import pytest
from click.testing import CliRunner

from symoro_elastic.analysis.trade_off.trade import Request, trade
from symoro_elastic.cli import cli
from symoro_elastic.codegen.compile import compile_package
from symoro_elastic.codegen.precision import DOUBLE, DOUBLE_DOUBLE, MIXED, SINGLE, Precision
from symoro_elastic.formats import read_machine
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.generation.pipeline import programs
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.scene import Scene
from symoro_elastic.models.programs.catalogue import trace, trace_scene
from symoro_elastic.symbolic.angle_sums import with_angle_sums
from symoro_elastic.symbolic.arithmetic import FLOATS, evaluate, multiprecision
from symoro_elastic.symbolic.expression import Expression, Graph, reachable
from symoro_elastic.symbolic.functions import cosine_sine
from symoro_elastic.symbolic.operations import SIN, SYMBOL
from tests.references.random_machines import random_machine

EXAMPLES = Path(__file__).parents[2] / "examples"
MODELS = ("geometric_model", "jacobian", "direct_dynamics", "inverse_dynamics")


def machine(name: str) -> Machine:
    return read_machine(EXAMPLES / name)[0]


def test_sums_and_differences_become_one_angle() -> None:
    graph = Graph()
    a, b, c = (graph.symbol(name) for name in "abc")
    for angle in (a + b, a - b, b - a, a + b + c, a - b - c):
        cosine, sine = cosine_sine(graph, angle)
        assert len(reachable([cosine, sine])) >= 10
        value = with_angle_sums(graph, [cosine, sine])
        sums = {node.operation for node in reachable([value(cosine), value(sine)])} - {"symbol", "neg"}
        assert sums <= {"cos", "sin", "+", "-"}, "no product is left"


@pytest.mark.parametrize("order", [1, -1])
@pytest.mark.parametrize("sign", [1, -1])
def test_every_form_of_the_addition_theorems_keeps_its_value(sign: int, order: int) -> None:
    """In each order in which products are made, by which sums order them."""
    graph = Graph()
    (ca, sa), (cb, sb) = (cosine_sine(graph, graph.symbol(name)) for name in "ab")
    products = [x * y for x, y in [(ca, cb), (ca, sb), (sa, cb), (sa, sb), (ca, ca)][::order]]
    numbers = {"a": mpmath.mpf("0.7"), "b": mpmath.mpf("-1.9")}
    with mpmath.workdps(30):
        for x, y in itertools.product([*products, *(-x for x in products)], repeat=2):
            root = x + sign * y
            merged = with_angle_sums(graph, [root])(root)
            before, after = (evaluate([z], numbers, multiprecision(30))(z) for z in (root, merged))
            assert abs(before - after) < 1e-25, (root, merged)


@pytest.mark.parametrize("seed", range(6))
def test_values_stay(seed: int) -> None:
    """In 50 digits, where a wrong sign or angle would be seen."""
    some = random_machine(seed, joints=6)
    roots = [x for o in trace(some, "jacobian").program.outputs for x in o.entries]
    graph = next(x.graph for x in roots if isinstance(x, Expression))
    value = with_angle_sums(graph, roots)
    merged = [value(x) for x in roots]
    rng = np.random.default_rng(seed)
    names = {n.operands[0] for n in reachable([*roots, *merged]) if n.operation == SYMBOL}
    with mpmath.workdps(50):
        symbols = {
            name: mpmath.mpf(float(x)) for name, x in zip(sorted(names), rng.uniform(-3, 3, len(names)), strict=True)
        }
        exact, found = (evaluate(some, symbols, multiprecision(50)) for some in (roots, merged))
        assert max(abs(exact(x) - found(y)) for x, y in zip(roots, merged, strict=True)) < mpmath.mpf(10) ** -45


def test_what_is_saved() -> None:
    count = trace(machine("planar_2r.toml"), "geometric_model", merge_angles=True).program.count
    assert (count.products, count.add, count.sincos) == (4, 3, 4)
    asked = Scene(models=MODELS, merge_angles=10.0)
    merged = {name: [m.merged for m in trace_scene(machine(name), asked)] for name in ("two_axis.toml", "rx90.par")}
    assert merged["two_axis.toml"] == [True, True, False, False]
    assert merged["rx90.par"] == [False] * 4, "a sine and a cosine more cost more than four products"


@pytest.mark.sampled(5)
@pytest.mark.parametrize("precision", [DOUBLE, SINGLE, MIXED, DOUBLE_DOUBLE], ids=lambda p: p.name)
def test_generated_code_sums_angles(precision: Precision, tmp_path: Path) -> None:
    """A sum of two angles below 10 is rounded by less than 10 u; the trigonometry and lengths below 1 m add a few u."""
    arm = machine("planar_2r.toml")
    states = np.random.default_rng(1).uniform(-10, 10, (37, 2)).astype(np.float32)
    plain, merged = (
        programs(arm, Scene(models=("geometric_model",), merge_angles=bound)).package for bound in (None, 10.0)
    )
    wanted = compile_package(plain, tmp_path / "plain").call("geometric_model", q=states)["T"]
    compiled = compile_package(merged, tmp_path / "merged", precision=precision)
    u = max(2.0**-53, 2.0**-precision.bits)
    for call in (compiled.call, compiled.call_batch):
        assert np.abs(call("geometric_model", q=states)["T"] - wanted).max() <= 20 * u


def test_beyond_the_bound_digits_are_lost(tmp_path: Path) -> None:
    """At 1e8 rad an ulp of an angle is 1.5e-8."""
    arm = machine("planar_2r.toml")
    scene = Scene(models=("geometric_model",), merge_angles=10.0)
    compiled = compile_package(programs(arm, scene).package, tmp_path)
    q = np.random.default_rng(2).uniform(0.5e8, 1e8, (50, 2))
    found = compiled.call("geometric_model", q=q)["T"][:, 1, 0, 0]
    wanted = np.cos(q[:, 0]) * np.cos(q[:, 1]) - np.sin(q[:, 0]) * np.sin(q[:, 1])
    assert 1e-9 < np.abs(found - wanted).max() < 2e-8


def test_the_bound_is_said(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    asked = ["generate", str(EXAMPLES / "planar_2r.toml"), "--merge-angles", "6.5"]
    CliRunner().invoke(cli, [*asked, "--model", "jacobian"], catch_exceptions=False)
    for name in ("planar_2r.h", "__init__.py"):
        assert "valid for |q| <= 6.5 rad" in Path("generated/planar_2r", name).read_text()
    result = CliRunner().invoke(cli, [*asked, "--model", "direct_dynamics"], catch_exceptions=False)
    assert "note: merging angles saves no operations" in result.stderr
    assert "valid for" not in Path("generated/planar_2r/planar_2r.h").read_text()


@pytest.mark.thorough
def test_sums_are_a_point_of_the_trade_where_they_pay(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CC", "no-such-compiler")
    asked = Scene(models=("geometric_model",), merge_angles=10.0)
    known = trade(machine("planar_2r.toml"), asked, Request("quick", states=4, rounds=1))
    assert {one.configuration.form.merged for one in known.measurements["geometric_model"]} == {False, True}
    known = trade(machine("rx90.par"), asked, Request("quick", states=4, rounds=1))
    assert {one.configuration.form.merged for one in known.measurements["geometric_model"]} == {False}
    far = trade(machine("planar_2r.toml"), asked, Request("quick", states=4, rounds=1, extreme=True))
    assert any("exceed any bound" in note for note in far.notes)
    with pytest.raises(InputError, match=r"needs 3\.15 or more"):
        trade(machine("planar_2r.toml"), Scene(models=("jacobian",), merge_angles=1.0))


def test_products_of_variables_share_a_sine() -> None:
    """They round, so that the sum of sines of each would be no more accurate; sums of variables are split."""
    graph = Graph()
    a, b, N = (graph.symbol(name) for name in ("a", "b", "N"))
    for angle, sines in ((a + b, 2), (a / 3 + b * Fraction(7, 10), 1), (a * N - b / 3, 1), (a + b / 3 + a * N, 2)):
        nodes = reachable(cosine_sine(graph, angle))
        assert sum(node.operation == SIN for node in nodes) == sines
        value = evaluate(cosine_sine(graph, angle), {"a": 0.3, "b": -1.7, "N": 5.0}, FLOATS)
        whole = float(evaluate([angle], {"a": 0.3, "b": -1.7, "N": 5.0}, FLOATS)(angle))
        for x, exact in zip(cosine_sine(graph, angle), (math.cos(whole), math.sin(whole)), strict=True):
            assert float(value(x)) == pytest.approx(exact, abs=4e-16)
