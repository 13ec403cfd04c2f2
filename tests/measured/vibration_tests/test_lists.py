"""Lists of tests that are wrong are refused by the mistake that explains the tests; right lists are not accused."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest

import symoro_elastic as se
from symoro_elastic.measured.vibration_tests.listed_tests import ListedTests
from symoro_elastic.measured.vibration_tests.measured import VibrationTest
from tests.benchmarks import updating
from tests.benchmarks.updating import CASES, exact_responses, labels_of, measured
from tests.references.vibrating_tables import with_labels

Wrong = Callable[[VibrationTest], VibrationTest]


@cache
def exact(name: str) -> list[Any]:
    return exact_responses(CASES[name])


def right_tests(name: str, seed: int = 0) -> tuple[dict[str, Any], list[VibrationTest]]:
    """A start off by up to two, and right tests."""
    rng = np.random.default_rng(seed)
    found = measured(CASES[name], exact(name), rng)
    off = {label: x * 2 ** rng.uniform(-1, 1) for label, x in labels_of(CASES[name].tables).items()}
    return with_labels(CASES[name].tables, off), found


def at(**changed: float) -> Wrong:
    return lambda test: replace(test, at={**test.at, **changed})


def called(name: str, other: str) -> Wrong:
    """Outputs and inputs of a name are listed as others."""

    def of(test: VibrationTest) -> VibrationTest:
        responses = [
            replace(
                one, output=other if one.output == name else one.output, input=other if one.input == name else one.input
            )
            for one in test.responses
        ]
        return replace(test, responses=tuple(responses))

    return of


def held(*motors: str) -> Wrong:
    return lambda test: replace(test, hold=motors)


DEGREES = 180 / math.pi
QUICK = [
    ("lathe", at(slide_x=-0.05), "at: slide_x has the opposite sign"),
    ("lathe", called("tool.fx", "tool.mx"), "tool.mx is tool.fx"),
    ("ball_screw", called("screw.wdx", "screw.wdy"), "screw.wdy is screw.wdx"),
]
LONGER = [
    ("gantry", held("cross_slide"), "hold: cross_slide was free"),
    ("lathe", at(slide_x=50.0), "at: slide_x is in mm, not m"),
    ("lathe", called("bed_lift.az", "bed_lift.ax"), "bed_lift.ax is bed_lift.az"),
    ("lathe", held(), "hold: slide_z, slide_x were held"),
    ("gantry", at(cross_slide=0.0), "at: the zero of cross_slide is off: add 0.4"),
    ("milling arm", at(shoulder=0.7), "at: shoulder has the opposite sign"),
    (
        "milling arm",
        at(base=0.3 * DEGREES, shoulder=-0.7 * DEGREES, elbow=1.1 * DEGREES),
        "at: base, shoulder, elbow are in degrees",
    ),
    ("milling arm", at(shoulder=1.1, elbow=-0.7), "at: shoulder and elbow are exchanged"),
]


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("name", "wrong", "said"), [*QUICK, *(pytest.param(*one, marks=pytest.mark.thorough) for one in LONGER)]
)
def test_a_wrong_list_is_refused_by_its_mistake(name: str, wrong: Wrong, said: str) -> None:
    """Responses of an arm whose shoulder has the opposite sign look as if they were in another unit."""
    tables, right = right_tests(name)
    with pytest.raises(se.InputError) as error:
        se.update(tables, [wrong(test) for test in right])
    assert said in str(error.value) and "the model explains the tests only with this corrected" in str(error.value)


@pytest.mark.thorough
@pytest.mark.parametrize("mode_at", [pytest.param(70.0, marks=pytest.mark.thorough), 1.3 * CASES["lathe"].band[1]])
def test_a_right_list_is_not_accused(mode_at: float) -> None:
    """What the model lacks is no mistake of the list."""
    tables, _ = right_tests("lathe")
    tests = updating.measured(CASES["lathe"], exact("lathe"), np.random.default_rng(1), mode_at=mode_at)
    found = se.update(tables, tests)
    assert found.fit.chi2_alone > found.fit.far or found.fit.chi2 > found.fit.far


def changes(found: Sequence[Any]) -> set[str]:
    return {row.name for row in found}


@pytest.mark.thorough
def test_lists_are_changed_in_all_tests_and_in_each() -> None:
    tables, right = right_tests("two_axis")
    listed = ListedTests(se.read(tables), right)
    mirrored = [row for row in listed.positions() if row.name == "at: motor_x has the opposite sign"]
    assert [row.changed for row in mirrored] == [(0, 1), (0,), (1,)]
    assert mirrored[1].data[0].at["motor_x"] == -right[0].at["motor_x"] and mirrored[1].data[1] is right[1]
    assert "at: the positions of these two are exchanged" in changes(listed.positions())
    assert {"hold: motor_x was free", "hold: motor_x, motor_y were under a servo"} <= changes(listed.motors_held())
    names = changes(listed.signals())
    assert {"tool.fx is tool.mz", "tool.fx is -ram.fx", "cart_y.ax is cart_y.wdy"} <= names
