"""Build the site: `python -m docs.site [--out build/site] [--without-pictures] [--versions FOLDER]`.

The pages are written as Markdown first, so that any site generator can read them; Zensical makes the site.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path

from docs.site.commands import Pictured, command_pages
from docs.site.gallery import SHOWN, gallery
from docs.site.guides import MADE, guides
from docs.site.tutorials import tutorials
from symoro_elastic import __version__
from symoro_elastic.pages.models_page import models_page
from tests.golden import ROOT

CONFIGURATION = ROOT / "zensical.toml"
SHIM = "assets/javascripts/iframe-worker.js"
"""Search from a folder needs a script that Zensical would fetch from another host: it travels with the site."""
FETCHED = re.compile(r'src="https://unpkg\.com/iframe-worker/shim"')


VERSIONS = '[project.extra.version]\nprovider = "mike"\n'
"""Pages offer the versions that are listed next to their folder: a server is needed."""


def build(out: Path, make: bool = True, more: str = "") -> None:
    """Write the site to a folder, with `more` in its configuration; without `make` no command and no tutorial runs."""
    with tempfile.TemporaryDirectory() as name:
        work = Path(name)
        for page, content in pages(work / "made", make):
            path = work / "pages" / page
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(content.encode("utf-8") if isinstance(content, str) else content)
        text = CONFIGURATION.read_text(encoding="utf-8")
        text = text if make else re.sub(r"^.*(gallery|tutorials/).*\n", "", text, flags=re.MULTILINE)
        (work / "zensical.toml").write_text(text.replace("VERSION", __version__) + more, encoding="utf-8")
        paths = {**os.environ, "PYTHONPATH": str(ROOT)}
        subprocess.run([sys.executable, "-m", "zensical", "build", "--strict"], cwd=work, env=paths, check=True)
        complete(work / "site")
        shutil.rmtree(out, ignore_errors=True)
        shutil.copytree(work / "site", out)


def pages(work: Path, make: bool) -> Iterator[tuple[str, str | bytes]]:
    """Yield names and contents of all pages and pictures."""
    drawn = [*(gallery(work / "gallery") if make else ())]
    yield from guides(work / "guides", make)
    yield from drawn
    yield from command_pages(pictures([name for name, _ in drawn]) if make else {})
    yield "models.md", models_page()
    if make:
        yield from tutorials(work / "tutorials")


def pictures(drawn: Sequence[str]) -> dict[str, list[Pictured]]:
    """Return pictures by the command that makes them: those of the gallery, of which names are given, and of guides."""
    found: dict[str, list[Pictured]] = {}
    for k, one in enumerate(SHOWN):
        for path in drawn:
            if path.startswith(f"gallery_files/{k}/"):
                picture = Pictured(path, one.title, f"symoro-elastic {one.command}")
                found.setdefault(one.command.split()[0], []).append(picture)
    for guide in sorted((ROOT / "docs").glob("*.md")):
        for command, name, title in MADE.findall(guide.read_text(encoding="utf-8")):
            picture = Pictured(f"made/{guide.stem}/{name}", title, f"symoro-elastic {command}")
            found.setdefault(command.split()[0], []).append(picture)
    return found


def complete(site: Path) -> None:
    """Let pages of a site ask no other host for the script of its search."""
    (site / SHIM).write_bytes((Path(__file__).parent / "vendor" / "iframe-worker.js").read_bytes())
    for page in site.rglob("*.html"):
        up = "../" * (len(page.relative_to(site).parts) - 1)
        text = page.read_text(encoding="utf-8")
        page.write_text(FETCHED.sub(f'src="{up}{SHIM}"', text), encoding="utf-8")


def publish(folder: Path, make: bool) -> None:
    """Write the site as the latest one of several versions, which its pages offer."""
    build(folder / __version__, make, VERSIONS)
    names = (path.name for path in folder.iterdir() if (path / "index.html").is_file())
    found = sorted(names, key=lambda name: [int(x) for x in re.findall(r"\d+", name)], reverse=True)
    listed = [{"version": name, "title": name, "aliases": ["latest"] * (name == __version__)} for name in found]
    (folder / "versions.json").write_text(json.dumps(listed), encoding="utf-8")
    there = (
        f'<!doctype html><meta charset="utf-8"><meta http-equiv="refresh" content="0; url={__version__}/index.html">'
    )
    (folder / "index.html").write_text(there, encoding="utf-8")


def main() -> None:
    """Build the site."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=ROOT / "build" / "site")
    parser.add_argument("--versions", type=Path, help="folder of several versions")
    parser.add_argument("--without-pictures", action="store_true", help="run no command and no tutorial")
    given = parser.parse_args()
    if given.versions:
        publish(given.versions, not given.without_pictures)
    else:
        build(given.out, not given.without_pictures)


if __name__ == "__main__":
    main()
