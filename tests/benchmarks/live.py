"""The live page of two_axis in Chromium: `python -m tests.benchmarks.live [--saves 10] [--picture docs/live.png]`.

How long it takes from a save to the picture: by the clock, and of it the processor time of the server, up to the
picture, and of the page (its main thread). Needs the extra live, playwright, and a Chromium that it finds, or whose
path is in the variable CHROMIUM.
"""

from __future__ import annotations

import argparse
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

from symoro_elastic.pages.live.parts import parts_of_file
from tests.benchmarks.pages import FLAGS
from tests.benchmarks.tables import print_table
from tests.command_line import EXAMPLES
from tests.pages.live.test_browser import CHROMIUM

STIFFNESS = "stiffness = 4.0e7"


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m tests.benchmarks.live", description=__doc__)
    parser.add_argument("--saves", type=int, default=10)
    parser.add_argument("--picture", type=Path, help="what the page looks like, 1200 x 680 px, light")
    asked = parser.parse_args()
    from playwright.sync_api import sync_playwright

    with tempfile.TemporaryDirectory() as folder, sync_playwright() as playwright:
        path = Path(shutil.copy(EXAMPLES / "two_axis.toml", folder))
        line = [sys.executable, "-m", "symoro_elastic", "live", str(path)]
        with subprocess.Popen(line, text=True, stdout=subprocess.PIPE) as process:
            assert process.stdout
            browser = playwright.chromium.launch(executable_path=CHROMIUM, args=list(FLAGS))
            page = browser.new_page(viewport={"width": 1200, "height": 680}, color_scheme="light")
            page.goto(process.stdout.readline().strip())
            page.wait_for_selector("body[data-modes=true]")
            if asked.picture:
                page.screenshot(path=asked.picture)
            found = [saved(page, path, k) for k in range(asked.saves)]
            browser.close()
            process.terminate()
    rows = [
        [name, *(f"{pick(x):.2f}" for pick in (min, median, max))]
        for name, x in zip(NAMES, zip(*found, strict=True), strict=True)
    ]
    print_table("From a save to the picture, s", ["of", "least", "median", "most"], rows)


NAMES = ("clock", "processor time of the server", "processor time of the page")


def saved(page: Any, path: Path, k: int) -> tuple[float, float, float]:
    """Save the file with another stiffness, and wait for its picture."""
    text = (
        (EXAMPLES / "two_axis.toml").read_text(encoding="utf-8").replace(STIFFNESS, f"stiffness = {4.1 + k / 10:.1f}e7")
    )
    metrics = page.context.new_cdp_session(page)
    metrics.send("Performance.enable", {"timeDomain": "threadTicks"})
    before, shown = worked(metrics), page.get_attribute("body", "data-shown")
    begin = time.perf_counter()
    path.write_text(text, encoding="utf-8")
    page.wait_for_function("(before) => document.body.dataset.shown !== before", arg=shown)
    clock, in_page = time.perf_counter() - begin, worked(metrics) - before
    page.wait_for_selector("body[data-modes=true]")
    begin = time.process_time()
    next(part for part in parts_of_file(str(path), text.encode()) if part.name == "picture")
    return clock, time.process_time() - begin, in_page


def worked(metrics: Any) -> float:
    """Seconds that the main thread of a page has worked."""
    return next(
        float(one["value"])
        for one in metrics.send("Performance.getMetrics")["metrics"]
        if one["name"] == "TaskDuration"
    )


def median(times: tuple[float, ...]) -> float:
    return sorted(times)[len(times) // 2]


if __name__ == "__main__":
    main()
