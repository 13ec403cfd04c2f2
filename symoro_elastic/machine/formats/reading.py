"""A machine from a file, to a file; the suffix tells the format."""

from __future__ import annotations

from collections.abc import Collection
from pathlib import Path
from types import ModuleType

from symoro_elastic.errors import InputError
from symoro_elastic.machine.checks import check
from symoro_elastic.machine.formats import par, toml
from symoro_elastic.machine.formats.files import load_text, save_text
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.resolve import Models

FORMATS: dict[str, ModuleType] = {".toml": toml, ".par": par}


def read_machine(
    path: str | Path, taken: Collection[str] = (), models: Models | None = None
) -> tuple[Machine, list[str]]:
    """The machine in a file, checked as by `check`, and warnings, a line each; raises `InputError`."""
    machine: Machine = _format(path).read(load_text(path), str(path))
    return machine, check(machine, taken, models)


def write_machine(machine: Machine, path: str | Path) -> None:
    """Write the machine in the format of the suffix; raises `InputError`."""
    save_text(_format(path).write(machine), path)


def _format(path: str | Path) -> ModuleType:
    suffix = Path(path).suffix.lower()
    if suffix not in FORMATS:
        what = f"the suffix {suffix!r} is no machine format: use {' or '.join(FORMATS)}"
        raise InputError(str(path), "file", what)
    return FORMATS[suffix]
