"""Option values: numbers and ranges by name, controller gains, grids of positions, frequency bands."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

import click

from symoro_elastic.errors import InputError

Callback = Callable[[click.Context, click.Parameter, Any], Any]


def parsed_by(parse: Callable[[Any, str], Any]) -> Callback:
    """Return a click callback that converts the value of an option by `parse(value, option)`."""
    return lambda _context, option, value: parse(value, option.opts[0])


def among(names: Sequence[str], known: Sequence[str] | dict[str, Any], option: str) -> tuple[str, ...]:
    """Return the names without repetition; raise `InputError` for one that is not known."""
    for name in names:
        if name not in known:
            raise InputError("symoro-elastic", option, f"there is no {name!r}: choose from {', '.join(known)}")
    return tuple(dict.fromkeys(names))


def numbers(given: Sequence[str], option: str) -> dict[str, float]:
    """Numbers by name, from `NAME=X`."""
    found = {}
    for text in given:
        name, _, number = text.partition("=")
        try:
            found[name.strip()] = float(number)
        except ValueError:
            raise InputError("symoro-elastic", option, f"{text!r} is not NAME=NUMBER") from None
    return found


def numbers_or_default(given: Sequence[str], option: str) -> dict[str, float]:
    """Numbers by name, from `NAME=X` or `X`; a number without name has the name ""."""
    return numbers([text if "=" in text else f"={text}" for text in given], option)


def ranges(given: Sequence[str], option: str) -> dict[str, tuple[float, float]]:
    """Ranges by name, from `NAME=LOW:HIGH` or `NAME=X` for -X:X; a range without name has the name ""."""
    found = {}
    for text in given:
        name, _, limit = text.rpartition("=")
        low, colon, high = limit.partition(":")
        try:
            found[name.strip()] = (float(low), float(high)) if colon else (-float(low), float(low))
            if not all(map(math.isfinite, found[name.strip()])):
                raise ValueError
        except ValueError:
            raise InputError("symoro-elastic", option, f"{text!r} is no limit: X, LOW:HIGH, NAME=X ...") from None
    return found


def gains(given: Sequence[str], option: str) -> dict[str, tuple[float, float]]:
    """Proportional and derivative gain by motor, from `MOTOR=KP:KD`."""
    for text in given:
        if ":" not in text:
            what = f"{text!r} is not MOTOR=KP:KD, in N/m and N s/m or N m/rad and N m s/rad"
            raise InputError("symoro-elastic", option, what)
    return ranges(given, option)


def grid(given: Sequence[str], option: str) -> dict[str, list[float]]:
    """Equally spaced positions by joint, from `JOINT=LOW:HIGH:COUNT`."""
    found: dict[str, list[float]] = {}
    for text in given:
        name, _, limits = text.partition("=")
        low, high, count = _low_high_count(limits, option, text)
        if name.strip() in found:
            raise InputError("symoro-elastic", option, f"{name.strip()} is given twice: name each joint once")
        found[name.strip()] = [low + (high - low) * k / max(count - 1, 1) for k in range(count)]
    return found


def band(text: str | None, option: str) -> tuple[float, float, int] | tuple[()]:
    """Lowest and highest frequency, Hz, and number of points, from `LOW:HIGH[:COUNT]`; empty for None."""
    if text is None:
        return ()
    return _low_high_count(text if text.count(":") > 1 else f"{text}:2000", option, text)


def _low_high_count(limits: str, option: str, text: str) -> tuple[float, float, int]:
    parts = limits.split(":")
    try:
        low, high, count = float(parts[0]), float(parts[1]), int(parts[2])
        if len(parts) != 3 or count < 1 or not abs(low) + abs(high) < float("inf"):
            raise ValueError
    except (ValueError, IndexError):
        what = f"{text!r}: give LOW:HIGH:COUNT, numbers and a count from 1"
        raise InputError("symoro-elastic", option, what) from None
    return low, high, count


def bound(given: float | None, option: str) -> float | None:
    """A finite bound on an angle, rad, or None."""
    if given is not None and not math.isfinite(given):
        raise InputError("symoro-elastic", option, f"{given} is no bound: write the largest angle, rad")
    return given


def outputs(given: Sequence[str], option: str) -> dict[str, tuple[str, ...]]:
    """Requested outputs by model, from `MODEL=NAME` or `MODEL by NAMES`."""
    from symoro_elastic.machine.scene import BY

    found: dict[str, tuple[str, ...]] = {}
    for text in given:
        model, equals, name = (part.strip() for part in text.partition("="))
        if not equals:
            model, by, name = (part.strip() for part in text.partition(BY))
            name = f"{by} {name}".strip()
        if not (model and name):
            what = f"{text!r} is not MODEL=NAME, as in 'jacobian=tool at (0.1, 0, L2) in base'"
            raise InputError("symoro-elastic", option, what)
        found[model] = (*found.get(model, ()), name)
    return found
