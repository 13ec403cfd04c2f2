"""The PUMA 560 as a robot of the Robotics Toolbox: Armstrong, Khatib and Burdick 1986, and P. Corke's table."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np

import symoro_elastic as se
from symoro_elastic.machine.machine import Machine

RIGHT = math.pi / 2
ROWS: list[tuple[Any, ...]] = [
    (0, 0, RIGHT, (0, 0.35, 0), (0, 0, 0), 0, 200e-6, -62.6111),
    (0, 0.4318, 0, (0.13, 0.524, 0.539), (-0.3638, 0.006, 0.2275), 17.4, 200e-6, 107.815),
    (0.15005, 0.0203, -RIGHT, (0.066, 0.086, 0.0125), (-0.0203, -0.0141, 0.070), 4.8, 200e-6, -53.7063),
    (0.4318, 0, RIGHT, (1.8e-3, 1.3e-3, 1.8e-3), (0, 0.019, 0), 0.82, 33e-6, 76.0364),
    (0, 0, -RIGHT, (0.3e-3, 0.4e-3, 0.3e-3), (0, 0, 0), 0.34, 33e-6, 71.923),
    (0, 0, 0, (0.15e-3, 0.15e-3, 0.04e-3), (0, 0, 0.032), 0.09, 33e-6, 76.686),
]
"""d, a, alpha; inertia about the centre of mass, its place, mass; rotor, gear."""
PLAIN = {"theta": 0.0, "offset": 0.0, "sigma": 0, "mdh": False, "B": 0.0, "Tc": (0.0, 0.0), "isflip": False}


def robot() -> Machine:
    """The arm, read as a robot of the toolbox."""
    links = [
        SimpleNamespace(**PLAIN, d=d, a=a, alpha=alpha, I=np.diag(I), r=np.array(r, float), m=m, Jm=Jm, G=G)
        for d, a, alpha, I, r, m, Jm, G in ROWS  # noqa: E741
    ]
    base = {"base": np.eye(4), "tool": np.eye(4), "gravity": np.array([0, 0, -9.81])}
    return se.read(SimpleNamespace(name="puma560", links=links, **base))
