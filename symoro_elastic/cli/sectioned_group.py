"""A command group whose help lists the commands in named sections."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from operator import attrgetter
from typing import Any

import click

from symoro_elastic.cli.listed import FORMER, LISTED, SECTIONS, ListedCommands
from symoro_elastic.foundation.errors import TWICE, InputError


class Failure(Exception):
    """An `OSError` or `EOFError` of a command, `cause`; click would treat them as Ctrl-C, or as a closed pipe."""

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
        """Return the command and its arguments; raises `InputError` for a repeated option."""
        if args and args[0] in FORMER:
            note_new_name(args[0], " ".join(FORMER[args[0]]))
            args = [*FORMER[args[0]], *args[1:]]
        name, command, words = super().resolve_command(ctx, args)
        if command:
            words = _with_present_names(command, words)
        if command and not ctx.resilient_parsing:
            _refuse_repeated(command, words, click.Context(command, ctx, name))
        return name, command, words

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write one list of commands per section, with the first line of each command's help."""
        width = max(map(len, LISTED))
        for title, section in SECTIONS.items():
            with formatter.section(title):
                limit = formatter.width - 6 - width
                formatter.write_dl([(name.ljust(width), listed.short(limit)) for name, listed in section.items()])


def _with_present_names(command: click.Command, typed: list[str]) -> list[str]:
    """Return the words of a command line with present names of options; former ones are reported on stderr."""
    from symoro_elastic.cli.options import DeclaredOption

    rows = [parameter.row for parameter in command.params if isinstance(parameter, DeclaredOption)]
    former, gone = (
        {old.partition("=")[0]: (row.flag, old) for row in rows for old in names(row) if old.startswith("--")}
        for names in (attrgetter("formerly"), attrgetter("gone"))
    )
    flags = {option for parameter in command.params for option in parameter.opts}
    end = typed.index("--") if "--" in typed else len(typed)
    words: list[str] = []
    for word in typed[:end]:
        name, equals, value = word.partition("=")
        if name in gone and name not in flags:
            flag, old = gone[name]
            raise InputError("symoro-elastic", name, f"it is now {flag}{old.removeprefix(name)}")
        if name not in former:
            words.append(word)
            continue
        flag, old = former[name]
        words += [f"{flag}{old.removeprefix(name)}" if "=" in old else f"{flag}{equals}{value}"]
        note_new_name(name, words[-1].partition("=")[0] if "=" not in old else words[-1])
    return [*words, *typed[end:]]


def note_new_name(former: str, now: str) -> None:
    """Print what a former name is called now."""
    from symoro_elastic.cli.output import say

    say(f"note: {former} is now {now}")


def _refuse_repeated(command: click.Command, words: list[str], ctx: click.Context) -> None:
    """Raise `InputError` for a repeated option of a single value; flags may be repeated."""
    _, _, order = command.make_parser(ctx).parse_args(list(words))
    for option in order:
        if isinstance(option, click.Option) and not (option.multiple or option.is_flag) and order.count(option) > 1:
            raise InputError("symoro-elastic", option.opts[0], TWICE)
