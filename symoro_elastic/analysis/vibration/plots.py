"""Plots of vibrations: Bode diagrams, shares of energy, frequencies over positions."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from symoro_elastic.analysis.vibration.comparison import Compared, Comparison, Loss
from symoro_elastic.analysis.vibration.energies import kinetic_shares, strain_shares
from symoro_elastic.analysis.vibration.export import labels
from symoro_elastic.analysis.vibration.feed_forward import FeedForward
from symoro_elastic.analysis.vibration.modes import Modes
from symoro_elastic.analysis.vibration.responses import Response
from symoro_elastic.analysis.vibration.tracking import Tracked
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.pictures import new_figure
from symoro_elastic.foundation.results import figures_of

MOST_CURVES = 6
LEAST_SHOWN, LEAST_NUMBER, DARK = 0.005, 0.05, 0.6
"""Of a heat map: a row that is shown, a number that is written, a cell on which it is white."""


@figures_of.register
def _(response: Response) -> dict[str, Any]:
    """Return bode_<input> for each input."""
    return {f"bode_{label}": bode(response, j) for j, label in enumerate(labels(response.inputs))}


@figures_of.register
def _(modal: Modes) -> dict[str, Any]:
    """Return shapes and energies."""
    return {"shapes": shapes(modal), "energies": energies(modal)}


@figures_of.register
def _(tracked: Tracked) -> dict[str, Any]:
    """Return positions and shapes_over_positions; over two joints positions_<k>, one mode each."""
    vibrating = [k for k in range(tracked.frequencies.shape[1]) if tracked.frequencies[:, k].any()][:MOST_CURVES]
    if len(tracked.joints) == 1:
        return {"positions": over_one(tracked), "shapes_over_positions": shapes_over_one(tracked, vibrating)}
    return {f"positions_{k + 1}": over_two(tracked, k) for k in vibrating}


@figures_of.register
def _(command: FeedForward) -> dict[str, Any]:
    """Return feed_forward."""
    return {"feed_forward": following(command)}


@figures_of.register
def _(comparison: Comparison) -> dict[str, Any]:
    """Return torques of motors and accelerations of springs."""
    by_quantity = {name: [x for x in comparison.losses if x.quantity == name] for name in Compared}
    return {f"{name}s": losses(some, comparison.trajectory.t) for name, some in by_quantity.items() if some}


def bode(response: Response, j: int) -> Any:
    """Return magnitudes, a scale for each unit, and phases of all outputs to input j over the frequency."""
    source = response.inputs[j]
    units = list(dict.fromkeys(response.unit(name, source) for name in response.outputs))
    figure = new_figure(8.0, 3.0 + 2.5 * len(units))
    *magnitudes, phase = figure.subplots(len(units) + 1, 1, sharex=True)
    for i, name in enumerate(response.outputs):
        G = np.where(response.values[:, i, j] == 0, np.nan, response.values[:, i, j])
        unit = response.unit(name, source)
        shown = f"{name}, {unit}" if np.isfinite(G).any() else f"{name}: no response"
        axis, style = magnitudes[units.index(unit)], {"linewidth": 0.9, "color": f"C{i % 10}"}
        axis.loglog(response.frequencies, np.abs(G), label=shown, **style)
        phase.semilogx(response.frequencies, _phase(G), **style)
    for axis, unit in zip(magnitudes, units, strict=True):
        axis.set_ylabel(f"magnitude, {unit}")
        axis.legend(fontsize="x-small")
    phase.set_ylabel("phase, deg")
    phase.set_xlabel("frequency, Hz")
    for axis in (*magnitudes, phase):
        axis.grid(True, which="both", linewidth=0.3)
    magnitudes[0].set_title(f"from {source}")
    return figure


def _phase(G: Any) -> Array:
    """Return the continuous phase in degrees, starting within -270 and 90; gaps stay gaps."""
    degrees = np.full(len(G), np.nan)
    there = np.isfinite(G)
    if there.any():
        phase = np.degrees(np.unwrap(np.angle(G[there])))
        degrees[there] = phase - (360.0 if phase[0] > 90.0 else 0.0)
    return degrees


def shapes(modal: Modes) -> Any:
    """Return mode shapes in joint coordinates, each weighted by the mass of its joint so that units compare."""
    names = modal.linear.coordinates
    weighted = np.sqrt(np.diag(modal.linear.M))[:, None] * modal.shapes
    weighted = weighted / np.abs(weighted).max(axis=0, initial=0.0)
    title = "mode shapes: motion of each joint times the root of its inertia, the largest being 1"
    return _picture(weighted, names, modal, "RdBu_r", -1.0, title, "{:.2f}")


def energies(modal: Modes) -> Any:
    """Return the shares of strain energy by spring and of kinetic energy by body."""
    strain, kinetic = strain_shares(modal), kinetic_shares(modal)
    both = np.vstack([strain.shares, kinetic.shares])
    names = (*(f"strain {name}" for name in strain.names), *(f"kinetic {name}" for name in kinetic.names))
    return _picture(both, names, modal, "Blues", 0.0, "shares of energy in springs and bodies", "{:.0%}")


def _picture(
    values: Array, rows: tuple[str, ...], modal: Modes, colours: str, low: float, title: str, form: str
) -> Any:
    """Return a heat map with numbers; rows without anything to see are left out."""
    kept = [k for k in range(len(rows)) if np.abs(values[k]).max(initial=0.0) >= LEAST_SHOWN]
    values, count = values[kept], values.shape[1]
    figure = new_figure(3.0 + 0.6 * count, 2.0 + 0.25 * len(kept))
    axis = figure.add_subplot()
    image = axis.imshow(values, cmap=colours, vmin=low, vmax=1.0, aspect="auto")
    for row, k in np.argwhere(np.abs(values) >= LEAST_NUMBER):
        colour = "white" if abs(values[row, k]) > DARK else "black"
        axis.text(k, row, form.format(values[row, k]), ha="center", va="center", fontsize=6, color=colour)
    axis.set_yticks(range(len(kept)), [rows[k] for k in kept], fontsize="x-small")
    axis.set_xticks(range(count), [_column(modal, k) for k in range(count)], fontsize="x-small", rotation=60)
    axis.set_xlabel("mode")
    axis.set_title(title, fontsize="small", loc="right")
    figure.colorbar(image, ax=axis)
    return figure


def _column(modal: Modes, k: int) -> str:
    """Return number and frequency of a mode; at 0 Hz how it moves."""
    if modal.growth[k]:
        return f"{k + 1}: grows"
    return f"{k + 1}: {modal.frequencies[k]:.4g} Hz" if modal.frequencies[k] else f"{k + 1}: free"


def over_one(tracked: Tracked) -> Any:
    """Return frequencies over the positions of one joint, a curve for each mode, on a logarithmic scale."""
    figure = new_figure(8.0, 6.0)
    axis = figure.add_subplot()
    for k, curve in enumerate(tracked.frequencies.T):
        if curve.any():
            axis.semilogy(
                tracked.positions[:, 0], np.where(curve > 0, curve, np.nan), marker=".", label=f"mode {k + 1}"
            )
    axis.set_xlabel(tracked.joints[0])
    axis.set_ylabel("frequency, Hz")
    axis.grid(True, which="both", linewidth=0.3)
    figure.legend(fontsize="x-small", loc="outside right upper")
    return figure


def shapes_over_one(tracked: Tracked, chosen: Sequence[int]) -> Any:
    """Return shapes of some modes over the positions of one joint, a row for each joint weighted by its mass."""
    names = tracked.modes[0].linear.coordinates
    figure = new_figure(8.0, 1.0 + (0.5 + 0.15 * len(names)) * len(chosen))
    place = np.linspace(tracked.positions[0, 0], tracked.positions[-1, 0], 6)
    for axis, k in zip(figure.subplots(len(chosen), 1, squeeze=False)[:, 0], chosen, strict=True):
        columns = [np.sqrt(np.diag(each.linear.M)) * each.shapes[:, k] for each in tracked.modes]
        image = axis.imshow(np.array(columns).T, cmap="RdBu_r", vmin=-1.0, vmax=1.0, aspect="auto")
        axis.set_yticks(range(len(names)), names, fontsize="xx-small")
        axis.set_xticks(np.linspace(0, len(columns) - 1, 6), [f"{x:.3g}" for x in place], fontsize="x-small")
        axis.set_title(f"mode {k + 1}", fontsize="small")
        figure.colorbar(image, ax=axis)
    return figure


def over_two(tracked: Tracked, mode: int) -> Any:
    """Return one mode's frequency over the first two joints of a grid, the others at their first position."""
    figure = new_figure(6.0, 5.0)
    axis = figure.add_subplot()
    first, second = tracked.lengths[:2]
    planes = (tracked.positions[:, 0], tracked.positions[:, 1], tracked.frequencies[:, mode])
    x, y, f = (values.reshape(first, second, -1)[:, :, 0] for values in planes)
    if min(first, second) > 1:
        figure.colorbar(axis.pcolormesh(x, y, f, shading="nearest"), ax=axis, label="frequency, Hz")
    else:
        axis.plot((x if first > 1 else y).ravel(), f.ravel(), marker=".")
    axis.set_xlabel(tracked.joints[0])
    axis.set_ylabel(tracked.joints[1])
    axis.set_title(f"mode {mode + 1}")
    return figure


def following(command: FeedForward) -> Any:
    """Return a column for each motor: reference trajectory, lead of the motor where springs give it one, torque.

    Where motors follow from loops, the trajectories are those of the joints that are to follow.
    """
    wanted, motors = command.wanted, command.machine.motor_joints
    y = np.stack([command.reference.y[joint.name][0] for joint in wanted], axis=1)
    rows = [("reference", wanted, command.units, y)]
    rows += [("motor ahead", wanted, tuple(j.unit for j in wanted), command.lead)] if command.lead.any() else []
    rows += [("torque", motors, tuple(j.force_unit for j in motors), command.tau)]
    columns = max(len(wanted), len(motors))
    figure = new_figure(2.0 + 3.0 * columns, 2.0 * len(rows))
    axes = figure.subplots(len(rows), columns, sharex=True, squeeze=False)
    for line, (label, joints, units, curves) in zip(axes, rows, strict=True):
        for axis, joint, unit, curve in zip(line, joints, units, curves.T, strict=False):
            axis.plot(command.t, curve, linewidth=0.9)
            axis.set_ylabel(f"{label}, {unit}")
            axis.grid(True, linewidth=0.3)
            if line is axes[0] or command.following:
                axis.set_title(joint.name)
        for axis in line[len(joints) :]:
            axis.set_axis_off()
    for axis in axes[-1]:
        axis.set_xlabel("t, s")
    return figure


def losses(some: Sequence[Loss], t: Array) -> Any:
    """Return a row for each joint: a quantity over the motion by three models, and the errors of two of them."""
    figure = new_figure(10.0, 1.0 + 1.6 * len(some))
    for (values, missed), loss in zip(figure.subplots(len(some), 2, sharex=True, squeeze=False), some, strict=True):
        models = (("full", loss.by_full, "-"), ("reduced", loss.by_reduced, "--"), ("rigid", loss.by_rigid, ":"))
        for k, (name, curve, style) in enumerate(models):
            values.plot(t, curve, style, color=f"C{k}", linewidth=0.9, label=name)
            if k:
                missed.plot(t, curve - loss.by_full, style, color=f"C{k}", linewidth=0.9)
        values.set_ylabel(f"{loss.joint}, {loss.unit}", fontsize="x-small")
        for axis in (values, missed):
            axis.grid(True, linewidth=0.3)
            axis.tick_params(labelsize="x-small")
            axis.set_xlabel("t, s" if loss is some[-1] else "")
    first = figure.axes[:2]
    first[0].set_title(some[0].quantity, fontsize="small")
    first[1].set_title("missed", fontsize="small")
    first[0].legend(fontsize="x-small")
    return figure
