"""Reports in Chromium: no error, no request, nothing wider than the window, images described, definitions shown.

`python -m tests.benchmarks.report_pages FOLDER [NAME ...]` writes the reports and what they look like to a folder.
Needs what `tests.benchmarks.pages` needs.
"""

from __future__ import annotations

import sys
from pathlib import Path

from tests.benchmarks.pages import MACHINES, NAMELESS, SIZES, Opened, chromium, listened, windows
from tests.command_line import ended

WINDOWS = {**SIZES, "small": (1000, 800)}
A4 = (688, 973)
"""Pixels within the margins of a sheet."""
MOVES = """() => [...document.querySelectorAll(".wide")].filter((x) => x.scrollWidth > x.clientWidth + 1)
  .map((x) => x.getAttribute("aria-label"))"""
"""Tables that are moved sideways."""
BARE = '() => [...document.querySelectorAll("img")].filter((x) => !x.alt || !x.naturalWidth).length'
WIDER = "document.documentElement.scrollWidth - document.documentElement.clientWidth"


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
    folder.mkdir(parents=True, exist_ok=True)
    failed = 0
    with chromium() as browser:
        for name in names or MACHINES:
            machine, *options = MACHINES[name]
            scene = options[:2] if "--scene" in options else []
            made = ended("report", machine, "--out", folder, "--force", *scene)
            if made.code:
                print(f"{name}: {made.err}")
                return 1
            file = Path(made.out.splitlines()[-1].removeprefix("wrote ")).resolve()
            for size, scheme, context in windows(browser, WINDOWS):
                opened = listened(name, context.new_page(), file, (file.as_uri(), "data:"))
                opened.page.screenshot(path=folder / f"{name}.{size}.{scheme}.png", full_page=True)
                check_paper(opened, *WINDOWS[size])
                check_report(opened)
                print(f"{name:14} {size:6} {scheme:6} {file.stat().st_size / 1000:.0f} kB", *opened.wrong, sep="; ")
                failed += len(opened.wrong)
    return int(failed > 0)


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1]), sys.argv[2:]))
