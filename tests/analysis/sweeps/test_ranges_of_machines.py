"""Sweeps over the ranges that the machine file gives: tolerances of parameters, limits of positions."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("scipy")

import symoro_elastic as se
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.machine import Machine
from tests.analysis.sweeps.machines import MASS, SLIDE, squared

TOLERATED: dict[str, Any] = {
    **SLIDE,
    "parameters": {"m": {"value": MASS, "tolerance": "10 %"}, "exact": 3},
    "limits": {"drive": {"position": [-0.25, 0.5]}},
}


def test_a_grid_goes_from_end_to_end_of_the_tolerance() -> None:
    found = se.sweep(TOLERATED, over={"m": "tolerance:3"}, of=squared)
    np.testing.assert_allclose(found.arrays()["m"], [1.8, 2.0, 2.2], rtol=1e-14)
    np.testing.assert_allclose(found.arrays()["squared"], np.square([1.8, 2.0, 2.2]), rtol=1e-14)


def test_a_sample_fills_the_tolerance_as_it_does_the_same_range_in_numbers() -> None:
    ways = ("tolerance", f"{MASS * 0.9}:{MASS * 1.1}")
    drawn, given = (se.sweep(TOLERATED, over={"m": over}, of=squared, samples=32, seed=3).arrays() for over in ways)
    assert (drawn["m"] == given["m"]).all() and (drawn["squared"] == given["squared"]).all()
    assert 1.8 < drawn["m"].min() < 1.85 and 2.15 < drawn["m"].max() < 2.2


def position(machine: Machine, positions: dict[str, float]) -> dict[str, float]:
    """A figure of a position."""
    return {"twice": 2 * positions["drive"]}


def test_positions_go_from_limit_to_limit() -> None:
    found = se.sweep(TOLERATED, over={"q.drive": "limits:4"}, of=position)
    assert found.arrays()["twice"].tolist() == [-0.5, 0.0, 0.5, 1.0]


def test_positions_without_limits_are_refused() -> None:
    free = {**TOLERATED, "limits": {}}
    with pytest.raises(InputError, match=r"q\.drive=limits: \[limits\] of the machine give no position of drive"):
        se.sweep(free, over={"q.drive": "limits:3"}, of=position)


@pytest.mark.parametrize(
    ("over", "said"),
    [
        ({"exact": "tolerance:3"}, "exact=tolerance: [parameters] of the machine give no tolerance of it: write"),
        ({"load.stiffness": "tolerance:3"}, "load.stiffness=tolerance: [parameters] of the machine give no tolerance"),
        ({"q.drive": "tolerance:3"}, "q.drive=tolerance: q.drive is a position: write q.drive=limits"),
        ({"m": "limits:3"}, "m=limits: m is a parameter: write m=tolerance"),
        ({"m": "tolerance"}, "m has a distribution: give the number of points by"),
        ({"m": "tolerance:1"}, "'m=tolerance:1': one value is not a range: give a COUNT from 2"),
        ({"m": "tolerance:3,log"}, "'m=tolerance:3,log': give tolerance or tolerance:COUNT"),
        ({"m": "tolerance:2:3"}, "'m=tolerance:2:3': give tolerance or tolerance:COUNT"),
    ],
)
def test_ranges_that_the_machine_does_not_give_are_refused(over: dict[str, str], said: str) -> None:
    with pytest.raises(InputError) as error:
        se.sweep(TOLERATED, over=over)
    assert said in str(error.value) and "\n" not in str(error.value)


def test_a_journal_of_another_tolerance_is_not_gone_on_with(tmp_path: Path) -> None:
    """The words are the same, the points are not."""
    wider = {**TOLERATED, "parameters": {"m": {"value": MASS, "tolerance": "20 %"}}}
    for machine, ends in ((TOLERATED, (1.8, 2.2)), (wider, (1.6, 2.4))):
        journal = tmp_path / f"{ends[0]}.journal"
        found = se.sweep(machine, over={"m": "tolerance:2"}, of=squared, journal=journal)
        assert found.arrays()["m"].tolist() == pytest.approx(ends)
    with pytest.raises(InputError):
        se.sweep(wider, over={"m": "tolerance:2"}, of=squared, journal=tmp_path / "1.8.journal")
