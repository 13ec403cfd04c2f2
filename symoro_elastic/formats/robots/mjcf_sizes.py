"""How large an MJCF text makes a model: copies and announced numbers, bounded before MuJoCo reads it."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from xml.etree.ElementTree import Element

from symoro_elastic.foundation.errors import InputError

MOST_COPIES = 1000
MOST_COPIED = 20_000
"""Elements that all <replicate> of a model make together."""
MOST_NUMBERS = 10_000_000
MOST_IN_MESH = 100
"""Of each of the first two numbers of a mesh that MuJoCo makes: how finely it is divided."""
EACH = ("nuserdata", "nkey", "nsample", "actdim", "dim")
"""Attributes that give some elements so many numbers each; those of <size> that begin with nuser_, too."""
FIELDS = ("hfield", "texture")
"""Elements that are fields of so many rows and columns."""


@dataclass
class Sizes:
    """What is counted of a model: its elements with copies, those that are copies, and numbers for an element."""

    elements: int = 0
    copied: int = 0
    each: int = 0

    def add(self, element: Element, copies: int, file: str) -> None:
        """Count an element; raises `InputError` where a model is too large for a machine."""
        if copies > MOST_COPIES:
            raise InputError(file, "replicate", f"it makes more than {MOST_COPIES} copies: too many for a machine")
        self.elements += copies
        self.copied += copies if copies > 1 else 0
        if self.copied > MOST_COPIED:
            what = f"copies make more than {MOST_COPIED} elements: too many for a machine"
            raise InputError(file, "replicate", what)
        for name in element.attrib:
            if name.startswith("nuser_") or name in EACH:
                self.each = max(self.each, _number(element, name))
                self._refuse(self.each * self.elements, f"<{element.tag}> {name}", file)
        if element.tag in FIELDS:
            numbers = math.prod(max(_number(element, key), 1) for key in ("nrow", "ncol", "width", "height"))
            self._refuse(numbers, f"<{element.tag}>", file)
        self._refuse(self.each * self.elements, f"<{element.tag}>", file)
        _refuse_mesh(element, file)

    def _refuse(self, numbers: float, place: str, file: str) -> None:
        if numbers > MOST_NUMBERS:
            what = f"the model would hold more than {MOST_NUMBERS:.0e} numbers: give a smaller size"
            raise InputError(file, place, what)


def _refuse_mesh(element: Element, file: str) -> None:
    """Raise `InputError` for a mesh that MuJoCo would make of very many triangles."""
    if element.tag == "mesh" and "builtin" in element.attrib:
        for word in element.get("params", "").split()[:2]:
            if _value(word) > MOST_IN_MESH:
                what = f"params divide it into more than {MOST_IN_MESH} parts: give less"
                raise InputError(file, "<mesh>", what)


def with_copies(root: Element, before: int) -> Iterator[tuple[Element, int]]:
    """Yield every element in its order, with how often each <replicate> around it repeats it."""
    waiting = [(root, before)]
    while waiting:
        element, times = waiting.pop()
        if element.tag == "replicate":
            times *= int(min(_number(element, "count", 1), MOST_COPIES + 1))
        yield element, times
        waiting += ((child, times) for child in reversed(element))


def _number(element: Element, key: str, default: int = 0) -> int:
    """Return the whole number of an attribute, 0 for a negative one."""
    value = _value(element.get(key, "")) if element.get(key, "").strip() else default
    return int(min(value, 10**18))


def _value(word: str) -> float:
    """Return a number that is at least what MuJoCo may take a word for: without bound where it is no number."""
    for read in (float, lambda text: float(int(text, 0))):
        try:
            value = read(word.strip())
        except (ValueError, OverflowError):
            continue
        return math.inf if math.isnan(value) else max(value, 0.0)
    return math.inf
