"""Input files: regular ones, opened in this module only.

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

AT_ONCE = getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0)
"""Flags with which opening never waits, and with which no system changes line ends."""
NO_LINK = getattr(os, "O_NOFOLLOW", 0)
"""Flag with which a link is not opened."""
PACKAGE = Path(__file__).resolve().parents[1]
EXAMPLES, SCENES = "examples", "scenes"
SUFFIXES = (".toml", ".par", ".urdf", ".xml")
"""Of examples, in the order in which a name without suffix is looked for."""


def is_plain_file(path: str | Path) -> bool:
    """Return whether a path leads to a regular file; False for names that are impossible."""
    try:
        return stat.S_ISREG(os.stat(path).st_mode)
    except (OSError, ValueError):
        return False


@contextmanager
def open_file(path: str | Path, place: str = "file", follow: bool = True) -> Iterator[BinaryIO]:
    """Open a regular file to read its bytes; links are followed, or never.

    Raises `InputError`, also where reading fails in the block.
    """
    try:
        with _open(path, place, follow) as stream:
            yield stream
    except OSError as error:
        raise InputError(str(path), place, f"cannot be read: {error.strerror or error}") from None


def read_file(path: str | Path, place: str = "file", most: int | None = None, follow: bool = True) -> bytes:
    """Return the bytes of a regular file, all or the first `most`; links followed, or never. Raises `InputError`."""
    with open_file(path, place, follow) as stream:
        return stream.read() if most is None else stream.read(most)


def size_of(stream: BinaryIO) -> int:
    """Return the size of an open file in bytes."""
    return os.fstat(stream.fileno()).st_size


def _open(path: str | Path, place: str, follow: bool) -> BinaryIO:
    """Return a file opened without blocking; its type is checked again, since it may have changed."""
    try:
        _refuse_special(os.stat(path, follow_symlinks=follow), path, place)
        opened = os.open(path, os.O_RDONLY | AT_ONCE | (0 if follow else NO_LINK))
    except (FileNotFoundError, NotADirectoryError, ValueError):
        raise InputError(str(path), place, f"no such file{_example(Path(path).name)}") from None
    try:
        _refuse_special(os.fstat(opened), path, place)
        return os.fdopen(opened, "rb")
    except BaseException:
        os.close(opened)
        raise


def _example(name: str) -> str:
    """The end of a message about a missing file that has the name of an example."""
    called_so = (example for example, path in examples().items() if path.name == name)
    said = (f"; an example is called so, which symoro-elastic new --example {example} writes" for example in called_so)
    return next(said, "")


def _refuse_special(status: os.stat_result, path: str | Path, place: str) -> None:
    if not stat.S_ISREG(status.st_mode):
        raise InputError(str(path), place, f"is not a file: it is a {kind_of_file(status)}")


def kind_of_file(status: os.stat_result) -> str:
    """Return the type of a file in a word."""
    kinds = {stat.S_ISDIR: "folder", stat.S_ISFIFO: "pipe", stat.S_ISSOCK: "socket", stat.S_ISLNK: "link"}
    return next((name for holds, name in kinds.items() if holds(status.st_mode)), "device")


def shipped_folder(name: str, holding: str) -> Path:
    """Return the folder `name` of the package, which contains a folder `holding`; raises `FileNotFoundError`."""
    places = (PACKAGE / name, PACKAGE.parent / name)
    for place in places:
        if (place / holding).is_dir():
            return place
    raise FileNotFoundError(f"no {name} in {places[0]} nor in {places[1]}: reinstall symoro-elastic")


def examples(*, scenes: bool = True) -> dict[str, Path]:
    """Return the examples by name, without suffix if unique: machines, and scenes of them."""
    files = list(_files(scenes))
    paths: dict[str, Path] = {}
    for path in sorted(files, key=lambda path: (path.stem, SUFFIXES.index(path.suffix))):
        paths[path.name if path.stem in paths else path.stem] = path
    return dict(sorted(paths.items()))


def _files(scenes: bool) -> Iterator[Path]:
    try:
        folder = shipped_folder(EXAMPLES, SCENES)
    except FileNotFoundError:
        return
    folders = (folder, folder / SCENES) if scenes else (folder,)
    yield from (path for folder in folders for path in folder.iterdir() if path.suffix in SUFFIXES)
