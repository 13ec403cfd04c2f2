"""Plots of a simulated motion: its outputs, their deviation from the reference and its spectrum, energies, motors."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np

from symoro_elastic.analysis.simulation.simulated import FORMS, Simulation, Simulations
from symoro_elastic.analysis.simulation.tolerances import unit_of
from symoro_elastic.analysis.time_series.plots import torque_speed
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.pictures import Plot, numbered_figures
from symoro_elastic.foundation.plot_style import by_unit, curve, curves, legend, logarithmic, shades, y_label
from symoro_elastic.foundation.results import figures_of

LEAST_OF_SPECTRUM = 1e-9
"""Of the largest amplitude of an output, for a frequency to be drawn."""


@figures_of.register
def _(run: Simulation) -> dict[str, Plot | str]:
    outputs = {"outputs": _over_time(run, run.outputs, "outputs"), **_of_motors(run)}
    energy = {"energy": _plot(run, "energies, from the start", partial(_energies, run), 1)}
    if run.is_exact:
        return {**outputs, **energy}
    what = "deviation from the reference motion"
    return {
        **outputs,
        "deviation": _over_time(run, run.deviation, what),
        "spectrum": _plot(run, f"spectrum of the {what}", partial(_spectrum, run), 1),
        **energy,
    }


@figures_of.register
def _(runs: Simulations) -> Mapping[str, Plot | str]:
    """Return the plots of all motions, numbered where there are several."""
    return runs[0].plots().all if len(runs) == 1 else numbered_figures(run.plots() for run in runs).all


def _plot(run: Simulation, what: str, draw: Any, rows: int) -> Plot:
    return Plot(f"{run.reference.machine.name}: {what}", draw, rows, size=(8.0, 1.6 + 2.4 * rows))


def _of_motors(run: Simulation) -> dict[str, Plot | str]:
    """Return torques and powers of the motors over time, and torques over speeds."""
    joints = run.reference.machine.motor_joints
    if not joints:
        return {}
    units, motors, tau = [joint.force_unit for joint in joints], run.reference.motors, run.motion.tau
    _, rates = run.reference.of_motors(run.motion)
    title = f"{run.reference.machine.name}: torques and forces of the motors over their speeds"
    return {
        "torques": _columns(run, motors, units, tau, "torques and forces of the motors", FORCES),
        "powers": _columns(run, motors, ["W"] * len(motors), run.powers, "powers of the motors", {"W": "power"}),
        "torque_speed": torque_speed(title, motors, rates, tau, [f"{joint.unit}/s" for joint in joints], units),
    }


def _over_time(run: Simulation, columns: Array, title: str) -> Plot:
    """Return columns (N, names) of the outputs over time, one diagram for each unit."""
    units = [unit_of(run.reference.machine, name) for name in run.names]
    words = FORCES | dict.fromkeys({*units} - FORCES.keys(), title.partition(" ")[0].removesuffix("s"))
    return _columns(run, run.names, units, columns, title, words)


FORCES = {"N": "force", "N m": "torque"}


def _columns(
    run: Simulation, names: Sequence[str], units: Sequence[str], columns: Array, title: str, words: Mapping[str, str]
) -> Plot:
    """Return columns (N, names) over time, one diagram for each unit and its quantity."""
    grouped = by_unit(units)
    return _plot(run, title, partial(_draw_columns, run, names, grouped, columns, words), len(grouped))


def _draw_columns(
    run: Simulation,
    names: Sequence[str],
    grouped: dict[str, list[int]],
    columns: Array,
    words: Mapping[str, str],
    *axes: Any,
) -> None:
    for axis, (unit, which) in zip(axes, grouped.items(), strict=True):
        curves(axis, run.motion.t, columns[:, which], [names[k] for k in which])
        y_label(axis, words[unit], unit)
        legend(axis)
        for crossing in run.crossings:
            axis.axvline(crossing.t, color=shades().grey, linewidth=0.6, linestyle=":")
    axes[-1].set_xlabel("time, s")


def _spectrum(run: Simulation, axis: Any) -> None:
    """Draw the amplitudes of the deviations over frequency, each relative to its largest, by a Hann window."""
    t = run.motion.t
    frequencies = np.fft.rfftfreq(len(t), float(t[-1] - t[0]) / (len(t) - 1))[1:]
    x = run.deviation - run.deviation.mean(axis=0)
    amplitudes = np.abs(np.fft.rfft(x * np.hanning(len(t))[:, None], axis=0))[1:]
    largest = amplitudes.max(axis=0, initial=0.0)
    moving = np.flatnonzero(largest > 0)
    relative = amplitudes[:, moving] / largest[moving]
    relative[relative < LEAST_OF_SPECTRUM] = np.nan
    curves(axis, frequencies, relative, [run.names[k] for k in moving])
    if run.followed is not None:
        axis.axvline(run.followed, color=shades().ink, linewidth=0.8, linestyle="--", label="damped by the step above")
    if len(moving):
        logarithmic(axis, "x", "y")
    axis.set_xlabel("frequency, Hz")
    axis.set_ylabel("amplitude, of the largest")
    legend(axis)


def _energies(run: Simulation, axis: Any) -> None:
    """Draw kinetic, gravitational and spring energy over time, minus their start, and their sum."""
    changes = run.energy.energies - run.energy.energies[0]
    for k, (name, energy) in enumerate(zip(FORMS, changes.T, strict=True)):
        axis.plot(run.motion.t, energy, label=name, **curve(k))
    axis.plot(run.motion.t, changes.sum(axis=1), color=shades().ink, linestyle=(0, (1, 1)), label="sum")
    axis.set_xlabel("time, s")
    y_label(axis, "energy", "J")
    legend(axis)
