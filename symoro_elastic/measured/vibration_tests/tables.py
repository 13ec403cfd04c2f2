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

from symoro_elastic.analysis.time_series.measurements import missing
from symoro_elastic.analysis.time_series.reading import Columns, name_and_unit
from symoro_elastic.foundation.array_types import Array, BoolArray, ComplexArray
from symoro_elastic.foundation.errors import TWICE, InputError
from symoro_elastic.measured.vibration_tests.measured import MeasuredModes
from symoro_elastic.measured.vibration_tests.signal_names import FileResponse, Names, pair_name
from symoro_elastic.quantities.unit_reader import UnitError, conversion

MOST_RADIANS = 100.0  # of a phase, unwrapped or not: what is above it is in degrees
PARTS = ("re", "im", "mag", "phase", "coherence")
COMPLEX = (("re", "im"), ("mag", "phase"))
SAVED = ("frequencies", "G", "inputs", "outputs")  # arrays of the .npz file of a response
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
            f = _once(f, x * factor_of(unit, "Hz", source, header), source, header)
            continue
        match = _COLUMN.fullmatch(name)
        if match is None:
            choices = f"{FREQUENCY}, {', '.join(f'{part} OUT/IN' for part in PARTS)}"
            raise InputError(source, header, f"is not a column of frequency responses, which are {choices}: delete it")
        of = parts.setdefault(pair_name(match["pair"]), {})
        if match["part"] in of:
            raise InputError(source, header, TWICE)
        of[match["part"]] = _Column(header, unit, x)
    if f is None:
        raise missing([FREQUENCY], columns, source, "name the column of frequencies f [Hz]")
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
        raise InputError(source, header, TWICE)
    return x


def factor_of(unit: str | None, needed: str, source: str, header: str) -> float:
    """Return the factor from the unit of a column, 1 where it has none; raises `InputError`."""
    try:
        return 1.0 if unit is None else conversion(unit, needed).number
    except UnitError as error:
        raise InputError(source, header, str(error)) from None


def _response(name: str, of: Mapping[str, _Column], f: Array, source: str) -> FileResponse:
    """Return a response of its columns: two of them make complex numbers."""
    pairs = [pair for pair in COMPLEX if of.keys() & {*pair}]
    first = next(iter(of.values())).header
    if len(pairs) != 1:
        raise InputError(source, first, f"give one pair of {name}: re and im, or mag and phase")
    for part in pairs[0]:
        if part not in of:
            raise InputError(source, first, f"{part} {name} is missing")
    coherence = _coherence(of["coherence"], source) if "coherence" in of else None
    H, unit = (_cartesian if pairs[0] == COMPLEX[0] else _polar)(of, source)
    return FileResponse(name, unit, f, H, coherence, first)


def _cartesian(of: Mapping[str, _Column], source: str) -> tuple[ComplexArray, str | None]:
    re, im = of["re"], of["im"]
    if re.unit != im.unit:
        raise InputError(source, im.header, f"is in [{im.unit or 'SI'}], {re.header} is not: give both the same unit")
    with np.errstate(invalid="ignore"):  # frequencies without a number are left out
        return re.x + 1j * im.x, re.unit


def _polar(of: Mapping[str, _Column], source: str) -> tuple[ComplexArray, str | None]:
    mag, phase = of["mag"], of["phase"]
    if phase.unit is None:
        raise InputError(source, phase.header, "say whether the phase is [deg] or [rad]")
    largest = float(np.abs(phase.x[np.isfinite(phase.x)]).max(initial=0.0))
    if phase.unit == "rad" and largest > MOST_RADIANS:
        raise InputError(source, phase.header, f"up to {largest:g} rad: if these are degrees, write [deg]")
    if phase.unit == "deg" and 0.97 * math.pi < largest <= 1.0001 * math.pi:
        raise InputError(source, phase.header, f"up to {largest:g} deg: if these are radians, write [rad]")
    angle = phase.x * factor_of(phase.unit, "rad", source, phase.header)
    decibel = _DECIBEL.fullmatch(mag.unit or "")
    with np.errstate(over="ignore"):
        size = 10 ** (mag.x / 20) if decibel else mag.x
    if (size < 0).any():
        raise InputError(source, mag.header, "amplitudes are not negative: if these are decibels, write [dB]")
    return size * np.exp(1j * angle), decibel["unit"] if decibel else mag.unit


def _coherence(column: _Column, source: str) -> Array:
    coherence: Array = column.x * factor_of(column.unit, "", source, column.header)
    if reason := why_incoherent(coherence):
        raise InputError(source, column.header, f"{reason}: if in percent, write [%]")
    return coherence


def why_incoherent(x: Array) -> str:
    """Return why numbers cannot be a coherence; empty where they can."""
    finite = x[np.isfinite(x)]
    worst = finite[np.argmax(np.abs(finite - 0.5))] if len(finite) else 0.5
    return "" if abs(worst - 0.5) <= 0.5 + 1e-6 else f"{worst:g} is no coherence, which is 0 to 1"


# Natural frequencies


def modes_in(columns: Columns, names: Names, source: str, band: tuple[float, float]) -> MeasuredModes:
    """Return the modes of a table whose frequencies are in a band; raises `InputError` that names the column."""
    numbers: dict[str, Array] = {}
    shapes: dict[str, Array] = {}
    for header, x in columns.items():
        name, unit = name_and_unit(header)
        if name in OF_MODES:
            factor = factor_of(unit, "Hz" if name.endswith("frequency") else "", source, header)
            numbers[name] = _once(numbers.get(name), x * factor, source, header)
        else:
            output, factor = names.output(name, unit, partial(InputError, source, header))
            shapes[output] = x * factor
    names.refuse_unused([*columns])
    f = numbers["frequency"]
    order = np.flatnonzero((f >= band[0]) & (f <= band[1]))
    _refuse_modes(numbers, shapes, source)
    if not len(order):
        raise InputError(source, "frequency", f"no mode is within the band, {band[0]:g} to {band[1]:g} Hz: widen it")
    zeta, std_f, std_zeta = (numbers[name][order] if name in numbers else None for name in OF_MODES[1:])
    amplitudes = np.stack([*shapes.values()], axis=1)[order].astype(complex) if shapes else None
    return MeasuredModes(f[order], zeta, std_f, std_zeta, tuple(shapes), amplitudes)


# Ring-downs


def signals_in(columns: Columns, names: Names, source: str) -> dict[str, Array]:
    """Return time (`t`, s) and signals by output of a ring-down, in SI units; raises `InputError` naming the column."""
    signals: dict[str, Array] = {}
    for header, x in columns.items():
        name, unit = name_and_unit(header)
        if name == TIME:
            signals[TIME] = _once(signals.get(TIME), x * factor_of(unit, "s", source, header), source, header)
        else:
            output, factor = names.output(name, unit, partial(InputError, source, header))
            signals[output] = factor * x
    names.refuse_unused([*columns])
    return signals


def _refuse_modes(known: Mapping[str, Array], shapes: Mapping[str, Array], source: str) -> None:
    f = known["frequency"]
    refuse_unsorted(f, np.isfinite(f), source, "frequency")
    if f[0] <= 0:
        raise InputError(source, "frequency", f"{f[0]:g} Hz is not a vibration: remove rigid-body motion")
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
    """Raise `InputError` for frequencies that are NaN, negative, or do not increase."""
    if not finite.all():
        raise InputError(source, place, f"line {int(np.argmin(finite)) + 1} is {f[~finite][0]:g}, not a frequency")
    if len(f) and f.min() < 0:
        raise InputError(source, place, f"{f.min():g} Hz: frequencies are not negative, give one side of the spectrum")
    steps = np.diff(f)
    if (steps <= 0).any():
        k = int(np.argmax(steps <= 0))
        how = "is there twice" if steps[k] == 0 else f"is followed by {f[k + 1]:.9g} Hz"
        raise InputError(source, place, f"line {k + 1}, {f[k]:.9g} Hz, {how}: sort the lines by frequency, each once")
