"""Machines saved into the text of the file that they came from: values change, comments and order stay."""

from __future__ import annotations

import re
import tomllib
from dataclasses import replace
from pathlib import Path
from shutil import copy

import pytest

import symoro_elastic as se
from symoro_elastic.formats import write_machine
from symoro_elastic.formats.toml import reading as toml
from symoro_elastic.machine.described import DescribedMachine
from symoro_elastic.machine.named_cells import with_named_cells, with_values
from tests.command_line import EXAMPLES, run

pytest.importorskip("tomlkit")

FILES = sorted(EXAMPLES.glob("*.toml"))
CHANGED = ("stiffness", "damping", "mass", "viscous")
COMMENTED = """# a drive
name = "drive"  # of the shop
[[joints]]  # one
name = "motor"
kind = "motor"
sigma = 0
theta = "m"
[[joints]]
name = "load" # two
kind = "elastic"
sigma = 0
theta = "e"
[springs] # from the catalogue
# a catalogue of 1998
load = { stiffness = "3 kN m/rad", damping = 4 } # soft
[bodies]
load = { mass = 2, inertia_at_origin = [ # about the frame
  0.1, 0.2, # measured
  0.3 ] }
motor = { mass = { value = 1, unit = "kg" } }
"""


def saved(machine: DescribedMachine, path: Path, like: Path) -> str:
    assert write_machine(machine, path, like) == ""
    text = path.read_text(encoding="utf-8")
    assert toml.write(toml.read(text, str(path))) == toml.write(machine)
    return text


def comments(text: str) -> list[str]:
    return re.findall(r"#[^\n\"]*$", text, re.MULTILINE)


@pytest.mark.sampled(3)
@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_every_example_keeps_its_text_but_for_what_changed(path: Path, tmp_path: Path) -> None:
    machine = se.read(path, warn=lambda _: None)
    numbers = {p.name: float(p.value.value()) for p in with_named_cells(machine).parameters if p.value is not None}
    of_parts = {f"{spring.joint}.stiffness" for spring in machine.origin.catalogue_springs}
    rows = {row["name"] for row in tomllib.loads(path.read_text(encoding="utf-8"))["joints"]}
    named = {name: name.rpartition(".") for name in numbers.keys() - of_parts}
    values = {name: 1.1 * numbers[name] for name, (row, _, key) in named.items() if row in rows and key in CHANGED}
    copy(EXAMPLES / "bracket.npz", tmp_path)
    text, old = saved(with_values(machine, values), tmp_path / path.name, path), path.read_text(encoding="utf-8")
    assert comments(text) == comments(old)
    pairs = list(zip(old.splitlines(), text.splitlines(), strict=True))
    same = [a == b for a, b in pairs]
    assert sum(same) >= len(same) - len(values)
    assert (text == old) == (not values)


def test_units_comments_and_parts_of_lists(tmp_path: Path) -> None:
    like = tmp_path / "drive.toml"
    like.write_text(COMMENTED, encoding="utf-8")
    machine = se.read(like)
    text = saved(with_values(machine, {"load.stiffness": 2500.5, "motor.mass": 1.5}), tmp_path / "new.toml", like)
    changed = COMMENTED.replace('"3 kN m/rad"', "2500.5").replace('{ value = 1, unit = "kg" }', "1.5")
    assert text == changed
    more = replace(machine, origin=replace(machine.origin, notes=("found",)))
    assert comments(saved(more, tmp_path / "more.toml", like)) == comments(COMMENTED)


def test_a_file_without_a_name_gets_that_of_the_machine(tmp_path: Path) -> None:
    like = tmp_path / "drive.toml"
    like.write_text(COMMENTED.replace('name = "drive"  # of the shop\n', ""), encoding="utf-8")
    text = saved(se.read(like), tmp_path / "fitted.toml", like)
    assert tomllib.loads(text)["name"] == "drive"


def test_what_does_not_fit_is_written_anew_and_said(tmp_path: Path) -> None:
    """Another table of joints, and a file that is no TOML, has no comments to keep."""
    like = tmp_path / "drive.toml"
    like.write_text(COMMENTED, encoding="utf-8")
    with pytest.warns(se.MachineWarning, match="comments and order of .*drive.toml are not kept: what changed"):
        se.write(EXAMPLES / "planar_2r.toml", tmp_path / "other.toml", like=like)
    assert se.read(tmp_path / "other.toml").name == "planar_2r"
    assert write_machine(se.read(like), tmp_path / "drive.par", like) == ""


@pytest.mark.thorough
def test_the_scene_of_a_ladder_keeps_its_comments(tmp_path: Path) -> None:
    scene, out = EXAMPLES / "scenes" / "planar_2r_move.toml", tmp_path / "reduced.toml"
    run("ladder", EXAMPLES / "planar_2r.toml", "--scene", scene, "--save", out)
    old, text = scene.read_text(encoding="utf-8"), out.read_text(encoding="utf-8")
    assert old in text and 'steps = ["rodas4"]' in text
