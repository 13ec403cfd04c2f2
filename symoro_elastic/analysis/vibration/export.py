"""Files for other programs: numpy (.npz), MATLAB (.mat, .m), python-control; frequency responses as .csv or .npz."""

from __future__ import annotations

import io
import re
from collections.abc import Mapping, Sequence
from itertools import chain, count
from pathlib import Path
from typing import Any

import numpy as np

from symoro_elastic.analysis.time_series.writing import CSV, NPZ, write_columns
from symoro_elastic.analysis.vibration.linearization import Linearization
from symoro_elastic.analysis.vibration.responses import Response
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.foundation.file_forms import LINEARIZATIONS, MODES, form_of
from symoro_elastic.foundation.output_files import write_file
from symoro_elastic.foundation.packages import for_vibrations

WIDTH = 110
_FUNCTION = re.compile(r"[A-Za-z]\w{0,62}", re.ASCII)
HEAD = """\
function found = {name}(what)
%{upper}  {headline}.
%
%   sys = {name}() returns the state space as an object of ss, with names of states, inputs and outputs. It needs
%   the Control System Toolbox of MATLAB, or the package control of GNU Octave.
%   linear = {name}('matrices') returns a structure and needs neither: A, B, C, D of the state space; mass, damping,
%   stiffness, F, Cq, Cv, Ca of mass*ddq + damping*dqd + stiffness*dq = F*du, dy = Cq*dq + Cv*dqd + Ca*ddq; names of
%   states, inputs, outputs; the state q, qd, qdd of joints, and tau. SI units, radians.
{notes}

"""
TAIL = """
    if nargin > 0 && strcmp(what, 'matrices')
        found = linear;
        return
    elseif nargin > 0
        error('{name}:what', '{name} takes ''matrices'' or nothing');
    elseif isempty(which('ss'))
        what = 'ss is missing: install the Control System Toolbox, or in Octave the package control and pkg load it';
        error('{name}:ss', '%s; {name}(''matrices'') needs neither', what);
    end
    found = ss(linear.A, linear.B, linear.C, linear.D);
    found.StateName = linear.states;
    found.InputName = linear.inputs;
    found.OutputName = linear.outputs;
end
"""

MAT_TEXT = 116
"""Bytes of free text at the head of a .mat file, where a date would stand."""
M = ".m"


def save_linearization(linear: Linearization, path: str | Path) -> None:
    """Write the arrays of a linearization to .npz or .mat (names as cells of text), or as a MATLAB function to .m.

    Raises `InputError`.
    """
    if refuse_linearization_file(path) == M:
        write_file(function_text(linear.arrays(), Path(path).stem, linear.headline).encode(), path)
    else:
        save_arrays(linear.arrays(), path)


def save_response(response: Response, path: str | Path) -> None:
    """Write a frequency response to .csv (Hz, real and imaginary part of each), .npz or .mat. Raises `InputError`."""
    if Path(path).suffix.lower() != CSV:
        save_arrays(response.arrays(), path)
        return
    columns = {"f [Hz]": response.frequencies}
    for i, output in enumerate(response.outputs):
        for j, name in enumerate(response.inputs):
            G = response.values[:, i, j]
            columns |= {f"re {output} / {name}": G.real, f"im {output} / {name}": G.imag}
    write_columns(columns, path)


def refuse_linearization_file(path: str | Path) -> str:
    """Return the suffix; raise `InputError` for an unsupported one, and for a stem that is no function name."""
    suffix = form_of(path, LINEARIZATIONS, "--out")
    if suffix == M and not _FUNCTION.fullmatch(Path(path).stem):
        what = "MATLAB names the function by the file: use a letter, then letters, digits and underscores"
        raise InputError(str(path), "--out", what)
    return suffix


def save_arrays(arrays: Mapping[str, Any], path: str | Path) -> None:
    """Write arrays and lists of texts to .npz or .mat, the same bytes for the same numbers. Raises `InputError`."""
    stream = io.BytesIO()
    if form_of(path, MODES, "--out") == NPZ:
        np.savez(stream, **{name: np.asarray(x) for name, x in arrays.items()})  # type: ignore[arg-type]
        write_file(stream.getvalue(), path)
        return
    cells = {name: np.array(x, dtype=object) if isinstance(x, list) else x for name, x in arrays.items()}
    for_vibrations("scipy.io").savemat(stream, cells)
    head = "; ".join(["MATLAB 5.0 MAT-file", *arrays.get("notes", ())]).encode("ascii", "replace")
    write_file(head[:MAT_TEXT].ljust(MAT_TEXT) + stream.getvalue()[MAT_TEXT:], path)


def labels(names: Sequence[str]) -> list[str]:
    """Return distinct names of letters, digits and `_`: `tool at (-0.1, 0, 0).x` is `tool_at_minus_0p1_0_0_x`.

    Equal ones are numbered.
    """
    unique: list[str] = []
    for name in names:
        spelled = re.sub(r"(?<=\d)\.(?=\d)", "p", re.sub(r"(?<!\w)-", "minus ", name))
        label = re.sub(r"\W+", "_", spelled)
        numbered = (f"{label}_{k}" for k in count(2))
        unique.append(next(candidate for candidate in chain([label], numbered) if candidate not in unique))
    return unique


# A linearization as the text of a function for MATLAB and GNU Octave.
def function_text(arrays: Mapping[str, Any], name: str, headline: str) -> str:
    """Return the text of a function of this name that holds arrays and lists of texts."""
    notes = "\n".join(f"%   {note}." for note in arrays["notes"])
    head = HEAD.format(name=name, upper=name.upper(), headline=headline, notes=notes or "%")
    fields = [f"    linear.{key} = {_value(value)};\n" for key, value in arrays.items() if key != "notes"]
    return "".join([head, *fields, TAIL.format(name=name)])


def _value(value: Any) -> str:
    if isinstance(value, list):
        return "{" + _fill(["'" + text.replace("'", "''") + "'" for text in value], ", ") + "}"
    if not value.size:
        return f"zeros({', '.join(map(str, (*value.shape, 1)[:2]))})"
    if value.ndim == 1:
        return "[" + _fill(list(map(_number, value)), "; ") + "]"
    return "[" + ";\n        ".join(_fill(list(map(_number, row)), " ") for row in value) + "]"


def _fill(items: Sequence[str], between: str) -> str:
    """Join items to lines of limited width, indented after the first."""
    lines = [""]
    for item in items:
        if lines[-1] and len(lines[-1]) + len(item) > WIDTH:
            lines.append("")
        lines[-1] += item + between
    return " ...\n            ".join(line.rstrip() for line in lines).removesuffix(between.rstrip())


def _number(x: float) -> str:
    return repr(float(x) + 0.0).removesuffix(".0")
