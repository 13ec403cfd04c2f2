"""Times that are whole parts of others, in as few digits as a message needs."""

from __future__ import annotations

import math

WHOLE = 1e-9
"""Of a number of steps: rounding of times."""
NEAR = 8
"""Numbers of steps of a period that are tried for a step of few digits."""


def is_whole(ratio: float) -> bool:
    """Return whether a ratio of times is a positive whole number to rounding."""
    return round(ratio) >= 1 and abs(ratio - round(ratio)) <= WHOLE * ratio


def part_of(period: float, largest: float) -> str:
    """Return a step up to the largest, s, of which a period is a whole number: of few digits where that is near."""
    fewest = math.ceil(period / largest)
    short = (f"{period / steps:g}" for steps in range(fewest, fewest + NEAR))
    return next((text for text in short if is_whole(period / float(text))), f"{period / fewest:.12g}")


def part_from(period: float, least: float) -> str:
    """Return the shortest step from the least on, s, of which a period, no shorter than that, is a whole number."""
    return f"{period / math.floor(period / least):.12g}"


def rounded_down(x: float) -> str:
    """Return three digits of a number, of one below it where they would round it up."""
    text = f"{x:.3g}"
    return text if float(text) <= x else f"{x * 0.995:.3g}"
