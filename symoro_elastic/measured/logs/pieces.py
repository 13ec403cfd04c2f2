"""Records with gaps: pieces in which samples follow each other, and the filter that all of them share."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from symoro_elastic.analysis.time_series.clocks import GAP, missing_samples, pieces
from symoro_elastic.analysis.time_series.measurements import Measurements
from symoro_elastic.foundation.errors import InputError, refuse_numbers
from symoro_elastic.measured.logs.estimation import refuse_short
from symoro_elastic.measured.logs.filtering import Filter, default_filter, smooth, still_joints

BRIDGED = 0.1  # of the window of averages: longer gaps split a record
BEFORE_FILTER = 10.0  # usual steps: gaps that split a record before its filter is known
LONG = 0.5  # of the longest piece: those whose bandwidth counts
SAME_RATE = 0.02  # of the sampling frequency


def filter_of(records: Sequence[Measurements], motors: Sequence[int], bandwidth: float | None) -> Filter:
    """Return the filter of the fastest motion, used for all records.

    Raises `InputError` for records at different sampling frequencies.
    """
    first = records[0]
    for record in records:
        if abs(record.period / first.period - 1) > SAME_RATE:
            rates = f"{1 / first.period:.6g} Hz in {first.source}, {1 / record.period:.6g} Hz in {record.source}"
            what = f"records are sampled at {rates}: resample them"
            raise InputError(
                record.source, "t", f"{what}, with --resample {min(1 / first.period, 1 / record.period):.4g}"
            )
    parts = [pieces(record, BEFORE_FILTER) for record in records]
    long = [x for some in parts for x in some if len(x.t) >= LONG * max(len(other.t) for other in some)]
    return max((default_filter(piece, motors, bandwidth) for piece in long), key=lambda chosen: chosen.motion)


def in_pieces(record: Measurements, chosen: Filter | None) -> list[Measurements]:
    """Return the pieces of a record that are long enough for an average, with notes on gaps and the samples in use.

    Gaps of up to a tenth of the window are bridged: positions there are interpolated for the filter. Raises
    `InputError` where no piece is long enough.
    """
    if record.is_even:
        return [record]
    longest = max(GAP, BRIDGED * chosen.window + 1) if chosen else GAP
    every = pieces(record, longest)
    least = 2 * chosen.trim + chosen.window if chosen else 5
    long_enough = [piece for piece in every if len(piece.t) >= least]
    gaps = f"{len(every) - 1} gaps" if len(every) != 2 else "1 gap"
    if not long_enough:
        what = f"{gaps} leave no piece of {least * record.period:.3g} s, which filters of this motion need"
        raise InputError(record.source, "t", f"{what}: measure again, or give a higher --bandwidth")
    first = replace(long_enough[0], warnings=(*record.warnings, *_notes(record, every, long_enough, gaps)))
    return [first, *long_enough[1:]]


def _refuse_rest(records: Sequence[Measurements], chosen: Filter) -> None:
    """Raise `InputError` for records in which no joint moves beyond the noise of its sensor."""
    for record in records:
        slow = smooth(record.q, chosen, record)
        if len(still_joints(slow, record.q - slow)) < record.q.shape[1]:
            return
    what = "no joint moves beyond the noise of its sensor: nothing can be identified at rest"
    raise InputError(records[0].source, "q", what)


def _notes(record: Measurements, every: Sequence[Measurements], used: Sequence[Measurements], gaps: str) -> list[str]:
    """Return notes on gaps, and on the steps of uneven sampling."""
    lines = []
    share = 100 * sum(float(np.ptp(piece.t)) for piece in used) / float(np.ptp(record.t))
    if len(every) > 1:
        number = f"{len(used)} pieces" if len(used) > 1 else "1 piece"
        lines.append(f"{record.source}: {gaps}, {number}, {share:.3g} % of the record used")
    short = sum(int(missing_samples(piece).sum()) for piece in used)
    if short:
        what = "positions are interpolated there, torques are not"
        lines.append(f"{record.source}: {short} short gaps are bridged: {what}")
    steps = 1e3 * np.concatenate([np.diff(piece.t)[~missing_samples(piece)] for piece in used])
    low, high = np.quantile(steps, (0.01, 0.99)).tolist()
    if high - low > 0.1 * 1e3 * record.period:
        what = f"sampling is uneven, steps of {low:.3g} to {high:.3g} ms"
        lines.append(
            f"{record.source}: {what}: positions are filtered on an even clock, torques count at their own times"
        )
    return lines


def refuse_amount(
    pieces_of_records: Sequence[Sequence[Measurements]], chosen: Filter | None, parameters: int, may_be_few: bool
) -> None:
    """Raise `InputError` for records at rest, with too few equations unless `may_be_few`, or with more equations than
    memory has room for, those of both noise records included."""
    records = [piece for pieces in pieces_of_records for piece in pieces]
    source, rows = records[0].source, sum(record.q.size for record in records)
    if chosen:
        _refuse_rest(records, chosen)
        rows = sum(len(chosen.starts(len(record.t) - 2 * chosen.trim)) * record.q.shape[1] for record in records)
    if not may_be_few:
        refuse_short(rows, parameters, chosen.correlation if chosen else (1.0,), source)
    what = f"{rows} equations after filtering for {parameters} parameters"
    way_out = "use less of the record (--after, --before), or a lower --bandwidth"
    refuse_numbers(3 * rows * parameters, what, source, "t", way_out)
