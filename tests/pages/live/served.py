"""A live page that is served within the test's own process, and a client of it."""

from __future__ import annotations

import asyncio
import http.client
import json
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple
from urllib.parse import urlsplit

from symoro_elastic.foundation.errors import InputError
from symoro_elastic.pages.live import following, parts
from symoro_elastic.pages.live.handlers import serve

LONGEST = 30.0
"""s after which what does not come is an error."""


class WorkHere:
    """Work without a process: all parts are told at once."""

    def __init__(self, told: Callable[[str, Any, str], None], name: str, *arguments: str | bytes) -> None:
        for part in getattr(parts, name)(*arguments):
            told(part.name, part.data, part.page)

    def drop(self) -> None:
        pass

    async def ended(self) -> None:
        pass


class Answer(NamedTuple):
    status: int
    text: str
    headers: dict[str, str]


@dataclass(frozen=True)
class Served:
    """The address of a live page."""

    address: str

    @property
    def host(self) -> str:
        return urlsplit(self.address).netloc

    def ask(self, path: str = "", body: Any = None, whole: str = "", **headers: str) -> Answer:
        """Ask for a path below the address (or a `whole` one); with a body, as the page itself posts."""
        of_page = {"Origin": f"http://{self.host}", "Content-Type": "application/json"} if body is not None else {}
        named = {key.replace("_", "-"): x for key, x in headers.items()}
        sent = {key: x for key, x in {"Host": self.host, **of_page, **named}.items() if x}
        connection = http.client.HTTPConnection(self.host, timeout=LONGEST)
        try:
            connection.putrequest("GET" if body is None else "POST", whole or urlsplit(self.address).path + path,
                                  skip_host=True)  # fmt: skip
            content = body if isinstance(body, bytes) else json.dumps(body).encode() if body is not None else b""
            for key, x in {**sent, **({"Content-Length": str(len(content))} if body is not None else {})}.items():
                connection.putheader(key, x)
            connection.endheaders(content or None)
            answer = connection.getresponse()
            return Answer(answer.status, answer.read().decode(), dict(answer.getheaders()))
        finally:
            connection.close()

    @contextmanager
    def watching(self) -> Iterator[Watching]:
        """The stream of news."""
        connection = http.client.HTTPConnection(self.host, timeout=LONGEST)
        connection.request("GET", urlsplit(self.address).path + "events")
        try:
            yield Watching(connection.getresponse(), {})
        finally:
            connection.close()


@dataclass
class Watching:
    """The parts that a stream has told."""

    stream: http.client.HTTPResponse
    parts: dict[str, Any]

    def until(self, holds: Callable[[dict[str, Any]], Any]) -> dict[str, Any]:
        """Read news until something holds of the parts, and return these."""
        end = time.monotonic() + LONGEST
        while not holds(self.parts):
            assert time.monotonic() < end, self.parts.keys()
            line = self.stream.readline()
            assert line, "the stream ended"
            if line.startswith(b"data: "):
                self.parts.update(json.loads(line[6:]))
        return self.parts


@contextmanager
def serving(path: Path, work: Any = WorkHere) -> Iterator[Served]:
    """Serve a file in a thread."""
    addresses: list[str] = []
    errors: list[BaseException] = []
    ends: list[Callable[[], object]] = []

    async def run() -> None:
        loop, task = asyncio.get_running_loop(), asyncio.current_task()
        ends.append(lambda: loop.call_soon_threadsafe(task.cancel))  # type: ignore[union-attr]
        try:
            await serve(str(path), 0, addresses.append)
        except InputError as error:
            errors.append(error)
        except asyncio.CancelledError:
            pass

    before, following.Work = following.Work, work
    thread = threading.Thread(target=lambda: asyncio.run(run()))
    thread.start()
    try:
        end = time.monotonic() + LONGEST
        while not addresses and not errors and time.monotonic() < end:
            time.sleep(0.01)
        if errors:
            raise errors[0]
        yield Served(addresses[0])
    finally:
        with suppress(RuntimeError):  # it has ended
            ends[0]()
        thread.join(LONGEST)
        following.Work = before
