"""Notes on sensors: coarse encoders, offsets of torques and their delay."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from symoro_elastic.analysis.identification.estimation import Estimate, Estimation, Verdict
from symoro_elastic.analysis.identification.filtering import Filter, FilteredMotion
from symoro_elastic.analysis.identification.sensors import DELAY, OFFSET, SIGNIFICANT, Sensors, shows
from symoro_elastic.analysis.time_series.measurements import Measurements
from symoro_elastic.analysis.time_series.resolution import resolution_of
from symoro_elastic.machine.machine import Machine

FEWEST_STEPS = 6.0  # that motion crosses in a period of the Butterworth cut-off


def of_encoders(
    record: Measurements, motion: FilteredMotion, chosen: Filter | None, joints: Sequence[str]
) -> list[str]:
    """Return notes on joints whose noise is the staircase of their encoder, and on steps too coarse for a motion."""
    moved = [k for k in motion.staircases if k not in motion.still]
    if not moved or chosen is None:
        return []
    steps = {k: resolution_of(record.q[:, k]) for k in moved}
    rates = {k: float(np.sqrt(np.mean(motion.qd[:, k] ** 2))) / steps[k] for k in moved}
    named = ", ".join(f"{joints[k]} {steps[k]:.3g}" for k in moved)
    notes = [f"positions are whole steps of encoders, whose staircase is their noise: {named} (rad or m)"]
    for k in moved:
        if rates[k] < FEWEST_STEPS * chosen.cutoff:
            few = rates[k] / chosen.cutoff
            what = f"encoder of {joints[k]}: {few:.2g} steps pass in a period of {chosen.cutoff:.3g} Hz"
            way = "move it faster or farther, or measure it with a finer encoder"
            notes.append(f"{what}, so standard deviations are too small where they rest on this joint: {way}")
    return notes


def of_sensors(estimation: Estimation, sensors: Sensors, machine: Machine) -> list[str]:
    """Return notes on offsets of torques and on their delay."""
    notes = []
    for e in estimation.estimates:
        if e.unknown.quantity == OFFSET and e.verdict is not Verdict.NOT:
            notes.append(_of_offset(e))
        if e.unknown.quantity == DELAY and e.verdict is not Verdict.NOT:
            order = "behind" if e.value > 0 else "ahead of"
            what = f"torques are {1e3 * abs(e.value):.4g} ms (std {1e3 * e.std:.2g} ms) {order} positions"
            notes.append(f"{what}: compensated, and sought with the parameters")
    for m, size in sensors.untold.items():
        joint = machine.motor_joints[m]
        what, below = f"an offset of the torque of {joint.name}", f"{size:.2g} {joint.force_unit}"
        what += f" is not told from gravity by this motion: standard deviations allow for {below}, as sensors have"
        notes.append(f"{what}; move it farther, or give --offsets never if its sensor has none")
    return notes


def _of_offset(e: Estimate) -> str:
    """Return whether an offset shows that is sought with the parameters."""
    if shows(e):
        what = f"torque of {e.unknown.joint} has an offset of {e.value:.4g} {e.unknown.unit} (std {e.std:.2g})"
        return f"{what}: sought with the parameters"
    what = f"no offset of the torque of {e.unknown.joint} shows, but parameters would take up one below"
    most = abs(e.value) + SIGNIFICANT * e.std
    return f"{what} {most:.2g} {e.unknown.unit}, so it is sought: give --offsets never if its sensor has none"
