"""Files for other programs: numpy (.npz), MATLAB (.mat, .m), python-control; frequency responses as .csv or .npz."""

from __future__ import annotations

import io
import re
from collections.abc import Callable, Mapping, Sequence
from itertools import chain, count
from pathlib import Path
from typing import Any

import numpy as np

from symoro_elastic.errors import InputError
from symoro_elastic.output_files import write_file
from symoro_elastic.packages import for_vibrations, imported
from symoro_elastic.time_series.writing import CSV, NPZ, write_columns
from symoro_elastic.vibration.energies import frame_shapes
from symoro_elastic.vibration.linearization import Linearization
from symoro_elastic.vibration.matlab_text import function_text, refuse_function_file
from symoro_elastic.vibration.modes import Modes
from symoro_elastic.vibration.responses import Response
from symoro_elastic.vibration.sensitivity import Sensitivity
from symoro_elastic.vibration.tracking import Tracked

MAT_TEXT = 116
"""Bytes of free text at the head of a .mat file, where a date would stand."""
MAT = ".mat"
M = ".m"
LINEARIZATION_FILES = (NPZ, MAT, M)
RESPONSE_FILES = (CSV, NPZ, MAT)


def arrays_of(linear: Linearization) -> dict[str, Any]:
    """Return mass, damping, stiffness, F, Cq, Cv, Ca; A, B, C, D of the state space; names, notes; the state.

    The state is q, qd, qdd, tau.
    """
    space, state = linear.space, linear.state
    return {
        "mass": linear.M, "damping": linear.D, "stiffness": linear.K,
        "F": linear.F, "Cq": linear.Cq, "Cv": linear.Cv, "Ca": linear.Ca,
        "A": space.A, "B": space.B, "C": space.C, "D": space.D,
        "states": list(space.states), "inputs": list(space.inputs), "outputs": list(space.outputs),
        "notes": list(linear.notes),
        "joints": list(linear.motion.names), "q": state.q, "qd": state.qd, "qdd": state.qdd, "tau": state.tau,
    }  # fmt: skip


def modes_arrays(modal: Modes, by: Sensitivity) -> dict[str, Any]:
    """Return frequencies, damping, poles, shapes of joints (n, m) and frames (frames, 6, m), sensitivities."""
    return {
        "frequencies": modal.frequencies, "eigenvalues": modal.eigenvalues, "damping_ratios": modal.damping_ratios,
        "poles": modal.poles, "shapes": modal.shapes, "coordinates": list(modal.linear.coordinates),
        "frame_shapes": frame_shapes(modal), "frames": [joint.name for joint in modal.linear.motion.machine.joints],
        "sensitivity": by.slopes, "parameters": list(by.parameters),
    }  # fmt: skip


def tracked_arrays(tracked: Tracked) -> dict[str, Any]:
    """Return positions (points, joints), frequencies, growth and MAC (points, m), shapes (points, n, m)."""
    return {
        "joints": list(tracked.joints), "positions": tracked.positions, "frequencies": tracked.frequencies,
        "growth": tracked.growth, "mac": tracked.mac, "shapes": np.array([each.shapes for each in tracked.modes]),
        "coordinates": list(tracked.modes[0].linear.coordinates),
    }  # fmt: skip


def save_linearization(linear: Linearization, path: str | Path) -> None:
    """Write `arrays_of` to a .npz or .mat file (names as cells of text), or as a MATLAB function to a .m file.

    Raises `InputError`.
    """
    refuse_linearization_file(path)
    if Path(path).suffix.lower() == M:
        write_file(function_text(arrays_of(linear), Path(path).stem, linear.headline).encode(), path)
    else:
        save_arrays(arrays_of(linear), path)


def save_response(response: Response, path: str | Path) -> None:
    """Write a frequency response to .csv (Hz, real and imaginary part of each), .npz or .mat. Raises `InputError`."""
    if Path(path).suffix.lower() != CSV:
        arrays = {"frequencies": response.frequencies, "G": response.values}
        save_arrays({**arrays, "inputs": list(response.inputs), "outputs": list(response.outputs)}, path)
        return
    columns = {"f [Hz]": response.frequencies}
    for i, output in enumerate(response.outputs):
        for j, name in enumerate(response.inputs):
            G = response.values[:, i, j]
            columns |= {f"re {output} / {name}": G.real, f"im {output} / {name}": G.imag}
    write_columns(columns, path)


def refuse_file(path: str | Path, forms: tuple[str, ...] = (NPZ, MAT)) -> None:
    """Raise `InputError` for a file name whose ending is none of `forms`."""
    if Path(path).suffix.lower() not in forms:
        raise InputError(str(path), "--out", f"no form {Path(path).suffix!r}: end the name with {' or '.join(forms)}")


def refuse_linearization_file(path: str | Path) -> None:
    """Raise `InputError` for a file name whose ending or, of a function, whose stem is not possible."""
    refuse_file(path, LINEARIZATION_FILES)
    if Path(path).suffix.lower() == M:
        refuse_function_file(path)


def save_arrays(arrays: Mapping[str, Any], path: str | Path) -> None:
    """Write arrays and lists of texts to .npz or .mat, the same bytes for the same numbers. Raises `InputError`."""
    refuse_file(path)
    forms: dict[str, Callable[[Mapping[str, Any]], bytes]] = {NPZ: _npz, MAT: _mat}
    write_file(forms[Path(path).suffix.lower()](arrays), path)


def control_system(linear: Linearization) -> Any:
    """Return the linearization as a `control.StateSpace` with the names of `labels`, as `motor_x_tau`.

    Raises `InputError` without python-control.
    """
    space = linear.space
    states, ins, outs = map(labels, (space.states, space.inputs, space.outputs))
    package = imported("control", "a system for python-control", "control")
    return package.ss(space.A, space.B, space.C, space.D, states=states, inputs=ins, outputs=outs)


def labels(names: Sequence[str]) -> list[str]:
    """Return distinct names of letters, digits and `_`: `tool at (-0.1, 0, 0).x` is `tool_at_minus_0p1_0_0_x`.

    Those that would still be alike are numbered.
    """
    unique: list[str] = []
    for name in names:
        spelled = re.sub(r"(?<=\d)\.(?=\d)", "p", re.sub(r"(?<!\w)-", "minus ", name))
        label = re.sub(r"\W+", "_", spelled)
        numbered = (f"{label}_{k}" for k in count(2))
        unique.append(next(each for each in chain([label], numbered) if each not in unique))
    return unique


def _npz(arrays: Mapping[str, Any]) -> bytes:
    stream = io.BytesIO()
    np.savez(stream, **{name: np.asarray(x) for name, x in arrays.items()})  # type: ignore[arg-type]
    return stream.getvalue()


def _mat(arrays: Mapping[str, Any]) -> bytes:
    stream = io.BytesIO()
    cells = {name: np.array(x, dtype=object) if isinstance(x, list) else x for name, x in arrays.items()}
    for_vibrations("scipy.io").savemat(stream, cells)
    head = "; ".join(["MATLAB 5.0 MAT-file", *arrays.get("notes", ())]).encode("ascii", "replace")
    return head[:MAT_TEXT].ljust(MAT_TEXT) + stream.getvalue()[MAT_TEXT:]
