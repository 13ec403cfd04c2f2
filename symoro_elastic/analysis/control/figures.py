"""Results of drives by name, for sweeps: margins, bandwidth, following error, largest gains, compliances."""

from __future__ import annotations

from collections.abc import Iterator

from symoro_elastic.analysis.control.control import AxisControl, Control, unit_of_compliance
from symoro_elastic.analysis.control.loops import Margins
from symoro_elastic.machine.machine import Machine


def control_figures(control: Control) -> dict[str, float]:
    """Return the results of a machine at its first position, by names as "motor_x: position_modulus".

    Margins are 0 where the loops are unstable. `behind` is in s, frequencies in Hz, `growth` in 1/s.
    """
    place = control.places[0]
    figures: dict[str, float] = {}
    for axis in place.axes:
        figures |= {f"{axis.motor}: {name}": x for name, x in _of_axis(axis, place.growth <= 0)}
    for compliance in place.compliances:
        figures |= {f"{compliance.output}: at_rest": compliance.static, f"{compliance.output}: peak": compliance.peak}
        figures |= {f"{compliance.output}: peak_frequency": compliance.frequency}
    return {**figures, "growth": place.growth}


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
    """Return the unit of a result by its name; empty for a pure number."""
    output, _, name = figure.rpartition(": ")
    if name in ("at_rest", "peak"):
        return unit_of_compliance(machine, output)
    return next((unit for end, unit in UNITS.items() if figure.endswith(end)), "")
