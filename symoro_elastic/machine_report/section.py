"""Sections of a page, as HTML: texts of a machine are escaped where they become part of one."""

from __future__ import annotations

import base64
import re
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from html import escape

from symoro_elastic.errors import InputError
from symoro_elastic.results import Part, Result, Titled, as_html

MANY_DIGITS = re.compile(r"(?<![\w.])\d+\.\d{7,}(?:e[-+]?\d+)?(?![\w.])")


@dataclass(frozen=True)
class Section:
    """A title, and blocks of HTML; `anchor` is its name in links."""

    anchor: str
    title: str
    blocks: tuple[str, ...]


def section(anchor: str, title: str, make: Callable[[], Iterable[str]]) -> Section:
    """Return a section; what refuses to be computed is said in one line in its place."""
    try:
        blocks = tuple(make())
    except InputError as error:
        blocks = (paragraph(f"Not computed: {error.place}: {error.what}", "refused"),)
    return Section(anchor, title, blocks)


def shown(result: Result) -> list[str]:
    """Return the parts of a result as blocks."""
    return [block(part) for part in result.parts()]


def block(part: Part) -> str:
    """Return a sentence or a table; a table that is too wide moves sideways within its block."""
    if isinstance(part, Titled):
        name = escape(part.title or "table", quote=True)
        return f'<div class="wide" role="region" tabindex="0" aria-label="{name}">{shortened(as_html(part))}</div>'
    return as_html(part)


def shortened(table: str) -> str:
    """Return a table with numbers of many digits to six of them; the file has them all."""
    return MANY_DIGITS.sub(lambda number: f"{float(number[0]):.6g}", table)


def paragraph(text: str, kind: str = "") -> str:
    """Return a sentence as a block of a class of styles."""
    return f'<p class="{kind}">{escape(text)}</p>' if kind else f"<p>{escape(text)}</p>"


def image(svg: str | bytes, described: str, caption: str = "", kind: str = "machine") -> str:
    """Return a picture within the page, described for those who do not see it; `kind` is its class of styles."""
    data = base64.b64encode(svg if isinstance(svg, bytes) else svg.encode("utf-8")).decode("ascii")
    below = f"<figcaption>{escape(caption)}</figcaption>" if caption else ""
    source = f"data:image/svg+xml;base64,{data}"
    return f'<figure><img class="{kind}" src="{source}" alt="{escape(described, quote=True)}">{below}</figure>'


def folded(title: str, blocks: Sequence[str], opened: bool = False) -> str:
    """Return blocks under a title that opens and closes them; those that are open are printed."""
    state = " open" if opened else ""
    return f"<details{state}><summary>{escape(title)}</summary>{''.join(blocks)}</details>"
