"""Plots of a simulated motion: its outputs, their deviation from the reference and its spectrum, energies."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from symoro_elastic.analysis.simulation.energy_balance import FORMS
from symoro_elastic.analysis.simulation.simulated import Simulation
from symoro_elastic.analysis.simulation.tolerances import unit_of
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.pictures import new_figure
from symoro_elastic.foundation.results import figures_of

LEAST_OF_SPECTRUM = 1e-9
"""Of the largest amplitude of an output, for a frequency to be drawn."""


@figures_of.register
def _(found: Simulation) -> dict[str, Any]:
    if found.is_exact:
        return {**_of_outputs(found), **_of_motors(found), "energy": energies(found)}
    return {
        **_of_outputs(found),
        **_of_motors(found),
        "deviation": _over_time(found, found.deviation, "deviation from the reference motion"),
        "spectrum": spectrum(found),
        "energy": energies(found),
    }


def _of_outputs(found: Simulation) -> dict[str, Any]:
    return {"outputs": _over_time(found, found.outputs, "outputs")}


def _of_motors(found: Simulation) -> dict[str, Any]:
    """Return torques and powers of the motors over time."""
    units = [joint.force_unit for joint in found.reference.machine.motor_joints]
    if not units:
        return {}
    motors = found.reference.motors
    return {
        "torques": _columns(found, motors, units, found.motion.tau, "torques and forces of the motors"),
        "powers": _columns(found, motors, ["W"] * len(motors), found.powers, "powers of the motors"),
    }


def _over_time(found: Simulation, columns: Array, title: str) -> Any:
    """Return columns (N, names) of the outputs over time, one diagram for each unit."""
    units = [unit_of(found.reference.machine, name) for name in found.names]
    return _columns(found, found.names, units, columns, title)


def _columns(found: Simulation, names: Sequence[str], units: Sequence[str], columns: Array, title: str) -> Any:
    """Return columns (N, names) over time, one diagram for each unit."""
    shown = list(dict.fromkeys(units))
    figure = new_figure(8.0, 1.0 + 2.5 * len(shown))
    axes = np.atleast_1d(figure.subplots(len(shown), 1, sharex=True))
    for k, (name, unit) in enumerate(zip(names, units, strict=True)):
        axes[shown.index(unit)].plot(found.motion.t, columns[:, k], linewidth=0.9, label=name, color=f"C{k % 10}")
    for axis, unit in zip(axes, shown, strict=True):
        axis.set_ylabel(unit)
        axis.legend(fontsize="x-small")
        axis.grid(True, linewidth=0.3)
        for crossing in found.crossings:
            axis.axvline(crossing.t, color="0.5", linewidth=0.6, linestyle=":")
    axes[0].set_title(title, fontsize="small")
    axes[-1].set_xlabel("time, s")
    return figure


def spectrum(found: Simulation) -> Any:
    """Return the amplitudes of the deviations over frequency, each relative to its largest, by a Hann window."""
    figure = new_figure(8.0, 4.0)
    axis = figure.add_subplot()
    t = found.motion.t
    frequencies = np.fft.rfftfreq(len(t), float(t[-1] - t[0]) / (len(t) - 1))[1:]
    window = np.hanning(len(t))
    for k, name in enumerate(found.names):
        x = found.deviation[:, k] - found.deviation[:, k].mean()
        amplitudes = np.abs(np.fft.rfft(x * window))[1:]
        largest = amplitudes.max(initial=0.0)
        if largest > 0:
            relative = np.where(amplitudes > LEAST_OF_SPECTRUM * largest, amplitudes / largest, np.nan)
            axis.loglog(frequencies, relative, linewidth=0.9, label=name, color=f"C{k % 10}")
    if found.followed is not None:
        axis.axvline(found.followed, color="0.3", linewidth=0.8, linestyle="--", label="damped by the step above")
    axis.set_xlabel("frequency, Hz")
    axis.set_ylabel("amplitude, of the largest")
    axis.set_title("spectrum of the deviation from the reference motion", fontsize="small")
    if axis.get_legend_handles_labels()[0]:
        axis.legend(fontsize="x-small")
    axis.grid(True, which="both", linewidth=0.3)
    return figure


def energies(found: Simulation) -> Any:
    """Return kinetic energy, that of gravity and that of springs over time, from the start, and their sum."""
    figure = new_figure(8.0, 4.0)
    axis = figure.add_subplot()
    changes = found.energy.energies - found.energy.energies[0]
    for name, energy in zip(FORMS, changes.T, strict=True):
        axis.plot(found.motion.t, energy, linewidth=0.9, label=name)
    axis.plot(found.motion.t, changes.sum(axis=1), color="black", linewidth=0.9, linestyle="--", label="sum")
    axis.set_xlabel("time, s")
    axis.set_ylabel("energy, J")
    axis.set_title("energies, from the start", fontsize="small")
    axis.legend(fontsize="x-small")
    axis.grid(True, linewidth=0.3)
    return figure
