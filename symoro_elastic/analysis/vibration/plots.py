"""Plots of vibrations: Bode diagrams, shares of energy, frequencies over positions."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import Any

import numpy as np

from symoro_elastic.analysis.time_series.plots import MOST_IN_ROWS, over_time, torque_speed
from symoro_elastic.analysis.vibration.comparison import Compared, Comparison, Loss
from symoro_elastic.analysis.vibration.drawn_modes import mode_pictures
from symoro_elastic.analysis.vibration.export import labels
from symoro_elastic.analysis.vibration.feed_forward import FeedForward
from symoro_elastic.analysis.vibration.linearization import Linearization
from symoro_elastic.analysis.vibration.modes import Modes, kinetic_shares, strain_shares
from symoro_elastic.analysis.vibration.responses import PointStiffness, Response
from symoro_elastic.analysis.vibration.tracking import Tracked
from symoro_elastic.foundation.array_types import AnyArray, Array
from symoro_elastic.foundation.pictures import Plot
from symoro_elastic.foundation.plot_style import (
    RIGHT_ANGLE,
    bars,
    by_unit,
    contours,
    curve,
    curves,
    legend,
    logarithmic,
    map_of_numbers,
    mark_multiples,
    plain,
    shades,
    shorten,
    y_label,
)
from symoro_elastic.foundation.results import figures_of
from symoro_elastic.quantities.units import in_micro

MOST_CURVES, MOST_MODES, MOST_PANELS, MOST_ROWS = 6, 16, 8, 10
LEAST_SHOWN = 0.005
"""Of a heat map: a row that is shown."""


@figures_of.register
def _(response: Response) -> dict[str, Plot | str]:
    """Return bode_<input> for each input, stiffness_<output> for each frame along a force on it."""
    bodes = {f"bode_{label}": bode(response, j) for j, label in enumerate(labels(response.inputs))}
    names = labels([point.output for point in response.stiffnesses])
    points = zip(names, response.stiffnesses, strict=True)
    return {**bodes, **{f"stiffness_{name}": stiffness(response, point) for name, point in points}}


@figures_of.register
def _(modal: Modes) -> dict[str, Plot | str]:
    """Return shapes, energies, and pictures of the modes."""
    return {"shapes": shapes(modal), "energies": energies(modal), "pictures": mode_pictures(modal)}


@figures_of.register
def _(linear: Linearization) -> dict[str, Plot | str]:
    """Return poles."""
    poles = np.linalg.eigvals(linear.space.A)
    return {"poles": Plot(f"{linear.motion.machine.name}: poles", partial(_poles, poles), size=(7.0, 5.0))}


@figures_of.register
def _(tracked: Tracked) -> dict[str, Plot | str]:
    """Return positions and shapes_over_positions; over two joints frequency_<k>_over_<joint>, one mode each."""
    name = tracked.modes[0].linear.motion.machine.name
    vibrating = [k for k in range(tracked.frequencies.shape[1]) if tracked.frequencies[:, k].any()][:MOST_CURVES]
    if len(tracked.joints) == 1:
        title = f"{name}: frequencies over {tracked.joints[0]}"
        reason = "" if vibrating else "no mode vibrates at any position"
        alone = Plot(title, partial(_over_one, tracked), size=(8.0, 5.5))
        return {"positions": reason or alone, "shapes_over_positions": reason or _shapes_over_one(tracked, vibrating)}
    return {f"frequency_{k + 1}_over_{'_'.join(labels(tracked.joints[:2]))}": _over_two(tracked, k) for k in vibrating}


@figures_of.register
def _(command: FeedForward) -> dict[str, Plot | str]:
    """Return feed_forward, and torque_speed."""
    motors = command.machine.motor_joints
    units = [joint.force_unit for joint in motors]
    speeds = [f"{joint.unit}/s" for joint in motors]
    title = f"{command.machine.name}: torques over speeds of the motors"
    return {
        "feed_forward": _following(command),
        "torque_speed": torque_speed(title, command.motors, command.velocities, command.tau, speeds, units),
    }


@figures_of.register
def _(comparison: Comparison) -> dict[str, Plot | str]:
    """Return torques of motors and accelerations of springs."""
    by_quantity = {name: [x for x in comparison.losses if x.quantity == name] for name in Compared}
    name, t = comparison.full.linear.motion.machine.name, comparison.trajectory.t
    return {f"{quantity}s": _losses(some, t, name) for quantity, some in by_quantity.items() if some}


def bode(response: Response, j: int) -> Plot:
    """Return magnitudes, a scale for each unit, and phases of all outputs to input j over the frequency."""
    source = response.inputs[j]
    units = by_unit([response.unit(name, source) for name in response.outputs])
    title = f"{response.machine}: response to {source}".removeprefix(": ")
    draw = partial(_bode, response, j, units)
    return Plot(title, draw, len(units) + 1, size=(8.0, 2.0 + 2.1 * len(units)))


def _bode(response: Response, j: int, units: dict[str, list[int]], *axes: Any) -> None:
    *magnitudes, phase = axes
    f, first = response.frequencies, 0
    for axis, (unit, rows) in zip(magnitudes, units.items(), strict=True):
        G = np.where(response.values[:, rows, j] == 0, np.nan, response.values[:, rows, j])
        none = [not np.isfinite(column).any() for column in G.T]
        names = [f"{response.outputs[k]}{': no response' if idle else ''}" for k, idle in zip(rows, none, strict=True)]
        factor, shown_unit = in_micro(unit)
        curves(axis, f, factor * np.abs(G), names, first, MOST_IN_ROWS)
        curves(phase, f, np.transpose([_phase(column) for column in G.T]), names, first, MOST_IN_ROWS)
        y_label(axis, "magnitude", shown_unit)
        logarithmic(axis, "x", "y")
        legend(axis)
        first += len(rows)
    y_label(phase, "phase", "deg")
    mark_multiples(phase, RIGHT_ANGLE)
    logarithmic(phase, "x")
    phase.set_xlabel("frequency, Hz")


def stiffness(response: Response, point: PointStiffness) -> Plot:
    """Return the compliance of a point under a force, its static value and peak, and the limiting springs."""
    title = f"{response.machine}: {point.sentence}".removeprefix(": ")
    rows = len({**point.held_by, **point.shaken_by}) or 1
    size = (8.0, 3.9 + 0.24 * min(rows, MOST_ROWS))
    draw = partial(_stiffness, response, point)
    return Plot(title, draw, 2, size=size, ratios=(3.0, 0.6 + 0.24 * min(rows, MOST_ROWS)), share_x=False)


def _stiffness(response: Response, point: PointStiffness, magnitude: Any, springs: Any) -> None:
    factor, unit = in_micro(point.unit)
    G = factor * np.abs(response.values[:, response.outputs.index(point.output), response.inputs.index(point.source)])
    curves(magnitude, response.frequencies, G[:, None], [f"{point.output} / {point.source}"])
    if np.isfinite(point.static):
        magnitude.axhline(factor * point.static, color=shades().ink, linewidth=0.9, linestyle="--", label="at rest")
    if np.isfinite(point.peak) and point.frequency > 0:
        look = {"color": curve(1)["color"], "markersize": 7, "label": "largest"}
        magnitude.plot(point.frequency, factor * point.peak, "v", **look)
    if np.isinf(point.peak):
        magnitude.axvline(point.frequency, color=curve(1)["color"], linestyle=":", label="undamped resonance")
    logarithmic(magnitude, "x", "y")
    magnitude.set_xlabel("frequency, Hz")
    y_label(magnitude, "compliance", unit)
    legend(magnitude)
    both = {"at rest": point.held_by, f"at {point.frequency:.4g} Hz": point.shaken_by}
    rows = [*dict.fromkeys(name for shares in both.values() for name in shares)][:MOST_ROWS]
    bars(springs, {name: [100 * shares.get(x, 0.0) for x in rows] for name, shares in both.items() if shares}, rows)
    springs.set_xlabel("strain energy, %")
    legend(springs)


def _phase(G: Any) -> Array:
    """Return the continuous phase in degrees, starting within -270 and 90; gaps stay gaps."""
    degrees = np.full(len(G), np.nan)
    there = np.isfinite(G)
    if there.any():
        phase = np.degrees(np.unwrap(np.angle(G[there])))
        degrees[there] = phase - (360.0 if phase[0] > 90.0 else 0.0)
    return degrees


def _poles(poles: AnyArray, axes: Any) -> None:
    """Draw poles as frequency over decay, Hz and 1/s; unstable ones are on the right."""
    axes.plot(poles.real, poles.imag / (2 * np.pi), "x", color=curve(0)["color"], markersize=7)
    axes.axvline(0.0, color=shades().ink, linewidth=0.8)
    axes.set_yscale("asinh", linear_width=max(1.0, np.abs(poles.imag).max(initial=0.0) / 200))
    axes.yaxis.set_major_formatter(plain)
    axes.set_xlabel("real part, 1/s")
    axes.set_ylabel("imaginary part, Hz")


def shapes(modal: Modes) -> Plot:
    """Return mode shapes in joint coordinates, each weighted by the mass of its joint so that units compare."""
    names = modal.linear.coordinates
    weighted = np.sqrt(np.diag(modal.linear.M))[:, None] * modal.shapes
    weighted = weighted / np.abs(weighted).max(axis=0, initial=0.0)
    what = "mode shapes, joints weighted by the roots of their inertias"
    return _picture(weighted, names, modal, what, "{:.2f}", "motion, of the largest")


def energies(modal: Modes) -> Plot:
    """Return the shares of strain energy by spring and of kinetic energy by body."""
    strain, kinetic = strain_shares(modal), kinetic_shares(modal)
    both = np.vstack([strain.shares, kinetic.shares])
    names = (*(f"strain {name}" for name in strain.names), *(f"kinetic {name}" for name in kinetic.names))
    return _picture(both, names, modal, "shares of energy in springs and bodies", "{:.0%}", "share of the energy")


def _picture(values: Array, rows: tuple[str, ...], modal: Modes, what: str, form: str, unit: str) -> Plot:
    """Return a heat map with numbers; empty rows and the highest of many modes are omitted."""
    count, all_modes = min(MOST_MODES, values.shape[1]), values.shape[1]
    visible = [k for k in range(len(rows)) if np.abs(values[k, :count]).max(initial=0.0) >= LEAST_SHOWN]
    if not visible:
        visible = [*range(len(rows))]
    title = f"{modal.linear.motion.machine.name}: {what}"
    title += f"; {count} of {all_modes} modes" if count < all_modes else ""
    columns = [_column(modal, k) for k in range(count)]
    draw = partial(_map, values[np.ix_(visible, range(count))], [rows[k] for k in visible], columns, form, unit)
    return Plot(title, draw, size=(max(5.5, 3.2 + 0.55 * count), 1.9 + 0.26 * len(visible)))


def _map(values: Array, rows: Sequence[str], columns: Sequence[str], form: str, unit: str, axes: Any) -> None:
    map_of_numbers(axes, values, rows, columns, form, unit)
    axes.set_xlabel("mode")


def _column(modal: Modes, k: int) -> str:
    """Return number and frequency of a mode; at 0 Hz its kind of motion."""
    if modal.growth[k]:
        return f"{k + 1}: grows"
    return f"{k + 1}: {modal.frequencies[k]:.4g} Hz" if modal.frequencies[k] else f"{k + 1}: free"


def _over_one(tracked: Tracked, axes: Any) -> None:
    """Draw frequencies over the positions of a joint, a curve for each mode, on a logarithmic scale."""
    f = np.where(tracked.frequencies > 0, tracked.frequencies, np.nan)
    finite = [k for k in range(f.shape[1]) if np.isfinite(f[:, k]).any()]
    for j, k in enumerate(finite):
        look = {"marker": ".", **curve(j)} if j < MOST_ROWS else {"color": shades().grey, "linewidth": 0.5}
        label = f"mode {k + 1}" if j < MOST_ROWS else f"{len(finite) - j} higher ones" if j == MOST_ROWS else None
        axes.plot(tracked.positions[:, 0], f[:, k], label=label, **look)
    logarithmic(axes, "y")
    axes.set_xlabel(_joint(tracked, 0))
    y_label(axes, "frequency", "Hz")
    legend(axes)


def _joint(tracked: Tracked, k: int) -> str:
    """The name of a joint of the grid, and its unit."""
    joints = tracked.modes[0].linear.motion.machine.joints
    unit = next(joint.unit for joint in joints if joint.name == tracked.joints[k])
    return f"{shorten(tracked.joints[k])}, {unit}"


def _shapes_over_one(tracked: Tracked, chosen: Sequence[int]) -> Plot:
    """Return shapes of some modes over the positions of a joint, a row for each joint weighted by its mass."""
    weighted = np.array([np.sqrt(np.diag(modal.linear.M))[:, None] * modal.shapes for modal in tracked.modes])
    shapes = {k: weighted[:, :, k].T for k in chosen}
    rows = sum(min(MOST_ROWS, len(tracked.modes[0].linear.coordinates)) for _ in chosen)
    title = f"{tracked.modes[0].linear.motion.machine.name}: mode shapes over {tracked.joints[0]}"
    draw = partial(_draw_shapes_over_one, tracked, shapes)
    return Plot(title, draw, len(chosen), size=(8.0, 1.2 + 0.45 * len(chosen) + 0.19 * rows))


def _draw_shapes_over_one(tracked: Tracked, shapes: dict[int, Array], *axes: Any) -> None:
    names, x = tracked.modes[0].linear.coordinates, tracked.positions[:, 0]
    half = (x[1] - x[0]) / 2 if len(x) > 1 else 0.5
    for axis, (k, values) in zip(axes, shapes.items(), strict=True):
        largest = sorted(np.argsort(-np.abs(values).max(axis=1), kind="stable")[:MOST_ROWS])
        edges = (x[0] - half, x[-1] + half, len(largest) - 0.5, -0.5)
        look: dict[str, Any] = {"cmap": "RdBu_r", "vmin": -1.0, "vmax": 1.0, "aspect": "auto", "extent": edges}
        image = axis.imshow(values[largest], **look)
        axis.set_yticks(range(len(largest)), [shorten(names[j]) for j in largest], fontsize=7)
        axis.grid(False)
        axis.set_title(f"mode {k + 1}", fontsize=8)
        axis.figure.colorbar(image, ax=axis, label="motion")
    axes[-1].set_xlabel(_joint(tracked, 0))


def _over_two(tracked: Tracked, mode: int) -> Plot | str:
    """Return one mode's frequency over the first two joints of a grid, the others at their first position."""
    first, second = tracked.lengths[:2]
    planes = (tracked.positions[:, 0], tracked.positions[:, 1], tracked.frequencies[:, mode])
    x, y, f = (values.reshape(first, second, -1)[:, :, 0] for values in planes)
    if np.ptp(f) <= 1e-9 * f.max():
        return f"mode {mode + 1} is at {f.flat[0]:.4g} Hz at all positions"
    title = f"{tracked.modes[0].linear.motion.machine.name}: frequency of mode {mode + 1}, Hz"
    names = (_joint(tracked, 0), _joint(tracked, 1))
    return Plot(title, partial(contours, x, y, f, names, "frequency, Hz"), size=(7.0, 5.0))


def _following(command: FeedForward) -> Plot:
    """Return reference trajectory, lead of the motors over springs, and torques, by unit.

    Where motors follow from loops, the trajectories are those of the joints that are to follow.
    """
    wanted, motors = command.wanted, command.machine.motor_joints
    y = np.stack([command.reference.y[joint.name][0] for joint in wanted], axis=1)
    blocks = [("reference", wanted, command.units, y)]
    blocks += [("motor ahead", wanted, tuple(j.unit for j in wanted), command.lead)] if command.lead.any() else []
    blocks += [("torque", motors, tuple(j.force_unit for j in motors), command.tau)]
    rows = [
        (label, unit, [joints[k].name for k in columns], values[:, columns])
        for label, joints, units, values in blocks
        for unit, columns in by_unit(units).items()
    ]
    title = f"{command.machine.name}: feed-forward"
    return Plot(title, partial(over_time, command.t, rows), len(rows), size=(8.0, 1.0 + 1.8 * len(rows)))


def _losses(some: Sequence[Loss], t: Array, machine: str) -> Plot:
    """Return a row for each joint: a quantity over the motion by three models, and two errors."""
    worst = sorted(range(len(some)), key=lambda k: -max(some[k].rigid[1], some[k].reduced[1]))[:MOST_PANELS]
    chosen = [some[k] for k in sorted(worst)]
    title = f"{machine}: {some[0].quantity}s by three models, and what the simpler ones miss"
    title += f"; {len(chosen)} of {len(some)} joints, those with the largest errors" if len(chosen) < len(some) else ""
    return Plot(title, partial(_draw_losses, chosen, t), len(chosen), 2, size=(10.0, 1.3 + 1.5 * len(chosen)))


def _draw_losses(some: Sequence[Loss], t: Array, *axes: Any) -> None:
    pairs = np.reshape(np.array(axes, dtype=object), (len(some), 2))
    for (values, missed), loss in zip(pairs, some, strict=True):
        models = (("full", loss.by_full), ("reduced", loss.by_reduced), ("rigid", loss.by_rigid))
        for k, (name, column) in enumerate(models):
            values.plot(t, column, label=name, **curve(k))
            if k:
                missed.plot(t, column - loss.by_full, **curve(k))
        y_label(values, loss.joint, loss.unit)
        for axis in (values, missed):
            axis.set_xlabel("time, s" if loss is some[-1] else "")
    pairs[0, 0].set_title(some[0].quantity)
    pairs[0, 1].set_title("missed")
    legend(pairs[0, 1], of=pairs[0, 0])
