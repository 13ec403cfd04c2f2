"""Plots of time series: curves over time, and torques of motors over their speeds."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import Any

import numpy as np

from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.pictures import Plot
from symoro_elastic.foundation.plot_style import MOST_NAMED, by_unit, curve, curves, legend, marker, shades, y_label

MOST_IN_ROWS = 7
"""Curves with names in diagrams above each other."""


def over_time(t: Array, rows: Sequence[tuple[str, str, list[str], Array]], *axes: Any) -> None:
    """Draw rows (what, unit, names, columns) of curves over time, one diagram each."""
    for axis, (label, unit, names, values) in zip(axes, rows, strict=True):
        curves(axis, t, values, names, most=MOST_IN_ROWS)
        y_label(axis, label, unit)
        legend(axis)
    axes[-1].set_xlabel("time, s")


def torque_speed(
    title: str, names: Sequence[str], speeds: Array, torques: Array, per: Sequence[str], of: Sequence[str]
) -> Plot:
    """Return torques (N, motors) of motors over their speeds, one diagram for each unit; a dot marks the start."""
    units = by_unit([f"{speed}|{force}" for speed, force in zip(per, of, strict=True)])
    draw = partial(_torque_speed, names, speeds, torques, units)
    return Plot(title, draw, len(units), size=(7.5, 0.6 + 3.6 * len(units)), share_x=False)


def _torque_speed(names: Sequence[str], speeds: Array, torques: Array, units: dict[str, list[int]], *axes: Any) -> None:
    for axis, (unit, columns) in zip(axes, units.items(), strict=True):
        per, of = unit.split("|")
        axis.axhline(0.0, color=shades().grey, linewidth=0.8)
        axis.axvline(0.0, color=shades().grey, linewidth=0.8)
        largest = sorted(columns, key=lambda k: -np.abs(torques[:, k] * speeds[:, k]).max(initial=0.0))[:MOST_NAMED]
        for j, k in enumerate(sorted(largest)):
            axis.plot(speeds[:, k], torques[:, k], label=names[k], **curve(j))
            axis.plot(speeds[:1, k], torques[:1, k], marker(j), color=curve(j)["color"], markersize=5)
        omitted = len(columns) - len(largest)
        legend(axis, f"without {omitted} of less power" if omitted else "")
        axis.set_xlabel(f"speed, {per}")
        y_label(axis, "force" if of == "N" else "torque", of)
