"""Files of vibration tests that tests write, and the machine that they are of."""

from __future__ import annotations

import csv
from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path

import numpy as np

from symoro_elastic.formats import read_machine
from symoro_elastic.machine.described import DescribedMachine
from symoro_elastic.measured.vibration_tests.measured import VibrationTest, VibrationTests
from symoro_elastic.measured.vibration_tests.reading import read_tests

EXAMPLES = Path(__file__).parents[3] / "examples"
LIST = '[[tests]]\nfile = "m.csv"\n'
F = np.array([10.0, 12.5, 20.0, 40.0])
H = np.array([1 + 2j, -3 + 0.5j, 0.25j, -1e-3 + 0j])
PAIR = "tool.ax/tool.fx"


@cache
def machine() -> DescribedMachine:
    """A machine tool with two motors, motor_x and motor_y, both slides, with limits of their strokes."""
    return read_machine(EXAMPLES / "two_axis.toml")[0]


def write_csv(path: Path, columns: Mapping[str, Sequence[float]], delimiter: str = ",", comma: bool = False) -> None:
    """Write columns, with decimal commas if asked for."""
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, delimiter=delimiter)
        writer.writerow(columns)
        for row in zip(*columns.values(), strict=True):
            cells = [repr(float(x)) for x in row]
            writer.writerow([cell.replace(".", ",") for cell in cells] if comma else cells)


def listed(folder: Path, text: str = LIST) -> VibrationTests:
    """The tests of a list in a folder."""
    (folder / "tests.toml").write_text(text, encoding="utf-8")
    return read_tests(folder / "tests.toml", machine())


def the_test(folder: Path, columns: Mapping[str, Sequence[float]], more: str = "", **of: bool) -> VibrationTest:
    """The one test of a .csv file with these columns."""
    write_csv(folder / "m.csv", columns, **of)
    (test,) = listed(folder, LIST + more).tests
    return test


def cartesian(pair: str = PAIR, unit: str = "") -> dict[str, Sequence[float]]:
    """Columns of the response H from F."""
    return {"f [Hz]": F, f"re {pair}{unit}": H.real, f"im {pair}{unit}": H.imag}
