"""The command line: what it prints, what it writes, and how it refuses."""

from __future__ import annotations

import errno
import json
import os
import random
import re
import shutil
import subprocess
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import pytest

from symoro_elastic import cli
from symoro_elastic.foundation.output_files import MANIFEST

ROOT = Path(__file__).parents[2]
EXAMPLES = ROOT / "examples"
TWO_R = EXAMPLES / "planar_2r.toml"
FLEX4 = EXAMPLES / "flex4.par"
PRINTED = EXAMPLES / "two_axis_printed.par"
PACKAGE = {"__init__.py", "_runtime.py", "_direct_dynamics.py", "_inverse_dynamics.py"}
COUNTS = {"mul", "add", "div", "sincos"}


class Ran(NamedTuple):
    code: int
    out: str
    err: str

    @property
    def figures(self) -> dict[str, Any]:
        """The one JSON object on stdout."""
        assert self.code == 0 and not self.err and self.out.count("\n") == 1
        found: dict[str, Any] = json.loads(self.out)
        return found


Run = Callable[..., Ran]


@pytest.fixture
def run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Run:
    """`symoro-elastic ARGUMENTS` in an empty folder; anything but a clean exit is a failure."""
    monkeypatch.chdir(tmp_path)

    def command(*arguments: object) -> Ran:
        monkeypatch.setattr(sys, "argv", ["symoro-elastic", *map(str, arguments)])
        with pytest.raises(SystemExit) as caught:
            cli.main()
        printed = capsys.readouterr()
        return Ran(int(caught.value.code or 0), printed.out, printed.err)

    return command


def outside(*arguments: object, folder: Path, **variables: str) -> Ran:
    """`python -m symoro_elastic ARGUMENTS` in a process of its own."""
    command = [sys.executable, "-m", "symoro_elastic", *map(str, arguments)]
    environment = {**os.environ, **variables}
    run = subprocess.run(command, capture_output=True, text=True, check=False, cwd=folder, env=environment)
    return Ran(run.returncode, run.stdout, run.stderr)


def files_below(folder: Path) -> dict[str, bytes]:
    return {str(p.relative_to(folder)): p.read_bytes() if p.is_file() else b"" for p in folder.rglob("*")}


def refused(run: Run, *arguments: object) -> str:
    """The error of a command: one line on stderr, exit code 2, nothing on stdout, no file touched.

    The printed table, whose motors are parallel, is warned about first.
    """
    before = files_below(Path.cwd())
    ran = run(*arguments)
    assert (ran.code, ran.out) == (2, "")
    *warned, line = ran.err.splitlines()
    assert line.startswith("error: ") and "Traceback" not in ran.err
    assert [text.partition(": ")[0] for text in warned] == ["warning"] * (PRINTED in arguments)
    assert files_below(Path.cwd()) == before
    return line.removeprefix("error: ")


def edited(source: Path, folder: Path, old: str, new: str) -> Path:
    text = source.read_text(encoding="utf-8")
    assert old in text
    target = folder / source.name
    target.write_text(text.replace(old, new), encoding="utf-8")
    return target


# What is written and printed


def test_generate_writes_both_targets_and_says_so(run: Run) -> None:
    ran = run("generate", TWO_R)
    folder = Path("generated/planar_2r")
    expected = PACKAGE | {"planar_2r.h", "planar_2r.c", MANIFEST}
    assert ran.code == 0 and ran.err == ""
    assert {p.name for p in folder.iterdir()} == expected
    written = ran.out.splitlines()[0].removeprefix(f"wrote {folder}: ")
    assert set(written.split(", ")) == expected
    for model in ("direct_dynamics", "inverse_dynamics"):
        row = next(line for line in ran.out.splitlines() if line.strip().startswith(model))
        assert re.search(r"\d+x \d+\+ 4 sin/cos +\d+x \d+\+", row)
    assert json.loads((folder / MANIFEST).read_text())["files"] == sorted(expected - {MANIFEST})


def test_single_precision_has_a_name_of_its_own(run: Run) -> None:
    ran = run("generate", TWO_R, "--precision", "single", "--precision", "double")
    assert ran.code == 0
    for header, function, number in (
        ("planar_2r_single.h", "direct_dynamics_f32", "float"),
        ("planar_2r.h", "direct_dynamics", "double"),
    ):
        text = Path("generated/planar_2r", header).read_text()
        assert re.search(rf"void planar_2r_{function}\(\s*const {number} q\[", text)


def test_generate_json(run: Run) -> None:
    found = run("generate", FLEX4, "--json").figures
    assert found.keys() == {"written", "models", "form"}
    assert all(Path(path).is_file() for path in found["written"]) and len(found["written"]) == 7
    assert found["models"].keys() == {"direct_dynamics", "inverse_dynamics"}
    for figures in found["models"].values():
        assert figures.keys() == COUNTS | {"once"} and figures["once"].keys() == COUNTS
        assert all(type(n) is int for n in [figures[k] for k in COUNTS] + list(figures["once"].values()))
        assert figures["sincos"] == 4 and figures["mul"] > 100 and figures["once"]["mul"] > 0


def test_the_table_and_the_json_tell_the_same(run: Run) -> None:
    counts = run("generate", FLEX4, "--json").figures["models"]
    printed = run("generate", FLEX4).out
    for model, figures in counts.items():
        once = figures["once"]
        row = f"{figures['mul'] + figures['div']}x {figures['add']}+ {figures['sincos']} sin/cos"
        found = re.search(rf"{model} +{re.escape(row)} +(\d+)x (\d+)\+", printed)
        assert found and (int(found[1]), int(found[2])) == (once["mul"] + once["div"], once["add"])


def test_options_choose_models_targets_and_folder(run: Run) -> None:
    ran = run("generate", TWO_R, "--model", "inertia_matrix", "--target", "c", "--out", "a/b", "--json")
    assert set(ran.figures["models"]) == {"inertia_matrix"}
    assert set(files_below(Path.cwd())) == {
        "a",
        "a/b",
        "a/b/planar_2r",
        *(f"a/b/planar_2r/{name}" for name in ("planar_2r.c", "planar_2r.h", MANIFEST)),
    }
    assert not (Path.cwd() / "generated").exists()
    twice = run("generate", TWO_R, "--model", "bias_forces", "--model", "bias_forces", "--target", "c", "--target", "c")
    assert twice.code == 0


def test_fold_and_scene_show_what_they_save(run: Run, tmp_path: Path) -> None:
    (tmp_path / "view.toml").write_text('models = ["direct_dynamics"]\nlocked = { elbow = 0.5 }\ngravity = false\n')
    found = run("generate", TWO_R, "--scene", "view.toml", "--fold", "l1", "--fold", "m2", "--json").figures
    figures = found["models"]["direct_dynamics"]
    assert figures.keys() == COUNTS | {"once", "whole", "saved"}
    assert {key: figures["whole"][key] - figures[key] for key in COUNTS} == figures["saved"]
    assert sum(figures["saved"].values()) > 0
    header = (tmp_path / "generated/planar_2r/planar_2r.h").read_text()
    assert "#define PLANAR_2R_JOINTS 1" in header and "PLANAR_2R_P_l1" not in header and "PLANAR_2R_P_m1" in header
    ran = run("generate", TWO_R, "--fold", "all")
    assert "saved" in ran.out and "PARAMETERS = ()" in (tmp_path / "generated/planar_2r/__init__.py").read_text()


def test_models_on_the_command_line_go_before_those_of_the_scene(run: Run, tmp_path: Path) -> None:
    (tmp_path / "view.toml").write_text('models = ["direct_dynamics"]\n')
    found = run("generate", TWO_R, "--scene", "view.toml", "--model", "bias_forces", "--json").figures
    assert set(found["models"]) == {"bias_forces"}


@pytest.mark.thorough
def test_show_json(run: Run) -> None:
    found = run("show", FLEX4, "--json").figures
    assert found.keys() >= {"name", "joints", "motors", "elastic", "parameters", "degenerate"}
    assert (found["name"], found["degenerate"]) == ("flex4", [])
    assert (found["joints"], found["motors"], found["elastic"]) == (
        ["j1", "j2", "j3", "j4"],
        ["j1", "j3"],
        ["j2", "j4"],
    )
    assert "k2" in found["parameters"] and "th1" not in found["parameters"]
    printed = run("show", PRINTED, "--json")
    assert printed.err.startswith("warning: joint 9 (motor_y): slides parallel to joint 5 (motor_x)")
    found = json.loads(printed.out)
    assert len(found["degenerate"]) == 2 and "bed_y" in found["degenerate"][0] and "cart_x" in found["degenerate"][1]


@pytest.mark.thorough
def test_show_prints_the_table(run: Run) -> None:
    ran = run("show", EXAMPLES / "two_axis.toml")
    assert ran.code == 0 and not ran.err and "no degenerate joints" in ran.out
    assert re.search(r"3 +│? *bed_x +│? *2 +│? *elastic +│? *1 +│? *-pi/2", ran.out)
    assert "D12 = 0.15 m" in ran.out
    assert ran.out.count("degenerate: ") == 0
    assert run("show", PRINTED).out.count("\ndegenerate: joint") == 2


@pytest.mark.thorough
def test_the_table_is_plain_where_the_terminal_is(tmp_path: Path) -> None:
    ran = outside("show", TWO_R, folder=tmp_path, PYTHONIOENCODING="ascii", PYTHONUTF8="0")
    assert ran.code == 0 and ran.out.isascii() and "shoulder" in ran.out and not ran.err


def test_warnings_go_to_stderr_and_refuse_nothing(run: Run, tmp_path: Path) -> None:
    machine = edited(TWO_R, tmp_path, "gravity = ", "# gravity = ")
    ran = run("generate", machine, "--json")
    assert ran.code == 0 and len(json.loads(ran.out)["written"]) == 7
    assert ran.err.startswith("warning: no gravity is given") and ran.err.count("\n") == 1


def test_gravity_is_shown_where_the_machine_is(run: Run, tmp_path: Path) -> None:
    """By `show`, in the head of C, and where there is none."""
    assert "gravity: 0, -g0, 0 m/s2 in frame 0" in run("show", TWO_R).out
    assert run("show", TWO_R, "--json").figures["gravity"] == ["0", "-g0", "0"]
    run("generate", TWO_R, "--target", "c", "--out", tmp_path)
    assert "gravity: 0, -g0, 0 m/s2 in frame 0." in (tmp_path / "planar_2r" / "planar_2r.h").read_text()
    weightless = edited(TWO_R, tmp_path, 'gravity = [0, "-g0", 0]', "gravity = [0, 0, 0]")
    ran = run("show", weightless)
    assert "no gravity\n" in ran.out and "gravity" not in ran.err


@pytest.mark.thorough
def test_without_masses_the_models_are_those_of_kinematics(run: Run, tmp_path: Path) -> None:
    """Others are refused in one line, which names them."""
    links = "".join(f'<link name="{name}"/>' for name in ("base", "a", "b"))
    joint = '<joint name="{0}" type="continuous"><parent link="{1}"/><child link="{2}"/><axis xyz="0 0 1"/></joint>'
    robot = f'<robot name="bare">{links}{joint.format("i", "base", "a")}{joint.format("j", "a", "b")}</robot>'
    file = tmp_path / "bare.urdf"
    file.write_text(robot, encoding="utf-8")
    ran = run("generate", file, "--out", tmp_path)
    assert ran.code == 0 and "note: without mass and inertia, the models are geometric_model and jacobian" in ran.err
    assert {"_geometric_model.py", "_jacobian.py"} <= {path.name for path in (tmp_path / "bare").iterdir()}
    assert run("check", file).code == 0
    ran = run("generate", file, "--model", "direct_dynamics", "--out", tmp_path / "more")
    assert ran.code == 2 and "no body has mass or inertia" in ran.err and "inverse_geometric_model" in ran.err


def test_without_arguments_help_is_shown(run: Run) -> None:
    assert run().out == run("--help").out == run("-h").out
    assert all(word in run("--help").out for word in ("generate", "show"))
    assert run("--version").out.startswith("symoro-elastic, version ")


@pytest.mark.thorough
def test_the_same_through_python_m_and_the_entry_point(tmp_path: Path) -> None:
    ran = outside("generate", TWO_R, "--json", folder=tmp_path)
    assert len(ran.figures["written"]) == 7
    ran = outside("generate", "none.toml", folder=tmp_path)
    assert ran == Ran(2, "", "error: none.toml: file: no such file\n")
    from importlib.metadata import entry_points

    (script,) = entry_points(group="console_scripts", name="symoro-elastic")
    assert script.load() is cli.main


@pytest.mark.sampled(5)
@pytest.mark.parametrize("arguments", [["--help"], ["generate", "--help"], ["show", "--help"], ["--version"]])
def test_help_imports_nothing_heavy(arguments: Sequence[str], tmp_path: Path) -> None:
    code = (
        "import sys; from symoro_elastic import cli; sys.argv = sys.argv[1:]\n"
        "try: cli.main()\n"
        "finally: print([m for m in ('numpy', 'sympy', 'jinja2', 'mpmath', 'rich') if m in sys.modules])"
    )
    command = [sys.executable, "-c", code, "symoro-elastic", *arguments]
    ran = subprocess.run(command, capture_output=True, text=True, check=True, cwd=tmp_path)
    assert ran.stdout.splitlines()[-1] == "[]"


# What is refused


@pytest.mark.sampled(2)
@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["generate", "none.toml"], "none.toml: file: no such file"),
        (["generate", "."], ".: file: the suffix '' is not a machine format"),
        (["generate", "machine.txt"], "machine.txt: file: the suffix '.txt' is not a machine format"),
        (["generate"], "symoro-elastic generate: Missing argument 'MACHINE'"),
        (["generate", TWO_R, "--model", "direct_dynamic"], "--model: no model 'direct_dynamic'; did you mean"),
        (["generate", TWO_R, "--target", "fortran"], "--target: unknown 'fortran': choose from numpy, c"),
        (["generate", TWO_R, "--fold", "l9"], "--fold: no parameter 'l9'"),
        (["generate", FLEX4, "--fold", "k2"], "--fold: k2 has no value"),
        (["generate", TWO_R, "--scene", "none.toml"], "none.toml: file: no such file"),
        (["generate", TWO_R, "--colour"], "symoro-elastic generate: No such option"),
        (["make", TWO_R], "symoro-elastic: No such command 'make'"),
        (["generate", PRINTED], "joint 2, joint 3: H2 is zero at every position"),
        (["show", "none.par"], "none.par: file: no such file"),
        (("generate", TWO_R, "--precision", "half"), "unknown 'half': choose from double, single, mixed"),
        (("generate", TWO_R, "--precision", "single", "--target", "numpy"), "--precision: concerns the C code"),
        (
            ("generate", TWO_R, "--precision", "mixed", "--model", "inverse_geometric_model"),
            "--precision double, or leave",
        ),
        (("benchmark", TWO_R, "--tolerance", "nan"), "--tolerance: 'nan' is not a number: nan is not finite"),
        (
            (
                *("excite", TWO_R, "--out", "e.csv", "--position", "-1:1", "--velocity", "3", "--acceleration", "9"),
                *("--value", "nope=1"),
            ),
            "--value: unknown 'nope': choose from g0, m1",
        ),
    ],
)
def test_refused_arguments(arguments: Sequence[object], said: str, run: Run) -> None:
    assert said in refused(run, *arguments)


@pytest.mark.parametrize(
    ("text", "place", "said"),
    [
        ("modells = []", "modells", "did you mean 'models'"),
        ('models = ["dynamics"]', "scene, models", "no model 'dynamics'"),
        ('outputs = { direct_dynamics = ["wrist"] }', "scene, outputs, direct_dynamics", "no joint 'wrist'"),
        ("locked = { wrist = 0 }", "scene, locked", "no joint 'wrist'"),
        ("locked = { tip = 0 }", "scene, locked, tip", "no variable to lock"),
        ('fold = "everything"', "fold", "list of texts"),
        ("gravity = 0", "gravity", "true or false"),
        ("= 3", "line 1, column 1", "not TOML"),
    ],
)
def test_refused_scenes(text: str, place: str, said: str, run: Run, tmp_path: Path) -> None:
    (tmp_path / "view.toml").write_text(text)
    line = refused(run, "generate", TWO_R, "--scene", "view.toml")
    assert line.startswith(f"view.toml: {place}: ") and said in line


def test_refused_outputs(run: Run, tmp_path: Path) -> None:
    (tmp_path / "view.toml").write_text('outputs = { direct_dynamics = ["tip"] }')
    line = refused(run, "generate", TWO_R, "--scene", "view.toml")
    assert "scene, outputs, direct_dynamics: joint 3 (tip) is a fixed frame" in line
    (tmp_path / "view.toml").write_text('outputs = { direct_dynamics = ["q1"] }\nlocked = { shoulder = 1 }')
    assert "joint 1 (shoulder) is locked" in refused(run, "generate", TWO_R, "--scene", "view.toml")


@pytest.mark.parametrize(
    ("old", "new", "place", "said"),
    [
        ('d = "l1"', 'd = "1/(lc1 - lc1)"', "joint 2 (elbow), d", "zero"),
        ('d = "l1"', 'd = "1/(n1 - n1)"', "joint 2 (elbow), d", "divides by zero"),
        ('d = "l1"', 'd = "tan(pi/2)"', "joint 2 (elbow), d", "divides by zero"),
        ('d = "l1"', 'd = "sqrt(n1 - n1 - 1)"', "joint 2 (elbow), d", "square root of a negative"),
        ('d = "l1"', 'd = "1e200"', "joint 2 (elbow), d", "1e+200 is out of range (1e-100 to 1e+50)"),
        ('d = "l1"', "d = \"__import__('os')\"", "joint 2 (elbow), d", "not arithmetic"),
        ('name = "planar_2r"', 'name = "../x"', "name", "'../x' cannot be used"),
        ('name = "planar_2r"', 'name = "/tmp/x"', "name", "'/tmp/x' cannot be used"),
        ('name = "planar_2r"', 'name = "two words"', "name", "'two words' cannot be used"),
    ],
)
def test_refused_machines(old: str, new: str, place: str, said: str, run: Run, tmp_path: Path) -> None:
    text = TWO_R.read_text(encoding="utf-8").replace("[parameters]", "[parameters]\nn1 = nan")
    (tmp_path / TWO_R.name).write_text(text)
    machine = edited(tmp_path / TWO_R.name, tmp_path, old, new)
    line = refused(run, "generate", machine, "--out", tmp_path / "out")
    assert line.startswith(f"{machine}: {place}: ") and said in line


def test_a_par_file_names_no_folder_outside(run: Run, tmp_path: Path) -> None:
    line = "(* Robotname = 'flex4' *)"
    machine = edited(FLEX4, tmp_path, line, f'{line}\n(*toml name = "../flex4" *)')
    assert "flex4" in refused(run, "generate", machine)


def test_an_error_is_one_line_whatever_the_name_of_the_file(run: Run) -> None:
    assert "no such file" in refused(run, "generate", "two\nlines.toml")


# Folders


def test_a_file_in_the_way(run: Run, tmp_path: Path) -> None:
    (tmp_path / "taken").write_text("mine")
    assert refused(run, "generate", TWO_R, "--out", "taken").startswith("taken: --out: is a file")
    (tmp_path / "out").mkdir()
    (tmp_path / "out/planar_2r").write_text("mine")
    assert "out/planar_2r: --out: is a file" in refused(run, "generate", TWO_R, "--out", "out")


@pytest.mark.skipif(not Path("/proc/self").exists(), reason="needs a folder that not even root can write")
def test_an_unwritable_folder(run: Run) -> None:
    line = refused(run, "generate", TWO_R, "--out", "/proc/self")
    assert line.startswith("/proc/self/planar_2r: --out: cannot be written")


def test_a_folder_of_somebody_else(run: Run, tmp_path: Path) -> None:
    (tmp_path / "out/planar_2r").mkdir(parents=True)
    (tmp_path / "out/planar_2r/notes.txt").write_text("mine")
    assert "holds files that were not generated" in refused(run, "generate", TWO_R, "--out", "out")
    (tmp_path / "out/planar_2r" / MANIFEST).write_text("[]")
    assert "is not a list of generated files" in refused(run, "generate", TWO_R, "--out", "out")


def test_regenerating_removes_what_is_stale_and_keeps_what_is_mine(run: Run, tmp_path: Path) -> None:
    folder = tmp_path / "generated/planar_2r"
    assert run("generate", TWO_R).code == 0
    (folder / "notes.txt").write_text("mine")
    (folder / "__pycache__").mkdir()
    assert run("generate", TWO_R, "--target", "c", "--model", "inertia_matrix").code == 0
    left = {p.name for p in folder.iterdir()}
    assert left == {"planar_2r.c", "planar_2r.h", MANIFEST, "notes.txt", "__pycache__"}
    assert (folder / "notes.txt").read_text() == "mine"
    assert "direct_dynamics" not in (folder / "planar_2r.h").read_text()


@pytest.mark.thorough
def test_regenerating_gives_the_same_bytes(run: Run, tmp_path: Path) -> None:
    run("generate", FLEX4)
    before = files_below(tmp_path)
    run("generate", FLEX4, "--target", "c", "--model", "bias_forces")
    run("generate", FLEX4)
    assert files_below(tmp_path) == before


@pytest.mark.parametrize("kind", ["file", "folder", "link"])
def test_my_own_files_are_not_replaced(kind: str, run: Run, tmp_path: Path) -> None:
    """A file of mine in a generated folder that a later target would make."""
    run("generate", TWO_R, "--target", "numpy")
    mine = tmp_path / "generated/planar_2r/planar_2r.c"
    if kind == "file":
        mine.write_text("mine")
    elif kind == "folder":
        mine.mkdir()
    else:
        mine.symlink_to(tmp_path / "nowhere")
    line = refused(run, "generate", TWO_R)
    assert line.startswith("generated/planar_2r/planar_2r.c: --out: was not generated")


@pytest.mark.sampled(12)
@pytest.mark.parametrize(
    "listed", ["../precious.txt", "{folder}/precious.txt", "..", ".", "", "sub/../../precious.txt"]
)
def test_a_list_of_files_that_leads_out_of_the_folder_removes_nothing(listed: str, run: Run, tmp_path: Path) -> None:
    run("generate", TWO_R)
    (tmp_path / "generated/precious.txt").write_text("mine")
    manifest = tmp_path / "generated/planar_2r" / MANIFEST
    manifest.write_text(json.dumps({"files": [listed.format(folder=tmp_path / "generated"), "_runtime.py"]}))
    for name in ("planar_2r.c", "planar_2r.h"):
        (manifest.parent / name).unlink()
    assert run("generate", TWO_R, "--target", "c").code == 0
    assert (tmp_path / "generated/precious.txt").read_text() == "mine"
    assert not (manifest.parent / "_runtime.py").exists() and (manifest.parent / "__init__.py").exists()


def test_a_full_disk_leaves_the_old_files(run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    run("generate", TWO_R)
    before = files_below(tmp_path)
    written: list[Path] = []
    write_bytes = Path.write_bytes

    def full(path: Path, *arguments: Any, **named: Any) -> int:
        written.append(path)
        if len(written) > 3:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        return write_bytes(path, *arguments, **named)

    monkeypatch.setattr(Path, "write_bytes", full)
    ran = run("generate", TWO_R, "--model", "bias_forces")
    assert ran.code == 2 and "cannot be written (No space left on device)" in ran.err
    assert files_below(tmp_path) == before


# Without compilers


def test_generation_needs_no_compiler(tmp_path: Path) -> None:
    assert outside("generate", TWO_R, "--json", folder=tmp_path, PATH="", CC="").code == 0


# Anything at all


@pytest.mark.thorough
def test_damaged_files_are_refused_in_one_line_or_read(run: Run, tmp_path: Path) -> None:
    """Tokens of the examples replaced, lines lost and doubled: exit code 0 or 2, one error line, never a traceback."""
    pieces = ["", "0", "-1", "1e400", "nan", "pi", "q1", "{", "]", "1/0", "tan(pi/2)", "L12", '"', ",", "=", "motor"]
    pieces += ["fixed", "2", "1e200", "M1", "th1", "(*", "*)", "é", "\x00", "[scene]", "1/3"]
    sources = [EXAMPLES / name for name in ("two_axis.toml", "planar_2r.toml", "rx90.par", "flex4.par")]
    codes = []
    for seed in range(250):
        source = random.Random(seed)
        path = source.choice(sources)
        text = path.read_text(encoding="utf-8")
        if source.random() < 0.3:
            lines = text.split("\n")
            lines[source.randrange(len(lines))] = source.choice(lines)
            text = "\n".join(lines)
        else:
            found = source.choice(list(re.finditer(r"[A-Za-z0-9_.]+|[^\sA-Za-z0-9]", text)))
            text = text[: found.start()] + source.choice(pieces) + text[found.end() :]
        (tmp_path / path.name).write_text(text, encoding="utf-8")
        ran = run("generate", path.name, "--target", "c", "--model", source.choice(["inertia_matrix", "bias_forces"]))
        errors = [line for line in ran.err.splitlines() if not line.startswith("warning: ")]
        assert [line.startswith(f"error: {path.name}: ") for line in errors] == [True] * (ran.code == 2), (seed, errors)
        assert bool(errors) != bool(ran.out)
        codes.append(ran.code)
    assert set(codes) == {0, 2} and codes.count(0) > 50


# check and equations

needs_compiler = pytest.mark.skipif(not (shutil.which("gcc") or shutil.which("clang")), reason="needs a C compiler")


@pytest.mark.thorough
@needs_compiler
def test_check_json(run: Run) -> None:
    found = run("check", TWO_R, "--json").figures
    assert found["ok"] is True and found["models"].keys() == {"direct_dynamics", "inverse_dynamics"}
    for errors in found["models"].values():
        assert 0 < errors["numpy"] < 1e-12 and 0 < errors["c"] < 1e-12
    assert list(Path.cwd().iterdir()) == []


@pytest.mark.thorough
@needs_compiler
def test_check_prints_a_table(run: Run) -> None:
    ran = run("check", TWO_R, "--model", "inertia_matrix")
    assert ran.code == 0 and not ran.err
    assert "inertia_matrix" in ran.out and "ok" in ran.out and "direct_dynamics" not in ran.out


@pytest.mark.thorough
@needs_compiler
def test_check_exits_with_1_where_numbers_are_wrong(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    """A sign changed in the printer is noticed in every language."""
    from symoro_elastic.codegen.printers import OPERATORS
    from symoro_elastic.symbolic.operations import ADD, SUBTRACT

    monkeypatch.setitem(OPERATORS, ADD, OPERATORS[SUBTRACT])  # type: ignore[misc]
    ran = run("check", TWO_R, "--json")
    assert ran.code == 1 and json.loads(ran.out)["ok"] is False and ran.err == ""


@pytest.mark.thorough
def test_check_says_what_is_missing(tmp_path: Path) -> None:
    ran = outside("check", TWO_R, "--json", folder=tmp_path, PATH="", CC="")
    assert ran.code == 2 and ran.err.startswith(f"error: {TWO_R}: C compiler: ") and ran.err.count("\n") == 1
    found = json.loads(ran.out)
    assert found["ok"] is False and found["models"]["direct_dynamics"]["c"] is None
    assert found["models"]["direct_dynamics"]["numpy"] < 1e-12


@pytest.mark.sampled(2)
@pytest.mark.parametrize("command", ["check", "equations"])
def test_check_and_equations_refuse(command: str, run: Run) -> None:
    assert "joint 2, joint 3: H2 is zero" in refused(run, command, PRINTED)
    assert "no such file" in refused(run, command, "none.toml")
    assert "no model 'nothing'" in refused(run, command, TWO_R, "--model", "nothing")
    assert "no parameter 'l9'" in refused(run, command, TWO_R, "--fold", "l9")


def test_equations_are_latex_unless_said(run: Run, tmp_path: Path) -> None:
    ran = run("equations", TWO_R, "--model", "inertia_matrix")
    assert ran.code == 0 and ran.err == "" and ran.out.startswith(r"\documentclass")
    assert ran.out.rstrip().endswith(r"\end{document}")
    ran = run("equations", TWO_R, "--model", "inertia_matrix", "--out", "a.tex")
    assert (ran.code, ran.out, ran.err) == (0, "", "wrote a.tex\n")
    assert (tmp_path / "a.tex").read_text(encoding="utf-8").startswith(r"\documentclass")
    assert "choose from latex, html, pdf" in refused(run, "equations", TWO_R, "--format", "docx")
    assert "cannot be written" in refused(run, "equations", TWO_R, "--out", "none/a.tex")


def test_a_parameter_called_like_a_result_or_a_macro_is_no_clash(run: Run, tmp_path: Path) -> None:
    """Generated code avoids the clash: the models are those of the same machine with another name."""
    counts = []
    for name in ("A", "PLANAR_2R_P_l1", "other"):
        machine = edited(TWO_R, tmp_path, "l2  =", f"{name} = 1\nl2  =")
        run_ = run("generate", machine, "--model", "inertia_matrix", "--out", tmp_path / name, "--json")
        assert run_.code == 0
        counts.append(json.loads(run_.out)["models"])
    assert counts[0] == counts[1] == counts[2]


def test_a_model_too_large_for_memory_is_one_line(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    def exhausted(*_: object, **__: object) -> None:
        raise MemoryError

    monkeypatch.setattr("symoro_elastic.generation.pipeline.generate", exhausted)
    assert "not enough memory for so large a model" in refused(run, "generate", TWO_R)
