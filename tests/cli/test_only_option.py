"""Parts of models asked for on the command line and in scene files: what is made of them, what is refused."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from symoro_elastic.formats import read_machine
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.generation.pipeline import generate
from symoro_elastic.machine.scene import Scene
from tests.command_line import refused, run
from tests.generated_code import imported

EXAMPLES = Path(__file__).parents[2] / "examples"
TWO_AXIS, TWO_R = EXAMPLES / "two_axis.toml", EXAMPLES / "planar_2r.toml"
POINT = "elbow at (l2, 0, -l1/2) in base"


def scene(folder: Path, text: str) -> Path:
    (folder / "asked.toml").write_text(text)
    return folder / "asked.toml"


def test_frames_without_a_scene_file(tmp_path: Path) -> None:
    """Beside those that the scene asks for; other models stay whole."""
    file = scene(tmp_path, 'models = ["jacobian", "velocities"]\noutputs = { jacobian = ["shoulder"] }\n')
    run("generate", TWO_R, "--scene", file, "--only", f"jacobian={POINT}", "--only", "jacobian=2", "--out", tmp_path)
    outputs = imported(tmp_path / "planar_2r").OUTPUTS
    assert outputs == {
        "jacobian": {"J": ("shoulder", POINT, "elbow")},
        "velocities": {"V": ("shoulder", "elbow", "tip")},
    }


def test_rows_that_were_chosen_are_in_the_header(tmp_path: Path) -> None:
    asked = ("--model", "jacobian", "--model", "inverse_dynamics", "--model", "bias_forces")
    run("generate", TWO_R, *asked, "--only", f"jacobian={POINT}", "--only", "inverse_dynamics=elbow", "--out", tmp_path)
    header = (tmp_path / "planar_2r" / "planar_2r.h").read_text(encoding="utf-8")
    assert f" *   rows of J: {POINT}\n" in header and " *   rows of tau: elbow\n" in header
    assert "rows of H" not in header and "rows of qdd" not in header


@pytest.mark.thorough
def test_check_and_equations_take_points(tmp_path: Path) -> None:
    found = json.loads(
        run("check", TWO_R, "--model", "geometric_model", "--only", f"geometric_model={POINT}", "--json").stdout
    )
    assert found["ok"] and found["models"]["geometric_model"]["numpy"] < 1e-14
    text = run("equations", TWO_R, "--model", "jacobian", "--only", f"jacobian={POINT}").stdout
    assert "elbow at (l2, 0, -l1/2)" in text


def test_a_narrower_command_line_drops_the_outputs_of_a_scene(tmp_path: Path) -> None:
    file = scene(tmp_path, 'models = ["jacobian", "velocities"]\noutputs = { jacobian = ["shoulder"] }\n')
    run("generate", TWO_R, "--scene", file, "--model", "velocities", "--out", tmp_path)
    assert imported(tmp_path / "planar_2r").OUTPUTS == {"velocities": {"V": ("shoulder", "elbow", "tip")}}


def test_a_wider_command_line_uses_them(tmp_path: Path) -> None:
    file = scene(tmp_path, 'outputs = { jacobian = ["shoulder"] }\n')
    run("generate", TWO_R, "--scene", file, "--model", "jacobian", "--out", tmp_path)
    assert imported(tmp_path / "planar_2r").OUTPUTS == {"jacobian": {"J": ("shoulder",)}}


@pytest.mark.sampled(12)
@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ('outputs = { jacobian = ["tool"] }', "outputs, jacobian: jacobian is not requested: add it to models"),
        (
            'models = ["jacobian"]\noutputs = { jacobian = ["tool at (0, D13)"] }',
            "outputs, jacobian: 'tool at (0, D13)': a",
        ),
        ('models = ["jacobian"]\noutputs = { jacobian = ["tool at (0, 0, D14)"] }', "'D14' is not declared"),
        ('outputs = { inverse_dynamics = ["tool"] }', "outputs, inverse_dynamics: joint 12 (tool) is a fixed frame"),
        ('locked = { ram = "1/0" }', "locked, ram: '1/0' has no value: it divides by zero"),
        ('models = ["jacobian"]\noutputs = { jacobian = ["tool at (sqrt(-1), 0, 1)"] }', "'sqrt(-1)' has no value"),
        ("locked = { ram = 1, 11 = 2 }", "locked: a joint is given twice"),
        ('fold = ["D99"]', "fold: no parameter 'D99'"),
    ],
)
def test_a_bad_scene_file_is_called_by_its_name(text: str, reason: str, tmp_path: Path) -> None:
    file = scene(tmp_path, text + "\n")
    said = refused("generate", TWO_AXIS, "--scene", file, "--out", tmp_path / "out")
    assert said.startswith(f"{file}: scene, ") and reason in said and "\n" not in said
    assert not (tmp_path / "out").exists()


def test_a_parameter_without_value_is_not_folded_by_a_scene_file(tmp_path: Path) -> None:
    said = refused("generate", EXAMPLES / "flex4.par", "--scene", scene(tmp_path, 'fold = ["L2"]\n'), "--out", tmp_path)
    assert said.startswith(f"{tmp_path / 'asked.toml'}: scene, fold: L2 has no value")


@pytest.mark.parametrize(
    ("only", "reason"),
    [
        ("tool", "symoro-elastic: --only: 'tool' is not MODEL=NAME"),
        ("jacobian=", "is not MODEL=NAME"),
        ("jacobien=tool", "two_axis.toml: --only: no model 'jacobien'; did you mean 'jacobian'?"),
        ("jacobian=tol", "two_axis.toml: --only, jacobian: no frame 'tol'"),
        ("jacobian=tool at 1 2 3", "a point has three coordinates in brackets"),
        (
            "velocities=tool",
            "outputs, velocities: velocities is not requested: add it to models (or --model velocities)",
        ),
    ],
)
def test_bad_words_on_the_command_line(only: str, reason: str, tmp_path: Path) -> None:
    assert reason in refused("generate", TWO_AXIS, "--model", "jacobian", "--only", only, "--out", tmp_path)
    assert not list(tmp_path.iterdir())


def test_idle_outputs_are_refused_without_a_command_line_too(tmp_path: Path) -> None:
    machine, _ = read_machine(TWO_R)
    with pytest.raises(InputError, match="velocities is not requested"):
        generate(machine, Scene(("jacobian",), {"velocities": ("elbow",)}), ["c"], tmp_path)
