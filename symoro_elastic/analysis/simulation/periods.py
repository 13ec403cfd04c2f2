"""Periods of a controller: steps that divide them, and their computing time; times in readable units."""

from __future__ import annotations

import math

from symoro_elastic.machine.described import Wanted

WHOLE = 1e-9
"""Of a number of steps: rounding of times."""
NEAR = 8
"""Numbers of steps of a period that are tried for a step of few digits."""

PREFIXES = ((1.0, ""), (1e-3, "m"), (1e-6, "u"), (1e-9, "n"))


def period_line(wanted: Wanted, step: float, seconds: float) -> str:
    """Return the computing time of a period's steps, and whether `wanted` allows it; empty without a period.

    `step` is the time between steps, `seconds` the computing time of a step, both s.
    """
    if wanted.period is None:
        return ""
    count = round(wanted.period / step)
    spent = count * seconds
    steps = "1 step" if count == 1 else f"{count} steps"
    line = f"a period of {quantity(wanted.period, 's')} needs {steps}, {quantity(spent, 's')} on this computer"
    if wanted.time is None:
        return line
    fits = "within" if spent <= wanted.time else "more than"
    return f"{line}: {fits} the {quantity(wanted.time, 's')} that [wanted] allows"


def quantity(x: float, unit: str) -> str:
    """Return a number with its unit: `5.9 um`, `3.12 ms`, `12 N`."""
    if unit not in ("m", "s") or not abs(x) > 0:
        return f"{x:.3g} {unit}"
    rounded = abs(float(f"{x:.3g}"))
    scale, prefix = next((pair for pair in PREFIXES if rounded >= pair[0]), PREFIXES[-1])
    return f"{x / scale:.3g} {prefix}{unit}"


def is_whole(ratio: float) -> bool:
    """Return whether a ratio of times is a positive integer within rounding."""
    return round(ratio) >= 1 and abs(ratio - round(ratio)) <= WHOLE * ratio


def part_of(period: float, largest: float) -> str:
    """Return the largest step up to a bound, s, that divides a period; of few digits if possible."""
    fewest = math.ceil(period / largest)
    short = (f"{period / steps:g}" for steps in range(fewest, fewest + NEAR))
    return next((text for text in short if is_whole(period / float(text))), f"{period / fewest:.12g}")


def part_from(period: float, least: float) -> str:
    """Return the shortest step that is at least `least`, s, and divides a period."""
    return f"{period / math.floor(period / least):.12g}"


def rounded_down(x: float) -> str:
    """Return a number rounded down to three digits."""
    text = f"{x:.3g}"
    return text if float(text) <= x else f"{x * 0.995:.3g}"
