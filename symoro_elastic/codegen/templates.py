"""The templates, wherever the package is: in a wheel, an editable install or a checkout."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from fractions import Fraction
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from symoro_elastic.foundation.input_files import shipped_folder

if TYPE_CHECKING:
    from jinja2 import Environment

LINE = 100
DIGEST = "\ue000" * 9
"""Placeholder of the digest of files in templates; texts of users do not contain this character."""


def template_folder() -> Path:
    """The folder of templates; raises `FileNotFoundError` with the places that were searched."""
    return shipped_folder("templates", "c")


@cache
def environment() -> Environment:
    """The template environment; an undefined name is an error, not an empty string."""
    import jinja2

    jinja = jinja2.Environment(
        loader=jinja2.FileSystemLoader(template_folder()),
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
        autoescape=False,
        finalize=_written,
    )
    jinja.globals["digest"] = DIGEST
    jinja.filters["join"] = lambda items, between="": between.join(str(_written(x)) for x in items)
    jinja.filters["tuple_line"] = lambda items: in_brackets("(", items, ")")
    jinja.filters["list_line"] = lambda items: in_brackets("[", items, "]")
    return jinja


def _written(x: Any) -> Any:
    """Text of a value in a template: text, integer, decimal. Raises `TypeError` for a fraction.

    C reads 1/2 as a division of whole numbers, which is 0: `Literals.number` writes the literal of a precision.
    """
    if isinstance(x, Fraction):
        raise TypeError(f"{x} is a fraction: give the template the literal of a precision")
    return x


def render(template: str, **context: Any) -> str:
    """Return the text of a template rendered with a context."""
    return environment().get_template(template).render(**context)


def with_digest(files: Mapping[str, str]) -> dict[str, str]:
    """Return files with nine digits of their common SHA-256 inserted, which reveal files of different generations."""
    texts = "\0".join(f"{name}\0{files[name]}" for name in sorted(files))
    least = 10 ** (len(DIGEST) - 1)  # no digest begins with 0, which is an octal number in C
    digest = str(least + int(hashlib.sha256(texts.encode()).hexdigest(), 16) % (9 * least))
    return {name: text.replace(DIGEST, digest) for name, text in files.items()}


def in_brackets(opening: str, items: Sequence[Any], closing: str) -> str:
    """Python source of a tuple or list, broken into lines where it is long."""
    texts = [f'"{item}"' if type(item) is str else str(item) for item in items]
    line = ", ".join(texts) + ("," if opening == "(" and len(texts) == 1 else "")
    if len(line) <= LINE - 20:
        return f"{opening}{line}{closing}"
    lines, current = [], ""
    for text in texts:
        if current and len(current) + len(text) > LINE - 10:
            lines.append(current)
            current = ""
        current += f"{text}, "
    return "\n    ".join([opening, *(line.rstrip() for line in [*lines, current])]) + f"\n{closing}"


class Literal(str):
    """Source text that is not to be quoted."""

    __slots__ = ()
