"""Vibration tests under drives of the machine file: responses of another program, slopes, fits, wrong entries."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import symoro_elastic as se
from symoro_elastic.measured.vibration_tests.measured import VibrationTest
from symoro_elastic.measured.vibration_tests.predictions import Predictions
from symoro_elastic.measured.vibration_tests.reading import read_tests
from symoro_elastic.measured.vibration_tests.unknowns import sought_of
from tests.benchmarks.updating import CASES, SCREW_DRIVE, driven_responses, labels_of, measured_response
from tests.references.vibrating_tables import with_labels

TABLES = dict(CASES["ball_screw under its drive"].tables)
OUTS, INS = ("table.ax", "nut.ax", "motor.qdd"), ("table.fx", "motor.tau")
PAIRS = [(out, source) for out in OUTS for source in INS]
F = np.geomspace(15, 1500, 60)


@cache
def exact() -> Any:
    """G (f, pairs) of the ball screw under its drive."""
    return driven_responses(TABLES, {}, PAIRS, F)


def under_drives(seed: int) -> VibrationTest:
    rng = np.random.default_rng(seed)
    responses = tuple(measured_response(*pair, F, G, rng) for pair, G in zip(PAIRS, exact().T, strict=True))
    return VibrationTest("on", {}, (), {}, 10, False, responses, drives=("motor",))


@pytest.mark.thorough
def test_responses_are_those_of_another_program_and_slopes_those_of_differences() -> None:
    """Differences of fourth order at 5e-5: 2e-9 of the largest slope of a response."""
    test = under_drives(0)
    sought = sought_of(se.read(TABLES), (), 2.0, 0.0, None, [test])
    asked, x = Predictions(sought, [test]), sought.start
    (found,) = asked.at(x)
    G = np.stack([one.G for one in found.responses], axis=1)
    assert np.abs(G / exact() - 1).max() < 1e-10

    def at(y: Any) -> Any:
        return np.stack([one.G for one in asked.at(y, slopes=False)[0].responses], axis=1)

    slopes = np.stack([one.slopes for one in found.responses], axis=2)
    largest = np.abs(slopes).max(axis=(0, 1))
    for k, along in enumerate(np.eye(len(x))):
        h, two = 5e-5 * along, 1e-4 * along
        by_differences = (8 * (at(x + h) - at(x - h)) - (at(x + two) - at(x - two))) / (12 * 5e-5)
        assert (np.abs(by_differences - slopes[k]) / largest).max() < 1e-8, sought.labels[k]


@pytest.mark.thorough
def test_springs_are_found_under_drives_and_what_hardly_shows_is_not_told() -> None:
    """The encoder's mode is above the band: minima that explain noise by it were 60 standard deviations off."""
    truth, rng = labels_of(CASES["ball_screw"].tables), np.random.default_rng(1004)
    test = under_drives(1004)
    starts = {label: x * 2 ** rng.uniform(-1, 1) for label, x in truth.items()}
    found = se.update(with_labels(TABLES, starts), [test])
    assert found.fit.chi2 < 1.2 and found.notes == ()
    for one in found.estimates:
        assert abs(np.log(one.value / truth[one.unknown.label])) < 4 * one.relative, one.unknown.label
    assert sum(one.verdict == "identified" for one in found.estimates) >= 9
    off = se.update(with_labels(TABLES, starts), [replace(test, drives=())])
    assert off.fit.chi2 > 10 and any("the drives of motor are off" in line for line in off.notes)


@pytest.mark.parametrize(
    ("entry", "said"),
    [
        ('drives = ["mottor"]', "drives: no drive of 'mottor'; did you mean 'motor'?"),
        ('drives = ["all"]\nhold = ["all"]', "drives: motor is under hold, too: remove one of the two"),
        ('drives = ["motor"]\npd = { motor = [1, 2] }', "drives: motor is under pd, too: remove one of the two"),
        ('drives = ["motor", "motor"]', "drives: a motor is given twice: keep one"),
    ],
)
def test_wrong_drives_are_named(entry: str, said: str, tmp_path: Path) -> None:
    (tmp_path / "tests.toml").write_text(f'[[tests]]\nfile = "a.csv"\n{entry}\n', encoding="utf-8")
    with pytest.raises(se.InputError) as error:
        read_tests(tmp_path / "tests.toml", se.read(TABLES))
    assert said in str(error.value)


@pytest.mark.parametrize(
    ("drive", "said"),
    [
        ({"Kp": "tuned"}, 'drives, motor, Kp: is "tuned", which is no number'),
        ({"Kp": "kp / 1e8"}, "drives, motor, Kp: depends on kp, which is sought"),
    ],
)
def test_drives_without_numbers_are_refused(drive: dict[str, Any], said: str) -> None:
    with pytest.raises(se.InputError, match=said):
        se.update(TABLES | {"drives": {"motor": SCREW_DRIVE | drive}}, [under_drives(0)])
