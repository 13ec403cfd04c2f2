"""Scenes that the linear model along a motion does not hold for are refused in one line."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from symoro_elastic.analysis.simulation.adaptive import simulate_adaptively
from symoro_elastic.analysis.simulation.prediction.path import linear_path, refuse_coupled
from symoro_elastic.analysis.simulation.prediction.resolution import is_resolved, resolved_path
from symoro_elastic.analysis.simulation.prediction.spring_errors import Deviations
from symoro_elastic.analysis.simulation.reference_motion import reference_of
from symoro_elastic.analysis.simulation.simulate import Request, simulate
from symoro_elastic.formats import read_machine
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.machine import Friction, Machine
from symoro_elastic.machine.prescribed_motion import PrescribedMotion, Wobble
from tests.analysis.ladder.motions import moved
from tests.analysis.vibration.machines import drive
from tests.command_line import EXAMPLES
from tests.compiled_models import cell

MOVE = {"motor": (0.1, 0.5)}


def example(name: str) -> Machine:
    return read_machine(EXAMPLES / name)[0]


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("four_bar.par", r"four_bar\.par: loop \w+: the ladder does not handle loops: use simulate"),
        (
            "ball_screw.toml",
            r"ball_screw\.toml: joint \w+: it follows .*, and has a variable, which the ladder does not handle: use",
        ),
    ],
)
def test_joints_that_depend_on_others(name: str, said: str) -> None:
    with pytest.raises(InputError, match=said):
        refuse_coupled(example(name))


def test_dry_friction_without_a_motor() -> None:
    machine = drive()
    motor, load = machine.joints
    rubbing = replace(machine, joints=(motor, replace(load, friction=Friction(cell(0), cell(2)))))
    with pytest.raises(InputError, match=r"drive\.toml: friction: load has no motor, so dry friction holds it .*creep"):
        linear_path(moved(rubbing, 0.5, MOVE), ("load.z",))


def test_no_inertia() -> None:
    with pytest.raises(InputError, match=r"drive\.toml: inertia matrix: singular here: nothing has inertia|load"):
        linear_path(moved(drive(m2=0.0), 0.5, MOVE), ("load.z",))


def test_torques_that_are_no_numbers() -> None:
    said = r"drive\.toml: motion: the torques of the reference are not numbers at 0"
    near = moved(drive(), 0.5, MOVE)
    far = replace(near, start=replace(near.start, q=np.full_like(near.start.q, 1e308)))
    with np.errstate(all="ignore"), pytest.raises(InputError, match=said):
        linear_path(far, ("load.z",))


def test_unknown_outputs() -> None:
    with pytest.raises(InputError, match=r"drive\.toml: --output: 'lod\.z': no frame 'lod'; did you mean 'load'"):
        linear_path(moved(drive(), 0.5, MOVE), ("lod.z",))


def test_samples_are_doubled_until_they_tell_the_vibrations() -> None:
    """A spring of 630 Hz that a short move shakes, undamped; the amplitude is that in closed form."""
    reference = moved(drive(m2=5.0, k=8e7), 0.8, {"motor": (1e-3, 1.6e-2)})
    tolerance = {"load.z": 1e-9}
    coarse = linear_path(reference, tuple(tolerance))
    assert not is_resolved(coarse, tolerance)
    path = resolved_path(reference, tolerance)
    assert len(path.t) > len(coarse.t)
    w, t = np.sqrt(8e7 / 5.0), np.linspace(0.0, 1.6e-2, 20001)
    acceleration = reference.at(t)[2][:, 0]
    swing = abs((acceleration * np.exp(-1j * w * t)).sum() * t[1]) / w
    after = Deviations(path).outputs[path.t > 1.7e-2]
    assert np.abs(after).max() == pytest.approx(swing, rel=0.1)


def test_motions_too_long_for_what_happens_in_them(monkeypatch: pytest.MonkeyPatch) -> None:
    """A move that no sample would meet, and vibrations that need more samples than there may be."""
    said = "motion, duration: .* s are too long for the short moves or vibrations in it: shorten it"
    with pytest.raises(InputError, match=said):
        resolved_path(moved(drive(), 50.0, {"motor": (1e-3, 2e-3)}), {"load.z": 1e-6})
    monkeypatch.setattr("symoro_elastic.analysis.simulation.prediction.resolution.MOST_SAMPLES", 1600)
    with pytest.raises(InputError, match=said):
        resolved_path(moved(drive(m2=5.0, k=8e7), 0.8, {"motor": (1e-3, 1.6e-2)}), {"load.z": 1e-9})


def test_a_wobble_of_too_many_periods_is_refused_before_any_step() -> None:
    """2.5 million periods, 20 steps each."""
    wobble = Wobble("motor", 1e-9, 1e7)
    reference = reference_of(drive(), PrescribedMotion(0.25, wobbles=(wobble,)))
    said = "motion, duration: its shortest .* lasts 1e-07 s: 5e.07 steps, some 0.014 h, 5e.06 is the limit"
    with pytest.raises(InputError, match=said):
        simulate(reference, Request())
    with pytest.raises(InputError, match=said):
        simulate_adaptively(reference, Request(), {})
