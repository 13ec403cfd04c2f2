"""Elements of an XML text of a user: no document type, no entities, nothing that lies elsewhere."""

from __future__ import annotations

from typing import NoReturn
from xml.etree.ElementTree import Element, TreeBuilder
from xml.parsers import expat

from symoro_elastic.errors import InputError
from symoro_elastic.machine.names import quoted

DEEPEST = 400
"""Elements inside each other; XML of robots nests a body in a body."""


def root_of(text: str, source: str) -> Element:
    """Return the root element of an XML text.

    Raises `InputError` for what is no XML, for document types and entities, and for elements nested too deep.
    """
    return _Reading(source).root(text)


class _Reading:
    def __init__(self, source: str) -> None:
        self.source, self.depth = source, 0
        self.builder, self.parser = TreeBuilder(), expat.ParserCreate()
        self.parser.buffer_text = True
        self.parser.SetParamEntityParsing(expat.XML_PARAM_ENTITY_PARSING_NEVER)
        self.parser.StartDoctypeDeclHandler = self._document_type
        self.parser.StartElementHandler = self._start
        self.parser.EndElementHandler = self._end
        self.parser.CharacterDataHandler = self.builder.data

    def root(self, text: str) -> Element:
        try:
            self.parser.Parse(text, True)
        except expat.ExpatError as error:
            what = f"it is no XML: {expat.ErrorString(error.code)}"
            raise self._error(what, error.lineno, error.offset + 1) from None
        except UnicodeEncodeError:
            raise InputError(self.source, "file", "it holds a character that no text has: save it as UTF-8") from None
        return self.builder.close()

    def _start(self, name: str, attributes: dict[str, str]) -> None:
        self.depth += 1
        if self.depth > DEEPEST:
            self._refuse(f"more than {DEEPEST} elements are inside each other: no robot is described so")
        self.builder.start(name, attributes)

    def _end(self, name: str) -> None:
        self.depth -= 1
        self.builder.end(name)

    def _document_type(self, name: str, *rest: object) -> None:
        self._refuse(f"the document type {quoted(name)} may name entities and other files: remove <!DOCTYPE ...>")

    def _refuse(self, what: str) -> NoReturn:
        raise self._error(what, self.parser.CurrentLineNumber, self.parser.CurrentColumnNumber + 1)

    def _error(self, what: str, line: int, column: int) -> InputError:
        return InputError(self.source, f"line {line}, column {column}", what)
