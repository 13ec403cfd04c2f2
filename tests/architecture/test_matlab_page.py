"""Commands and MATLAB blocks of docs/matlab.md, run by GNU Octave, print what the page shows."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

from tests.documented_pages import BLOCK, beside_examples, differences, output, runs
from tests.golden import ROOT
from tests.octave import needs_mkoctfile, needs_octave, run_octave

PAGE = (ROOT / "docs" / "matlab.md").read_text(encoding="utf-8")
NEXT = "@@ next block @@"
BLOCKS = [(text, shown) for (kind, text), (after, shown) in pairwise(BLOCK.findall(PAGE)) if kind == "matlab"]


@needs_octave
@needs_mkoctfile
def test_blocks_print_what_the_page_shows(tmp_path: Path) -> None:
    with beside_examples(tmp_path):
        for run in runs(PAGE):
            output(run)
    text = "\n".join(f"{block}\ndisp('{NEXT}')" for block, _ in BLOCKS)
    printed = run_octave(text, tmp_path).split(NEXT)
    assert len(BLOCKS) >= 5
    assert [pair for (_, shown), out in zip(BLOCKS, printed, strict=False) for pair in differences(shown, out)] == []
