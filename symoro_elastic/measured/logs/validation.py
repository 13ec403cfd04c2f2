"""How well tau = Y X explains torques: those it was found from, and those of another record."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

import numpy as np

from symoro_elastic.analysis.time_series.measurements import Measurements
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.machine import Machine
from symoro_elastic.measured.fitting.estimates import ROUNDING
from symoro_elastic.measured.logs.equations import Sampled
from symoro_elastic.measured.logs.filtering import smooth
from symoro_elastic.measured.logs.pieces import filter_of, in_pieces
from symoro_elastic.measured.logs.result import Identification


@dataclass(frozen=True)
class Fit:
    """Torque residuals of a record by joint: root mean square (N m or N), and in per cent of that of the torques
    that the estimated parameters explain. Both are of averages over windows.

    `counted` is the share of samples in them, in per cent: dry friction does not reverse there. `sample_percent` is of
    every sample, with noise of torques, at rest and at reversals, too; `band_percent` of every sample, both sides
    through the Butterworth filter of positions: what is faster than the motion is noise. They are of records that were
    not fitted.
    """

    source: str
    residual: dict[str, float]
    percent: dict[str, float]
    counted: dict[str, float] = field(default_factory=dict)
    sample_percent: dict[str, float] = field(default_factory=dict)
    band_percent: dict[str, float] = field(default_factory=dict)


def own_fit(result: Identification) -> Fit:
    """Return the residuals of the estimates in the records from which they were identified."""
    return _fit(result.machine, result.tau, result.estimation.solution.residuals, "residuals")


def validation_of(result: Identification, record: Measurements) -> Fit:
    """Return the residuals of the estimates in another record. Raises `InputError` where it is too short."""
    chosen = filter_of([record], (), result.filter.motion) if result.filter else None
    sampled = [result.equations.sample(piece, chosen) for piece in in_pieces(record, chosen)]
    tau, residual = (np.concatenate(x) for x in zip(*(_of_averages(result, some) for some in sampled), strict=True))
    if not len(tau):
        raise InputError(record.source, "t", "too short to validate anything: give a longer record")
    averaged = _fit(result.machine, tau, residual, record.source)
    samples = [np.concatenate(x) for x in zip(*(_of_samples(result, some) for some in sampled), strict=True)]
    counted, *both = samples
    percents = 100 * counted.mean(axis=0), _percent(*both[:2]), _percent(*both[2:])
    places = {joint.name: k for k, joint in enumerate(result.machine.independent_joints)}
    by_joint = [{name: float(x[places[name]]) for name in averaged.residual} for x in percents]
    return replace(averaged, counted=by_joint[0], sample_percent=by_joint[1], band_percent=by_joint[2])


def _of_averages(result: Identification, sampled: Sampled) -> tuple[Array, Array]:
    """Return averages of the torques to be explained, and of their residuals, (rows, n)."""
    rows = result.equations.rows(sampled)
    tau = result.equations.torques(sampled, result.delay)[0] - rows.given
    of_laws = _of_laws(result, sampled.motion.part(slice(None)))
    averages = [sampled.averages(of_laws[:, :, c]) for c in range(of_laws.shape[2])]
    Y = np.concatenate([rows.Y, *(x[:, :, None] for x in averages)], axis=2)
    return tau, tau - _predicted_torques(result, Y, rows.offsets)


def _of_samples(result: Identification, sampled: Sampled) -> tuple[Array, ...]:
    """Return which samples count, residuals and torques of all samples, and both low-pass filtered, (N, n)."""
    motion, equations = sampled.motion, result.equations
    late = equations.Y.joint_torques(motion.q, sampled.torques(result.delay)[0])
    residual, torque = np.zeros_like(late), np.zeros_like(late)
    for piece in sampled.pieces:
        q, qd, qdd = motion.part(piece)
        units = np.eye(motion.tau.shape[1])
        offsets = np.stack([equations.Y.joint_torques(q, np.tile(unit, (len(q), 1))) for unit in units], axis=2)
        torque[piece] = late[piece] - equations.fixed_torques((q, qd, qdd))
        Y = [equations.Y.evaluate(q, qd, qdd, equations.estimated_columns), _of_laws(result, (q, qd, qdd))]
        predicted = _predicted_torques(result, np.concatenate(Y, axis=2), offsets)
        residual[piece] = torque[piece] - predicted
    chosen, record = sampled.chosen, replace(sampled.record, t=motion.t)
    slow = [residual, torque] if chosen is None else [smooth(x, chosen, record) for x in (residual, torque)]
    return sampled.counted.astype(float), residual, torque, *slow


def _percent(residual: Array, torque: Array) -> Array:
    """Return residuals in per cent of torques, (n)."""
    size = np.sqrt((torque**2).mean(axis=0))
    percent: Array = 100 * np.sqrt((residual**2).mean(axis=0)) / np.where(size > 0, size, np.nan)
    return percent


def _of_laws(result: Identification, motion: tuple[Array, Array, Array]) -> Array:
    """Return the columns of laws of friction."""
    return result.laws.columns(result.equations.Y, result.equations.linear, motion)


def _predicted_torques(result: Identification, Y: Array, offsets: Array) -> Array:
    """Return Y X and offsets of torques, (rows, n)."""
    sought, X = np.concatenate([Y, offsets[:, :, list(result.sensors.offsets)]], axis=2), result.estimation.solution.X
    places = [(k, c) for k, c in enumerate(result.estimation.grouping.kept) if c < sought.shape[2]]
    about = [result.estimates[c].unknown.about for _, c in places]
    predicted: Array = sought[:, :, [c for _, c in places]] @ (X[[k for k, _ in places]] + about)
    return predicted


def _fit(machine: Machine, tau: Array, residuals: Array, source: str) -> Fit:
    largest = np.abs(tau).max(axis=0)
    driven = np.flatnonzero(largest > ROUNDING * largest.max(initial=0.0)).tolist()
    motors = sorted({*machine.motor_entries, *driven})
    names = [machine.independent_joints[k].name for k in motors]
    used = np.maximum((tau != 0).sum(axis=0), 1)
    errors, of = (np.sqrt((x**2).sum(axis=0) / used)[motors].tolist() for x in (residuals, tau))
    percent = [100 * a / b if b else math.nan for a, b in zip(errors, of, strict=True)]
    return Fit(source, dict(zip(names, errors, strict=True)), dict(zip(names, percent, strict=True)))
