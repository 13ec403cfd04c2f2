"""Guides of the folder `docs` as pages of the site: links that leave the folder, and pictures that commands make."""

from __future__ import annotations

import re
import shlex
from collections.abc import Iterator, Mapping
from functools import partial
from pathlib import Path

from tests.command_line import ended
from tests.documented_pages import beside_examples
from tests.golden import ROOT

PICTURE = re.compile(r"\]\(\.\./examples/(\w+\.svg)\)")
OUTSIDE = re.compile(r"\[([^\]]+)\]\(\.\./([^)]+)\)")
TOPIC = re.compile(r"^## (.+)$", re.MULTILINE)
TO_PYTHON = re.compile(r"\]\((?:python\.md)?#([\w-]+)\)")
MADE = re.compile(r"^<!-- made by: symoro-elastic (.+) \| (\S+) \| (.+) -->$", re.MULTILINE)
"""A picture of a guide on the site: the command that makes it, its file in the folder `plots`, and what it shows."""


def guides(work: Path, make: bool) -> Iterator[tuple[str, str | bytes]]:
    """Yield names and contents of the pages made of `docs/*.md`, and of their pictures.

    With `make` the commands of pictures run in folders below `work`.
    """
    for path in sorted((ROOT / "docs").glob("*.md")):
        text = path.read_text(encoding="utf-8")
        if path.stem == "python":
            yield from topics(text)
        elif path.stem != "commands":
            pictures = dict(_made(text, work / path.stem)) if make else {}
            yield from ((f"made/{path.stem}/{name}", content) for name, content in pictures.items())
            yield path.name, on_site(MADE.sub(partial(_shown, path.stem, pictures), text))
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
    """Run the commands of the pictures of a page, each once, and yield the pictures by their names."""
    found = MADE.findall(text)
    for k, command in enumerate(dict.fromkeys(command for command, _, _ in found)):
        folder = work / str(k)
        folder.mkdir(parents=True)
        with beside_examples(folder):
            done = ended(*shlex.split(command), "--plots", "plots", "--plot-format", "svg")
        if done.code:
            raise SystemExit(f"{command}: {done.err}")
        names = [name for own, name, _ in found if own == command]
        yield from ((name, (folder / "plots" / name).read_bytes()) for name in names)


def _shown(page: str, pictures: Mapping[str, bytes], found: re.Match[str]) -> str:
    """Return a picture and the command that makes it; nothing where it was not made."""
    command, name, text = found.groups()
    if name not in pictures:
        return ""
    return f"![{text}](made/{page}/{name})\n\n*{text}: `symoro-elastic {command} --plots plots`*"
