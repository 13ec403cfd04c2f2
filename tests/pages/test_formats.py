"""The reference of the file formats: the page is the rows, and every key of them stands in an example."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from symoro_elastic.analysis.time_series.measurements import NAMED_COLUMNS, NamedColumn, named_columns
from symoro_elastic.formats import read_machine, read_scene
from symoro_elastic.formats.par import syntax as par_syntax
from symoro_elastic.formats.par.keys import KEYS
from symoro_elastic.formats.toml import drives as drive_keys
from symoro_elastic.formats.toml import keys as toml_keys
from symoro_elastic.formats.toml import motion_keys
from symoro_elastic.formats.toml.flexible.beams import BEAMS
from symoro_elastic.formats.toml.flexible.bodies import FLEXIBLE
from symoro_elastic.formats.toml.key import Section
from symoro_elastic.formats.toml.keys import BODY, MACHINE, SCENE, SECTIONS
from symoro_elastic.formats.toml.vibration_tests import TESTS
from symoro_elastic.formats.toml.writing import write
from symoro_elastic.pages.formats import formats_page

ROOT = Path(__file__).parents[2]
EXAMPLES = ROOT / "examples"


def test_the_page_is_up_to_date() -> None:
    page = (ROOT / "docs" / "formats.md").read_text(encoding="utf-8")
    assert page == formats_page(), "symoro-elastic formats > docs/formats.md"


def test_every_row_says_what_it_means() -> None:
    for section in SECTIONS:
        assert section.meaning
        for key in section.keys:
            assert key.meaning, key
            assert key.example or key.type.title.endswith(("table", "tables")), key
            assert key.is_required or key.default_in_words, key
    assert all(key.meaning and key.example and key.default for key in KEYS)


TEST_LISTS = ("lathe_tests/tests.toml", "two_axis_tests/tests.toml")
OF_DRIVE = {
    "current": drive_keys.CURRENT,
    "feed_forward": drive_keys.FEED_FORWARD,
    "limits": drive_keys.LIMITS,
    "set_point": drive_keys.SET_POINT,
}


def used(name: str) -> dict[str, Any]:
    return tomllib.loads((EXAMPLES / name).read_text(encoding="utf-8"))


def tables() -> Iterator[tuple[Section, dict[str, Any]]]:
    """Every table of the examples that show the keys, with its section."""
    examples = ("all_keys", "floating_arm", "linkage", "backlash", "cantilever", "carriage", "spindle")
    for name in (*examples, "flexible_arm", "flexible_gantry"):
        top = used(f"{name}.toml")
        yield MACHINE, top
        yield from ((toml_keys.JOINTS, row) for row in top["joints"])
        yield from ((toml_keys.WITH_UNIT, p) for p in top.get("parameters", {}).values() if isinstance(p, dict))
        for section in toml_keys.OF_JOINTS:
            yield from ((toml_keys.section_of(section), entry) for entry in top.get(section, {}).values())
        for heading, section in toml_keys.OF_CATALOGUES.items():
            yield from ((section, entry) for entry in top.get(heading, {}).values())
        yield from ((toml_keys.LIMITS, entry) for entry in top.get("limits", {}).values())
        yield from ((BEAMS, entry) for entry in top.get("beams", {}).values())
        yield from ((FLEXIBLE, entry) for entry in top.get("flexible", {}).values())
        for drive in top.get("drives", {}).values():
            yield drive_keys.DRIVES, drive
            yield from ((part, drive.get(key, {})) for key, part in OF_DRIVE.items())
            yield from ((drive_keys.FILTERS, entry) for entry in drive.get("filters", ()))
        for section in (toml_keys.LOOPS, toml_keys.FRAMES):
            yield from ((section, entry) for entry in top.get(section.heading[1:-1], {}).values())
        yield toml_keys.BASE, top.get("base", {})
        yield SCENE, top.get("scene", {})
        yield from of_motion(top)
    page = (ROOT / "docs" / "flexible.md").read_text(encoding="utf-8").split("## Tapered beams", 1)[1]
    for entry in tomllib.loads(page.split("```toml", 1)[1].split("```", 1)[0])["beams"].values():
        yield BEAMS, entry
    written = tomllib.loads(write(read_machine(EXAMPLES / "flexible_arm.toml")[0]))
    yield from ((FLEXIBLE, entry) for entry in written["flexible"].values())
    yield SCENE, used("scenes/tool.toml") | used("scenes/puma_within.toml")
    yield from of_motion(used("scenes/two_axis_move.toml"))
    yield from of_motion(used("scenes/ball_screw_drives.toml"))


def of_motion(top: dict[str, Any]) -> Iterator[tuple[Section, dict[str, Any]]]:
    """Tables of a motion, and of what is wanted of it."""
    motion = top.get("motion", {})
    yield motion_keys.MOTION, motion
    yield from ((motion_keys.MOVES, entry) for entry in motion.get("moves", ()))
    yield from ((motion_keys.WOBBLES, entry) for entry in motion.get("wobbles", ()))
    yield from ((motion_keys.SERVO, entry) for entry in motion.get("servo", {}).values())
    yield from ((motion_keys.FORCES, entry) for entry in motion.get("forces", ()))
    yield motion_keys.BASE_START, motion.get("base", {})
    yield motion_keys.WANTED, top.get("wanted", {})


def test_every_key_of_toml_stands_in_an_example() -> None:
    shown = {(section.heading, key) for section, table in tables() for key in table}
    assert shown == {(section.heading, name) for section in SECTIONS for name in section.names}
    assert {key for section, table in tables() if section is BODY for key in table} == {*BODY.names}


def test_every_key_of_scenes_stands_in_an_example() -> None:
    machine, _ = read_machine(EXAMPLES / "all_keys.toml")
    read_scene(EXAMPLES / "scenes" / "tool.toml", machine)
    read_scene(EXAMPLES / "scenes" / "puma_within.toml", read_machine(EXAMPLES / "puma560_measured.toml")[0])
    assert {*used("scenes/tool.toml"), *used("scenes/puma_within.toml")} == {*SCENE.names}


def test_every_key_of_tests_stands_in_an_example() -> None:
    assert {key for name in TEST_LISTS for test in used(name)["tests"] for key in test} == {*TESTS.names}


def test_every_key_of_par_stands_in_an_example() -> None:
    texts = [(EXAMPLES / name).read_text(encoding="utf-8") for name in ("all_keys.par", "four_bar.par")]
    found = [par_syntax.take_apart(text, "") for text in texts]
    shown = {key for one in found for key in (*one.numbers, *one.lists)}
    assert shown == {key.name for key in KEYS}


@pytest.mark.parametrize("column", NAMED_COLUMNS, ids=lambda column: column.name)
def test_columns_are_read_in_the_units_and_by_the_examples_that_are_listed(column: NamedColumn) -> None:
    """Of a joint that turns and of one that slides; the example has another factor."""
    machine, _ = read_machine(EXAMPLES / "all_keys.toml")
    turning, sliding = "table", "slide"
    for name, unit in zip((turning, sliding), (column.unit.split(" or ") * 2)[:2], strict=True):
        header = column.name.replace("<joint>", name).replace("<motor>", name)
        named, warnings = named_columns({f"{header} [{unit}]": np.ones(3)}, machine, "file")
        assert next(iter(named.values())).tolist() == [1.0] * 3 and not warnings
    example = re.sub("elbow|shoulder", turning, column.example)
    named, warnings = named_columns({example: np.ones(3)}, machine, "file")
    assert next(iter(named.values()))[0] not in (0.0, 1.0) and not warnings
