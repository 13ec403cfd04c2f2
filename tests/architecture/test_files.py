"""Files are opened behind few doors, `input_files`, `output_files`, `replacing`: plain files only, without waiting."""

from __future__ import annotations

import ast
import os
import signal
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from symoro_elastic import read
from symoro_elastic.analysis.time_series.reading import read_arrays
from symoro_elastic.formats.files import load_text
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.foundation.input_files import is_plain_file, open_file, read_file
from symoro_elastic.foundation.output_files import open_at_end, permission, write_all, write_file, write_files

ROOT = Path(__file__).parents[2]
PACKAGE = ROOT / "symoro_elastic"
DOORS = {"foundation/input_files.py", "foundation/output_files.py", "foundation/replacing.py"}
BUILT_IN = {"open"}
METHODS = {"open", "read_text", "read_bytes", "write_text", "write_bytes", "is_file", "fdopen"}
OF_NUMPY = {"load", "save", "loadtxt", "genfromtxt", "savetxt", "fromfile", "tofile", "memmap"}
NO_FILE_OF_A_USER = {
    ("cli/__init__.py", "open(os.devnull, 'w')"): "what is printed has nowhere to go",
    ("formats/modes_file.py", "np.load(io.BytesIO(content), allow_pickle=False)"): "bytes that were read by the doors",
    ("analysis/flexible/matrix_files.py", "np.loadtxt(lines or ['none'], ndmin=2)"): "lines of a text",
    ("analysis/time_series/reading.py", "archive.open(info)"): "a member of an archive that is open",
}


def openings(path: Path) -> Iterator[ast.Call]:
    """Calls that open a file by its path, or may wait for one."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if not isinstance(node, ast.Call):
            continue
        f = node.func
        if isinstance(f, ast.Name) and f.id in BUILT_IN:
            yield node
        elif isinstance(f, ast.Attribute):
            owner = ast.unparse(f.value)
            if (f.attr in METHODS and owner != "output_files") or (f.attr in OF_NUMPY and owner in ("np", "numpy")):
                yield node


@pytest.mark.thorough
def test_files_are_opened_behind_the_doors_only() -> None:
    found = {
        (path.relative_to(PACKAGE).as_posix(), ast.unparse(call))
        for path in sorted(PACKAGE.rglob("*.py"))
        if path.relative_to(PACKAGE).as_posix() not in DOORS
        for call in openings(path)
    }
    assert found == set(NO_FILE_OF_A_USER)


@pytest.mark.parametrize("text", ["open(x)", "Path(x).read_text()", "x.open('rb')", "np.load(x)", "os.open(x, 0)"])
def test_what_goes_around_the_doors_is_found(text: str, tmp_path: Path) -> None:
    (tmp_path / "module.py").write_text(text, encoding="utf-8")
    assert len([*openings(tmp_path / "module.py")]) == 1


def _appended(path: Path) -> None:
    with open_at_end(path) as write:
        write(b"x")


def _opened(path: Path) -> None:
    with open_file(path):
        pass


def _forced(write: Callable[[], object]) -> None:
    with permission(force=True):
        write()


USES: dict[str, Callable[[Path], object]] = {
    "read_file": read_file,
    "open_file": _opened,
    "load_text": load_text,
    "a table": lambda path: read_arrays(path.rename(path.with_suffix(".csv"))),
    "arrays": lambda path: read_arrays(path.rename(path.with_suffix(".npz"))),
    "a machine": lambda path: read(path.rename(path.with_suffix(".toml"))),
    "a robot": lambda path: read(path.rename(path.with_suffix(".urdf"))),
    "a file": lambda path: _forced(lambda: write_file(b"x", path)),
    "files of a folder": lambda path: _forced(lambda: write_all({path.name: b"x"}, path.parent)),
    "a journal": _appended,
    "a list of generated files": lambda path: write_files(
        path.rename(path.with_name("generated.json")).parent, {"a.c": ""}
    ),
}


@pytest.mark.parametrize("use", USES)
def test_pipes_are_neither_read_nor_written_and_keep_nobody_waiting(use: str, tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")

    def waited(*_: object) -> None:
        raise TimeoutError(use)

    before = signal.signal(signal.SIGALRM, waited)
    signal.alarm(20)
    try:
        with pytest.raises(InputError, match="pipe") as said:
            USES[use](tmp_path / "pipe")
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)
    assert "\n" not in str(said.value)
    (left,) = tmp_path.iterdir()
    assert left.is_fifo()


def test_folders_devices_and_missing_files_are_said(tmp_path: Path) -> None:
    for path, said in (
        (tmp_path, "is not a file: it is a folder"),
        (Path("/dev/zero"), "is not a file: it is a device"),
        (tmp_path / "none", "no such file"),
        (tmp_path / ("a" * 5000), "cannot be read: File name too long"),
        (tmp_path / "a\0b", "no such file"),
    ):
        assert not is_plain_file(path)
        with pytest.raises(InputError, match=said):
            read_file(path)


def test_a_journal_is_no_link(tmp_path: Path) -> None:
    (tmp_path / "journal").symlink_to(tmp_path / "elsewhere")
    with pytest.raises(InputError, match="is a link: give the name of the file itself"):
        _appended(tmp_path / "journal")
    assert not (tmp_path / "elsewhere").exists()
