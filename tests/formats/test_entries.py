"""Rows and keys of TOML files, added and removed: only their lines change, and the examples are machines."""

from __future__ import annotations

import tomllib
from typing import Any

import pytest

from symoro_elastic.foundation.errors import InputError
from tests.command_line import EXAMPLES

pytest.importorskip("tomlkit")

from symoro_elastic.formats.toml.editing import SECTIONS, tables_of
from symoro_elastic.formats.toml.entries import with_entry, without_entry
from symoro_elastic.machine.machine import Kind

TWO_R = (EXAMPLES / "planar_2r.toml").read_text(encoding="utf-8")
OWN_TABLES = """gravity = [0, 0, -9.81] # keep
[[joints]]
name = "a" # first
sigma = 0

[[joints]]
name = "b"
sigma = 0

[bodies]
b = { mass = 1 }
"""


@pytest.mark.parametrize("heading", SECTIONS)
def test_every_key_of_a_table_is_added_with_its_example(heading: str) -> None:
    key = SECTIONS[heading].keys[0]
    added = with_entry(TWO_R, [heading, "new", key.name], "", "file")
    value = tomllib.loads(f"x = {key.example}")["x"]
    assert tomllib.loads(added)[heading]["new"] == {key.name: value}
    assert tomllib.loads(without_entry(added, [heading, "new"], "", "file")) == tomllib.loads(TWO_R)
    assert set(TWO_R.splitlines()) <= set(added.splitlines()), "no other line changes"


@pytest.mark.parametrize("kind", Kind)
@pytest.mark.parametrize("text", [TWO_R, OWN_TABLES], ids=["rows", "tables"])
def test_joints_are_added_last_and_taken_with_their_rows(kind: Kind, text: str) -> None:
    """Whatever a name is, it is a text."""
    name = 'x", kind = "fixed'
    added = with_entry(text, ["joints", name, "kind"], kind.value, "file")
    *rest, last = tomllib.loads(added)["joints"]
    assert rest == tomllib.loads(text)["joints"] and last["name"] == name and last["kind"] == kind
    assert "# keep" in added or text == TWO_R
    added = with_entry(added, ["bodies", name, "mass"], "", "file")
    assert tomllib.loads(without_entry(added, ["joints", len(rest)], "", "file")) == tomllib.loads(text)


def test_gravity_is_added_above_the_tables() -> None:
    without = OWN_TABLES.partition("\n")[2]
    assert tomllib.loads(with_entry(without, ["gravity"], "", "file"))["gravity"] == [0, 0, -9.81]


@pytest.mark.parametrize(
    ("path", "new"),
    [(["gravity"], ""), (["bodies", "b", "mass"], ""), (["joints", "c", "kind"], "wheel"), (["bodies", "b", "no"], "")],
)
def test_what_is_there_or_unknown_is_refused(path: list[Any], new: str) -> None:
    with pytest.raises(InputError):
        with_entry(OWN_TABLES, path, new, "file")


def test_a_joint_stays_where_others_are_numbered() -> None:
    with pytest.raises(InputError, match="write names first"):
        without_entry(
            OWN_TABLES.replace("sigma = 0\n\n[bodies", "sigma = 0\nantecedent = 1\n\n[bodies"),
            ["joints", 0],
            "",
            "file",
        )


def test_tables_have_units_definitions_choices_and_the_names_of_new_rows() -> None:
    tables = {table["heading"]: table for table in tables_of(TWO_R, "file")}
    assert [*tables][:2] == ["gravity", "joints"] and tables["springs"]["rows"] == []
    heads = dict(zip(tables["joints"]["columns"], tables["joints"]["heads"], strict=True))
    assert heads["kind"]["choices"] == [*Kind] and heads["kind"]["meaning"].startswith("what acts on the joint")
    assert heads["d"]["unit"] == "m" and tables["gravity"]["heads"][0]["unit"] == "m/s2"
    assert tables["springs"]["names"] == [row["name"] for row in tables["joints"]["rows"]]
    assert "stiffness" in tables["springs"]["keys"] and tables["parameters"]["names"] == []
