"""Small machines whose figures have closed forms, and functions that are computed of them."""

from __future__ import annotations

import math
import os
from pathlib import Path
from typing import Any

from symoro_elastic.machine.machine import Machine

MASS, STIFFNESS, DAMPING = 2.0, 8e4, 40.0
SLIDE: dict[str, Any] = {
    "name": "slide",
    "joints": [
        {"name": "drive", "antecedent": 0, "kind": "motor", "sigma": 1, "r": "x"},
        {"name": "load", "antecedent": "drive", "kind": "elastic", "sigma": 1, "r": "y"},
    ],
    "bodies": {"drive": {"mass": 10.0}, "load": {"mass": "m"}},
    "springs": {"load": {"stiffness": STIFFNESS, "damping": DAMPING}},
    "parameters": {"m": {"value": MASS, "unit": "kg"}},
}
"""A mass on a spring on a slide that is driven."""


def hertz(mass: float = MASS, stiffness: float = STIFFNESS) -> float:
    """The natural frequency of the load where the drive is held."""
    return math.sqrt(stiffness / mass) / (2 * math.pi)


def value(machine: Machine, name: str = "m") -> float:
    """The value of a parameter."""
    return next(p.value.value() for p in machine.parameters if p.name == name and p.value is not None)


def squared(machine: Machine) -> dict[str, float]:
    """A figure that is known."""
    return {"squared": value(machine) ** 2}


def squared_unless_killed(machine: Machine) -> dict[str, float]:
    """The process that computes 13 dies; that of 5 dies once, and leaves a file."""
    x = value(machine)
    once = Path(os.environ["SWEEP_TEST"]) / "died"
    if x == 13.0 or (x == 5.0 and not once.exists()):
        once.touch()
        os._exit(9)
    return {"squared": x**2}
