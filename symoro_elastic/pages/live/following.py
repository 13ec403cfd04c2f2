"""What the live page shows now, and how it follows the file: each save begins new work, and ends the work before."""

from __future__ import annotations

import asyncio
import os
from collections.abc import AsyncGenerator
from contextlib import suppress
from typing import Any

from symoro_elastic.foundation.errors import InputError
from symoro_elastic.foundation.packages import import_optional
from symoro_elastic.pages.live.computing import FAILED, Work
from symoro_elastic.pages.live.followed_file import FollowedFile, version_of

QUIET, SETTLED = 10, 60
"""ms: how long nothing changes before a change is reported, and how long is waited for that."""
KEEPS_OPEN = 15.0
"""s after which a stream without news says that it lives."""


class Following:
    """The parts of the page of one file, by name, and who waits for news of them."""

    def __init__(self, file: FollowedFile) -> None:
        self.file = file
        self.version = ""
        self.parts: dict[str, Any] = {}
        self.picture = ""
        self._work: Work | None = None
        self._asked: set[Work] = set()
        self._listeners: dict[asyncio.Event, dict[str, None]] = {}
        self._editing = asyncio.Lock()

    def look(self) -> None:
        """Read the file, and begin anew where it is another version than the one shown."""
        try:
            content = self.file.content()
        except InputError as error:
            self._begin("")
            self._tell("checked", {"error": {"place": error.place, "what": error.what, "line": None}, "warnings": []})
            return
        if version_of(content) == self.version:
            return
        self._begin(version_of(content))
        self._work = Work(self._told, "parts_of_file", self.file.path, content.decode("utf-8-sig", "replace"))

    def _begin(self, version: str) -> None:
        """Drop all work for the version before."""
        self.drop()
        self.version = version
        self._tell("file", {"name": self.file.name, "undo": self.file.undoable, "redo": self.file.redoable})

    def drop(self) -> None:
        """End all work."""
        for work in (*self._asked, *([self._work] if self._work else [])):
            work.drop()
        self._asked.clear()
        self._work = None

    def _told(self, name: str, data: Any, page: str) -> None:
        if name == FAILED:
            self._tell("checked", {"error": {"place": "computing", "what": data, "line": None}, "warnings": []})
            return
        if page:
            self.picture = page
        self._tell(name, data)

    def _tell(self, name: str, data: Any) -> None:
        self.parts[name] = {**data, "version": self.version}
        for wake, waiting in self._listeners.items():
            waiting[name] = None
            wake.set()

    async def news(self) -> AsyncGenerator[dict[str, Any], None]:
        """Yield all parts there are, then those that are new as they come; nothing in it where none came for long."""
        waiting: dict[str, None] = dict.fromkeys(self.parts)
        wake = asyncio.Event()
        self._listeners[wake] = waiting
        try:
            while True:
                names = [*waiting]
                waiting.clear()
                wake.clear()
                yield {name: self.parts[name] for name in names}
                if not waiting:
                    with suppress(TimeoutError):
                        await asyncio.wait_for(wake.wait(), KEEPS_OPEN)
        finally:
            del self._listeners[wake]

    async def asked(self, name: str, *arguments: str) -> list[tuple[Any, str]]:
        """Return data and pages of the parts of work that somebody waits for; fewer where the file was saved since."""
        found: list[tuple[Any, str]] = []
        work = Work(lambda _name, data, page: found.append((data, page)), name, *arguments)
        self._asked.add(work)
        try:
            await work.ended()
        finally:
            work.drop()
            self._asked.discard(work)
        return found

    async def write_cell(self, seen: str, path: list[Any], new: str) -> None:
        """Write one cell to the file, and show it; raises `Conflict` and `InputError`."""

        async def fault(text: str) -> str:
            return next((str(data) for data, _ in await self.asked("fault_of_text", self.file.path, text)), "")

        async with self._editing:
            await self.file.write_cell(seen, path, new, fault)
            self.look()

    async def undo(self) -> None:
        """Undo the last cell, and show it; raises `Conflict` and `InputError`."""
        async with self._editing:
            self.file.undo()
            self.look()

    async def redo(self) -> None:
        """Write the cell again that was undone last, and show it; raises `Conflict` and `InputError`."""
        async with self._editing:
            self.file.redo()
            self.look()

    async def follow(self) -> None:
        """Look whenever the file is saved, until cancelled."""
        watchfiles = import_optional("watchfiles", "following a file", "live")
        folder, name = os.path.split(self.file.path)
        changes = watchfiles.awatch(
            folder, watch_filter=lambda _, path: os.path.basename(path) == name, step=QUIET, debounce=SETTLED,
            recursive=False,
        )  # fmt: skip
        self.look()
        async for _ in changes:
            self.look()
