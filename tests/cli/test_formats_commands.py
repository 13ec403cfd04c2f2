"""`new`, `formats`, `schema`, and what the shell completes."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest
from click.shell_completion import ShellComplete

import symoro_elastic as se
from symoro_elastic.cli import cli
from symoro_elastic.formats.toml import reading as toml
from symoro_elastic.formats.toml.starting import STARTS, starting_text
from symoro_elastic.foundation.input_files import SUFFIXES, examples
from symoro_elastic.models.programs.catalogue import MODELS
from symoro_elastic.pages.formats import formats_page
from tests.command_line import EXAMPLES, refused, run


@pytest.mark.sampled(5)
@pytest.mark.parametrize("kind", STARTS)
def test_generate_and_check_take_a_new_machine_as_it_is(kind: str, tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    assert "mine.toml" in run("new", path, "--kind", kind).output
    assert run("generate", path, "--out", tmp_path).exit_code == 0
    assert json.loads(run("check", path, "--json").output)["ok"]


def test_new_never_writes_over_a_file(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    path.write_text("mine")
    assert "mine.toml: NAME: exists already" in refused("new", tmp_path / "mine")
    assert "exists already" in refused("schema", "--out", path) and "exists already" in refused(
        "formats", "--out", path
    )
    assert path.read_text() == "mine"
    run("new", path, "--force")
    assert path.read_text().startswith("# mine: an arm")


def test_new_refuses_unknown_kinds_and_names_that_no_machine_has(tmp_path: Path) -> None:
    assert "choose from arm, cartesian" in refused("new", tmp_path / "mine", "--kind", "tripod")
    assert "letters, digits" in refused("new", tmp_path / "my-machine")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.sampled(2)
@pytest.mark.parametrize("kind", STARTS)
def test_a_full_machine_is_the_usual_one_with_comments(kind: str, tmp_path: Path) -> None:
    """Which say what each key means, and what holds where it is left out."""
    path = tmp_path / "mine.toml"
    whole = toml.read(starting_text("mine", kind, full=True), str(path))
    run("new", path, "--kind", kind)
    lines = path.read_text().splitlines()
    assert [line for line in lines[2:] if line.startswith("#")] == [] and len(lines) < (100 if kind == "delta" else 50)
    assert toml.read(path.read_text(), str(path)) == whole == se.new(path, kind, full=True, force=True)
    text = path.read_text()
    assert not re.search(r"\( or|\.; |default: (lag|notch|of a|with)", text) and "where left out: none" in text


@pytest.mark.sampled(3)
@pytest.mark.parametrize("name", examples())
def test_examples_are_copied(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    source = examples()[name]
    assert f"wrote {source.name}: symoro-elastic " in run("new", "--example", name).output
    run("new", "--example", name, "--force", "mine")
    assert (tmp_path / source.name).read_bytes() == source.read_bytes()
    assert (tmp_path / f"mine{source.suffix}").read_bytes() == source.read_bytes()
    assert "exists already" in refused("new", "mine", "--example", name)
    assert "--full: an example is copied as it is" in refused("new", "other", "--example", name, "--full")
    assert "--kind: an example is copied as it is" in refused("new", "other", "--example", name, "--kind", "arm")


def test_examples_are_named_where_one_is_missing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert {path.name for path in examples().values()} == {
        path.name for path in (*EXAMPLES.iterdir(), *(EXAMPLES / "scenes").iterdir()) if path.suffix in SUFFIXES
    }
    said = "no such file; an example is called so, which symoro-elastic new --example all_keys.par writes"
    assert said in refused("show", "examples/all_keys.par")
    assert "planar_2r_move writes" in refused("simulate", TWO_AXIS, "--scene", "planar_2r_move.toml")
    assert "--example: unknown 'two_axes': choose from all_keys, " in refused("new", "--example", "two_axes")
    assert "NAME: name the file, or an example with --example" in refused("new")
    assert se.new("copy", example="rx90").name == "rx90" and Path("copy.par").is_file()
    with pytest.raises(se.InputError, match="example: unknown 'planar_2r_move'"):
        se.new("scene", example="planar_2r_move")


def test_schemas_and_reference_are_printed() -> None:
    assert json.loads(run("schema").output)["title"].startswith("Machine")
    assert json.loads(run("schema", "scene").output)["title"].startswith("Scene")
    assert json.loads(run("schema", "tests").output)["title"].startswith("Vibration tests")
    assert "choose from machine, scene, tests" in refused("schema", "robot")
    assert run("formats").output == formats_page()


def completed(*words: str) -> list[str]:
    *arguments, begun = words
    found = ShellComplete(cli, {}, "symoro-elastic", "_SYMORO_ELASTIC_COMPLETE").get_completions(arguments, begun)
    return [item.value for item in found]


TWO_AXIS = str(EXAMPLES / "two_axis.toml")


@pytest.mark.parametrize(
    ("words", "values"),
    [
        (("generate", TWO_AXIS, "--model", "inverse_d"), ["inverse_dynamics", "inverse_dynamics_derivatives"]),
        (("generate", TWO_AXIS, "--precision", "d"), ["double", "double-double"]),
        (("generate", TWO_AXIS, "--target", "n"), ["numpy"]),
        (("generate", TWO_AXIS, "--fold", "D"), ["D4", "D12", "D13"]),
        (("equations", TWO_AXIS, "--format", ""), ["latex", "html", "pdf"]),
        (("modes", TWO_AXIS, "--hold", ""), ["motor_x", "motor_y", "all"]),
        (("benchmark", TWO_AXIS, "--plot-format", ""), ["png", "svg", "pdf"]),
        (("generate", TWO_AXIS, "--free", "s"), ["springs"]),
        (("response", "no such file", "--hold", ""), []),
        (("new", "mine", "--kind", "c"), ["cartesian"]),
        (("schema", ""), ["machine", "scene", "tests"]),
    ],
    ids=lambda words: " ".join(words[2:]) if isinstance(words, tuple) else "",
)
def test_values_are_completed(words: tuple[str, ...], values: list[str]) -> None:
    assert [value for value in completed(*words) if value in values or "derivative" not in value] == values


def test_every_option_that_names_a_model_a_target_or_a_motor_is_completed() -> None:
    for command in cli.commands.values():
        for option in command.params:
            if {"--model", "--target", "--hold", "--precision", "--fold"} & {*option.opts}:
                assert option._custom_shell_complete is not None, (command.name, option.opts)
    assert {*completed("equations", TWO_AXIS, "--model", "")} == {*MODELS}


@pytest.mark.thorough
@pytest.mark.parametrize("screws", ["20mm", ""])
def test_slides_pass_what_a_beginner_runs(screws: str, tmp_path: Path) -> None:
    pytest.importorskip("scipy")
    path = tmp_path / "mine.toml"
    run("new", path, "--axes", "X Y Z", *(("--screws", screws) if screws else ()))
    assert toml.read(path.read_text(), str(path)) == se.new(path, axes="X Y Z", screws=screws, force=True)
    assert "every error is within its bound" in run("check", path).output
    assert "limited by" in run("modes", path).output or not screws
    run("view", path, "--out", tmp_path / "mine.html")


def test_slides_are_no_kind_and_screws_need_them(tmp_path: Path) -> None:
    path = tmp_path / "mine"
    assert "--screws: says how the slides" in refused("new", path, "--screws", "20mm")
    assert "--kind: --axes makes" in refused("new", path, "--axes", "X", "--kind", "arm")
    assert "--axes: an example is copied" in refused("new", "--example", "two_axis", "--axes", "X")
    assert "is not a list of axes" in refused("new", path, "--axes", "X Q") and list(tmp_path.iterdir()) == []
