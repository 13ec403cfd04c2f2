"""A format is one object: a toy format, added here, is read by every command and refused by none but `convert`."""

from __future__ import annotations

from pathlib import Path

import click
import pytest
from click.testing import CliRunner

from symoro_elastic.cli import cli
from symoro_elastic.cli.options import OutputFile
from symoro_elastic.formats import FORMATS, Format, read_machine, reading, write_machine
from symoro_elastic.formats.toml import reading as toml
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.format_names import FORMAT_NAMES, FormatName, in_words, suffixes
from symoro_elastic.machine.machine import Machine

HEAD = "toy\n"
PLANAR_2R = Path(__file__).parents[2] / "examples" / "planar_2r.toml"


def read_toy(text: str, source: str) -> Machine:
    """A line `toy`, then the machine as TOML."""
    if not text.startswith(HEAD):
        raise InputError(source, "line 1", "no toy")
    return toml.read(text.removeprefix(HEAD), source)


@pytest.fixture(autouse=True)
def toy(monkeypatch: pytest.MonkeyPatch) -> Format:
    form = Format(FormatName("toy", (".toy", ".plaything")), read_toy)
    monkeypatch.setattr(reading, "FORMATS", (*FORMATS, form))
    return form


@pytest.fixture
def arm(tmp_path: Path) -> Path:
    path = tmp_path / "arm.toy"
    path.write_text(HEAD + PLANAR_2R.read_text(encoding="utf-8"), encoding="utf-8")
    return path


def run(*words: object) -> tuple[int, str, str]:
    result = CliRunner().invoke(cli, list(map(str, words)), standalone_mode=False)
    if isinstance(result.exception, InputError):
        return 2, result.stdout, str(result.exception)
    assert result.exception is None or isinstance(result.exception, SystemExit), result.exception
    return result.exit_code, result.stdout, result.stderr


COMMANDS = {
    name: command for name, command in cli.commands.items() if any(one.name == "machine" for one in command.params)
}


def needed(command: click.Command, machine: Path) -> list[object]:
    """What a command cannot do without."""
    words: list[object] = [machine if one.name == "machine" else written(one.type) for one in arguments(command)]
    for one in command.params:
        if isinstance(one, click.Option) and one.required:
            words += [
                one.opts[0],
                written(one.type) if isinstance(one.type, click.Path) else "1,1,1" if one.metavar == "X,Y,Z" else "1",
            ]
    return words


def written(path: click.ParamType) -> str:  # type: ignore[type-arg]
    """A name that the path of a command may have."""
    return f"x{path.forms[0]}" if isinstance(path, OutputFile) else "x.csv"


def arguments(command: click.Command) -> list[click.Argument]:
    return [one for one in command.params if isinstance(one, click.Argument)]


@pytest.mark.parametrize("name", sorted({*COMMANDS} - {"live"}))  # which shows an error, and follows the file
def test_every_command_reads_a_machine_of_any_format(name: str, tmp_path: Path) -> None:
    """The reader of the toy format refuses the file."""
    broken = tmp_path / "broken.plaything"
    broken.write_text("play")
    assert run(name, *needed(COMMANDS[name], broken)) == (2, "", f"{broken}: line 1: no toy")


def test_a_format_that_is_read_only_is_enough_to_generate(arm: Path, tmp_path: Path) -> None:
    assert read_machine(arm)[0].joints == read_machine(PLANAR_2R)[0].joints
    code, out, _ = run("generate", arm, "--target", "numpy", "--out", tmp_path / "out")
    assert code == 0 and out.startswith(f"wrote {tmp_path}/out/planar_2r: __init__.py")
    code, _, _ = run("convert", arm, tmp_path / "arm.toml")
    assert code == 0 and read_machine(tmp_path / "arm.toml")[0].joints == read_machine(arm)[0].joints


def test_convert_to_a_read_only_format_is_refused_in_one_line(arm: Path, tmp_path: Path) -> None:
    target = tmp_path / "other.toy"
    code, out, error = run("convert", arm, target)
    assert (code, out) == (2, "") and not target.exists()
    assert error == f"{target}: FILE: toy files can be read, but not written: use .toml, .par, .urdf or .xml"


def test_unknown_suffixes_name_the_known_ones(tmp_path: Path) -> None:
    machine, _ = read_machine(PLANAR_2R)
    with pytest.raises(InputError, match=r"the suffix '\.json' is not a machine format: use .*, \.toy or \.plaything"):
        read_machine(tmp_path / "arm.json")
    with pytest.raises(InputError, match=r"the suffix '\.json' is not a machine format"):
        write_machine(machine, tmp_path / "arm.json")


def test_help_knows_every_format_and_which_are_written() -> None:
    assert tuple(form.named for form in FORMATS) == FORMAT_NAMES
    assert [form.named for form in FORMATS if form.describe] == [form for form in FORMAT_NAMES if form.is_robot]
    assert [form.named for form in FORMATS if form.write] == [form for form in FORMAT_NAMES if form.is_written]
    assert suffixes() == tuple(suffix for form in FORMATS for suffix in form.suffixes)
    help_, converting = (" ".join(run(*words, "--help")[1].replace("-\n", "-").split()) for words in ((), ("convert",)))
    assert f"({', '.join(suffixes())})" in help_ and f"ends in {' or '.join(suffixes(written=True))}." in converting


def test_lists_are_written_as_in_english() -> None:
    assert in_words([".toml", ".par", ".urdf"]) == ".toml, .par or .urdf"
    assert in_words([".toml", ".par"], "and") == ".toml and .par" and in_words(["one"]) == "one"


def test_suffixes_belong_to_one_format_each() -> None:
    suffixes = [suffix for form in FORMATS for suffix in form.suffixes]
    assert len(set(suffixes)) == len(suffixes) and all(suffix == suffix.lower() for suffix in suffixes)
