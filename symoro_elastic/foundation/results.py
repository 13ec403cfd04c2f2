"""Results: data with units, and their views.

A class of results holds its data. How it is printed and exported is registered by class in the module `views` of its
room, how it is drawn in `plots`, with the functions below. Both are imported when a result is first shown, so that data
know no table and no plot. A field is declared once: JSON, arrays, data frames and tables use its name, unit and digits
from there.
"""

from __future__ import annotations

import re
import warnings
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
    """Rows of texts below heads; the first `keys` columns repeat in every part of a wide table."""

    heads: tuple[str, ...]
    rows: list[tuple[str, ...]] = field(default_factory=list)
    title: str = ""
    keys: int = 1

    def add_row(self, *cells: str) -> None:
        """Append a row; missing cells are empty."""
        self.rows.append((*cells, *[""] * (len(self.heads) - len(cells))))

    @property
    def columns(self) -> list[tuple[str, tuple[str, ...]]]:
        """Head and cells of the columns."""
        return [(head, tuple(row[k] for row in self.rows)) for k, head in enumerate(self.heads)]


Part: TypeAlias = str | Table
"""A sentence, or a table."""


@dataclass(frozen=True)
class Field:
    """A field of a result or of its rows, declared once for JSON, arrays, data frames and tables.

    `value` gets it from the result, or names its attribute, by default `name`. It is in JSON if `json`, in arrays if
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
        """Return the value of this field in a result."""
        return self.value(result) if callable(self.value) else attrgetter(self.value or self.name)(result)

    @property
    def title(self) -> str:
        """Head of its column, with the unit."""
        return f"{self.head}, {self.unit}" if self.unit else self.head or ""

    def cell(self, result: Any) -> str:
        """Return the text of this field in a table: a dash for an unknown value."""
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
    """Return the declared fields of a class."""
    _load(kind, "views")
    return next((_FIELDS[base] for base in kind.__mro__ if base in _FIELDS), ())


def table_of(kind: type, rows: Iterable[Any], title: str = "", keys: int = 1) -> Table:
    """Return a table of rows of a class, with its fields that have a head."""
    shown = [field for field in fields_of(kind) if field.head is not None]
    return Table(tuple(x.title for x in shown), [tuple(f.cell(x) for f in shown) for x in rows], title, keys)


@singledispatch
def parts_of(result: Any) -> Sequence[Part]:
    """Return tables and sentences that show a result, in their order. Registered by class."""
    return [result.headline]


@singledispatch
def json_of(result: Any) -> dict[str, Any]:
    """Return a result, or a row of one, as plain data for JSON: its fields, unless registered otherwise."""
    return {item.name: plain(item.of(result)) for item in fields_of(type(result)) if item.json}


@singledispatch
def arrays_of(result: Any) -> Mapping[str, Any]:
    """Return the arrays and names of a result: its fields, unless registered otherwise."""
    values = ((item.name, item.of(result)) for item in fields_of(type(result)) if item.array)
    return {name: list(x) if isinstance(x, tuple) else x for name, x in values}


@singledispatch
def columns_of(result: Any) -> Mapping[str, Sequence[Any] | AnyArray]:
    """Return the columns of the data frame of a result: of fields, or of rows, unless registered otherwise."""
    columns: dict[str, Any] = {}
    for item in fields_of(type(result)):
        x = item.of(result) if item.column or item.rows else {}
        if item.rows:
            rows = x.values() if isinstance(x, Mapping) else x
            columns |= {x.column: [x.of(row) for row in rows] for x in fields_of(item.rows) if x.column}
        else:
            by_name = x if isinstance(x, Mapping) else {"": x}
            columns |= {item.column.format(name): row for name, row in by_name.items()}
    return columns


@singledispatch
def figures_of(result: Any) -> Mapping[str, Plot | str]:
    """Return the plots of a result, by name, the main one first; or the reason why one would be empty.

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
        return [plain(entry) for entry in x]
    if isinstance(x, complex):
        return [plain(x.real), plain(x.imag)]
    if isinstance(x, float):
        return x if isfinite(x) else None
    return x if x is None or isinstance(x, int | str) else json_of(x) or x


def _load(kind: type, name: str) -> None:
    """Import the modules `views` or `plots` of a class and its bases, which register its views."""
    for base in kind.__mro__:
        if base.__module__.startswith("symoro_elastic."):
            _import(f"{base.__module__.rpartition('.')[0]}.{name}")


@cache
def _import(module: str) -> None:
    if find_spec(module):
        import_module(module)


class Shown:
    """A value with a short `repr`, and a page of HTML in a notebook."""

    @property
    def headline(self) -> str:
        """Description of the value in a few words."""
        return type(self).__name__

    def parts(self) -> Sequence[Part]:
        """Return tables and sentences that show the value, in order."""
        _load(type(self), "views")
        return parts_of(self)

    def summary(self) -> str:
        """Return the sentences that show the value, without its tables: the headline where there are none."""
        return "\n".join(part for part in self.parts() if isinstance(part, str)) or self.headline

    def table(self) -> Table:
        """Return the main table; raises `TypeError` for a value without one."""
        for part in self.parts():
            if isinstance(part, Table):
                return part
        raise TypeError(f"{type(self).__name__} has no table: use its attributes")

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
        """Return the columns of `to_frame` by name, of one length."""
        _load(type(self), "views")
        return dict(columns_of(self)) or self._refuse("rows")

    def to_frame(self) -> Any:
        """Return a pandas data frame, a row a sample, mode or estimate; raises `InputError` without pandas."""
        return import_optional("pandas", "a data frame", "notebook").DataFrame(self.columns())

    @property
    def frame(self) -> Callable[[], Any]:
        """`to_frame` under its former name."""
        warnings.warn("frame is now to_frame", DeprecationWarning, stacklevel=2)
        return self.to_frame

    def plots(self) -> Figures:
        """Return all figures by name, which notebooks show and `save` writes."""
        from symoro_elastic.foundation.pictures import Figures

        _load(type(self), "plots")
        figures = figures_of(self)
        return Figures(figures) if figures else self._refuse("plots")

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
    """Return a page as a part of another, its styles and names isolated."""
    style = "width:100%;height:40em;border:1px solid #ccc"
    return f'<iframe srcdoc="{escape(page, quote=True)}" style="{style}" title="page"></iframe>'


def as_html(part: Part) -> str:
    """Return a sentence or a table as HTML; decimal points of a column are aligned."""
    if isinstance(part, str):
        return f"<pre>{escape(part)}</pre>" if "\n" in part else f"<p>{escape(part)}</p>"
    title = f"<caption>{escape(part.title)}</caption>" if part.title else ""
    sides = ["right" if all(map(_is_number, cells)) else "left" for _, cells in part.columns]
    columns = [_align_points(cells) if side == "right" else [*map(escape, cells)] for side, (_, cells) in
               zip(sides, part.columns, strict=True)]  # fmt: skip
    heads = _row("th", part.heads, map(_with_unit, part.heads), sides)
    rows = "".join(_row("td", part.heads, row, sides) for row in zip(*columns, strict=True))
    return f"{TABLE}{title}<thead>{heads}</thead><tbody>{rows}</tbody></table>"


def _row(tag: str, heads: Sequence[str], cells: Iterable[str], sides: Sequence[str]) -> str:
    """A row of cells; on narrow pages each cell of the body names its head."""
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


def _align_points(cells: Sequence[str]) -> list[str]:
    """Return numbers padded by hidden digits, so that decimal points align."""
    matches = [NUMBER.fullmatch(cell) for cell in cells]
    if not all(match or cell in ("-", "") for match, cell in zip(matches, cells, strict=True)):
        return [*map(escape, cells)]
    tails = [match[1] if match else None for match in matches]
    longest = max((tail for tail in tails if tail), key=len, default="")
    rests = ["" if tail is None else longest[len(tail) :] for tail in tails]
    hidden = '<span style="visibility:hidden" aria-hidden="true">{}</span>'
    return [escape(cell) + (hidden.format(rest) if rest else "") for cell, rest in zip(cells, rests, strict=True)]


def _is_number(cell: str) -> bool:
    """Return whether a cell begins like a number; true for a dash."""
    return cell.lstrip("+-")[:1].isdigit() or cell in ("-", "")
