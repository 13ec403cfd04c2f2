"""Frequency responses and modes from universal files (.uff, .unv): data sets 58 and 55, read by the package pyuff.

The format has six digits for frequencies; responses have twelve, or six in single precision.
"""

from __future__ import annotations

import re
import warnings
from collections import Counter
from collections.abc import Mapping
from dataclasses import replace
from enum import IntEnum
from pathlib import Path
from typing import Any

import numpy as np

from symoro_elastic.analysis.vibration.responses import quotient_unit
from symoro_elastic.foundation.array_types import AnyArray, Array, ComplexArray
from symoro_elastic.foundation.errors import TWICE, InputError
from symoro_elastic.foundation.input_files import open_file, size_of
from symoro_elastic.foundation.packages import import_optional
from symoro_elastic.measured.vibration_tests.signal_names import FileResponse
from symoro_elastic.measured.vibration_tests.tables import why_incoherent
from symoro_elastic.quantities.unit_reader import UnitError, conversion, is_unit, spelled_label

SUFFIXES = (".uff", ".unv")
MOST_BYTES = 200_000_000
RESPONSE, COHERENCE = "frequency response", "coherence"
KINDS = {
    0: "general function", 1: "time record", 2: "auto spectrum", 3: "cross spectrum", 4: RESPONSE,
    5: "transmissibility", 6: COHERENCE, 7: "auto correlation", 8: "cross correlation", 9: "power spectral density",
    12: "spectrum",
}  # fmt: skip
"""Names of functions of data sets 58, by their types."""
MODES = {2: "normal mode", 3: "complex mode", 7: "complex mode"}
"""Types of analysis of data sets 55 that are modes."""
AXES = ("+X", "+Y", "+Z", "+RX", "+RY", "+RZ")
DIRECTIONS = ("S", "+X", "+Y", "+Z", "+RX", "+RY", "+RZ")  # by number; -1 is -X, and so on
OVER_FREQUENCY = (0, 1, 18)  # specific data types of abscissas: unknown, general, frequency
LINE = 5  # values that a line of a data set may have behind its last one: the rest of it is zeros
UNSAID, LOST = "not said", "\ufffd"
LENGTHS, FORCES = {8: "m", 11: "m/s", 12: "m/s2"}, (9, 13)
"""Specific data types: displacement, velocity, acceleration; reaction and excitation force."""


class DataSet(IntEnum):
    """Types of data sets."""

    FUNCTION = 58
    NODES = 55
    UNITS = 164


def read_universal_file(path: Path) -> list[FileResponse]:
    """Return the frequency responses of a universal file, named `3:+Z/1:+X` by nodes and directions.

    Responses in negative directions are turned. Units are those of its labels, else of its data set 164, else SI.
    Raises `InputError` for files that are damaged or hold no responses, and for responses that are there twice.
    """
    source, sets = str(path), _sets(path)
    system = next((data_set for kind, data_set in sets if kind == DataSet.UNITS), None)
    responses: dict[str, FileResponse] = {}
    coherences: dict[str, tuple[Array, Array]] = {}
    for k, data_set in enumerate((data_set for kind, data_set in sets if kind == DataSet.FUNCTION), start=1):
        place = f"function {k}"
        kind = KINDS.get(data_set["func_type"])
        if kind not in (RESPONSE, COHERENCE):
            continue
        name, sign = _name(data_set, source, place)
        if name in (responses if kind == RESPONSE else coherences):
            raise InputError(source, place, f"{name} {TWICE}")
        f, data = _numbers(data_set, source, place)
        if kind == COHERENCE:
            coherences[name] = f, _coherence(data, source, place)
        else:
            unit, scale = _unit(data_set, system)
            with np.errstate(invalid="ignore"):  # frequencies without a number are left out
                H = sign * _complex(data, source, place)
            responses[name] = FileResponse(name, unit, f, H, None, place, scale)
    return [_with_coherence(response, coherences, source) for response in responses.values()]


def modes_of_universal_file(path: Path) -> dict[str, AnyArray]:
    """Return `frequency` (Hz), `damping_ratio` and shapes of the modes of a universal file, by names such as `3:+Z`.

    A damping ratio that is zero is not known. Raises `InputError` for data sets 55 of different nodes.
    """
    modes = [nodes for kind, nodes in _sets(path) if kind == DataSet.NODES]
    modes = [mode for mode in modes if mode["analysis_type"] in MODES]
    if not modes:
        return {}
    poles = [_pole(mode) for mode in modes]
    columns: dict[str, AnyArray] = {"frequency": np.array([f for f, _ in poles])}
    if any(zeta for _, zeta in poles):
        columns["damping_ratio"] = np.array([zeta or np.nan for _, zeta in poles])
    if any(not np.array_equal(mode["node_nums"], modes[0]["node_nums"]) for mode in modes):
        raise InputError(str(path), "data sets 55", "modes are at different nodes: export all modes at the same ones")
    for k, node in enumerate(modes[0]["node_nums"]):
        axes = {axis: f"r{n}" for n, axis in enumerate(AXES, start=1) if f"r{n}" in modes[0]}
        columns |= {f"{int(node)}:{axis}": np.array([mode[r][k] for mode in modes]) for axis, r in axes.items()}
    order = np.argsort(columns["frequency"], kind="stable")
    return {name: x[order] for name, x in columns.items()}


def _pole(mode: Mapping[str, Any]) -> tuple[float, float]:
    """Return natural frequency, Hz, and damping ratio of a mode."""
    if MODES[mode["analysis_type"]] == "normal mode":
        return float(mode["freq"]), float(mode["modal_damp_vis"])
    size = abs(mode["eig"])
    return size / (2 * np.pi), -mode["eig"].real / size if size else 0.0


def contents_of(path: Path) -> str:
    """Return what a universal file holds, in words: `4 time records, data sets 15, 151`."""
    counts = Counter(
        KINDS.get(data_set["func_type"], "function") for kind, data_set in _sets(path) if kind == DataSet.FUNCTION
    )
    kinds = sorted(set(_reader(path).get_set_types()) - {DataSet.FUNCTION})
    functions = [f"{n} {name}{'s' if n > 1 else ''}" for name, n in counts.items()]
    return ", ".join([*functions, *([f"data sets {', '.join(str(int(x)) for x in kinds)}"] if kinds else [])])


def _sets(path: Path) -> list[tuple[int, Mapping[str, Any]]]:
    """Return the data sets of functions, of modes and of units, with their types."""
    source = str(path)
    with open_file(path) as file:
        if size_of(file) > MOST_BYTES:
            raise InputError(source, "file", f"larger than {MOST_BYTES // 10**6} MB: cut it")
        content = file.read()
    sets: list[tuple[int, Mapping[str, Any]]] = []
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            reader = _reader(path)
            for k, kind in enumerate(map(int, reader.get_set_types())):
                if kind in [*DataSet]:
                    sets.append((kind, _with_labels(reader.read_sets(k), content)))
        except Exception:  # of any kind: pyuff assumes complete files
            what = f"data set {len(sets) + 1} cannot be read: is not a universal file, or damaged"
            raise InputError(source, "file", what) from None
    return sets


def _reader(path: Path) -> Any:
    return import_optional("pyuff", "reading universal files", "uff").UFF(str(path))


def _with_labels(data_set: dict[str, Any], content: bytes) -> dict[str, Any]:
    """Return a data set whose labels have the signs of Latin-1 that pyuff reads as damaged UTF-8: `m/s\xb2`."""
    for key, text in data_set.items():
        if key.endswith("_lab") and LOST in text:
            pattern = re.escape(text.encode()).replace(re.escape(LOST.encode()), rb"[\x80-\xff]")
            if len(signs := set(re.findall(pattern, content))) == 1:
                data_set[key] = signs.pop().decode("latin-1")
    return data_set


def _name(data_set: Mapping[str, Any], source: str, place: str) -> tuple[str, float]:
    """Return the nodes and directions of a function, without negative ones, and its sign."""
    ends, sign = [], 1.0
    for end in ("rsp", "ref"):
        node, direction = data_set[f"{end}_node"], data_set[f"{end}_dir"]
        if abs(direction) >= len(DIRECTIONS):
            raise InputError(source, place, f"direction {direction}: there are -6 to 6")
        ends.append(f"{node}:{DIRECTIONS[abs(direction)]}")
        sign *= -1.0 if direction < 0 else 1.0
    return "/".join(ends), sign


def _numbers(data_set: Mapping[str, Any], source: str, place: str) -> tuple[Array, Array]:
    """Return frequencies in Hz and ordinates, as many as the head announces."""
    if data_set["abscissa_spec_data_type"] not in OVER_FREQUENCY:
        raise InputError(source, place, "is not over frequency")
    unit = _label(data_set, "abscissa")
    try:
        factor = conversion(unit, "Hz").number if unit else 1.0
    except UnitError as error:
        raise InputError(source, place, f"frequencies: {error}") from None
    count = data_set["num_pts"]
    f, data = np.asarray(data_set["x"], dtype=float)[:count] * factor, np.asarray(data_set["data"])
    if len(data) < count or len(f) < count or len(data) > count + LINE or data[count:].any():
        what = f"{len(data)} values, {count} are announced: the file is damaged, export it again"
        raise InputError(source, place, what)
    return f, data[:count]


def _complex(data: Array, source: str, place: str) -> ComplexArray:
    if not np.iscomplexobj(data) and (data >= 0).all():
        raise InputError(source, place, "holds amplitudes without phase: export complex numbers")
    return data.astype(complex)


def _coherence(data: Array, source: str, place: str) -> Array:
    if np.iscomplexobj(data) or (reason := why_incoherent(data)):
        raise InputError(source, place, "a coherence is real" if np.iscomplexobj(data) else reason)
    return data.astype(float)


def _with_coherence(response: FileResponse, coherences: Mapping[str, tuple[Array, Array]], source: str) -> FileResponse:
    if response.name not in coherences:
        return response
    f, coherence = coherences[response.name]
    if not np.array_equal(f, response.f):
        what = f"coherence of {response.name} is at other frequencies: export both at the same ones"
        raise InputError(source, response.place, what)
    return replace(response, coherence=coherence)


# Units


def _label(data_set: Mapping[str, Any], axis: str) -> str:
    """Return the label of the units of an axis, empty where there is none."""
    text = str(data_set.get(f"{axis}_axis_units_lab", "")).strip()
    if not text or text.upper() == "NONE":
        return ""
    try:
        return spelled_label(text)
    except UnitError:
        return f"{text}?" if is_unit(text) else text


def _unit(data_set: Mapping[str, Any], system: Mapping[str, Any] | None) -> tuple[str | None, float]:
    """Return the unit of a response, None without a unit, and the factor to it from that of the file."""
    above, below = _label(data_set, "ordinate"), _label(data_set, "orddenom")
    turns = [abs(data_set[f"{end}_dir"]) > 3 for end in ("rsp", "ref")]
    L, F = (1.0, 1.0) if system is None else (1 / system["length"], 1 / system["force"])
    length = LENGTHS.get(data_set["ordinate_spec_data_type"], "")
    usual = length.replace("m", "rad", 1) if turns[0] else length
    if above and not below and not is_unit(above, usual):
        return above, 1.0  # the label is that of the quotient
    scale = 1.0
    if not above:
        above, scale = usual, 1.0 if turns[0] else L
    if not below and data_set.get("orddenom_spec_data_type") in FORCES:
        below, scale = ("N m", scale / (F * L)) if turns[1] else ("N", scale / F)
    if above and below:
        return quotient_unit(above, below), scale
    return UNSAID if above or below or L * F != 1 else None, 1.0
