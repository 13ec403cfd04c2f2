"""The commands around the models: convert, models, show with base parameters, --base, identify."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import symoro_elastic as se
from symoro_elastic.formats import read_machine
from symoro_elastic.models.parameters.base_parameters import base_grouping
from symoro_elastic.models.programs.catalogue import MODELS, trace
from symoro_elastic.symbolic.expression import Graph
from symoro_elastic.symbolic.program import Names, Output, Section, build
from tests.command_line import EXAMPLES, refused, run
from tests.generated_code import imported

RX90, TWO_R = EXAMPLES / "rx90.par", EXAMPLES / "planar_2r.toml"
TWO_AXIS = EXAMPLES / "two_axis.toml"


@pytest.mark.sampled(2)
@pytest.mark.parametrize("suffix", ["toml", "par"])
def test_a_machine_converts_to_the_other_format_and_back(suffix: str, tmp_path: Path) -> None:
    there, back = tmp_path / f"rx90.{suffix}", tmp_path / "back" / "rx90.par"
    back.parent.mkdir()
    assert run("convert", RX90, there).exit_code == 0
    assert run("convert", there, back).exit_code == 0
    whole, _ = read_machine(RX90)
    again, _ = read_machine(back)
    assert (again.joints, again.parameters, again.base) == (whole.joints, whole.parameters, whole.base)


def test_nothing_is_overwritten_by_convert(tmp_path: Path) -> None:
    there = tmp_path / "rx90.toml"
    there.write_text("mine")
    assert "exists already" in refused("convert", RX90, there)
    assert there.read_text() == "mine"


@pytest.mark.sampled(2)
@pytest.mark.parametrize("suffix", ["toml", "par"])
def test_the_grouped_machine_is_written_and_read_without_a_warning(suffix: str, tmp_path: Path) -> None:
    there = tmp_path / f"rx90_base.{suffix}"
    assert run("convert", RX90, there, "--base").exit_code == 0
    machine, warnings = read_machine(there)
    assert warnings == []
    kept = base_grouping(read_machine(RX90)[0]).machine
    counts = [trace(m, "inverse_dynamics").program.count for m in (machine, kept)]
    assert counts[0] == counts[1]


@pytest.mark.thorough
def test_base_saves_operations_and_refuses_reaction_wrenches(tmp_path: Path) -> None:
    found = [
        json.loads(run("generate", RX90, "--out", tmp_path / str(k), "--json", *base).stdout)["models"]
        for k, base in enumerate(((), ("--base",)))
    ]
    for model in ("direct_dynamics", "inverse_dynamics"):
        for kind in ("mul", "add"):
            assert found[1][model][kind] < found[0][model][kind]
    assert "not the reaction wrenches" in refused("generate", RX90, "--base", "--model", "reaction_wrenches")


@pytest.mark.thorough
def test_show_takes_values() -> None:
    """Of parameters and of cells, as the other commands do: the tip of the arm is at l1 + l2."""
    shown = run("show", TWO_R, "--value", "l1=2", "--value", "l2=0.5").stdout
    assert "l1 = 2.0 m" in shown and "l2 = 0.5 m" in shown and "lc2 = 0.15 m" in shown
    found = json.loads(run("show", TWO_R, "--value", "l1=2", "--value", "l2=0.5", "--json").stdout)
    assert found["axes"]["tip"]["origin"] == [2.5, 0, 0]
    assert found["base_parameters"]["MXR1"] == "lc1*m1 + l1*m2"
    assert "M = 7.0" in run("show", TWO_AXIS, "--value", "ram.mass=7").stdout
    assert "no parameter 'l9'; did you mean" in refused("show", TWO_R, "--value", "l9=1")


def test_show_gives_base_parameters_as_formulas() -> None:
    found = json.loads(run("show", TWO_R, "--json").stdout)
    assert found["base_parameters"] == {
        "ZZR1": "I1 + lc1^2*m1 + l1^2*m2",
        "MXR1": "lc1*m1 + l1*m2",
        "ZZ2": "I2 + lc2^2*m2",
        "MX2": "lc2*m2",
    }
    assert "as the rank of the regressor" in found["base_parameters_check"]
    assert "hardest to tell apart" in run("show", TWO_R).stdout


def test_every_model_is_listed_with_shape_and_meaning() -> None:
    found = json.loads(run("models", "--json").stdout)["models"]
    assert set(found) == set(MODELS)
    for name, model in found.items():
        assert model["equations"] and model["results"], name
        assert all(shape and meaning for shape, meaning in (*model["arguments"].values(), *model["results"].values()))
    assert all(name in run("models").stdout for name in MODELS)


def test_there_is_no_reference_for_an_inverse_geometric_model() -> None:
    assert "put its solutions back" in refused("check", RX90, "--model", "inverse_geometric_model")


def test_an_elastic_machine_has_no_inverse_geometric_model(tmp_path: Path) -> None:
    line = refused("generate", EXAMPLES / "two_axis.toml", "--model", "inverse_geometric_model", "--out", tmp_path)
    assert "joint 1 (bed_yaw): the joint is elastic" in line
    assert list(tmp_path.iterdir()) == []


@pytest.mark.thorough
def test_identify_recovers_the_planar_arm(tmp_path: Path) -> None:
    """Noise-free measurements at a rich motion give MX2 = lc2 m2 and ZZ2 = I2 + lc2^2 m2 of the file."""
    pytest.importorskip("scipy")
    machine, _ = read_machine(TWO_R)
    run("generate", TWO_R, "--out", tmp_path)
    code = imported(tmp_path / "planar_2r")
    t = np.arange(0, 10, 0.002)
    w = 2 * np.pi * 0.2
    waves = [np.sin(w * t) + 0.4 * np.cos(3 * w * t), np.cos(2 * w * t) + 0.3 * np.sin(5 * w * t)]
    q = np.stack(waves, axis=1)
    qd = np.stack([w * np.cos(w * t) - 1.2 * w * np.sin(3 * w * t),
                   -2 * w * np.sin(2 * w * t) + 1.5 * w * np.cos(5 * w * t)], axis=1)  # fmt: skip
    qdd = np.stack([-w**2 * np.sin(w * t) - 3.6 * w**2 * np.cos(3 * w * t),
                    -4 * w**2 * np.cos(2 * w * t) - 7.5 * w**2 * np.sin(5 * w * t)], axis=1)  # fmt: skip
    tau, _ = code.inverse_dynamics(q, qd, qdd)
    data = tmp_path / "measured.csv"
    table = np.column_stack([t, q, tau])
    np.savetxt(data, table, delimiter=",", header="t,q_shoulder,q_elbow,tau_shoulder,tau_elbow", comments="")
    found = json.loads(run("identify", TWO_R, data, "--json").stdout)["estimates"]
    values = base_grouping(machine).values({p.name: p.value.value() for p in machine.parameters if p.value})
    for label in ("MX2", "ZZ2"):
        match = next(x for name, x in found.items() if name == label or name.startswith(f"{label} "))
        assert match["value"] == pytest.approx(values[label], rel=1e-3)


def test_identify_names_a_missing_column(tmp_path: Path) -> None:
    data = tmp_path / "short.csv"
    data.write_text("t,q_shoulder,q_elbow,tau_shoulder\n0,0,0,0\n")
    assert "tau_elbow: missing" in refused("identify", TWO_R, data)


def scene_file(folder: Path, text: str) -> Path:
    file = folder / "scene.toml"
    file.write_text(text)
    return file


def test_models_say_what_a_frame_in_another_means() -> None:
    """The placement is relative to it; motions are relative to frame 0, in its axes."""
    notes = " ".join(json.loads(run("models", "--json").stdout)["notes"])
    assert "placement of tool relative to ram" in notes and "motion relative to frame 0" in notes
    found = json.loads(run("models", "--json").stdout)["models"]
    for model in ("velocities", "accelerations", "jacobian", "jacobian_dot_qd"):
        assert all("relative to frame 0" in said for _, said in found[model]["results"].values()), model


@pytest.mark.thorough
def test_check_knows_frames_seen_from_others(tmp_path: Path) -> None:
    frames = '"tool in bed_x", "ram", "base in tool"'
    scene = scene_file(tmp_path, f'models = ["geometric_model"]\noutputs = {{ geometric_model = [{frames}] }}\n')
    found = json.loads(run("check", EXAMPLES / "two_axis.toml", "--scene", scene, "--json").stdout)
    assert found["ok"] and found["models"]["geometric_model"]["numpy"] < 1e-14


def test_a_result_of_the_whole_machine_has_no_part_for_a_joint(tmp_path: Path) -> None:
    scene = scene_file(tmp_path, 'models = ["energy"]\noutputs = { energy = ["ram"] }\n')
    assert "leave it out" in refused(
        "generate", EXAMPLES / "two_axis.toml", "--scene", scene, "--out", tmp_path / "out"
    )


def test_one_name_for_two_quantities_is_no_program() -> None:
    graph, names, here = Graph(), Names(), Section("here")
    x, y = graph.symbol("x"), graph.symbol("y")
    names.give(x * y, "H1", here)
    names.give(x + y, "H1", here)
    with pytest.raises(ValueError, match="H1"):
        build((), (Output("f", (2,), (x * y, x + y)),), names)


def test_parameters_without_value_are_one_paragraph(tmp_path: Path) -> None:
    out = run("show", EXAMPLES / "flex4.par").output
    names = [parameter.name for parameter in se.read(EXAMPLES / "flex4.par").parameters]
    assert "no value" not in out and f"\n{len(names)} parameters without value: XX1, XY1, " in out
    paragraph = out.partition("without value: ")[2].partition("\n\n")[0]
    assert " ".join(paragraph.split()).split(", ") == names
    (tmp_path / "one.toml").write_text(TWO_R.read_text().replace("m2  = { value = 1.5,   unit", "m2  = { unit"))
    out = run("show", tmp_path / "one.toml").output
    assert "\na parameter without value: m2\n" in out and "\nI2 = 0.012 kg m2\n" in out
