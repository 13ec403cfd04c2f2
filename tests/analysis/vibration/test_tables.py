"""What is said of motions that grow, of repeated frequencies, of states not at rest and of losses that are none."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from symoro_elastic.analysis import vibration
from symoro_elastic.analysis.vibration.comparison import compare
from symoro_elastic.analysis.vibration.feed_forward import feed_forward
from symoro_elastic.analysis.vibration.linearization import linearize
from symoro_elastic.analysis.vibration.modes import modes, sensitivity
from symoro_elastic.analysis.vibration.reference_trajectory import move
from symoro_elastic.analysis.vibration.responses import frequency_response
from symoro_elastic.analysis.vibration.tracking import over_grid
from symoro_elastic.analysis.vibration.views import (
    comparison_conclusion,
    frequencies_table,
    losses_table,
    modes_conclusion,
    modes_table,
    state_lines,
    tracked_conclusion,
    tracked_table,
)
from symoro_elastic.formats import write_machine
from symoro_elastic.foundation.results import Table
from symoro_elastic.machine.machine import Body, Joint, Kind, Machine
from symoro_elastic.numerics.motion.equations_of_motion import EquationsOfMotion
from symoro_elastic.numerics.motion.equilibrium import given_state
from tests.analysis.vibration.machines import WEIGHT, drive, linearized, machine_of, modes_of, slide, spring, twins
from tests.analysis.vibration.test_reduced import arm
from tests.cli.test_vibration_commands import figures
from tests.command_line import run
from tests.compiled_models import cell, vector

GROWS = "0, grows 1.79 1/s"
"""sqrt((m g l - k) / I) of `pole`."""


def pole() -> Machine:
    """A pole on a lift, held upright by a spring that is too weak."""
    body = Body(cell(2), vector(0, "2*0.5", 0), (cell(1.5), cell(0), cell(0), cell(1), cell(0), cell(1.5)))
    upright = Joint("pole", 1, Kind.ELASTIC, 0, "q_pole", alpha=cell("pi/2"), body=body, spring=spring(5))
    return machine_of("pole", slide("lift", 0, Kind.MOTOR, 2), upright, base=WEIGHT)


def text(table: Table) -> str:
    """Heads and rows, a line each."""
    return "\n".join("   ".join(f" {cell} " for cell in row) for row in (table.heads, *table.rows))


def test_a_comparison_says_what_grows() -> None:
    found = compare(pole(), at={"pole": 0.0}, duration=0.1)
    assert text(frequencies_table(found)).count(GROWS) == 2
    said = comparison_conclusion(found)
    assert said.endswith("mode 1 of the full model grows; mode 1 of the reduced model grows")
    figures = found.as_json()
    assert figures["growth"] == {"full": [pytest.approx(np.sqrt((2 * 9.81 * 0.5 - 5) / 1.5))] * 1,
                                 "reduced": figures["growth"]["full"], "rigid": []}  # fmt: skip


def test_modes_over_positions_say_what_grows() -> None:
    found = over_grid(EquationsOfMotion(pole()), {"lift": [0.0, 1.0]}, {"pole": 0.0}, held=["lift"])
    assert text(tracked_table(found)).count(GROWS) == 2
    assert "mode 1 grows at 2 of 2 positions" in tracked_conclusion(found)
    np.testing.assert_array_equal(found.as_json()["growth"], found.growth)
    alone = modes_of(pole(), {"pole": 0.0}, held=["lift"])
    said = "nothing vibrates here: no mode has a frequency above 0 Hz; mode 1 is not a vibration: it grows"
    assert modes_conclusion(alone) == said


def test_slopes_of_a_repeated_frequency_stand_in_no_row_of_their_own() -> None:
    found = modes_of(twins("K1", "K2", parameters={"K1": 1e4, "K2": 1e4}), held=["table"])
    slopes = sensitivity(found, ["K1", "K2"])
    assert slopes.repeated == ((0, 1),)
    for mode in (0, 1):
        np.testing.assert_allclose([row[1:] for row in slopes.strongest(mode, 9)], [[0, 0.5], [0, 0.5]], atol=1e-12)
    first, second = (line for line in text(modes_table(found)).splitlines() if "100%" in line)
    assert "K1 +0.00 to +0.50, K2 +0.00 to +0.50" in first and "see mode 1" in second
    figures = found.as_json()
    assert figures["repeated"] == [[1, 2]]
    assert "is limited by one 50%, other 50% of its strain energy; modes 1 to 2 share one" in figures["conclusion"]


def test_frequencies_of_their_own_keep_their_slopes() -> None:
    found = modes_of(twins(1e4, 2e4), held=["table"])
    slopes = sensitivity(found)
    assert slopes.repeated == () and found.as_json()["repeated"] == []
    assert "one.stiffness +0.50" in text(modes_table(found)) and "see mode" not in text(modes_table(found))
    assert "1 % more one.stiffness raises it by 0.5 %" in modes_conclusion(found)


def test_a_given_state_that_is_not_at_rest_says_so(tmp_path: Path) -> None:
    motion = EquationsOfMotion(machine_of("lift", slide("lift", 0, Kind.MOTOR, 2), base=WEIGHT))
    falling = linearize(motion, given_state(motion, rates={"lift": -3.0}))
    note = "not at rest: qd up to 3 m/s at joint lift, qdd up to 9.81 m/s2 at joint lift"
    assert falling.notes == falling.unrest == (note,)
    assert linearize(motion, given_state(motion, torques={"lift": 2 * 9.81})).notes == ()
    assert linearized(drive()).unrest == ()
    write_machine(replace(drive(), base=WEIGHT), tmp_path / "drive.toml")
    asked = (tmp_path / "drive.toml", "--as-given")
    note = "not at rest: qdd up to 9.81 m/s2 at joint motor"
    assert figures("linearize", *asked)["notes"] == figures("response", *asked, "--band", "1:2:2")["notes"]
    assert note in run("linearize", *asked).stdout and note in run("modes", *asked).stdout
    assert figures("modes", *asked)["state"]["notes"] == [note]


def test_a_swing_does_not_hide_the_first_vibration_of_a_spring() -> None:
    """A pendulum on a free motor, a mass on a spring at its end: both are named, and that the motor is free."""
    body = Body(cell(2), vector(0, "-2*0.5", 0), (cell(1.5), cell(0), cell(0), cell(1), cell(0), cell(1.5)))
    swing = Joint("swing", 0, Kind.MOTOR, 0, "q_swing", alpha=cell("pi/2"), body=body)
    end = slide("end", 1, Kind.ELASTIC, 1, alpha=cell("pi/2"), spring=spring(1e5))
    machine = machine_of("swing", swing, end, base=WEIGHT)
    free = modes_of(machine)
    said = modes_conclusion(free)
    assert "Hz, is limited by gravity and loads" in said
    assert "; the first that springs limit, 50" in said and "Hz, is limited by end (100% of its strain energy)" in said
    assert said.endswith("motors are free here: --hold all holds them")
    held = modes_of(machine, held=["swing"])
    said = modes_conclusion(held)
    assert said.startswith("the first vibration, 50.3") and "gravity" not in said and "free" not in said


def test_torques_and_damping_that_are_rounding_are_zero() -> None:
    found = linearized(replace(drive(), base=WEIGHT))
    tiny = np.array([-1.38778e-17])
    lines = state_lines(replace(found, state=replace(found.state, torques=tiny)))
    assert lines[0].endswith("torques motor 0 N") and "e-17" not in lines[0]
    tiny[0] = -1.5e-3
    assert state_lines(replace(found, state=replace(found.state, torques=tiny)))[0].endswith("torques motor -0.0015 N")
    modal = modes_of(drive(), held=["motor"])
    still = replace(modal, damping_ratios=np.full_like(modal.damping_ratios, -1e-17))
    assert " 0 %" in text(modes_table(still))


@pytest.mark.thorough
def test_rounding_is_no_loss() -> None:
    """Two coaxial joints with rotors that turn with nothing: the reduced model is the full one but for rounding."""
    found = compare(arm(rotor=0.6, axial=0.0), ratios={"motor1": 7.5})
    loss = found.losses[0]
    assert not found.alike and 0 <= loss.reduced[1] <= 1e-12 * loss.full[1]
    assert "the reduced model misses nothing of the torque of motor" in comparison_conclusion(found)
    assert "0 / 0" in text(losses_table(found))
    geared = compare(arm(rotor=0.6, axial=0.0), ratios={"motor2": 7.5})
    assert "the reduced model misses up to 0.0" in comparison_conclusion(geared)
    assert modes(linearized(arm())).frequencies[0] == 0.0


@pytest.mark.thorough
def test_pictures_of_responses_have_names_of_their_own(tmp_path: Path, recwarn: pytest.WarningsRecorder) -> None:
    """Two points of a body give two pictures; a response that is zero is a word in the legend, not a curve."""
    ins = ["one at (0, 1*2, 0).fy", "one at (0, 1/2, 0).fy"]
    linear = linearized(twins(), None, ins, ["one.q", "other.q"], held=["table"])
    response = frequency_response(linear, np.array([1.0, 2.0]))
    written = {path.name for path in response.plots().save(tmp_path)}
    assert written == {"bode_one_at_0_1_2_0_fy.png", "bode_one_at_0_1_2_0_fy_2.png"} and not recwarn.list
    legend = response.plot().axes[0].get_legend().get_texts()
    assert [text.get_text() for text in legend] == ["one.q", "other.q: no response"]


def test_a_bode_plot_has_a_scale_for_each_unit() -> None:
    linear = linearized(drive(), ins=["motor"], outs=["motor.q", "load.z", "load.az"])
    figure = frequency_response(linear, np.array([1.0, 2.0])).plot()
    assert [axis.get_ylabel() for axis in figure.axes] == ["magnitude, um / N", "magnitude, m/s2 / N", "phase, deg"]
    legends = [[text.get_text() for text in axis.get_legend().get_texts()] for axis in figure.axes[:2]]
    assert legends == [["motor.q", "load.z"], ["load.az"]]


def test_a_heat_map_has_numbers_and_no_empty_row() -> None:
    figure = modes_of(drive(m2=6.0)).plot("energies")
    axis = figure.axes[0]
    assert [text.get_text() for text in axis.get_xticklabels()] == ["1: free", "2: 15.92 Hz"]
    assert [text.get_text() for text in axis.get_yticklabels()] == ["strain load", "kinetic motor", "kinetic load"]
    assert {"100%", "67%", "33%"} == {text.get_text() for text in axis.texts}
    assert np.abs(modes_of(drive()).plot("shapes").axes[0].images[0].get_array()).max() == 1.0


def test_a_motor_without_spring_is_never_ahead() -> None:
    stiff = machine_of("stiff", slide("motor", 0, Kind.MOTOR, 2))
    figure = feed_forward(stiff, move(stiff, {}, {"": 0.1}, 0.4, 5)).plot()
    assert [axis.get_ylabel() for axis in figure.axes] == ["reference, m", "torque, N"]


@pytest.mark.thorough
def test_models_that_are_the_same_have_no_column_of_errors() -> None:
    """A rigid machine is its own limit, and one without rotors that turn its own reduced model."""
    rigid, elastic = compare(machine_of("slide", slide("axis", 0, Kind.MOTOR, 2.0)), duration=1.0), compare(drive())
    assert "misses" not in text(losses_table(rigid))
    assert "no joint is elastic, so the rigid limit is the machine itself" in comparison_conclusion(rigid)
    assert "rigid misses" in text(losses_table(elastic)) and "reduced misses" not in text(losses_table(elastic))


@pytest.mark.thorough
def test_the_example_of_the_package_runs(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(Path(__file__).parents[3])
    lines = str(vibration.__doc__).split("\n\n", maxsplit=2)[2]
    names: dict[str, Any] = {}
    exec(lines, names)
    assert names["modal"].frequencies.shape == (11,)
