"""Commands and programs of docs/robots.md, run from the first to the last, print what the page shows."""

from __future__ import annotations

import re
import sys
from itertools import pairwise
from pathlib import Path

import pytest

from tests.command_line import EXAMPLES
from tests.golden import ROOT
from tests.house.test_scenes_page import Run, differences, output

PAGE = (ROOT / "docs" / "robots.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"^```(\w*)\n(.*?)^```$", PAGE, re.DOTALL | re.MULTILINE)
RUNS = [Run(*block, shown) for block, (kind, shown) in pairwise([*BLOCKS, ("sh", "")]) if block[0] and not kind]


def test_commands_print_what_the_page_shows(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "examples").symlink_to(EXAMPLES)
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(tmp_path)
    for name in [name for name in sys.modules if name.partition(".")[0] == "generated"]:
        monkeypatch.delitem(sys.modules, name)
    assert len(RUNS) == len([kind for kind, _ in BLOCKS if kind]) >= 6
    found = {run.text: differences(run.shown, output(run)) for run in RUNS}
    for name in [name for name in sys.modules if name.partition(".")[0] == "generated"]:
        monkeypatch.delitem(sys.modules, name)
    assert {text: wrong for text, wrong in found.items() if wrong} == {}
