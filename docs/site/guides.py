"""Guides of the folder `docs` as pages of the site: links that leave the folder, and pictures that commands make."""

from __future__ import annotations

import re
import shutil
from collections.abc import Callable, Iterator
from pathlib import Path

from tests.documented_pages import beside_examples, output, runs
from tests.golden import ROOT

PICTURE = re.compile(r"\]\(\.\./examples/(\w+\.svg)\)")
OUTSIDE = re.compile(r"\[([^\]]+)\]\(\.\./([^)]+)\)")
TOPIC = re.compile(r"^## (.+)$", re.MULTILINE)
TO_PYTHON = re.compile(r"\]\((?:python\.md)?#([\w-]+)\)")
MADE = re.compile(r'^<!-- made: (\S+) "([^"]*)" -->$', re.MULTILINE)
"""A picture that the commands of a page make: its file, and what it shows."""


def guides(work: Path, make: bool) -> Iterator[tuple[str, str | bytes]]:
    """Yield names and contents of the pages made of `docs/*.md`, and of their pictures.

    With `make` the commands of pages that show pictures run in the folder `work`.
    """
    for path in sorted((ROOT / "docs").glob("*.md")):
        text = path.read_text(encoding="utf-8")
        if path.stem == "python":
            yield from topics(text)
        elif path.stem != "commands":
            pictures = dict(_made(text, work / path.stem)) if make and MADE.search(text) else {}
            yield from ((f"made/{path.stem}/{Path(name).name}", content) for name, content in pictures.items())
            yield path.name, on_site(MADE.sub(_shown(path.stem, pictures), text))
    for picture in (*(ROOT / "examples").glob("*.svg"), *(ROOT / "docs").glob("*.svg"), *(ROOT / "docs").glob("*.png")):
        yield picture.name, picture.read_bytes()


def on_site(markdown: str) -> str:
    """Return a page with names of files of the repository in the place of links to them; pictures stay."""
    markdown = PICTURE.sub(r"](\1)", markdown)
    return OUTSIDE.sub(lambda link: link[1] if link[1].strip("`") == link[2] else f"{link[1]} (`{link[2]}`)", markdown)


def slug(title: str) -> str:
    """Return the name of a section in an address."""
    return re.sub(r"[^a-z0-9]+", "-", title.lower()).strip("-")


def topics(text: str) -> Iterator[tuple[str, str]]:
    """Yield the page of Python's functions: one of all topics, and one a topic."""
    head, *parts = TOPIC.split(text)
    names = {slug(title): title for title in parts[::2]}
    linked = TO_PYTHON.sub(lambda link: f"](python/{link[1]}.md)" if link[1] in names else link[0], on_site(head))
    index = "\n".join(f"- [{title}](python/{name}.md)" for name, title in names.items())
    yield "python.md", f"{linked}\n## Topics\n\n{index}\n"
    for (name, title), body in zip(names.items(), parts[1::2], strict=True):
        inside = re.sub(r"\]\((\w+\.md)", r"](../\1", on_site(body))
        inside = TO_PYTHON.sub(lambda link: f"]({link[1]}.md)" if link[1] in names else link[0], inside)
        yield f"python/{name}.md", f"# {title}\n{inside}"


def _made(text: str, work: Path) -> Iterator[tuple[str, bytes]]:
    """Run the commands of a page, and yield the pictures that it shows."""
    work.mkdir(parents=True)
    names: dict[str, object] = {}
    with beside_examples(work):
        for run in runs(text):
            output(run, names)
    for name, _ in MADE.findall(text):
        yield name, (work / name).read_bytes()
    shutil.rmtree(work)


def _shown(page: str, pictures: dict[str, bytes]) -> Callable[[re.Match[str]], str]:
    def show(found: re.Match[str]) -> str:
        return f"![{found[2]}](made/{page}/{Path(found[1]).name})" if found[1] in pictures else ""

    return show
