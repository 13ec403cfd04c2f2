"""Operations against guaranteed error: the path, and what stands behind each part of an error."""

from __future__ import annotations

import itertools
import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import symoro_elastic as se
from symoro_elastic.analysis.trade_off import guaranteed
from symoro_elastic.analysis.trade_off.guaranteed import (
    Grid,
    GuaranteedCurve,
    GuaranteedPoint,
    curves_of,
    grids_of,
    path_through,
)
from symoro_elastic.analysis.trade_off.views import advice, guaranteed_parts
from symoro_elastic.formats import read_machine
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.described import DescribedMachine
from symoro_elastic.machine.scene import ALL, Scene
from symoro_elastic.machine.within import ALL_RESULTS, GUARANTEES, Evidence, Keep, Tolerance, Within
from symoro_elastic.numerics.evaluation.arrays import arithmetic
from symoro_elastic.numerics.guarantees.box import box_of
from symoro_elastic.numerics.within.budget import Error
from symoro_elastic.symbolic.arithmetic import evaluate
from symoro_elastic.symbolic.program import OperationCount
from tests.command_line import EXAMPLES, refused, run

TWO_R = EXAMPLES / "planar_2r.toml"
TYPES = {"double": np.float64, "single": np.float32}
UNSEEN, SEED = 100_000, 4711


def described(path: Path) -> DescribedMachine:
    return DescribedMachine.of(read_machine(path)[0])


def point(time: float, total: float) -> GuaranteedPoint:
    part = Error(total, Evidence.PROVEN)
    none = Error(0.0, Evidence.PROVEN)
    return GuaranteedPoint("recursion", "double", 0.0, 0, OperationCount(), none, part, 0.0, time)


def within(tolerance: float, guaranteed: Evidence = Evidence.CONFIDENT) -> Within:
    return Within({ALL_RESULTS: Tolerance(tolerance)}, Keep.TERMS, guaranteed)


def test_the_path_takes_what_saves_most_for_its_error_within_the_tolerance() -> None:
    points = [point(100, 0.0), point(90, 0.1), point(60, 0.2), point(50, 0.9), point(40, 1.1), point(45, math.inf)]
    assert path_through(points) == (0, 2, 3)
    free = [point(100, 1e-3), point(80, 1e-4), point(70, 1e-3), point(60, math.nan)]
    assert path_through(free) == (0, 2), "what adds nothing comes first, the fastest of it; NaN is no bound"
    assert path_through([point(100, 2.0), point(120, 0.0)]) == (0,)


@pytest.mark.thorough
@pytest.mark.parametrize("guaranteed", list(GUARANTEES))
def test_every_part_of_an_error_has_its_word(guaranteed: Evidence) -> None:
    scene = Scene(models=("inverse_dynamics",), within=within(0.1, guaranteed))
    (curve,) = curves_of(grids_of(described(TWO_R), scene), {})
    word = Evidence.PROVEN if guaranteed is Evidence.PROVEN else Evidence.CONFIDENT
    refuse_paths_that_turn(curve)
    assert curve.points[0].left_out == 0 and curve.points[0].terms.value == 0 and curve.saved > 0
    for one in curve.points:
        assert one.rounding.evidence is Evidence.PROVEN and 0 < one.rounding.value < 1e-2
        assert one.terms.evidence is (word if one.left_out else Evidence.PROVEN)
        assert one.unseen <= one.terms.value <= 1
    assert "95 %: with 95% confidence" in str(guaranteed_parts(curve)) or word is Evidence.PROVEN
    assert f"{curve.advised.left_out} terms left out" in advice(curve)


def refuse_paths_that_turn(curve: GuaranteedCurve) -> None:
    path = [curve.points[k] for k in curve.path]
    assert all(after.time < before.time for before, after in itertools.pairwise(path))
    sums = list(itertools.accumulate((one.total for one in path), max))
    assert sums[-1] <= 1 and path[0].precision == "double" and not path[0].left_out


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("file", "model", "tolerance"),
    [
        ("planar_2r.toml", "direct_dynamics", 0.05),
        ("planar_2r.toml", "inverse_dynamics", 0.1),
        ("two_axis.toml", "direct_dynamics", 0.005),
        ("ball_screw.toml", "direct_dynamics", 0.01),
    ],
)
def test_no_unseen_state_exceeds_the_sum(file: str, model: str, tolerance: float) -> None:
    """In double and in single precision, beside the whole model in double; states of another seed."""
    machine = described(EXAMPLES / file)
    scene = Scene(models=(model,), within=within(tolerance), fold=ALL)
    grid = Grid(machine, scene)
    grid.add(0.3)
    grid.add(0.98)
    whole = grid.programs[model][0]
    program = whole.function.program
    box = box_of(whole.asked.machine, machine.limits, program.inputs, program.used)
    states = box.states(UNSEEN, np.random.default_rng(SEED))
    exact = results(whole.function.program, states, np.float64)
    largest = np.abs(exact).max(axis=1)
    claims = {(x.share, x.precision): x for x in grid.points({})[model]}
    assert len(claims) >= 6
    for one in grid.programs[model]:
        for precision, dtype in TYPES.items():
            found = np.abs(results(one.function.program, states, dtype) - exact).max(axis=1)
            allowed = np.where(largest > 0, largest, np.inf) * tolerance
            claim = claims[one.share, precision]
            assert (found / allowed).max() <= claim.total * LARGEST_OF_A_SAMPLE


LARGEST_OF_A_SAMPLE = 1.05
"""The largest value of a result at 20 000 states, to which tolerances are relative, and that of these states."""


def results(program: object, states: dict[str, np.ndarray], dtype: type) -> np.ndarray:
    roots = [x for output in program.outputs for x in output.entries]  # type: ignore[attr-defined]
    value = evaluate(roots, {name: x.astype(dtype) for name, x in states.items()}, arithmetic(dtype))
    return np.array([np.broadcast_to(value(x), UNSEEN).astype(np.float64) for x in roots])


@pytest.mark.thorough
def test_the_inertia_matrix_takes_part_where_it_has_fewer_operations(monkeypatch: pytest.MonkeyPatch) -> None:
    """Here it has as many, and is told to have fewer: each form has its own programs and certificates."""
    monkeypatch.setattr(guaranteed, "_has_forms", lambda *_: True)
    scene = Scene(models=("direct_dynamics",), within=within(0.1))
    (curve,) = curves_of(grids_of(described(TWO_R), scene), {})
    whole = {x.form: x for x in curve.points if not x.left_out and x.precision == "double"}
    assert {*whole} == {"recursion", "inertia"} and whole["recursion"].operations != whole["inertia"].operations
    assert all(x.rounding.evidence is Evidence.PROVEN for x in whole.values())
    refuse_paths_that_turn(curve)


@pytest.mark.thorough
def test_the_time_of_a_precision_is_what_was_measured() -> None:
    scene = Scene(models=("inverse_dynamics",), within=within(0.1))
    grid = Grid(described(TWO_R), replace(scene, fold=ALL))
    grid.add(0.98)
    counted = grid.points({})["inverse_dynamics"]
    by_name = {(x.share, x.precision): x.time for x in counted}
    assert by_name[0.0, "double"] == by_name[0.0, "single"] == by_name[0.0, "mixed"], "nothing is measured"
    found = se.benchmark(TWO_R, "inverse_dynamics", within="10 %", effort="quick", states=4)
    compiled = [x for x in found.measurements["inverse_dynamics"] if x.configuration.build and x.configuration.is_safe]
    fastest = {x: min(one.ns for one in compiled if one.configuration.precision.name == x) for x in TYPES}
    whole = {x.precision: x.time for x in found.curves[0].points if not x.left_out}
    assert whole["single"] / whole["double"] == pytest.approx(fastest["single"] / fastest["double"])


def test_parameters_without_values_are_refused() -> None:
    with pytest.raises(InputError, match="has no value"):
        grids_of(described(EXAMPLES / "flex4.par"), Scene(within=within(0.01)))
    said = refused("benchmark", str(EXAMPLES / "flex4.par"), "--within", "1%", "--effort", "quick", "--states", "4")
    assert "--within: " in said and "has no value" in said
    assert "--keep: belongs to a tolerance" in refused("benchmark", str(TWO_R), "--keep", "terms")


@pytest.mark.thorough
def test_the_command_prints_one_path(tmp_path: Path) -> None:
    asked = (str(TWO_R), "--model", "inverse_dynamics", "--within", "5%", "--effort", "quick", "--tolerance", "1e-6")
    printed = run("benchmark", *asked, "--plots", str(tmp_path)).stdout
    assert "operations against guaranteed error, of the tolerance" in printed
    assert (tmp_path / "inverse_dynamics_guaranteed.png").exists()
    (curve,) = json.loads(run("benchmark", *asked, "--json").stdout)["curves"]
    assert curve["points"][curve["path"][-1]]["total"] <= 1
