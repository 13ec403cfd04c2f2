"""Files to start from: every kind is a sound machine, and shows every key."""

from __future__ import annotations

import re

import pytest

from symoro_elastic.formats.toml import reading as toml
from symoro_elastic.formats.toml.keys import OF_JOINTS, SECTIONS
from symoro_elastic.formats.toml.starting import STARTS, starting_text
from symoro_elastic.machine.checks import check
from symoro_elastic.models.catalogue import MODELS, trace
from symoro_elastic.models.packaging import reserved_words


@pytest.mark.parametrize("kind", STARTS)
def test_a_start_is_a_sound_machine(kind: str) -> None:
    machine = toml.read(starting_text("machine", kind), "machine.toml")
    assert check(machine, reserved_words(), MODELS) == []
    assert machine.name == "machine"
    for model in ("direct_dynamics", "inverse_dynamics"):
        assert trace(machine, model).program.outputs


@pytest.mark.parametrize("kind", STARTS)
def test_all_tables_and_keys_are_shown(kind: str) -> None:
    text = starting_text("machine", kind)
    headings = re.findall(r"^(?:# )?\[(\w+)\]", text, re.MULTILINE)
    asked = ["scene", "motion", "wanted", "extras"]
    assert headings == ["loops", "parameters", *OF_JOINTS, "base", "limits", "drives", *asked]
    for key in (key for section in SECTIONS for key in section.keys):
        assert re.search(rf"\b{key.name}\b", text), key.name
    assert max(map(len, text.splitlines())) <= 120


@pytest.mark.parametrize("kind", STARTS)
def test_options_are_toml_without_their_sign(kind: str) -> None:
    """Each commented table, made active alone, is read."""
    text = starting_text("machine", kind)
    machine = toml.read(text, "")
    joint, motor = machine.joints[0].name, machine.motor_joints[0].name
    springs = [f'"{machine.joint(j).name}"' for j in machine.elastic]
    names = {"joint_name": joint, '"pin"': f'"{joint}"', '"pin_end"': f'"{joint}"', '"q3"': f'"{joint}"'}
    names |= {"elbow": joint, "motor_x": motor, "motor_name": motor, '["wrist"]': f"[{', '.join(springs)}]"}
    blocks = text.split("\n\n")
    options = [k for k, block in enumerate(blocks) if re.search(r"^# \[\w+\]", block, re.MULTILINE)]
    assert options
    for k in options:
        active = re.sub(r"^# (?=\[\w+\]$|\w+ = )", "", blocks[k], flags=re.MULTILINE)
        for name, own in {**names, "L2": machine.parameters[0].name}.items():
            active = active.replace(name, own)
        assert toml.read("\n\n".join([*blocks[:k], active, *blocks[k + 1 :]]), "machine.toml") != machine


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
