"""The time that the steps of a controller's period take, beside what is wanted; lengths and times for readers."""

from __future__ import annotations

from symoro_elastic.machine.wanted import Wanted

PREFIXES = ((1.0, ""), (1e-3, "m"), (1e-6, "u"), (1e-9, "n"))


def period_line(wanted: Wanted, step: float, seconds: float) -> str:
    """Return how long the steps of a period take, and whether `wanted` allows it; empty where no period is wanted.

    `step` is the time between steps, `seconds` what a step takes on this computer, both s.
    """
    if wanted.period is None:
        return ""
    count = round(wanted.period / step)
    spent = count * seconds
    steps = "1 step" if count == 1 else f"{count} steps"
    line = f"a period of {quantity(wanted.period, 's')} takes {steps}, {quantity(spent, 's')} on this computer"
    if wanted.time is None:
        return line
    fits = "within" if spent <= wanted.time else "more than"
    return f"{line}: {fits} the {quantity(wanted.time, 's')} that [wanted] allows"


def quantity(x: float, unit: str) -> str:
    """Return a number with its unit: `5.9 um`, `3.12 ms`, `12 N`."""
    if unit not in ("m", "s") or not abs(x) > 0:
        return f"{x:.3g} {unit}"
    shown = abs(float(f"{x:.3g}"))
    scale, prefix = next((pair for pair in PREFIXES if shown >= pair[0]), PREFIXES[-1])
    return f"{x / scale:.3g} {prefix}{unit}"
