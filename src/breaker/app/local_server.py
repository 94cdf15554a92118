"""The page's server: for the browser of this machine and user alone.

It is bound to 127.0.0.1. An address with the token sets a cookie; without that cookie nothing is
answered, nor to a request that names another host, or comes from another page. The content security
policy lets no page load or send anything elsewhere. Styles may stand within a page, as Bokeh
writes its own; scripts may not.
"""

import asyncio
import hmac
import importlib.util
import logging
import math
import secrets
import socket
import sys
import traceback
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from importlib.resources import files as resources
from pathlib import Path
from typing import Any

import tornado.httpserver
import tornado.web

from breaker.app.page_choices import Choices, read_choices
from breaker.app.page_text import (
    answer_part,
    cursor_page,
    curves_of,
    error_page,
    list_page,
    marks_for,
    visit_page,
)
from breaker.app.view_session import MissingError, Session

HOST = "127.0.0.1"
"""The only address at which it listens: nobody beyond this machine reaches it."""

POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self' 'unsafe-inline'; "
    "img-src 'self' data:; connect-src 'self'; form-action 'self'; base-uri 'none'; "
    "frame-ancestors 'none'"
)
"""What a page may load, and where it may send anything."""

_HEADERS = {
    "Content-Security-Policy": POLICY,
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Cache-Control": "no-store",
}
_DOOR = (
    '<!doctype html><meta http-equiv="refresh" content="0;url=/">'
    '<link rel="icon" href="/static/icon.svg"><a href="/">Open the page</a>'
)
_TYPES = {".js": "text/javascript", ".css": "text/css", ".svg": "image/svg+xml"}
_BODY = 65_536  # bytes of a request: only a name is sent
_OWN = ("page.js", "page.css", "icon.svg")
_BOKEH = ("bokeh.min.js", "bokeh-api.min.js")


class PageServer:
    """The server of a session.

    Args:
        session: What is shown.
        port: Where it listens; 0 for a free one.

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
        # What is shown at once waits for no answer of the model: one thread for each of both.
        self.quick, self.slow = (ThreadPoolExecutor(max_workers=1) for _ in range(2))

    @property
    def address(self) -> str:
        """The address that opens the page, with the token."""
        return f"http://{HOST}:{self.port}/?token={self.token}"

    async def serve(self, ended: asyncio.Event, ready: Callable[[], None] = lambda: None) -> None:
        """Answer until the event; what is being written by then is written to its end."""
        logging.getLogger("tornado.access").setLevel(logging.CRITICAL)  # addresses hold the token
        routes = [(path, handler, {"page": self}) for path, handler in _ROUTES]
        application = tornado.web.Application(routes, default_handler_class=_Lost)
        application.settings["default_handler_args"] = {"page": self}
        server = tornado.httpserver.HTTPServer(application, max_body_size=_BODY)
        server.add_socket(self._socket)
        try:  # whatever ends it: a thread of a worker that is not told would wait for ever
            ready()
            await ended.wait()
        finally:
            server.stop()
            await server.close_all_connections()
            for each in (self.slow, self.quick):
                each.shutdown(wait=True)


class _Handler(tornado.web.RequestHandler):
    """What every answer has in common: who may ask, and how errors are said."""

    def initialize(self, page: PageServer) -> None:
        self.page = page

    def set_default_headers(self) -> None:
        self.clear_header("Server")
        for name, value in _HEADERS.items():
            self.set_header(name, value)

    def prepare(self) -> None:
        hosts = {f"{HOST}:{self.page.port}", f"localhost:{self.page.port}"}
        origin, site = (self.request.headers.get(n) for n in ("Origin", "Sec-Fetch-Site"))
        if self.request.host not in hosts:
            raise _refused("This page answers under its own address alone.")
        foreign = origin is not None and origin not in {f"http://{each}" for each in hosts}
        changes = self.request.method not in ("GET", "HEAD")
        if foreign or (changes and origin is None) or (changes and site == "cross-site"):
            raise _refused("Another page asked for this, and was refused.")
        self._admit()

    def _admit(self) -> None:
        """Let who has the cookie pass."""
        if not self._same(self.get_cookie(self._cookie, "")):
            raise _refused(
                "This page opens with the whole address, token included, that `breaker view` has "
                "printed on the terminal. After another start, take its address.",
            )

    @property
    def _cookie(self) -> str:
        return f"breaker-{self.page.port}"  # browsers keep one cookie for all ports of a host

    def _same(self, token: str) -> bool:
        return hmac.compare_digest(token.encode(), self.page.token.encode())

    async def worked(self, find: Callable[[], Any], *, slow: bool = False) -> Any:
        """What is found by a worker, while other windows are answered. What only shows something is
        not begun if nobody waits for it any more.
        """
        worker = self.page.slow if slow else self.page.quick
        reads = self.request.method == "GET"

        def unless_gone() -> Any:
            if reads and self.request.connection.stream.closed():
                raise MissingError("nobody waits for this any more")
            return find()

        return await asyncio.get_running_loop().run_in_executor(worker, unless_gone)

    @property
    def query(self) -> dict[str, list[str]]:
        """Names and values of the address."""
        return {
            name: [each.decode("utf-8", "replace") for each in values]
            for name, values in self.request.query_arguments.items()
        }

    @property
    def state(self) -> str:
        """Of the files as the page that asks shows them; empty where it does not say."""
        return self.query.get("state", [""])[-1]

    def choices(self) -> Choices:
        """What the address chooses, of one file at least."""
        found = read_choices(self.query)
        if not found.files:
            raise MissingError("no file is chosen; choose one or more in the list")
        return found

    def write_error(self, status_code: int, **about: Any) -> None:
        error = about.get("exc_info", (None, None, None))[1]
        text = str(error)
        if isinstance(error, tornado.web.HTTPError):
            text = error.log_message or "There is no such page; go back to the list."
        elif isinstance(error, ValueError | OSError):
            self.set_status(getattr(error, "status", 422))
        elif error is not None:
            text = f"an error of breaker itself, {type(error).__name__}: {error}; please report it"
        self.finish(error_page(text, allowed=self.get_status() != 403))

    def log_exception(self, kind: Any, error: BaseException | None, trace: Any) -> None:
        """Print what is an error of this program; all else is said on the page."""
        if not isinstance(error, ValueError | OSError | tornado.web.HTTPError | MemoryError):
            traceback.print_exception(kind, error, trace, file=sys.stderr)


def _refused(text: str) -> tornado.web.HTTPError:
    return tornado.web.HTTPError(403, text)


class _Lost(_Handler):
    def get(self) -> None:
        raise tornado.web.HTTPError(404)


class _List(_Handler):
    """The files; and the door, where a token becomes a cookie."""

    def _admit(self) -> None:
        token = self.query.get("token")
        if token is None:
            super()._admit()
        elif not self._same(token[-1]):
            raise _refused("The token of this address is wrong: take the one on the terminal.")

    async def get(self) -> None:
        if "token" in self.query:
            self.set_cookie(self._cookie, self.page.token, httponly=True, samesite="Strict")
            # No redirect: a browser sends no strict cookie with one that another program began.
            self.finish(_DOOR)
            return
        number, look = (self.query.get(name, [""])[-1] for name in ("page", "look"))
        find = lambda: list_page(self.page.session, number, look)  # noqa: E731
        self.finish(await self.worked(find, slow=bool(look)))


class _Visit(_Handler):
    async def get(self) -> None:
        choices = self.choices()
        self.finish(await self.worked(lambda: visit_page(self.page.session, choices)))


class _Answer(_Handler):
    """Values, limits and the model's answer, or the marks that go with them."""

    async def get(self, what: str) -> None:
        asked = self.choices(), self.state
        if what == "answer":
            find = lambda: answer_part(self.page.session, *asked)  # noqa: E731
        else:
            find = lambda: marks_for(self.page.session.answered(*asked)[1])  # noqa: E731
        self.finish(await self.worked(find, slow=True))


class _Curves(_Handler):
    """Points of the curves, of all or of a part."""

    async def get(self) -> None:
        choices = self.choices()
        shown = await self.worked(lambda: self.page.session.shown(choices, self.state))
        self.finish(curves_of(shown, *(self._time(name) for name in ("from", "to"))))

    def _time(self, name: str) -> float | None:
        """A time of the address, ms; None where it has none."""
        if not (text := self.query.get(name, [""])[-1]):
            return None
        with suppress(ValueError):
            if math.isfinite(value := float(text)):
                return value
        raise ValueError(f"{text!r} is no time; write a number of ms")


class _Cursors(_Curves):
    """Readings at two cursors."""

    async def get(self) -> None:
        choices, times = self.choices(), [self._time(name) or 0.0 for name in ("first", "second")]
        shown = await self.worked(lambda: self.page.session.shown(choices, self.state))
        self.finish(cursor_page(shown, *times))


class _Sheet(_Handler):
    async def get(self, ending: str) -> None:
        choices = self.choices()
        find = lambda: self.page.session.sheet(choices, self.state, f".{ending}")  # noqa: E731
        content = await self.worked(find, slow=True)
        self.set_header("Content-Type", {"pdf": "application/pdf", "html": "text/html"}[ending])
        self.set_header("Content-Disposition", f'attachment; filename="sheet.{ending}"')
        self.finish(content)


class _Save(_Handler):
    async def post(self) -> None:
        choices = self.choices()
        name = self.get_body_argument("name", "", strip=True)
        if not name or "\0" in name:
            raise ValueError("name the file that is to be written")
        said = await self.worked(lambda: self.page.session.save(choices, name), slow=True)
        self.set_header("Content-Type", "text/plain; charset=utf-8")
        self.finish(said)


class _Static(_Handler):
    """Scripts and styles, those of Bokeh from its own package."""

    def get(self, name: str) -> None:
        if name in _OWN:
            content = resources("breaker.app").joinpath("static", name).read_bytes()
        elif name in _BOKEH:
            found = importlib.util.find_spec("bokeh")  # which takes a second to import
            content = (Path(found.origin).parent / "server" / "static" / "js" / name).read_bytes()
            self.set_header("Cache-Control", "private, max-age=86400")
        else:
            raise tornado.web.HTTPError(404)
        self.set_header("Content-Type", f"{_TYPES[Path(name).suffix]}; charset=utf-8")
        self.finish(content)


_ROUTES = [
    ("/", _List),
    ("/visit", _Visit),
    ("/(answer|marks)", _Answer),
    ("/curves", _Curves),
    ("/cursors", _Cursors),
    (r"/sheet\.(pdf|html)", _Sheet),
    ("/save", _Save),
    (r"/static/([\w.-]+)", _Static),
]
