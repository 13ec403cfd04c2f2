"""A file in the place of another one: the message says what it is, and what goes where."""

from __future__ import annotations

from pathlib import Path

import pytest

import symoro_elastic as se
from symoro_elastic.formats.kinds_of_files import FileKind, kind_of
from tests.command_line import EXAMPLES, refused

MACHINE, PAR = EXAMPLES / "planar_2r.toml", EXAMPLES / "rx90.par"
SCENE = EXAMPLES / "scenes" / "planar_2r_move.toml"
A_TABLE, A_SCENE, A_MACHINE = "a table of a motion or of measurements", "a scene", "a machine"
TABLES = {
    "commas.csv": "t,q_shoulder\n",
    "unit.csv": "t [ms],q_shoulder\n",
    "semicolons.csv": "t;q_shoulder\n",
    "tabs.txt": "t\tq_shoulder\n",
}


@pytest.fixture(autouse=True)
def _in_a_folder_with_tables(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for name, header in TABLES.items():
        (tmp_path / name).write_text(header + "0,1\n" * 1200)
    (tmp_path / "arrays.npz").write_bytes(b"PK\x03\x04")
    monkeypatch.chdir(tmp_path)


@pytest.mark.parametrize("table", [*TABLES, "arrays.npz"])
def test_a_table_in_the_place_of_the_machine(table: str) -> None:
    said = f"{table}: file: is {A_TABLE}, not a machine: give the machine first"
    assert refused("identify", table, MACHINE) == said
    assert refused("show", table) == said
    with pytest.raises(se.InputError, match="give the machine first"):
        se.identify(table, [PAR])


def test_other_files_in_the_place_of_one() -> None:
    assert f"rx90.par: file: is {A_MACHINE}, not {A_TABLE}: " in refused("identify", MACHINE, PAR)
    assert f"planar_2r.toml: file: is {A_MACHINE}, not {A_TABLE}: " in refused("compare", MACHINE, "--motion", MACHINE)
    assert f"move.toml: file: is {A_SCENE}, not a machine: " in refused("simulate", SCENE, "--scene", MACHINE)
    assert f"move.toml: file: is {A_SCENE}, not {A_TABLE}: " in refused("compare", MACHINE, "--motion", SCENE)
    for command in ("simulate", "check", "ladder"):
        assert f"planar_2r.toml: file: is {A_MACHINE}, not a scene: " in refused(command, MACHINE, "--scene", MACHINE)
        assert f"rx90.par: file: is {A_MACHINE}, not a scene: " in refused(command, MACHINE, "--scene", PAR)
        assert f"commas.csv: file: is {A_TABLE}, not a scene: " in refused(command, MACHINE, "--scene", "commas.csv")


def test_a_faulty_file_of_the_right_kind_says_its_fault(tmp_path: Path) -> None:
    (tmp_path / "arm.toml").write_text("joints = [1]\n")
    assert "is a machine" not in refused("show", "arm.toml") and "is a scene" not in refused("show", "arm.toml")
    assert "no such file" in refused("show", "none.csv")
    assert "no joint 'shoulder2'" in refused_scene(tmp_path, SCENE.read_text().replace('"shoulder"', '"shoulder2"'))


def refused_scene(folder: Path, text: str) -> str:
    (folder / "scene.toml").write_text(text)
    return refused("simulate", MACHINE, "--scene", "scene.toml")


def test_every_example_is_what_its_name_says() -> None:
    machines = [path for path in EXAMPLES.iterdir() if path.suffix in (".toml", ".par", ".urdf", ".xml")]
    assert {kind_of(path) for path in machines} == {FileKind.MACHINE} and len(machines) > 10
    assert {kind_of(path) for path in (EXAMPLES / "scenes").iterdir()} == {FileKind.SCENE}
    assert kind_of(EXAMPLES / "none.toml") is None and kind_of(EXAMPLES / "move_axis.py") is None
