"""Clocks of logged records: damaged and repeated rows, jitter of time stamps, gaps.

Nothing is invented. Rows are left out, a record is split where samples are missing, and times are changed only where
positions show that samples are even although their stamps are not.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np

from symoro_elastic.analysis.time_series.column_faults import frozen, stays
from symoro_elastic.analysis.time_series.measurements import Measurements, refuse_unsorted
from symoro_elastic.foundation.array_types import Array, BoolArray
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.machine import Machine

MOST_DAMAGED = 0.5  # of the samples
FASTER = 0.01  # of the largest velocity: slope of positions beyond a velocity that stays
GAP = 1.9  # usual steps: a sample is missing
MOST_SCATTER = 1.5  # usual steps, and those that one stamp stands for, that stamps are off an even clock
SMOOTHER = 0.5  # roughness of positions by an even clock over that by stamps


def tidy(record: Measurements, machine: Machine) -> Measurements:
    """Return the record on an even clock, without damaged and repeated rows, with a note on each change.

    Raises `InputError` for time that goes back or stands still, and columns that are hardly ever numbers.
    """
    damaged = {name: ~np.isfinite(x) for name, x in record.columns(machine).items()}
    record = _without_frozen(_without_repeated(_without(record, damaged, "NaN or infinity")), machine)
    if len(record.t) > 2 and (np.diff(record.t) >= 0).all():
        record = _at_even_times(record)
    refuse_unsorted(record)
    return record


def pieces(record: Measurements, longest: float) -> list[Measurements]:
    """Return the parts of a record between steps of more than `longest` periods; the first has the warnings."""
    ends = np.flatnonzero(np.diff(record.t) > longest * record.period) + 1
    parts = zip([0, *ends.tolist()], [*ends.tolist(), len(record.t)], strict=True)
    records = [part_of(record, slice(*ends)) for ends in parts] if len(ends) else [record]
    return [records[0], *(replace(piece, warnings=()) for piece in records[1:])]


def missing_samples(record: Measurements) -> BoolArray:
    """Return a mask (N - 1) of the steps in which at least one sample is missing."""
    return np.asarray(np.diff(record.t) > GAP * record.period)


def part_of(record: Measurements, some: slice | BoolArray) -> Measurements:
    """Return some samples of a record."""
    return with_change(record, record.t[some], lambda x: x[some])


def with_change(record: Measurements, t: Array, change: Callable[[Array], Array]) -> Measurements:
    """Return the record at other times, each block transformed by `change`."""
    qd, qdd = (None if x is None else change(x) for x in (record.qd, record.qdd))
    return replace(record, t=t, q=change(record.q), tau=change(record.tau), qd=qd, qdd=qdd)


def _without_frozen(record: Measurements, machine: Machine) -> Measurements:
    """Return the record without samples of frozen positions or velocities during motion."""
    names = [joint.name for joint in machine.independent_joints]
    bad = {f"q_{name}": frozen(q) for name, q in zip(names, record.q.T, strict=True)}
    record = _without(record, bad, "no change amid motion, as beyond the end of a sensor,")
    for name, q, qd in zip(names, record.q.T, () if record.qd is None else record.qd.T, strict=False):
        at = stays(qd)
        faster = np.sign(qd[at]) * (np.gradient(q, record.t)[at] - qd[at])
        if at.any() and faster.mean() > FASTER * np.abs(qd).max():
            what = f"qd is not used: qd_{name} stays at its ends at {at.sum()} of {len(at)} samples, while q goes on"
            return replace(record, qd=None, warnings=(*record.warnings, what))
    return record


def _without(record: Measurements, bad: dict[str, BoolArray], what: str) -> Measurements:
    """Return the record without bad samples of any column, with a note; raises `InputError` if most are bad."""
    bad = {name: where for name, where in bad.items() if where.any()}
    if not bad:
        return record
    damaged: BoolArray = np.any(list(bad.values()), axis=0)
    named, count = ", ".join(bad), int(damaged.sum())
    what = f"{what} at {count} of {len(damaged)} samples, first at sample {int(damaged.argmax()) + 1}"
    if count > MOST_DAMAGED * len(damaged):
        raise InputError(record.source, named, f"{what}: leave a column out that was not recorded, or cut the record")
    remaining = part_of(record, ~damaged)
    return replace(remaining, warnings=(*record.warnings, f"{named}: {what}: these samples are left out"))


def _without_repeated(record: Measurements) -> Measurements:
    same = np.diff(record.t) == 0
    for block in (record.q, record.tau, record.qd, record.qdd):
        if block is not None:
            same &= (np.diff(block, axis=0) == 0).all(axis=1)
    if not same.any():
        return record
    what = f"{int(same.sum())} of {len(record.t)} samples repeat the one before, with its time: left out"
    return replace(part_of(record, np.concatenate([[True], ~same])), warnings=(*record.warnings, what))


def _at_even_times(record: Measurements) -> Measurements:
    """Return the record at the times of an even clock, if positions are then smoother than by their time stamps."""
    if record.is_even:
        return record
    best, t = _roughness(record.t, record.q), record.t
    for count in _counts(t):
        even = np.polynomial.Polynomial.fit(count, t, 1)(count)
        period = float((even[-1] - even[0]) / (count[-1] - count[0]))
        at_once, off = len(t) / len(np.unique(t)), float(np.abs(even - t).max())
        if off <= MOST_SCATTER * max(1.0, at_once) * period and _roughness(even, record.q) < SMOOTHER * best:
            scatter = f"{1e3 * off:.3g} ms"
            what = f"stamps are up to {scatter} off an even clock of {1e3 * period:.4g} ms, and positions are smooth by"
            return replace(record, t=even, warnings=(*record.warnings, f"{what} that clock: its times are taken"))
    return record


def _counts(t: Array) -> Iterator[Array]:
    """Yield possible tick numbers of the samples on an even clock: consecutive, or with gaps."""
    yield np.arange(len(t), dtype=float)
    usual = float(np.median(np.diff(t)))
    ticks = np.round((t - t[0]) / usual) if usual > 0 else np.zeros(len(t))
    if (np.diff(ticks) > 0).all():
        yield ticks


def _roughness(t: Array, q: Array) -> float:
    """Return the mean square deviation of positions from linear interpolation, scaled per joint.

    Infinite where samples have the same time.
    """
    if (np.diff(t) <= 0).any():
        return np.inf
    share = ((t[1:-1] - t[:-2]) / (t[2:] - t[:-2]))[:, None]
    off = q[1:-1] - q[:-2] - share * (q[2:] - q[:-2])
    size = q.var(axis=0)
    return float(((off**2).mean(axis=0) / np.where(size > 0, size, 1.0)).sum())
