"""Request handlers of the live page, with their checks of origin and token; imported if tornado is installed."""

from __future__ import annotations

import asyncio
import gc
import json
import secrets
from collections.abc import Callable, Mapping
from contextlib import aclosing, suppress
from dataclasses import dataclass
from typing import Any

from tornado import web
from tornado.iostream import StreamClosedError
from tornado.log import app_log

from symoro_elastic.codegen.templates import render, template_folder
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.foundation.input_files import read_file
from symoro_elastic.foundation.packages import import_optional
from symoro_elastic.pages.drawing.page import content_policy
from symoro_elastic.pages.live.followed_file import EDITS, Conflict, FollowedFile
from symoro_elastic.pages.live.following import Following

SCRIPTS = ("view/panel.js", "live/picture.js", "live/cells.js", "live/live.js")
STYLES = ("view/page.css", "live/live.css")
HEADERS = {
    "Cache-Control": "no-store",
    "Referrer-Policy": "no-referrer",
    "X-Content-Type-Options": "nosniff",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Content-Security-Policy": "default-src 'none'; frame-ancestors 'self'",
}
SHORTEST, LONGEST = {"cell": 2, "add": 1, "remove": 2}, 6
"""Least length of the path of an edit, as keys at the top are only added, and the length that is too long."""
REFUSED = {403: "not from here", 404: "page not found"}
HOST = "127.0.0.1"
COLLECTED_AFTER = 700, 10, 10
"""New objects after which Python looks for cyclic garbage, as edits leave: its own values, not those of commands."""
MOST_POSTED, MOST_HEADERS = 20_000, 16_000
"""Bytes of an edit, and of the headers of a request."""


async def serve(path: str, port: int, ready: Callable[[str], None]) -> None:
    """Serve the live page of a machine file until cancelled; `ready` is called with its address.

    Raises `InputError` where the file or the port cannot be had, and where a package is missing.
    """
    netutil = import_optional("tornado.netutil", "serving a page", "live")
    http = import_optional("tornado.httpserver", "serving a page", "live")
    for module in ("watchfiles", "tomlkit"):
        import_optional(module, "following a file", "live")
    from symoro_elastic.pages.live.handlers import Site, application

    following = Following(FollowedFile(path))
    following.file.content()
    try:
        sockets = netutil.bind_sockets(port, HOST)
    except OSError as error:
        what = f"{port} cannot be had ({error.strerror}): give another one, or none"
        raise InputError("symoro-elastic", "--port", what) from None
    bound, token = sockets[0].getsockname()[1], secrets.token_urlsafe(24)
    hosts = frozenset(f"{name}:{bound}" for name in (HOST, "localhost"))
    server = http.HTTPServer(
        application(Site(following, token, hosts)), max_body_size=MOST_POSTED, max_header_size=MOST_HEADERS,
        body_timeout=10, idle_connection_timeout=600,
    )  # fmt: skip
    server.add_sockets(sockets)
    before = gc.get_threshold()
    gc.set_threshold(*COLLECTED_AFTER)
    try:
        ready(f"http://{HOST}:{bound}/{token}/")
        await following.follow()
    finally:
        gc.set_threshold(*before)
        server.stop()
        following.drop()


@dataclass(frozen=True)
class Site:
    """The served site: the parts of a file, below a `token`, for requests to one of the `hosts`."""

    following: Following
    token: str
    hosts: frozenset[str]


def live_page() -> str:
    """Return the page itself, without any text of a machine."""
    style, scripts = "\n".join(map(_file, STYLES)), [_file(name) for name in SCRIPTS]
    return render("live/page.html.j2", style=style, scripts=scripts)


def _file(name: str) -> str:
    return read_file(template_folder() / name).decode("utf-8")


class Handler(web.RequestHandler):
    """Base of request handlers: rejects requests without the token or from another origin."""

    def initialize(self, site: Site) -> None:
        """Store the served site."""
        self.site, self.following = site, site.following

    def set_default_headers(self) -> None:
        """Set the security headers."""
        self.clear_header("Server")
        for name, value in HEADERS.items():
            self.set_header(name, value)

    def prepare(self) -> None:
        """Check origin and target of a request before any work."""
        headers, hosts = self.request.headers, self.site.hosts
        origin = headers.get("Origin")
        is_foreign = origin is not None and origin not in {f"http://{host}" for host in hosts}
        is_sent_by_others = headers.get("Sec-Fetch-Site", "none") not in ("none", "same-origin")
        if headers.get("Host") not in hosts or is_foreign or is_sent_by_others:
            raise web.HTTPError(403)
        if not secrets.compare_digest(self.path_args[0].encode(), self.site.token.encode()):
            raise web.HTTPError(404)

    def write_error(self, status_code: int, **_: Any) -> None:
        """Answer an error with a few words."""
        self.say(status_code, REFUSED.get(status_code, "refused"))

    def log_exception(self, kind: Any, error: Any, trace: Any) -> None:
        """Log an error of the program, without the address of the request, which holds the token."""
        if not isinstance(error, web.HTTPError):
            app_log.error("error of the program", exc_info=(kind, error, trace))

    def say(self, status: int, text: str) -> None:
        """Answer with a sentence."""
        self.set_status(status)
        self.set_header("Content-Type", "text/plain; charset=utf-8")
        self.finish(text)

    def show(self, html: str, more: str) -> None:
        """Answer with an HTML page; `more` extends its Content-Security-Policy."""
        self.set_header("Content-Security-Policy", f"{content_policy(html)}; img-src data:; {more}")
        self.set_header("Content-Type", "text/html; charset=utf-8")
        self.finish(html)


class Page(Handler):
    """Handler of the page itself."""

    def get(self, _token: str) -> None:
        """Answer with the page."""
        self.show(live_page(), "connect-src 'self'; frame-src 'self'; frame-ancestors 'none'")


class Picture(Handler):
    """The picture of the last good machine."""

    def get(self, _token: str) -> None:
        """Answer with the page of the machine."""
        if not self.following.picture:
            raise web.HTTPError(404)
        self.show(self.following.picture, "frame-ancestors 'self'")


class Equations(Handler):
    """The equations of a model, computed on request."""

    async def get(self, _token: str) -> None:
        """Answer with a page of equations."""
        model = self.get_query_argument("model", "")
        if model not in self.following.parts.get("models", {}).get("titles", ()):
            raise web.HTTPError(404)
        file = self.following.file
        try:
            content = file.content()
        except InputError as error:
            self.say(422, f"{error.place}: {error.what}")
            return
        work = asyncio.ensure_future(self.following.asked("equations_of_file", file.path, content, model))
        self.on_connection_close = work.cancel  # type: ignore[method-assign,assignment]
        await asyncio.wait([work])
        pages = [] if work.cancelled() else [html for _, html in work.result() if html]
        if pages:
            self.show(pages[-1], "frame-ancestors 'self'")
        else:
            self.say(409, "the file was saved meanwhile")


class Events(Handler):
    """The stream of parts as they come."""

    async def get(self, _token: str) -> None:
        """Send all parts, then what is new, until the browser or the server ends."""
        self.set_header("Content-Type", "text/event-stream")
        sending = asyncio.ensure_future(self._send())
        self.on_connection_close = sending.cancel  # type: ignore[method-assign,assignment]
        with suppress(asyncio.CancelledError):  # the server ends
            await asyncio.wait([sending])

    async def _send(self) -> None:
        with suppress(StreamClosedError):
            async with aclosing(self.following.news()) as news:
                async for parts in news:
                    self.write(f"data: {json.dumps(parts)}\n\n" if parts else ": \n\n")
                    await self.flush()


class Change(Handler):
    """A change of the file, accepted from the page only."""

    async def post(self, _token: str) -> None:
        """Make the change, or say why not."""
        if "Origin" not in self.request.headers or self.request.headers.get("Content-Type") != "application/json":
            raise web.HTTPError(403)
        try:
            await self.change(json.loads(self.request.body))
        except Conflict as conflict:
            self.say(409, str(conflict))
        except InputError as error:
            self.say(422, f"{error.place}: {error.what}")
        except (TypeError, ValueError, RecursionError):
            raise web.HTTPError(400) from None
        else:
            self.finish({"version": self.following.version})

    async def change(self, body: Mapping[str, Any]) -> None:
        """Make the change; raises `TypeError` for what is none."""
        raise NotImplementedError


class Edit(Change):
    """One of `EDITS`, by the last part of the address."""

    async def change(self, body: Mapping[str, Any]) -> None:
        """Make it."""
        if not isinstance(body, dict) or body.keys() != {"version", "path", "text"}:
            raise TypeError(body)
        how = self.request.path.rpartition("/")[2]
        version, path, text = body["version"], body["path"], body["text"]
        if not (isinstance(version, str) and isinstance(text, str) and isinstance(path, list)):
            raise TypeError(body)
        if not SHORTEST[how] <= len(path) < LONGEST or any(
            isinstance(key, bool) or not isinstance(key, str | int) for key in path
        ):
            raise TypeError(path)
        await self.following.edit(how, version, path, text)


class Step(Change):
    """Undo of the last change, or redo of the last undone one, by the last part of the address."""

    async def change(self, body: Mapping[str, Any]) -> None:
        """Make it."""
        if body:
            raise TypeError(body)
        await self.following.step(self.request.path.rpartition("/")[2])


CHANGES = {**dict.fromkeys(EDITS, Edit), "undo": Step, "redo": Step}
PLACES = {"": Page, "picture": Picture, "equations": Equations, "events": Events, **CHANGES}


def application(site: Site) -> web.Application:
    """Return the application that serves a site, and nothing else."""
    routes = [(rf"/([^/]+)/{name}", handler, {"site": site}) for name, handler in PLACES.items()]
    return web.Application([*routes, (r"/(.*)", Handler, {"site": site})], log_function=lambda _: None)
