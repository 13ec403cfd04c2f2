"""XML text as elements: no DOCTYPE, no entities, nothing from outside, bounded in depth and number."""

from __future__ import annotations

from xml.etree.ElementTree import Element, TreeBuilder
from xml.parsers import expat

from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.names import quote

MOST_DEPTH = 400
MOST_ELEMENTS = 200_000


def root_element(text: str, source: str) -> Element:
    """Parse an XML text, which may begin with empty lines, to its root element; raises `InputError` with the line."""
    body = text.lstrip()
    reader = _Reader(source, text.count("\n", 0, len(text) - len(body)))
    try:
        reader.parser.Parse(body, True)
    except expat.ExpatError as error:
        what = f"no XML: {expat.ErrorString(error.code)}"
        raise InputError(source, f"line {reader.line}, column {error.offset + 1}", what) from None
    return reader.builder.close()


class _Reader:
    """XML parser that records line numbers and limits the size."""

    def __init__(self, source: str, lines_before: int) -> None:
        self.source, self.lines_before = source, lines_before
        self.builder, self.depth, self.count = TreeBuilder(), 0, 0
        self.parser = expat.ParserCreate()
        self.parser.buffer_text = True
        self.parser.StartDoctypeDeclHandler = self._refuse_doctype
        self.parser.StartElementHandler = self._start
        self.parser.EndElementHandler = self._end
        self.parser.CharacterDataHandler = self.builder.data

    def _refuse_doctype(self, *_: object) -> None:
        raise self._wrong("a DOCTYPE, which may hold entities: remove it")

    def _start(self, tag: str, attributes: dict[str, str]) -> None:
        self.depth, self.count = self.depth + 1, self.count + 1
        if self.depth > MOST_DEPTH:
            raise self._wrong(f"elements are nested more than {MOST_DEPTH} deep: too deep for a description of a robot")
        if self.count > MOST_ELEMENTS:
            raise self._wrong(f"more than {MOST_ELEMENTS} elements: too many for a description of a robot")
        self.builder.start(tag, attributes)

    def _end(self, tag: str) -> None:
        self.depth -= 1
        self.builder.end(tag)

    def _wrong(self, what: str) -> InputError:
        return InputError(self.source, f"line {self.line}", what)

    @property
    def line(self) -> int:
        """Line number at which the parser is."""
        return self.lines_before + self.parser.CurrentLineNumber


def numbers(element: Element, key: str, default: str | None, count: int, source: str, place: str) -> list[float]:
    """Numbers in an attribute, `count` of them; raises `InputError` for other counts or without the attribute."""
    text = element.get(key, default)
    if text is None:
        raise InputError(source, place, f"<{element.tag}> lacks {key}")
    words = text.split()
    if len(words) != count:
        what = f"{key} = {quote(text)} must be {'a number' if count == 1 else f'{count} numbers'}"
        raise InputError(source, place, f"<{element.tag}> {what}")
    return [_number(word, f"<{element.tag}> {key}", source, place) for word in words]


def _number(word: str, what: str, source: str, place: str) -> float:
    try:
        value = float("" if "_" in word else word)
    except ValueError:
        raise InputError(source, place, f"{what}: {quote(word)} is not a number") from None
    if not abs(value) < float("inf"):
        raise InputError(source, place, f"{what}: {quote(word)} is not finite")
    return value
