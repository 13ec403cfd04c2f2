"""What compilers make is stored by content: text, headers, options, compiler."""

from __future__ import annotations

import ctypes
import os
import shutil
import subprocess
from pathlib import Path

import pytest

from tests.compiled_once import CompiledOnce

pytestmark = [pytest.mark.compiled_anew, pytest.mark.skipif(shutil.which("gcc") is None, reason="no gcc")]
SOURCE = '#include "value.h"\nint value(void) { return VALUE; }\n'


def library(once: CompiledOnce, folder: Path, *options: str, value: int = 1, source: str = SOURCE) -> Path:
    folder.mkdir(exist_ok=True)
    (folder / "made.c").write_text(source)
    (folder / "value.h").write_text(f"#define VALUE {value}\n")
    once(["gcc", "-shared", "-fPIC", *options, "made.c", "-o", "made.so"], cwd=folder, capture_output=True, check=True)
    return folder / "made.so"


@pytest.fixture
def once(tmp_path: Path) -> CompiledOnce:
    return CompiledOnce(tmp_path / "store")


def test_the_same_text_in_another_folder_is_compiled_once(once: CompiledOnce, tmp_path: Path) -> None:
    first, second = library(once, tmp_path / "a"), library(once, tmp_path / "b")
    assert once.hits == 1
    assert first.read_bytes() == second.read_bytes()
    assert ctypes.CDLL(str(second)).value() == 1


def test_a_library_that_is_loaded_is_not_written_into(once: CompiledOnce, tmp_path: Path) -> None:
    made = library(once, tmp_path / "a")
    with made.open("rb") as loaded:
        library(once, tmp_path / "b", value=2)
        before, after = loaded.fileno(), library(once, tmp_path / "a")
        assert once.hits == 1 and os.fstat(before).st_ino != after.stat().st_ino


@pytest.mark.thorough
def test_another_text_header_or_option_is_compiled(once: CompiledOnce, tmp_path: Path) -> None:
    library(once, tmp_path / "a")
    assert ctypes.CDLL(str(library(once, tmp_path / "b", value=2))).value() == 2
    assert ctypes.CDLL(str(library(once, tmp_path / "c", source=SOURCE.replace("VALUE;", "VALUE + 2;")))).value() == 3
    library(once, tmp_path / "d", "-O1")
    library(once, tmp_path / "e", "-DUNUSED=1")
    assert once.hits == 0


@pytest.mark.thorough
def test_failures_and_warnings_are_not_stored(once: CompiledOnce, tmp_path: Path) -> None:
    for name in ("a", "b"):
        with pytest.raises(subprocess.CalledProcessError):
            library(once, tmp_path / name, source="int value(void) { return; }}")
        warned = SOURCE.replace("{", "{ int unused;")
        library(once, tmp_path / name, "-Wall", source=warned)
    assert once.hits == 0


def test_commands_that_write_more_files_are_run(once: CompiledOnce, tmp_path: Path) -> None:
    for name in ("a", "b"):
        library(once, tmp_path / name, "-MMD")
        assert (tmp_path / name / "made.d").is_file()
    assert once.hits == 0
