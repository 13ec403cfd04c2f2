"""Sweeps described by a TOML file: what is swept, what is computed, where the machine is."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from symoro_elastic.errors import InputError
from symoro_elastic.machine.formats.files import load_text
from symoro_elastic.machine.formats.tables import Number, Table, load
from symoro_elastic.sweeps.axes import AxisLike, axis

KEYS = (
    *("over", "of", "samples", "sampling", "seed", "figures", "inputs", "outputs", "frequencies", "damping"),
    *("method", "step", "at", "hold"),
)


@dataclass(frozen=True)
class Description:
    """What a file says of a sweep; what it does not say is None or empty."""

    over: Mapping[str, AxisLike] = field(default_factory=dict)
    of: str | None = None
    samples: int | None = None
    sampling: str | None = None
    seed: int | None = None
    figures: tuple[str, ...] = ()
    inputs: tuple[str, ...] = ()
    outputs: tuple[str, ...] = ()
    frequencies: tuple[float, ...] = ()
    damping: float | None = None
    method: str | None = None
    step: float | None = None
    at: Mapping[str, float] = field(default_factory=dict)
    hold: tuple[str, ...] = ()


def read_description(path: str | Path) -> Description:
    """Return the sweep in a file; raises `InputError`."""
    top = load(load_text(path), str(path)).only(KEYS)
    found: dict[str, Any] = {}
    for key in top.entries:
        if key in ("of", "sampling", "method"):
            found[key] = top.text(key)
        elif key in ("samples", "seed"):
            found[key] = top.whole(key)
        elif key in ("figures", "inputs", "outputs", "hold"):
            found[key] = top.texts(key)
        elif key in ("damping", "step"):
            found[key] = _number(top, key)
        elif key == "frequencies":
            found[key] = _numbers(top, key)
        elif key == "at":
            found[key] = {name: _number(top.table(key), name) for name in top.table(key).entries}
        else:
            found[key] = {name: _axis(top.table(key), name) for name in top.table(key).entries}
    return Description(**found)


def _axis(table: Table, name: str) -> AxisLike:
    """Return the values or the text of an axis."""
    given = table.entries[name]
    if isinstance(given, str) and not isinstance(given, Number):
        try:
            axis(name, given)
        except InputError as error:
            raise table.fail(name, error.what) from None
        return given
    return _numbers(table, name) if isinstance(given, list) else _number(table, name)


def _number(table: Table, key: str) -> float:
    """Return the number under a key; raises `InputError` for nan and inf."""
    given = table.entries[key]
    if isinstance(given, bool) or not isinstance(given, int | Number):
        raise table.fail(key, "must be a number")
    found = float(given)
    if not math.isfinite(found):
        raise table.fail(key, f"{found:g} is no number to compute with")
    return found


def _numbers(table: Table, key: str) -> tuple[float, ...]:
    given = table.entries[key]
    if not isinstance(given, list):
        raise table.fail(key, "must be a list of numbers")
    return tuple(_number(Table({key: x}, table.source, table.place), key) for x in given)
