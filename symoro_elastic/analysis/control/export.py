"""Loops for python-control: all of them closed as a state space, open ones as frequency responses."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from symoro_elastic.analysis.control.cascade import Cascade
from symoro_elastic.analysis.control.closed_loop import closed_loop
from symoro_elastic.analysis.control.loops import loops_of
from symoro_elastic.analysis.control.plant import Plant, position_row
from symoro_elastic.analysis.vibration.export import labels
from symoro_elastic.foundation.packages import import_optional

SET_POINTS = ("r", "rd", "rdd")


def systems_for_control(plant: Plant, drives: Sequence[Cascade], names: Sequence[str]) -> dict[str, Any]:
    """Return `closed`, a `control.StateSpace`, and open loops as `control.FrequencyResponseData`, at a position.

    `closed` has set points and their two rates by motor, forces at outputs of these names; positions that are
    controlled, and outputs; dead times are approximations of Pade of order 2 in it. `motor_x velocity` and
    `motor_x position` are exact.
    Raises `InputError` without python-control.
    """
    package = import_optional("control", "systems for python-control", "control")
    loop = closed_loop(plant, drives)
    rows = np.array([position_row(plant.linear, name) for name in names]).reshape(len(names), -1)
    columns = [column[:, k] for k in range(len(drives)) for column in loop.by_set_point]
    B = np.column_stack([*columns, loop.by_force @ rows.T])
    seen = np.vstack([[plant.axes[one.motor].position for one in drives], rows]) @ plant.free
    C = np.hstack([seen, np.zeros((len(seen), len(loop.A) - seen.shape[1]))])
    inputs = [f"{one.motor}.{key}" for one in drives for key in SET_POINTS] + [f"{name} force" for name in names]
    outputs = [*(f"{one.motor}.position" for one in drives), *names]
    D = np.zeros((len(C), B.shape[1]))
    found = {"closed": package.ss(loop.A, B, C, D, inputs=labels(inputs), outputs=labels(outputs))}
    for one in loops_of(plant, drives):
        for name, values in one.open_loops(one.frequencies).items():
            found[f"{one.cascade.motor} {name}"] = package.frd(values, 2 * np.pi * one.frequencies)
    return found
