"""What commands write: never their input, existing files with --force only, whole or not at all."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from functools import partial
from pathlib import Path

import click
import pytest

import symoro_elastic as se
from symoro_elastic import cli
from symoro_elastic.cli.options import InputFile, Output, OutputFile, OutputFolder, OutputMachine, OutputPage
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.foundation.file_forms import PICTURE_FORMATS, why_not_on_windows
from symoro_elastic.foundation.output_files import MANIFEST, permission, write_all, write_file, write_files
from symoro_elastic.foundation.replacing import STAGING
from tests.command_line import EXAMPLES, refused, run

TWO_R, TWO_AXIS = EXAMPLES / "planar_2r.toml", EXAMPLES / "two_axis.toml"
MOTION = EXAMPLES / "scenes" / "planar_2r_move.toml"
LIMITS = ("--position", "-1:1", "--velocity", "1", "--acceleration", "5", "--evaluations", "1", "--periods", "1")
WRITING = {
    "equations": (TWO_R, "--model", "inertia_matrix", "--out", "out.tex"),
    "convert": (TWO_R, "out.par"),
    "show": (TWO_R, "--picture", "out.svg"),
    "view": (TWO_R, "--out", "out.html"),
    "new": ("out.toml",),
    "flexible": (EXAMPLES / "bracket.npz", "--save", "out.npz"),
    "formats": ("--out", "out.md"),
    "schema": ("--out", "out.json"),
    "excite": (TWO_R, *LIMITS, "--sample-rate", "20", "--out", "out.csv"),
    "linearize": (TWO_R, "--out", "out.npz"),
    "modes": (TWO_AXIS, "--out", "out.mat"),
    "response": (TWO_AXIS, "--band", "1:10:3", "--out", "out.csv"),
    "simulate": (TWO_R, "--scene", MOTION, "--step", "0.01", "--out", "out.csv"),
    "reduce": (TWO_R, "--scene", MOTION, "--for", "feed-forward", "--save", "out.toml"),
    "ladder": (TWO_R, "--scene", MOTION, "--save", "out.toml"),
    "sweep": (TWO_AXIS, "--over", "ram.k=1e6,1e7", "--out", "out.csv"),
    "feed-forward": (TWO_R, "--duration", "0.1", "--sample-rate", "50", "--out", "out.csv"),
}
"""Arguments with which each command that writes one file writes it."""
WRITING_LATE = {
    "control": (TWO_AXIS, "--damping", "0.02", "--save", "out.toml"),
    "tune": (TWO_AXIS, "--damping", "0.02", "--save", "out.toml"),
    "identify": (TWO_R, "none.csv", "--save", "out.toml"),
    "report": (TWO_R, "--out", "out.html"),
    "update": (TWO_AXIS, "none.toml", "--save", "out.toml"),
}
"""The same where that takes long, or needs measurements first."""


@pytest.fixture(autouse=True)
def _in_an_empty_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def contents(folder: Path) -> dict[str, bytes]:
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def test_every_path_is_an_input_or_an_output_and_those_that_write_take_force() -> None:
    for name, command in cli.cli.commands.items():
        paths = [p.type for p in command.params if isinstance(p.type, click.Path)]
        assert all(isinstance(kind, (InputFile, Output)) for kind in paths), name
        writing = any(isinstance(kind, Output) for kind in paths)
        assert any("--force" in p.opts for p in command.params) == writing, name
        one = any(isinstance(kind, OutputFile) for kind in paths)
        assert one == (name in {*WRITING, *WRITING_LATE}), name


def files_written() -> list[tuple[str, click.Parameter]]:
    commands = cli.cli.commands.items()
    return [(name, p) for name, one in commands for p in one.params if isinstance(p.type, OutputFile)]


@pytest.mark.parametrize(("command", "parameter"), files_written(), ids=str)
def test_the_suffix_of_a_file_says_its_format(command: str, parameter: click.Parameter, tmp_path: Path) -> None:
    """Each file that a command writes declares its formats; others are refused before the machine is read."""
    if command == "new":
        return  # adds the suffix itself
    assert isinstance(parameter.type, OutputFile) and parameter.type.forms
    known = [*WRITING.get(command, WRITING_LATE.get(command, ()))[:-1]]
    given = ["none.toml" if isinstance(each, Path) and each.suffix == ".toml" else each for each in known]
    place = parameter.opts[0] if isinstance(parameter, click.Option) else str(parameter.metavar)
    said = refused(command, *given, "out.docx")
    if isinstance(parameter.type, OutputMachine):
        assert said.startswith(f"out.docx: {place}: the suffix '.docx' is not a machine format")
    else:
        assert said.startswith(f"out.docx: {place}: unknown format '.docx': end the name with ")
        assert all(form in said for form in parameter.type.forms)


def test_equations_are_written_in_the_format_of_the_suffix(tmp_path: Path) -> None:
    asked = ("equations", TWO_R, "--model", "inertia_matrix")
    for name, begins in {"a.html": "<!doctype html>", "b.HTM": "<!doctype html>", "c.tex": "\\documentclass"}.items():
        assert run(*asked, "--out", name).exit_code == 0
        assert (tmp_path / name).read_text().startswith(begins), name
    assert refused(*asked, "--out", "eq.html", "--format", "latex") == (
        "symoro-elastic: --format: eq.html is not a file of latex: leave --format out, or end the name otherwise"
    )
    assert (
        refused(*asked, "--out", "eq")
        == "eq: --out: its format is missing: end the name with .tex, .html, .htm or .pdf"
    )
    assert run(*asked, "--format", "html").stdout.startswith("<!doctype html>")


def folders_written() -> list[tuple[str, click.Parameter]]:
    """Each parameter of a command that is a folder, or a page in one."""
    commands = cli.cli.commands.items()
    return [(name, p) for name, one in commands for p in one.params if isinstance(p.type, OutputFolder | OutputPage)]


@pytest.mark.parametrize(("command", "parameter"), folders_written(), ids=str)
def test_no_folder_is_called_as_a_file(command: str, parameter: click.Parameter, tmp_path: Path) -> None:
    """`report --out r.txt` made a folder r.txt; a folder that is there may be called so, and `v1.2` is one, too."""
    assert isinstance(parameter.type, Output)
    for name in ("r.txt", "plots.PNG", "r.json", "r.zip"):
        with pytest.raises(InputError, match=r"leave it out|end the name with \.html"):
            parameter.type.refuse(name, parameter.opts[0])
    (tmp_path / "r.txt").mkdir()
    for name in ("r.txt", "v1.2", "plots", ".", "r.txt/inner"):
        parameter.type.refuse(name, parameter.opts[0])


def test_results_in_python_make_no_folder_called_as_a_file(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="leave it out"):
        se.generate(TWO_R, ["inertia_matrix"], out="generated.zip")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.thorough
def test_a_report_is_a_page_or_a_folder(tmp_path: Path) -> None:
    assert run("report", TWO_R, "--out", "page.html").stdout == "wrote page.html\n"
    run("report", TWO_R, "--out", "pages")
    assert (tmp_path / "page.html").read_bytes() == (tmp_path / "pages" / "planar_2r.html").read_bytes()
    assert "exists already" in refused("report", TWO_R, "--out", "page.html")


@pytest.mark.sampled(6)
@pytest.mark.parametrize("command", WRITING)
def test_a_file_is_replaced_with_force_only(command: str, tmp_path: Path) -> None:
    *arguments, out = WRITING[command]
    path = tmp_path / str(out)
    path.write_text("mine")
    assert "exists already" in refused(command, *arguments, out)
    assert path.read_text() == "mine"
    assert run(command, *arguments, out, "--force").exit_code == 0
    assert path.stat().st_size > 4 and b"mine" not in path.read_bytes()[:4]
    assert list(contents(tmp_path)) == [str(out)]


@pytest.mark.parametrize("link", ["same", "symbolic", "hard"])
def test_no_command_writes_onto_its_input(link: str, tmp_path: Path) -> None:
    machine, out = tmp_path / "machine.toml", tmp_path / "machine.toml"
    machine.write_bytes(TWO_R.read_bytes())
    if link != "same":
        out = tmp_path / "out.toml"
        out.symlink_to(machine) if link == "symbolic" else out.hardlink_to(machine)
    for force in ((), ("--force",)):
        assert "is read by this command" in refused("equations", machine, "--out", out, *force)
        assert "is read by this command" in refused("convert", machine, out, *force)
    assert machine.read_bytes() == TWO_R.read_bytes()


@pytest.mark.parametrize(
    ("out", "said"),
    [
        ("", "is not a name of a file"),
        ("a\nb", "is not a name of a file"),
        ("a\x1b[2Jb", "is not a name of a file"),
        ("none/a.tex", "--out: cannot be written: its folder does not exist"),
        (".", "--out: cannot be written: it is a folder"),
    ],
)
def test_names_that_no_file_has(out: str, said: str, tmp_path: Path) -> None:
    assert said in refused("equations", TWO_R, "--out", out)
    if out in ("", "a\nb"):
        assert said in refused("generate", TWO_R, "--out", out)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    "command", ["modes", "response", "compare", "simulate", "feed-forward", "benchmark", "identify", "excite"]
)
def test_pictures_into_a_file_are_refused_before_any_work(command: str, tmp_path: Path) -> None:
    """Before the machine is read, which does not exist."""
    (tmp_path / "mine").write_text("mine")
    scene = ("--scene", "scene.toml")
    cut = ("--direction", "tip.x", "--cutting", "1e9")
    needed = {"excite": (*LIMITS, "--out", "e.csv"), "identify": ("data.csv",), "ladder": scene, "lobes": cut}
    more = (needed | {"update": ("tests.toml",)}).get(command, ())
    assert refused(command, "none.toml", *more, "--plots", "mine") == (
        "mine: --plots: is a file, not a folder: choose another folder"
    )


@pytest.mark.thorough
def test_pictures_are_replaced_with_force_only(tmp_path: Path) -> None:
    shown = ("response", TWO_AXIS, "--input", "motor_x.tau", "--band", "1:10:3", "--plots", tmp_path / "new/plots")
    run(*shown)
    first = contents(tmp_path)
    assert list(first) == ["new/plots/bode_motor_x_tau.png"]
    assert "--plots: exists already" in refused(*shown)
    run(*shown, "--force")
    assert contents(tmp_path) == first


DRAWING = [name for name, command in cli.cli.commands.items() if any(p.name == "plots" for p in command.params)]


def test_every_command_that_draws_offers_the_formats_of_pictures() -> None:
    for name in DRAWING:
        (picture,) = (p for p in cli.cli.commands[name].params if p.name == "plot_format")
        assert picture.shell_complete is not None
        completed = [item.value for item in picture.shell_complete(click.Context(cli.cli.commands[name]), "")]
        assert completed == list(PICTURE_FORMATS), name


BEGINNINGS = {"png": b"\x89PNG", "svg": b"<?xml", "pdf": b"%PDF"}


@pytest.mark.thorough
@pytest.mark.parametrize("form", PICTURE_FORMATS)
def test_pictures_are_drawn_in_the_format_asked_for(form: str, tmp_path: Path) -> None:
    asked = ("--plot-format", form) if form != PICTURE_FORMATS[0] else ()
    run("modes", TWO_AXIS, "--plots", tmp_path, *asked)
    names = sorted(path.name for path in tmp_path.iterdir())
    assert names == [f"energies.{form}", f"pictures.{form}", f"shapes.{form}"]
    assert all((tmp_path / name).read_bytes().startswith(BEGINNINGS[form]) for name in names)


@pytest.mark.parametrize("command", DRAWING)
def test_formats_of_pictures_are_refused_before_any_work(command: str) -> None:
    scene = ("--scene", "scene.toml")
    cut = ("--direction", "tip.x", "--cutting", "1e9")
    needed = {"excite": (*LIMITS, "--out", "e.csv"), "identify": ("data.csv",), "ladder": scene, "lobes": cut}
    more = (needed | {"update": ("tests.toml",), "ik": ("--position", "0,0,0")}).get(command, ())
    unknown = refused(command, "none.toml", *more, "--plots", "p", "--plot-format", "bmp")
    assert unknown == "symoro-elastic: --plot-format: unknown 'bmp': choose from png, svg, pdf"
    alone = refused(command, "none.toml", *more, "--plot-format", "svg")
    assert alone == "symoro-elastic: --plot-format: plots need a folder: name it with --plots"


def test_devices_and_pipes_take_what_is_written() -> None:
    write_file(b"text", "/dev/null")
    assert Path("/dev/null").is_char_device()
    with pytest.raises(InputError, match="No space left on device"):
        write_file(b"text", "/dev/full")


def test_a_full_disk_leaves_the_old_file_and_no_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "a").write_text("old")

    def full(path: Path, content: bytes) -> int:
        with path.open("wb") as file:
            file.write(content[:2])
        raise OSError(28, os.strerror(28))

    monkeypatch.setattr(Path, "write_bytes", full)
    with permission(force=True), pytest.raises(InputError, match="No space left on device"):
        write_file(b"new text", tmp_path / "a")
    with pytest.raises(InputError, match="No space left on device"):
        write_all({"b": b"text", "c": b"text"}, tmp_path / "some" / "folder")
    with pytest.raises(InputError, match="No space left on device"):
        write_files(tmp_path / "OUT" / "name", {"b": "text"})
    assert contents(tmp_path) == {"a": b"old"} and len(list(tmp_path.iterdir())) == 1


def test_a_file_keeps_its_mode_and_a_new_one_has_the_usual(tmp_path: Path) -> None:
    (tmp_path / "old").touch(0o640)
    with permission(force=True):
        write_file(b"text", tmp_path / "old")
    write_file(b"text", tmp_path / "new")
    (tmp_path / "usual").write_text("")
    modes = [(tmp_path / name).stat().st_mode & 0o777 for name in ("old", "new", "usual")]
    assert modes[0] == 0o640 and modes[1] == modes[2]


def test_leftovers_of_killed_runs_are_removed_and_those_of_live_ones_stay(tmp_path: Path) -> None:
    held = (
        "import sys; from pathlib import Path; from symoro_elastic.foundation.replacing import _staging\n"
        "with _staging(Path(sys.argv[1])) as folder: print(folder.name, flush=True); sys.stdin.read()"
    )
    command = [sys.executable, "-c", held, str(tmp_path)]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as live:
        assert live.stdin and live.stdout
        staging = live.stdout.readline().strip()
        dead = tmp_path / f"{STAGING}dead"
        dead.mkdir()
        (dead / "planar_2r.c").write_text("half")
        write_file(b"text", tmp_path / "a")
        assert sorted(path.name for path in tmp_path.iterdir()) == sorted([staging, "a"])
        live.kill()
    with permission(force=True):
        write_file(b"text", tmp_path / "a")
    assert [path.name for path in tmp_path.iterdir()] == ["a"]


# Folders of generated files

FILES = {"a.c": "one\n", "b.c": "two\n"}


@pytest.mark.parametrize(
    ("path", "kind"),
    [
        ("con", "a device"), ("out/aux.toml", "a device"), (r"C:\out\NUL", "a device"), ("COM1 .csv", "a device"),
        ("a.csv:b", "a stream of another file"), (r"C:\a:b.csv", "a stream of another file"),
        (r"C:\out\arm.csv", ""), ("console.csv", ""), ("out/com.csv", ""), ("a.con", ""), (r"\\host\share\a.csv", ""),
    ],
)  # fmt: skip
def test_names_of_devices_and_streams_are_no_files_of_windows(path: str, kind: str) -> None:
    assert why_not_on_windows(path) == kind


def test_files_changed_by_hand_are_recognised(tmp_path: Path) -> None:
    run("generate", TWO_R, "--out", tmp_path)
    path = tmp_path / "planar_2r" / "planar_2r.c"
    generated = path.read_bytes()
    path.write_bytes(generated + b"/* mine */\n")
    for more in ((), ("--target", "numpy")):
        assert f"{path}: --out: was changed since it was generated" in refused(
            "generate", TWO_R, "--out", tmp_path, *more
        )
    run("generate", TWO_R, "--out", tmp_path, "--force")
    assert path.read_bytes() == generated


def test_the_list_has_hashes_which_line_ends_do_not_change(tmp_path: Path) -> None:
    write_files(tmp_path, FILES)
    listed = json.loads((tmp_path / MANIFEST).read_text())
    assert listed["files"] == list(FILES) == list(listed["sha256"])
    (tmp_path / "a.c").write_bytes(b"one\r\n")
    three = {**FILES, "a.c": "three\n"}
    write_files(tmp_path, three)
    assert (tmp_path / "a.c").read_text() == "three\n"
    del listed["sha256"]
    (tmp_path / MANIFEST).write_text(json.dumps(listed))
    write_files(tmp_path, FILES)


def test_files_of_mine_among_generated_ones_go_with_force_only(tmp_path: Path) -> None:
    write_files(tmp_path / "out", FILES)
    (tmp_path / "out/c.c").symlink_to(tmp_path / "mine")
    (tmp_path / "mine").write_text("mine")
    with pytest.raises(InputError, match="was not generated"):
        write_files(tmp_path / "out", {**FILES, "c.c": "three\n"})
    with permission(force=True):
        write_files(tmp_path / "out", {**FILES, "c.c": "three\n"})
    assert (tmp_path / "mine").read_text() == "mine" and (tmp_path / "out/c.c").read_text() == "three\n"
    (tmp_path / "own").mkdir()
    (tmp_path / "own/notes.txt").write_text("mine")
    with pytest.raises(InputError, match="holds files that were not generated"):
        write_files(tmp_path / "own", FILES)
    with permission(force=True):
        write_files(tmp_path / "own", FILES)
    assert (tmp_path / "own/notes.txt").read_text() == "mine"


def test_files_in_folders_and_of_bytes_come_and_go(tmp_path: Path) -> None:
    nested = {"+arm/move.m": "one\n", "+arm/deep/a.bin": b"\x00\r\n\xff", "build.m": "two\n"}
    written = write_files(tmp_path / "out", nested)
    assert {path.relative_to(tmp_path / "out").as_posix() for path in written} == {*nested, MANIFEST}
    assert (tmp_path / "out/+arm/deep/a.bin").read_bytes() == nested["+arm/deep/a.bin"]
    (tmp_path / "out/+arm/move.m").write_text("mine")
    with pytest.raises(InputError, match=r"move\.m: --out: was changed since it was generated"):
        write_files(tmp_path / "out", nested)
    (tmp_path / "out/+arm/move.m").write_text("one\n")
    write_files(tmp_path / "out", FILES)
    assert {path.name for path in (tmp_path / "out").iterdir()} == {*FILES, MANIFEST}


def test_no_file_outside_of_the_folder_is_reached(tmp_path: Path) -> None:
    mine = tmp_path / "mine"
    mine.mkdir()
    (mine / "a.m").write_text("mine")
    write_files(tmp_path / "out", {"+arm/a.m": "one\n", "b.m": "two\n"})
    (tmp_path / "out/+arm/a.m").unlink()
    (tmp_path / "out/+arm").rmdir()
    (tmp_path / "out/+arm").symlink_to(mine)
    for forced, said in ((False, "was not generated"), (True, r"\+arm: --out: is a link")):
        with permission(force=forced), pytest.raises(InputError, match=said):
            write_files(tmp_path / "out", {"+arm/a.m": "three\n"})
    listed = json.loads((tmp_path / "out" / MANIFEST).read_text())
    listed["files"] += ["../mine/a.m", "+arm/../../mine/a.m", str(mine / "a.m")]
    (tmp_path / "out" / MANIFEST).write_text(json.dumps(listed))
    write_files(tmp_path / "out", {"b.m": "two\n"})
    assert (mine / "a.m").read_text() == "mine"


@pytest.mark.parametrize("text", ["[" * 100_000, '{"files": ' + "[" * 5000, "null", '{"files": 3}', " " * 5_000_001])
def test_a_list_that_is_none_is_refused_and_replaced_by_force(text: str, tmp_path: Path) -> None:
    (tmp_path / MANIFEST).write_text(text)
    with pytest.raises(InputError, match="is not a list of generated files: move the folder away"):
        write_files(tmp_path, FILES)
    assert (tmp_path / MANIFEST).read_text() == text
    with permission(force=True):
        write_files(tmp_path, FILES)
    assert set(contents(tmp_path)) == {*FILES, MANIFEST}


def test_only_plain_files_of_a_list_are_removed(tmp_path: Path) -> None:
    write_files(tmp_path, FILES)
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine/notes").write_text("mine")
    listed = json.loads((tmp_path / MANIFEST).read_text())
    listed["files"] += ["mine", "a\0b", "a\nb", ""]
    (tmp_path / MANIFEST).write_text(json.dumps(listed))
    write_files(tmp_path, {"a.c": "new\n"})
    assert set(contents(tmp_path)) == {"a.c", "mine/notes", MANIFEST}
    assert json.loads((tmp_path / MANIFEST).read_text())["files"] == ["a.c"]


@pytest.mark.thorough
def test_four_runs_at_once_leave_a_whole_folder(tmp_path: Path) -> None:
    many = (
        "import sys; from pathlib import Path; from symoro_elastic.foundation.output_files import write_files\n"
        "for k in range(20): write_files(Path(sys.argv[1]), {f'{n}.c': f'{k} {n}' for n in range(5)})"
    )
    runs = [subprocess.Popen([sys.executable, "-c", many, str(tmp_path)], stderr=subprocess.PIPE) for _ in range(4)]
    assert [(run.communicate()[1], run.returncode) for run in runs] == [(b"", 0)] * 4
    write_files(tmp_path, {f"{n}.c": "" for n in range(5)})
    assert len(list(tmp_path.iterdir())) == 6


@pytest.mark.sampled(1000)
@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGHUP])
def test_temporary_folders_go_when_a_run_is_ended(number: signal.Signals, tmp_path: Path) -> None:
    (tmp_path / "tmp").mkdir()
    compiler = tmp_path / "cc"
    compiler.write_text(f"#!/bin/sh\ntouch {tmp_path}/compiling\nexec sleep 60\n")
    compiler.chmod(0o755)
    environment = {**os.environ, "CC": str(compiler), "TMPDIR": str(tmp_path / "tmp")}
    command = [sys.executable, "-m", "symoro_elastic", "check", str(TWO_R), "--model", "inertia_matrix"]
    heard = partial(signal.signal, number, signal.SIG_DFL)  # nohup has runs ignore SIGHUP
    streams = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    with subprocess.Popen(command, env=environment, preexec_fn=heard, **streams) as running:  # noqa: PLW1509
        while not (tmp_path / "compiling").exists() and running.poll() is None:
            time.sleep(0.05)
        running.send_signal(number)
        out, error = running.communicate()
    assert (running.returncode, out, error) == (128 + number, b"", b"")
    assert list((tmp_path / "tmp").iterdir()) == []
