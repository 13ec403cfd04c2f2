"""Symbols of printed equations linked to where they are defined."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

Content = dict[str, Any]
INNER = re.compile(r'<math displaystyle="true">(.*)</math>', re.DOTALL)
TAG = re.compile(r"<(/?)m\w+[^>]*?(/?)>")
COMPOSED = re.compile(r"<(msub|msup|msubsup|mover|mrow)\b.*</\1>", re.DOTALL)


def with_links(content: Content, prefix: str) -> Content:
    """Return the content of a page with names for its lines and parameters, and symbols linked to them."""
    lines = [*_lines(content)]
    for k, line in enumerate(lines, start=1):
        line["anchor"] = f"{prefix}line{k}"
    for k, line in enumerate(content["short"], start=1):
        line["anchor"] = f"{prefix}written{k}"
    for k, parameter in enumerate(content["parameters"], start=1):
        parameter["anchor"] = f"{prefix}parameter{k}"
    defined = {symbol: one["anchor"] for one in content["parameters"] if (symbol := _symbol(one["symbol"]))}
    defined |= {symbol: line["anchor"] for line in lines if (symbol := _symbol(line["left"]))}
    for line in (*lines, *content["short"]):
        line["right"] = linked(line["right"], defined)
    return content


def linked(formula: str, defined: Mapping[str, str]) -> str:
    """Return a formula in MathML whose symbols name the elements that define them; the outermost where they nest."""
    parts, end = [], 0
    for start, stop in _elements(formula):
        if start >= end and (anchor := defined.get(formula[start:stop])):
            parts += [formula[end:start], f'<mrow data-of="{anchor}">', formula[start:stop], "</mrow>"]
            end = stop
    return "".join([*parts, formula[end:]])


def _elements(formula: str) -> list[tuple[int, int]]:
    """Where elements begin and end, in the order in which they begin."""
    found, opened = [], []
    for tag in TAG.finditer(formula):
        if tag[1]:
            found.append((opened.pop(), tag.end()))
        elif not tag[2]:
            opened.append(tag.start())
    return sorted(found)


def _lines(content: Content) -> Iterator[dict[str, str]]:
    chapters: Sequence[Content] = content["chapters"]
    for chapter in chapters:
        for stretch in chapter["stretches"]:
            yield from stretch["lines"]


def _symbol(math: str) -> str:
    """The MathML of a symbol that is one element of several, as others stand within words; else empty."""
    found = INNER.fullmatch(math)
    return found[1] if found and COMPOSED.fullmatch(found[1]) else ""
