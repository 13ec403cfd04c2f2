"""Scenes: joints by any of their names, and what the machine has not."""

from __future__ import annotations

from pathlib import Path

import pytest

from symoro_elastic.formats import read_scene
from symoro_elastic.formats.par import reading as par
from symoro_elastic.formats.toml import reading as toml
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.scene import ALL, Scene
from symoro_elastic.models.programs.catalogue import MODELS
from tests.machine.samples import TOML

SCENE = """
models = ["direct_dynamics"]
outputs = { direct_dynamics = ["lift", "q1", "3"] }
locked = { q2 = "L2/2" }
fold = ["L2"]
gravity = false
steps = ["w3", "rk4"]
"""


@pytest.fixture
def machine() -> Machine:
    return toml.read(TOML, "arm.toml")


def written(text: str, folder: Path) -> Path:
    (folder / "view.toml").write_text(text)
    return folder / "view.toml"


@pytest.mark.parametrize("head", ["", "[scene]\n"])
def test_names_become_joint_names(head: str, machine: Machine, tmp_path: Path) -> None:
    scene = read_scene(written(head + SCENE, tmp_path), machine)
    assert scene.models == ("direct_dynamics",)
    assert scene.outputs == {"direct_dynamics": ("lift", "base_yaw", "tip")}
    assert {joint: value.text for joint, value in scene.locked.items()} == {"lift": "L2/2"}
    assert (scene.fold, scene.gravity, scene.steps) == (("L2",), False, ("w3", "rk4"))


def test_defaults_and_fold_all(machine: Machine, tmp_path: Path) -> None:
    assert read_scene(written("", tmp_path), machine) == Scene()
    assert read_scene(written('fold = "all"', tmp_path), machine).fold == ALL


def test_a_joint_name_goes_before_the_variable_of_another(tmp_path: Path) -> None:
    machine = toml.read(TOML.replace("base_yaw", "q2"), "arm.toml")
    assert list(read_scene(written("locked = { q2 = 0 }", tmp_path), machine).locked) == ["q2"]


def test_static_joints_by_any_name_each_once(machine: Machine, tmp_path: Path) -> None:
    assert read_scene(written('static = ["q2", "2", "lift"]', tmp_path), machine).static == {"lift": None}


@pytest.mark.parametrize(
    ("text", "place", "reason"),
    [
        ('models = ["direct_dynamic"]', "scene, models", "did you mean 'direct_dynamics'"),
        ('outputs = { dynamics = ["lift"] }', "scene, outputs", "no model 'dynamics'"),
        ('outputs = { jacobian = ["lft"] }', "scene, outputs, jacobian", "did you mean 'lift'"),
        ('outputs = { jacobian = ["4"] }', "scene, outputs, jacobian", "no frame '4'"),
        ('outputs = { jacobian = "lift" }', "outputs, jacobian", "list of texts"),
        ("locked = { lfit = 0 }", "scene, locked", "did you mean 'lift'"),
        ("locked = { lift = 0, q2 = 1 }", "scene, locked", "given twice"),
        ("locked = { tip = 0 }", "scene, locked, tip", "no variable to lock"),
        ('locked = { lift = "L7" }', "scene, locked, lift", "not declared"),
        ('locked = { lift = "a.b" }', "locked, lift", "not arithmetic"),
        ("locked = [1]", "locked", "table"),
        ('static = ["lfit"]', "scene, static", "did you mean 'lift'"),
        ('static = ["base_yaw"]', "scene, static, base_yaw", "the joint is motor: only elastic joints"),
        ('static = ["tip"]', "scene, static, tip", "the joint is fixed: only elastic joints"),
        ('static = ["q2"]\nlocked = { lift = 0 }', "scene, static, lift", "it is locked too: remove one of the two"),
        ("static = { lift = 0, q2 = 1 }", "scene, static", "given twice"),
        ('steps = ["rk5"]', "scene, steps", "no time step 'rk5'; did you mean 'rk4'?"),
        ('fold = ["L3"]', "scene, fold", "no parameter 'L3'"),
        ('fold = "some"', "fold", "list of texts"),
        ("gravity = 0", "gravity", "true or false"),
        ("gravty = false", "gravty", "did you mean 'gravity'"),
        ("[scene]\nx = 1", "scene, x", "no such key"),
        ("gravity = false\n[scene]", "gravity", "no such key"),
        ("gravity = ;", "line 1, column 11", "not TOML"),
    ],
)
def test_what_the_machine_has_not(text: str, place: str, reason: str, machine: Machine, tmp_path: Path) -> None:
    path = written(text, tmp_path)
    with pytest.raises(InputError) as caught:
        read_scene(path, machine, MODELS)
    said = str(caught.value)
    assert said.startswith(f"{path}: {place}: ") and reason in said and "\n" not in said


def test_models_may_be_given(machine: Machine, tmp_path: Path) -> None:
    path = written('models = ["mine"]', tmp_path)
    assert read_scene(path, machine, models={"mine": MODELS["energy"]}).models == ("mine",)
    with pytest.raises(InputError, match="no model 'mine'"):
        read_scene(path, machine, MODELS)


def test_the_scene_of_a_machine_file_is_resolved() -> None:
    text = TOML + "[scene]\nlocked = { 2 = 0.1 }\n"
    assert list(toml.read(text, "arm.toml").asked.scene.locked) == ["lift"]
    with pytest.raises(InputError, match=r"arm\.toml: scene, locked: no joint '9'"):
        toml.read(text.replace("2 = 0.1", "9 = 0.1"), "arm.toml")


def test_a_missing_file(machine: Machine) -> None:
    with pytest.raises(InputError, match=r"none\.toml: file: no such file"):
        read_scene("none.toml", machine)


def test_scene_in_a_par_file() -> None:
    text = "NL = 1\nant = {0}\nsigma = {0}\ntheta = {t1}\nd = {L}\n"
    line = "(*! scene = {models = {jacobian}, outputs = {jacobian = {t1}}, "
    line += "locked = {1 = 2*L}, fold = all, gravity = false} *)"
    scene = par.read(text + line, "").asked.scene
    assert scene.outputs == {"jacobian": ("j1",)} and scene.locked["j1"].text == "2*L"
    assert (scene.fold, scene.gravity) == (ALL, False)
