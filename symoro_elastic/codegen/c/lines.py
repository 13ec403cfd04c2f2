"""Lines of C of at most `WIDTH` characters: statements, signatures, calls and comments broken where they are long."""

from __future__ import annotations

import textwrap
from collections.abc import Iterator, Sequence

WIDTH = 120
INDENT = "    "
LAST_RESORT = 50
"""Cost of a break inside a product or before an argument, added to its depth: such breaks are a last resort."""


def wrap_lines(text: str) -> str:
    """Return C with lines of at most `WIDTH` characters, as far as names allow; directives are unchanged."""
    return "\n".join(line if len(line) <= WIDTH else _fit(line) for line in text.split("\n"))


def _fit(line: str) -> str:
    indent = line[: len(line) - len(line.lstrip())]
    code, opening, remark = line.partition("/* ")
    if line.lstrip().startswith("#"):
        return line
    if line.startswith("/* ") and not line.endswith("*/"):
        return "\n".join(textwrap.wrap(line, WIDTH, subsequent_indent=" * ", break_long_words=False))
    if line.lstrip().startswith("* "):
        first = indent + "*" + " " * (len(line[len(indent) + 1 :]) - len(line[len(indent) + 1 :].lstrip()))
        return "\n".join(textwrap.wrap(line, WIDTH, subsequent_indent=f"{first}  ", break_long_words=False))
    if opening and remark.endswith(" */"):
        above = comment(remark.removesuffix(" */"), indent)
        return f"{above}\n{_fit(code.rstrip())}" if code.strip() else above
    return statement(indent, line.lstrip()) if len(line) > WIDTH else line


def statement(head: str, right: str) -> str:
    """Return `head` and `right`, broken before signs and after commas of the outermost brackets that suffice."""
    if len(head) + len(right) <= WIDTH:
        return head + right
    indent = head[: len(head) - len(head.lstrip())] + INDENT
    return f"\n{indent}".join(_fill(head, right, indent))


def _fill(head: str, text: str, indent: str) -> Iterator[str]:
    breaks, start, room = _breaks(text), 0, WIDTH - len(head)
    while len(text) - start > room:
        fitting = [(k, cost) for k, cost in breaks if start < k and len(text[start:k].rstrip()) <= room]
        later = [(k, cost) for k, cost in breaks if k > start]
        if not fitting and head.strip():
            yield head.rstrip()
        elif fitting or later:
            end = _best(fitting, start + room // 2) if fitting else later[0][0]
            yield head + text[start:end].rstrip()
            start = end
        else:
            break
        head, room = "", WIDTH - len(indent)
    yield head + text[start:]


def _best(fitting: Sequence[tuple[int, int]], enough: int) -> int:
    """Last of the cheapest line breaks that fill at least half a line, else of all that fit."""
    far = [(cost, -k) for k, cost in fitting if k >= enough] or [(cost, -k) for k, cost in fitting]
    return -min(far)[1]


def _breaks(text: str) -> list[tuple[int, int]]:
    """Return the possible line breaks as (position, cost)."""
    breaks, depth = [], 0
    for k, character in enumerate(text):
        depth += (character == "(") - (character == ")")
        if text[k - 1 : k + 2] in (" + ", " - ") or text[k - 2 : k] == ", ":
            breaks.append((k, depth))
        elif text[k - 1 : k] in ("*", "/", "(", "[") and k:
            breaks.append((k, LAST_RESORT + depth))
    return breaks


def with_arguments(head: str, arguments: Sequence[str], end: str = ")") -> str:
    """Return `head(arguments)` on one line, or with arguments filled into lines of their own."""
    line = f"{head}({', '.join(arguments)}{end}"
    if len(line) <= WIDTH:
        return line
    indent = " " * (len(head) - len(head.lstrip())) + INDENT
    lines = [indent]
    for k, argument in enumerate(arguments):
        piece = argument + (", " if k + 1 < len(arguments) else end)
        if len(lines[-1]) > len(indent) and len(lines[-1]) + len(piece.rstrip()) > WIDTH:
            lines.append(indent)
        lines[-1] += piece
    return "\n".join([f"{head}(", *(line.rstrip() for line in lines)])


def comment(text: str, indent: str = "", first: str = "/* ") -> str:
    """Return a comment, its lines after the first marked by a star."""
    lines = textwrap.wrap(
        f"{first}{text} */", WIDTH, initial_indent=indent, subsequent_indent=f"{indent} * ", break_long_words=False
    )
    return "\n".join(lines)


def in_comment(text: str) -> str:
    """A user's text made safe for a comment: a single line that does not end the comment."""
    line = "".join(character if character.isprintable() else " " for character in text)
    return line.replace("*/", "* /").replace("/*", "/ *")
