"""The web server of the editor, on this machine, for one session."""

import asyncio
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import suppress
import hashlib
import hmac
from importlib.resources import files
import json
from pathlib import Path
import secrets
import socket
from typing import Any
from urllib.parse import urlsplit

from tornado.httpserver import HTTPServer
from tornado.ioloop import IOLoop, PeriodicCallback
from tornado.log import app_log
from tornado.netutil import bind_sockets
from tornado.web import Application, HTTPError, RequestHandler
from tornado.websocket import WebSocketClosedError, WebSocketHandler

from hunav_drake.editor.session import EditSession

HOST = "127.0.0.1"

# The largest message that a page may send, in bytes.
MAX_MESSAGE = 16 * 2**20

# How long the server runs after the last page was closed, in seconds.
LINGER = 30.0

# The period of checking whether the file was changed, in seconds.
LOOK = 2.0

# The time limit for an idle connection and for a request, in seconds. (Pings
# keep the channel of a page open.)
IDLE = 60.0

# The range of the ports of files, which has no ephemeral ports.
_PORTS = range(20_000, 30_000)

_TYPES = {
    ".css": "text/css; charset=utf-8",
    ".csv": "text/csv; charset=utf-8",
    ".html": "text/html; charset=utf-8",
    ".js": "text/javascript; charset=utf-8",
}
_POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self';"
    " img-src 'self' data: blob:; connect-src 'self'; frame-ancestors 'none';"
    " base-uri 'none'; form-action 'none'"
)

# Reports and replays are separate pages with inline scripts. They run without
# an origin, so they have no access to the editor and its cookie.
_RESULT_POLICY = (
    "sandbox allow-scripts allow-downloads; default-src 'none';"
    " script-src 'unsafe-inline' 'unsafe-eval' blob: data:;"
    " style-src 'unsafe-inline'; img-src data: blob:;"
    " connect-src data: blob:; font-src data:; worker-src blob:"
)

# Finds a file of a result by token, run and name.
FindFile = Callable[[str, str, str], Path | None]


class EditPage:
    """Serves the editor of one session to browsers of this machine."""

    def __init__(
        self,
        session: EditSession,
        *,
        port: int | None = None,
        find_file: FindFile | None = None,
        linger: float = LINGER,
        idle: float = IDLE,
    ) -> None:
        """Opens the port; `run` serves it.

        Args:
            session: The session that the pages show and edit.
            port: The port on 127.0.0.1; 0 for any free one. By default a fixed
                port for each file, if it is free, because a browser keeps
                unsaved work by port.
            find_file: Finds the file of a result; None if there are none.
            linger: How long to run after the last page was closed, in seconds.
            idle: The time limit for an idle connection and for a request, in
                seconds.

        Raises:
            OSError: If the port is taken.
        """
        self.session = session
        self.token = secrets.token_urlsafe(32)
        self.find_file = find_file
        self._secret = secrets.token_urlsafe(32)
        self._linger = linger
        self._idle = idle
        self._thread = ThreadPoolExecutor(1, "session")
        self._sockets = _bound(session, port)
        self.port: int = self._sockets[0].getsockname()[1]
        self._loop: IOLoop | None = None
        self._pages: set[_Channel] = set()
        self._ending: Any = None
        static = files("hunav_drake.editor") / "static"
        self.static = {
            item.name: item.read_bytes()
            for item in static.iterdir()
            if item.name.endswith((".js", ".css", ".html"))
        }

    @property
    def url(self) -> str:
        """The address to open; it holds the token."""
        return f"http://{HOST}:{self.port}/?token={self.token}"

    @property
    def cookie(self) -> str:
        """The name of the cookie; another editor has another port."""
        return f"hunav_edit_{self.port}"

    def application(self) -> Application:
        """Returns the web application."""
        names = "|".join(sorted(self.static)).replace(".", r"\.")
        page = {"page": self}
        return Application(
            [
                (r"/", _Index, page),
                (r"/socket", _Channel, page),
                (rf"/({names})", _Static, page),
                (r"/results/([\w-]+)/([\w-]+)/([\w.-]+)", _Result, page),
            ],
            default_handler_class=_Nothing,
            default_handler_args=page,
            compress_response=True,
            websocket_max_message_size=MAX_MESSAGE,
            websocket_ping_interval=20,
            log_function=lambda handler: None,
        )

    def run(self, ready: Callable[[], None] = lambda: None) -> None:
        """Serves until `stop`, Ctrl-C, or some time after the last page.

        Args:
            ready: Called once pages are served.
        """
        asyncio.run(self._serve(ready))

    async def _serve(self, ready: Callable[[], None]) -> None:
        self._loop = IOLoop.current()
        self._ended = asyncio.Event()
        server = HTTPServer(
            self.application(),
            max_buffer_size=2 * MAX_MESSAGE,
            idle_connection_timeout=self._idle,
            body_timeout=self._idle,
        )
        server.add_sockets(self._sockets)
        unsubscribe = self.session.subscribe(self._tell)
        self._loop.add_callback(ready)
        look = PeriodicCallback(lambda: self.do(self.session.poll), 1000 * LOOK)
        look.start()
        try:
            await self._ended.wait()
        finally:
            look.stop()
            unsubscribe()
            server.stop()
            for channel in list(self._pages):
                channel.close()
            # Browsers keep connections open for further requests.
            await server.close_all_connections()
            self._thread.shutdown(cancel_futures=True)

    def stop(self) -> None:
        """Ends `run`; may be called from any thread."""
        if self._loop is not None:
            self._loop.add_callback(self._ended.set)

    def do(self, function: Callable[..., object], *args: Any) -> None:
        """Calls functions of the session one after another, in a thread.

        So a large text, or a file on a slow disk, does not block the server.
        """
        self._thread.submit(function, *args).add_done_callback(_tell_failure)

    def may(self, request: Any) -> bool:
        """Returns whether a request has the right host name.

        Another name may come from an attack with DNS.
        """
        hosts = {f"{name}:{self.port}" for name in (HOST, "localhost")}
        return request.host in hosts

    def knows(self, handler: RequestHandler) -> bool:
        """Returns whether a request has the cookie of this server."""
        given = handler.get_cookie(self.cookie) or ""
        return hmac.compare_digest(given.encode(), self._secret.encode())

    def is_token(self, given: str) -> bool:
        """Returns whether a text is the token of the address."""
        return hmac.compare_digest(given.encode(), self.token.encode())

    def let_in(self, handler: RequestHandler) -> None:
        """Sets the cookie in a browser."""
        handler.set_cookie(
            self.cookie,
            self._secret,
            httponly=True,
            samesite="Strict",
            path="/",
        )

    def opened(self, channel: "_Channel") -> None:
        """Adds a page."""
        self._pages.add(channel)
        if self._ending is not None:
            IOLoop.current().remove_timeout(self._ending)
            self._ending = None

    def closed(self, channel: "_Channel") -> None:
        """Removes a page; after the last one, the server ends later."""
        self._pages.discard(channel)
        if not self._pages and self._ending is None:
            loop = IOLoop.current()
            self._ending = loop.call_later(self._linger, self.stop)

    def _tell(self, message: dict[str, Any]) -> None:
        """Sends a message to all pages; may be called from any thread."""
        text = json.dumps(message, allow_nan=False)
        if IOLoop.current(instance=False) is self._loop:
            self._send(text)
        elif self._loop is not None:
            self._loop.add_callback(self._send, text)

    def _send(self, text: str) -> None:
        for channel in list(self._pages):
            with suppress(WebSocketClosedError):
                sent = channel.write_message(text)
                # Retrieves the exception of a page that was closed.
                sent.add_done_callback(asyncio.Future.exception)


def _tell_failure(work: Future[object]) -> None:
    """Logs an unexpected exception of the session."""
    if not work.cancelled() and (error := work.exception()) is not None:
        app_log.error("the editor failed", exc_info=error)


def _bound(session: EditSession, port: int | None) -> list[socket.socket]:
    """Opens a port, by default that of the session's file."""
    if port is not None:
        return bind_sockets(port, HOST)
    file = session.state.file
    name = str(file.path or file.folder).encode()
    digest = int.from_bytes(hashlib.sha256(name).digest()[:8])
    try:
        return bind_sockets(_PORTS[digest % len(_PORTS)], HOST)
    except OSError:
        return bind_sockets(0, HOST)


class _Checked(RequestHandler):
    """A handler that checks the host of its requests."""

    def initialize(self, page: EditPage) -> None:
        self.page = page

    def set_default_headers(self) -> None:
        self.set_header("Content-Security-Policy", _POLICY)
        self.set_header("X-Content-Type-Options", "nosniff")
        self.set_header("Referrer-Policy", "no-referrer")
        self.set_header("Cross-Origin-Resource-Policy", "same-origin")
        self.set_header("Cache-Control", "no-store")
        self.clear_header("Server")

    def prepare(self) -> None:
        if not self.page.may(self.request):
            raise HTTPError(403)

    def write_error(self, status_code: int, **details: Any) -> None:
        self.set_header("Content-Type", "text/plain; charset=utf-8")
        words = {
            403: "Open the address that `hunav edit` has printed.\n",
            404: "This page does not exist.\n",
        }
        self.finish(words.get(status_code, f"{status_code}\n"))


class _Nothing(_Checked):
    """All other addresses."""

    def prepare(self) -> None:
        super().prepare()
        raise HTTPError(404)


class _Index(_Checked):
    """The page; its address with the token sets the cookie."""

    def get(self) -> None:
        given = self.get_query_argument("token", None)
        if given is not None:
            if not self.page.is_token(given):
                raise HTTPError(403)
            self.page.let_in(self)
            # The browser's history does not keep the token.
            self.redirect("/")
            return
        if not self.page.knows(self):
            raise HTTPError(403)
        self.set_header("Content-Type", _TYPES[".html"])
        self.finish(self.page.static["index.html"])


class _Static(_Checked):
    """A file of the page, from a fixed list."""

    def get(self, name: str) -> None:
        if not self.page.knows(self):
            raise HTTPError(403)
        self.set_header("Content-Type", _TYPES[Path(name).suffix])
        self.finish(self.page.static[name])


class _Result(_Checked):
    """A file of a run. Its address is secret, so it needs no cookie.

    (A page without an origin does not send cookies with its links.)
    """

    def set_default_headers(self) -> None:
        super().set_default_headers()
        self.set_header("Content-Security-Policy", _RESULT_POLICY)

    def get(self, token: str, run: str, name: str) -> None:
        find = self.page.find_file
        path = find(token, run, name) if find else None
        if path is None or path.suffix not in _TYPES:
            raise HTTPError(404)
        self.set_header("Content-Type", _TYPES[path.suffix])
        if path.suffix == ".csv":
            self.set_header(
                "Content-Disposition", f'attachment; filename="{path.name}"'
            )
        self.finish(path.read_bytes())


class _Channel(WebSocketHandler):
    """The messages of one page."""

    def initialize(self, page: EditPage) -> None:
        self.page = page

    def prepare(self) -> None:
        if not (self.page.may(self.request) and self.page.knows(self)):
            raise HTTPError(403)
        # Browsers always send it. (Tornado accepts other schemes of the same
        # host by default.)
        if not self.check_origin(self.request.headers.get("Origin", "")):
            raise HTTPError(403)

    def check_origin(self, origin: str) -> bool:
        parts = urlsplit(origin)
        return parts.scheme == "http" and parts.netloc == self.request.host

    def open(self, *args: str, **kwargs: str) -> None:
        self.page.opened(self)

    def on_close(self) -> None:
        self.page.closed(self)

    def on_message(self, message: str | bytes) -> None:
        self.page.do(self._receive, message)

    def _receive(self, message: str | bytes) -> None:
        try:
            content = json.loads(message)
        except (ValueError, RecursionError):
            content = None
        self.page.session.receive(content)
