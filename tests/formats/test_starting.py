"""Files to start from: every kind is a sound machine, and shows every key."""

from __future__ import annotations

import math
import re
from pathlib import Path

import numpy as np
import pytest

import symoro_elastic as se
from symoro_elastic.formats.toml import reading as toml
from symoro_elastic.formats.toml.catalogue import TABLES as OF_CATALOGUES
from symoro_elastic.formats.toml.flexible.bodies import FLEXIBLE, HEADING
from symoro_elastic.formats.toml.keys import OF_JOINTS, SECTIONS
from symoro_elastic.formats.toml.starting import STARTS, start_of_axes, starting_text
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.checks import check
from symoro_elastic.models.bound.joint_axes import placed_machine
from symoro_elastic.models.packaging import reserved_words
from symoro_elastic.models.programs.catalogue import MODELS, trace


@pytest.mark.parametrize("kind", STARTS)
def test_a_start_is_a_sound_machine(kind: str) -> None:
    machine = toml.read(starting_text("machine", kind, full=True), "machine.toml")
    assert check(machine, reserved_words(), MODELS) == []
    assert machine.name == "machine"
    for model in ("direct_dynamics", "inverse_dynamics"):
        assert trace(machine, model).program.outputs


@pytest.mark.parametrize("kind", STARTS)
def test_all_tables_and_keys_are_shown(kind: str) -> None:
    text = starting_text("machine", kind, full=True)
    headings = re.findall(r"^(?:# )?\[(\w+)\]", text, re.MULTILINE)
    asked = ["scene", "motion", "wanted", "extras"]
    parts = [*OF_JOINTS, "guides", "bearings", "screws", "belts", "couplings", "beams"]
    assert headings == ["loops", "frames", "parameters", *parts, "base", "limits", "drives", *asked]
    keys = [key for section in SECTIONS if section is not FLEXIBLE for key in section.keys]
    for key in (key for key in keys if key.name != HEADING):
        assert re.search(rf"\b{key.name}\b", text), key.name
    assert max(map(len, text.splitlines())) <= 120


@pytest.mark.parametrize("kind", STARTS)
def test_options_are_toml_without_their_sign(kind: str) -> None:
    """Each commented table, made active alone, is read."""
    text = starting_text("machine", kind, full=True)
    machine = toml.read(text, "")
    joint, motor = machine.joints[0].name, machine.motor_joints[0].name
    massive = next(one.name for one in machine.joints if not one.body.mass.is_zero)
    springs = [f'"{machine.joint(j).name}"' for j in machine.elastic]
    independent = machine.joints[machine.independent[0] - 1].name
    names = {
        "start = { motor_x": f"start = {{ {independent}",
        "elbow.mass": f"{massive}.mass",
        "joint_name": joint,
        '"pin"': f'"{joint}"',
        '"pin_end"': f'"{joint}"',
        '"q3"': f'"{joint}"',
        'length = "1.2 m"': 'length = "10 mm"',  # no child in the middle of the beam
    }
    names |= {"elbow": joint, "motor_x": motor, "motor_name": motor, '["wrist"]': f"[{', '.join(springs)}]"}
    blocks = text.split("\n\n")
    headings = {k: re.search(r"^# \[(\w+)\]", block, re.MULTILINE) for k, block in enumerate(blocks)}
    options = [k for k, heading in headings.items() if heading and heading[1] not in OF_CATALOGUES]
    assert options
    for k in options:
        active = re.sub(r"^# (?=\[\w+\]$|\w+ = )", "", blocks[k], flags=re.MULTILINE)
        for name, own in {**names, "L2": machine.parameters[0].name}.items():
            active = active.replace(name, own)
        assert toml.read("\n\n".join([*blocks[:k], active, *blocks[k + 1 :]]), "machine.toml") != machine


@pytest.mark.thorough
def test_the_limbs_of_a_delta_are_equal() -> None:
    """Two modes at one frequency, and drives with equal gains."""
    machine = toml.read(starting_text("machine", "delta"), "machine.toml")
    modes = se.modes(machine, hold=["all"])
    assert len(modes.frequencies) == 3 and modes.frequencies[0] == pytest.approx(modes.frequencies[1], rel=1e-9)
    gains = [(drive["Kp"], drive["Kv"]) for drive in se.control(machine).as_json()["drives"]]
    assert len(gains) == 3 and gains[1:] == [pytest.approx(gains[0], rel=1e-3)] * 2


@pytest.mark.parametrize(
    ("axes", "screws"), [("X Y Z", "20mm"), ("zx", ""), ("Y", "1/3"), ("y, z", "0.01"), ("XCZBYA", "20mm"), ("b", "")]
)
def test_axes_from_the_frame_to_the_tool_are_in_order(axes: str, screws: str) -> None:
    machine = toml.read(starting_text("machine", start_of_axes(axes, screws)), "machine.toml")
    check(machine, reserved_words(), MODELS)
    letters = axes.lower().replace(" ", "").replace(",", "")
    assert [one.name for one in machine.motor_joints] == [f"{x}_axis" for x in letters]
    assert [machine.joint(j).name for j in machine.elastic] == [f"{x}_screw" for x in letters if screws and x in "xyz"]
    axes_at_zero = [placed_machine(machine, {}).joints[j - 1].axis for j in machine.motors]
    assert np.allclose(axes_at_zero, [np.eye(3)["xyzabc".index(x) % 3] for x in letters])
    if screws:
        pitch = {"20mm": 0.02, "1/3": 1 / 3, "0.01": 0.01}[screws]
        assert machine.joints[0].ratio.value() == pytest.approx(2 * math.pi / pitch, rel=1e-15)


@pytest.mark.parametrize(
    ("axes", "screws", "what"),
    [
        *(
            ("X W", "", "--axes: 'X W' is not a list"),
            ("", "", "--axes: '' is not a list"),
            ("X X", "", "is not a list of axes"),
        ),
        *(("X", "20", "--screws: '20' is 20 m"), ("X", "-2 mm", "is -0.002 m"), ("X", "2 kg", "where m is needed")),
        *(("X", "p", "--screws: 'p'"), ("X", "__import__('os')", "not arithmetic"), ("X", "nan", "not finite")),
    ],
)
def test_lists_that_are_none_are_refused(axes: str, screws: str, what: str) -> None:
    with pytest.raises(InputError, match=re.escape(what)):
        start_of_axes(axes, screws)


def test_the_page_shows_the_rows_that_new_writes() -> None:
    text = starting_text("mill", start_of_axes("Y X Z", "20mm"))
    rows = text[text.index("joints = [") : text.index("\n]") + 2]
    assert rows in (Path(__file__).parents[2] / "docs" / "index.md").read_text()


def test_the_cartesian_machine_has_the_axes_of_frame_0() -> None:
    import numpy as np

    from symoro_elastic.machine.machine import Joint

    def rotation(joint: Joint) -> np.ndarray:
        c, s = ([f(x.value()) for x in (joint.gamma, joint.alpha, joint.theta)] for f in (np.cos, np.sin))
        about_z = [np.array([[c[k], -s[k], 0], [s[k], c[k], 0], [0, 0, 1]]) for k in (0, 2)]
        return about_z[0] @ np.array([[1, 0, 0], [0, c[1], -s[1]], [0, s[1], c[1]]]) @ about_z[1]

    machine = toml.read(starting_text("machine", "cartesian"), "machine.toml")
    placed, axes = np.eye(3), []
    for joint in machine.joints:
        placed = placed @ rotation(joint)
        axes.append(placed[:, 2])
    assert np.allclose(axes[:3], np.eye(3)) and np.allclose(placed, np.eye(3))


@pytest.mark.thorough
@pytest.mark.parametrize("kind", [kind for kind in STARTS if "drives" in STARTS[kind].tables])
def test_drives_of_a_start_are_tuned_as_written(kind: str) -> None:
    machine = toml.read(starting_text("machine", kind), "machine.toml")
    drives = se.control(machine, damping=0.01).as_json()["drives"]
    assert [drive["motor"] for drive in drives] == [joint.name for joint in machine.motor_joints]
    assert all(drive["Kp"] > 0 and drive["Kv"] > 0 for drive in drives)
