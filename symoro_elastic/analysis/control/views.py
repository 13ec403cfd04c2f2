"""Results about drives as tables, as data for JSON, and as sentences that name what limits a gain."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from symoro_elastic.analysis.control.cascade import Cascade
from symoro_elastic.analysis.control.control import AxisControl, Compliance, Control, Limit, PlaceControl
from symoro_elastic.analysis.control.cutting import Cut, Milling
from symoro_elastic.analysis.control.largest_gain import LargestGain
from symoro_elastic.analysis.control.lobes import Lobe, Lobes
from symoro_elastic.analysis.control.loops import Margins
from symoro_elastic.analysis.control.rules import RuledAxis
from symoro_elastic.analysis.control.tuning import Distances
from symoro_elastic.foundation.results import Field, Part, Table, declare, parts_of
from symoro_elastic.machine.drives import gain_unit

MOST_LISTED = 3
LEAST_LISTED = 0.05
"""Of a slope, % by %: less is not worth a word."""
NOTHING = 1e-6
"""Of a time by which an axis is behind, s: smaller ones are printed as zero."""
M_PER_MIN_AND_MM = 0.06
"""Of one 1/s."""
STIFFNESS = ".stiffness"

declare(
    Cascade,
    *(Field(name) for name in ("motor", "Kv", "Kp")),
    Field("Tn", lambda one: one.Tn if np.isfinite(one.Tn) else None),
    *(Field(name) for name in ("velocity_forward", "acceleration_forward")),
    Field("tuned", "sought"),
)
declare(
    Margins,
    Field("modulus"),
    Field("modulus_frequency"),
    Field("phase"),
    Field("phase_frequency"),
    Field("gain"),
    Field("gain_frequency"),
)
declare(LargestGain, Field("gain"), Field("frequency"))
declare(Limit, Field("key"), Field("distance"), Field("largest"), Field("influences", lambda one: dict(one.strongest)))
declare(
    AxisControl,
    Field("motor"),
    Field("velocity_loop", "velocity"),
    Field("position_loop", "position"),
    Field("bandwidth"),
    Field("in_phase"),
    Field("velocity_error"),
    Field("limits"),
)
declare(Compliance, Field("output"), Field("static"), Field("peak"), Field("frequency"), Field("unit"))
declare(PlaceControl, Field("position", "place"), Field("axes"), Field("compliances"), Field("growth"), Field("period"))
declare(Distances, Field("velocity"), Field("position"))
declare(
    Control,
    Field("machine"),
    Field("drives", "cascades"),
    Field("places"),
    Field("distances"),
    Field("damping"),
    Field("tuned"),
    Field("rules"),
    Field("notes"),
)
declare(
    RuledAxis,
    *(Field(name) for name in ("rule", "source")),
    Field("drive", "cascade"),
    *(Field(name) for name in ("inertia", "time", "velocity", "position", "growth")),
)


declare(Milling, Field("across"), Field("radial"), Field("immersion"), Field("down"))
declare(Cut, Field("coefficient"), Field("teeth"), Field("direction"), Field("thickness"), Field("milling"))
declare(
    Lobe,
    Field("position", "place"),
    Field("depths"),
    Field("periodic"),
    Field("frequencies", "waves"),
    Field("least"),
    Field("frequency"),
    Field("influences", lambda one: dict(one.strongest)),
)
declare(
    Lobes,
    Field("machine"),
    Field("cut"),
    Field("speeds", array=True, column="speed"),
    Field("worst", array=True, column="depth"),
    Field("places"),
    Field("notes"),
)


@parts_of.register
def _(lobes: Lobes) -> list[Part]:
    """Return the deepest stable cuts, and what limits the least one."""
    heads = ("position", "stable at all speeds", "waves at, Hz", "best speed, 1/min", "stable there")
    table = Table(heads, title=lobes.machine)
    for place in lobes.places:
        depths = place.depths if place.periodic is None else place.periodic
        best = int(np.argmax(depths))
        cells = (_millimetres(place.least), f"{place.frequency:.4g}", f"{lobes.speeds[best]:.5g}")
        table.add_row(place_text(place.place), *cells, _millimetres(depths[best]))
    worst = min(lobes.places, key=lambda place: place.least)
    effects = [_effect(name, x) for name, x in worst.strongest if abs(x) >= LEAST_LISTED][:MOST_LISTED]
    said = f"waves at {worst.frequency:.4g} Hz limit the depth at all speeds to {_millimetres(worst.least)}"
    unlimited = "no depth is unstable: the response has no negative real part"
    return [table, f"{said}: {'; '.join(effects)}" if np.isfinite(worst.least) else unlimited, *lobes.notes]


def _millimetres(depth: float) -> str:
    return f"{1e3 * depth:.4g} mm" if np.isfinite(depth) else "any"


@parts_of.register
def _(control: Control) -> list[Part]:
    """Return gains, loops and compliances at each position, and what limits each gain."""
    parts: list[Part] = [gains_table(control), loops_table(control)]
    if control.rules:
        parts.append(rules_table(control))
    return [*parts, compliances_table(control), *limits_lines(control), *stability_lines(control), *control.notes]


def gains_table(control: Control) -> Table:
    """Return a row for each axis: its gains, of the joint and, where there is a ratio, of the rotor's own axis."""
    table = Table(("axis", "Kp", "Kp of the rotor", "Tn, s", "Kv, 1/s", "Kv, m/min/mm", "found"), title=control.machine)
    for axis in control.places[0].axes:
        one, unit = axis.cascade, gain_unit("Kp", axis.joint)
        ratio = axis.joint.ratio.value(control.plants[0].linear.motion.parameters)
        rotor = f"{one.Kp / ratio**2:.5g} N m s/rad" if ratio else "-"
        integral = f"{one.Tn:.4g}" if np.isfinite(one.Tn) else "-"
        found = ", ".join(one.sought) or "-"
        table.add_row(
            axis.motor, f"{one.Kp:.5g} {unit}", rotor, integral, f"{one.Kv:.4g}",
            f"{M_PER_MIN_AND_MM * one.Kv:.3g}", found,
        )  # fmt: skip
    return table


def loops_table(control: Control) -> Table:
    """Return a row for each loop of each axis at each position: margins; bandwidths and error of the position."""
    heads = ("position", "axis", "loop", "modulus", "phase, deg", "gain", "bandwidth, Hz", "-90 deg, Hz", "behind, ms")
    table = Table(heads, title="loops", keys=3)
    for place in control.places:
        for axis in place.axes:
            at = place_text(place.place)
            table.add_row(at, axis.motor, "velocity", *_margins(axis.velocity))
            behind = axis.velocity_error if abs(axis.velocity_error) > NOTHING else 0.0
            own = (_frequency(axis.bandwidth), _frequency(axis.in_phase), f"{1e3 * behind:.4g}")
            table.add_row(at, axis.motor, "position", *_margins(axis.position), *own)
    return table


def rules_table(control: Control) -> Table:
    """Return a row for each rule and axis: its gains, and what the loops have of them at the worst position."""
    heads = ("rule", "axis", "inertia", "T, ms", "Kp", "Tn, ms", "Kv, 1/s", "velocity", "position", "all loops")
    table = Table(heads, title="published rules, and the least |1 + L| with them", keys=2)
    units = {axis.motor: gain_unit("Kp", axis.joint) for axis in control.places[0].axes}
    for one in control.rules:
        drive = one.cascade
        integral = f"{1e3 * drive.Tn:.4g}" if np.isfinite(drive.Tn) else "-"
        sizes = (f"{one.inertia:.4g}", f"{1e3 * one.time:.4g}", f"{drive.Kp:.5g} {units[drive.motor]}", integral)
        is_stable = one.growth < 0
        loops = (f"{one.velocity:.3g}", f"{one.position:.3g}", "stable") if is_stable else ("-", "-", "unstable")
        table.add_row(f"{one.rule} ({one.source})", drive.motor, *sizes, f"{drive.Kv:.4g}", *loops)
    return table


def compliances_table(control: Control) -> Table:
    """Return a row for each output that a force moves, at each position."""
    table = Table(("position", "output", "at rest", "peak", "at, Hz"), title="compliance, all loops closed", keys=2)
    for place in control.places:
        for one in place.compliances:
            if one.peak:
                sizes = (f"{x:.4g} {one.unit}" for x in (one.static, one.peak))
                table.add_row(place_text(place.place), one.output, *sizes, f"{one.frequency:.4g}")
    return table


def _margins(found: Margins) -> tuple[str, str, str]:
    phase, gain = ("-" if np.isnan(x) else f"{x:.3g}" for x in (found.phase, found.gain))
    return f"{found.modulus:.3g}", phase, gain


def _frequency(f: float) -> str:
    return f"{f:.4g}" if np.isfinite(f) else "-"


def place_text(place: Mapping[str, float]) -> str:
    """Return a position in words."""
    return ", ".join(f"{name} {x:g}" for name, x in place.items()) or "as given"


def limits_lines(control: Control) -> list[str]:
    """Return a sentence for each gain of each axis, at the position that allows least of it."""
    lines = []
    for k, one in enumerate(control.cascades):
        for number in range(len(control.places[0].axes[k].limits)):
            at = [place.axes[k].limits[number] for place in control.places]
            lines.append(_sentence(one, min(at, key=_allowed)))
    return lines


def _allowed(limit: Limit) -> float:
    return limit.largest.gain if limit.largest else 0.0


def _sentence(one: Cascade, limit: Limit) -> str:
    said = f"{limit.key} of {one.motor}"
    if limit.largest is None:
        return f"{said}: no value keeps its loop stable and {limit.distance:g} away from instability"
    if not np.isfinite(limit.largest.gain):
        return f"{said} is not limited: the drive has no dead time and no lag, or the machine no springs"
    now = getattr(one, limit.key)
    below = "its value" if abs(now / limit.largest.gain - 1) < 1e-6 else f"now {now:.5g}"
    first = f"{said} may be {limit.largest.gain:.5g} ({below}), limited at {limit.largest.frequency:.4g} Hz by "
    strongest = [(name, x) for name, x in limit.strongest if abs(x) >= LEAST_LISTED]
    shown = strongest[:MOST_LISTED]
    springs = [pair for pair in strongest if pair[0].endswith(STIFFNESS)][:1]
    shown += [pair for pair in springs if pair not in shown]
    return first + ("; ".join(_effect(name, x) for name, x in shown) or "nothing that a parameter changes")


def _effect(name: str, slope: float) -> str:
    """What one per cent of a parameter does: in the direction that raises the gain."""
    return f"{name} (1 % {'more' if slope > 0 else 'less'} raises it by {abs(slope):.2g} %)"


def stability_lines(control: Control) -> list[str]:
    """Return a line for each position at which the loops are unstable, or that all are stable."""
    unstable = [place for place in control.places if place.growth >= 0]
    period = control.places[0].period
    sampled = f", sampled every {1e3 * period:g} ms" if period else ""
    if not unstable:
        return [f"all loops closed{sampled}: stable" + (" at all positions" if len(control.places) > 1 else "")]
    return [f"unstable at {place_text(place.place)}: a motion grows by {place.growth:.3g} 1/s" for place in unstable]
