"""Plots of drives: open loops (Bode, Nyquist), sensitivities, compliances with loops closed, stability lobes."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np

from symoro_elastic.analysis.control.cascade import laplace
from symoro_elastic.analysis.control.control import Control
from symoro_elastic.analysis.control.lobes import Lobes
from symoro_elastic.analysis.control.loops import AxisLoops, Margins, loops_of
from symoro_elastic.analysis.control.plant import position_row
from symoro_elastic.analysis.control.views import place_text
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.pictures import Plot
from symoro_elastic.foundation.plot_style import (
    MOST_NAMED,
    RIGHT_ANGLE,
    TWENTY_DECIBELS,
    curve,
    curves,
    legend,
    logarithmic,
    mark_multiples,
    shades,
    y_label,
)
from symoro_elastic.foundation.results import figures_of
from symoro_elastic.quantities.units import MICRO

FURTHEST = 3.0
"""Half the width of a Nyquist diagram around -1."""
HIGHEST = 8.0
"""Of the depth that is stable at all speeds: the end of the axis of lobes."""
SLOWEST, BETWEEN = 0.1, 6
"""Hz from which on loops are drawn; how finely frequencies that are tried are divided."""
LEAST_DECIBELS = -80.0
"""Of the axis of open loops."""
STYLES = {"velocity": "-", "position": "--"}


@figures_of.register
def _(control: Control) -> dict[str, Plot | str]:
    """Return open_loops_<motor>, nyquist_<motor> and sensitivity_<motor> for each axis, and compliances."""
    plots: dict[str, Plot | str] = {}
    by_place = [loops_of(plant, control.cascades) for plant in control.plants]
    for k, cascade in enumerate(control.cascades):
        axes = [loops[k] for loops in by_place]
        title = f"{control.machine}: open loops of {cascade.motor}"
        near = f"{title}, least distances to -1, circles: required ones"
        margins = [[place.axes[k].velocity, place.axes[k].position] for place in control.places]
        draw = partial(_bode, control, axes, margins)
        plots[f"open_loops_{cascade.motor}"] = Plot(f"{title}, with margins", draw, 2, size=(8.0, 5.5))
        plots[f"nyquist_{cascade.motor}"] = Plot(near, partial(_nyquist, control, axes), size=(7.5, 5.8))
        largest = f"{control.machine}: sensitivity 1/|1 + L| of {cascade.motor}, horizontal lines: largest ones allowed"
        plots[f"sensitivity_{cascade.motor}"] = Plot(largest, partial(_sensitivity, control, axes), size=(8.0, 4.2))
    title = f"{control.machine}: compliance with all loops closed"
    return plots | {"compliances": Plot(title, partial(_compliances, control), size=(8.0, 4.2))}


@figures_of.register
def _(lobes: Lobes) -> dict[str, Plot | str]:
    """Return the plot stability_lobes: depths and chatter frequencies over the spindle speed."""
    title = f"{lobes.machine}: stability lobes along {', '.join(lobes.cut.forces)}, stable below"
    return {"stability_lobes": Plot(title, partial(_lobes, lobes), 2, size=(8.0, 5.5), ratios=(2, 1))}


def _lobes(lobes: Lobes, depth: Any, waves: Any) -> None:
    for k, place in enumerate(lobes.places):
        look, label = curve(k), place_text(place.place) if len(lobes.places) > 1 and k < MOST_NAMED else None
        depth.plot(lobes.speeds, np.where(np.isfinite(place.depths), 1e3 * place.depths, np.nan), label=label, **look)
        if place.periodic is not None:
            by_intervals = np.where(np.isfinite(place.periodic), 1e3 * place.periodic, np.nan)
            depth.plot(lobes.speeds, by_intervals, ".", markersize=3, color=look["color"])
        depth.axhline(1e3 * place.least, linewidth=0.6, label="" if k else "stable at every speed", **look)
        waves.plot(lobes.speeds, place.waves, ".", markersize=2, color=look["color"])
    depth.set_ylim(0, HIGHEST * 1e3 * min(place.least for place in lobes.places))
    y_label(depth, "depth", "mm")
    y_label(waves, "chatter frequency", "Hz")
    for axis in (depth, waves):
        logarithmic(axis, "x")
    waves.set_xlabel("spindle speed, turns per minute")
    legend(depth)


def plot_frequencies(axis: AxisLoops) -> Array:
    """Return the frequencies of drawn curves: those of the search, and some between."""
    coarse = axis.frequencies[axis.frequencies >= SLOWEST]
    places = np.arange((len(coarse) - 1) * BETWEEN + 1) / BETWEEN
    return np.asarray(np.exp(np.interp(places, range(len(coarse)), np.log(coarse))))


def decibels(x: Any) -> Array:
    """Return 20 log10 of magnitudes."""
    with np.errstate(divide="ignore"):
        return np.asarray(20 * np.log10(np.abs(x)))


def _bode(control: Control, axes: list[AxisLoops], margins: list[list[Margins]], magnitude: Any, phase: Any) -> None:
    """Draw magnitude and phase of the open loops of an axis with their margins, a colour for each position."""
    for k, (axis, place, of_loops) in enumerate(zip(axes, control.places, margins, strict=True)):
        frequencies = plot_frequencies(axis)
        for (name, L), margin in zip(axis.open_loops(frequencies).items(), of_loops, strict=True):
            look = {"linestyle": STYLES[name], "color": curve(k)["color"]}
            label = f"{name}, {place_text(place.place)}" if len(axes) > 1 else name
            degrees = np.degrees(np.unwrap(np.angle(L)))
            magnitude.plot(frequencies, decibels(L), label=label if k < MOST_NAMED / 2 else None, **look)
            phase.plot(frequencies, degrees, **look)
            _draw_margins(margin, frequencies, degrees, look["color"], magnitude, phase)
    logarithmic(magnitude, "x")
    logarithmic(phase, "x")
    magnitude.axhline(0.0, color=shades().grey, linewidth=0.8)
    mark_multiples(magnitude, TWENTY_DECIBELS)
    magnitude.set_ylim(bottom=LEAST_DECIBELS)
    mark_multiples(phase, RIGHT_ANGLE)
    y_label(magnitude, "open loop", "dB")
    y_label(phase, "phase", "deg")
    phase.set_xlabel("frequency, Hz")
    legend(magnitude)


def _draw_margins(margin: Margins, frequencies: Array, degrees: Array, color: str, magnitude: Any, phase: Any) -> None:
    """Draw the gain margin from 0 dB, and the phase margin from the nearest odd multiple of 180 deg."""
    look: dict[str, Any] = {"color": color, "marker": "o", "markersize": 3, "linewidth": 2.2}
    if np.isfinite(margin.gain_frequency):
        magnitude.plot([margin.gain_frequency] * 2, [0.0, -decibels(margin.gain)], **look)
    if np.isfinite(margin.phase_frequency):
        at = float(np.interp(margin.phase_frequency, frequencies, degrees))
        phase.plot([margin.phase_frequency] * 2, [360 * np.floor(at / 360) + 180, at], **look)


def _nyquist(control: Control, axes: list[AxisLoops], plane: Any) -> None:
    """Draw the open loops of an axis near -1, their least distances to it, and the required ones as circles."""
    turn = np.exp(1j * np.linspace(0, 2 * np.pi, 200))
    for name, distance in (("velocity", control.distances.velocity), ("position", control.distances.position)):
        circle = -1 + distance * turn
        plane.plot(circle.real, circle.imag, STYLES[name], color=shades().grey, linewidth=0.8)
    for k, axis in enumerate(axes):
        for name, L in axis.open_loops(plot_frequencies(axis)).items():
            plane.plot(L.real, L.imag, STYLES[name], color=curve(k)["color"], label=name if k == 0 else None)
            nearest, look = L[np.argmin(np.abs(1 + L))], {"markersize": 3, "linewidth": 0.8}
            plane.plot([-1, nearest.real], [0, nearest.imag], "o-", color=curve(k)["color"], **look)
    plane.plot([-1], [0], "+", color=shades().ink, markersize=8)
    plane.set_xlim(-1 - FURTHEST, -1 + FURTHEST)
    plane.set_ylim(-FURTHEST, FURTHEST)
    plane.set_aspect("equal")
    plane.set_xlabel("real part")
    plane.set_ylabel("imaginary part")
    legend(plane)


def _sensitivity(control: Control, axes: list[AxisLoops], magnitude: Any) -> None:
    """Draw how much the loops of an axis reduce or enlarge an error, and the inverses of the required distances."""
    for k, axis in enumerate(axes):
        frequencies = plot_frequencies(axis)
        for name, L in axis.open_loops(frequencies).items():
            label = name if k == 0 else None
            magnitude.plot(frequencies, -decibels(1 + L), STYLES[name], color=curve(k)["color"], label=label)
    for name, distance in (("velocity", control.distances.velocity), ("position", control.distances.position)):
        magnitude.axhline(-decibels(distance), linestyle=STYLES[name], color=shades().grey, linewidth=0.8)
    logarithmic(magnitude, "x")
    mark_multiples(magnitude, TWENTY_DECIBELS)
    magnitude.set_ylim(bottom=LEAST_DECIBELS)
    y_label(magnitude, "sensitivity", "dB")
    magnitude.set_xlabel("frequency, Hz")
    legend(magnitude)


def _compliances(control: Control, axis: Any) -> None:
    """Draw the displacements of outputs by forces there over the frequency, all loops closed."""
    names = [compliance.output for compliance in control.places[0].compliances]
    columns: list[Array] = []
    labels: list[str] = []
    for plant, place in zip(control.plants, control.places, strict=True):
        grid = plot_frequencies(loops_of(plant, control.cascades)[0])
        for name in names:
            row = position_row(plant.linear, name)
            moved = np.abs(plant.response(laplace(grid), control.cascades, row, row))
            if moved.any():
                columns.append(np.stack([grid, MICRO * moved]))
                labels.append(f"{name}, {place_text(place.place)}" if len(control.places) > 1 else name)
    for k, ((grid, moved), label) in enumerate(zip(columns, labels, strict=True)):
        curves(axis, grid, moved[:, None], [label] if k < MOST_NAMED else [""], k)
    units = dict.fromkeys(f"u{compliance.unit}" for compliance in control.places[0].compliances)
    y_label(axis, "compliance", " or ".join(units))
    axis.set_xlabel("frequency, Hz")
    if columns:
        logarithmic(axis, "x", "y")
    legend(axis)
