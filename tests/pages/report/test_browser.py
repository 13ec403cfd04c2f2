"""The report in Chromium: no error, nothing wider than the window, tables folded on a phone."""

from __future__ import annotations

import os
import shutil
from pathlib import Path

import pytest

import symoro_elastic as se
from tests.benchmarks.pages import SIZES, chromium, listened, windows
from tests.benchmarks.report_pages import WIDER
from tests.pages.report.test_report import DRIVE

pytestmark = pytest.mark.thorough
pytest.importorskip("playwright")
CHROMIUM = os.environ.get("CHROMIUM") or shutil.which("chromium") or shutil.which("google-chrome")
HEADS = '() => getComputedStyle(document.querySelector(".wide thead")).display'
CELLS = """() => [...document.querySelectorAll(".wide td")].filter((x) => x.checkVisibility()).map((x) => {
  const row = x.closest("tr").getBoundingClientRect(), cell = x.getBoundingClientRect();
  return cell.width / row.width; })"""


@pytest.mark.skipif(CHROMIUM is None, reason="needs Chromium")
def test_tables_fold_and_nothing_is_wider_than_the_window(tmp_path: Path) -> None:
    """On a phone each cell is a line as wide as its table, below no head; on a screen rows are lines."""
    page = tmp_path / "report.html"
    page.write_text(se.report(DRIVE).html, encoding="utf-8")
    with chromium() as browser:
        for size, _, context in windows(browser, SIZES):
            opened = listened(size, context.new_page(), page, (page.as_uri(),))
            opened.page.evaluate('document.querySelectorAll("details").forEach((one) => { one.open = true; })')
            assert opened.page.evaluate(WIDER) <= 0 and opened.wrong == []
            widths = opened.page.evaluate(CELLS)
            is_phone = size == "phone"
            assert (opened.page.evaluate(HEADS) == "none") == is_phone == (min(widths) > 0.95)
