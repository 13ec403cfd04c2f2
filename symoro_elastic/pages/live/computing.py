"""Work in processes of its own, which are ended when it is no longer wanted.

They are forked from a process that has all that they need, so that each begins within milliseconds; whatever
happens to one, the page is still served.
"""

from __future__ import annotations

import asyncio
import json
import multiprocessing
import signal
from collections.abc import Callable, Iterator
from contextlib import suppress
from functools import cache
from multiprocessing import forkserver
from multiprocessing.connection import Connection
from multiprocessing.context import BaseContext
from typing import Any

from symoro_elastic.foundation.errors import InputError

PARTS, WARM = "symoro_elastic.pages.live.parts", "symoro_elastic.pages.live.warm"
FAILED = "failed"
Told = Callable[[str, Any, str], None]
"""Called with name, data and page of each part."""


@cache
def _context() -> BaseContext:
    """Processes forked from one that has imported `WARM`."""
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
    """Parts that a generator of `PARTS` yields in another process, reported one after the other as they come."""

    def __init__(self, told: Told, name: str, *arguments: str) -> None:
        self._told = told
        self._loop = asyncio.get_running_loop()
        self._ended: asyncio.Future[None] = self._loop.create_future()
        self._ours, theirs = _context().Pipe(duplex=False)
        process = _context().Process(target=_run, args=(theirs, name, arguments), daemon=True)  # type: ignore[attr-defined]
        process.start()
        theirs.close()
        self._process = process
        self._loop.add_reader(self._ours.fileno(), self._receive)

    def _receive(self) -> None:
        try:
            told = json.loads(self._ours.recv_bytes())
        except (EOFError, OSError):
            self.drop()
        else:
            self._told(*told)

    def drop(self) -> None:
        """End the process, whatever it computes; nothing more is reported."""
        if self._ended.done():
            return
        self._ended.set_result(None)
        self._loop.remove_reader(self._ours.fileno())
        self._ours.close()
        self._process.kill()
        self._process.join()

    async def ended(self) -> None:
        """Wait until all parts are reported, or the work was dropped."""
        await self._ended


def _run(ours: Connection, name: str, arguments: tuple[str, ...]) -> None:
    """Send the parts of a generator, the last one a sentence where it failed; in the other process."""
    from importlib import import_module

    with suppress(BrokenPipeError), ours:
        try:
            made: Iterator[Any] = getattr(import_module(PARTS), name)(*arguments)
            for part in made:
                ours.send_bytes(json.dumps((part.name, part.data, part.page)).encode())
        except BrokenPipeError:
            raise
        except Exception as error:
            ours.send_bytes(json.dumps((FAILED, f"{type(error).__name__}: {error}", "")).encode())
