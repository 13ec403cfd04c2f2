"""From where machines are drawn: the direction against gravity, and the view of pictures."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from symoro_elastic.foundation.array_types import Array
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.machine import Machine

AZIMUTH, ELEVATION = np.radians(35.0), np.radians(22.0)
"""Of the eye, from the front of the machine towards its right, and above the horizon."""


def number_or_nan(formula: Formula, values: Mapping[str, float]) -> float:
    """Return the value of a formula; NaN without one."""
    try:
        return formula.value(values) if formula.names <= values.keys() else math.nan
    except (ArithmeticError, ValueError):
        return math.nan


def upward(machine: Machine, values: Mapping[str, float]) -> Array:
    """Return the direction (3,) against gravity; z without gravity, and an axis whose gravity has no value."""
    gravity = np.array([number_or_nan(x, values) for x in machine.base.gravity])
    unknown = np.isnan(gravity)
    size = 0.0 if unknown.any() else float(np.linalg.norm(gravity))
    return np.asarray(0.0 - gravity / size if size > 0 else np.eye(3)[int(np.argmax(unknown)) if unknown.any() else 2])


def view_axes(up: Array) -> Array:
    """Return the directions (3, 3) to the right, up and to the eye, in rows: from the front, the right and above.

    x points to the right as far as `up` (3,) allows.
    """
    across = np.eye(3)[int(abs(up[0]) > 0.9)]
    right = across - up * float(across @ up)
    right = right / np.linalg.norm(right)
    back = np.cross(up, right)
    eye = np.cos(ELEVATION) * (np.sin(AZIMUTH) * right - np.cos(AZIMUTH) * back) + np.sin(ELEVATION) * up
    aside = np.cross(up, eye)
    aside = aside / np.linalg.norm(aside)
    return np.stack([aside, np.cross(eye, aside), eye])
