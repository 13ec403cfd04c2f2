"""The server of the live page: on this computer only, for who has its address, which holds a random token.

A page of another site can neither read nor write: Host and Origin are checked, edits are JSON that a foreign page may
not send, and no address of the file system comes from a page.
"""

from __future__ import annotations

import asyncio
import json
import secrets
from collections.abc import Callable
from contextlib import aclosing, suppress
from typing import Any

from symoro_elastic.codegen.templates import render, template_folder
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.foundation.input_files import read_file
from symoro_elastic.foundation.packages import import_optional
from symoro_elastic.pages.drawing.page import content_policy
from symoro_elastic.pages.live.followed_file import Conflict, FollowedFile
from symoro_elastic.pages.live.following import Following

HOST = "127.0.0.1"
MOST_POSTED, MOST_HEADERS = 20_000, 16_000
"""Bytes of an edit, and of the headers of a request."""
SCRIPTS = ("view/panel.js", "live/cells.js", "live/live.js")
STYLES = ("view/page.css", "live/live.css")
HEADERS = {
    "Cache-Control": "no-store",
    "Referrer-Policy": "no-referrer",
    "X-Content-Type-Options": "nosniff",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Content-Security-Policy": "default-src 'none'; frame-ancestors 'self'",
}


def live_page() -> str:
    """Return the page itself, without any text of a machine."""
    style, scripts = "\n".join(map(_file, STYLES)), [_file(name) for name in SCRIPTS]
    return render("live/page.html.j2", style=style, scripts=scripts)


def _file(name: str) -> str:
    return read_file(template_folder() / name).decode("utf-8")


def _policy_of_frame(page: str) -> str:
    return f"{content_policy(page)}; img-src data:; frame-ancestors 'self'"


def application(following: Following, token: str, hosts: set[str]) -> Any:
    """Return the application of tornado that serves a file; `hosts` are the names under which it is asked."""
    web = import_optional("tornado.web", "serving a page", "live")
    closed = import_optional("tornado.iostream", "serving a page", "live").StreamClosedError
    page = live_page()
    policy = f"{content_policy(page)}; connect-src 'self'; frame-src 'self'; img-src data:; frame-ancestors 'none'"

    class Handler(web.RequestHandler):  # type: ignore[misc, name-defined]
        """Refuse who has not the token, or comes from elsewhere."""

        def set_default_headers(self) -> None:
            self.clear_header("Server")
            for name, value in HEADERS.items():
                self.set_header(name, value)

        def prepare(self) -> None:
            given = self.request.headers
            origin = given.get("Origin")
            if given.get("Host") not in hosts:
                raise web.HTTPError(403)
            if origin is not None and origin not in {f"http://{host}" for host in hosts}:
                raise web.HTTPError(403)
            if given.get("Sec-Fetch-Site", "none") not in ("none", "same-origin"):
                raise web.HTTPError(403)
            if not secrets.compare_digest(self.path_args[0].encode(), token.encode()):
                raise web.HTTPError(404)

        def write_error(self, status_code: int, **_: Any) -> None:
            self.say(status_code, {403: "not from here", 404: "there is no such page"}.get(status_code, "refused"))

        def say(self, status: int, text: str) -> None:
            """Answer with a sentence."""
            self.set_status(status)
            self.set_header("Content-Type", "text/plain; charset=utf-8")
            self.finish(text)

        def show(self, html: str, its_policy: str) -> None:
            """Answer with a page."""
            self.set_header("Content-Security-Policy", its_policy)
            self.set_header("Content-Type", "text/html; charset=utf-8")
            self.finish(html)

    class Page(Handler):
        def get(self, _token: str) -> None:
            self.show(page, policy)

    class Picture(Handler):
        def get(self, _token: str) -> None:
            if not following.picture:
                raise web.HTTPError(404)
            self.show(following.picture, _policy_of_frame(following.picture))

    class Equations(Handler):
        async def get(self, _token: str) -> None:
            model = self.get_query_argument("model", "")
            if model not in following.parts.get("models", {}).get("titles", ()):
                raise web.HTTPError(404)
            work = asyncio.ensure_future(following.asked("equations_of_file", following.file.path, model))
            self.on_connection_close = work.cancel
            await asyncio.wait([work])
            found = [] if work.cancelled() else [html for _, html in work.result() if html]
            if found:
                self.show(found[-1], _policy_of_frame(found[-1]))
            else:
                self.say(409, "the file was saved meanwhile")

    class Events(Handler):
        async def get(self, _token: str) -> None:
            self.set_header("Content-Type", "text/event-stream")
            reading = asyncio.ensure_future(self._send())
            self.on_connection_close = reading.cancel
            with suppress(asyncio.CancelledError):  # the server ends
                await asyncio.wait([reading])

        async def _send(self) -> None:
            with suppress(closed):
                async with aclosing(following.news()) as news:
                    async for parts in news:
                        self.write(f"data: {json.dumps(parts)}\n\n" if parts else ": \n\n")
                        await self.flush()

    class Change(Handler):
        async def post(self, _token: str) -> None:
            if "Origin" not in self.request.headers or self.request.headers.get("Content-Type") != "application/json":
                raise web.HTTPError(403)
            try:
                await self.change(**json.loads(self.request.body))
            except Conflict as conflict:
                self.say(409, str(conflict))
            except InputError as error:
                self.say(422, f"{error.place}: {error.what}")
            except (TypeError, ValueError, RecursionError):
                raise web.HTTPError(400) from None
            else:
                self.set_header("Content-Type", "application/json")
                self.finish(json.dumps({"version": following.version}))

    class Cell(Change):
        async def change(self, version: str, path: list[Any], text: str) -> None:
            """Write one cell."""
            if not (isinstance(text, str) and isinstance(path, list) and 1 < len(path) < 6):
                raise TypeError(path)
            if any(isinstance(key, bool) or not isinstance(key, str | int) for key in path):
                raise TypeError(path)
            await following.write_cell(str(version), path, text)

    class Undo(Change):
        async def change(self) -> None:
            """Undo the last cell."""
            await following.undo()

    at = {"": Page, "picture": Picture, "equations": Equations, "events": Events, "cell": Cell, "undo": Undo}
    routes = [*((rf"/([^/]+)/{name}", handler) for name, handler in at.items()), (r"/(.*)", Handler)]
    return web.Application(routes, log_function=lambda _: None)


async def serve(path: str, port: int, ready: Callable[[str], None]) -> None:
    """Serve the live page of a machine file until cancelled; `ready` is called with its address.

    Raises `InputError` where the file or the port cannot be had, and where a package is missing.
    """
    netutil = import_optional("tornado.netutil", "serving a page", "live")
    http = import_optional("tornado.httpserver", "serving a page", "live")
    for module in ("watchfiles", "tomlkit"):
        import_optional(module, "following a file", "live")
    following = Following(FollowedFile(path))
    following.file.content()
    try:
        sockets = netutil.bind_sockets(port, HOST)
    except OSError as error:
        what = f"{port} cannot be had ({error.strerror}): give another one, or none"
        raise InputError("symoro-elastic", "--port", what) from None
    bound, token = sockets[0].getsockname()[1], secrets.token_urlsafe(24)
    hosts = {f"{name}:{bound}" for name in (HOST, "localhost")}
    server = http.HTTPServer(
        application(following, token, hosts), max_body_size=MOST_POSTED, max_header_size=MOST_HEADERS,
        body_timeout=10, idle_connection_timeout=600,
    )  # fmt: skip
    server.add_sockets(sockets)
    try:
        ready(f"http://{HOST}:{bound}/{token}/")
        await following.follow()
    finally:
        server.stop()
        following.drop()
