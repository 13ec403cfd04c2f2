"""A command group whose help lists the commands in named sections."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import click

from symoro_elastic.cli.listed import LISTED, SECTIONS, ListedCommands
from symoro_elastic.foundation.errors import InputError


class Failure(Exception):
    """An `OSError` or `EOFError` of a command, `cause`; click takes the latter for Ctrl-C, a closed pipe for exit 1."""

    def __init__(self, cause: OSError | EOFError) -> None:
        super().__init__(cause)
        self.cause = cause


@contextmanager
def _failures() -> Iterator[None]:
    try:
        yield
    except (OSError, EOFError) as error:
        raise Failure(error) from error


class SectionedGroup(click.Group):
    """Commands by section; each belongs to exactly one."""

    def __init__(self, *arguments: Any, **settings: Any) -> None:
        super().__init__(*arguments, **settings)
        self.commands = ListedCommands()  # type: ignore[assignment]

    def make_context(self, *arguments: Any, **settings: Any) -> click.Context:
        """Return the context of a command line; raises `Failure`."""
        with _failures():
            return super().make_context(*arguments, **settings)

    def invoke(self, ctx: click.Context) -> Any:
        """Run a command; raises `Failure`."""
        with _failures():
            return super().invoke(ctx)

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """Return the command and its arguments; raises `InputError` for an option that is given twice."""
        name, command, given = super().resolve_command(ctx, args)
        if command:
            given = _renamed(command, given)
        if command and not ctx.resilient_parsing:
            _refuse_repeated(command, given, click.Context(command, ctx, name))
        return name, command, given

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write one list of commands per section, with the first line of each command's help."""
        width = max(map(len, LISTED))
        for title, section in SECTIONS.items():
            with formatter.section(title):
                limit = formatter.width - 6 - width
                formatter.write_dl([(name.ljust(width), one.short(limit)) for name, one in section.items()])


def _renamed(command: click.Command, given: list[str]) -> list[str]:
    """Return the words of a command line with the options' present names; former ones are reported on stderr."""
    from symoro_elastic.cli.options import DeclaredOption

    rows = [one.row for one in command.params if isinstance(one, DeclaredOption)]
    former = {old.partition("=")[0]: (row.flag, old) for row in rows for old in row.formerly if old.startswith("--")}
    end = given.index("--") if "--" in given else len(given)
    words: list[str] = []
    for word in given[:end]:
        name, equals, value = word.partition("=")
        if name not in former:
            words.append(word)
            continue
        flag, old = former[name]
        words += [f"{flag}{old.removeprefix(name)}" if "=" in old else f"{flag}{equals}{value}"]
        click.echo(f"note: {name} is now {words[-1].partition('=')[0] if '=' not in old else words[-1]}", err=True)
    return [*words, *given[end:]]


def _refuse_repeated(command: click.Command, given: list[str], ctx: click.Context) -> None:
    """Raise `InputError` for an option of one value that is given twice; flags may be."""
    _, _, order = command.make_parser(ctx).parse_args(list(given))
    for option in order:
        if isinstance(option, click.Option) and not (option.multiple or option.is_flag) and order.count(option) > 1:
            raise InputError("symoro-elastic", option.opts[0], "is given twice: give it one value")
