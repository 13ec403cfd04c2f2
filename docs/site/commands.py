"""A page a command, of what `--help` says, and one of all."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

import click

from docs.site.guides import on_site
from symoro_elastic.cli import cli
from symoro_elastic.cli.listed import LISTED, SECTIONS
from tests.documented_pages import runs
from tests.golden import ROOT

PROGRAM = "symoro-elastic"


class Pictured(NamedTuple):
    """A picture, or a page, that a command makes: its path on the site, what it shows, the command."""

    path: str
    title: str
    command: str


def command_pages(pictures: Mapping[str, Sequence[Pictured]] = {}) -> Iterator[tuple[str, str]]:
    """Yield names and texts of the pages, with pictures by the command that draws them."""
    head = (ROOT / "docs" / "commands.md").read_text(encoding="utf-8")
    rows = [
        line
        for section, names in SECTIONS.items()
        for line in (
            "",
            f"## {section}",
            "",
            *(f"- [`{name}`](commands/{name}.md): {LISTED[name].line}" for name in names),
        )
    ]
    yield "commands.md", "\n".join([on_site(head).rstrip(), *rows, ""])
    with click.Context(cli, info_name=PROGRAM) as context:
        for name in LISTED:
            yield f"commands/{name}.md", _page(name, context, pictures.get(name, ()))


def _page(name: str, context: click.Context, pictures: Sequence[Pictured]) -> str:
    command = cli.get_command(context, name)
    assert command is not None
    with click.Context(command, parent=context, info_name=name) as own:
        usage = " ".join(command.collect_usage_pieces(own))
        records = [record for one in command.get_params(own) if (record := one.get_help_record(own))]
        rows = [_row(*record) for record in records if record[1]]
    # Paragraphs of help are separated by empty lines; \b marks those that are not to be wrapped.
    text = (command.help or "").replace("\b\n", "")
    table = ["| option | meaning |", "|---|---|", *rows] if rows else []
    shown = [f"# {name}", "", f"`{PROGRAM} {name} {usage}`", "", escaped(text), "", *_example(name), *_drawn(pictures)]
    return "\n".join([*shown, "## Options", "", *table, ""])


def _drawn(pictures: Sequence[Pictured]) -> Iterator[str]:
    for one in pictures[:1]:
        if one.path.endswith(".html"):
            yield from ("```sh", one.command, "```", "", f"writes [this page](../{one.path}).", "")
        else:
            yield from (f"![{one.title}](../{one.path})", "", f"*{one.title}: `{one.command}`*", "")


def _example(name: str) -> Iterator[str]:
    """A call of a command in a guide, with what it prints where it is alone, and a link to the guide."""
    texts = {guide: guide.read_text(encoding="utf-8") for guide in sorted((ROOT / "docs").glob("*.md"))}
    calls = [call for guide, text in texts.items() for call in _calls(guide.stem, text) if call.command == name]
    if not calls:
        return
    call = max(calls, key=Call.rank)
    output = ["```text", call.shown.rstrip("\n"), "```", ""] if call.is_alone and call.shown else []
    title = texts[ROOT / "docs" / f"{call.guide}.md"].splitlines()[0].removeprefix("# ")
    yield from ("## Example", "", "```sh", call.line, "```", "", *output, f"More in [{title}](../{call.guide}.md).", "")


class Call(NamedTuple):
    """A call in a guide; whether it is in a block that runs, and alone there, and the output that is shown."""

    guide: str
    line: str
    is_run: bool = False
    is_alone: bool = False
    shown: str = ""

    def rank(self) -> tuple[bool | int, ...]:
        """Largest for a call with its output, on an example, on the start page, short."""
        on_example = "examples/" in self.line or self.command == "new"
        return self.is_run, self.is_alone, on_example, bool(self.shown), self.guide == "index", -len(self.line)

    @property
    def command(self) -> str:
        return self.line.split()[1]


def _calls(guide: str, text: str) -> Iterator[Call]:
    for run in runs(text):
        lines = _lines(run.text) if run.language == "sh" else []
        for line in lines:
            if line.startswith(f"{PROGRAM} "):
                yield Call(guide, line, True, len(lines) == 1, run.shown)
    for line in re.findall(rf"`({PROGRAM} [^`]+)`", text):
        yield Call(guide, line)


def _lines(text: str) -> list[str]:
    return [" ".join(line.split()) for line in text.replace("\\\n", " ").splitlines() if line.strip()]


def _row(names: str, text: str) -> str:
    return f"| <code>{escaped(names)}</code> | {escaped(text)} |"


def escaped(text: str) -> str:
    """Return a text in which Markdown finds no markup."""
    text = text.replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")
    return re.sub(r"[*_\[\]|`]", lambda sign: f"&#{ord(sign[0])};", text)
