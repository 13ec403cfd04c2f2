"""A page a command, of what `--help` says, and one of all."""

from __future__ import annotations

from collections.abc import Iterator

import click

from docs.site.guides import on_site
from symoro_elastic.cli import cli
from symoro_elastic.cli.listed import LISTED, SECTIONS
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
    table = ["| option | |", "|---|---|", *rows] if rows else []
    return "\n".join([f"# {name}", "", f"`{PROGRAM} {name} {usage}`", "", escaped(text), "", *table, ""])


def _row(names: str, text: str) -> str:
    return f"| `{names.replace('|', chr(92) + '|')}` | {escaped(text).replace('|', chr(92) + '|')} |"


def escaped(text: str) -> str:
    """Return a text in which Markdown finds no markup."""
    for sign in "*_[]<>":
        text = text.replace(sign, chr(92) + sign)
    return text
