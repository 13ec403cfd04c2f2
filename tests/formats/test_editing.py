"""Cells of TOML files written one by one: nothing else changes, texts stay data, places of messages have lines."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterable, Iterator
from typing import Any

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from symoro_elastic.foundation.errors import InputError
from tests.command_line import EXAMPLES

pytest.importorskip("tomlkit")

from symoro_elastic.formats.toml.editing import MOST_OF_A_CELL, Lines, tables_of, with_cell

ON_ONE_LINE = {
    "{ r = 0 }": "{ r = 0, new = 5 }",
    "{r = 0}": "{r = 0, new = 5}",
    "{ r = 0 , b = [1, 2]  }": "{ r = 0 , b = [1, 2], new = 5  }",
    "{ r = { b = 1 } }": "{ r = { b = 1 }, new = 5 }",
    "{}": "{new = 5}",
}
"""Tables, and what they are with a new entry."""
FILES = sorted(EXAMPLES.glob("*.toml"))
ODD = """# odd
springs.b.stiffness = 8   # dotted
[springs.a]\r
stiffness = "8 N/um" # crlf\r

[[joints]] # one
name = "a"
d = { value = 350, unit = "mm" } # [x]

  [[joints]]
  'name' = "b"  # "quoted"
  r = [ # not a cell
    1, # first
    2
  ]

[bodies."c # d"]
mass = 1_000
center_of_mass = [ 0,
   1e-3, # second
   'x' ]
"""


def leaves(x: Any) -> Iterator[tuple[list[Any], str]]:
    """Paths and texts of the cells of tables."""
    if "parts" in x:
        for part in x["parts"]:
            yield from leaves(part)
    elif "path" in x:
        yield x["path"], x["text"]


def cells(text: str) -> list[tuple[list[Any], str]]:
    rows = (cell for table in tables_of(text, "file") for row in table["rows"] for cell in row["cells"])
    return [leaf for cell in rows for leaf in leaves(cell)]


def at(entries: Any, path: list[Any], new: Any = None) -> Any:
    """The value of a path in tables, replaced where a new one is given."""
    *front, last = path
    for key in front:
        entries = entries[key]
    if new is not None:
        entries[last] = new
    return entries[last] if isinstance(entries, list) or last in entries else None


TEXTS = {**{path.stem: path.read_text(encoding="utf-8") for path in FILES}, "odd": ODD}
QUICK = ("planar_2r", "ball_screw_rigid", "odd")


def each(names: Iterable[str]) -> list[Any]:
    """Names of texts, small ones in the test command."""
    return [pytest.param(name, marks=[] if name in QUICK else [pytest.mark.thorough]) for name in names]


@pytest.mark.parametrize("truth", ["true", "false"])
def test_truths_are_shown_as_they_are_written(truth: str) -> None:
    """Otherwise a cell that is confirmed as it is shown would become a text."""
    text = f"[drives]\nm = {{ Kv = 5, Kp = 3, feed_forward = {{ torque = {truth} }} }}\n"
    ((path, shown),) = [leaf for leaf in cells(text) if "torque" in leaf[0]]
    assert shown == truth and with_cell(text, path, shown, "file") == text


@pytest.mark.sampled(12)
@pytest.mark.parametrize("name", each(TEXTS))
def test_every_cell_is_written_alone(name: str) -> None:
    """Compared with what tomllib reads; in the text, one line at most changes, and no comment of it."""
    text = TEXTS[name]
    found = cells(text)
    assert len(found) > 4
    for path, shown in found:
        written = with_cell(text, path, "4.50e-3", "file")
        wanted = tomllib.loads(text)
        old = at(wanted, path)
        at(wanted, path, 4.5e-3)
        assert str(tomllib.loads(written)) == str(wanted), path
        assert shown == ("" if old is None else shown)
        assert shown in ("", str(old), str(old).lower()) or float(shown) == float(old)
        before, after = text.splitlines(), written.splitlines()
        assert len(after) - len(before) <= (old is None)
        changed = [k for k, line in enumerate(after) if line not in before]
        assert len(changed) == 1 and "4.50e-3" in after[changed[0]], path
        comment = re.search(r"#[^\"']*$", after[changed[0]])
        assert comment is None or comment[0].strip() in text


def test_truths_stay_truths() -> None:
    text = TEXTS["all_keys"]
    changed = tomllib.loads(with_cell(text, ["drives", "table", "feed_forward", "torque"], "false", "file"))
    assert changed["drives"]["table"]["feed_forward"]["torque"] is False


def test_cells_of_loops_limits_and_drives_are_among_them() -> None:
    """Those within tables and lists of a row, too; each is written with the comments beside it."""
    found = [path for name in ("all_keys", "linkage") for path, _ in cells(TEXTS[name])]
    for path in (
        ["loops", "parallelogram", "start", "qm"],
        ["loops", "parallelogram", "dependent", 1],
        ["limits", "table", "position", 1],
        ["limits", "gear", "torque"],
        ["drives", "table", "Kp"],
        ["drives", "shoulder", "current", "lag"],
        ["drives", "table", "filters", 0, "depth"],
    ):
        assert path in found


@given(st.text(max_size=40) | st.floats(allow_nan=False, allow_infinity=False).map(repr) | st.integers().map(str))
@example("9007199254740993")  # no number of floating point
@example("false")
@settings(max_examples=60, deadline=None)
def test_what_is_typed_becomes_a_number_or_a_text_and_nothing_else(typed: str) -> None:
    try:
        written = with_cell(ODD, ["joints", 0, "d", "value"], typed, "file")
    except InputError:
        assert not typed.strip() or not typed.strip().isprintable() or len(typed) > MOST_OF_A_CELL
        return
    wanted = tomllib.loads(ODD)
    value = at(tomllib.loads(written), ["joints", 0, "d", "value"])
    at(wanted, ["joints", 0, "d", "value"], value)
    assert tomllib.loads(written) == wanted
    if isinstance(value, str | bool):
        assert (value if isinstance(value, str) else str(value).lower()) == typed.strip()
    else:
        assert value == type(value)(typed)


NO_CELLS: list[list[Any]] = [
    *(["odd"], ["springs"], ["springs", "a"], ["springs", "new", "x"], ["joints", 2, "d"], ["joints", -1, "d"]),
    *(["joints", 0, "d"], ["joints", 1, "r"], ["joints", 1, "r", 2], ["joints", "name"], ["joints", 0, "name", "x"]),
]


@pytest.mark.parametrize("path", NO_CELLS, ids=str)
def test_tables_and_lists_are_not_replaced(path: list[Any]) -> None:
    with pytest.raises(InputError, match="change it in an editor"):
        with_cell(ODD, path, "1", "file")


def test_places_of_messages_have_lines() -> None:
    text = TEXTS["two_axis"]
    lines, rows = Lines(text, "file"), text.splitlines()

    def line(begin: str) -> int:
        return next(k for k, row in enumerate(rows, start=1) if row.lstrip().startswith(begin))

    springs = rows.index(next(row for row in rows if row.startswith("[springs]")))
    for place, wanted in {
        "joint 3 (bed_x), alpha": line('{ name = "bed_x"'),
        "joint 13 (sensor_head)": line('{ name = "sensor_head"'),
        "joint 3 (bed_x), mass": line("bed_x "),
        "joint 3 (bed_x), stiffness": springs + 1 + [row.split(" ")[0] for row in rows[springs:]].index("bed_x"),
        "parameters, D12": line("D12"),
        "gravity": line("gravity"),
        "limits, motor_x": line("motor_x         = { position"),
        "drives, motor_y, Kv": line("motor_y = { Kv"),
        "line 7, column 3": 7,
    }.items():
        assert lines.of(place) == wanted, place
    for place in ("", "scene, models", "joint 99 (x), d", "computing"):
        assert lines.of(place) is None
    assert Lines("not toml [", "file").of("gravity") is None


@pytest.mark.parametrize("name", each(["ball_screw_rigid", "two_axis"]))
def test_every_cell_has_its_line(name: str) -> None:
    """The line of a cell is the one that a change of the cell changes."""
    text = TEXTS[name]
    lines, rows = Lines(text, "file"), text.splitlines()
    joints = tomllib.loads(text)["joints"]
    for path, _ in cells(text):
        if path[0] in ("springs", "bodies") or path[:2] in (["joints", 0], ["joints", 12]):
            joint = joints[path[1]]["name"] if path[0] == "joints" else path[1]
            number = next(k for k, one in enumerate(joints, start=1) if one["name"] == joint)
            after = with_cell(text, path, "4.50e-3", "file").splitlines()
            (changed,) = (k for k, row in enumerate(after, start=1) if row != rows[k - 1])
            assert lines.of(f"joint {number} ({joint}), {path[2]}") == changed


def test_a_message_about_a_strange_key_is_one_line() -> None:
    for path in (["nothing", 'x"y\n'], ["joints", 99, "a" * 500], ["x\x1b[2J", "y"]):
        with pytest.raises(InputError) as refused:
            with_cell(ODD, path, "1", "f.toml")
        assert str(refused.value).isprintable() and len(str(refused.value)) < 200


@pytest.mark.parametrize("before", ON_ONE_LINE)
def test_a_new_entry_leaves_the_blanks_before_the_end_of_a_table(before: str) -> None:
    text = f"[bodies]\narm = {before}  # x\nhand = {before}\n"
    assert with_cell(text, ["bodies", "arm", "new"], "5", "file") == text.replace(before, ON_ONE_LINE[before], 1)
