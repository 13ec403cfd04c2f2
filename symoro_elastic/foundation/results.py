"""Results: data with units, and how they are shown.

A class of results holds its data. How it is printed and exported is registered by class in the module `views` of its
room, how it is drawn in `plots`, with the functions below. Both are imported when a result is first shown, so that data
know no table and no plot. A field is declared once: JSON, arrays, data frames and tables take its name, unit and digits
from there.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache, singledispatch
from html import escape
from importlib import import_module
from importlib.util import find_spec
from math import isfinite, isnan
from operator import attrgetter
from typing import TYPE_CHECKING, Any, TypeAlias

from symoro_elastic.foundation.packages import import_optional

if TYPE_CHECKING:
    from symoro_elastic.foundation.array_types import AnyArray
    from symoro_elastic.foundation.pictures import Figures, Plot

TABLE = '<table style="border-collapse:collapse;margin:0.5em 0">'
NUMBER = re.compile(r"[-+]?\d+((?:\.\d+)?(?:e[-+]?\d+)?)(?: ?%)?")
"""A number; the group is what follows its whole part."""
CELL = "padding:0.15em 1em 0.15em 0;text-align:{}"


@dataclass
class Table:
    """Rows of texts below heads; the first `keys` columns stand in every part where it is too wide for a line."""

    heads: tuple[str, ...]
    rows: list[tuple[str, ...]] = field(default_factory=list)
    title: str = ""
    keys: int = 1

    def add_row(self, *cells: str) -> None:
        """Append a row; cells that are left out are empty."""
        self.rows.append((*cells, *[""] * (len(self.heads) - len(cells))))

    @property
    def columns(self) -> list[tuple[str, tuple[str, ...]]]:
        """Head and cells of each column."""
        return [(head, tuple(row[k] for row in self.rows)) for k, head in enumerate(self.heads)]


Part: TypeAlias = str | Table
"""A sentence, or a table."""


@dataclass(frozen=True)
class Field:
    """A field of a result or of its rows, declared once: JSON, arrays, data frames and tables take it from here.

    `value` takes it from the result, or names its attribute, by default `name`. It is in JSON if `json`, in arrays if
    `array`, and in data frames if it has a name there, `column`; a mapping has a column for each of its keys, as in
    "strain in {}". Objects of a class `rows` are the rows of the data frame. In tables it stands below `head` with
    its `unit`, as `text`, or as a number in the format `form`; without a head it is in no table.
    """

    name: str
    value: Callable[[Any], Any] | str = ""
    head: str | None = None
    unit: str = ""
    form: str = ".4g"
    text: Callable[[Any], str] | None = None
    json: bool = True
    array: bool = False
    column: str = ""
    rows: type | None = None

    def of(self, result: Any) -> Any:
        """Return the value of a result."""
        return self.value(result) if callable(self.value) else attrgetter(self.value or self.name)(result)

    @property
    def title(self) -> str:
        """Head of its column, with the unit."""
        return f"{self.head}, {self.unit}" if self.unit else self.head or ""

    def cell(self, result: Any) -> str:
        """Return its text in a table: a dash for what is not known."""
        if self.text:
            return self.text(result)
        x = self.of(result)
        if x is None or (isinstance(x, float) and isnan(x)):
            return "-"
        return format(x, self.form) if isinstance(x, float) else str(x)


_FIELDS: dict[type, tuple[Field, ...]] = {}


def declare(kind: type, *fields: Field) -> None:
    """Declare the fields of a class of results, or of the rows of one."""
    _FIELDS[kind] = fields


def fields_of(kind: type) -> tuple[Field, ...]:
    """Return the fields that are declared for a class."""
    _load(kind, "views")
    return next((_FIELDS[each] for each in kind.__mro__ if each in _FIELDS), ())


def table_of(kind: type, rows: Iterable[Any], title: str = "", keys: int = 1) -> Table:
    """Return a table of rows of a class: its fields that have a head."""
    shown = [each for each in fields_of(kind) if each.head is not None]
    return Table(tuple(each.title for each in shown), [tuple(f.cell(x) for f in shown) for x in rows], title, keys)


@singledispatch
def parts_of(result: Any) -> Sequence[Part]:
    """Return tables and sentences that show a result, in their order. Registered by class."""
    return [result.headline]


@singledispatch
def json_of(result: Any) -> dict[str, Any]:
    """Return a result, or a row of one, as plain data for JSON: its fields, unless registered otherwise."""
    return {each.name: plain(each.of(result)) for each in fields_of(type(result)) if each.json}


@singledispatch
def arrays_of(result: Any) -> Mapping[str, Any]:
    """Return the arrays and names of a result: its fields, unless registered otherwise."""
    values = ((each.name, each.of(result)) for each in fields_of(type(result)) if each.array)
    return {name: list(x) if isinstance(x, tuple) else x for name, x in values}


@singledispatch
def columns_of(result: Any) -> Mapping[str, Sequence[Any] | AnyArray]:
    """Return the columns of the data frame of a result: of fields, or of rows, unless registered otherwise."""
    columns: dict[str, Any] = {}
    for each in fields_of(type(result)):
        x = each.of(result) if each.column or each.rows else {}
        if each.rows:
            rows = x.values() if isinstance(x, Mapping) else x
            columns |= {one.column: [one.of(row) for row in rows] for one in fields_of(each.rows) if one.column}
        else:
            by_name = x if isinstance(x, Mapping) else {"": x}
            columns |= {each.column.format(name): row for name, row in by_name.items()}
    return columns


@singledispatch
def figures_of(result: Any) -> Mapping[str, Plot | str]:
    """Return the plots that draw a result, by name, the main one first; a reason in place of one that says nothing.

    Registered by class in `plots` of its room.
    """
    return {}


def plain(x: Any) -> Any:
    """Return arrays, complex numbers, NaN and rows as JSON has them: lists, [real, imaginary], null, objects."""
    if hasattr(x, "tolist"):
        return plain(x.tolist())
    if isinstance(x, Mapping):
        return {str(key): plain(value) for key, value in x.items()}
    if isinstance(x, list | tuple):
        return [plain(each) for each in x]
    if isinstance(x, complex):
        return [plain(x.real), plain(x.imag)]
    if isinstance(x, float):
        return x if isfinite(x) else None
    return x if x is None or isinstance(x, int | str) else json_of(x) or x


def _load(kind: type, name: str) -> None:
    """Import the modules `views` or `plots` beside a class and its bases, which register how it is shown."""
    for each in kind.__mro__:
        if each.__module__.startswith("symoro_elastic."):
            _import(f"{each.__module__.rpartition('.')[0]}.{name}")


@cache
def _import(module: str) -> None:
    if find_spec(module):
        import_module(module)


class Shown:
    """A value with a short `repr`, and a page of HTML in a notebook."""

    @property
    def headline(self) -> str:
        """What the value is, in a few words."""
        return type(self).__name__

    def parts(self) -> Sequence[Part]:
        """Return tables and sentences that show the value, in their order."""
        _load(type(self), "views")
        return parts_of(self)

    def __repr__(self) -> str:
        """Return one line that names the value and its size."""
        return f"<{self.headline}>"

    def _repr_html_(self) -> str:
        """Return the parts as HTML."""
        return "\n".join(as_html(part) for part in self.parts())


class Result(Shown):
    """A result that also converts to arrays, to a data frame and to plain data for JSON, and draws itself."""

    def as_json(self) -> dict[str, Any]:
        """Return the results as plain data, as the command line prints them with --json."""
        _load(type(self), "views")
        return json_of(self) or self._refuse("data")

    def arrays(self) -> dict[str, AnyArray]:
        """Return the results by name, as files of the command line hold them; SI units, radians."""
        _load(type(self), "views")
        return dict(arrays_of(self)) or self._refuse("arrays")

    def columns(self) -> dict[str, Sequence[Any] | AnyArray]:
        """Return the columns of `frame` by name, of one length."""
        _load(type(self), "views")
        return dict(columns_of(self)) or self._refuse("rows")

    def frame(self) -> Any:
        """Return a pandas data frame, a row a sample, mode or estimate; raises `InputError` without pandas."""
        return import_optional("pandas", "a data frame", "notebook").DataFrame(self.columns())

    def plots(self) -> Figures:
        """Return all figures by name, which a notebook shows and `save` writes."""
        from symoro_elastic.foundation.pictures import Figures

        _load(type(self), "plots")
        found = figures_of(self)
        return Figures(found) if found else self._refuse("plots")

    def plot(self, name: str = "", axes: Any = None, *, dark: bool = False) -> Any:
        """Return a figure of matplotlib: that of a name in `plots`, by default the first; on dark paper if `dark`.

        `axes`, one or as many as the plot needs, are drawn into and returned instead. Raises `InputError` for unknown
        names, another number of axes, and without matplotlib.
        """
        plot = self.plots().plot(name)
        return plot.figure(dark=dark) if axes is None else plot.into(axes)

    def _refuse(self, what: str) -> Any:
        raise TypeError(f"{type(self).__name__} has no {what}: use its attributes")


def inline_page(page: str) -> str:
    """Return a whole page as a part of another: its styles and names stay within."""
    style = "width:100%;height:40em;border:1px solid #ccc"
    return f'<iframe srcdoc="{escape(page, quote=True)}" style="{style}" title="page"></iframe>'


def as_html(part: Part) -> str:
    """Return a sentence or a table as HTML; numbers of a column stand with their points below each other."""
    if isinstance(part, str):
        return f"<pre>{escape(part)}</pre>" if "\n" in part else f"<p>{escape(part)}</p>"
    title = f"<caption>{escape(part.title)}</caption>" if part.title else ""
    sides = ["right" if all(map(_is_number, cells)) else "left" for _, cells in part.columns]
    columns = [_aligned(cells) if side == "right" else [*map(escape, cells)] for side, (_, cells) in
               zip(sides, part.columns, strict=True)]  # fmt: skip
    heads = _row("th", part.heads, map(_with_unit, part.heads), sides)
    rows = "".join(_row("td", part.heads, row, sides) for row in zip(*columns, strict=True))
    return f"{TABLE}{title}<thead>{heads}</thead><tbody>{rows}</tbody></table>"


def _row(tag: str, heads: Sequence[str], cells: Iterable[str], sides: Sequence[str]) -> str:
    """A row of cells; on narrow pages a cell of the body names its head."""
    entries = (
        f'<{tag} style="{CELL.format(side)}"{named}>{cell}</{tag}>'
        for head, cell, side in zip(heads, cells, sides, strict=True)
        for named in ([f' data-head="{escape(head)}"'] if tag == "td" else [""])
    )
    return f"<tr>{''.join(entries)}</tr>"


def _with_unit(head: str) -> str:
    """A head as HTML, whose unit stays on one line."""
    what, comma, unit = head.partition(", ")
    return escape(what + comma + unit.replace(" ", "\u00a0"))


def _aligned(cells: Sequence[str]) -> list[str]:
    """Return numbers, each with what the longest fraction has more, hidden: so that points are below each other."""
    found = [NUMBER.fullmatch(cell) for cell in cells]
    if not all(one or cell in ("-", "") for one, cell in zip(found, cells, strict=True)):
        return [*map(escape, cells)]
    tails = [one[1] if one else None for one in found]
    longest = max((tail for tail in tails if tail), key=len, default="")
    rests = ["" if tail is None else longest[len(tail) :] for tail in tails]
    hidden = '<span style="visibility:hidden" aria-hidden="true">{}</span>'
    return [escape(cell) + (hidden.format(rest) if rest else "") for cell, rest in zip(cells, rests, strict=True)]


def _is_number(cell: str) -> bool:
    """Return whether a cell begins as a number does, a dash for none included."""
    return cell.lstrip("+-")[:1].isdigit() or cell in ("-", "")
