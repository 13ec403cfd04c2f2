"""Frequency responses from universal files (.uff, .unv): data sets 58, read by the package pyuff.

The format has six digits for frequencies; responses have twelve, or six in single precision.
"""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from symoro_elastic.analysis.updating.file_texts import FileResponse, factor_to
from symoro_elastic.analysis.updating.tables import FREQUENCY_UNITS, why_incoherent
from symoro_elastic.analysis.vibration.responses import quotient_unit
from symoro_elastic.foundation.array_types import Array, ComplexArray
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.foundation.input_files import open_file, size_of
from symoro_elastic.foundation.packages import import_optional

SUFFIXES = (".uff", ".unv")
MOST_BYTES = 200_000_000
FUNCTIONS, UNITS = 58, 164
"""Types of data sets."""
RESPONSE, COHERENCE = 4, 6
"""Types of functions."""
DIRECTIONS = ("S", "+X", "+Y", "+Z", "+RX", "+RY", "+RZ")
"""By number; -1 is -X, and so on."""
GENERAL, FREQUENCY = 1, 18
UNSAID = "not said"
LENGTHS, FORCES = {8: "m", 11: "m/s", 12: "m/s2"}, (9, 13)
"""Specific data types: displacement, velocity, acceleration; reaction and excitation force."""


def read_universal_file(path: Path) -> list[FileResponse]:
    """Return the frequency responses of a universal file, named `3:+Z/1:+X` by nodes and directions.

    Responses in negative directions are turned. Units are those of its labels, else of its data set 164, else SI.
    Raises `InputError` for files that are damaged or hold no responses, and for responses that are there twice.
    """
    source = str(path)
    sets = _sets(path)
    system = next((one for kind, one in sets if kind == UNITS), None)
    responses: dict[str, FileResponse] = {}
    coherences: dict[str, tuple[Array, Array]] = {}
    for k, one in enumerate((one for kind, one in sets if kind == FUNCTIONS), start=1):
        place = f"function {k}"
        if one["func_type"] not in (RESPONSE, COHERENCE):
            continue
        name, sign = _name(one, source, place)
        if name in (responses if one["func_type"] == RESPONSE else coherences):
            raise InputError(source, place, f"{name} is there twice: keep one")
        f, data = _numbers(one, source, place)
        if one["func_type"] == COHERENCE:
            coherences[name] = f, _coherence(data, source, place)
        else:
            unit, scale = _unit(one, system)
            responses[name] = FileResponse(name, unit, f, sign * _complex(data, source, place), None, place, scale)
    return [_with_coherence(one, coherences, source) for one in responses.values()]


def _sets(path: Path) -> list[tuple[int, Mapping[str, Any]]]:
    """Return the data sets of functions and of units, with their types."""
    pyuff = import_optional("pyuff", "reading universal files", "uff")
    source = str(path)
    with open_file(path) as file:
        if size_of(file) > MOST_BYTES:
            raise InputError(source, "file", f"larger than {MOST_BYTES // 10**6} MB: cut it")
    found = []
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            reader = pyuff.UFF(source)
            for k, kind in enumerate(map(int, reader.get_set_types())):
                if kind in (FUNCTIONS, UNITS):
                    found.append((kind, reader.read_sets(k)))
        except Exception:  # of any kind: pyuff takes files to be whole
            what = f"data set {len(found) + 1} cannot be read: is not a universal file, or damaged"
            raise InputError(source, "file", what) from None
    return found


def _name(one: Mapping[str, Any], source: str, place: str) -> tuple[str, float]:
    """Return the nodes and directions of a function, without negative ones, and its sign."""
    ends, sign = [], 1.0
    for end in ("rsp", "ref"):
        node, direction = one[f"{end}_node"], one[f"{end}_dir"]
        if abs(direction) >= len(DIRECTIONS):
            raise InputError(source, place, f"direction {direction}: there are -6 to 6")
        ends.append(f"{node}:{DIRECTIONS[abs(direction)]}")
        sign *= -1.0 if direction < 0 else 1.0
    return "/".join(ends), sign


def _numbers(one: Mapping[str, Any], source: str, place: str) -> tuple[Array, Array]:
    """Return frequencies in Hz and ordinates, as many as the head announces."""
    if one["abscissa_spec_data_type"] not in (0, GENERAL, FREQUENCY):
        raise InputError(source, place, "is not over frequency")
    unit = _label(one, "abscissa") or "Hz"
    if unit not in FREQUENCY_UNITS:
        raise InputError(source, place, f"frequencies in [{unit}]: export them in one of {', '.join(FREQUENCY_UNITS)}")
    f, data = np.asarray(one["x"], dtype=float) * FREQUENCY_UNITS[unit], np.asarray(one["data"])
    if not len(f) == len(data) == one["num_pts"]:
        what = f"{len(data)} values, {one['num_pts']} are announced: the file is damaged, export it again"
        raise InputError(source, place, what)
    return f, data


def _complex(data: Array, source: str, place: str) -> ComplexArray:
    if not np.iscomplexobj(data) and (data >= 0).all():
        raise InputError(source, place, "holds amplitudes without phase: export complex numbers")
    return data.astype(complex)


def _coherence(data: Array, source: str, place: str) -> Array:
    if np.iscomplexobj(data) or (reason := why_incoherent(data)):
        raise InputError(source, place, "complex numbers are no coherence" if np.iscomplexobj(data) else reason)
    return data.astype(float)


def _with_coherence(one: FileResponse, coherences: Mapping[str, tuple[Array, Array]], source: str) -> FileResponse:
    if one.name not in coherences:
        return one
    f, coherence = coherences[one.name]
    if not np.array_equal(f, one.f):
        raise InputError(source, one.place, f"coherence of {one.name} is at other frequencies: export both alike")
    return replace(one, coherence=coherence)


# Units


def _label(one: Mapping[str, Any], axis: str) -> str:
    """Return the label of the units of an axis, empty where there is none."""
    text = str(one.get(f"{axis}_axis_units_lab", "")).strip()
    return "" if text.upper() == "NONE" else text


def _unit(one: Mapping[str, Any], system: Mapping[str, Any] | None) -> tuple[str | None, float]:
    """Return the unit of a response, None where nothing is said, and the factor to it from that of the file."""
    above, below = _label(one, "ordinate"), _label(one, "orddenom")
    turns = [abs(one[f"{end}_dir"]) > 3 for end in ("rsp", "ref")]
    L, F = (1.0, 1.0) if system is None else (1 / system["length"], 1 / system["force"])
    length = LENGTHS.get(one["ordinate_spec_data_type"], "")
    usual = length.replace("m", "rad", 1) if turns[0] else length
    if above and not below and factor_to(usual, above) is None:
        return above, 1.0  # the label is that of the quotient
    scale = 1.0
    if not above:
        above, scale = usual, 1.0 if turns[0] else L
    if not below and one.get("orddenom_spec_data_type") in FORCES:
        below, scale = ("N m", scale / (F * L)) if turns[1] else ("N", scale / F)
    if above and below:
        return quotient_unit(above, below), scale
    return UNSAID if above or below or L * F != 1 else None, 1.0
