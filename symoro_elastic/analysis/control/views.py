"""Results about drives as tables, as data for JSON, and as sentences that name what limits a gain."""

from __future__ import annotations

from collections.abc import Collection, Mapping

import numpy as np

from symoro_elastic.analysis.control.cascade import Cascade, is_gain
from symoro_elastic.analysis.control.control import AxisControl, Compliance, Control, Limit, PlaceControl, RuledAxis
from symoro_elastic.analysis.control.cutting import Cut, Milling
from symoro_elastic.analysis.control.largest_gain import LargestGain
from symoro_elastic.analysis.control.lobes import Lobe, Lobes
from symoro_elastic.analysis.control.loops import Margins
from symoro_elastic.analysis.control.tuning import Distances
from symoro_elastic.foundation.results import Field, Part, Table, declare, parts_of
from symoro_elastic.machine.drives import gain_unit
from symoro_elastic.quantities.units import MICRO

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
    *map(Field, ("motor", "Kv", "Kp")),
    Field("Tn", lambda axis: axis.Tn if np.isfinite(axis.Tn) else None),
    *map(Field, ("velocity_forward", "acceleration_forward")),
    Field("tuned", "tuned_gains"),
)
declare(Margins, *map(Field, ("modulus", "modulus_frequency", "phase", "phase_frequency", "gain", "gain_frequency")))
declare(LargestGain, *map(Field, ("gain", "frequency")))
declare(Limit, *map(Field, ("key", "distance", "largest")), Field("influences", lambda x: dict(x.strongest)))
declare(
    AxisControl,
    Field("motor"),
    Field("velocity_loop", "velocity"),
    Field("position_loop", "position"),
    *map(Field, ("bandwidth", "in_phase", "velocity_error", "limits")),
)
declare(Compliance, *map(Field, ("output", "static", "peak", "frequency", "unit")))
declare(PlaceControl, Field("position", "place"), *map(Field, ("axes", "compliances", "growth", "period")))
declare(Distances, *map(Field, ("velocity", "position")))
declare(
    Control,
    Field("machine"),
    Field("drives", "cascades"),
    *map(Field, ("places", "distances", "damping", "tuned", "rules", "notes")),
)
declare(
    RuledAxis,
    *map(Field, ("rule", "source")),
    Field("drive", "cascade"),
    *map(Field, ("inertia", "time", "velocity", "position", "growth")),
)


declare(Milling, *map(Field, ("across", "radial", "immersion", "down")))
declare(Cut, *map(Field, ("coefficient", "teeth", "direction", "thickness", "milling")))
declare(
    Lobe,
    Field("position", "place"),
    Field("depths"),
    Field("periodic"),
    Field("frequencies", "waves"),
    Field("least"),
    Field("frequency"),
    Field("influences", lambda lobe: dict(lobe.strongest)),
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
    """Return the deepest stable cuts, and the influences on the least one."""
    heads = ("position", "stable at all speeds", "chatter frequency, Hz", "best speed, 1/min", "limit at that speed")
    table = Table(heads, title=lobes.machine)
    for place in lobes.places:
        depths = place.depths if place.periodic is None else place.periodic
        best = int(np.argmax(depths))
        waves = f"{place.frequency:.4g}" if np.isfinite(place.frequency) else "-"
        cells = (_millimetres(place.least), waves, f"{lobes.speeds[best]:.5g}")
        table.add_row(place_text(place.place), *cells, _millimetres(depths[best]))
    worst = min(lobes.places, key=lambda place: place.least)
    effects = [_effect(name, x) for name, x in worst.strongest if abs(x) >= LEAST_LISTED][:MOST_LISTED]
    summary = f"chatter at {worst.frequency:.4g} Hz limits the depth at all speeds to {_millimetres(worst.least)}"
    unlimited = "no depth is unstable: the response has no negative real part"
    return [table, f"{summary}: {'; '.join(effects)}" if np.isfinite(worst.least) else unlimited, *lobes.notes]


def _millimetres(depth: float) -> str:
    return f"{1e3 * depth:.4g} mm" if np.isfinite(depth) else "any"


@parts_of.register
def _(control: Control) -> list[Part]:
    """Return gains, loops and compliances at each position, and the influences on each gain."""
    parts: list[Part] = [gains_table(control), loops_table(control)]
    if control.rules:
        parts.append(rules_table(control))
    return [*parts, compliances_table(control), *limits_lines(control), *stability_lines(control), *control.notes]


def gains_table(control: Control) -> Table:
    """Return a row for each axis: its gains, referred to the joint and, with a ratio, to the rotor's axis."""
    table = Table(("axis", "Kp", "Kp of the rotor", "Tn, s", "Kv, 1/s", "Kv, m/min/mm", "tuned"), title=control.machine)
    for axis in control.places[0].axes:
        cascade, unit = axis.cascade, gain_unit("Kp", axis.joint)
        ratio = axis.joint.ratio.value(control.plants[0].linear.motion.parameters)
        rotor = f"{cascade.Kp / ratio**2:.5g} N m s/rad" if ratio else "-"
        integral = f"{cascade.Tn:.4g}" if np.isfinite(cascade.Tn) else "-"
        tuned = ", ".join(cascade.tuned_gains) or "-"
        table.add_row(
            axis.motor, f"{cascade.Kp:.5g} {unit}", rotor, integral, f"{cascade.Kv:.4g}",
            f"{M_PER_MIN_AND_MM * cascade.Kv:.3g}" if axis.joint.sigma == 1 else "-", tuned,
        )  # fmt: skip
    return table


def loops_table(control: Control) -> Table:
    """Return a row for each loop of the axes at each position: margins; bandwidths and error of the position."""
    margins = ("min |1 + L|", "phase, deg", "gain")
    of_position = ("bandwidth, Hz", "-90 deg, Hz", "following error, ms")
    table = Table(("position", "axis", "loop", *margins, *of_position), title="loops", keys=3)
    for place in control.places:
        for axis in place.axes:
            at = place_text(place.place)
            table.add_row(at, axis.motor, "velocity", *_margins(axis.velocity))
            behind = axis.velocity_error if abs(axis.velocity_error) > NOTHING else 0.0
            own = (_frequency(axis.bandwidth), _frequency(axis.in_phase), f"{1e3 * behind:.4g}")
            table.add_row(at, axis.motor, "position", *_margins(axis.position), *own)
    return table


def rules_table(control: Control) -> Table:
    """Return a row for each rule and axis: its gains, and the least margins of the loops over positions."""
    heads = ("rule", "axis", "inertia", "T, ms", "Kp", "Tn, ms", "Kv, 1/s", "velocity", "position", "all loops")
    table = Table(heads, title="published rules, and the least |1 + L| with them", keys=2)
    units = {axis.motor: gain_unit("Kp", axis.joint) for axis in control.places[0].axes}
    for rule in control.rules:
        drive = rule.cascade
        integral = f"{1e3 * drive.Tn:.4g}" if np.isfinite(drive.Tn) else "-"
        sizes = (f"{rule.inertia:.4g}", f"{1e3 * rule.time:.4g}", f"{drive.Kp:.5g} {units[drive.motor]}", integral)
        is_stable = rule.growth <= 0
        loops = (f"{rule.velocity:.3g}", f"{rule.position:.3g}", "stable") if is_stable else ("-", "-", "unstable")
        table.add_row(f"{rule.rule} ({rule.source})", drive.motor, *sizes, f"{drive.Kv:.4g}", *loops)
    return table


def compliances_table(control: Control) -> Table:
    """Return a row for each output with a compliance, at each position."""
    table = Table(("position", "output", "at rest", "peak", "at, Hz"), title="compliance, all loops closed", keys=2)
    for place in control.places:
        for compliance in place.compliances:
            if compliance.peak:
                sizes = (f"{MICRO * x:.4g} u{compliance.unit}" for x in (compliance.static, compliance.peak))
                table.add_row(place_text(place.place), compliance.output, *sizes, f"{compliance.frequency:.4g}")
    return table


def _margins(margins: Margins) -> tuple[str, str, str]:
    phase, gain = ("-" if np.isnan(x) else f"{x:.3g}" for x in (margins.phase, margins.gain))
    return f"{margins.modulus:.3g}", phase, gain


def _frequency(f: float) -> str:
    return f"{f:.4g}" if np.isfinite(f) else "-"


def place_text(place: Mapping[str, float]) -> str:
    """Return a position in words."""
    return ", ".join(f"{name} {x:g}" for name, x in place.items()) or "initial position"


def limits_lines(control: Control) -> list[str]:
    """Return a sentence for each gain of the axes, at the position with the least limit."""
    lines = []
    for k, axis in enumerate(control.cascades):
        for number in range(len(control.places[0].axes[k].limits)):
            at = [place.axes[k].limits[number] for place in control.places]
            repeated = {x.removeprefix(f"{axis.motor}, ") for drive in control.cascades for x in drive.repeated_names}
            lines.append(_sentence(axis, min(at, key=lambda x: x.largest.gain if x.largest else 0.0), repeated))
    return lines


def _sentence(cascade: Cascade, limit: Limit, repeated_names: Collection[str]) -> str:
    subject = f"{limit.key} of {cascade.motor}"
    if limit.largest is None:
        return f"{subject}: no value keeps its loop stable and {limit.distance:g} away from instability"
    if not np.isfinite(limit.largest.gain):
        return f"{subject} is not limited: the drive has no dead time and no lag, or the machine no springs"
    now = getattr(cascade, limit.key)
    used = "in use" if abs(now / limit.largest.gain - 1) < 1e-6 else f"in use {now:.5g}"
    first = f"{subject}: maximum {limit.largest.gain:.5g} ({used}), limited at {limit.largest.frequency:.4g} Hz by "
    strongest = [(name, x) for name, x in limit.strongest if not (is_gain(name) or name in repeated_names)]
    strongest = [(name, x) for name, x in strongest if abs(x) >= LEAST_LISTED]
    listed = strongest[:MOST_LISTED]
    springs = [pair for pair in strongest if pair[0].endswith(STIFFNESS)][:1]
    listed += [pair for pair in springs if pair not in listed]
    return first + ("; ".join(_effect(name, x) for name, x in listed) or "nothing that a parameter changes")


def _effect(name: str, slope: float) -> str:
    """Return the effect of a change of a parameter by 1 % on the largest gain, in the direction that raises it."""
    return f"{name} (1 % {'more' if slope > 0 else 'less'} raises it by {abs(slope):.2g} %)"


def stability_lines(control: Control) -> list[str]:
    """Return a line for each position with unstable loops, or one that all are stable."""
    unstable = [place for place in control.places if place.growth > 0]
    period = control.places[0].period
    sampled = f", sampled every {1e3 * period:g} ms" if period else ""
    if not unstable:
        lasts = any(place.growth == 0 for place in control.places)
        but = ", but a motion lasts that no drive and no damping stops" if lasts else ""
        return [f"all loops closed{sampled}: stable" + (" at all positions" if len(control.places) > 1 else "") + but]
    return [f"unstable at {place_text(place.place)}: a motion grows by {place.growth:.3g} 1/s" for place in unstable]
