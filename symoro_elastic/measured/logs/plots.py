"""Plots of an identification: torques measured and predicted, residuals and their spectra, standard deviations.

And of an exciting motion: positions, velocities and accelerations within their limits, the search for it.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import Any

import numpy as np

from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.pictures import Plot
from symoro_elastic.foundation.plot_style import curve, curves, legend, logarithmic, shades, shorten, y_label
from symoro_elastic.foundation.results import figures_of
from symoro_elastic.machine.machine import Joint, Kind
from symoro_elastic.measured.fitting.estimates import Verdict
from symoro_elastic.measured.logs.excitation import Excitation
from symoro_elastic.measured.logs.identified import Identified
from symoro_elastic.measured.logs.result import Identification
from symoro_elastic.measured.logs.trajectory import ExcitingTrajectory

VERDICTS = {Verdict.IDENTIFIED: "good", Verdict.POOR: "doubtful", Verdict.NOT: "grey"}
MOST_BARS = 80  # parameters in a plot
MOST_PANELS = 10  # joints in a plot
LARGEST_BAR = 1000.0  # per cent
FEWEST = 16  # fewest samples of a spectrum


@figures_of.register
def _(result: Identification) -> dict[str, Plot | str]:
    """Return the plots of an identification: torques, residuals, spectra and parameters."""
    joints = _panels(len(result.machine.independent_joints))
    size = (8.0, 1.2 + 1.5 * len(joints))
    name, count = result.machine.name, len(joints)
    some = "" if count == len(result.machine.independent_joints) else f"; the first {count} joints"

    def panels(what: str, draw: Any) -> Plot:
        return Plot(f"{name}: {what}{some}", partial(draw, result), count, size=size)

    return {
        "torques": panels("both sides of tau = Y X", _torques),
        "residuals": panels("residuals tau - Y X, band of two standard deviations", _residuals),
        "spectra": _of_spectra(result),
        "parameters": _of_parameters(result),
    }


@figures_of.register
def _(result: Identified) -> dict[str, Plot | str]:
    return dict(figures_of(result.found))


@figures_of.register
def _(found: ExcitingTrajectory) -> dict[str, Plot | str]:
    """Return the plots of an exciting trajectory: the motion and the search."""
    count = len(_panels(len(found.machine.motor_joints), 6))
    some = "" if count == len(found.machine.motor_joints) else f"; the first {count} motors"
    title = f"{found.machine.name}: exciting motion and its limits{some}"
    searched = f"{found.machine.name}: search for the exciting motion"
    return {
        "trajectory": Plot(title, partial(_motion, found, count), 3, count, size=(2.0 + 2.8 * count, 6.0)),
        "search": Plot(searched, partial(_search, found.best), size=(7.0, 4.0)),
    }


def _panels(count: int, most: int = MOST_PANELS) -> range:
    return range(min(count, most))


def _motion(trajectory: ExcitingTrajectory, count: int, *axes: Any) -> None:
    """Draw positions, velocities and accelerations by motor, with their limits."""
    sampled, limits, motors = trajectory.sampled, trajectory.limits, trajectory.machine.motor_joints[:count]
    rows = (
        ("", sampled.q, limits.low, limits.high),
        ("/s", sampled.qd, -limits.velocity, limits.velocity),
        ("/s2", sampled.qdd, -limits.acceleration, limits.acceleration),
    )
    grid = np.reshape(np.array(axes, dtype=object), (3, count))
    for row, (per, block, low, high) in zip(grid, rows, strict=True):
        for k, (axis, joint) in enumerate(zip(row, motors, strict=True)):
            axis.plot(sampled.t, block[:, k], **curve(0))
            for limit in (low[k], high[k]):
                axis.axhline(limit, color=shades().grey, linewidth=0.9, linestyle="--")
            y_label(axis, joint.name, f"{joint.unit}{per}")
    for axis in grid[-1]:
        axis.set_xlabel("time, s")


def _search(excitation: Excitation, axis: Any) -> None:
    """Draw the best condition number after each evaluation."""
    axis.plot(range(1, len(excitation.history) + 1), excitation.history, **curve(0))
    logarithmic(axis, "y")
    axis.set_xlabel("motions tried")
    axis.set_ylabel("condition number of the regressor")


def _torques(result: Identification, *axes: Any) -> None:
    """Draw measured and predicted torques by motor; for other joints, spring torques and the remaining ones."""
    joints = result.machine.independent_joints
    styles = ({**curve(0), "linewidth": 2.6, "alpha": 0.55}, {"color": shades().ink, "linewidth": 0.8})
    for axis, (k, joint) in zip(axes, enumerate(joints), strict=False):
        used = _used_rows(result, k)
        for side, label, look in zip(_sides(result, k, joint), _words(joint), styles, strict=True):
            axis.plot(result.t, np.where(used, side, np.nan), label=label, **look)
        y_label(axis, joint.name, joint.force_unit)
        legend(axis)
    axes[-1].set_xlabel("time, s")


def _residuals(result: Identification, *axes: Any) -> None:
    """Draw tau - Y X by joint, with two standard deviations."""
    joints = result.machine.independent_joints
    solution = result.estimation.solution
    for axis, (k, joint) in zip(axes, enumerate(joints), strict=False):
        used, sigma = _used_rows(result, k), float(solution.sigma[k])
        axis.axhspan(-2 * sigma, 2 * sigma, color=shades().grey, alpha=0.25, linewidth=0)
        axis.plot(result.t[used], solution.residuals[used, k], ".", color=curve(0)["color"], markersize=1.5)
        y_label(axis, joint.name, joint.force_unit)
    axes[-1].set_xlabel("time, s")


def _of_spectra(result: Identification) -> Plot | str:
    """Return the spectra of residuals: flat where they are noise; a peak is motion that the model leaves out."""
    steps = np.diff(result.t)
    if len(steps) < FEWEST or np.ptp(steps) > 0.01 * np.median(steps):
        return "the samples are few, or not evenly spaced: no spectrum"
    title = f"{result.machine.name}: spectra of the residuals, flat for noise"
    return Plot(title, partial(_spectra, result), size=(8.0, 4.2))


def _spectra(result: Identification, axis: Any) -> None:
    """Draw amplitudes of residuals over frequency in multiples of their root mean square, by a Hann window."""
    residuals: Array = result.estimation.solution.residuals
    f = np.fft.rfftfreq(len(result.t), float(np.median(np.diff(result.t))))[1:]
    size = np.sqrt(np.mean(residuals**2, axis=0))
    nonzero = np.flatnonzero(size > 0)
    window = np.hanning(len(result.t))[:, None]
    amplitudes = np.abs(np.fft.rfft(residuals[:, nonzero] * window, axis=0))[1:]
    relative = amplitudes / (size[nonzero] * np.sqrt(np.sum(window**2)))
    curves(axis, f, relative, [result.machine.independent_joints[k].name for k in nonzero])
    if len(nonzero):
        logarithmic(axis, "x", "y")
    axis.set_xlabel("frequency, Hz")
    axis.set_ylabel("amplitude, 1 for white noise")
    legend(axis)


def _of_parameters(result: Identification) -> Plot:
    """Return relative standard deviations as bars, by verdict."""
    count = min(MOST_BARS, len(result.estimates))
    title = f"{result.machine.name}: standard deviations of parameters"
    title += f"; {count} of {len(result.estimates)}" if count < len(result.estimates) else ""
    return Plot(title, partial(_parameters, result), size=(8.0, 1.4 + 0.2 * count))


def _parameters(result: Identification, axis: Any) -> None:
    """Draw bars coloured by verdict, empty where not identifiable."""
    shown = result.estimates[:MOST_BARS]
    sizes = [100 * e.relative if np.isfinite(e.relative) else LARGEST_BAR for e in shown]
    for verdict, shade in VERDICTS.items():
        rows = [k for k, e in enumerate(shown) if e.verdict is verdict]
        if rows:
            colour = getattr(shades(), shade)
            empty = {"fill": False, "hatch": "///"} if verdict is Verdict.NOT else {}
            lengths = [min(sizes[k], LARGEST_BAR) for k in rows]
            axis.barh(rows, lengths, color=colour, edgecolor=colour, label=str(verdict), **empty)
    names: Sequence[str] = [shorten(e.unknown.label) for e in shown]
    axis.set_yticks(range(len(shown)), names, fontsize=7)
    axis.set_ylim(len(shown) - 0.4, -0.6)
    logarithmic(axis, "x")
    axis.axvline(10.0, color=shades().ink, linewidth=0.8, linestyle=":")
    axis.set_xlabel("relative standard deviation, %")
    legend(axis)


def _used_rows(result: Identification, k: int) -> Any:
    """Return a mask of the samples that were used for joint k."""
    solution = result.estimation.solution
    used = (solution.predicted[:, k] != 0.0) | (result.tau[:, k] != 0.0)
    return used if used.any() else np.ones_like(used)


def _sides(result: Identification, k: int, joint: Joint) -> tuple[Any, Any]:
    """Return both sides of joint k's equation; without a motor, springs and dampers against the remaining terms."""
    predicted = result.estimation.solution.predicted[:, k]
    if joint.kind is Kind.MOTOR:
        return result.tau[:, k], predicted
    springs = result.springs[:, k]
    return -springs, predicted - springs - result.tau[:, k]


def _words(joint: Joint) -> tuple[str, str]:
    return ("measured", "predicted") if joint.kind is Kind.MOTOR else ("springs", "inertia and gravity")
