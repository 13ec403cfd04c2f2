"""The picture of docs/live.md: `python -m tests.benchmarks.live_picture FILE.png` serves two_axis and looks at it.

Needs the extra live, playwright, and a Chromium that it finds, or whose path is in the variable CHROMIUM.
"""

from __future__ import annotations

import subprocess
import sys

from tests.benchmarks.pages import FLAGS
from tests.command_line import EXAMPLES
from tests.pages.live.test_browser import CHROMIUM


def main(file: str) -> None:
    """Write the picture: 1200 x 680 px, light."""
    from playwright.sync_api import sync_playwright

    line = [sys.executable, "-m", "symoro_elastic", "live", str(EXAMPLES / "two_axis.toml")]
    with subprocess.Popen(line, text=True, stdout=subprocess.PIPE) as process, sync_playwright() as playwright:
        assert process.stdout
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=list(FLAGS))
        page = browser.new_page(viewport={"width": 1200, "height": 680}, color_scheme="light")
        page.goto(process.stdout.readline().strip())
        page.wait_for_selector("body[data-modes=true]")
        page.screenshot(path=file)
        browser.close()
        process.terminate()


if __name__ == "__main__":
    main(sys.argv[1])
