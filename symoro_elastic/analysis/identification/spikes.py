"""Spikes: samples that stick out beside their neighbours, as lost messages and electrical disturbances leave them.

The identifier of Hampel (Pearson 2002), on what of a signal is faster than the motion: a sample is a spike where it
differs from the median of its neighbours by more than noise does, which a quantile tells that spikes do not move, and
by more than a slope does at an edge, as where dry friction reverses. Spikes become the median. Samples of the usual
value tell no noise, for a sensor that shows small torques as zero has pulses, no spikes.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from statistics import NormalDist
from typing import Any

import numpy as np

from symoro_elastic.analysis.identification.filtering import Filter, smooth
from symoro_elastic.analysis.time_series.measurements import Measurements
from symoro_elastic.analysis.time_series.resolution import resolution_of
from symoro_elastic.foundation.array_types import Array, BoolArray
from symoro_elastic.foundation.packages import for_identification
from symoro_elastic.machine.machine import Joint, Machine

NEIGHBOURS = 7  # samples of the median
ALONG_SLOPES = 4.0  # steps of a slope, of which noise alone has one: three are to the end of the neighbours
STICKS_OUT = 6.0  # standard deviations of noise beyond them
QUIET = 0.8  # of the samples are no spikes, at any place, too
NEAR = 50  # samples to each side that tell the noise at a place
LEAST = 1e-4  # of the standard deviation of a signal: its noise is at least taken for that
MOST_SPIKES = 0.1  # of the samples: more are noise with long tails


@dataclass(frozen=True)
class Found:
    """A signal (N) without its spikes, and where it had them."""

    x: Array
    spikes: BoolArray


def without_spikes(record: Measurements, chosen: Filter, machine: Machine) -> Measurements:
    """Return the record with the median of neighbours in place of spikes, and a warning for each column with some."""
    joints, motors = machine.independent_joints, machine.motor_joints
    blocks = {"q": ("positions", joints), "qd": ("velocities", joints), "qdd": ("accelerations", joints)}
    changed: dict[str, Any] = {}
    lines: list[str] = []
    for name, (title, named) in {**blocks, "tau": ("torque", motors)}.items():
        before = getattr(record, name)
        if before is not None and before.shape[1]:
            changed[name], said = _repaired(before, record, chosen, title, named)
            lines += said
    return replace(record, **changed, warnings=(*record.warnings, *lines)) if lines else record


def spikes_of(x: Array, slow: Array) -> Found:
    """Return a signal (N) without spikes, of which `slow` is the part that motion makes."""
    fast, median = x - slow, for_identification("scipy.ndimage").median_filter
    beside = fast - median(fast, NEIGHBOURS, mode="nearest")
    slopes = median(np.abs(np.diff(fast, prepend=fast[:1])), NEIGHBOURS + 2, mode="nearest")
    beyond = np.abs(beside) - ALONG_SLOPES * slopes
    unusual = x != np.quantile(x, 0.5, method="lower")
    noise = _deviation(beside[unusual]) if unusual.any() else 0.0
    spikes = beyond > STICKS_OUT * max(noise, _deviation(beside), resolution_of(x), LEAST * float(x.std()))
    for k in np.flatnonzero(spikes):
        spikes[k] = beyond[k] > STICKS_OUT * _deviation(beside[max(0, k - NEAR) : k + NEAR + 1])
    return Found(np.where(spikes, x - beside, x), spikes)


def _deviation(x: Array) -> float:
    """Return the standard deviation of noise by a quantile."""
    return float(np.quantile(np.abs(x), QUIET)) / NormalDist().inv_cdf((1 + QUIET) / 2)


def _repaired(
    x: Array, record: Measurements, chosen: Filter, title: str, joints: Sequence[Joint]
) -> tuple[Array, list[str]]:
    """Return the columns of a block (N, k) without spikes, and a line for each that had some."""
    slow, repaired, lines, t = smooth(x, chosen, record), x.copy(), [], record.t
    for k, joint in enumerate(joints):
        found = spikes_of(x[:, k], slow[:, k])
        if not (count := int(found.spikes.sum())):
            continue
        first = float(t[np.flatnonzero(found.spikes)[0]])
        what = f"{title} of {joint.name}: {count} of {len(t)} samples are spikes, the first at t = {first:g} s"
        if count > MOST_SPIKES * len(t):
            way_out = "too many to be taken out, so standard deviations count them as noise: look for their cause"
        else:
            repaired[:, k] = found.x
            way_out = "replaced by the median of their neighbours; look for lost messages or disturbances of the sensor"
        lines.append(f"{what}: {way_out}")
    return repaired, lines
