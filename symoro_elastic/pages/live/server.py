"""The server of the live page: on this computer only, for who has its address, which holds a random token.

A page of another site can neither read nor write: Host and Origin are checked, edits are JSON that a foreign page may
not send, and no address of the file system comes from a page.
"""

from __future__ import annotations

import secrets
from collections.abc import Callable

from symoro_elastic.foundation.errors import InputError
from symoro_elastic.foundation.packages import import_optional
from symoro_elastic.pages.live.followed_file import FollowedFile
from symoro_elastic.pages.live.following import Following

HOST = "127.0.0.1"
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
    try:
        ready(f"http://{HOST}:{bound}/{token}/")
        await following.follow()
    finally:
        server.stop()
        following.drop()
