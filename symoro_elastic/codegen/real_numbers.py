"""Arguments of loaded models: real numbers, others rejected with the same sentence for all libraries."""

from __future__ import annotations

import datetime
from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import NDArray

REFUSED = {"c": "complex ones", "U": "text", "S": "text", "M": "dates", "m": "dates"}
"""Kinds of dtype that are not real numbers, in words."""
PLAIN = {float, int, np.float64}
"""Types of numbers that need no further look."""
KINDS: tuple[tuple[type | tuple[type, ...], str], ...] = (
    ((str, bytes), "text"),
    ((complex, np.complexfloating), "complex ones"),
    ((datetime.date, datetime.timedelta, np.datetime64, np.timedelta64), "dates"),
    (type(None), "None"),
)


def real_numbers(value: Any) -> NDArray[Any]:
    """Return an argument as an array of numpy; raises `TypeError` for complex numbers, text, dates and masks."""
    refuse_no_numbers(value)
    return np.asarray(value)


def refuse_no_numbers(value: Any) -> None:
    """Raise `TypeError` for complex numbers, text, dates and masked entries; numbers of any library are let through."""
    if what := _fault(value):
        raise TypeError(f"arguments are real numbers, not {what}")


def _fault(value: Any) -> str:
    """Return a description of what is not a real number in an argument, empty if nothing is detected."""
    if isinstance(value, np.ma.MaskedArray):
        if np.ma.is_masked(value):
            return "masked ones"
        value = value.data
    if isinstance(value, list | tuple):
        return "" if {*map(type, value)} <= PLAIN else next(filter(None, map(_fault, value)), "")
    if not isinstance(value, np.ndarray | np.generic):
        if one := _of_object(value):
            return one
        dtype = getattr(value, "dtype", None)
        if dtype is None:
            return ""
        if not isinstance(dtype, np.dtype):
            return REFUSED["c"] if "complex" in str(dtype) else ""
        return REFUSED.get(dtype.kind, "") if dtype.kind != "O" else _of_objects(np.asarray(value).flat)
    return _of_objects(value.flat) if value.dtype.kind == "O" else REFUSED.get(value.dtype.kind, "")


def _of_objects(values: Iterable[Any]) -> str:
    return next(filter(None, map(_of_object, values)), "")


def _of_object(x: Any) -> str:
    return next((what for kind, what in KINDS if isinstance(x, kind)), "")
