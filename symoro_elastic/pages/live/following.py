"""Contents of the live page, updated with the file: each save starts new work, and ends the previous."""

from __future__ import annotations

import asyncio
import json
import multiprocessing
import os
import signal
import threading
from collections.abc import AsyncGenerator, Callable, Iterator
from contextlib import suppress
from functools import cache
from multiprocessing import forkserver
from multiprocessing.connection import Connection
from multiprocessing.context import BaseContext
from typing import Any

from symoro_elastic.foundation.errors import InputError
from symoro_elastic.foundation.packages import import_optional
from symoro_elastic.pages.live.followed_file import FollowedFile, version_of

QUIET, SETTLED = 10, 60
"""ms: how long nothing changes before a change is reported, and how long is waited for that."""
KEEPS_OPEN = 15.0
"""s after which a stream without news says that it lives."""
PARTS, WARM = "symoro_elastic.pages.live.parts", "symoro_elastic.pages.live.warm"
FAILED = "failed"
Receive = Callable[[str, Any, str], None]
"""Called with name, data and page of the parts."""


class Following:
    """The parts of the page of one file, by name, and the listeners that wait for changes of them."""

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
        """Read the file, and start new work if its version changed."""
        try:
            content = self.file.content()
        except InputError as error:
            self._begin("")
            self._tell("checked", {"error": {"place": error.place, "what": error.what, "line": None}, "warnings": []})
            return
        if version_of(content) == self.version:
            return
        self._begin(version_of(content))
        self._work = Work(self._receive_part, "parts_of_file", self.file.path, content)

    def _begin(self, version: str) -> None:
        """Drop all work for the previous version."""
        self.drop()
        self.version = version
        self._tell("file", {"name": self.file.name, "undo": len(self.file.written), "redo": len(self.file.undone)})

    def drop(self) -> None:
        """End all work."""
        for work in (*self._asked, *([self._work] if self._work else [])):
            work.drop()
        self._asked.clear()
        self._work = None

    def _receive_part(self, name: str, data: Any, page: str) -> None:
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

    async def asked(self, name: str, *arguments: str | bytes) -> list[tuple[Any, str]]:
        """Return data and pages of the parts of work that somebody waits for; fewer where the file was saved since."""
        results: list[tuple[Any, str]] = []
        work = Work(lambda _name, data, page: results.append((data, page)), name, *arguments)
        self._asked.add(work)
        try:
            await work.ended()
        finally:
            work.drop()
            self._asked.discard(work)
        return results

    async def edit(self, how: str, version: str, path: list[Any], new: str) -> None:
        """Make one of `EDITS` of the file, and show it; raises `Conflict` and `InputError`."""

        async def fault(text: str) -> str:
            return next((str(data) for data, _ in await self.asked("fault_of_text", self.file.path, text)), "")

        async with self._editing:
            await self.file.edit(how, version, path, new, fault)
            self.look()

    async def step(self, how: str) -> None:
        """Undo or redo the last change, and show the file; raises `Conflict` and `InputError`."""
        async with self._editing:
            (self.file.undo if how == "undo" else self.file.redo)()
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


@cache
def _context() -> BaseContext:
    """Return the context of processes forked from a server that has imported `WARM`; raises `InputError`."""
    if "forkserver" not in multiprocessing.get_all_start_methods():
        raise InputError("symoro-elastic", "live", "needs a POSIX system: write pages with symoro-elastic view")
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload([WARM])
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)  # inherited: Ctrl+C ends the server, which ends the others
    try:
        forkserver.ensure_running()
    finally:
        signal.signal(signal.SIGINT, before)
    return context


class Work:
    """Parts that a generator of `PARTS` yields in another process, reported as they come.

    A process begins when the one that it is forked from has imported all, for which a thread waits: pages are served.
    """

    def __init__(self, receive: Receive, name: str, *arguments: str | bytes) -> None:
        self._receive_part = receive
        self._loop = asyncio.get_running_loop()
        self._ended: asyncio.Future[None] = self._loop.create_future()
        self._ours, theirs = _context().Pipe(duplex=False)
        self._process = _context().Process(target=_run, args=(theirs, name, arguments), daemon=True)  # type: ignore[attr-defined]
        self._has_begun = False
        self._loop.add_reader(self._ours.fileno(), self._receive)
        threading.Thread(target=self._start, args=(theirs,), daemon=True).start()

    def _start(self, theirs: Connection) -> None:
        """Start the process, from a thread of its own; if that fails, the pipe closes, which ends the work."""
        with theirs, suppress(OSError, EOFError, RuntimeError):  # of the server that ends meanwhile
            self._process.start()
            self._loop.call_soon_threadsafe(self._begin)

    def _begin(self) -> None:
        self._has_begun = True
        if self._ended.done():
            self._end_process()

    def _receive(self) -> None:
        try:
            arguments = json.loads(self._ours.recv_bytes())
        except (EOFError, OSError):
            self.drop()
        else:
            self._receive_part(*arguments)

    def drop(self) -> None:
        """End the process, whatever it computes; nothing more is reported."""
        if self._ended.done():
            return
        self._ended.set_result(None)
        self._loop.remove_reader(self._ours.fileno())
        self._ours.close()
        if self._has_begun:
            self._end_process()

    def _end_process(self) -> None:
        self._process.kill()
        self._process.join()

    async def ended(self) -> None:
        """Wait until all parts are reported, or the work was dropped."""
        await self._ended


def _run(ours: Connection, name: str, arguments: tuple[str | bytes, ...]) -> None:
    """Send the parts of a generator, and the error as a sentence if it fails; in the other process."""
    from importlib import import_module

    with suppress(BrokenPipeError), ours:
        try:
            parts: Iterator[Any] = getattr(import_module(PARTS), name)(*arguments)
            for part in parts:
                ours.send_bytes(json.dumps((part.name, part.data, part.page)).encode())
        except BrokenPipeError:
            raise
        except Exception as error:
            ours.send_bytes(json.dumps((FAILED, f"{type(error).__name__}: {error}", "")).encode())
