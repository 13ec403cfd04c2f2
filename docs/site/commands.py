"""A page a command, of what `--help` says, and one of all."""

from __future__ import annotations

import re
from collections.abc import Iterator

import click

from docs.site.guides import on_site
from symoro_elastic.cli import cli
from symoro_elastic.cli.listed import LISTED, SECTIONS
from tests.documented_pages import runs
from tests.golden import ROOT

PROGRAM = "symoro-elastic"


def command_pages() -> Iterator[tuple[str, str]]:
    """Yield names and texts of the pages."""
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
            yield f"commands/{name}.md", _page(name, context)


def _page(name: str, context: click.Context) -> str:
    command = cli.get_command(context, name)
    assert command is not None
    with click.Context(command, parent=context, info_name=name) as own:
        usage = " ".join(command.collect_usage_pieces(own))
        rows = [_row(*record) for one in command.get_params(own) if (record := one.get_help_record(own))]
    # Paragraphs of help are separated by empty lines; \b marks those that are not to be wrapped.
    text = (command.help or "").replace("\b\n", "")
    table = ["| option | meaning |", "|---|---|", *rows] if rows else []
    shown = [f"# {name}", "", f"`{PROGRAM} {name} {usage}`", "", escaped(text), "", *_example(name), *table, ""]
    return "\n".join(shown)


def _example(name: str) -> Iterator[str]:
    """The first call of a command in a guide, with a link to that: one that runs, else one in its text."""
    texts = {guide.stem: guide.read_text(encoding="utf-8") for guide in sorted((ROOT / "docs").glob("*.md"))}
    lines = [(guide, x) for guide, text in texts.items() for run in runs(text) for x in _lines(run.text)]
    lines += [(guide, x) for guide, text in texts.items() for x in re.findall(rf"`({PROGRAM} [^`]+)`", text)]
    for guide, line in lines:
        if line.split()[:2] == [PROGRAM, name]:
            yield from ("```sh", line, "```", "", f"From [{guide}](../{guide}.md).", "")
            return


def _lines(text: str) -> Iterator[str]:
    yield from (" ".join(line.split()) for line in text.replace("\\\n", " ").splitlines())


def _row(names: str, text: str) -> str:
    return f"| `{names.replace('|', chr(92) + '|')}` | {escaped(text).replace('|', chr(92) + '|')} |"


def escaped(text: str) -> str:
    """Return a text in which Markdown finds no markup."""
    text = text.replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")
    return re.sub(r"([*_\[\]])", r"\\\1", text)
