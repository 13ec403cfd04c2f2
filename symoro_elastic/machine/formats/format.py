"""The interface of a file format."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from symoro_elastic.machine.formats.files import UTF_8
from symoro_elastic.machine.machine import Machine


@dataclass(frozen=True)
class Format:
    """A text format of machine files: its name, the suffixes of its files, how to read and write them.

    The text of a file is in the first of `encodings` that it fits.
    `read(text, source)` gives the machine, not yet checked, and raises `InputError` that names `source`, the path of
    the file; `write(machine)` gives the text, and raises `InputError` for what the format cannot hold. Without
    `write` the format is read only.
    """

    title: str
    suffixes: tuple[str, ...]
    read: Callable[[str, str], Machine]
    write: Callable[[Machine], str] | None = None
    encodings: tuple[str, ...] = (UTF_8,)
