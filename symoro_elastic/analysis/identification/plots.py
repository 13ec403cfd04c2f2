"""Plots of an identification: torques measured and predicted, residuals, relative standard deviations.

And of an exciting motion: positions, velocities and accelerations within their limits, the search for it.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from symoro_elastic.analysis.identification.estimation import Verdict
from symoro_elastic.analysis.identification.excitation import Excitation
from symoro_elastic.analysis.identification.identified import Identified
from symoro_elastic.analysis.identification.identify import Identification
from symoro_elastic.analysis.identification.trajectory import ExcitingTrajectory
from symoro_elastic.foundation.pictures import new_figure
from symoro_elastic.foundation.results import figures_of
from symoro_elastic.machine.machine import Joint, Kind

VERDICT_COLOURS = {Verdict.IDENTIFIED: "#2a7f62", Verdict.POOR: "#d98e04", Verdict.NOT: "#b3b3b3"}
DARK, LIGHT = "#14365d", "#9aa5b1"
MEASURED_STYLE = {"color": "#e3b261", "linewidth": 3.0}
PREDICTED_STYLE = {"color": DARK, "linewidth": 0.8}
MOST_BARS = 80
LARGEST_BAR = 1000.0  # per cent


@figures_of.register
def _(result: Identification) -> dict[str, Any]:
    return {"torques": torques(result), "residuals": residuals(result), "parameters": parameters(result)}


@figures_of.register
def _(result: Identified) -> dict[str, Any]:
    return dict(figures_of(result.found))


@figures_of.register
def _(found: ExcitingTrajectory) -> dict[str, Any]:
    return {"trajectory": motion(found), "search": search(found.best)}


def motion(found: ExcitingTrajectory) -> Any:
    """Return position, velocity and acceleration of each motor, with their limits."""
    sampled, limits, motors = found.sampled, found.limits, found.machine.motor_joints
    figure = new_figure(2.0 + 3.0 * len(motors), 6.0)
    axes = figure.subplots(3, len(motors), sharex=True, squeeze=False)
    rows = (
        ("", sampled.q, limits.low, limits.high),
        ("/s", sampled.qd, -limits.velocity, limits.velocity),
        ("/s2", sampled.qdd, -limits.acceleration, limits.acceleration),
    )
    for row, (per, block, low, high) in zip(axes, rows, strict=True):
        for k, (axis, joint) in enumerate(zip(row, motors, strict=True)):
            axis.plot(sampled.t, block[:, k], color=DARK, linewidth=0.8)
            for limit in (low[k], high[k]):
                axis.axhline(limit, color=LIGHT, linewidth=0.8, linestyle="--")
            axis.set_ylabel(f"{joint.name}, {joint.unit}{per}")
    for axis in axes[-1]:
        axis.set_xlabel("t, s")
    figure.suptitle(f"{found.machine.name}: exciting motion and its limits")
    return figure


def search(excitation: Excitation) -> Any:
    """Return the best condition number after each evaluation."""
    figure = new_figure(6.0, 3.5)
    axis = figure.add_subplot()
    axis.semilogy(range(1, len(excitation.history) + 1), excitation.history, color=DARK)
    axis.set_xlabel("motions tried")
    axis.set_ylabel("condition number of the regressor")
    return figure


def torques(result: Identification) -> Any:
    """Return measured and predicted torque of each motor; of other joints, spring torque and all else."""
    joints = result.machine.independent_joints
    figure, axes = _stacked_axes(len(joints))
    for axis, (k, joint) in zip(axes, enumerate(joints), strict=True):
        used = _used(result, k)
        left, right = _sides(result, k, joint)
        for side, label, style in zip((left, right), _words(joint), (MEASURED_STYLE, PREDICTED_STYLE), strict=True):
            axis.plot(result.t, np.where(used, side, np.nan), label=label, **style)
        axis.set_ylabel(f"{joint.name}, {joint.force_unit}")
        axis.legend(loc="lower left", bbox_to_anchor=(0, 1), ncols=2, fontsize="x-small", frameon=False)
    axes[-1].set_xlabel("t, s")
    figure.suptitle(f"{result.machine.name}: both sides of tau = Y X")
    return figure


def residuals(result: Identification) -> Any:
    """Return tau - Y X of each joint, with two standard deviations."""
    joints = result.machine.independent_joints
    figure, axes = _stacked_axes(len(joints))
    solution = result.estimation.solution
    for axis, (k, joint) in zip(axes, enumerate(joints), strict=True):
        used, sigma = _used(result, k), float(solution.sigma[k])
        axis.axhspan(-2 * sigma, 2 * sigma, color=LIGHT, alpha=0.25, linewidth=0)
        axis.plot(result.t[used], solution.residuals[used, k], ".", color=DARK, markersize=1.5)
        axis.set_ylabel(f"{joint.name}, {joint.force_unit}")
    axes[-1].set_xlabel("t, s")
    figure.suptitle(f"{result.machine.name}: residuals, band of two standard deviations")
    return figure


def parameters(result: Identification) -> Any:
    """Return relative standard deviations as bars, coloured by verdict, empty where not identifiable."""
    shown = result.estimates[:MOST_BARS]
    figure = new_figure(8.0, 1.2 + 0.2 * len(shown))
    axis = figure.add_subplot()
    sizes = [100 * e.relative if np.isfinite(e.relative) else LARGEST_BAR for e in shown]
    for verdict, colour in VERDICT_COLOURS.items():
        rows = [k for k, e in enumerate(shown) if e.verdict is verdict]
        if not rows:
            continue
        empty = {"fill": False, "hatch": "///"} if verdict is Verdict.NOT else {}
        axis.barh(
            rows,
            [min(sizes[k], LARGEST_BAR) for k in rows],
            color=colour,
            edgecolor=colour,
            label=str(verdict),
            **empty,
        )
    axis.set_yticks(range(len(shown)), [e.unknown.label for e in shown], fontsize="x-small")
    axis.invert_yaxis()
    axis.set_xscale("log")
    axis.axvline(10.0, color="black", linewidth=0.6, linestyle=":")
    axis.set_xlabel("relative standard deviation, %")
    axis.set_title(f"{result.machine.name}: standard deviations")
    axis.legend(fontsize="x-small")
    return figure


def _used(result: Identification, k: int) -> Any:
    """Return a mask of the samples that were used for joint k."""
    solution = result.estimation.solution
    used = (solution.predicted[:, k] != 0.0) | (result.tau[:, k] != 0.0)
    return used if used.any() else np.ones_like(used)


def _sides(result: Identification, k: int, joint: Joint) -> tuple[Any, Any]:
    """Return both sides of the equation of joint k; without a motor, springs and dampers against the rest."""
    predicted = result.estimation.solution.predicted[:, k]
    if joint.kind is Kind.MOTOR:
        return result.tau[:, k], predicted
    springs = result.springs[:, k]
    return -springs, predicted - springs - result.tau[:, k]


def _words(joint: Joint) -> tuple[str, str]:
    return ("measured", "predicted") if joint.kind is Kind.MOTOR else ("springs", "inertia and gravity")


def _stacked_axes(count: int) -> tuple[Any, list[Any]]:
    figure = new_figure(8.0, 1.0 + 1.5 * count)
    axes = figure.subplots(count, 1, sharex=True, squeeze=False)
    return figure, list(axes[:, 0])
