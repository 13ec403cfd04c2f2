"""Requested signals of a motion, and their largest errors."""

from __future__ import annotations

from collections.abc import Mapping

from symoro_elastic.analysis.simulation.reference_motion import Reference
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.described import Wanted
from symoro_elastic.machine.machine import Machine
from symoro_elastic.numerics.motion.signals import MOTOR_TORQUE, input_unit, inputs, output_unit, outputs

POSITIONS = ("m", "rad")
ROUNDING = 1e-14
"""Of the largest position in a motion: what double precision leaves of it."""


def unit_of(machine: Machine, signal: str) -> str:
    """Return the unit of a motor's torque (motor_x.tau) or of an output (motor_x.q, tool.vx); raises `InputError`."""
    return input_unit(machine, signal) if _is_torque(signal) else output_unit(machine, signal)


def tolerances(wanted: Wanted, machine: Machine) -> dict[str, float]:
    """Return the allowed errors by signal, in its unit: a single number is for all outputs, which must be positions.

    Raises `InputError` for unknown signals, and for one number where it cannot be that of all outputs.
    """
    signals = output_signals(wanted, machine)
    if wanted.tolerance is None:
        return {}
    if isinstance(wanted.tolerance, dict):
        named = [_signal_name(name, wanted, machine, "tolerance") for name in wanted.tolerance]
        return dict(zip(named, wanted.tolerance.values(), strict=True))
    if not signals:
        raise wanted.error("tolerance", "one number applies to all outputs: add outputs, or give it by signal")
    for signal in signals:
        unit = unit_of(machine, signal)
        if unit not in POSITIONS:
            what = f"one number is in m or rad, {signal} in {unit}"
            raise wanted.error("tolerance", f'{what}: give it by signal, {{ "{signal}" = X }}')
    return dict.fromkeys(signals, wanted.tolerance)


def output_signals(wanted: Wanted, machine: Machine) -> tuple[str, ...]:
    """Return the full names of the outputs, by default those with a tolerance; raises `InputError`."""
    listed = tuple(_signal_name(name, wanted, machine, "outputs") for name in wanted.outputs)
    if listed or not isinstance(wanted.tolerance, dict):
        return listed
    return tuple(_signal_name(name, wanted, machine, "tolerance") for name in wanted.tolerance)


def refuse_rounding(tolerance: Mapping[str, float], reference: Reference) -> None:
    """Raise `InputError` for a tolerance of a position, by signal, below the rounding of the positions in a motion."""
    least, source = ROUNDING * reference.extent, reference.prescribed.source or reference.machine.label
    for signal, x in tolerance.items():
        if unit_of(reference.machine, signal) in POSITIONS and x < least:
            what = f"{x:g} is below rounding, {least:.1g} for positions up to {reference.extent:.3g}: give more"
            raise InputError(source, f"wanted, tolerance, {signal}", what)


def _signal_name(name: str, wanted: Wanted, machine: Machine, key: str) -> str:
    """Return the full name of a signal: a joint alone is its position. Raises `InputError` with file and key."""
    try:
        (signal,) = (inputs if _is_torque(name) else outputs)(machine, [name])
    except InputError as error:
        raise wanted.error(key, error.what) from None
    return signal.name


def _is_torque(name: str) -> bool:
    return name.rpartition(".")[2].strip() == MOTOR_TORQUE
