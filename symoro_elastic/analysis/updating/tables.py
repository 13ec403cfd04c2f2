"""Columns of frequency responses and of natural frequencies, from .csv and .npz files.

Responses: `f`, then `re OUT/IN` and `im OUT/IN`, or `mag OUT/IN` and `phase OUT/IN [deg]`, and `coherence OUT/IN`.
Natural frequencies: `frequency`, `damping_ratio`, `std_frequency`, `std_damping`, and a column `OUT` for each shape.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from symoro_elastic.analysis.time_series.reading import Columns
from symoro_elastic.analysis.updating.file_texts import FileResponse, name_and_unit, pair_name
from symoro_elastic.analysis.updating.measured import MeasuredModes
from symoro_elastic.analysis.updating.signal_names import Names
from symoro_elastic.foundation.array_types import Array, BoolArray, ComplexArray
from symoro_elastic.foundation.errors import InputError

FREQUENCY_UNITS = {"Hz": 1.0, "kHz": 1e3, "rad/s": 1 / (2 * math.pi)}
TIME_UNITS = {"s": 1.0, "ms": 1e-3, "us": 1e-6}
PHASE_UNITS = {"deg": math.pi / 180, "rad": 1.0}
RATIO_UNITS = {"1": 1.0, "%": 0.01}
MOST_RADIANS = 100.0
"""Of a phase, unwrapped or not: what is above it is in degrees."""
PARTS = ("re", "im", "mag", "phase", "coherence")
COMPLEX = (("re", "im"), ("mag", "phase"))
SAVED = ("frequencies", "G", "inputs", "outputs")
"""Arrays of the .npz file of a response."""
TIME, FREQUENCY, OF_MODES = "t", "f", ("frequency", "damping_ratio", "std_frequency", "std_damping")
_COLUMN = re.compile(rf"(?P<part>{'|'.join(PARTS)})\s+(?P<pair>.+)")
_DECIBEL = re.compile(r"dB(?:\s+re\s+(?:1\s+)?(?P<unit>.+))?")


@dataclass(frozen=True)
class _Column:
    header: str
    unit: str | None
    x: Array


def responses_in(columns: Columns, source: str) -> list[FileResponse]:
    """Return the responses of a table, in its order; raises `InputError` that names the column."""
    heads = {header: name_and_unit(header) for header in columns}
    parts: dict[str, dict[str, _Column]] = {}
    f: Array | None = None
    for header, x in columns.items():
        name, unit = heads[header]
        if name == FREQUENCY:
            f = _once(f, x * _chosen(unit or "Hz", FREQUENCY_UNITS, source, header), source, header)
            continue
        found = _COLUMN.fullmatch(name)
        if found is None:
            choices = f"{FREQUENCY}, {', '.join(f'{part} OUT/IN' for part in PARTS)}"
            raise InputError(source, header, f"is no column of frequency responses, which are {choices}: delete it")
        of = parts.setdefault(pair_name(found["pair"]), {})
        if found["part"] in of:
            raise InputError(source, header, "is given twice: keep one")
        of[found["part"]] = _Column(header, unit, x)
    if f is None:
        raise InputError(source, FREQUENCY, "is missing: name the column of frequencies f [Hz]")
    return [_response(name, of, f, source) for name, of in parts.items()]


def saved_responses(arrays: Mapping[str, Any], source: str) -> list[FileResponse]:
    """Return the responses of a .npz file that `response --out` wrote; raises `InputError`."""
    f, G, ins, outs = (arrays[name] for name in SAVED)
    kinds = "".join(x.dtype.kind for x in (f, G, ins, outs))
    if kinds != "fcUU" or not f.ndim == ins.ndim == outs.ndim == 1 or G.shape != (len(f), len(outs), len(ins)):
        raise InputError(source, SAVED[1], "is not complex, frequencies x outputs x inputs: write it by response --out")
    pairs = [(i, j) for i in range(len(outs)) for j in range(len(ins))]
    names = [f"{outs[i]}/{ins[j]}" for i, j in pairs]
    return [FileResponse(name, None, f, G[:, i, j], None, name) for name, (i, j) in zip(names, pairs, strict=True)]


def _once(known: Array | None, x: Array, source: str, header: str) -> Array:
    if known is not None:
        raise InputError(source, header, "is given twice: keep one")
    return x


def _chosen(unit: str, units: Mapping[str, float], source: str, header: str) -> float:
    if unit not in units:
        raise InputError(source, header, f"no unit [{unit}] here: choose from {', '.join(units)}")
    return units[unit]


def _response(name: str, of: Mapping[str, _Column], f: Array, source: str) -> FileResponse:
    """Return a response of its columns: two of them make complex numbers."""
    pairs = [pair for pair in COMPLEX if of.keys() & {*pair}]
    first = next(iter(of.values())).header
    if len(pairs) != 1:
        raise InputError(source, first, f"give one pair of {name}: re and im, or mag and phase")
    for part in pairs[0]:
        if part not in of:
            raise InputError(source, first, f"{part} {name} is missing beside it")
    coherence = _coherence(of["coherence"], source) if "coherence" in of else None
    H, unit = (_cartesian if pairs[0] == COMPLEX[0] else _polar)(of, source)
    return FileResponse(name, unit, f, H, coherence, first)


def _cartesian(of: Mapping[str, _Column], source: str) -> tuple[ComplexArray, str | None]:
    re, im = of["re"], of["im"]
    if re.unit != im.unit:
        raise InputError(source, im.header, f"is in [{im.unit or 'SI'}], {re.header} is not: give both the same unit")
    return re.x + 1j * im.x, re.unit


def _polar(of: Mapping[str, _Column], source: str) -> tuple[ComplexArray, str | None]:
    mag, phase = of["mag"], of["phase"]
    if phase.unit is None:
        raise InputError(source, phase.header, f"say whether the phase is [{'] or ['.join(PHASE_UNITS)}]")
    largest = float(np.abs(phase.x[np.isfinite(phase.x)]).max(initial=0.0))
    if phase.unit == "rad" and largest > MOST_RADIANS:
        raise InputError(source, phase.header, f"up to {largest:g} rad: if these are degrees, write [deg]")
    if phase.unit == "deg" and 0.97 * math.pi < largest <= 1.0001 * math.pi:
        raise InputError(source, phase.header, f"up to {largest:g} deg: if these are radians, write [rad]")
    angle = phase.x * _chosen(phase.unit, PHASE_UNITS, source, phase.header)
    decibel = _DECIBEL.fullmatch(mag.unit or "")
    with np.errstate(over="ignore"):
        size = 10 ** (mag.x / 20) if decibel else mag.x
    if (size < 0).any():
        raise InputError(source, mag.header, "amplitudes are not negative: if these are decibels, write [dB]")
    return size * np.exp(1j * angle), decibel["unit"] if decibel else mag.unit


def _coherence(column: _Column, source: str) -> Array:
    found: Array = column.x * _chosen(column.unit or "1", RATIO_UNITS, source, column.header)
    if reason := why_incoherent(found):
        raise InputError(source, column.header, f"{reason}: if in percent, write [%]")
    return found


def why_incoherent(x: Array) -> str:
    """Return why numbers are no coherence; empty where they are."""
    known = x[np.isfinite(x)]
    worst = known[np.argmax(np.abs(known - 0.5))] if len(known) else 0.5
    return "" if abs(worst - 0.5) <= 0.5 + 1e-6 else f"{worst:g} is no coherence, which is 0 to 1"


# Natural frequencies


def modes_in(columns: Columns, names: Names, source: str, band: tuple[float, float]) -> MeasuredModes:
    """Return the modes of a table whose frequencies are in a band; raises `InputError` that names the column."""
    known: dict[str, Array] = {}
    shapes: dict[str, Array] = {}
    for header, x in columns.items():
        name, unit = name_and_unit(header)
        if name in OF_MODES:
            units = FREQUENCY_UNITS if name.endswith("frequency") else RATIO_UNITS
            factor = _chosen(unit or next(iter(units)), units, source, header)
            known[name] = _once(known.get(name), x * factor, source, header)
        else:
            output, factor = names.output(name, unit, partial(InputError, source, header))
            shapes[output] = x * factor
    names.refuse_unused([*columns])
    f = known["frequency"]
    order = np.flatnonzero((f >= band[0]) & (f <= band[1]))
    _refuse_modes(known, shapes, source)
    if not len(order):
        raise InputError(source, "frequency", f"no mode is within the band, {band[0]:g} to {band[1]:g} Hz: widen it")
    zeta, std_f, std_zeta = (known[name][order] if name in known else None for name in OF_MODES[1:])
    amplitudes = np.stack([*shapes.values()], axis=1)[order].astype(complex) if shapes else None
    return MeasuredModes(f[order], zeta, std_f, std_zeta, tuple(shapes), amplitudes)


# Ring-downs


def signals_in(columns: Columns, names: Names, source: str) -> dict[str, Array]:
    """Return time (`t`, s) and signals by output of a ring-down, in SI units; raises `InputError` naming the column."""
    found: dict[str, Array] = {}
    for header, x in columns.items():
        name, unit = name_and_unit(header)
        if name == TIME:
            found[TIME] = _once(found.get(TIME), x * _chosen(unit or "s", TIME_UNITS, source, header), source, header)
        else:
            output, factor = names.output(name, unit, partial(InputError, source, header))
            found[output] = factor * x
    names.refuse_unused([*columns])
    return found


def _refuse_modes(known: Mapping[str, Array], shapes: Mapping[str, Array], source: str) -> None:
    f = known["frequency"]
    refuse_unsorted(f, np.isfinite(f), source, "frequency")
    if f[0] <= 0:
        raise InputError(source, "frequency", f"{f[0]:g} Hz is no vibration: leave rigid-body motion out")
    for name, x in known.items():
        wrong = (x <= 0) | ((x >= 1) & (name == "damping_ratio"))
        if wrong.any():
            k = int(np.argmax(wrong))
            hint = "if in percent, write [%]" if x[k] >= 1 else "give one above 0, or nan where it is unknown"
            raise InputError(source, name, f"mode {k + 1} has {x[k]:g}: {hint}")
    for name, x in shapes.items():
        if not np.isfinite(x).all():
            raise InputError(source, name, f"mode {int(np.argmin(np.isfinite(x))) + 1} has no amplitude: leave it out")


def refuse_unsorted(f: Array, finite: BoolArray, source: str, place: str) -> None:
    """Raise `InputError` for frequencies that are no numbers, negative, or that do not increase."""
    if not finite.all():
        raise InputError(source, place, f"line {int(np.argmin(finite)) + 1} is {f[~finite][0]:g}, not a frequency")
    if len(f) and f.min() < 0:
        raise InputError(source, place, f"{f.min():g} Hz: frequencies are not negative, give one side of the spectrum")
    steps = np.diff(f)
    if (steps <= 0).any():
        k = int(np.argmax(steps <= 0))
        how = "is there twice" if steps[k] == 0 else f"is followed by {f[k + 1]:.9g} Hz"
        raise InputError(source, place, f"line {k + 1}, {f[k]:.9g} Hz, {how}: sort the lines by frequency, each once")
