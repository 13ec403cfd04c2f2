"""Files that the program reads: plain ones, opened here and nowhere else.

A pipe would keep the program waiting for ever, and a device may have no end: neither is opened. Files are written by
`output_files`; `tests/architecture/test_files.py` holds that nothing goes around the two.
"""

from __future__ import annotations

import os
import stat
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO

from symoro_elastic.foundation.errors import InputError
from symoro_elastic.foundation.shipped import example_called

AT_ONCE = getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0)
"""Flags with which opening never waits, and with which no system changes line ends."""


def is_plain_file(path: str | Path) -> bool:
    """Return whether a path leads to a plain file; False too for names that no file can have."""
    try:
        return stat.S_ISREG(os.stat(path).st_mode)
    except (OSError, ValueError):
        return False


@contextmanager
def open_file(path: str | Path, place: str = "file") -> Iterator[BinaryIO]:
    """Open a plain file to read its bytes. Raises `InputError`, also where reading fails in the block."""
    try:
        with _opened(path, place) as stream:
            yield stream
    except OSError as error:
        raise InputError(str(path), place, f"cannot be read: {error.strerror or error}") from None


def read_file(path: str | Path, place: str = "file", most: int | None = None) -> bytes:
    """Return the bytes of a plain file, all or the first `most`. Raises `InputError`."""
    with open_file(path, place) as stream:
        return stream.read() if most is None else stream.read(most)


def size_of(stream: BinaryIO) -> int:
    """Return the size of an open file in bytes."""
    return os.fstat(stream.fileno()).st_size


def _opened(path: str | Path, place: str) -> BinaryIO:
    """Return a file opened without waiting; what is found is looked at again, as it may have changed since."""
    try:
        _refuse_special(os.stat(path), path, place)
        opened = os.open(path, os.O_RDONLY | AT_ONCE)
    except (FileNotFoundError, NotADirectoryError, ValueError):
        raise InputError(str(path), place, f"there is no such file{_example(Path(path).name)}") from None
    try:
        _refuse_special(os.fstat(opened), path, place)
        return os.fdopen(opened, "rb")
    except BaseException:
        os.close(opened)
        raise


def _example(name: str) -> str:
    """The end of a message about a file that is missing, where it has the name of an example."""
    known = example_called(name)
    return f"; an example is called so, which symoro-elastic new --example {known} writes" if known else ""


def _refuse_special(found: os.stat_result, path: str | Path, place: str) -> None:
    if not stat.S_ISREG(found.st_mode):
        raise InputError(str(path), place, f"is not a file: it is a {kind_of_file(found)}")


def kind_of_file(found: os.stat_result) -> str:
    """Return what a path leads to, in a word."""
    kinds = {stat.S_ISDIR: "folder", stat.S_ISFIFO: "pipe", stat.S_ISSOCK: "socket"}
    return next((name for holds, name in kinds.items() if holds(found.st_mode)), "device")
