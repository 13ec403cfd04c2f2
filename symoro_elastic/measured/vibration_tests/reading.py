"""Vibration tests read from a list of them and its files: .csv, .npz and universal files."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from symoro_elastic.analysis.time_series.column_faults import repetitions
from symoro_elastic.analysis.time_series.reading import NUMBERS_AND_TEXTS, Columns, name_and_unit, read_arrays_of
from symoro_elastic.formats.kinds_of_files import FileKind, read_as
from symoro_elastic.formats.toml.vibration_tests import ListedTest, read_list
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.names import list_of_names
from symoro_elastic.measured.vibration_tests import tables, universal_files
from symoro_elastic.measured.vibration_tests.measured import (
    NO_TEST,
    MeasuredResponse,
    VibrationTest,
    VibrationTests,
    Window,
    WindowKind,
    segment_of,
)
from symoro_elastic.measured.vibration_tests.ring_downs import modes_of_ring_down
from symoro_elastic.measured.vibration_tests.signal_names import FileResponse, Names

FEWEST_LINES = 3
NO_WINDOW = "is of frequency responses, and these are modes or a ring-down: remove it"


def read_tests(path: str | Path, machine: Machine) -> VibrationTests:
    """Return the vibration tests of a machine that a list (.toml) names, from their files.

    Raises
    ------
    InputError
        Naming the file, the test and the key or column: wrong keys, names, units, numbers, files.
    """
    with read_as(FileKind.TESTS, path):
        listed = read_list(path, machine)
    read = [_read(test, machine) for test in listed]
    return VibrationTests(tuple(test for test, _ in read), tuple(note for _, notes in read for note in notes))


def _read(listed: ListedTest, machine: Machine) -> tuple[VibrationTest, list[str]]:
    """Return a test from its file, with notes on what was omitted."""
    test = VibrationTest(
        listed.file, listed.at, listed.hold, listed.pd, listed.averages, listed.validate, drives=listed.drives
    )  # fmt: skip
    names, source = Names(machine, listed), str(listed.path)
    if listed.path.suffix.lower() in universal_files.SUFFIXES:
        return _of_universal_file(test, names)
    columns = read_arrays_of(listed.path, NUMBERS_AND_TEXTS)
    if {*tables.SAVED} <= columns.keys():
        return _with_responses(test, tables.saved_responses(columns, source), names)
    for header, x in columns.items():
        if x.ndim != 1 or x.dtype.kind != "f" or len(x) != len(next(iter(columns.values()))):
            what = f"has shape {x.shape}: numbers are needed, real, as many as in {next(iter(columns))}"
            raise InputError(source, header, what)
    heads = {name_and_unit(header)[0] for header in columns}
    if tables.FREQUENCY in heads:
        return _with_responses(test, tables.responses_in(columns, source), names)
    if listed.window:
        raise listed.fail("window", NO_WINDOW)
    if tables.OF_MODES[0] in heads:
        return replace(test, modes=tables.modes_in(columns, names, source, listed.band)), []
    if tables.TIME in heads:
        signals = tables.signals_in(columns, names, source)
        modes, left_out = modes_of_ring_down(signals.pop(tables.TIME), signals, listed.band, source)
        return replace(test, modes=modes), [f"{listed.file}: {note}" for note in left_out]
    what = f"has neither {tables.FREQUENCY} nor {tables.OF_MODES[0]} nor {tables.TIME}: responses begin with f [Hz], "
    what += "natural frequencies with frequency, ring-downs with t"
    raise InputError(source, "columns", what)


def _of_universal_file(test: VibrationTest, names: Names) -> tuple[VibrationTest, list[str]]:
    """Return a test with the responses of a universal file, or with its modes where it has none."""
    listed, path = names.test, names.test.path
    if responses := universal_files.read_universal_file(path):
        return _with_responses(test, responses, names)
    modes = universal_files.modes_of_universal_file(path)
    if not modes:
        what = f"no frequency response and no mode; the file holds {universal_files.contents_of(path)}"
        raise InputError(str(path), "responses", what)
    if listed.window:
        raise listed.fail("window", NO_WINDOW)
    columns = {name: x for name, x in modes.items() if name in tables.OF_MODES or name in names.rename}
    skipped = [name for name in modes if name not in columns]
    names.used |= columns.keys() & names.rename.keys()
    names.refuse_unused([*modes])
    notes = (
        [f"{listed.file}: shapes at {list_of_names(skipped)} are skipped: rename them to use them"] if skipped else []
    )
    return replace(test, modes=tables.modes_in(Columns(columns), names, str(path), listed.band)), notes


def _with_responses(
    test: VibrationTest, responses_of_file: Sequence[FileResponse], names: Names
) -> tuple[VibrationTest, list[str]]:
    """Return a test with the responses of its file by the names of the machine."""
    listed = names.test
    nodal = listed.path.suffix.lower() in universal_files.SUFFIXES
    named = [entry for entry in responses_of_file if not nodal or entry.name in names.rename]
    notes = []
    if skipped := [entry.name for entry in responses_of_file if entry not in named]:
        what = f"{listed.file}: {list_of_names(skipped)} are skipped"
        notes.append(f"{what}: rename them to use them")
    responses = []
    for entry in named:
        response, lost = _measured_response(entry, names)
        responses.append(response)
        notes += lost
    names.refuse_unused([entry.name for entry in responses_of_file])
    if not responses:
        names_of_file = list_of_names(entry.name for entry in responses_of_file)
        there = f"there are {names_of_file}: rename them" if responses_of_file else "there are none"
        raise InputError(str(listed.path), "responses", f"no response of the machine, {there}")
    if (listed.averages or 1) == 1 or any(entry.coherence is None for entry in responses):
        notes.append(_without_noise(listed, responses))
    return replace(test, responses=tuple(responses), window=_window(listed, responses)), notes


def _window(listed: ListedTest, responses: Sequence[MeasuredResponse]) -> Window | None:
    """Return the window that a test names; raises `InputError` where lines do not determine its segments."""
    if listed.window is None:
        return None
    kind, time = WindowKind(listed.window[0]), listed.window[1]
    if kind is WindowKind.EXPONENTIAL:
        return Window(kind, decay=time or math.inf)
    if kind is WindowKind.HANN:
        time = time or segment_of(responses[0].f)
        if time is None:
            what = "lines are not even: give the length of segments, window = { hann = 0.5 }"
            raise listed.fail("window", what)
    return Window(kind, time or math.nan)


def _without_noise(listed: ListedTest, responses: Iterable[MeasuredResponse]) -> str:
    """Return a note that a file lacks coherence or averages, which determine the noise."""
    lacking = [response.pair for response in responses if response.coherence is None]
    averages = "averages" if listed.averages is None else "second average" if listed.averages == 1 else ""
    what = " and ".join(filter(None, [f"coherence of {', '.join(lacking)}" if lacking else "", averages]))
    return f"{listed.file}: no {what}: {NO_TEST}"


def _measured_response(entry: FileResponse, names: Names) -> tuple[MeasuredResponse, list[str]]:
    """Return a response in SI units, its lines sorted, finite, within the band; and notes about lines left out."""
    listed, source = names.test, str(names.test.path)
    output, given, factor = names.pair(entry, source)
    tables.refuse_unsorted(entry.f, np.isfinite(entry.f), source, entry.place)
    low, high = listed.band
    inside = (entry.f >= low) & (entry.f <= high)
    still = entry.f == 0
    with np.errstate(over="ignore", invalid="ignore"):
        H = factor * entry.H
    finite = np.isfinite(H) & (True if entry.coherence is None else np.isfinite(entry.coherence))
    filled = repetitions(entry.H)
    used = inside & ~still & finite & ~filled
    if used.sum() < FEWEST_LINES:
        what = f"{used.sum()} lines with numbers between {low:g} and {high:g} Hz, above 0: {FEWEST_LINES} are needed"
        raise InputError(source, entry.place, f"{what}; widen the band, or measure again")
    left_out = (
        (inside & still, "at 0 Hz"),
        (inside & ~still & ~finite, "without a number"),
        (inside & ~still & finite & filled, "which repeat the one before"),
    )
    notes = [
        f"{listed.file}: {output} / {given}: {lines.sum()} of {len(lines)} lines, {what}, are left out"
        for lines, what in left_out
        if lines.any()
    ]
    coherence = None if entry.coherence is None else np.clip(entry.coherence[used], 0.0, 1.0)
    return MeasuredResponse(output, given, entry.f[used], H[used], coherence), notes
