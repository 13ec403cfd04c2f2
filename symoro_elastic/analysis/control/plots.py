"""Plots of drives: Bode and Nyquist diagrams of open loops, compliances with loops closed."""

from __future__ import annotations

from typing import Any

import numpy as np

from symoro_elastic.analysis.control.cascade import laplace
from symoro_elastic.analysis.control.control import Control
from symoro_elastic.analysis.control.lobes import Lobes
from symoro_elastic.analysis.control.loops import AxisLoops, loops_of
from symoro_elastic.analysis.control.plant import position_row
from symoro_elastic.analysis.control.views import place_text
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.pictures import new_figure
from symoro_elastic.foundation.results import figures_of

FURTHEST = 3.0
"""Half the width of a Nyquist diagram around -1."""
HIGHEST = 8.0
"""Of the depth that is stable at all speeds: the end of the axis of lobes."""
SLOWEST, BETWEEN = 0.1, 6
"""Hz from which on loops are drawn; how finely frequencies that are tried are divided."""
STYLES = {"velocity": "-", "position": "--"}


@figures_of.register
def _(control: Control) -> dict[str, Any]:
    """Return open_loops_<motor> and nyquist_<motor> for each axis, and compliances."""
    found: dict[str, Any] = {}
    by_place = [loops_of(plant, control.cascades) for plant in control.plants]
    for k, one in enumerate(control.cascades):
        axes = [loops[k] for loops in by_place]
        found |= {f"open_loops_{one.motor}": bode(control, axes), f"nyquist_{one.motor}": nyquist(control, axes)}
    return found | {"compliances": compliances(control)}


@figures_of.register
def _(lobes: Lobes) -> dict[str, Any]:
    """Return stability_lobes: depths and frequencies of waves over the spindle speed."""
    figure = new_figure(8.0, 5.5)
    depth, waves = figure.subplots(2, 1, sharex=True, height_ratios=(2, 1))
    for k, place in enumerate(lobes.places):
        label = place_text(place.place) if len(lobes.places) > 1 else None
        shown = np.where(np.isfinite(place.depths), 1e3 * place.depths, np.nan)
        depth.plot(lobes.speeds, shown, linewidth=0.9, color=f"C{k % 10}", label=label)
        if place.periodic is not None:
            by_intervals = np.where(np.isfinite(place.periodic), 1e3 * place.periodic, np.nan)
            depth.plot(lobes.speeds, by_intervals, ".", markersize=3, color=f"C{k % 10}")
        depth.axhline(1e3 * place.least, linewidth=0.6, color=f"C{k % 10}", linestyle="--")
        waves.plot(lobes.speeds, place.waves, ".", markersize=2, color=f"C{k % 10}")
    depth.set_ylim(0, HIGHEST * 1e3 * min(place.least for place in lobes.places))
    depth.set_ylabel("depth, mm: stable below")
    waves.set_ylabel("waves, Hz")
    waves.set_xlabel("spindle speed, turns per minute")
    for axis in (depth, waves):
        axis.grid(True, linewidth=0.3)
    if len(lobes.places) > 1:
        depth.legend(fontsize="x-small")
    depth.set_title(f"{lobes.machine}: stability lobes along {', '.join(lobes.cut.forces)}")
    return {"stability_lobes": figure}


def shown(axis: AxisLoops) -> Array:
    """Return the frequencies at which loops are drawn: those that are tried, and some between."""
    tried = axis.frequencies[axis.frequencies >= SLOWEST]
    found: Array = np.exp(
        np.interp(np.arange((len(tried) - 1) * BETWEEN + 1) / BETWEEN, range(len(tried)), np.log(tried))
    )
    return found


def bode(control: Control, axes: list[AxisLoops]) -> Any:
    """Return magnitude and phase of the open loops of an axis, a colour for each position."""
    figure = new_figure(8.0, 6.0)
    magnitude, phase = figure.subplots(2, 1, sharex=True)
    for k, (axis, place) in enumerate(zip(axes, control.places, strict=True)):
        frequencies = shown(axis)
        for name, L in axis.open_loops(frequencies).items():
            style = {"linestyle": STYLES[name], "linewidth": 0.9, "color": f"C{k % 10}"}
            label = f"{name}, {place_text(place.place)}" if len(axes) > 1 else name
            magnitude.loglog(frequencies, np.abs(L), label=label, **style)
            phase.semilogx(frequencies, np.degrees(np.unwrap(np.angle(L))), **style)
    magnitude.axhline(1.0, color="0.5", linewidth=0.6)
    magnitude.set_ylim(bottom=1e-4)
    magnitude.set_ylabel("open loop")
    phase.set_ylabel("phase, deg")
    phase.set_xlabel("frequency, Hz")
    for axis_ in (magnitude, phase):
        axis_.grid(True, which="both", linewidth=0.3)
    magnitude.legend(fontsize="x-small")
    magnitude.set_title(f"open loops of {axes[0].cascade.motor}")
    return figure


def nyquist(control: Control, axes: list[AxisLoops]) -> Any:
    """Return the open loops of an axis in the complex plane near -1, with the circles of their distances."""
    figure = new_figure(6.0, 6.0)
    plane = figure.add_subplot()
    turn = np.exp(1j * np.linspace(0, 2 * np.pi, 200))
    for name, distance in (("velocity", control.distances.velocity), ("position", control.distances.position)):
        circle = -1 + distance * turn
        plane.plot(circle.real, circle.imag, STYLES[name], color="0.6", linewidth=0.8)
    for k, axis in enumerate(axes):
        for name, L in axis.open_loops(shown(axis)).items():
            plane.plot(L.real, L.imag, STYLES[name], color=f"C{k % 10}", linewidth=0.9, label=name if k == 0 else None)
    plane.plot([-1], [0], "+", color="black")
    plane.set_xlim(-1 - FURTHEST, -1 + FURTHEST)
    plane.set_ylim(-FURTHEST, FURTHEST)
    plane.set_aspect("equal")
    plane.grid(True, linewidth=0.3)
    plane.set_xlabel("real part")
    plane.set_ylabel("imaginary part")
    plane.legend(fontsize="x-small")
    plane.set_title(f"open loops of {axes[0].cascade.motor}, circles at their distances to -1", fontsize="small")
    return figure


def compliances(control: Control) -> Any:
    """Return the displacement of each output by a force there over the frequency, all loops closed."""
    figure = new_figure(8.0, 4.0)
    axis = figure.add_subplot()
    names = [one.output for one in control.places[0].compliances]
    for k, (plant, place) in enumerate(zip(control.plants, control.places, strict=True)):
        grid = shown(loops_of(plant, control.cascades)[0])
        for i, name in enumerate(names):
            row = position_row(plant.linear, name)
            moved = plant.response(laplace(grid), control.cascades, row, row)
            label = f"{name}, {place_text(place.place)}" if len(control.places) > 1 else name
            if np.abs(moved).any():
                axis.loglog(grid, np.abs(moved), linewidth=0.9, color=f"C{k % 10}", linestyle=("-", "--", ":")[i % 3],
                            label=label)  # fmt: skip
    units = dict.fromkeys(one.unit for one in control.places[0].compliances)
    axis.set_ylabel(f"compliance, {' or '.join(units)}")
    axis.set_xlabel("frequency, Hz")
    axis.grid(True, which="both", linewidth=0.3)
    axis.legend(fontsize="x-small")
    axis.set_title(f"{control.machine}: compliance with all loops closed")
    return figure
