"""The table [flexible] of a machine file: bodies that bend by modes, from a file of modes or as integrals."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from symoro_elastic.formats.modes_file import Interface, ModalBody, load
from symoro_elastic.formats.toml import key as keys
from symoro_elastic.formats.toml.flexible.modal_rows import MOVES, ROOT, Follower, Guideway, ModalRows, Rows
from symoro_elastic.formats.toml.key import Key, Section, Type
from symoro_elastic.formats.toml.tables import Number, Table
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.machine.flexible import FlexibleBody, without_rounding
from symoro_elastic.machine.names import no_such

HEADING = "flexible"
SHAPES = {"Ct0": "m3", "Ct1": "mm3", "T0": "m33", "T1": "mm33", "Mee": "mm"}
"""Sizes of the integrals, m being the number of modes."""


def _numbers(table: Table, key: str) -> Array:
    """An array of numbers as written."""
    try:
        return np.array(_floats(table.entries[key]), dtype=float)
    except (TypeError, ValueError):
        raise table.fail(key, "must be lists of numbers, all of equal length") from None


def _floats(value: Any) -> Any:
    if isinstance(value, list):
        return [*map(_floats, value)]
    if isinstance(value, bool) or not isinstance(value, int | Number):
        raise TypeError
    return float(value)


ARRAY = Type("lists of numbers", {"type": "array"}, _numbers)
FILE = Key(
    *("file", keys.TEXT, "file of modes, as `symoro-elastic flexible` writes, beside the machine's file"),
    '"bed.npz"',
    otherwise="modes and their integrals",
)
KEEP = Key(
    *("keep", keys.NUMBER, "highest frequency of the modes that are kept, with the joint held"),
    '"800 Hz"',
    otherwise="all modes of the file",
    unit="Hz",
)
DAMPING = Key(
    *("damping", keys.NUMBER, "damping ratio of every mode, with the joint held", "0.02"), otherwise="that of the file"
)
STIFFENING = Key(
    *("stiffening", keys.TRUTH, "whether tension stiffens the body of a file from a mesh, and pressure weakens it"),
    "true",
    default=False,
)
MODES = Key(
    *("modes", keys.TEXTS, "elastic rows on the body that are its modes, in place of a file", '["bed_e1", "bed_e2"]'),
    otherwise="those of the file",
)
INTEGRALS = tuple(
    Key(name, ARRAY, meaning, "[[0.1, 0, 0]]", otherwise="with modes")
    for name, meaning in {
        "Ct0": "integrals over the mass of the modes phi_k, a list for each mode",
        "Ct1": "of their foreshortening s_kl",
        "T0": "of x phi_k^T",
        "T1": "of phi_l phi_k^T + x s_kl^T",
        "Mee": "of phi_k . phi_l",
    }.items()
)
FLEXIBLE = Section(
    f"[{HEADING}]",
    "Bodies that bend, by the joint whose frame holds them: a file becomes rows NAME_e1, NAME_e2 ... of kind elastic, "
    "and a row NAME_INTERFACE for each interface of the file, which carries what names it as antecedent.",
    (FILE, KEEP, DAMPING, STIFFENING, MODES, *INTEGRALS),
    "joint",
)


def bodies_of_files(top: Table) -> dict[str, ModalBody]:
    """Read the modal bodies that entries load from files, by joint; raises `InputError`."""
    table = top.table(HEADING)
    rows = [row.text("name") for row in top.tables("joints")] if table.entries else []
    bodies = {}
    for name in table.entries:
        entry = table.table(name).only(FLEXIBLE.names)
        if name not in rows:
            raise top.fail(HEADING, no_such("joint", name, rows))
        if FILE.name in entry.entries:
            for key in (MODES, *INTEGRALS):
                if key.name in entry.entries:
                    raise entry.fail(key.name, "follows from the file: remove one of the two")
            if name in top.table("bodies").entries:
                raise entry.fail(FILE.name, "has mass and inertia: leave the joint out of [bodies]")
            bodies[name] = _chosen(entry, load(Path(top.source).parent / FILE.read(entry)))
    return bodies


def _chosen(entry: Table, body: ModalBody) -> ModalBody:
    """The body with the modes and the damping that its entry selects."""
    if not STIFFENING.read(entry):
        body = body.without_foreshortening
    elif body.Ct1 is None:
        what = "the file has no foreshortening, which needs stresses: make it from a mesh, not from matrices"
        raise entry.fail(STIFFENING.name, what)
    if KEEP.name in entry.entries:
        is_low = body.frequencies <= KEEP.read(entry)
        if not is_low.any():
            raise entry.fail(KEEP.name, f"is below all modes: the first has {body.frequencies.min():.4g} Hz")
        body = body.keep(is_low)
    if DAMPING.name in entry.entries:
        if (ratio := DAMPING.read(entry)) < 0:
            raise entry.fail(DAMPING.name, f"{ratio:g} must not be negative")
        body = replace(body, damping=2 * ratio * np.sqrt(body.stiffness * np.diag(body.masses)))
    return body


def rows_of_body(name: str, body: ModalBody) -> Rows:
    """Rows of a modal body, below the row that carries it."""
    followers = [
        Follower(f"{name}_{key}", x.point, x.shift, x.turn, np.eye(3), _shorter(x))
        for key, x in body.interfaces.items()
    ]
    sigmas = [1] * body.count
    return ModalRows(
        name, labels(name, body), sigmas, body.stiffness.tolist(), body.damping.tolist(), body.rigid, followers
    ).rows({})


def along_rail(name: str, key: str, body: ModalBody) -> Guideway:
    """Guideway along a rail of a modal body."""
    rail = body.rails[key]
    turned = {"shift": rail.shift @ rail.axes, "turn": rail.turn @ rail.axes}
    moves = {(what, k): turned[what][:, :, k].T.tolist() for what, k in MOVES}
    stiffened, names = body.Ct1 is not None, labels(name, body)
    return Guideway(name + ROOT, names, moves, rail.length, rail.point, rail.axes, np.eye(3), stiffened)


def _shorter(interface: Interface) -> list[tuple[str, int, Array]]:
    """Foreshortening of an interface along -x, -y, -z, as quadratic terms by axis."""
    if interface.shorter is None:
        return []
    against = without_rounding(-interface.shorter)
    return [("shorter", axis, against[:, :, axis]) for axis in range(3)]


def labels(name: str, body: ModalBody) -> list[str]:
    """Names of the rows of a body's modes."""
    return [f"{name}_e{k + 1}" for k in range(body.count)]


def body_of_file(name: str, body: ModalBody) -> FlexibleBody:
    """Flexible body for the rows of a modal body read from a file."""
    return FlexibleBody.of(name + ROOT, labels(name, body), body.integrals, body.surface)


def written_bodies(top: Table) -> Iterator[FlexibleBody]:
    """Read the flexible bodies that entries define by integrals; raises `InputError`."""
    table = top.table(HEADING)
    rows = [row.text("name") for row in top.tables("joints")] if table.entries else []
    for name in table.entries:
        entry = table.table(name)
        if FILE.name in entry.entries:
            continue
        for key in (MODES, *INTEGRALS):
            if key.name not in entry.entries:
                raise entry.fail(key.name, "is missing: give a file, or modes and their integrals")
        for key in (KEEP, DAMPING, STIFFENING):
            if key.name in entry.entries:
                raise entry.fail(key.name, "belongs to a file of modes: leave it out, or give a file")
        modes = MODES.read(entry)
        for mode in modes:
            if mode not in rows:
                raise entry.fail(MODES.name, no_such("joint", mode, rows))
        yield FlexibleBody.of(name, modes, {key.name: _of_shape(entry, key, len(modes)) for key in INTEGRALS})


def _of_shape(entry: Table, key: Key, m: int) -> Array:
    array: Array = key.read(entry)
    shape = tuple(m if size == "m" else int(size) for size in SHAPES[key.name])
    if array.shape != shape or not np.isfinite(array).all():
        raise entry.fail(key.name, f"must be numbers of the shape {shape}, is {array.shape}")
    return array


def entry_of_body(body: FlexibleBody) -> list[tuple[str, str]]:
    """Entries of a flexible body as TOML texts."""
    modes = ", ".join(f'"{name}"' for name in body.modes)
    return [(MODES.name, f"[{modes}]"), *((key, _written(getattr(body, key))) for key in SHAPES)]


def _written(value: Any) -> str:
    return f"[{', '.join(map(_written, value))}]" if isinstance(value, tuple) else repr(float(value))
