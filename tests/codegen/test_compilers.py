"""Compilers that print in another encoding, do not start, do not end, or write something else: one line each."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from symoro_elastic.codegen import compile as compiling
from symoro_elastic.codegen.compile import CompilationFailed, compile_library, find_compiler, run_program, words
from tests.command_line import EXAMPLES, ended

pytestmark = pytest.mark.compiled_anew
TWO_R, MOVE = EXAMPLES / "planar_2r.toml", EXAMPLES / "scenes" / "planar_2r_move.toml"
FAULTS = {
    "a message in Latin-1": ("#!/bin/sh\nprintf 'error: unbekannt \\344\\n' >&2; exit 1\n", "error: unbekannt \ufffd"),
    "no interpreter": ("#!/no/such/interpreter\n", "cannot be started (No such file or directory): set CC"),
    "no program": ("hello\n", "cannot be started (Exec format error): set CC to a C compiler, or unset it"),
    "another program": ("#!/bin/sh\nexit 0\n", "wrote no library: set CC to a C compiler, or unset it"),
}
COMMANDS = {
    "check": ("check", TWO_R, "--model", "inertia_matrix"),
    "check --self": ("check", TWO_R, "--self", "--model", "inertia_matrix"),
    "simulate": ("simulate", TWO_R, "--scene", MOVE, "--step", "0.01"),
    "generate": ("generate", TWO_R, "--target", "fmu", "--out", "out"),
}


@pytest.fixture(autouse=True)
def _in_an_empty_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def program(path: Path, text: str) -> Path:
    path.write_bytes(text.encode("latin-1"))
    path.chmod(0o755)
    return path


@pytest.mark.sampled(4)
@pytest.mark.parametrize("fault", FAULTS)
@pytest.mark.parametrize("command", COMMANDS)
def test_compilers_that_fail_are_one_line(
    command: str, fault: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    text, said = FAULTS[fault]
    monkeypatch.setenv("CC", str(program(tmp_path / "cc", text)))
    found = ended(*COMMANDS[command])
    assert (found.code, found.out) == (2, "") and found.err.count("\n") == 1
    assert found.err.startswith(f"error: symoro-elastic: C compiler: {tmp_path / 'cc'}: {said}")
    assert [path.name for path in tmp_path.iterdir()] == ["cc"]


@pytest.mark.sampled(2)
@pytest.mark.parametrize("command", COMMANDS)
def test_a_computer_without_a_compiler_is_one_line(command: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CC", "no-such-compiler")
    found = ended(*COMMANDS[command])
    if command == "generate":
        assert found.code == 0 and "no C compiler was found" in found.out
    else:
        assert found.code == 2 and "CC is 'no-such-compiler', and there is no such program" in found.err
        assert found.err.count("\n") == 1


@pytest.mark.sampled(2)
@pytest.mark.skipif(shutil.which("gcc") is None, reason="no gcc")
@pytest.mark.parametrize("command", COMMANDS)
def test_a_library_without_the_functions_is_one_line(
    command: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As that of a cache with a wrong entry."""
    (tmp_path / "other.c").write_text("int other;\n")
    compile_library({"other.c": "int other;\n"}, tmp_path / "made", ("gcc",))
    copying = f'for word; do test "$before" = -o && cp {tmp_path}/made/other.so $word; before=$word; done'
    monkeypatch.setenv("CC", str(program(tmp_path / "cc", f"#!/bin/sh\n{copying}\nexit 0\n")))
    found = ended(*COMMANDS[command])
    assert found.code == 2 and found.err.count("\n") == 1 and "error: symoro-elastic: C compiler: the lib" in found.err


def test_a_compiler_that_does_not_end_is_ended(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(compiling, "LONGEST", 0.2)
    with pytest.raises(CompilationFailed, match=r"cc: has not ended in 0\.2 s: ask for fewer models, or set CC to"):
        run_program([str(program(tmp_path / "cc", "#!/bin/sh\nexec sleep 60\n"))])


def test_a_compiler_that_reads_gets_nothing(tmp_path: Path) -> None:
    assert run_program([str(program(tmp_path / "cc", "#!/bin/sh\nexec cat\n"))]).stdout == ""


def test_the_path_of_a_compiler_may_have_blanks(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "my compilers").mkdir()
    path = str(program(tmp_path / "my compilers" / "cc", "#!/bin/sh\n"))
    monkeypatch.setenv("CC", path)
    assert find_compiler() == (path,)
    monkeypatch.setenv("CC", f"'{path}' -m32")
    assert find_compiler() == (path, "-m32")


def test_paths_of_windows_keep_their_backslashes(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(compiling, "ON_WINDOWS", True)
    assert words(r"C:\mingw\bin\gcc.exe -m64") == (r"C:\mingw\bin\gcc.exe", "-m64")
    assert words(r'"C:\Program Files\mingw\gcc.exe" -O2') == (r"C:\Program Files\mingw\gcc.exe", "-O2")
    with pytest.raises(ValueError, match="gcc"):
        words('"gcc')
