"""Figures of drives by name, for sweeps: margins, bandwidth, following error, largest gains, compliances."""

from __future__ import annotations

from collections.abc import Iterator

from symoro_elastic.analysis.control.control import AxisControl, Control, unit_of_compliance
from symoro_elastic.analysis.control.loops import Margins
from symoro_elastic.machine.machine import Machine


def control_figures(control: Control) -> dict[str, float]:
    """Return the figures of a machine at its first position, as "motor_x: position_modulus".

    Margins are 0 where the loops are unstable. `behind` is in s, frequencies in Hz, `growth` in 1/s.
    """
    place = control.places[0]
    found: dict[str, float] = {}
    for axis in place.axes:
        found |= {f"{axis.motor}: {name}": x for name, x in _of_axis(axis, place.growth < 0)}
    for one in place.compliances:
        found |= {f"{one.output}: at_rest": one.static, f"{one.output}: peak": one.peak}
        found |= {f"{one.output}: peak_frequency": one.frequency}
    return {**found, "growth": place.growth}


def _of_axis(axis: AxisControl, is_stable: bool) -> Iterator[tuple[str, float]]:
    loops: dict[str, Margins] = {"velocity": axis.velocity, "position": axis.position}
    for loop, margins in loops.items():
        for name in ("modulus", "phase", "gain"):
            yield f"{loop}_{name}", getattr(margins, name) if is_stable else 0.0
    yield from (("bandwidth", axis.bandwidth), ("behind", axis.velocity_error))
    for limit in axis.limits:
        yield f"largest_{limit.key}", limit.largest.gain if limit.largest else 0.0


UNITS = {"phase": "deg", "bandwidth": "Hz", "peak_frequency": "Hz", "growth": "1/s", "behind": "s"}
"""Of a figure, by what its name ends with; compliances and gains have that of their output and axis."""


def unit_of(figure: str, machine: Machine) -> str:
    """Return the unit of a figure of a machine by its name; empty where it has none, or one of its own."""
    output, _, name = figure.rpartition(": ")
    if name in ("at_rest", "peak"):
        return unit_of_compliance(machine, output)
    return next((unit for end, unit in UNITS.items() if figure.endswith(end)), "")
