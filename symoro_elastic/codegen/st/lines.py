"""Lines of Structured Text: statements of at most eight operators a line, comments that hold a user's text."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Iterator, Sequence

WIDTH = 110
MOST_OPERATORS = 8
INDENT = "  "
_OPERATOR = re.compile(r" [+-] |[*/]")


def statement(head: str, right: str) -> list[str]:
    """Return `head` and `right;`, broken before signs or else after `*` and `/`, at the outermost brackets."""
    indent = head[: len(head) - len(head.lstrip())] + INDENT * 2
    first, *more = _pieces(right, WIDTH - len(head) - 1, WIDTH - len(indent) - 1)
    lines = [head + first, *(indent + piece for piece in more)]
    return [*lines[:-1], f"{lines[-1]};"]


def _pieces(text: str, room: int, later: int) -> Iterator[str]:
    """A text in pieces; `room` is that of the first, `later` that of others."""
    breaks = _breaks(text)
    start = 0
    while True:
        fitting = [x for x in breaks if x[0] > start and len(text[start : x[0]].rstrip()) <= room]
        crowded = [sign for _, _, sign in breaks if sign >= start][MOST_OPERATORS:]
        if len(text) - start <= room and not crowded:
            break
        if crowded:
            fitting = [x for x in fitting if x[0] <= crowded[0]]
        if not fitting:
            fitting = [x for x in breaks if x[0] > start][:1]
        if not fitting:
            break
        half = start + (fitting[-1][0] - start) // 2
        end = min((depth, -place) for place, depth, _ in fitting if place >= half)[1]
        yield text[start:-end].rstrip()
        start, room = -end, later
    yield text[start:]


def _breaks(text: str) -> list[tuple[int, int, int]]:
    """Where a line may begin, how deep that is, and where the operator of it stands."""
    depths, depth = [], 0
    for character in text:
        depth += (character == "(") - (character == ")")
        depths.append(depth)
    found = []
    for operator in _OPERATOR.finditer(text):
        place = operator.start() + 1
        is_sum = operator[0][0] == " "
        found.append((place if is_sum else operator.end(), depths[place - 1] * 2 + (not is_sum), place - (not is_sum)))
    return found


def call(head: str, arguments: Sequence[str]) -> list[str]:
    """Return `head(arguments);`, on lines of their own where they are long."""
    line = f"{head}({', '.join(arguments)});"
    indent = head[: len(head) - len(head.lstrip())] + INDENT * 2
    if len(line) <= WIDTH:
        return [line]
    whole = ", ".join(argument.replace(" ", "\0") for argument in arguments)
    lines = textwrap.wrap(f"{whole});", WIDTH, initial_indent=indent, subsequent_indent=indent, break_on_hyphens=False)
    return [f"{head}(", *(line.replace("\0", " ") for line in lines)]


def comment(text: str, indent: str = "") -> list[str]:
    """Return a comment, broken into lines where it is long."""
    first = f"{indent}(* "
    return textwrap.wrap(
        f"{in_comment(text)} *)",
        WIDTH,
        initial_indent=first,
        subsequent_indent=" " * len(first),
        break_long_words=False,
    )


def in_comment(text: str) -> str:
    """A user's text as it may stand in a comment: one line that neither ends it nor begins another."""
    line = "".join(character if character.isprintable() else " " for character in text)
    for mark, apart in (("(*", "( *"), ("*)", "* )"), ("/*", "/ *"), ("*/", "* /"), ("{", "("), ("}", ")")):
        line = line.replace(mark, apart)
    return line


def declarations(names: Sequence[str], type_: str, indent: str) -> list[str]:
    """Return declarations of variables of one type, many a line."""
    lines = textwrap.wrap(", ".join(names), WIDTH - len(type_) - 4, break_long_words=False)
    return [f"{indent}{line.rstrip(',')} : {type_};" for line in lines]
