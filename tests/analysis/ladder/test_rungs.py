"""The ladder: rungs against simulations of the whole machine, advice, the scene of the rung that is chosen."""

from __future__ import annotations

import itertools
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from pytest import MonkeyPatch

from symoro_elastic.analysis.ladder.rung import Measured, Rung
from symoro_elastic.analysis.ladder.rungs import (
    Ladder,
    Measurement,
    ladder_of_prediction,
    measured_ladder,
    prediction_of,
    reduced_scene,
)
from symoro_elastic.analysis.ladder.views import advice, arithmetic_line, springs_table
from symoro_elastic.analysis.simulation.prediction.path import linear_path
from symoro_elastic.analysis.simulation.prediction.spring_errors import Deviations, relative, spring_errors
from symoro_elastic.analysis.simulation.reference_motion import reference_of
from symoro_elastic.formats import read_machine
from symoro_elastic.formats.toml import reading as toml
from symoro_elastic.formats.toml.writing import write_scene
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.prescribed_motion import AppliedForce, Bandwidth, Move, PrescribedMotion
from symoro_elastic.machine.restrict import restrict
from symoro_elastic.machine.scene import Scene
from tests.command_line import EXAMPLES, refused, run

TOLERANCE = {"tool.x": 1e-5, "tool.y": 1e-5}
LOCKED = ("bed_yaw", "motor_secondary", "cart_yaw", "cart_x", "sensor_head", "y_chain_1")
TWO_AXIS = EXAMPLES / "two_axis.toml"
SCENE = EXAMPLES / "scenes" / "two_axis_move.toml"


def machine() -> Machine:
    """The two-axis machine with four springs: bed_y, bed_x, cart_y, ram."""
    whole, _ = read_machine(TWO_AXIS)
    return restrict(whole, Scene(locked=dict.fromkeys(LOCKED, Formula.parse(0))))


def motion() -> PrescribedMotion:
    moves = (Move("motor_x", 0.08, 0.0, 0.15), Move("motor_y", 0.05, 0.0, 0.15))
    servo = dict.fromkeys(("motor_x", "motor_y"), Bandwidth(25.0, 0.8))
    return PrescribedMotion(0.2, {"motor_y": 0.1}, moves, servo=servo)


@cache
def measurement() -> Measurement:
    """The measurement of `ladder`: its compiled rungs serve more than one test."""
    return Measurement(prediction_of(machine(), [motion()], TOLERANCE))


@cache
def found() -> Ladder:
    return measured_ladder(measurement(), measurement().prediction.rungs())


@pytest.mark.thorough
def test_the_chosen_rung_is_measured_within_its_tolerance_and_prediction() -> None:
    assert found().chosen is not None
    rung = found().rungs[found().chosen or 0]
    assert rung.measured is not None and rung.chosen is not None and rung.left_out
    for name, limit in TOLERANCE.items():
        assert rung.measured.model[name] + rung.measured.steps[name] <= limit
        assert rung.measured.model[name] == pytest.approx(rung.predicted[name], rel=0.1, abs=1e-3 * limit)
        assert rung.measured.steps[name] == pytest.approx(rung.chosen.predicted[name], rel=1.0, abs=0.01 * limit)


@pytest.mark.thorough
def test_every_rung_leaves_out_one_spring_more() -> None:
    static = [rung.left_out for rung in found().rungs if not rung.locked]
    assert [len(names) for names in static] == [0, 1, 2, 3, 4]
    assert all({*fewer} < {*more} for fewer, more in itertools.pairwise(static))
    assert [rung.left_out for rung in found().rungs if rung.locked] == [static[-1]]


@pytest.mark.thorough
def test_the_chosen_rung_is_the_cheapest_that_fits() -> None:
    costs = [rung.chosen.cost for rung in found().rungs if rung.chosen]
    chosen = found().rungs[found().chosen or 0].chosen
    assert chosen is not None and chosen.cost == min(costs) and found().saving == found().full.cost / chosen.cost
    assert all((rung.chosen is None) == (relative(rung.predicted, TOLERANCE) > 0.7) for rung in found().rungs)


@pytest.mark.thorough
def test_a_rung_whose_prediction_fails_is_not_chosen(monkeypatch: MonkeyPatch) -> None:
    """Measured errors three times those predicted: the ladder falls back until nothing is left out."""
    right_ladder, measure = found(), Measurement.errors

    def wrong(measurement: Measurement, rung: Rung) -> Measured:
        right = measure(measurement, rung)
        return Measured({name: 3 * x for name, x in right.model.items()}, right.steps, right.seconds)

    monkeypatch.setattr(Measurement, "errors", wrong)
    fallen = measured_ladder(measurement(), right_ladder.rungs)
    assert fallen.distrusted and fallen.chosen != right_ladder.chosen and right_ladder.chosen in fallen.distrusted
    assert all(max(fallen.rungs[k].predicted.values()) > 0.01 * min(TOLERANCE.values()) for k in fallen.distrusted)


@pytest.mark.thorough
def test_advice_names_what_stays_and_what_follows() -> None:
    sentence = advice(found())
    rung = found().rungs[found().chosen or 0]
    assert sentence.startswith("tool.x within 10 um, tool.y within 10 um over this motion: keep ")
    assert ", ".join(rung.left_out) in sentence and "\n" not in sentence


@pytest.mark.thorough
def test_single_precision_is_enough_where_it_takes_little_of_the_tolerance() -> None:
    assert arithmetic_line(found()).endswith(" to tool.x: mixed precision is enough")
    tight = replace(found(), tolerance=dict.fromkeys(TOLERANCE, 1e-9))
    assert arithmetic_line(tight).endswith(": use double precision")
    assert arithmetic_line(replace(found(), chosen=None)) == ""


def test_advice_where_no_rung_is_good_enough() -> None:
    assert "no rung is good enough; the closest, keep every spring, uses" in advice(replace(found(), chosen=None))


def test_advice_says_that_steps_are_not_good_enough() -> None:
    """The model of the whole machine takes nothing of the tolerance; its steps take twelve times what was predicted."""
    rung = found().rungs[0]
    assert rung.chosen is not None
    predicted, measured = (dict.fromkeys(TOLERANCE, x) for x in (1e-6, 1.2e-5))
    chosen = replace(rung.chosen, predicted=predicted)
    missed = replace(rung, chosen=chosen, measured=Measured(dict.fromkeys(TOLERANCE, 0.0), measured, 0.0))
    said = f"its {chosen.steps} steps of {chosen.method} use 120% where 10% were predicted"
    assert said in advice(replace(found(), rungs=(missed, *found().rungs[1:]), chosen=None))


def test_advice_leaves_out_a_saving_that_is_none() -> None:
    rung = found().rungs[found().chosen or 0]
    assert rung.chosen is not None and "times fewer operations" in advice(found())
    for part, told in ((1.0, False), (1.04, False), (1.06, True)):
        full = replace(found().full, steps=round(part * 1e6), operations=rung.chosen.cost)
        slow = replace(rung, chosen=replace(rung.chosen, steps=10**6, operations=rung.chosen.cost))
        rungs = (*found().rungs[: found().chosen], slow, *found().rungs[(found().chosen or 0) + 1 :])
        assert ("times fewer operations" in advice(replace(found(), rungs=rungs, full=full))) is told


@pytest.mark.thorough
def test_the_reduced_scene_is_generated_and_is_the_same_again(tmp_path: Path) -> None:
    scene = reduced_scene(found(), machine(), Scene())
    rung = found().rungs[found().chosen or 0]
    assert tuple(scene.static) == rung.left_out and scene.steps == (rung.chosen.method if rung.chosen else "",)
    path = tmp_path / "reduced.toml"
    path.write_text(write_scene(scene, [motion()]))
    assert run("generate", TWO_AXIS, "--scene", path, "--out", tmp_path).exit_code == 0
    assert f"step_{scene.steps[0]}" in (tmp_path / "two_axis" / "two_axis.h").read_text()


def test_springs_are_listed_with_what_is_usually_asked_of_them() -> None:
    """In the table and as data; none of it is the order of the rungs."""
    data = found().as_json()["springs"]
    assert [one["name"] for one in data] == [
        joint.name for joint in found().machine.independent_joints if joint.kind == "elastic"
    ]
    first = {rung.left_out[0]: rung for rung in found().rungs if len(rung.left_out) == 1}
    ((name, rung),) = first.items()
    alone = next(one for one in data if one["name"] == name)
    assert alone["alone"] == pytest.approx(relative(rung.predicted, TOLERANCE))
    assert len(springs_table(found()).rows) == len(data)


SERIES = """
joints = [
  { name = "motor", kind = "motor", sigma = 1, r = "q1" },
  { name = "first", kind = "elastic", sigma = 1, r = "q2" },
  { name = "last", kind = "elastic", sigma = 1, r = "q3" },
  { name = "arm", kind = "elastic", sigma = 0, alpha = "pi/2", theta = "q4" },
  { name = "tip", kind = "fixed", d = 0.3 },
]
[bodies]
motor = { mass = 2 }
first = { mass = MIDDLE }
last = { mass = 3 }
arm = { mass = 1, center_of_mass = [0.2, 0, 0], inertia = [0, 0.01, 0.01] }
[springs]
first = { stiffness = 6e5 }
last = { stiffness = 3e5 }
arm = { stiffness = 800 }
"""
PUSHED = PrescribedMotion(0.2, {}, (Move("motor", 0.05, 0.0, 0.1),), source="scene.toml")


def in_series(middle: float = 0.0) -> Machine:
    return toml.read(SERIES.replace("MIDDLE", repr(middle)), "series.toml")


@cache
def joined_ladder(*forces: AppliedForce) -> Ladder:
    return ladder_of_prediction(prediction_of(in_series(), [replace(PUSHED, forces=forces)], {"tip.z": 5e-4}))


@pytest.mark.thorough
def test_forces_on_frames_are_measured_too() -> None:
    """The tip is pushed: springs bend by it, static ones too; the model errs as predicted, which is not as without."""
    push = AppliedForce("tip", (30.0, 0.0, 400.0, 0.0, 0.0, 0.0), 0.05, 0.05)
    pushed, free = joined_ladder(push), joined_ladder()
    assert [rung.left_out for rung in pushed.rungs[:2]] == [(), ("last",)] and not pushed.distrusted
    measured = pushed.rungs[1].measured
    assert measured is not None
    assert measured.model["tip.z"] == pytest.approx(pushed.rungs[1].predicted["tip.z"], rel=0.02)
    each = zip(pushed.rungs[1:], free.rungs[1:], strict=True)
    assert all(one.predicted["tip.z"] != pytest.approx(other.predicted["tip.z"], rel=0.02) for one, other in each)
    assert reduced_scene(pushed, in_series(), Scene()).forces == ("tip",)


def test_springs_in_series_are_condensed() -> None:
    """Rungs are those of the machine with one spring; a gram between the two changes the measured error by little."""
    joined = joined_ladder()
    assert joined.condensed == (
        "first and last are in series: last is last + first with k1 k2/(k1 + k2), first is fixed",
    )
    assert joined.rungs[0].left_out == ()
    assert reduced_scene(joined, in_series(), Scene()).condense and joined.as_json()["condensed"]
    rung = next(rung for rung in joined.rungs if rung.left_out == ("last",))
    assert rung.predicted["tip.z"] > 1e-6
    apart = linear_path(reference_of(in_series(1e-3), PUSHED), ("tip.z",), 3200)
    (both,) = spring_errors([Deviations(apart)], [tuple(map(apart.joints.index, ("first", "last")))])
    assert both.static["tip.z"] == pytest.approx(rung.predicted["tip.z"], rel=0.02)
    assert rung.measured is not None
    assert rung.measured.model["tip.z"] == pytest.approx(rung.predicted["tip.z"], rel=0.02)


@pytest.mark.parametrize(
    ("motion", "tolerance", "said"),
    [
        (
            PUSHED,
            {"last.q": 1e-6},
            "wanted, tolerance: last.q belongs to two springs in series, which are merged: leave it",
        ),
        (PUSHED, {"first.z": 1e-6}, "wanted, tolerance: first.z belongs to two springs in series"),
        (replace(PUSHED, start={"first": 0.0}), {"tip.z": 1e-6}, "start, first: first is one of two springs in series"),
        (
            replace(PUSHED, forces=(AppliedForce("first", (1.0, *[0.0] * 5), 0.0, 0.1),)),
            {"tip.z": 1e-6},
            "forces 1, at: first is between two springs in series",
        ),
    ],
)
def test_what_condensing_changes_is_refused(motion: PrescribedMotion, tolerance: dict[str, float], said: str) -> None:
    with pytest.raises(InputError, match=said):
        ladder_of_prediction(prediction_of(in_series(), [motion], tolerance))


def test_json_has_every_rung() -> None:
    data = found().as_json()
    assert len(data["rungs"]) == len(found().rungs) and data["rungs"][data["chosen"]]["verdict"] == "<- chosen"
    assert np.isfinite(data["full"]["operations"])


@pytest.mark.parametrize(
    ("text", "what"),
    [
        ('[wanted]\ntolerance = { "tool.x" = 1e-6 }', "missing: write a table [motion]"),
        ("[motion]\nduration = 1", "no tolerance is given"),
    ],
)
def test_what_the_ladder_needs(text: str, what: str, tmp_path: Path) -> None:
    (tmp_path / "scene.toml").write_text(text)
    assert what in refused("ladder", TWO_AXIS, "--scene", tmp_path / "scene.toml")


def test_tolerances_below_rounding_are_refused_before_any_work(tmp_path: Path) -> None:
    text = SCENE.read_text().replace("tolerance = 10e-6", "tolerance = 1e-18")
    (tmp_path / "scene.toml").write_text(text)
    said = "scene.toml: wanted, tolerance, tool.x: 1e-18 is below rounding"
    for command in ("ladder", "simulate"):
        assert said in refused(command, TWO_AXIS, "--scene", tmp_path / "scene.toml")


@pytest.mark.parametrize("box", ["motor_y=0.3:0", "motor_y=-0.1"])
def test_ranges_of_starts_that_are_reversed_are_refused(box: str) -> None:
    line = refused("ladder", TWO_AXIS, "--scene", SCENE, "--box", box)
    assert "--box: motor_y=" in line and line.endswith("is not a range: give finite LOW:HIGH, LOW first")


@pytest.mark.thorough
def test_springs_that_a_scene_has_static_stay_static() -> None:
    """The whole machine is that of the scene then; rungs leave out more springs, and are measured as predicted."""
    static = restrict(in_series(), Scene(static={"arm": None}, condense=True))
    found = ladder_of_prediction(prediction_of(static, [PUSHED], {"tip.z": 5e-4}))
    assert [rung.left_out for rung in found.rungs if not rung.locked] == [(), ("last",)] and not found.distrusted
    assert found.chosen is not None and found.rungs[found.chosen].measured is not None
