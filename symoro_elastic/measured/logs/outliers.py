"""Averages that stand out from what all the others say: contacts, collisions, saturated motors.

Iteratively reweighted least squares with Cauchy's weights 1 / (1 + (r / 2.5 s)^2), s = 1.4826 median |r| of the rows of
each joint, finds parameters that outliers hardly move (Holland and Welsch 1977). Rows far off them are left out, and
least squares of the others has the usual standard deviations (Rousseeuw and Leroy 1987, reweighted least squares):
weights that depend on residuals would make these too small.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from statistics import NormalDist
from typing import Any

import numpy as np

from symoro_elastic.analysis.time_series.measurements import Measurements
from symoro_elastic.analysis.time_series.resolution import resolution_of
from symoro_elastic.foundation.array_types import Array, BoolArray
from symoro_elastic.foundation.packages import for_identification
from symoro_elastic.machine.machine import Joint, Machine
from symoro_elastic.measured.fitting.corrections import MOST_NAMED
from symoro_elastic.measured.fitting.estimates import CAUCHY, OUTLYING, TO_DEVIATION
from symoro_elastic.measured.logs.estimation import FROM_DATA, balanced_rows
from symoro_elastic.measured.logs.filtering import Filter, smooth
from symoro_elastic.measured.logs.sensors import Columns
from symoro_elastic.numerics.linear.independence import independent_columns

NEIGHBOURS = 7  # samples of the median
ALONG_SLOPES = 4.0  # steps of a slope, of which noise alone has one: three are to the end of the neighbours
QUIET = 0.8  # of the samples, at any place, too, that are not spikes: their quantile is that of noise
NEAR = 50  # samples to either side that determine the noise at a place
LEAST = 1e-4  # of the standard deviation of a signal: least noise
MOST_SPIKES = 0.1  # of the samples: more are noise with long tails
ROUNDS = 30  # reweightings


def outliers_of(columns: Columns) -> BoolArray:
    """Return which rows (rows, n) are outliers of a fit of parameters, offsets of all motors and a delay."""
    tau, slopes = columns.torques(0.0)
    Y = columns.with_sensor_columns(range(columns.offsets.shape[2]), slopes)[0]
    Y = Y[:, :, list(independent_columns(balanced_rows(Y), FROM_DATA).kept)]
    used = Y.any(axis=2)
    weights = used.astype(float)
    deviation = np.ones(Y.shape[1])
    for _ in range(ROUNDS):
        root = np.sqrt(weights) / deviation
        X = np.linalg.lstsq((Y * root[:, :, None]).reshape(-1, Y.shape[2]), (tau * root).ravel(), rcond=None)[0]
        residuals = np.where(used, np.abs(tau - Y @ X), np.nan)
        medians = [float(np.median(r[~np.isnan(r)])) if (~np.isnan(r)).any() else 0.0 for r in residuals.T]
        scales = TO_DEVIATION * np.array(medians)
        deviation = np.where(scales > 0, scales, 1.0)
        weights = used / (1 + (np.nan_to_num(residuals) / (CAUCHY * deviation)) ** 2)
    beyond: BoolArray = np.nan_to_num(residuals) > OUTLYING * np.where(scales > 0, scales, np.inf)
    return beyond


def without(columns: Columns, rows: BoolArray) -> Columns:
    """Return the columns with some rows (rows, n) left out."""
    used, torques = (~rows).astype(float), columns.torques
    return replace(
        columns, Y=columns.Y * used[:, :, None], offsets=columns.offsets * used[:, :, None],
        noise=columns.noise.without(used, columns.Y),
        torques=lambda delay: (torques(delay)[0] * used, torques(delay)[1] * used),
    )  # fmt: skip


def notes_on_outliers(t: Array, rows: BoolArray, used: BoolArray, joints: Sequence[str]) -> list[str]:
    """Return a line for each joint with rows at times t (rows) that are left out."""
    lines = []
    for k, joint in enumerate(joints):
        times = t[rows[:, k]]
        if not len(times):
            continue
        step = 3 * float(np.median(np.diff(t)))
        parts = np.split(times, np.flatnonzero(np.diff(times) > step) + 1)
        spans = [f"{x[0]:.4g} to {x[-1]:.4g} s" if len(x) > 1 else f"{x[0]:.4g} s" for x in parts]
        more = f" and {len(spans) - MOST_NAMED} more times" if len(spans) > MOST_NAMED else ""
        count = f"{len(times)} of {int(used[:, k].sum())} averages stand out and are left out"
        lines.append(f"outliers of {joint}: {count}, at {', '.join(spans[:MOST_NAMED])}{more}: look for contacts there")
    return lines or ["outliers: no average stands out, so nothing is left out"]


def without_spikes(record: Measurements, chosen: Filter, machine: Machine) -> Measurements:
    """Return the record with the median of neighbours in place of spikes, and a warning for each column with some."""
    joints, motors = machine.independent_joints, machine.motor_joints
    blocks = {"q": ("positions", joints), "qd": ("velocities", joints), "qdd": ("accelerations", joints)}
    changed: dict[str, Any] = {}
    lines: list[str] = []
    for name, (title, named) in {**blocks, "tau": ("torque", motors)}.items():
        before = getattr(record, name)
        if before is not None and before.shape[1]:
            changed[name], said = _without_spikes(before, record, chosen, title, named)
            lines += said
    return replace(record, **changed, warnings=(*record.warnings, *lines)) if lines else record


def spikes_of(x: Array, slow: Array) -> tuple[Array, BoolArray]:
    """Return a signal (N) without spikes, and where these are; `slow` is its part due to motion."""
    fast, median = x - slow, for_identification("scipy.ndimage").median_filter
    deviations = fast - median(fast, NEIGHBOURS, mode="nearest")
    slopes = median(np.abs(np.diff(fast, prepend=fast[:1])), NEIGHBOURS + 2, mode="nearest")
    beyond = np.abs(deviations) - ALONG_SLOPES * slopes
    samples = (deviations, deviations[x != np.quantile(x, 0.5, method="lower")])
    noise = max(_deviation(some) for some in samples if len(some))
    spikes: BoolArray = beyond > OUTLYING * max(noise, resolution_of(x), LEAST * float(x.std()))
    for k in np.flatnonzero(spikes):
        spikes[k] = beyond[k] > OUTLYING * _deviation(deviations[max(0, k - NEAR) : k + NEAR + 1])
    return np.where(spikes, x - deviations, x), spikes


def _deviation(x: Array) -> float:
    """Return the standard deviation of noise, from a quantile of its absolute values."""
    return float(np.quantile(np.abs(x), QUIET)) / NormalDist().inv_cdf((1 + QUIET) / 2)


def _without_spikes(
    x: Array, record: Measurements, chosen: Filter, title: str, joints: Sequence[Joint]
) -> tuple[Array, list[str]]:
    """Return the columns of a block (N, k) without spikes, and a line for each that had some."""
    slow, repaired, lines, t = smooth(x, chosen, record), x.copy(), [], record.t
    for k, joint in enumerate(joints):
        signal, spikes = spikes_of(x[:, k], slow[:, k])
        if not (count := int(spikes.sum())):
            continue
        first = float(t[np.flatnonzero(spikes)[0]])
        what = f"{title} of {joint.name}: {count} of {len(t)} samples are spikes, the first at t = {first:g} s"
        if count > MOST_SPIKES * len(t):
            way_out = "too many to be taken out, so standard deviations count them as noise: look for their cause"
        else:
            repaired[:, k] = signal
            way_out = "replaced by the median of their neighbours; look for lost messages or disturbances of the sensor"
        lines.append(f"{what}: {way_out}")
    return repaired, lines
