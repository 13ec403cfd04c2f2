"""`reduce`: a tolerance at the tool becomes tolerances of torques and cheaper models, measured by simulation."""

from __future__ import annotations

import json
import shutil
from functools import cache
from pathlib import Path

import numpy as np
import pytest

import symoro_elastic as se
from symoro_elastic.analysis.ladder.feed_forward import (
    PREDICTED_FRACTION,
    FedMeasurement,
    FeedForwardSearch,
    ReducedTorques,
)
from symoro_elastic.analysis.ladder.reduced import Reduced
from symoro_elastic.analysis.ladder.rungs import prediction_of
from symoro_elastic.codegen.embedded.processors import CONTROLLERS, Processor
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.within import Evidence
from tests.analysis.ladder.test_drives import drawn
from tests.command_line import EXAMPLES, refused, run

ARM, MOVE = EXAMPLES / "planar_2r.toml", EXAMPLES / "scenes" / "planar_2r_move.toml"
TWO_AXIS, TWO_AXIS_MOVE = EXAMPLES / "two_axis.toml", EXAMPLES / "scenes" / "two_axis_move.toml"
TO = {"tip.x": 1e-3, "tip.y": 1e-3}
needs_gcc = pytest.mark.skipif(shutil.which("gcc") is None, reason="needs gcc")
LINEAR = 0.1
"""Relative difference of the linear model from a simulation: torques are wrong by 8 % of the largest."""


@cache
def arm() -> Reduced:
    return se.reduce(ARM, MOVE, to=TO, for_="feed-forward")


def test_terms_left_out_cost_at_the_tool_what_is_predicted_and_measured() -> None:
    feed = arm().feed_forward
    assert feed is not None and feed.chosen is not None and feed.chosen.measured is not None
    assert feed.operations < feed.full and arm().is_within and arm().simulation is None
    for name, measured in feed.chosen.measured.items():
        assert measured <= PREDICTED_FRACTION * TO[name]
        assert measured == pytest.approx(feed.chosen.predicted[name], rel=LINEAR)


def test_torque_errors_stay_within_the_scaled_shares_all_over_the_range() -> None:
    """At random states of the range, not those of the search: compared with the numpy code of the full model."""
    feed = arm().feed_forward
    assert feed is not None
    scale = {x.motor: x.share for x in feed.tolerances}
    for one in feed.tried:
        for error in one.model.reduction.errors:
            motor = list(scale)[error.index]
            assert error.tolerance == pytest.approx(one.scale * scale[motor])
            assert error.confident is not None and error.unseen <= error.confident <= error.tolerance


@pytest.mark.thorough
def test_the_scene_is_generated_with_the_operations_that_are_advised(tmp_path: Path) -> None:
    (path,) = arm().write(tmp_path / "reduced.toml")
    generated = se.generate(ARM, scene=path, limits="set-points", out=tmp_path / "out", targets=["numpy"])
    (model,) = generated.reduced
    feed = arm().feed_forward
    assert feed is not None
    assert feed.chosen is not None and model.operations == feed.chosen.model.operations
    with pytest.raises(InputError, match="exists"):
        arm().write(path)


@pytest.mark.thorough
def test_where_constant_torques_are_enough_no_operation_is_left() -> None:
    result = se.reduce(ARM, MOVE, to={"tip.x": 1.0, "tip.y": 1.0}, for_="feed-forward")
    assert result.feed_forward is not None and result.feed_forward.operations == 0
    assert "constant torques are enough" in result.summary()


@pytest.mark.thorough
def test_proven_torque_errors_are_bounded_for_the_whole_range() -> None:
    feed = se.reduce(ARM, MOVE, to=TO, for_="feed-forward", proven=True).feed_forward
    assert feed is not None and feed.chosen is not None
    assert feed.chosen.model.within.guaranteed is Evidence.PROVEN
    assert all(x.bounded is not None and x.bounded <= x.tolerance for x in feed.chosen.model.reduction.errors)


@pytest.mark.thorough
def test_feeding_the_torques_of_the_full_model_changes_nothing() -> None:
    machine = drawn(3)
    tolerance = {"tip.x": 1e-5, "tip.y": 1e-5}
    search = FeedForwardSearch(prediction_of(machine, machine.asked.motions, tolerance), machine)
    measurement = FedMeasurement(search.prediction, search.full)
    reference = search.prediction.references[0]
    same = measurement.errors(lambda motion, t: search.full[motion](*reference.at(t)))
    assert same == {"tip.x": 0.0, "tip.y": 0.0}


@pytest.mark.thorough
@pytest.mark.parametrize("seed", [3, pytest.param(8, marks=pytest.mark.thorough)])
def test_a_constant_torque_error_under_drives_has_the_predicted_effect(seed: int) -> None:
    """A share of each motor in turn, from a ramp on: below the tolerance, and above a hundredth of it."""
    machine = drawn(seed)
    tolerance = {"tip.x": 1e-5, "tip.y": 1e-5}
    search = FeedForwardSearch(prediction_of(machine, machine.asked.motions, tolerance), machine)
    measurement = FedMeasurement(search.prediction, search.full)
    reference = search.prediction.references[0]
    for k, motor in enumerate(search.tolerances):
        error = np.eye(len(search.tolerances))[k] * motor.share

        def torques(motion: int, t: np.ndarray, error: np.ndarray = error) -> np.ndarray:
            ramp = np.clip(t / (0.1 * reference.duration), 0, 1)[:, None]
            return search.full[motion](*reference.at(t)) + ramp * error

        used = search.budget.used_fraction(measurement.errors(torques))
        assert 0.01 < used <= 1


@pytest.mark.thorough
def test_both_purposes_have_one_table_and_two_scenes(tmp_path: Path) -> None:
    result = run(
        *("reduce", str(TWO_AXIS), "--scene", str(TWO_AXIS_MOVE), "--to", "tool.x=5um", "--to", "tool.y=5um"),
        *("--rate", "1kHz", "--save", str(tmp_path / "r.toml")),
    )
    words = " ".join(result.stdout.split())
    assert "torques of all motors may be wrong by motor_x 11.4 N" in words
    assert "simulation springs" in words and "feed-forward 5 terms" in words
    assert "the rigid machine, all springs locked: tool.x" in words
    for name in ("r.toml", "r_feed_forward.toml"):
        assert run("simulate", str(TWO_AXIS), "--scene", str(tmp_path / name)).exit_code == 0


@pytest.mark.thorough
@needs_gcc
@pytest.mark.parametrize("precision", ["double", pytest.param("single", marks=pytest.mark.thorough)])
def test_costs_on_a_processor_are_those_of_the_generated_code(
    precision: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """Of the scenes that it writes, in the precision of the processor's unit; this computer stands for it."""
    monkeypatch.setitem(CONTROLLERS, "cortex-m4", Processor("gcc", "-O1", precision))
    result = se.reduce(ARM, MOVE, to=TO, processor="cortex-m4", only=["terms", "steps"])
    assert result.costs is not None and result.costs.torques is not None and result.costs.step is not None
    simulated, fed = result.write(tmp_path / "r.toml")
    where = {"out": tmp_path, "targets": ["c"], "report": True, "processor": "cortex-m4"}
    (code,) = se.generate(ARM, scene=fed, limits="set-points", precisions=[precision], **where).reports
    (torques,) = [x for x in code.functions if x.name == result.costs.torques.name]
    assert torques.cost == result.costs.torques.cost and torques.cost.instructions
    mixed = {"double": "double", "single": "mixed"}[precision]
    where |= {"fold": "all", "models": ["direct_dynamics"], "force": True}
    (code,) = se.generate(ARM, scene=simulated, precisions=[mixed], **where).reports
    assert result.costs.step.cost in [x.cost for x in code.functions if x.name == result.costs.step.name]
    assert "on cortex-m4: torques in" in result.summary() and "a step at most" in result.summary()
    assert result.as_json()["costs"]["torques"]["instructions"] == torques.cost.instructions


def test_the_compiler_of_a_processor_is_named_where_it_is_missing(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(CONTROLLERS, "cortex-m4", Processor("arm-none-gcc", "", "single"))
    with pytest.raises(InputError, match="processor: there is no program 'arm-none-gcc'"):
        se.reduce(ARM, MOVE, to=TO, processor="cortex-m4")


@pytest.mark.thorough
def test_only_springs_are_left_out_where_only_they_may_be() -> None:
    result = se.reduce(TWO_AXIS, TWO_AXIS_MOVE, only=["springs"])
    assert result.feed_forward is None and result.simulation is not None and result.simulation.budget is not None
    rung = result.simulation.budget.advised.rung
    assert rung.left_out and not rung.zero and not rung.neutral


def test_json_has_the_torque_accuracy_and_the_advice() -> None:
    data = json.loads(json.dumps(arm().as_json()))
    assert {*data["torques"]} == {"shoulder", "elbow"} == {x["motor"] for x in data["torque_tolerances"]}
    assert data["within"] and data["chosen"] == data["feed_forward"] and data["simulation"] is None
    assert data["chosen"]["operations"] < data["chosen"]["operations_whole"] and data["chosen"]["left_out"]
    assert len(data["points"]) > 1 and {*data["points"][0]} == {"for", "left_out", "operations", "error", "evidence"}
    assert {*arm().plots()} == {"feed_forward"} and "N m" in data["advice"]


@pytest.mark.thorough
def test_ctrl_c_keeps_the_best_model_so_far(monkeypatch: pytest.MonkeyPatch) -> None:
    whole = arm().feed_forward
    assert whole is not None
    prediction = prediction_of(se.read(ARM), [x.prescribed for x in whole.references], TO)
    search, scales = FeedForwardSearch(prediction, se.read(ARM)), []

    def reduced(scale: float) -> ReducedTorques:
        scales.append(scale)
        if len(scales) > 1:
            raise KeyboardInterrupt
        return whole.tried[0]

    monkeypatch.setattr(search, "_model", reduced)
    ended = search.run()
    assert len(ended.tried) == 1 and ended.advised == 0
    monkeypatch.setattr(search, "_model", lambda _: (_ for _ in ()).throw(KeyboardInterrupt))
    with pytest.raises(KeyboardInterrupt):
        search.run()


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("--for", "code"), "--for: unknown 'code'"),
        (("--only", "screws"), "--only: unknown 'screws'"),
        (("--to", "tip.x=5kg"), "--to"),
        (("--to", "nose.x=5um"), "nose"),
        (("--processor", "cortex-m"), "--processor: unknown 'cortex-m': choose from cortex-m4"),
    ],
)
def test_wrong_requests_are_refused_by_name(words: tuple[str, ...], message: str) -> None:
    assert message in refused("reduce", str(ARM), "--scene", str(MOVE), *words)


def test_what_nothing_controls_has_no_feed_forward() -> None:
    scene = {"motion": {"duration": 0.3, "moves": [{"motor": "motor_x", "by": 0.01, "in": 0.2}]}}
    with pytest.raises(InputError, match="motors follow exactly"):
        se.reduce(TWO_AXIS, scene, to={"tool.x": 1e-5}, for_="feed-forward")
    with pytest.raises(InputError, match="no tolerance is given"):
        se.reduce(TWO_AXIS, scene)
    with pytest.raises(InputError, match="leave out within"):
        se.reduce(TWO_AXIS, scene | {"scene": {"within": "1 %"}}, to={"tool.x": 1e-5})


@pytest.mark.thorough
def test_a_motor_that_moves_no_output_may_have_any_error(tmp_path: Path) -> None:
    scene = tmp_path / "move.toml"
    move = '[motion]\nduration = 0.3\nmoves = [ { motor = "x_axis", by = 0.05, in = 0.2 } ]\ndrives = true\n'
    scene.write_text(move + '[wanted]\ntolerance = { "tool.x" = "20 um" }\nperiod = 1e-3\n')
    se.new(tmp_path / "slides.toml", axes="X Z", screws="20mm")
    run("tune", tmp_path / "slides.toml", "--save", tmp_path / "tuned.toml")
    done = run("reduce", tmp_path / "tuned.toml", "--scene", scene, "--for", "feed-forward", "--to", "tool.x=20um")
    (row,) = (line.split() for line in done.output.splitlines() if line.split()[:1] == ["z_axis"])
    assert row == ["z_axis", *["any"] * 4, row[-2], "any"] and "inf" not in done.output.split()
