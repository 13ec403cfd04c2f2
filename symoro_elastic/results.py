"""Results that show themselves in a terminal and in a notebook, and convert to arrays and data frames."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from html import escape
from typing import TYPE_CHECKING, Any, TypeAlias

from symoro_elastic.packages import imported

if TYPE_CHECKING:
    from symoro_elastic.array_types import AnyArray

TABLE = '<table style="border-collapse:collapse;margin:0.5em 0">'
CELL = "padding:0.15em 1em 0.15em 0;text-align:{}"


@dataclass(frozen=True)
class Titled:
    """A table of rich with a title; its first `keys` columns stand in every part where it is too wide for a line."""

    table: Any
    title: str = ""
    keys: int = 1


Part: TypeAlias = str | Titled
"""A sentence, or a table."""


class Shown:
    """A value with a short `repr`, and a page of HTML in a notebook."""

    @property
    def headline(self) -> str:
        """What the value is, in a few words."""
        return type(self).__name__

    def parts(self) -> Sequence[Part]:
        """Return tables and sentences that show the value, in their order."""
        return [self.headline]

    def __repr__(self) -> str:
        """Return one line that names the value and its size."""
        return f"<{self.headline}>"

    def _repr_html_(self) -> str:
        """Return the parts as HTML."""
        return "\n".join(as_html(part) for part in self.parts())


class Result(Shown):
    """A result that also converts to arrays, to a data frame and to plain data for JSON."""

    def as_json(self) -> dict[str, Any]:
        """Return the figures as plain data, as the command line prints them with --json."""
        raise TypeError(f"{type(self).__name__} has no figures of its own: take its attributes")

    def arrays(self) -> dict[str, AnyArray]:
        """Return the figures by name, as files of the command line hold them; SI units, radians."""
        raise TypeError(f"{type(self).__name__} has no arrays of its own: take its attributes")

    def columns(self) -> Mapping[str, Sequence[Any] | AnyArray]:
        """Return the columns of `frame` by name, of one length."""
        raise TypeError(f"{type(self).__name__} is no table: take its attributes")

    def frame(self) -> Any:
        """Return a pandas data frame, a row a sample, mode or estimate; raises `InputError` without pandas."""
        return imported("pandas", "a data frame", "notebook").DataFrame(dict(self.columns()))


def framed(page: str) -> str:
    """Return a whole page as a part of another: its styles and names stay within."""
    style = "width:100%;height:40em;border:1px solid #ccc"
    return f'<iframe srcdoc="{escape(page, quote=True)}" style="{style}" title="page"></iframe>'


def as_html(part: Part) -> str:
    """Return a sentence or a table as HTML."""
    if isinstance(part, str):
        return f"<pre>{escape(part)}</pre>" if "\n" in part else f"<p>{escape(part)}</p>"
    table, title = part.table, f"<caption>{escape(part.title)}</caption>" if part.title else ""
    sides = ["right" if column.justify == "right" else "left" for column in table.columns]
    heads = _row("th", [column.header for column in table.columns], sides)
    cells = zip(*(column.cells for column in table.columns), strict=True) if table.columns else ()
    rows = "".join(_row("td", row, sides) for row in cells)
    return f"{TABLE}{title}<thead>{heads}</thead><tbody>{rows}</tbody></table>"


def _row(tag: str, cells: Sequence[Any], sides: Sequence[str]) -> str:
    entries = (
        f'<{tag} style="{CELL.format(side)}">{escape(_text(cell))}</{tag}>'
        for cell, side in zip(cells, sides, strict=True)
    )
    return f"<tr>{''.join(entries)}</tr>"


def _text(cell: Any) -> str:
    """Return the plain text of a cell: markup of rich is not read, texts of files may look like it."""
    return str(getattr(cell, "plain", cell))
