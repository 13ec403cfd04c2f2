"""Columns that are written are read again, digit by digit."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from symoro_elastic.analysis.time_series.measurements import read_columns
from symoro_elastic.analysis.time_series.writing import columns_of, refuse_file, write_columns
from symoro_elastic.foundation.errors import InputError
from tests.analysis.vibration.machines import drive

T = np.array([0.0, 1 / 3, 2 / 3])
BLOCKS = (("q", np.array([[0.1, -0.0], [1e-17, 2.0], [3.0, 1 / 7]]), ["motor", "load"]),)


@pytest.mark.parametrize("name", ["run.csv", "run.npz"])
def test_written_columns_are_read_without_loss(name: str, tmp_path: Path) -> None:
    columns = columns_of(T, *BLOCKS)
    assert list(columns) == ["t", "q_motor", "q_load"]
    write_columns(columns, tmp_path / name)
    again = read_columns(tmp_path / name, drive())
    assert list(again) == list(columns)
    for header, values in columns.items():
        np.testing.assert_array_equal(again[header], values)


def test_no_minus_zero_is_written(tmp_path: Path) -> None:
    write_columns(columns_of(T, *BLOCKS), tmp_path / "run.csv")
    assert "-0.0" not in (tmp_path / "run.csv").read_text()


@pytest.mark.parametrize(("name", "what"), [("run.txt", "with .csv or .npz"), ("none/run.csv", "does not exist")])
def test_files_that_cannot_be_written_are_refused(name: str, what: str, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=what):
        refuse_file(tmp_path / name)
