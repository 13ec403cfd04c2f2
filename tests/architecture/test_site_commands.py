"""Commands that make the pictures of the site: each runs, and makes what its page shows."""

from __future__ import annotations

import re
import shlex
from pathlib import Path
from xml.etree import ElementTree

import pytest

from docs.site import gallery, guides
from docs.site.commands import Pictured, command_pages
from symoro_elastic.cli.listed import LISTED
from tests.command_line import ended
from tests.documented_pages import beside_examples, runs
from tests.golden import ROOT

pytest.importorskip("matplotlib")
GUIDES = {path.stem: path.read_text(encoding="utf-8") for path in sorted((ROOT / "docs").glob("*.md"))}
OF_GUIDES: dict[str, list[str]] = {}
for text in GUIDES.values():
    for command, names in guides.commands(text).items():
        OF_GUIDES.setdefault(command.removesuffix(" --plot-format svg"), []).extend(names)
RUN_WITH_PAGES = [
    line for text in GUIDES.values() for run in runs(text) for line in run.text.replace("\\\n", " ").splitlines()
]


def commands() -> list[str]:
    """Those that no test of a page runs already, with these options and perhaps more."""
    every = dict.fromkeys([*(one.command for one in gallery.SHOWN), *OF_GUIDES])
    asked = {one: f"symoro-elastic {one.split(' --plots')[0]}" for one in every}
    return [one for one, words in asked.items() if not any(line.startswith(words) for line in RUN_WITH_PAGES)]


@pytest.mark.thorough
def test_every_page_of_a_command_has_an_example_and_no_stray_markup() -> None:
    pages = dict(command_pages())
    assert len(pages) == len(LISTED) + 1
    for name, page in pages.items():
        assert "\\" not in page and ("## Example" in page or name == "commands.md"), name
        for guide in re.findall(r"^More in \[[^\]]+\]\(\.\./(\w+)\.md\)", page, re.MULTILINE):
            assert guide in GUIDES
    made = Pictured("made/drives/lobes.svg", "Stable cutting", "symoro-elastic lobes m.toml")
    assert "](../made/drives/lobes.svg)" in dict(command_pages({"lobes": [made]}))["commands/lobes.md"]


def test_every_picture_that_a_guide_names_is_one() -> None:
    """A comment that is written otherwise would be left on the page."""
    for name, text in GUIDES.items():
        assert text.count("<!-- ") == len(guides.MADE.findall(text)) + len(guides.DRAWN.findall(text)), name


@pytest.mark.thorough
@pytest.mark.parametrize("command", commands())
def test_commands_of_pictures_run(command: str, tmp_path: Path) -> None:
    (tmp_path / "plots").mkdir()
    with beside_examples(tmp_path):
        done = ended(*shlex.split(command), *(["--force"] if "--plots" in command else []))
    assert done.code == 0, done.err
    made = {path.stem for path in tmp_path.rglob("*") if path.suffix in (".svg", ".png", ".html")}
    assert made and {Path(name).stem for name in OF_GUIDES.get(command, ())} <= made
    for path in tmp_path.rglob("*.svg"):
        ElementTree.parse(path)
