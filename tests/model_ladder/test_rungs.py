"""The ladder: rungs against simulations of the whole machine, advice, the scene of the rung that is chosen."""

from __future__ import annotations

import itertools
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from pytest import MonkeyPatch

from symoro_elastic.machine.formats import read_machine
from symoro_elastic.machine.formats.toml_writing import write_scene
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.prescribed_motion import Bandwidth, Move, PrescribedMotion
from symoro_elastic.machine.restrict import restricted
from symoro_elastic.machine.scene import Scene
from symoro_elastic.model_ladder import rungs as rungs_module
from symoro_elastic.model_ladder.rungs import Ladder, Measured, ladder
from symoro_elastic.model_ladder.spring_errors import relative
from symoro_elastic.model_ladder.tables import advice, arithmetic_line, ladder_json, reduced_scene
from symoro_elastic.progress import no_progress
from tests.command_line import EXAMPLES, refused, run

TOLERANCE = {"tool.x": 1e-5, "tool.y": 1e-5}
LOCKED = ("bed_yaw", "motor_secondary", "cart_yaw", "cart_x", "sensor_head", "y_chain_1")
TWO_AXIS = EXAMPLES / "two_axis.toml"
SCENE = EXAMPLES / "scenes" / "two_axis_move.toml"


def machine() -> Machine:
    """The two-axis machine with four springs: bed_y, bed_x, cart_y, ram."""
    whole, _ = read_machine(TWO_AXIS)
    return restricted(whole, Scene(locked=dict.fromkeys(LOCKED, Formula.parse(0))))


def motion() -> PrescribedMotion:
    moves = (Move("motor_x", 0.08, 0.0, 0.15), Move("motor_y", 0.05, 0.0, 0.15))
    servo = dict.fromkeys(("motor_x", "motor_y"), Bandwidth(25.0, 0.8))
    return PrescribedMotion(0.2, {"motor_y": 0.1}, moves, servo=servo)


@cache
def found() -> Ladder:
    return ladder(machine(), [motion()], TOLERANCE)


def test_the_chosen_rung_is_measured_within_its_tolerance_and_prediction() -> None:
    assert found().chosen is not None
    rung = found().rungs[found().chosen or 0]
    assert rung.measured is not None and rung.chosen is not None and rung.left_out
    for name, limit in TOLERANCE.items():
        assert rung.measured.model[name] + rung.measured.steps[name] <= limit
        assert rung.measured.model[name] == pytest.approx(rung.predicted[name], rel=0.1, abs=1e-3 * limit)
        assert rung.measured.steps[name] == pytest.approx(rung.chosen.predicted[name], rel=1.0, abs=0.01 * limit)


def test_every_rung_leaves_out_one_spring_more() -> None:
    static = [rung.left_out for rung in found().rungs if not rung.locked]
    assert [len(names) for names in static] == [0, 1, 2, 3, 4]
    assert all({*fewer} < {*more} for fewer, more in itertools.pairwise(static))
    assert [rung.left_out for rung in found().rungs if rung.locked] == [static[-1]]


def test_the_chosen_rung_is_the_cheapest_that_fits() -> None:
    costs = [rung.chosen.cost for rung in found().rungs if rung.chosen]
    chosen = found().rungs[found().chosen or 0].chosen
    assert chosen is not None and chosen.cost == min(costs) and found().saving == found().full.cost / chosen.cost
    assert all((rung.chosen is None) == (relative(rung.predicted, TOLERANCE) > 0.7) for rung in found().rungs)


def test_a_rung_whose_prediction_fails_is_not_chosen(monkeypatch: MonkeyPatch) -> None:
    """Measured errors three times those predicted: the ladder falls back until nothing is left out."""
    measure = rungs_module._Climb._measured

    def wrong(climb: rungs_module._Climb, rung: rungs_module.Rung) -> Measured:
        right = measure(climb, rung)
        return Measured({name: 3 * x for name, x in right.model.items()}, right.steps, right.seconds)

    monkeypatch.setattr(rungs_module._Climb, "_measured", wrong)
    climb = rungs_module._Climb(machine(), found().references, TOLERANCE, None)
    fallen = climb.measured(found().rungs, no_progress)
    assert fallen.distrusted and fallen.chosen != found().chosen and found().chosen in fallen.distrusted
    assert all(max(fallen.rungs[k].predicted.values()) > 0.01 * min(TOLERANCE.values()) for k in fallen.distrusted)


def test_advice_names_what_stays_and_what_follows() -> None:
    sentence = advice(found())
    rung = found().rungs[found().chosen or 0]
    assert sentence.startswith("tool.x within 10 um, tool.y within 10 um over this motion: keep ")
    assert ", ".join(rung.left_out) in sentence and "\n" not in sentence


def test_single_precision_is_enough_where_it_takes_little_of_the_tolerance() -> None:
    assert arithmetic_line(found()).endswith(" to tool.x: mixed precision is enough")
    tight = replace(found(), tolerance=dict.fromkeys(TOLERANCE, 1e-9))
    assert arithmetic_line(tight).endswith(": use double precision")
    assert arithmetic_line(replace(found(), chosen=None)) == ""


def test_advice_where_no_rung_is_good_enough() -> None:
    assert "no rung is good enough; the nearest one, keep every spring, takes" in advice(replace(found(), chosen=None))


def test_the_reduced_scene_is_generated_and_is_the_same_again(tmp_path: Path) -> None:
    scene = reduced_scene(found(), machine(), Scene())
    rung = found().rungs[found().chosen or 0]
    assert tuple(scene.static) == rung.left_out and scene.steps == (rung.chosen.method if rung.chosen else "",)
    path = tmp_path / "reduced.toml"
    path.write_text(write_scene(scene, [motion()]))
    assert run("generate", TWO_AXIS, "--scene", path, "--out", tmp_path).exit_code == 0
    assert f"step_{scene.steps[0]}" in (tmp_path / "two_axis" / "two_axis.h").read_text()


def test_json_has_every_rung() -> None:
    data = ladder_json(found())
    assert len(data["rungs"]) == len(found().rungs) and data["rungs"][data["chosen"]]["verdict"] == "<- chosen"
    assert np.isfinite(data["full"]["operations"])


@pytest.mark.parametrize(
    ("text", "what"),
    [
        ('[wanted]\ntolerance = { "tool.x" = 1e-6 }', "there is no table [motion]"),
        ("[motion]\nduration = 1", "no error is allowed yet"),
    ],
)
def test_what_the_ladder_needs(text: str, what: str, tmp_path: Path) -> None:
    (tmp_path / "scene.toml").write_text(text)
    assert what in refused("ladder", TWO_AXIS, "--scene", tmp_path / "scene.toml")
