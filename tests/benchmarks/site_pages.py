"""The site in Chromium, opened from its folder: `python -m tests.benchmarks.site_pages SITE FOLDER [PAGE ...]`.

Every page, 1400 and 390 px wide, light and dark: no error, no request but of its own files, nothing wider than the
window, pictures that are there and have a text. The search finds a word, the cheat sheet prints on one page. The
first screen of each page goes to a folder. The page of servers for what is missing is left out. Needs what
`tests.benchmarks.pages` needs.
"""

from __future__ import annotations

import re
import sys
from pathlib import Path

from tests.benchmarks.pages import SCHEMES, SIZES, Opened, chromium, listened, windows
from tests.benchmarks.report_pages import BARE, WIDER

WIDEST = """() => [...document.querySelectorAll("article *")].filter((x) =>
  x.getBoundingClientRect().right > innerWidth + 1 && !x.closest(".md-typeset__scrollwrap, pre, table, details")
).slice(0, 3).map((x) => x.outerHTML.slice(0, 80))"""
SEARCHED = "frequency"
PRINTED = re.compile(rb"/Type\s*/Page\b")


def check(opened: Opened) -> None:
    """Widths and pictures."""
    page = opened.page
    page.evaluate('document.querySelectorAll("img[loading=lazy]").forEach((x) => { x.loading = "eager"; })')
    wide, bare = page.evaluate(WIDER), page.evaluate(BARE)
    opened.expect(wide <= 0, f"{wide} px wider than the window: {page.evaluate(WIDEST)}")
    opened.expect(not bare, f"{bare} pictures are not there or have no text")


def check_search(opened: Opened) -> None:
    """Type a word, and go to what is found."""
    page = opened.page
    page.keyboard.press("/")
    page.keyboard.type(SEARCHED, delay=30)
    found = page.get_by_text(re.compile(r"^\d+ results?$"))
    found.wait_for(timeout=60_000)
    opened.expect(not found.inner_text().startswith("0"), f"nothing is found of {SEARCHED}")


def check_print(opened: Opened) -> None:
    """Print a page."""
    count = len(PRINTED.findall(opened.page.pdf(prefer_css_page_size=True)))
    opened.expect(count == 1, f"{count} pages of paper")


def main(site: Path, folder: Path, names: list[str]) -> int:
    """Open the pages; 1 where something is wrong."""
    folder.mkdir(parents=True, exist_ok=True)
    files = [site / name for name in names] or sorted(path for path in site.rglob("*.html") if path.name != "404.html")
    failed, own = 0, (site.as_uri(), "data:", "blob:", "about:")
    with chromium() as browser:
        for size, scheme, context in windows(browser):
            for file in files:
                opened = listened(str(file.relative_to(site)), context.new_page(), file, own)
                check(opened)
                if file.name == "index.html":
                    check_search(opened)
                if file.name == "cheat_sheet.html":
                    check_print(opened)
                opened.page.screenshot(path=folder / f"{opened.name.replace('/', '_')}.{size}.{scheme}.png")
                if opened.wrong:
                    print(opened.name, size, scheme, *opened.wrong, sep="; ")
                failed += len(opened.wrong)
                opened.page.close()
    print(f"{len(files)} pages, {len(SIZES) * len(SCHEMES)} windows, {failed} faults")
    return int(failed > 0)


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1]).resolve(), Path(sys.argv[2]), sys.argv[3:]))
