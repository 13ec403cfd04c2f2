"""Reports in Chromium: no error, no request, nothing wider than the window, images described, definitions shown.

`python -m tests.benchmarks.report_pages FOLDER [NAME ...]` writes the reports and what they look like to a folder.
Needs what `tests.benchmarks.pages` needs.
"""

from __future__ import annotations

import os
import shutil
import sys
from pathlib import Path
from typing import Any

from tests.benchmarks.pages import FLAGS, MACHINES, NAMELESS, SCHEMES, SIZES, Opened
from tests.command_line import ended

WINDOWS = [(size, *extent, scheme) for size, extent in {**SIZES, "small": (1000, 800)}.items() for scheme in SCHEMES]
A4 = (688, 973)
"""Pixels within the margins of a sheet."""
MOVES = """() => [...document.querySelectorAll(".wide")].filter((x) => x.scrollWidth > x.clientWidth + 1)
  .map((x) => x.getAttribute("aria-label"))"""
"""Tables that are moved sideways."""
BARE = '() => [...document.querySelectorAll("img")].filter((x) => !x.alt || !x.naturalWidth).length'
WIDER = "document.documentElement.scrollWidth - document.documentElement.clientWidth"


def opened_report(name: str, page: Any, file: Path) -> Opened:
    """Open a report; errors of scripts and requests are wrong."""
    opened = Opened(name, page, [])
    page.on("console", lambda m: opened.expect(m.type != "error", f"console: {m.text[:200]}"))
    page.on("pageerror", lambda error: opened.wrong.append(f"script: {str(error)[:200]}"))
    page.on("request", lambda r: opened.expect(r.url.startswith(("data:", file.as_uri())), f"request: {r.url[:80]}"))
    page.goto(file.as_uri())
    return opened


def check_report(opened: Opened) -> None:
    """Widths, names, pictures; a symbol shows its definition, a click leads to it."""
    page = opened.page
    wide = page.evaluate(WIDER)
    opened.expect(wide <= 0, f"{wide} px wider than the window")
    nameless, bare = page.evaluate(NAMELESS), page.evaluate(BARE)
    opened.expect(not nameless and not bare, f"without a name: {nameless}, {bare} pictures")
    moved = page.evaluate(MOVES)
    opened.expect(not moved, f"moved sideways: {moved}")
    page.evaluate('document.querySelectorAll("details").forEach((one) => { one.open = true; })')
    wide = page.evaluate(WIDER)
    opened.expect(wide <= 0, f"{wide} px wider than the window, all parts opened")
    symbol = page.locator("details [data-of]").last
    symbol.scroll_into_view_if_needed()
    symbol.hover()
    opened.expect(page.locator(".definition").is_visible(), "no definition where a symbol is pointed at")
    symbol.click()
    opened.expect(page.locator(".found").count() == 1, "a click on a symbol leads nowhere")


def check_paper(opened: Opened, width: int, height: int) -> None:
    """Nothing that is printed is wider than a sheet of A4; the window is as before."""
    page = opened.page
    page.set_viewport_size({"width": A4[0], "height": A4[1]})
    page.emulate_media(media="print")
    wide, moved = page.evaluate(WIDER), page.evaluate(MOVES)
    opened.expect(wide <= 0 and not moved, f"wider than A4: {wide} px, {moved}")
    page.emulate_media(media="screen")
    page.set_viewport_size({"width": width, "height": height})


def main(folder: Path, names: list[str]) -> int:
    """Write and open the reports; 1 where something is wrong."""
    from playwright.sync_api import sync_playwright

    folder.mkdir(parents=True, exist_ok=True)
    browser_path = os.environ.get("CHROMIUM") or shutil.which("chromium") or shutil.which("google-chrome")
    failed = 0
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=browser_path, args=list(FLAGS))
        for name in names or MACHINES:
            machine, *options = MACHINES[name]
            scene = options[:2] if "--scene" in options else []
            made = ended("report", machine, "--out", folder, "--force", *scene)
            if made.code:
                print(f"{name}: {made.err}")
                return 1
            file = Path(made.out.splitlines()[-1].removeprefix("wrote ")).resolve()
            for size, width, height, scheme in WINDOWS:
                context = browser.new_context(viewport={"width": width, "height": height}, color_scheme=scheme)
                opened = opened_report(name, context.new_page(), file)
                opened.page.screenshot(path=folder / f"{name}.{size}.{scheme}.png", full_page=True)
                check_paper(opened, width, height)
                check_report(opened)
                print(f"{name:14} {size:6} {scheme:6} {file.stat().st_size / 1000:.0f} kB", *opened.wrong, sep="; ")
                failed += len(opened.wrong)
                context.close()
        browser.close()
    return int(failed > 0)


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1]), sys.argv[2:]))
