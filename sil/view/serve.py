# SPDX-License-Identifier: MIT
"""The web server of a view: one page, with live frames or with a history to replay."""

import asyncio
import errno
import ipaddress
import re
import signal
import socket
import sys
from asyncio import Future
from collections.abc import Callable
from contextlib import suppress
from typing import Any

import tornado.httpserver
import tornado.web
from tornado.ioloop import PeriodicCallback
from tornado.websocket import WebSocketClosedError, WebSocketHandler

from sil.view import alarm, page
from sil.view.chart import Chart
from sil.view.live_source import FRAMES_PER_S, Live
from sil.view.plain_json import json_of

_POLICY = (
    "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; "
    "img-src 'self' data: blob:; connect-src 'self' ws:; base-uri 'none'; form-action 'none'"
)


_MOST_PORTS = 20


class Server:
    """Serves `source` at `bind` (host, port; port 0: any); OSError.

    If the port is in use, takes the next free one of the 20 from there.
    """

    def __init__(
        self, source: Live | dict[str, Any], bind: tuple[str, int], chart: Chart | None = None
    ) -> None:
        self._source, self._chart = source, chart
        self._clients: set[_Frames] = set()
        self._socket = _socket_at(*bind)
        self._socket.setblocking(False)
        address, port = self._socket.getsockname()[:2]
        own = rf"(localhost|127(\.\d+){{3}}|\[::1\]|{re.escape(bind[0])})"
        # DNS rebinding: on the loopback, reject requests under another site's name
        self._names = own if ipaddress.ip_address(address).is_loopback else ".*"
        host = f"[{bind[0]}]" if ":" in bind[0] else bind[0]
        self.url = f"http://{host}:{port}/"
        self.is_elsewhere = bind[1] not in (0, port)
        self._text = self._page()

    async def run(self) -> None:
        """Serve until cancelled."""
        server = tornado.httpserver.HTTPServer(self._application())
        server.add_socket(self._socket)
        beat = PeriodicCallback(self._tell, 1000 / FRAMES_PER_S)
        try:
            if isinstance(self._source, Live):
                beat.start()
                await self._source.run()
            await asyncio.Event().wait()
        finally:
            beat.stop()
            server.stop()
            await server.close_all_connections()

    def end(self) -> None:
        """End a live source: every open page continues as a replay of what was heard."""
        if isinstance(self._source, Live):
            self._source = self._source.history()
            self._text = self._page()
            for client in tuple(self._clients):
                client.end()

    def _is_over(self) -> bool:
        return not isinstance(self._source, Live)

    def _page(self) -> str:
        has_chart = self._chart is not None
        if isinstance(self._source, Live):
            return page.live(has_chart=has_chart)
        return page.page_with(self._source, self._source["title"], has_chart=has_chart)

    def _history(self) -> str:
        source = self._source.history() if isinstance(self._source, Live) else self._source
        return json_of(source)

    def _application(self) -> tornado.web.Application:
        json_kind = "application/json"
        routes: list[Any] = [
            (r"/favicon.ico", _Nothing),
            (r"/", _Text, {"text": lambda: self._text, "kind": "text/html"}),
            (r"/history", _Text, {"text": self._history, "kind": json_kind}),
        ]
        if isinstance(self._source, Live):
            routes.append((r"/live", _Frames, {"clients": self._clients, "is_over": self._is_over}))
        if self._chart is not None:
            about = json_of(self._chart.about)
            routes.append((r"/chart", _Text, {"text": lambda: about, "kind": json_kind}))
            routes.append((r"/tile/(\d{1,2})/(\d{1,9})/(\d{1,9})", _Tile, {"chart": self._chart}))
        application = tornado.web.Application(
            compress_response=True, websocket_ping_interval=10, log_function=_no_log
        )
        application.add_handlers(self._names, routes)
        return application

    def _tell(self) -> None:
        if not isinstance(self._source, Live):
            return
        self._source.look()
        if self._clients:
            text = self._source.text()
            for client in tuple(self._clients):
                client.tell(text)


class _Text(tornado.web.RequestHandler):
    def initialize(self, text: Callable[[], str], kind: str) -> None:
        self._text, self._kind = text, kind

    def get(self) -> None:
        self.set_header("Content-Type", f"{self._kind}; charset=UTF-8")
        self.set_header("Content-Security-Policy", _POLICY)
        self.set_header("Cache-Control", "no-store")
        self.write(self._text())


class _Nothing(tornado.web.RequestHandler):
    def get(self) -> None:
        self.set_status(204)


class _Tile(tornado.web.RequestHandler):
    def initialize(self, chart: Chart) -> None:
        self._chart = chart

    def get(self, zoom: str, column: str, row: str) -> None:
        picture = self._chart.tile(int(zoom), int(column), int(row))
        if picture is None:
            self.set_status(204)
            return
        self.set_header("Content-Type", self._chart.kind)
        self.set_header("Cache-Control", "max-age=86400")
        self.write(picture)


class _Frames(WebSocketHandler):
    """The WebSocket of an open page; ignores the page's messages."""

    def initialize(self, clients: "set[_Frames]", is_over: Callable[[], bool]) -> None:
        self._clients, self._is_over = clients, is_over
        self._sent: Future[None] | None = None

    def open(self, *_: str, **__: str) -> None:
        self._clients.add(self)
        if self._is_over():
            self.end()

    def on_close(self) -> None:
        self._clients.discard(self)

    def on_message(self, message: str | bytes) -> None:
        pass

    def tell(self, text: str) -> None:
        """Send a frame, unless the last one is still being sent."""
        if self._sent is None or self._sent.done():
            self._send(text)

    def end(self) -> None:
        """Tell the page that no more frames follow; waits behind a frame that is being sent."""
        self._send('{"over":true}')

    def _send(self, text: str) -> None:
        with suppress(WebSocketClosedError):
            self._sent = asyncio.ensure_future(self.write_message(text))
            self._sent.add_done_callback(_look)


def _look(sent: "Future[None]") -> None:
    """Retrieve the exception: a page that was closed meanwhile is not an error."""
    if not sent.cancelled():
        sent.exception()


def _no_log(_: tornado.web.RequestHandler) -> None:
    pass


def _socket_at(host: str, port: int) -> socket.socket:
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    for at in range(port, min(port + _MOST_PORTS, 1 << 16) if port else 1):
        try:
            return socket.create_server((host, at), family=family)
        except OSError as error:
            if error.errno != errno.EADDRINUSE:
                raise OSError(f"{host}:{at}: {alarm.of_error(error)}") from None
    raise OSError(f"{host}: ports {port} to {at} are all in use; choose another with --bind")


def serve(source: Live | dict[str, Any], bind: tuple[str, int], chart: Chart | None = None) -> None:
    """Print the URL and serve until SIGINT or SIGTERM; OSError if it cannot.

    SIGUSR1 ends a live source; the pages then replay it.
    """

    async def run() -> None:
        server = Server(source, bind, chart)
        serving = asyncio.ensure_future(server.run())
        for number in (signal.SIGINT, signal.SIGTERM):  # a shell may have set them to be ignored
            asyncio.get_running_loop().add_signal_handler(number, serving.cancel)
        asyncio.get_running_loop().add_signal_handler(signal.SIGUSR1, server.end)
        if server.is_elsewhere:
            print(f"view: port {bind[1]} is in use, using the next free one", file=sys.stderr)
        print(f"view: {server.url}", flush=True)
        with suppress(asyncio.CancelledError):
            await serving

    asyncio.run(run())
