"""One budget: the path from the whole machine to the model that is advised, and the simulations that it must keep."""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from dataclasses import replace
from functools import cache
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from pytest import MonkeyPatch

import symoro_elastic as se
from symoro_elastic.analysis.ladder import rungs
from symoro_elastic.analysis.ladder.budget_path import BudgetPath, LeftOutNumbers
from symoro_elastic.analysis.ladder.predicted_rungs import WHOLE, Prediction
from symoro_elastic.analysis.ladder.rung import PREDICTED_FRACTION, Budget, Expense, PathStep, springs_text
from symoro_elastic.analysis.ladder.rungs import (
    Ladder,
    Measurement,
    SimulatedRung,
    budget_of,
    measured_errors,
    measured_ladder,
    reduced_scene,
)
from symoro_elastic.analysis.ladder.views import advice_on_budget, measured_line, times_line
from symoro_elastic.analysis.simulation.observed import Observer
from symoro_elastic.analysis.simulation.prediction.spring_errors import relative
from symoro_elastic.codegen.precision import MIXED
from symoro_elastic.formats.toml.writing import write_scene
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.foundation.results import Table
from symoro_elastic.machine import scene as request
from symoro_elastic.machine.machine import Machine
from tests.analysis.ladder.motions import moved
from tests.analysis.ladder.scenes import Scene, many
from tests.command_line import EXAMPLES, refused

NOT_TOLD = 1 - PREDICTED_FRACTION
"""Of the tolerance: what the linear model may not tell."""
TWO_AXIS = EXAMPLES / "two_axis.toml"
MOVE = EXAMPLES / "scenes" / "two_axis_move.toml"


@cache
def arm() -> Scene:
    """An elastic arm under servos."""
    return many()["flex4, servos"]()


TOLERANCE = dict.fromkeys(("j4.x", "j4.y", "j4.z"), 1e-5)


@cache
def measurement() -> Measurement:
    return Measurement(Prediction(arm().reference.machine, (arm().reference,), arm().tolerances))


@cache
def found() -> Ladder:
    """The ladder of the arm, and its budget; mixed precision is no faster, whatever else this computer does."""
    candidates = measurement().prediction.rungs()
    climbed = measured_ladder(measurement(), candidates)
    with MonkeyPatch.context() as patch:
        patch.setattr(rungs, "times", lambda *_: (1e-6, 1e-6))
        return replace(climbed, budget=budget_of(measurement(), climbed))


def budget() -> Budget:
    spent = found().budget
    assert spent is not None
    return spent


def is_claimed(measured: Mapping[str, float], step: PathStep, tolerance: Mapping[str, float]) -> bool:
    """Whether measured errors are not above the sum of a path, but for what the linear model may not tell."""
    return all(measured[name] <= step.total[name] + NOT_TOLD * limit for name, limit in tolerance.items())


def refuse_paths_that_turn(path: tuple[PathStep, ...], tolerance: Mapping[str, float]) -> None:
    for before, after in itertools.pairwise(path):
        assert after.steps.cost < before.steps.cost or after.expense is Expense.PRECISION
        assert all(after.total[name] >= before.total[name] for name in tolerance)
    for name, limit in tolerance.items():
        assert all(step.total[name] <= PREDICTED_FRACTION * limit for step in path)


@pytest.mark.thorough
def test_every_step_saves_operations_and_adds_its_error() -> None:
    path = budget().path
    refuse_paths_that_turn(path, TOLERANCE)
    assert path[0].expense is Expense.WHOLE and not path[0].rung.left_out
    model = {
        name: sum(step.added[name] for step in path[1:] if step.expense is not Expense.STEPS) for name in TOLERANCE
    }
    assert path[-1].rung.predicted == pytest.approx(model)
    assert {*path[-1].rung.left_out} == {x for step in path if step.expense is Expense.SPRINGS for x in step.names}
    assert {*path[-1].rung.zero} == {x for step in path if step.expense is Expense.NUMBERS for x in step.names}


@pytest.mark.thorough
def test_every_step_of_the_path_keeps_its_claim_when_it_is_simulated() -> None:
    for step in budget().path:
        assert is_claimed(measured_errors(measurement(), step.rung), step, TOLERANCE)


@pytest.mark.thorough
def test_the_end_is_measured_within_the_tolerance_and_takes_fewer_operations() -> None:
    end = budget().advised
    assert budget().is_within and budget().measured.errors == measured_errors(measurement(), end.rung)
    alone = found().rungs[found().chosen or 0].chosen
    assert alone is not None and budget().saved == pytest.approx(1 - end.steps.cost / alone.cost) and budget().saved > 0
    assert end.steps.operations == measurement().prediction.operations_of(end.rung, end.steps.method)


def test_changes_without_numbers_are_those_of_simulations() -> None:
    """Each by itself and two at once, beside a machine that a file without these numbers describes."""
    prediction = measurement().prediction
    fine = prediction.fine_steps(0)
    _, whole = measurement().simulation(WHOLE, 0).run("w3", fine)
    numbers = LeftOutNumbers(prediction.paths[0])
    sets = [("j4.YZ",), ("j4.XZ",), ("j3.XZ", "j4.YZ"), ("j3.rotor_coupling",)]
    predicted = np.abs(numbers.changes(sets, ())).max(axis=0)
    for names, errors in zip(sets, predicted, strict=True):
        rung = replace(WHOLE, zero=names)
        _, left = SimulatedRung(prediction, rung, 0).run("w3", fine)
        np.testing.assert_allclose(np.abs(left - whole).max(axis=0), errors, rtol=0.03, atol=1e-9)


def test_numbers_that_hold_all_inertia_stay() -> None:
    numbers = LeftOutNumbers(measurement().prediction.paths[0])
    of_last = tuple(name for name in numbers.numbers if name.startswith("j4."))
    assert numbers.has_inertia(("j4.MZ",), ())
    assert not numbers.has_inertia(of_last, ())


def follow_the_known_path(monkeypatch: MonkeyPatch) -> None:
    path = budget().path
    monkeypatch.setattr(rungs, "BudgetPath", lambda *_: SimpleNamespace(run=lambda _: path))


@pytest.mark.thorough
def test_steps_that_a_simulation_does_not_confirm_are_taken_back(monkeypatch: MonkeyPatch) -> None:
    allowed = budget().path[1].rung.model

    def measured(_: Measurement, rung: object, *__: object) -> dict[str, float]:
        return dict.fromkeys(TOLERANCE, 0.0 if getattr(rung, "model", None) == allowed else 1.0)

    follow_the_known_path(monkeypatch)
    monkeypatch.setattr(rungs, "measured_errors", measured)
    monkeypatch.setattr(rungs, "times", lambda *_: (1.0, 1.0))
    again = budget_of(measurement(), found())
    assert again.path == budget().path[:2] and again.dropped == budget().path[2:]
    assert "rejected, because the simulation exceeded the tolerance" in str(again.parts())


@pytest.mark.thorough
def test_mixed_precision_is_the_last_step_where_it_is_faster(monkeypatch: MonkeyPatch) -> None:
    follow_the_known_path(monkeypatch)
    monkeypatch.setattr(rungs, "times", lambda *_: (1e-6, 0.5e-6))
    faster = budget_of(measurement(), found())
    last, before = faster.advised, faster.path[-2]
    assert last.expense is Expense.PRECISION and last.rung == before.rung
    assert all(0 <= last.added[name] < 0.01 * limit for name, limit in TOLERANCE.items())
    assert last.added["j4.x"] > 0
    assert faster.measured.errors == measured_errors(measurement(), last.rung, MIXED)
    assert is_claimed(faster.measured.errors, last, TOLERANCE)
    assert "mixed precision" in advice_on_budget(faster) and times_line(faster).endswith(": mixed precision")
    monkeypatch.setattr(rungs, "times", lambda *_: (1e-6, 0.99e-6))
    same = budget_of(measurement(), found())
    assert same.advised == budget().advised and times_line(same).endswith(": double precision")


@pytest.mark.thorough
def test_the_scene_of_the_end_simulates_within_the_tolerance(tmp_path: Path) -> None:
    """Its own equilibrium at the start: what a user gets of the file."""
    machine, steps = arm().reference.machine, budget().advised.steps
    scene = reduced_scene(found(), machine, request.Scene())
    assert scene.zero == budget().advised.rung.zero and {*scene.static} == {*budget().advised.rung.left_out}
    path = tmp_path / "reduced.toml"
    path.write_text(write_scene(scene, [arm().reference.prescribed]))
    step = arm().reference.duration / steps.steps
    (simulated,) = se.simulate(machine, path, method=steps.method, step=step)
    seen = Observer(simulated.reference.machine, simulated.reference, arm().outputs).outputs(simulated.motion)
    fine = 32 * steps.steps
    _, whole = measurement().simulation(WHOLE, 0).run("w3", fine)
    assert (np.abs(seen - whole[::32]).max(axis=0) <= list(TOLERANCE.values())).all()


@pytest.mark.thorough
@pytest.mark.parametrize("name", ["two_axis, 80 ms, pushed", "flex4, fast", "random 15", "random 20"])
def test_claims_of_other_machines_and_motions_hold(name: str) -> None:
    """Machine tools, an arm, random trees; motors that follow exactly, servos, and forces on the tool."""
    scene = many()[name]()
    prediction = Prediction(scene.reference.machine, (scene.reference,), scene.tolerances)
    path = BudgetPath(prediction, prediction.rungs()).run()
    assert len(path) > 1
    refuse_paths_that_turn(path, scene.tolerances)
    measured = Measurement(prediction)
    for step in (path[0], path[len(path) // 2], path[-1]):
        assert is_claimed(measured_errors(measured, step.rung), step, scene.tolerances)


@pytest.mark.thorough
def test_what_is_said_and_drawn_of_a_budget() -> None:
    spent = budget()
    assert spent.measured is not None and spent.is_within and measured_line(spent).endswith("within the tolerance")
    assert relative(spent.measured.errors_mixed, spent.tolerance) <= 1
    assert {*found().plots()} == {"rungs", "operations", "budget"} and {*spent.plots()} == {"budget"}


@pytest.mark.thorough
def test_what_is_left_out_is_counted_and_springs_are_named() -> None:
    """No names are hidden behind "and 7 more": springs stand in the sentence, parts of drives in the JSON."""
    names = ("x_screw", "yaw", "x.dead_time", "x.lag", "y.lag")
    assert (
        springs_text(names, "quasi-static") == "2 springs quasi-static (x_screw, yaw); 3 lags and dead times left out"
    )
    assert springs_text(names[:1], "locked", named=False) == "1 spring locked"
    last = budget().path[-1]
    step = replace(last, expense=Expense.SPRINGS, names=names, rung=replace(last.rung, left_out=names))
    spent = replace(budget(), path=(*budget().path[:1], step))
    (table,) = (part for part in spent.parts() if isinstance(part, Table))
    assert table.rows[-2][1] == "springs static: 2 springs quasi-static; 3 lags and dead times left out"
    assert spent.as_json()["static"] == list(names) and any("--json" in str(part) for part in spent.parts())


@pytest.mark.thorough
def test_a_budget_takes_the_steps_that_the_ladder_has_predicted(monkeypatch: MonkeyPatch) -> None:
    """They cost most of its time: none of a rung is searched again but for less room; each stage has a name."""
    prediction, calls, stages = measurement().prediction, [0], list[str]()
    rungs = prediction.rungs(announce=stages.append)
    assert stages == ["predict time steps"]
    steps_of = Prediction.steps_of

    def counting(self: Prediction, *given: object, **named: object) -> object:
        calls[0] += 1
        return steps_of(self, *given, **named)  # type: ignore[arg-type]

    monkeypatch.setattr(Prediction, "steps_of", counting)
    path = BudgetPath(prediction, rungs).run()
    assert len(path) > 2 and calls[0] == 1  # the longer steps at the end


def test_tolerances_of_results_are_refused_beside_a_budget(tmp_path: Path) -> None:
    scene = tmp_path / "scene.toml"
    scene.write_text('[scene]\nwithin = { tau = "1 %" }\n' + MOVE.read_text())
    said = refused("ladder", str(TWO_AXIS), "--scene", str(scene), "--budget")
    assert "scene, within: a model that is simulated loses numbers, not terms" in said
    with pytest.raises(InputError, match="leave out within"):
        se.ladder(TWO_AXIS, scene, budget=True)


@pytest.mark.thorough
def test_without_a_budget_there_is_none() -> None:
    assert replace(found(), budget=None).as_json()["budget"] is None and found().as_json()["budget"]["path"]
    assert found().advised == budget().advised.rung


def geared_arm() -> Machine:
    """A planar arm whose rotors are bodies on the arm, before elastic gears; the second one is heavy."""
    joints = [
        {"name": "j1", "kind": "motor", "sigma": 0, "antecedent": 0, "theta": "q1"},
        {"name": "f1", "kind": "elastic", "sigma": 0, "antecedent": 1, "theta": "q2"},
        {"name": "j2", "kind": "motor", "sigma": 0, "antecedent": 2, "theta": "q3", "d": 0.5},
        {"name": "f2", "kind": "elastic", "sigma": 0, "antecedent": 3, "theta": "q4"},
        {"name": "tool", "kind": "fixed", "sigma": 2, "antecedent": 4, "d": 0.4},
    ]
    bodies = {
        "j1": {"mass": 1, "inertia": [0.01, 0, 0, 0.01, 0, 0.02]},
        "f1": {"mass": 6, "center_of_mass": [0.25, 0, 0], "inertia": [0.01, 0, 0, 0.4, 0, 0.4]},
        "j2": {"mass": 1, "inertia": [0.01, 0, 0, 0.01, 0, 0.2]},
        "f2": {"mass": 3, "center_of_mass": [0.2, 0, 0], "inertia": [0.01, 0, 0, 0.2, 0, 0.2]},
    }
    springs = {"f1": {"stiffness": 2e4, "damping": 5}, "f2": {"stiffness": 1e4, "damping": 2}}
    return se.read({"name": "geared", "gravity": [0, 0, -9.81], "joints": joints, "bodies": bodies, "springs": springs})


@pytest.mark.thorough
def test_changes_without_the_coupling_of_rotors_are_those_of_simulations() -> None:
    tolerance = dict.fromkeys(("tool.x", "tool.y"), 1e-4)
    reference = moved(geared_arm(), 0.5, {"j1": (0.6, 0.3), "j2": (0.4, 0.3)})
    prediction = Prediction(reference.machine, (reference,), tolerance)
    measured, names = Measurement(prediction), ("j2.rotor_coupling",)
    predicted = np.abs(LeftOutNumbers(prediction.paths[0]).changes([names], ())).max(axis=0)[0]
    fine = prediction.fine_steps(0)
    _, whole = measured.simulation(WHOLE, 0).run("w3", fine)
    _, left = SimulatedRung(prediction, replace(WHOLE, zero=names), 0).run("w3", fine)
    np.testing.assert_allclose(np.abs(left - whole).max(axis=0), predicted, rtol=0.1)
