"""Texts in the files of tests: names with units in brackets, pairs OUT/IN, nodes and directions."""

from __future__ import annotations

import re
from dataclasses import dataclass

from symoro_elastic.foundation.array_types import Array, ComplexArray

_NODE = re.compile(r"(?P<node>\d+):(?P<sign>[+-]?)(?P<axis>R?[XYZ]|S)", re.ASCII)


@dataclass(frozen=True)
class FileResponse:
    """A response as its file has it: f (N) in Hz, H (N), which is `scale` times `unit`, None where it names none."""

    name: str
    unit: str | None
    f: Array
    H: ComplexArray
    coherence: Array | None
    place: str
    scale: float = 1.0


def split_pair(text: str) -> tuple[str, str] | None:
    """Return OUT and IN of `OUT/IN`; slashes in brackets belong to points. None where there is not one slash."""
    depth, slashes = 0, []
    for k, sign in enumerate(text):
        depth += (sign == "(") - (sign == ")")
        if sign == "/" and depth == 0:
            slashes.append(k)
    return (text[: slashes[0]].strip(), text[slashes[0] + 1 :].strip()) if len(slashes) == 1 else None


def pair_name(text: str) -> str:
    """Return the name of a pair of a file without spaces about its slash."""
    parts = split_pair(text)
    return "/".join(parts) if parts else text


def normal_name(text: str) -> tuple[str, float]:
    """Return a name such as `3:-Z/1:X` in positive directions, `3:+Z/1:+X`, and its sign; other texts as they are."""
    ends = [_NODE.fullmatch(end.strip()) for end in text.split("/")]
    sign = 1.0
    named = []
    for end in ends:
        if end is None:
            return text, 1.0
        sign *= -1.0 if end["sign"] == "-" else 1.0
        named.append(f"{int(end['node'])}:{'' if end['axis'] == 'S' else '+'}{end['axis']}")
    return "/".join(named), sign
