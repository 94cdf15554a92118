"""The server of the page, only for a browser and user on this machine.

It listens at 127.0.0.1. An address with the token sets a cookie. The server refuses requests
without this cookie, for another host, or from another page. The content security policy stops pages
from loading from or sending to other servers, and from running inline scripts; inline styles are
allowed for tables.
"""

import asyncio
import hmac
import logging
import secrets
import socket
import sys
import traceback
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import tornado.httpserver
import tornado.web

from breaker.page import views
from breaker.page.session import Session

HOST = "127.0.0.1"
"""Address of the server, which other machines cannot reach."""

POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self' 'unsafe-inline'; "
    "img-src 'self' data:; connect-src 'self'; form-action 'self'; base-uri 'none'; "
    "frame-ancestors 'none'"
)
"""Content security policy: sources from which a page may load, and targets it may send to."""

_HEADERS = {
    "Content-Security-Policy": POLICY,
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "same-origin",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Cache-Control": "no-store",
}
_DOOR = (
    '<!doctype html><meta http-equiv="refresh" content="0;url=/">'
    '<link rel="icon" href="/static/icon.svg"><a href="/">Open the page</a>'
)
_BODY = 2**20  # most bytes of a request; a limit has a hundred, a query of many files more


class PageServer:
    """The server of a session.

    Args:
        session: Folder, configuration and inspections to show.
        port: Port of the server; 0 for a free one.

    Raises:
        OSError: If the port is in use.
    """

    def __init__(self, session: Session, port: int = 0) -> None:
        self.session, self.token = session, secrets.token_urlsafe(24)
        try:
            self._socket = socket.create_server((HOST, port))
        except (OSError, OverflowError) as error:
            remedy = "leave --port out, and a free one is taken, or name another"
            raise OSError(f"port {port} is in use or may not be taken; {remedy}") from error
        self._socket.setblocking(False)
        self.port = self._socket.getsockname()[1]
        self.worker = ThreadPoolExecutor(max_workers=1)  # matplotlib is not safe in two threads

    @property
    def address(self) -> str:
        """Address that opens the page, with the token."""
        return f"http://{HOST}:{self.port}/?token={self.token}"

    async def serve(self, ended: asyncio.Event, ready: Callable[[], None] = lambda: None) -> None:
        """Answer requests until the event ``ended``; complete answers that are being written."""
        access = logging.getLogger("tornado.access")
        access.setLevel(logging.CRITICAL)  # addresses contain the token
        static = {"path": str(Path(__file__).with_name("static"))}
        handlers = [(r"/static/(.*)", _Static, static), (r"/(.*)", _Views)]
        application = tornado.web.Application(handlers, page=self)
        server = tornado.httpserver.HTTPServer(application, max_buffer_size=_BODY)
        server.add_socket(self._socket)
        try:
            ready()
            await ended.wait()
        finally:
            server.stop()
            await server.close_all_connections()
            self.worker.shutdown(wait=True)


class _Handler(tornado.web.RequestHandler):
    """Common part of all answers: access checks and error pages."""

    @property
    def page(self) -> PageServer:
        """The server of this handler."""
        return self.settings["page"]

    def set_default_headers(self) -> None:
        self.clear_header("Server")
        for name, value in _HEADERS.items():
            self.set_header(name, value)

    def prepare(self) -> None:
        hosts = {f"{HOST}:{self.page.port}", f"localhost:{self.page.port}"}
        origins = {f"http://{host}" for host in hosts}
        if self.request.method != "POST":
            origins |= {None}
        token = self.get_cookie(self._cookie, "")
        if self.request.path == "/":
            token = self.get_query_argument("token", token)
        if self.request.host not in hosts:
            refusal = "This page answers under its own address alone."
        elif self.request.headers.get("Origin") not in origins:
            refusal = "Another page asked for this, and was refused."
        elif not hmac.compare_digest(token.encode(), self.page.token.encode()):
            refusal = "Open this page with the address and token that the terminal shows now."
        else:
            return
        raise tornado.web.HTTPError(403, refusal)

    @property
    def _cookie(self) -> str:
        return f"breaker-{self.page.port}"  # browsers keep one cookie for all ports of a host

    def write_error(self, status_code: int, **about: Any) -> None:
        error = about.get("exc_info", (None, None, None))[1]
        text = str(error)
        if isinstance(error, tornado.web.HTTPError):
            text = error.log_message or "There is no such page; go back to the list."
        elif isinstance(error, ValueError | OSError):
            self.set_status(getattr(error, "status", 422))
        elif error is not None:
            text = f"an error of breaker itself, {type(error).__name__}: {error}; please report it"
        self.finish(views.error_page(text))

    def log_exception(self, kind: Any, error: BaseException | None, trace: Any) -> None:
        """Print errors of this program; the page shows other errors."""
        if not isinstance(error, ValueError | OSError | tornado.web.HTTPError | MemoryError):
            traceback.print_exception(kind, error, trace, file=sys.stderr)


class _Static(_Handler, tornado.web.StaticFileHandler):
    """Handler of scripts and styles."""


class _Views(_Handler):
    """Handler of pages and data, which calls the view of a path."""

    async def get(self, name: str) -> None:
        if not name and self.get_query_argument("token", None) is not None:
            self.set_cookie(self._cookie, self.page.token, httponly=True, samesite="Strict")
            self.finish(_DOOR)  # after a redirect a browser does not send a strict cookie
            return
        await self._answer("GET", name)

    async def post(self, name: str) -> None:
        await self._answer("POST", name)

    async def _answer(self, method: str, name: str) -> None:
        """Run a view on the worker, and send a new address or a page."""
        if (view := views.VIEWS.get((method, name))) is None:
            raise tornado.web.HTTPError(404)
        query, form = map(_texts, (self.request.query_arguments, self.request.body_arguments))
        asked, loop = views.Asked(self.page.session, query, form), asyncio.get_running_loop()
        answer = await loop.run_in_executor(self.page.worker, view, asked)
        if isinstance(answer, views.Moved):
            self.redirect(answer, status=303)
        else:
            self.finish(answer)


def _texts(arguments: Mapping[str, Sequence[bytes]]) -> dict[str, list[str]]:
    return {name: [v.decode("utf-8", "replace") for v in arguments[name]] for name in arguments}
