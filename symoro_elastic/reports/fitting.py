"""Tables that fit the width of a terminal: nothing is cut, no name or number is broken that fits in a line.

A table that is too wide has lines wrapped between words, or its columns in several tables below each other, each of
which begins with the first columns: whichever takes fewer lines.
"""

from __future__ import annotations

import textwrap
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

GLUE = "\N{NO-BREAK SPACE}"
KEPT_TOGETHER = 24
"""Most characters between two commas that are kept in one line if the width allows."""
WIDE, NARROW = 3, 2
"""Characters that each column takes beside its text, and one more for the table."""
FEWEST = 8
"""Least width of what stands beside the first columns."""


@dataclass(frozen=True)
class Column:
    """Heading, cells, and the width at which they are wrapped."""

    heading: str
    cells: tuple[str, ...]
    width: int = 0
    together: bool = True

    @property
    def natural(self) -> int:
        """The width at which nothing is wrapped."""
        return max(map(len, (self.heading, *self.cells)))

    @property
    def least(self) -> int:
        """The width at which no word is broken."""
        words = [self.heading.split(), *(_glued(cell, self.together).split(" ") for cell in self.cells)]
        return max((len(word) for line in words for word in line), default=0)

    def lines(self, text: str) -> list[str]:
        """A text in lines of this width; words that are longer are broken."""
        glued = _glued(text, self.together)
        fits = all(len(word) <= self.width for word in glued.split(" "))
        wrapped = textwrap.wrap(glued if fits else text, self.width, break_on_hyphens=False)
        return [line.replace(GLUE, " ") for line in wrapped] or [""]

    def height(self, row: int) -> int:
        """Lines of one cell."""
        return len(self.lines(self.cells[row]))


def fitted(table: Any, width: int, keys: int = 1) -> list[Any]:
    """Return a table of rich as one or more of at most `width` characters; `keys` columns are repeated in each.

    Columns without any text are left out, and so is a table without rows.
    """
    columns = [column for column in _columns(table) if any(column.cells)]
    if not columns:
        return []
    if sum(column.natural + WIDE for column in columns) < width:
        return [_table([replace(column, width=column.natural) for column in columns], WIDE)]
    layouts = [layout for layout in _layouts(columns, width, min(keys, len(columns) - 1)) if layout]
    return [_table(part, NARROW) for part in min(layouts, key=_height)]


def _columns(table: Any) -> list[Column]:
    return [Column(str(column.header), tuple(map(str, column.cells))) for column in table.columns]


def _layouts(columns: Sequence[Column], width: int, keys: int) -> Iterator[list[list[Column]]]:
    """Ways to print columns: one table, words kept together or not; several tables, which is always possible."""
    for together in (True, False):
        one = _shared([replace(column, together=together) for column in columns], width)
        yield [one] if one else []
    yield _parts(columns, width, keys)


def _shared(columns: Sequence[Column], width: int) -> list[Column]:
    """Columns that share a line, none narrower than its longest word; empty where there is no room."""
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
    left = -1
    for column in columns[keys:]:
        wanted = replace(column, width=min(column.natural, max(room - NARROW, FEWEST)))
        if left < wanted.width + NARROW:
            parts.append(list(first))
            left = room
        parts[-1].append(wanted)
        left -= wanted.width + NARROW
    return parts or [first]


def _keys(columns: Sequence[Column], width: int) -> list[Column]:
    """The columns that stand in each table: within the width or, so that no word is broken, a little more."""
    share = width // max(len(columns), 1) - NARROW
    loose = [replace(column, together=False) for column in columns]
    unbroken = [max(column.least, min(column.natural, share)) for column in loose]
    fits = sum(unbroken) <= 3 * width // 2
    return [replace(c, width=w if fits else min(w, share)) for c, w in zip(loose, unbroken, strict=True)]


def _height(layout: Sequence[Sequence[Column]]) -> int:
    """Lines of all tables of a layout, with four for the head of each."""
    return sum(4 + sum(max(c.height(row) for c in part) for row in range(len(part[0].cells))) for part in layout)


def _glued(text: str, together: bool) -> str:
    """A text with spaces that do not break where a name, a sign and a number belong together."""
    if not together:
        return text
    pieces = text.replace(" = ", f"{GLUE}={GLUE}").split(", ")
    return ", ".join(piece.replace(" ", GLUE) if len(piece) <= KEPT_TOGETHER else piece for piece in pieces)


def _table(columns: Sequence[Column], beside: int) -> Any:
    from rich import box
    from rich.table import Table
    from rich.text import Text

    table = Table(box=box.SIMPLE_HEAD, padding=(0, 1) if beside == WIDE else (0, 1, 0, 0), pad_edge=beside == WIDE)
    for column in columns:
        table.add_column(Text("\n".join(column.lines(column.heading))), width=column.width, no_wrap=True)
    for row in range(len(columns[0].cells)):
        table.add_row(*(Text("\n".join(column.lines(column.cells[row]))) for column in columns))
    return table
