"""The file of the live page: its versions, cells written to it, undo and redo.

A version is a digest of the bytes. Whoever writes names the version that it has seen: a file that was saved elsewhere
meanwhile is left as it is.
"""

from __future__ import annotations

import codecs
import hashlib
import os
from collections.abc import Awaitable, Callable
from typing import Any

from symoro_elastic.formats.files import MAX_BYTES, text_of
from symoro_elastic.formats.toml.editing import MOST_CHARACTERS, with_cell
from symoro_elastic.formats.toml.entries import with_entry, without_entry
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.foundation.input_files import read_file
from symoro_elastic.foundation.output_files import permission, write_file
from symoro_elastic.machine.format_names import TOML

MOST_UNDONE = 100
EDITS = {"cell": with_cell, "add": with_entry, "remove": without_entry}
"""Changes of a text at a path, by name."""
Fault = Callable[[str], Awaitable[str]]
"""Returns what is wrong with a text as a machine; nothing where it is one."""


class Conflict(Exception):
    """The file differs from the version of the page."""


def version_of(content: bytes) -> str:
    """Return the version of a file with this content."""
    return hashlib.sha256(content).hexdigest()[:32]


class FollowedFile:
    """A machine file, by the real path if the name is a link: changes `written` and `undone`, before and after each."""

    def __init__(self, path: str) -> None:
        self.name = os.path.basename(path)
        self.path = os.path.realpath(path)
        self.written: list[tuple[bytes, bytes]] = []
        self.undone: list[tuple[bytes, bytes]] = []

    def content(self) -> bytes:
        """Return the bytes of the file; raises `InputError`, also if a link replaced it."""
        if os.path.realpath(self.path) != self.path:
            raise InputError(self.path, "file", "is a link now, which it was not: start again with the file itself")
        content = read_file(self.path, most=MAX_BYTES + 1, follow=False)
        if len(content) > MAX_BYTES:
            raise InputError(self.path, "file", f"larger than {MAX_BYTES // 10**6} MB")
        return content

    async def edit(self, how: str, version: str, path: list[Any], new: str, fault: Fault) -> None:
        """Make one of `EDITS` where the file is still the version that was seen, and is a machine with it.

        Raises `Conflict`, and `InputError` where nothing is written as it would be no machine.
        """
        before = self._content_of(version)
        if not self.path.lower().endswith(TOML.suffixes) or len(before) > MOST_CHARACTERS:
            raise InputError(self.path, "file", "is not edited here: change it in an editor")
        mark = codecs.BOM_UTF8 if before.startswith(codecs.BOM_UTF8) else b""
        edited = EDITS[how](text_of(before, self.path), path, new, self.path)
        if message := await fault(edited):
            raise InputError(self.path, "not written", message)
        after = mark + edited.encode("utf-8")
        self._replace(version, after)
        self.written = [*self.written, (before, after)][-MOST_UNDONE:]
        self.undone.clear()

    def undo(self) -> None:
        """Restore the file before the last written cell; raises `Conflict` if it was saved since."""
        if not self.written:
            raise InputError(self.path, "undo", "no change made here is left to undo")
        before, after = self.written[-1]
        self._replace(version_of(after), before)
        self.undone.append(self.written.pop())

    def redo(self) -> None:
        """Make the last undone change again; raises `Conflict` if the file was saved since."""
        if not self.undone:
            raise InputError(self.path, "redo", "no change is undone")
        before, after = self.undone[-1]
        self._replace(version_of(before), after)
        self.written.append(self.undone.pop())

    def _replace(self, version: str, content: bytes) -> None:
        self._content_of(version)
        with permission(force=True):
            write_file(content, self.path, follow=False)

    def _content_of(self, version: str) -> bytes:
        """Return the content of a version; raises `Conflict` for another one."""
        content = self.content()
        if version_of(content) != version:
            raise Conflict(f"{self.name} was saved elsewhere since: nothing is written; look at it, and try again")
        return content
