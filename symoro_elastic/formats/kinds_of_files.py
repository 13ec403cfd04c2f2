"""The kind of a file from its name and content, for messages about files of another kind."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager
from enum import Enum
from pathlib import Path

from symoro_elastic.formats.files import load_text
from symoro_elastic.formats.toml.tables import load
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.foundation.input_files import is_plain_file, read_file
from symoro_elastic.machine.format_names import SYMORO, is_robot

HEADER = 1000


class FileKind(Enum):
    """Kind of a file that commands read: machine, scene, table of a motion or measurements, list of tests."""

    MACHINE = "a machine"
    SCENE = "a scene"
    TABLE = "a table of a motion or of measurements"
    TESTS = "a list of vibration tests"


REMEDIES = {
    FileKind.MACHINE: "give the machine first",
    FileKind.SCENE: "a scene is a .toml file with keys of [scene], [motion] and [wanted]",
    FileKind.TABLE: "give the machine first, then .csv or .npz files",
    FileKind.TESTS: "give the machine first, then a .toml file with a table [[tests]] for each test",
}


@contextmanager
def read_as(kind: FileKind, path: str | Path) -> Iterator[None]:
    """Context in which an error of reading a file is replaced if the file is of another known kind."""
    try:
        yield
    except InputError:
        actual = kind_of(Path(path))
        if actual in (None, kind):
            raise
        what = f"is {actual.value}, not {kind.value}: {REMEDIES[kind]}"
        raise InputError(str(path), "file", what) from None


def kind_of(path: Path) -> FileKind | None:
    """Return the kind of a file by its suffix and its first words; None if they do not determine it."""
    suffix = path.suffix.lower()
    if not is_plain_file(path):
        return None
    if suffix == ".npz":
        return FileKind.TABLE
    if suffix in (".csv", ".txt"):
        return _kind_of_table(path)
    if suffix == ".toml":
        return _kind_of_toml(path)
    return FileKind.MACHINE if suffix in SYMORO.suffixes or is_robot(str(path)) else None


def _kind_of_table(path: Path) -> FileKind | None:
    """Kind of a table by its header: a record if the first column is t, a machine (DH table) with a column alpha."""
    try:
        first = read_file(path, most=HEADER).splitlines() or [b""]
        cells = re.split("[,;\t]", first[0].decode("utf-8-sig"))
    except (InputError, UnicodeDecodeError):
        return None
    names = [cell.partition("[")[0].strip(' "\n') for cell in cells]
    return FileKind.TABLE if names[0] == "t" else FileKind.MACHINE if "alpha" in names else None


def _kind_of_toml(path: Path) -> FileKind | None:
    try:
        keys = load(load_text(path), str(path)).entries.keys()
    except InputError:
        return None
    if "joints" in keys:
        return FileKind.MACHINE
    if "tests" in keys:
        return FileKind.TESTS
    return FileKind.SCENE if keys & {"motion", "wanted", "scene", "models", "outputs", "locked", "static"} else None
