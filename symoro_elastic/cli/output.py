"""Output of commands: tables, results as JSON, progress."""

from __future__ import annotations

import json
import sys
import textwrap
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, TextIO

import click

from symoro_elastic.foundation.errors import printable, readable

if TYPE_CHECKING:
    from symoro_elastic.foundation.results import Part, Result, Table
    from symoro_elastic.machine.machine import Machine

GLUE = "\N{NO-BREAK SPACE}"
KEPT_TOGETHER = 24
"""Most characters between two commas that are kept in one line if the width allows."""
WIDE, NARROW = 3, 2
"""Characters that a column needs in addition to its text, and one more for the table."""
FEWEST = 8
"""Least width of the columns after the first ones."""

PIPED = 160
"""Width of tables that no terminal shows."""


def echo(text: str, err: bool = False, nl: bool = True) -> None:
    """Print a text on standard output or standard error, without control characters."""
    click.echo(printable(text), err=err, nl=nl)


def say(line: str) -> None:
    """Print a line on standard error; the middle of a long one is omitted."""
    echo(readable(" ".join(line.split())), err=True)


def print_json(figures: dict[str, Any]) -> None:
    """One line of JSON on standard output."""
    echo(json.dumps(figures))


def line_width() -> int:
    """Return the width of a line: that of the terminal, else 160."""
    from rich.console import Console

    return Console().width if _is_terminal(sys.stdout) else PIPED


def print_table(table: Table) -> None:
    """Print a table on standard output; a wide one as several, each with its first `keys` columns.

    Nothing is cut; a pipe or a file has lines of up to 160 characters.
    """
    from rich.console import Console
    from rich.text import Text

    class Output(Console):
        def on_broken_pipe(self) -> None:
            raise  # noqa: PLE0704  (the error that this handles, instead of exit code 1)

    console = Output(highlight=False, width=line_width())
    for k, part in enumerate(fit_tables(table, console.width)):
        part.title = Text(printable(table.title), style="table.title") if table.title and not k else None
        console.print(part)


def print_parts(parts: Iterable[Part]) -> None:
    """Print sentences and tables, in their order."""
    for part in parts:
        if isinstance(part, str):
            echo(part)
        else:
            print_table(part)


def print_result(result: Result, as_json: bool, written: str | None = None, **more: Any) -> None:
    """Print a result and the file `written`, or these and `more` values as JSON."""
    if as_json:
        print_json({**result.as_json(), **({"written": written} if written else {}), **more})
        return
    print_parts(result.parts())
    if written:
        echo(f"wrote {written}")


def write_text(text: str, out: str) -> None:
    """Write a text file; raises `InputError` for one that cannot be written."""
    from symoro_elastic.foundation import output_files

    output_files.write_text(text, out)


def _is_terminal(stream: TextIO | None) -> bool:
    return stream is not None and stream.isatty()


@contextmanager
def progress_bar(step: str) -> Iterator[Callable[[int, int], None]]:
    """Show a progress bar on a terminal's stderr, and nothing elsewhere."""
    with staged_progress(step) as (_, progress):
        yield progress


@contextmanager
def staged_progress(first: str = "read") -> Iterator[tuple[Callable[[str], None], Callable[[int, int], None]]]:
    """Show a progress bar on a terminal's stderr, nothing elsewhere; yield what names and counts a stage."""
    if not _is_terminal(sys.stderr):
        yield lambda _: None, lambda _done, _total: None
        return
    from rich.console import Console
    from rich.progress import Progress

    with Progress(console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task(_plain(first), total=None)
        yield (
            lambda stage: bar.reset(task, total=None, description=_plain(stage)),
            lambda done, total: bar.update(task, completed=done, total=total),
        )


@contextmanager
def counted_ahead(name: str) -> Iterator[Callable[[int, int], None]]:
    """Show a progress bar with the remaining time, without a drawing thread: processes may fork meanwhile."""
    if not _is_terminal(sys.stderr):
        yield lambda _done, _total: None
        return
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    columns = TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn()
    with Progress(*columns, console=Console(stderr=True), transient=True, auto_refresh=False) as bar:
        task = bar.add_task(_plain(name), total=None)
        yield lambda done, total: bar.update(task, completed=done, total=total, refresh=True)


@contextmanager
def steps(first: str = "read") -> Iterator[Callable[[str], None]]:
    """Show the current step on a terminal's stderr, and nothing elsewhere."""
    if not _is_terminal(sys.stderr):
        yield lambda _: None
        return
    from rich.console import Console

    with Console(stderr=True).status(first) as status:
        yield lambda stage: status.update(_plain(stage))


def _plain(stage: str) -> str:
    """The name of a stage, without styles of rich."""
    from rich.markup import escape

    return escape(printable(stage))


def save_arrays(result: Result, out: str | None, as_json: bool) -> None:
    """Save the arrays of a result to `out`, if given, and print its name; on stderr with JSON."""
    if out:
        from symoro_elastic.analysis.vibration.export import save_arrays

        save_arrays(result.arrays(), out)
        echo(f"wrote {out}", err=as_json)


def save_machine(machine: Machine, path: str, of_file: str) -> None:
    """Save a machine derived from a file's, with the file's comments if both are TOML."""
    from symoro_elastic.formats import write_machine

    if lost := write_machine(machine, path, of_file):
        say(f"note: {lost}")


def print_written(folder: str, written: Sequence[Path]) -> None:
    """Name the files written to a folder, on stderr."""
    echo(f"wrote {folder}: {', '.join(path.name for path in written)}", err=True)


# Tables that fit the width of a terminal: nothing is cut, no name or number is broken that fits in a line.
#
# A table that is too wide has lines wrapped between words, or its columns in several tables below each other, each of
# which begins with the first columns: whichever needs fewer lines.
@dataclass(frozen=True)
class Column:
    """Heading, cells, and the width at which they are wrapped."""

    heading: str
    cells: tuple[str, ...]
    width: int = 0
    together: bool = True

    @property
    def natural(self) -> int:
        """The width without wrapping."""
        return max(map(len, (self.heading, *self.cells)))

    @property
    def least(self) -> int:
        """The width without broken words."""
        words = [self.heading.split(), *(_glue(cell, self.together).split(" ") for cell in self.cells)]
        return max((len(word) for line in words for word in line), default=0)

    def lines(self, text: str) -> list[str]:
        """Return a text in lines of this width; longer words are broken."""
        glued = _glue(text, self.together)
        fits = all(len(word) <= self.width for word in glued.split(" "))
        wrapped = textwrap.wrap(glued if fits else text, self.width, break_on_hyphens=False)
        return [line.replace(GLUE, " ") for line in wrapped] or [""]

    def height(self, row: int) -> int:
        """Lines of a cell."""
        return len(self.lines(self.cells[row]))


def fit_tables(table: Table, width: int) -> list[Any]:
    """Return a table as one or more rich tables of at most `width` characters; the `keys` columns repeat.

    Columns without any text are left out, and so is a table without rows.
    """
    columns = [Column(printable(head), tuple(map(printable, cells))) for head, cells in table.columns if any(cells)]
    if not columns:
        return []
    if sum(column.natural + WIDE for column in columns) < width:
        return [_table([replace(column, width=column.natural) for column in columns], WIDE)]
    layouts = [layout for layout in _layouts(columns, width, min(table.keys, len(columns) - 1)) if layout]
    return [_table(part, NARROW) for part in min(layouts, key=_height)]


def _layouts(columns: Sequence[Column], width: int, keys: int) -> Iterator[list[list[Column]]]:
    """Layouts of columns: one table, words kept together or not; several tables, which always fit."""
    for together in (True, False):
        line = _columns_in_line([replace(column, together=together) for column in columns], width)
        yield [line] if line else []
    yield _parts(columns, width, keys)


def _columns_in_line(columns: Sequence[Column], width: int) -> list[Column]:
    """Columns that fit a line, none narrower than its longest word; empty if they do not fit."""
    widths = [column.least for column in columns]
    spare = width - 1 - sum(w + NARROW for w in widths)
    if spare < 0:
        return []
    for _ in range(spare):
        k = max(range(len(columns)), key=lambda k: columns[k].natural / max(widths[k], 1))
        widths[k] += widths[k] < columns[k].natural
    return [replace(column, width=max(w, 1)) for column, w in zip(columns, widths, strict=True)]


def _parts(columns: Sequence[Column], width: int, keys: int) -> list[list[Column]]:
    """Columns of several tables, the first `keys` of them in each."""
    first = _keys(columns[:keys], width // 2)
    room = width - 1 - sum(column.width + NARROW for column in first)
    parts: list[list[Column]] = []
    room_left = -1
    for column in columns[keys:]:
        wanted = replace(column, width=min(column.natural, max(room - NARROW, FEWEST)))
        if room_left < wanted.width + NARROW:
            parts.append(list(first))
            room_left = room
        parts[-1].append(wanted)
        room_left -= wanted.width + NARROW
    return parts or [first]


def _keys(columns: Sequence[Column], width: int) -> list[Column]:
    """The columns of the tables: within the width or, to break no word, a little more."""
    share = width // max(len(columns), 1) - NARROW
    loose = [replace(column, together=False) for column in columns]
    unbroken = [max(column.least, min(column.natural, share)) for column in loose]
    fits = sum(unbroken) <= 3 * width // 2
    return [replace(c, width=w if fits else min(w, share)) for c, w in zip(loose, unbroken, strict=True)]


def _height(layout: Sequence[Sequence[Column]]) -> int:
    """Lines of all tables of a layout, with four for the head of each."""
    return sum(4 + sum(max(c.height(row) for c in part) for row in range(len(part[0].cells))) for part in layout)


def _glue(text: str, together: bool) -> str:
    """A text with unbreakable spaces within a name, a sign and a number that belong together."""
    if not together:
        return text
    pieces = text.replace(" = ", f"{GLUE}={GLUE}").split(", ")
    return ", ".join(piece.replace(" ", GLUE) if len(piece) <= KEPT_TOGETHER else piece for piece in pieces)


def _table(columns: Sequence[Column], spacing: int) -> Any:
    from rich import box
    from rich.table import Table
    from rich.text import Text

    table = Table(box=box.SIMPLE_HEAD, padding=(0, 1) if spacing == WIDE else (0, 1, 0, 0), pad_edge=spacing == WIDE)
    for column in columns:
        table.add_column(Text("\n".join(column.lines(column.heading))), width=column.width, no_wrap=True)
    for row in range(len(columns[0].cells)):
        table.add_row(*(Text("\n".join(column.lines(column.cells[row]))) for column in columns))
    return table
