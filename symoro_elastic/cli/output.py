"""What a command prints: tables, figures as JSON, progress."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, TextIO

import click

if TYPE_CHECKING:
    from symoro_elastic.results import Part, Result

PIPED = 160
"""Width of tables that no terminal shows."""


def print_json(figures: dict[str, Any]) -> None:
    """One line of JSON on standard output."""
    click.echo(json.dumps(figures))


def line_width() -> int:
    """Return the characters of a line: those of the terminal, else 160."""
    from rich.console import Console

    return Console().width if _is_terminal(sys.stdout) else PIPED


def print_table(table: Any, title: str = "", keys: int = 1) -> None:
    """A table of rich on standard output, as several of them, each with the first `keys` columns, where it is too wide.

    Nothing is cut; a pipe or a file has lines of up to 160 characters.
    """
    from rich.console import Console
    from rich.text import Text

    from symoro_elastic.reports.fitting import fitted

    class Output(Console):
        def on_broken_pipe(self) -> None:
            raise  # noqa: PLE0704  (the error that this handles, instead of exit code 1)

    console = Output(highlight=False, width=line_width())
    for part, one in enumerate(fitted(table, console.width, keys)):
        one.title = Text(title, style="table.title") if title and not part else None
        console.print(one)


def print_parts(parts: Sequence[Part]) -> None:
    """Sentences and tables on standard output, in their order."""
    for part in parts:
        if isinstance(part, str):
            click.echo(part)
        else:
            print_table(part.table, part.title, part.keys)


def print_result(result: Result, as_json: bool, **written: Any) -> None:
    """A result on standard output, or its figures and what was `written` as JSON."""
    if as_json:
        print_json({**result.as_json(), **written})
    else:
        print_parts(result.parts())


def write_text(text: str, out: str) -> None:
    """Save a text; raises `InputError` where the file cannot be written."""
    from symoro_elastic import output_files

    output_files.write_text(text, out)


def _is_terminal(stream: TextIO | None) -> bool:
    return stream is not None and stream.isatty()


@contextmanager
def counted(step: str) -> Iterator[Callable[[int, int], None]]:
    """A progress bar on a terminal's stderr, and nothing elsewhere."""
    with staged(step) as (_, progress):
        yield progress


@contextmanager
def staged(first: str = "read") -> Iterator[tuple[Callable[[str], None], Callable[[int, int], None]]]:
    """A progress bar on a terminal's stderr, and nothing elsewhere: callbacks that name a stage, and count its work."""
    if not _is_terminal(sys.stderr):
        yield lambda _: None, lambda _done, _total: None
        return
    from rich.console import Console
    from rich.progress import Progress

    with Progress(console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task(first, total=None)
        yield (
            lambda stage: bar.update(task, description=stage),
            lambda done, total: bar.update(task, completed=done, total=total),
        )


@contextmanager
def counted_ahead(name: str) -> Iterator[Callable[[int, int], None]]:
    """A progress bar with the time left, which no thread draws: processes may be copied while it is there."""
    if not _is_terminal(sys.stderr):
        yield lambda _done, _total: None
        return
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    columns = TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn()
    with Progress(*columns, console=Console(stderr=True), transient=True, auto_refresh=False) as bar:
        task = bar.add_task(name, total=None)
        yield lambda done, total: bar.update(task, completed=done, total=total, refresh=True)


@contextmanager
def steps() -> Iterator[Callable[[str], None]]:
    """Shows the current step on a terminal's stderr, and nothing elsewhere."""
    if not _is_terminal(sys.stderr):
        yield lambda _: None
        return
    from rich.console import Console

    with Console(stderr=True).status("read") as status:
        yield status.update


def save_arrays(result: Result, out: str | None, as_json: bool) -> None:
    """Save the arrays of a result to `out`, if given, and say so; on stderr beside JSON."""
    if out:
        from symoro_elastic.vibration.export import save_arrays

        save_arrays(result.arrays(), out)
        click.echo(f"wrote {out}", err=as_json)


def print_written(folder: str, written: Sequence[Path]) -> None:
    """Name the files written to a folder, on stderr."""
    click.echo(f"wrote {folder}: {', '.join(path.name for path in written)}", err=True)
