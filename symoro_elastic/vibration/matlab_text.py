"""A linearization as the text of a function for MATLAB and GNU Octave."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from symoro_elastic.errors import InputError

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


def refuse_function_file(path: str | Path) -> None:
    """Raise `InputError` for a file of a function whose name is none."""
    if not _FUNCTION.fullmatch(Path(path).stem):
        what = "MATLAB calls the function as the file: name it by a letter, then letters, digits and underscores"
        raise InputError(str(path), "--out", what)


def function_text(arrays: Mapping[str, Any], name: str, headline: str) -> str:
    """Return the text of a function of this name that holds arrays and lists of texts."""
    notes = "\n".join(f"%   {note}." for note in arrays["notes"])
    head = HEAD.format(name=name, upper=name.upper(), headline=headline, notes=notes or "%")
    fields = [f"    linear.{key} = {_value(value)};\n" for key, value in arrays.items() if key != "notes"]
    return "".join([head, *fields, TAIL.format(name=name)])


def _value(value: Any) -> str:
    if isinstance(value, list):
        return "{" + _filled(["'" + text.replace("'", "''") + "'" for text in value], ", ") + "}"
    if not value.size:
        return f"zeros({', '.join(map(str, (*value.shape, 1)[:2]))})"
    if value.ndim == 1:
        return "[" + _filled(list(map(_number, value)), "; ") + "]"
    return "[" + ";\n        ".join(_filled(list(map(_number, row)), " ") for row in value) + "]"


def _filled(items: Sequence[str], between: str) -> str:
    """Items in lines, those after the first indented."""
    lines = [""]
    for item in items:
        if lines[-1] and len(lines[-1]) + len(item) > WIDTH:
            lines.append("")
        lines[-1] += item + between
    return " ...\n            ".join(line.rstrip() for line in lines).removesuffix(between.rstrip())


def _number(x: float) -> str:
    return repr(float(x) + 0.0).removesuffix(".0")
