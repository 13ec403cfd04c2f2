"""Guides of the folder `docs` as pages of the site: links that leave the folder, pictures that commands make, print."""

from __future__ import annotations

import re
import shlex
from collections.abc import Iterator, Mapping
from functools import partial
from pathlib import Path

from symoro_elastic.foundation.pictures import picture
from tests.command_line import ended
from tests.documented_pages import beside_examples, output, runs
from tests.golden import ROOT

PICTURE = re.compile(r"\]\(\.\./examples/(\w+\.svg)\)")
OUTSIDE = re.compile(r"\[([^\]]+)\]\(\.\./([^)]+)\)")
TOPIC = re.compile(r"^## (.+)$", re.MULTILINE)
TO_PYTHON = re.compile(r"\]\((?:python\.md)?#([\w-]+)\)")
MADE = re.compile(r"^<!-- made by: symoro-elastic (.+) \| (\S+) \| (.+) -->$", re.MULTILINE)
"""A picture of a guide on the site: the command that makes it, its file in the folder `plots`, and what it shows."""
DRAWN = re.compile(r"^<!-- drawn by: (.+) \| (\S+) \| (.+) -->$", re.MULTILINE)
"""The same by the programs of the page up to here, and an expression of Python that gives a figure."""


def guides(work: Path, make: bool) -> Iterator[tuple[str, str | bytes]]:
    """Yield names and contents of the pages made of `docs/*.md`, and of their pictures.

    With `make` the commands of pictures run in folders below `work`.
    """
    for path in sorted((ROOT / "docs").glob("*.md")):
        text = path.read_text(encoding="utf-8")
        if path.stem == "python":
            yield from topics(text)
        elif path.stem != "commands":
            pictures = {**dict(made(text, work / path.stem)), **dict(drawn(text, work / path.stem))} if make else {}
            yield from ((f"made/{path.stem}/{name}", content) for name, content in pictures.items())
            shown = MADE.sub(partial(_shown, path.stem, pictures), text)
            yield path.name, on_site(DRAWN.sub(partial(_shown, path.stem, pictures), shown))
    for path in (*(ROOT / "examples").glob("*.svg"), *(ROOT / "docs").glob("*.svg"), *(ROOT / "docs").glob("*.png")):
        yield path.name, path.read_bytes()
    yield "site.css", (Path(__file__).parent / "site.css").read_bytes()


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


def commands(text: str) -> dict[str, list[str]]:
    """Return the commands that make the pictures of a page, with their names."""
    found: dict[str, list[str]] = {}
    for command, name, _ in MADE.findall(text):
        into = f"--picture plots/{name}" if command.startswith("show ") else "--plots plots --plot-format svg"
        found.setdefault(f"{command} {into}", []).append(name)
    return found


def made(text: str, work: Path) -> Iterator[tuple[str, bytes]]:
    """Run the commands of the pictures of a page, each once, and yield the pictures by their names."""
    for k, (command, names) in enumerate(commands(text).items()):
        folder = work / str(k)
        (folder / "plots").mkdir(parents=True)
        with beside_examples(folder):
            done = ended(*shlex.split(command), *(["--force"] if "--plots" in command else []))
        if done.code:
            raise SystemExit(f"{command}: {done.err}")
        yield from ((name, (folder / "plots" / name).read_bytes()) for name in names)


def drawn(text: str, work: Path) -> Iterator[tuple[str, bytes]]:
    """Yield the pictures that programs of a page draw, by their names."""
    for mark in DRAWN.finditer(text):
        names: dict[str, object] = {}
        folder = work / mark[2]
        folder.mkdir(parents=True)
        with beside_examples(folder):
            for run in runs(text[: mark.start()]):
                output(run, names)
            yield mark[2], picture(eval(mark[1], names), "svg")


def _shown(page: str, pictures: Mapping[str, bytes], found: re.Match[str]) -> str:
    """Return a picture and the command that makes it; nothing where it was not made."""
    command, name, text = found.groups()
    if name not in pictures:
        return ""
    by = command if found.re is DRAWN else f"symoro-elastic {command}"
    by += "" if found.re is DRAWN or command.startswith("show ") else " --plots plots"
    return f"![{text}](made/{page}/{name})\n\n*{text}: `{by}`*"
