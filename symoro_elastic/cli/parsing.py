"""Option values: numbers and ranges by name, controller gains, grids of positions, frequency bands."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any, TypeVar

import click

from symoro_elastic.errors import InputError

Callback = Callable[[click.Context, click.Parameter, Any], Any]
T = TypeVar("T")


def parsed_by(parse: Callable[[Any, str], Any]) -> Callback:
    """Return a click callback that converts the value of an option by `parse(value, option)`."""
    return lambda _context, option, value: parse(value, option.opts[0])


def number(text: str) -> float:
    """A number, or a formula of numbers, read as in a machine file; raises `ValueError`."""
    from symoro_elastic.machine import formula

    try:
        return formula.number(text)
    except ValueError as error:
        raise ValueError(f"is no number: {error}") from None


def whole_number(text: str) -> int:
    """A whole number, of any size; raises `ValueError`."""
    number(text)
    if not text.strip().lstrip("+-").isdecimal():
        raise ValueError("is no whole number")
    return int(text)


class _AsInFiles(click.ParamType):  # type: ignore[type-arg]
    """A number that is written by the rules of machine files."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        if not isinstance(value, str):
            return super().convert(value, param, ctx)
        try:
            whole = isinstance(self, click.types.IntParamType)
            given: float = whole_number(value) if whole else number(value)
        except ValueError as error:
            place = param.opts[0] if param else self.name
            raise InputError("symoro-elastic", place, f"{value!r} {error}") from None
        return super().convert(given, param, ctx)


class Number(_AsInFiles, click.types.FloatParamType):
    """A number."""


class NumberRange(_AsInFiles, click.FloatRange):
    """A number within a range."""


class Whole(_AsInFiles, click.types.IntParamType):
    """A whole number."""


class WholeRange(_AsInFiles, click.IntRange):
    """A whole number within a range."""


def named(given: Sequence[str], option: str, parse: Callable[[str], T], form: str) -> dict[str, T]:
    """Values by name, from `NAME=VALUE`; raise `InputError` for what `parse` refuses, and for two values of a name."""
    found: dict[str, T] = {}
    for text in given:
        name, _, written = (part.strip() for part in text.rpartition("="))
        try:
            value = parse(written)
        except ValueError as error:
            reason = str(error).removeprefix("is no number")
            raise InputError("symoro-elastic", option, f"{text.removeprefix('=')!r}{form}{reason}") from None
        if found.setdefault(name, value) != value:
            what = f"{name or 'the value of all'} is given twice: give it one value"
            raise InputError("symoro-elastic", option, what)
    return found


def numbers(given: Sequence[str], option: str) -> dict[str, float]:
    """Numbers by name, from `NAME=X`."""
    form = " is not NAME=NUMBER"
    for text in given:
        if "=" not in text:
            raise InputError("symoro-elastic", option, f"{text!r}{form}")
    return named(given, option, number, form)


def texts(given: Sequence[str], option: str) -> dict[str, str]:
    """Texts by name, from `NAME=TEXT`; raise `InputError` for two texts of a name."""
    found: dict[str, str] = {}
    for text in given:
        name, equals, written = (part.strip() for part in text.partition("="))
        if not (name and equals and written):
            raise InputError("symoro-elastic", option, f"{text!r} is not NAME=VALUES")
        if name in found:
            raise InputError("symoro-elastic", option, f"{name} is given twice: give it one value, list or range")
        found[name] = written
    return found


def numbers_or_default(given: Sequence[str], option: str) -> dict[str, float]:
    """Numbers by name, from `NAME=X` or `X`; a number without name has the name ""."""
    return numbers([text if "=" in text else f"={text}" for text in given], option)


def numbers_or_none(given: Sequence[str], option: str) -> dict[str, float | None]:
    """Numbers by name, from `NAME=X`, None from `NAME`."""
    valued = numbers([text for text in given if "=" in text], option)
    return {name: valued.get(name) for name in (text.partition("=")[0].strip() for text in given)}


def ranges(given: Sequence[str], option: str) -> dict[str, tuple[float, float]]:
    """Ranges by name, from `NAME=LOW:HIGH` or `NAME=X` for -X:X; a range without name has the name ""."""
    return named(given, option, _low_high, " is no limit: X, LOW:HIGH, NAME=X ...")


def _low_high(limits: str) -> tuple[float, float]:
    low, colon, high = limits.partition(":")
    return (number(low), number(high)) if colon else (-number(low), number(low))


def gains(given: Sequence[str], option: str) -> dict[str, tuple[float, float]]:
    """Proportional and derivative gain by motor, from `MOTOR=KP:KD`."""
    for text in given:
        if ":" not in text:
            what = f"{text!r} is not MOTOR=KP:KD, in N/m and N s/m or N m/rad and N m s/rad"
            raise InputError("symoro-elastic", option, what)
    return ranges(given, option)


def springs_on_joints(given: Sequence[str], option: str) -> dict[str, tuple[float, ...]]:
    """Stiffness, and inertia of the rotor where it is given, by joint, from `JOINT=K[:IA]`."""
    form = " is not JOINT=K or JOINT=K:IA, in N m/rad and kg m2 or N/m and kg"
    for text in given:
        if "=" not in text or text.count(":") > 1:
            raise InputError("symoro-elastic", option, f"{text!r}{form}")
    return named(given, option, lambda written: tuple(map(number, written.split(":"))), form)


def grid(given: Sequence[str], option: str) -> dict[str, list[float]]:
    """Positions by joint, from `JOINT=LOW:HIGH:COUNT[,log]` or `JOINT=X1,X2,...`; raise `InputError` for too many."""
    from symoro_elastic.sweeps.axes import Listed, axis
    from symoro_elastic.vibration.tracking import refuse_grid

    written = texts(given, option)
    axes = {name: axis(name, text) for name, text in written.items()}
    listed = {name: one for name, one in axes.items() if isinstance(one, Listed)}
    for name in axes.keys() - listed.keys():
        raise InputError("symoro-elastic", option, f"{f'{name}={written[name]}'!r}{LOW_HIGH_COUNT}")
    if listed:
        refuse_grid([one.count for one in listed.values()], "symoro-elastic")
    return {name: one.values() for name, one in listed.items()}


def band(text: str | None, option: str) -> tuple[float, float, int] | tuple[()]:
    """Lowest and highest frequency, Hz, and number of points, from `LOW:HIGH[:COUNT]`; empty for None."""
    if text is None:
        return ()
    from symoro_elastic.vibration.responses import POINTS, refuse_band

    whole = text if text.count(":") > 1 else f"{text}:{POINTS}"
    try:
        low, high, count = _low_high_count(whole)
    except ValueError:
        raise InputError("symoro-elastic", option, f"{text!r}{LOW_HIGH_COUNT}") from None
    refuse_band(low, high, count, "symoro-elastic")
    return low, high, count


LOW_HIGH_COUNT = ": give LOW:HIGH:COUNT, numbers and a count from 1"


def _low_high_count(limits: str) -> tuple[float, float, int]:
    low, high, count = map(number, limits.split(":"))
    if count != int(count) or count < 1:
        raise ValueError
    return low, high, int(count)


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
