"""Reading and writing of machine files in the format of their suffix."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from symoro_elastic.errors import InputError
from symoro_elastic.machine.checks import check
from symoro_elastic.machine.formats import par, toml
from symoro_elastic.machine.formats.files import load_text
from symoro_elastic.machine.formats.format import Format
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.names import NONE, Reasons
from symoro_elastic.machine.resolve import Models
from symoro_elastic.output_files import write_text

FORMATS: tuple[Format, ...] = (toml.FORMAT, par.FORMAT)
"""Every format; a new one is a module and its line here."""


def read_machine(path: str | Path, taken: Reasons = NONE, models: Models | None = None) -> tuple[Machine, list[str]]:
    """The machine in a file, checked as by `check`, and warnings, a line each; raises `InputError`."""
    machine = read(path)
    return machine, check(machine, taken, models)


def read(path: str | Path) -> Machine:
    """The machine in a file, not yet checked by `check`; raises `InputError`."""
    form = format_of(path, FORMATS)
    return form.read(load_text(path, form.encodings), str(path))


def write_machine(machine: Machine, path: str | Path) -> None:
    """Write the machine in the format of the suffix; raises `InputError`."""
    form = refuse_unwritable(path)
    assert form.write
    write_text(form.write(machine), path)


def refuse_unwritable(path: str | Path) -> Format:
    """Return the format of a file that machines can be written to; raises `InputError` for others."""
    form = format_of(path, FORMATS)
    if form.write is None:
        writable = _suffixes(form for form in FORMATS if form.write)
        raise InputError(str(path), "file", f"{form.title} files can be read, but not written: use {writable}")
    return form


def format_of(path: str | Path, formats: Iterable[Format]) -> Format:
    """The format with the suffix of a file; raises `InputError` for an unknown suffix."""
    suffix = Path(path).suffix.lower()
    for form in formats:
        if suffix in form.suffixes:
            return form
    what = f"the suffix {suffix!r} is no machine format: use {_suffixes(formats)}"
    raise InputError(str(path), "file", what)


def _suffixes(formats: Iterable[Format]) -> str:
    return " or ".join(suffix for form in formats for suffix in form.suffixes)
