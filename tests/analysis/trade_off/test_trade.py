"""The trade of speed against accuracy: the front, the advice, the drift of states, what is missing is said."""

from __future__ import annotations

import ctypes
import json
import math
import shlex
import subprocess
import warnings
from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner
from hypothesis import given
from hypothesis import strategies as st

from symoro_elastic.analysis.trade_off import drift
from symoro_elastic.analysis.trade_off import formulations as formulations_of_trade
from symoro_elastic.analysis.trade_off import trade as of_trade
from symoro_elastic.analysis.trade_off import trade as trade_module
from symoro_elastic.analysis.trade_off.advice import sentence
from symoro_elastic.analysis.trade_off.builds import FAST_MATH, NATIVE, PLAIN, WITH_LIBM, Build, flag_sets
from symoro_elastic.analysis.trade_off.configurations import (
    BATCH,
    MATTERS,
    SINGLE_CALL,
    Configuration,
    Measurement,
    Run,
    Time,
    front,
    time_runs,
)
from symoro_elastic.analysis.trade_off.drift import drifts
from symoro_elastic.analysis.trade_off.formulations import Formulation, formulations
from symoro_elastic.analysis.trade_off.trade import Request, Trade, trade
from symoro_elastic.analysis.trade_off.views import effects
from symoro_elastic.cli import cli
from symoro_elastic.codegen.compile import CompilationFailed, compile_library
from symoro_elastic.codegen.precision import DOUBLE, SINGLE, Precision
from symoro_elastic.codegen.targets.c import render_c
from symoro_elastic.formats import read_machine
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.foundation.output_files import permission
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.scene import Scene
from symoro_elastic.numerics.evaluation.arrays import evaluate_arrays
from symoro_elastic.numerics.evaluation.values import parameter_values
from symoro_elastic.numerics.verification.accuracy import Errors, round_states, rounded_values
from symoro_elastic.numerics.verification.states import moderate_states
from tests.closed_chains.machines import without_closed_form

EXAMPLES = Path(__file__).parents[3] / "examples"
TWO_R = EXAMPLES / "planar_2r.toml"
SINGLE_U = 2.0**-SINGLE.bits
ASKED = ["--base", "--fold", "all", "--model", "direct_dynamics"]


@pytest.fixture(scope="module")
def two_r() -> Machine:
    return read_machine(TWO_R)[0]


@pytest.fixture(scope="module")
def form(two_r: Machine) -> Formulation:
    return formulations(two_r, Scene(models=("inverse_dynamics",)), parameter_values(two_r))[0][0]


@pytest.fixture(scope="module")
def printed() -> Iterator[dict[str, Any]]:
    """Figures of a quick trade; no build is left out, however busy the machine is."""
    options = ["--effort", "quick", "--states", "400", "--rounds", "1", "--tolerance", "1e-10", "--json"]
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(trade_module, "PATIENCE", math.inf)
        result = CliRunner().invoke(cli, ["benchmark", str(TWO_R), *ASKED, *options], catch_exceptions=False)
    yield json.loads(result.stdout)


def figures(
    form: Formulation,
    ns: float,
    error: float,
    flags: tuple[str, ...] = NATIVE,
    precision: Precision = DOUBLE,
    call: str = BATCH,
    bound: float | None = None,
) -> Measurement:
    point = Configuration("inverse_dynamics", form, Build(("gcc",), flags, precision), precision, call)
    u = 2.0**-precision.bits
    return Measurement(
        point,
        Time(ns, ns),
        Errors(u, error / u, error / u / 8, 1.0, 1.0, 100, 0, (error if bound is None else bound) / u),
    )


def found(machine: Machine, *some: Measurement) -> Trade:
    return Trade(machine, Request(), {"inverse_dynamics": list(some)})


@pytest.mark.thorough
@given(st.lists(st.tuples(st.floats(1, 1e4), st.floats(1e-17, 1e-3) | st.just(math.inf)), max_size=12))
def test_nothing_beats_the_front(form: Formulation, drawn: list[tuple[float, float]]) -> None:
    some = [figures(form, ns, error) for ns, error in drawn]
    best = front(some)
    for one, other in pairwise(best):
        assert one.ns <= other.ns and one.error > other.error * MATTERS
    for one in some:
        if math.isfinite(one.error):
            assert any(other.ns <= one.ns and other.error <= one.error * MATTERS for other in best)
    assert all(math.isfinite(one.error) for one in best)


def test_the_fastest_within_the_tolerance_is_advised(two_r: Machine, form: Formulation) -> None:
    slow, fast = figures(form, 20, 1e-16), figures(form, 5, 1e-7, precision=SINGLE)
    one_by_one = figures(form, 70, 1e-16, call=SINGLE_CALL)
    known = found(two_r, slow, fast, one_by_one)
    assert known.advice(1e-6).fastest == (fast,)
    strict = known.advice(1e-9)
    assert strict.fastest == (slow,) and strict.one_state == (one_by_one,)
    said = sentence(strict)
    assert said.count(".\n") == 0 and said.endswith(".") and "20 ns" in said and "70 ns" in said


def test_what_is_advised_holds_at_states_that_were_not_tried(two_r: Machine, form: Formulation) -> None:
    lucky, sure = figures(form, 5, 1e-7, precision=SINGLE, bound=1e-4), figures(form, 20, 1e-16, bound=1e-14)
    known = found(two_r, lucky, sure)
    assert known.advice(1e-6).fastest == (sure,) and known.advice(1e-3).fastest == (lucky,)
    said = sentence(known.advice(1e-3))
    assert said.startswith(
        "Within a relative error of 1.0e-03, with 95% confidence at 100000 unseen states by the tail of "
        "the errors, inputs in double"
    )
    assert "(worst of 100 states 1.0e-07, bound 1.0e-04)" in said


@pytest.mark.thorough
def test_rounding_of_inputs_counts(two_r: Machine) -> None:
    """The exact result is that of inputs in double: rounding them to single is more than rounding the result."""
    request = Request("quick", states=400, rounds=1)
    with pytest.MonkeyPatch.context() as patched:
        patched.setenv("CC", "no-such-compiler")
        known = trade(two_r, Scene(models=("inverse_dynamics",)), request).measurements["inverse_dynamics"]
    single = next(one for one in known if one.configuration.precision is SINGLE)
    values, states = parameter_values(two_r), moderate_states(two_r, 400, values=parameter_values(two_r))
    traced = single.configuration.form.traced["inverse_dynamics"]
    rounded_inputs = evaluate_arrays(traced, round_states(states, SINGLE), rounded_values(values, SINGLE), np.float64)[
        "tau"
    ]
    exact = evaluate_arrays(traced, states, values, np.float64)["tau"]
    error = np.abs(rounded_inputs - exact).max(axis=1) / np.abs(exact).max(axis=1)
    assert single.error > 0.5 * error.max() > SINGLE_U


def test_fast_math_is_advised_only_where_it_is_allowed(two_r: Machine, form: Formulation) -> None:
    known = found(two_r, figures(form, 20, 1e-16), figures(form, 1, 2e-16, (*NATIVE, FAST_MATH)))
    assert known.advice(1e-12).fastest[0].ns == 20
    assert known.advice(1e-12, fast_math=True).fastest[0].ns == 1
    assert [one.ns for one in front(known.measurements["inverse_dynamics"])] == [20]


def test_a_tolerance_that_no_point_reaches_names_the_nearest(two_r: Machine, form: Formulation) -> None:
    known = found(two_r, figures(form, 20, 3e-16), figures(form, 5, 1e-7, precision=SINGLE))
    with pytest.raises(
        InputError, match=r"within .* 1\.0e-20, .*: nearest is 3\.0e-16, with recursion; double; gcc O3"
    ):
        known.advice(1e-20)


def test_no_bound_is_told_from_too_few_states(two_r: Machine, form: Formulation) -> None:
    point = figures(form, 20, 3e-16)
    known = found(two_r, replace(point, errors=replace(point.errors, unseen=math.inf)))
    with pytest.raises(InputError, match=r"nearest is without a bound \(measure at more --states\), with recursion"):
        known.advice(1e-3)


def test_a_choice_is_told_from_points_that_differ_in_nothing_else(form: Formulation) -> None:
    best, libm, plain = (
        figures(form, 10, 1e-16),
        figures(form, 30, 2e-16, (*NATIVE, WITH_LIBM)),
        figures(form, 20, 1e-16, PLAIN),
    )
    told = {one.words: (one.time, one.error) for one in effects([best, libm, plain])}
    assert told == {
        "libm's sine and cosine": (pytest.approx(3), pytest.approx(2)),
        "-O2 instead of what the source recommends": (pytest.approx(2), pytest.approx(1)),
    }


def test_a_choice_is_told_only_where_all_other_factors_agree(form: Formulation) -> None:
    """Fast-math with libm against fast-math without is not an effect of libm; compilers compare at equal flags."""
    gcc, fast_libm, fast = (
        measured(form, flags) for flags in (NATIVE, (*NATIVE, FAST_MATH, WITH_LIBM), (*NATIVE, FAST_MATH))
    )
    clang, numpy = measured(form, NATIVE, "clang", ns=5), measured(form, None)
    told = {one.words: one.time for one in effects([gcc, fast_libm, fast, clang, numpy])}
    assert told == {"-ffast-math, inline sine and cosine": 1.0, "clang instead of gcc": 0.5}


def measured(form: Formulation, flags: tuple[str, ...] | None, compiler: str = "gcc", ns: float = 10) -> Measurement:
    build = None if flags is None else Build((compiler,), flags, DOUBLE)
    u = 2.0**-DOUBLE.bits
    errors = Errors(u, 1e-16 / u, 1e-16 / u, 1.0, 1.0, 100, 0, 1e-16 / u)
    return Measurement(Configuration("inverse_dynamics", form, build, DOUBLE, BATCH), Time(ns, ns), errors)


def test_times_are_of_one_state_and_every_run_has_its_turn() -> None:
    turns: list[str] = []
    runs = [Run(lambda times, name=name: turns.extend([name] * times), 10) for name in ("a", "b")]  # type: ignore[misc]
    runs.append(Run(lambda times: [sum(range(20_000)) for _ in range(times)] and None, 2))
    found = time_runs(runs, rounds=3)
    assert all(0 < time.best <= time.median for time in found)
    changes = sum(one != other for one, other in pairwise(turns))
    assert changes >= 6, "a and b take turns, round by round"


KEYS = {
    "equations", "base", "folded", "angles_summed", "precision", "compiler", "flags", "call", "advisable", "ns",
    "best_ns", "operations", "u", "worst", "bound", "worst_u", "typical_u", "input_effect_u", "judged", "front",
}  # fmt: skip


@pytest.mark.thorough
def test_json_holds_every_point(printed: dict[str, Any]) -> None:
    points = printed["models"]["direct_dynamics"]["points"]
    assert all(set(point) == KEYS for point in points)
    assert {point["precision"] for point in points} == {"double", "single", "mixed"}
    assert {point["call"] for point in points} == {BATCH, SINGLE_CALL}
    assert {point["compiler"] is None for point in points} == {True, False}
    assert any(point["front"] for point in points)
    assert all(point["base"] and point["folded"] for point in points)


@pytest.mark.thorough
def test_errors_are_those_of_the_precision(printed: dict[str, Any]) -> None:
    """No machine of two joints loses half the digits; no rounding is better than a hundredth of a unit."""
    for point in printed["models"]["direct_dynamics"]["points"]:
        assert point["worst"] == pytest.approx(point["worst_u"] * point["u"])
        assert 0.01 * point["u"] < point["worst"] < math.sqrt(point["u"])
        assert point["judged"] == 400


@pytest.mark.thorough
def test_the_commands_that_are_advised_work(
    printed: dict[str, Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    told = printed["advice"]
    assert told["tolerance"] == 1e-10 and told["fastest"]["direct_dynamics"]["precision"] == "double"
    program, *arguments = shlex.split(told["commands"][0])
    assert program == "symoro-elastic"
    CliRunner().invoke(cli, arguments, catch_exceptions=False)
    assert len(told["commands"]) == 2
    subprocess.run(shlex.split(told["commands"][1]), check=True)
    assert Path("planar_2r.o").stat().st_size > 0


@pytest.mark.thorough
def test_the_drift_of_the_state(printed: dict[str, Any]) -> None:
    """N steps round a state N times: half an ulp at random grows as sqrt(N) = 220 units, a compensated sum does not."""
    double, mixed, compensated, single = (one["drift"] for one in printed["drift"])
    assert printed["drift"][0]["steps"] == 50_000
    assert single > 10 * compensated
    assert single > 10 * mixed
    assert mixed > 1e3 * double
    assert double <= 1e-10 * printed["drift"][0]["energy"]


def test_the_drift_where_loops_are_assembled(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Dependent variables follow from step to step: what is left of energy is as small as in closed form."""
    monkeypatch.setattr(drift, "STEPS", 5000)
    described = without_closed_form()
    double, mixed, _, single = drifts(described, parameter_values(described), tmp_path, lambda _done, _total: None)
    assert double.drift <= 1e-10 * double.energy
    assert mixed.drift > 1e3 * double.drift and single.drift > 3 * mixed.drift


@pytest.mark.thorough
def test_a_compensated_sum_keeps_what_rounding_takes(form: Formulation, two_r: Machine, tmp_path: Path) -> None:
    """100 000 changes of a thousandth of an ulp of 1 and less: the plain sum stays, the compensated one arrives."""
    direct, _ = formulations(two_r, Scene(models=("direct_dynamics",)), parameter_values(two_r))
    library = ctypes.CDLL(str(compile_library(render_c(direct[0].package, SINGLE), tmp_path)))
    changes = np.random.default_rng(0).uniform(0, 2.0**-33, (100_000, 3)).astype(np.float32)
    x, lost = np.ones(3, np.float32), np.zeros(3, np.float32)
    advance = library.planar_2r_single_advance
    advance.argtypes = [ctypes.c_size_t, *[ctypes.c_void_p] * 3]
    for change in changes:
        advance(3, x.ctypes.data, lost.ctypes.data, change.ctypes.data)
    exact = [1 + math.fsum(column.tolist()) for column in changes.T]
    assert np.abs(x - exact).max() <= 2.0**-24 and min(exact) > 1 + 2.0**-18
    assert "_advance" not in "".join(render_c(form.package, SINGLE).values()), "only where a state is integrated"


@pytest.mark.thorough
def test_a_machine_without_accelerations_has_no_drift(two_r: Machine, tmp_path: Path) -> None:
    values = parameter_values(two_r) | {"m1": math.nan}
    with pytest.raises(InputError, match="no finite accelerations"):
        drifts(two_r, values, tmp_path, lambda _done, _total: None)


def test_every_form_is_found_and_gives_the_same_results(two_r: Machine) -> None:
    values = parameter_values(two_r)
    written, notes = formulations(two_r, Scene(), values)
    recursions = {(one.base, one.folded) for one in written if one.way == "recursion"}
    assert notes == [] and recursions == {(False, False), (False, True), (True, False), (True, True)}
    assert {one.way for one in written} == {"recursion", "A^-1"}
    states = moderate_states(two_r, 5, values=values)
    qdd = [evaluate_arrays(one.traced["direct_dynamics"], states, one.values, np.float64)["qdd"] for one in written]
    for other in qdd[1:]:
        assert np.allclose(other, qdd[0], rtol=1e-11)


@pytest.mark.thorough
def test_without_a_compiler_there_is_numpy(two_r: Machine, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CC", "no-such-compiler")
    known = trade(two_r, Scene(models=("direct_dynamics",)), Request("quick", states=400, rounds=1))
    assert known.drifts == [] and any("no-such-compiler" in note for note in known.notes)
    assert {one.configuration.build for one in known.measurements["direct_dynamics"]} == {None}
    assert known.advice(1e-9).fastest[0].configuration.made_by == "numpy"


@pytest.mark.thorough
def test_a_flag_that_the_compiler_lacks_is_noted(tmp_path: Path) -> None:
    compiler = tmp_path / "poor"
    compiler.write_text('#!/bin/sh\ncase "$*" in *-ffast-math*) exit 1;; esac\nexec cc "$@"\n')
    compiler.chmod(0o755)
    sets, notes = flag_sets((str(compiler),))
    assert notes == [f"{compiler} has no -ffast-math: builds without it only"]
    assert not any(FAST_MATH in flags for flags in (sets.best, *sets.variants, *sets.every))


def test_a_build_that_fails_is_noted(
    form: Formulation, two_r: Machine, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fails(*_: object) -> Path:
        raise CompilationFailed("gcc: killed")

    monkeypatch.setattr(of_trade, "compile_library", fails)
    jobs = [(form, Build(("gcc",), PLAIN, DOUBLE))]
    states = moderate_states(two_r, 3)
    made, notes = of_trade.compiled_configurations(jobs, states, tmp_path, 60.0, lambda _done, _total: None)
    assert made == [] and notes == ["gcc O2, double: left out, gcc: killed"]
    made, notes = of_trade.compiled_configurations(jobs, states, tmp_path, -1.0, lambda _done, _total: None)
    assert made == [] and "1 of 1 builds left out" in notes[0]


@pytest.mark.thorough
def test_a_machine_on_a_floating_base() -> None:
    """Errors are those of both models, the base's acceleration included; what is not offered is said."""
    machine, _ = read_machine(EXAMPLES / "floating_arm.toml")
    found = trade(machine, Scene(), Request("quick", states=200, rounds=1))
    assert found.notes[-1] == "the base floats: base parameters and the drift of a motion are left out"
    assert found.measurements.keys() == {"direct_dynamics", "inverse_dynamics"} and not found.drifts
    for measurements in found.measurements.values():
        assert {one.configuration.precision.name for one in measurements} >= {"double", "single", "mixed"}
        assert all(0.5 < one.errors.worst < 300 for one in measurements), "units in the last place of each precision"


def test_a_model_that_is_too_large_is_refused(two_r: Machine, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(formulations_of_trade, "MOST_OPERATIONS", 10)
    with pytest.raises(InputError, match=r"operations are more than the 10 .*: ask for one --model"):
        trade(two_r, Scene())


@pytest.mark.parametrize("model", ["inverse_geometric_model", "base_parameters"])
def test_what_is_no_function_of_a_state_is_refused(two_r: Machine, model: str) -> None:
    with pytest.raises(InputError, match=f"{model}: it is not a function of a state"):
        trade(two_r, Scene(models=(model,)))


@pytest.mark.thorough
def test_a_tolerance_out_of_reach_ends_the_command(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CC", "no-such-compiler")
    options = ["--effort=quick", "--states", "4", "--rounds", "1", "--tolerance", "1e-30", "--model", "inertia_matrix"]
    result = CliRunner().invoke(cli, ["benchmark", str(TWO_R), *options])
    assert isinstance(result.exception, InputError) and "nearest is" in str(result.exception)
    assert "ns a state" in result.stdout, "the front is shown all the same"


@pytest.mark.thorough
def test_the_picture(two_r: Machine, form: Formulation, tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    points = [
        figures(form, 20, 1e-16),
        figures(form, 5, 1e-7, precision=SINGLE),
        figures(form, 4, 1.0, (*NATIVE, FAST_MATH)),
    ]
    known = found(two_r, *points, replace(points[0], errors=replace(points[0].errors, worst=math.inf)))
    path, _ = known.plots().save(tmp_path, "svg")
    first = path.read_bytes()
    assert known.plots().save(tmp_path)[0].name == "inverse_dynamics_error_over_time.png", "as all commands draw"
    assert path.name == "inverse_dynamics_error_over_time.svg" and b"<svg" in first
    with permission(force=True):
        assert known.plots().save(tmp_path, "svg")[0].read_bytes() == first


@pytest.mark.thorough
def test_errors_that_are_all_zero_are_drawn(two_r: Machine, form: Formulation, tmp_path: Path) -> None:
    """On a logarithmic scale, which matplotlib warns about where nothing is positive."""
    pytest.importorskip("matplotlib")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        found(two_r, figures(form, 20, 0.0)).plots().save(tmp_path)


def test_static_springs_and_steps_of_a_scene_are_no_models_to_time() -> None:
    """Both add functions to generated code."""
    machine = read_machine(EXAMPLES / "all_keys.toml")[0]
    assert machine.asked.scene and machine.asked.scene.static
    scene = replace(machine.asked.scene, steps=("rk4",))
    found, _ = formulations_of_trade.formulations(machine, scene, parameter_values(machine))
    assert {tuple(one.traced) for one in found} == {("inverse_dynamics", "jacobian")}
