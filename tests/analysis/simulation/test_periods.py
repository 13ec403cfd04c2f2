"""Steps of a controller's period beside the time that is wanted."""

from __future__ import annotations

import pytest

from symoro_elastic.analysis.simulation.periods import period_line, quantity
from symoro_elastic.machine.described import Wanted

pytestmark = pytest.mark.sampled(4)


@pytest.mark.parametrize(
    ("wanted", "line"),
    [
        (Wanted(), ""),
        (Wanted(period=1e-3), "a period of 1 ms needs 4 steps, 12 us on this computer"),
        (Wanted(period=1e-3, time=13e-6), "... on this computer: within the 13 us that [wanted] allows"),
        (Wanted(period=1e-3, time=11e-6), "... on this computer: more than the 11 us that [wanted] allows"),
        (Wanted(period=0.25e-3), "a period of 250 us needs 1 step, 3 us on this computer"),
    ],
)
def test_steps_of_a_period_are_added_and_compared(wanted: Wanted, line: str) -> None:
    said = period_line(wanted, 0.25e-3, 3e-6)
    assert said.endswith(line.removeprefix("...")) if line else not said


@pytest.mark.parametrize(
    ("x", "unit", "text"),
    [
        (0.0, "m", "0 m"),
        (2.0, "m", "2 m"),
        (-3e-3, "s", "-3 ms"),
        (4e-11, "m", "0.04 nm"),
        (1e-6, "rad", "1e-06 rad"),
        (9.996e-7, "s", "1 us"),
    ],
)
def test_quantities_have_prefixes(x: float, unit: str, text: str) -> None:
    assert quantity(x, unit) == text
