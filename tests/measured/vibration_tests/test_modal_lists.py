"""Lists of modes that are wrong are named by the mistake that explains them; right ones are not accused."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import symoro_elastic as se
from symoro_elastic.measured.vibration_tests.measured import MeasuredModes, VibrationTest
from tests.benchmarks.updating import CASES, exact_responses, labels_of, measured
from tests.measured.vibration_tests.files import LIST, listed, write_csv
from tests.references.vibrating_tables import VibratingTables, with_labels

LATHE = CASES["lathe"]
HELD = ("slide_z", "slide_x")
POSITIONS = ({"slide_z": 0.1, "slide_x": 0.05}, {"slide_z": 0.3, "slide_x": 0.2})
OUTPUTS = ("tool.ax", "tool.ay", "tool.az", "saddle.ax", "bed_lift.az", "turret.ay")
Wrong = Callable[[MeasuredModes], MeasuredModes]


def start(seed: int = 0) -> dict[str, Any]:
    """The lathe, values off by up to a factor 2."""
    rng, truth = np.random.default_rng(seed), labels_of(LATHE.tables)
    return with_labels(LATHE.tables, {label: x * 2 ** rng.uniform(-1, 1) for label, x in truth.items()})


def right(count: int = 1, shapes: bool = True, seed: int = 0) -> list[VibrationTest]:
    """Lists of modes by another program: noise of 0.1 % of frequencies, 5 % of damping ratios, 3 % of shapes."""
    rng, truth, tests = np.random.default_rng(seed), VibratingTables(LATHE.tables), []
    for k, at in enumerate(POSITIONS[:count]):
        f, zeta, amplitudes = truth.mode_shapes(at, HELD, OUTPUTS)
        f, zeta = f * (1 + 1e-3 * rng.normal(size=len(f))), zeta * (1 + 0.05 * rng.normal(size=len(f)))
        amplitudes = amplitudes + 0.03 * (rng.normal(size=amplitudes.shape) + 1j * rng.normal(size=amplitudes.shape))
        more = (OUTPUTS, amplitudes) if shapes else ((), None)
        modes = MeasuredModes(f, zeta, 1e-3 * f, 0.05 * zeta, *more)
        tests.append(VibrationTest(f"modal {k + 1}", at, HELD, modes=modes))
    return tests


def wrong(tests: list[VibrationTest], of: Wrong) -> list[VibrationTest]:
    """Tests whose first list of modes is wrong."""
    (first, *others) = tests
    return [replace(first, modes=None if first.modes is None else of(first.modes)), *others]


def times(f: float = 1.0, zeta: float = 1.0) -> Wrong:
    return lambda x: replace(x, f=f * x.f, std_f=f * x.std_f, zeta=zeta * x.zeta, std_zeta=zeta * x.std_zeta)


def exchanged(a: int, b: int) -> Wrong:
    order = [{a: b, b: a}.get(k, k) for k in range(len(OUTPUTS))]
    return lambda x: replace(x, shapes=x.shapes[:, order])


def mirrored(column: int) -> Wrong:
    return lambda x: replace(x, shapes=x.shapes * np.where(np.arange(len(OUTPUTS)) == column, -1, 1))


def called(name: str, other: str) -> Wrong:
    return lambda x: replace(x, outputs=tuple(other if one == name else one for one in x.outputs))


def doubled(k: int) -> Wrong:
    """A mode is there twice, 0.3 % apart."""

    def of(x: MeasuredModes) -> MeasuredModes:
        zeta, std_f, std_zeta, shapes = (np.insert(y, k, y[k], axis=0) for y in (x.zeta, x.std_f, x.std_zeta, x.shapes))
        return MeasuredModes(np.insert(x.f, k, 0.997 * x.f[k]), zeta, std_f, std_zeta, x.outputs, shapes)

    return of


REFUSED = [(exchanged(0, 1), "tool.ax and tool.ay are exchanged")]
LONGER = [
    (times(f=2 * math.pi), "frequencies are in rad/s, not in Hz"),
    (times(f=60.0), "frequencies are in turns a minute, not in Hz"),
    (times(f=1e-3), "frequencies are in kHz, or times in ms, and are called Hz and s"),
    (exchanged(0, 4), "tool.ax and bed_lift.az are exchanged"),
    (called("tool.az", "tool.wdx"), "tool.wdx is tool.az"),
]


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("of", "said"), [*REFUSED, *(pytest.param(*one, marks=pytest.mark.thorough) for one in LONGER)]
)
def test_a_wrong_list_of_modes_is_refused_by_its_mistake(of: Wrong, said: str) -> None:
    with pytest.raises(se.InputError) as error:
        se.update(start(), wrong(right(), of))
    line = str(error.value)
    assert (
        line.startswith("modal 1: modes: ")
        and said in line
        and "the model explains them only with this corrected" in line
    )


@pytest.mark.thorough
def test_a_mode_that_is_there_twice_is_named() -> None:
    """Both of the pair, for nothing tells which is the right one."""
    found = se.update(start(), wrong(right(), doubled(1)))
    (line,) = (line for line in found.notes if "is there twice" in line)
    assert line.startswith("modal 1: modes: mode ") and "mode 2, " in line and "mode 3, " in line


@pytest.mark.thorough
@pytest.mark.parametrize(("count", "shapes"), [(1, True), (1, False), (2, True), (2, False)])
def test_a_right_list_of_modes_is_not_accused(count: int, shapes: bool) -> None:
    """Nor is one without a mode; stiffness is right within four standard deviations."""
    for tests in (right(count, shapes), wrong(right(count, shapes), without(1))):
        found = se.update(start(), tests)
        assert not [line for line in found.notes if ": modes: " in line]
        for one in found.estimates:
            apart = abs(math.log(one.value / labels_of(LATHE.tables)[one.unknown.label]))
            assert apart < 4 * one.relative, one.unknown.label


def without(k: int) -> Wrong:
    """A mode is missing."""

    def of(x: MeasuredModes) -> MeasuredModes:
        parts = (None if y is None else np.delete(y, k, axis=0) for y in (x.f, x.zeta, x.std_f, x.std_zeta))
        return MeasuredModes(*parts, x.outputs, None if x.shapes is None else np.delete(x.shapes, k, axis=0))

    return of


@pytest.mark.thorough
def test_a_sign_of_an_output_that_hardly_moves_does_no_harm() -> None:
    """MAC hardly tells it; pairs and values stay as they are."""
    plain, other = (se.update(start(), wrong(right(), of)) for of in (lambda x: x, mirrored(3)))
    for a, b in zip(plain.estimates, other.estimates, strict=True):
        assert abs(math.log(a.value / b.value)) < 0.1 * a.relative


@pytest.mark.thorough
def test_modes_beside_responses_are_judged_by_these() -> None:
    """Responses tell the values; a list of modes in rad/s is refused, and so is a wrong sign of all responses."""
    hammer = measured(LATHE, exact_responses(LATHE), np.random.default_rng(1))
    with pytest.raises(se.InputError, match="modal 1: modes: frequencies are in rad/s"):
        se.update(start(), [*hammer, *wrong(right(), times(f=2 * math.pi))])
    found = se.update(start(), [*hammer, *right()])
    assert not [line for line in found.notes if ": modes: " in line] and found.fit.chi2 < found.fit.far


@pytest.mark.parametrize(
    ("columns", "said"),
    [
        ({"frequency": [0.0, 20.0]}, "frequency: 0 Hz is not a vibration"),
        ({"frequency": [-5.0, 20.0]}, "frequency: -5 Hz: frequencies are not negative"),
        ({"frequency": [30.0, 20.0]}, "is followed by 20 Hz: sort the lines by frequency"),
        ({"frequency": [20.0, 20.0]}, "20 Hz, is there twice: sort the lines by frequency, each once"),
        ({"frequency": [math.nan, 20.0]}, "line 1 is nan, not a frequency"),
        ({"frequency [s]": [10.0, 20.0]}, "frequency [s]: 's' cannot be converted to Hz"),
        ({"frequency": [10.0, 20.0], "damping_ratio": [2.0, 1.0]}, "damping_ratio: mode 1 has 2: if in percent"),
        ({"frequency": [10.0, 20.0], "damping_ratio": [0.0, 0.01]}, "mode 1 has 0: give one above 0"),
        ({"frequency": [10.0, 20.0], "std_frequency": [-1.0, 1.0]}, "std_frequency: mode 1 has -1"),
        ({"frequency": [10.0, 20.0], "toool.ax": [1.0, 1.0]}, "did you mean 'tool'"),
        ({"frequency": [10.0, 20.0], "tool.ax": [1.0, math.nan]}, "tool.ax: mode 2 has no amplitude"),
    ],
)
def test_entries_that_no_mode_has_are_refused(tmp_path: Path, columns: dict[str, list[float]], said: str) -> None:
    write_csv(tmp_path / "m.csv", {name: np.array(x) for name, x in columns.items()})
    with pytest.raises(se.InputError) as error:
        listed(tmp_path, LIST)
    assert said in str(error.value) and "\n" not in str(error.value)
