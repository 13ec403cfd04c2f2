"""The one file that the live page follows: its versions, cells written to it, undone and done again.

A version is a digest of the bytes. Whoever writes names the version that it has seen: a file that was saved elsewhere
meanwhile is left as it is.
"""

from __future__ import annotations

import hashlib
import os
from collections.abc import Awaitable, Callable
from typing import Any

from symoro_elastic.formats.files import MAX_BYTES
from symoro_elastic.formats.toml.editing import MOST_CHARACTERS, with_cell
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.foundation.input_files import read_file
from symoro_elastic.foundation.output_files import permission, write_file
from symoro_elastic.machine.format_names import TOML

MOST_UNDONE = 100
BYTE_ORDER_MARK = "\ufeff"
Fault = Callable[[str], Awaitable[str]]
"""Returns what is wrong with a text as a machine; nothing where it is one."""


class Conflict(Exception):
    """The file is another one than the page has seen."""


def version_of(content: bytes) -> str:
    """Return the version of a file with this content."""
    return hashlib.sha256(content).hexdigest()[:32]


class FollowedFile:
    """A machine file, by the path of the file itself where the name is a link."""

    def __init__(self, path: str) -> None:
        self.name = os.path.basename(path)
        self.path = os.path.realpath(path)
        self._written: list[tuple[bytes, bytes]] = []
        self._undone: list[tuple[bytes, bytes]] = []

    def content(self) -> bytes:
        """Return the bytes of the file; raises `InputError`."""
        content = read_file(self.path, most=MAX_BYTES + 1)
        if len(content) > MAX_BYTES:
            raise InputError(self.path, "file", f"larger than {MAX_BYTES // 10**6} MB")
        return content

    @property
    def undoable(self) -> int:
        """How many changes can be undone."""
        return len(self._written)

    @property
    def redoable(self) -> int:
        """How many changes that were undone can be made again."""
        return len(self._undone)

    async def write_cell(self, seen: str, path: list[Any], new: str, fault: Fault) -> None:
        """Write one cell where the file is still the version that was seen, and is a machine with it.

        Raises `Conflict`, and `InputError` where nothing is written as it would be no machine.
        """
        before = self._content_of(seen)
        if not self.path.lower().endswith(TOML.suffixes) or len(before) > MOST_CHARACTERS:
            raise InputError(self.path, "file", "is not edited here: change it in an editor")
        text = before.decode("utf-8")
        mark = BYTE_ORDER_MARK if text.startswith(BYTE_ORDER_MARK) else ""
        found = with_cell(text.removeprefix(mark), path, new, self.path)
        if said := await fault(found):
            raise InputError(self.path, "not written", said)
        after = (mark + found).encode("utf-8")
        self._replace(seen, after)
        self._written = [*self._written, (before, after)][-MOST_UNDONE:]
        self._undone.clear()

    def undo(self) -> None:
        """Bring the file back to what it was before the last cell; raises `Conflict` where it was saved since."""
        if not self._written:
            raise InputError(self.path, "undo", "no change made here is left to undo")
        before, after = self._written[-1]
        self._replace(version_of(after), before)
        self._undone.append(self._written.pop())

    def redo(self) -> None:
        """Make the change again that was undone last; raises `Conflict` where the file was saved since."""
        if not self._undone:
            raise InputError(self.path, "redo", "no change is undone")
        before, after = self._undone[-1]
        self._replace(version_of(before), after)
        self._written.append(self._undone.pop())

    def _replace(self, seen: str, content: bytes) -> None:
        self._content_of(seen)
        with permission(force=True):
            write_file(content, self.path)

    def _content_of(self, seen: str) -> bytes:
        """The content of the version that was seen; raises `Conflict` for another one."""
        content = self.content()
        if version_of(content) != seen:
            raise Conflict(f"{self.name} was saved elsewhere since: nothing is written; look at it, and try again")
        return content
