"""What is answered to a browser, and to whom; imported where tornado is there."""

from __future__ import annotations

import asyncio
import json
import secrets
from collections.abc import Mapping
from contextlib import aclosing, suppress
from dataclasses import dataclass
from typing import Any

from tornado import web
from tornado.iostream import StreamClosedError

from symoro_elastic.codegen.templates import render, template_folder
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.foundation.input_files import read_file
from symoro_elastic.pages.drawing.page import content_policy
from symoro_elastic.pages.live.followed_file import Conflict
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
REFUSED = {403: "not from here", 404: "there is no such page"}


@dataclass(frozen=True)
class Site:
    """What is served: the parts of a file, below a `token`, to who asks one of the `hosts`."""

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
    """Refuse who has not the token, or comes from elsewhere."""

    def initialize(self, site: Site) -> None:
        """Take what is served."""
        self.site, self.following = site, site.following

    def set_default_headers(self) -> None:
        """Set the headers that keep others out."""
        self.clear_header("Server")
        for name, value in HEADERS.items():
            self.set_header(name, value)

    def prepare(self) -> None:
        """Check from where and for what a request is, before anything is done for it."""
        given, hosts = self.request.headers, self.site.hosts
        origin = given.get("Origin")
        is_foreign = origin is not None and origin not in {f"http://{host}" for host in hosts}
        is_sent_by_others = given.get("Sec-Fetch-Site", "none") not in ("none", "same-origin")
        if given.get("Host") not in hosts or is_foreign or is_sent_by_others:
            raise web.HTTPError(403)
        if not secrets.compare_digest(self.path_args[0].encode(), self.site.token.encode()):
            raise web.HTTPError(404)

    def write_error(self, status_code: int, **_: Any) -> None:
        """Answer an error with a few words."""
        self.say(status_code, REFUSED.get(status_code, "refused"))

    def say(self, status: int, text: str) -> None:
        """Answer with a sentence."""
        self.set_status(status)
        self.set_header("Content-Type", "text/plain; charset=utf-8")
        self.finish(text)

    def show(self, html: str, more: str) -> None:
        """Answer with a page that runs what is in it, and `more` of a policy."""
        self.set_header("Content-Security-Policy", f"{content_policy(html)}; img-src data:; {more}")
        self.set_header("Content-Type", "text/html; charset=utf-8")
        self.finish(html)


class Page(Handler):
    """The page itself."""

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
    """The equations of a model, computed when they are asked for."""

    async def get(self, _token: str) -> None:
        """Answer with a page of equations."""
        model = self.get_query_argument("model", "")
        if model not in self.following.parts.get("models", {}).get("titles", ()):
            raise web.HTTPError(404)
        work = asyncio.ensure_future(self.following.asked("equations_of_file", self.following.file.path, model))
        self.on_connection_close = work.cancel  # type: ignore[method-assign,assignment]
        await asyncio.wait([work])
        found = [] if work.cancelled() else [html for _, html in work.result() if html]
        if found:
            self.show(found[-1], "frame-ancestors 'self'")
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
    """A change of the file, as the page alone may send it."""

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

    async def change(self, given: Mapping[str, Any]) -> None:
        """Make the change; raises `TypeError` for what is none."""
        raise NotImplementedError


class Cell(Change):
    """One cell of the file."""

    async def change(self, given: Mapping[str, Any]) -> None:
        """Write the cell."""
        if not isinstance(given, dict) or given.keys() != {"version", "path", "text"}:
            raise TypeError(given)
        version, path, text = given["version"], given["path"], given["text"]
        if not (isinstance(version, str) and isinstance(text, str) and isinstance(path, list) and 1 < len(path) < 6):
            raise TypeError(given)
        if any(isinstance(key, bool) or not isinstance(key, str | int) for key in path):
            raise TypeError(path)
        await self.following.write_cell(version, path, text)


class Undo(Change):
    """The cell that was written last."""

    async def change(self, given: Mapping[str, Any]) -> None:
        """Undo it."""
        if given:
            raise TypeError(given)
        await self.following.undo()


class Redo(Change):
    """The cell that was undone last."""

    async def change(self, given: Mapping[str, Any]) -> None:
        """Write it again."""
        if given:
            raise TypeError(given)
        await self.following.redo()


CHANGES = {"cell": Cell, "undo": Undo, "redo": Redo}
PLACES = {"": Page, "picture": Picture, "equations": Equations, "events": Events, **CHANGES}


def application(site: Site) -> web.Application:
    """Return the application that serves a site, and answers nothing else."""
    routes = [(rf"/([^/]+)/{name}", handler, {"site": site}) for name, handler in PLACES.items()]
    return web.Application([*routes, (r"/(.*)", Handler, {"site": site})], log_function=lambda _: None)
