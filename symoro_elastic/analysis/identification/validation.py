"""How well tau = Y X explains torques: those it was found from, and those of another record."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from symoro_elastic.analysis.identification.filtering import Filter, default_filter
from symoro_elastic.analysis.identification.identify import Identification, Rows
from symoro_elastic.analysis.time_series.measurements import Measurements
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.machine import Machine

ROUNDING = 1e-12
"""Of the largest torque, of what motors on dependent joints exert on a joint that they do not move."""


@dataclass(frozen=True)
class Fit:
    """Residuals of what motors exert in a record, by the joint that moves: root mean square (N m or N), and in per cent
    of that of the torques that the sought parameters explain."""

    source: str
    residual: dict[str, float]
    percent: dict[str, float]


def own_fit(result: Identification) -> Fit:
    """Return how well the estimates explain the records that they are from."""
    return _fit(result.machine, result.tau, result.estimation.solution.residuals, "residuals")


def validation_of(result: Identification, record: Measurements) -> Fit:
    """Return how well the estimates explain another record. Raises `InputError` where it is too short."""
    rows = result.equations.rows(record, _same_filter(result, record))
    if not len(rows.t):
        raise InputError(record.source, "t", "too short to validate anything: give a longer record")
    return _fit(result.machine, rows.tau, rows.tau - _predicted(result, rows), record.source)


def _predicted(result: Identification, rows: Rows) -> Array:
    kept = list(result.estimation.grouping.kept)
    predicted: Array = rows.Y[:, :, kept] @ result.estimation.solution.X
    return predicted


def _same_filter(result: Identification, record: Measurements) -> Filter | None:
    """Return the filter of the identification at the sampling frequency of a record."""
    if result.filter is None:
        return None
    return default_filter(record, bandwidth=result.filter.motion)


def _fit(machine: Machine, tau: Array, residuals: Array, source: str) -> Fit:
    largest = np.abs(tau).max(axis=0)
    driven = np.flatnonzero(largest > ROUNDING * largest.max(initial=0.0)).tolist()
    motors = sorted({*machine.motor_entries, *driven})
    names = [machine.independent_joints[k].name for k in motors]
    used = np.maximum((tau != 0).sum(axis=0), 1)
    left, of = (np.sqrt((x**2).sum(axis=0) / used)[motors].tolist() for x in (residuals, tau))
    percent = [100 * a / b if b else math.nan for a, b in zip(left, of, strict=True)]
    return Fit(source, dict(zip(names, left, strict=True)), dict(zip(names, percent, strict=True)))
