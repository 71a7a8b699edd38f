# SPDX-License-Identifier: MIT
"""The web server of a view: one page, and either live frames for it or a history in it."""

import asyncio
import ipaddress
import json
import re
import signal
import socket
from asyncio import Future
from contextlib import suppress
from typing import Any

import tornado.httpserver
import tornado.web
from tornado.ioloop import PeriodicCallback
from tornado.websocket import WebSocketClosedError, WebSocketHandler

from sil.view import page
from sil.view.live_source import FRAMES_PER_S, Live

_POLICY = (
    "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; "
    "img-src 'self' data: blob:; connect-src 'self' ws:; base-uri 'none'; form-action 'none'"
)


class Server:
    """Serves `source` at `bind` (host, port; port 0: any) while a loop runs; OSError."""

    def __init__(self, source: Live | dict[str, Any], bind: tuple[str, int]) -> None:
        self._source = source
        self._clients: set[_Frames] = set()
        try:
            family = socket.AF_INET6 if ":" in bind[0] else socket.AF_INET
            self._socket = socket.create_server(bind, family=family)
        except OSError as error:
            raise OSError(f"{bind[0]}:{bind[1]}: {error.strerror}") from None
        self._socket.setblocking(False)
        address, port = self._socket.getsockname()[:2]
        own = rf"(localhost|127(\.\d+){{3}}|\[::1\]|{re.escape(bind[0])})"
        # another site's name that is said to be this machine's opens no page of the loopback
        self._names = own if ipaddress.ip_address(address).is_loopback else ".*"
        host = f"[{bind[0]}]" if ":" in bind[0] else bind[0]
        self.url = f"http://{host}:{port}/"

    async def run(self) -> None:
        """Serves until it is cancelled."""
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

    def _application(self) -> tornado.web.Application:
        source = self._source
        routes: list[Any] = [(r"/favicon.ico", _Nothing)]
        if isinstance(source, Live):
            routes.append((r"/", _Text, {"text": page.live(), "kind": "text/html"}))
            routes.append((r"/live", _Frames, {"clients": self._clients}))
        else:
            text = page.page_with(dict(source), source["title"])
            history = json.dumps(source, separators=(",", ":"))
            routes.append((r"/", _Text, {"text": text, "kind": "text/html"}))
            routes.append((r"/history", _Text, {"text": history, "kind": "application/json"}))
        application = tornado.web.Application(
            compress_response=True, websocket_ping_interval=10, log_function=_no_log
        )
        application.add_handlers(self._names, routes)
        return application

    def _tell(self) -> None:
        if isinstance(self._source, Live) and self._clients:
            text = self._source.text()
            for client in tuple(self._clients):
                client.tell(text)


class _Text(tornado.web.RequestHandler):
    def initialize(self, text: str, kind: str) -> None:
        self._text, self._kind = text, kind

    def get(self) -> None:
        self.set_header("Content-Type", f"{self._kind}; charset=UTF-8")
        self.set_header("Content-Security-Policy", _POLICY)
        self.set_header("Cache-Control", "no-store")
        self.write(self._text)


class _Nothing(tornado.web.RequestHandler):
    def get(self) -> None:
        self.set_status(204)


class _Frames(WebSocketHandler):
    """One page that is open; what it says is not listened to."""

    def initialize(self, clients: "set[_Frames]") -> None:
        self._clients = clients
        self._sent: Future[None] | None = None

    def open(self, *_: str, **__: str) -> None:
        self._clients.add(self)

    def on_close(self) -> None:
        self._clients.discard(self)

    def on_message(self, message: str | bytes) -> None:
        pass

    def tell(self, text: str) -> None:
        """Sends a frame, unless the page has not taken the last one yet."""
        if self._sent is not None and not self._sent.done():
            return
        with suppress(WebSocketClosedError):
            self._sent = asyncio.ensure_future(self.write_message(text))
            self._sent.add_done_callback(_look)


def _look(sent: "Future[None]") -> None:
    """A page that went meanwhile is no error."""
    if not sent.cancelled():
        sent.exception()


def _no_log(_: tornado.web.RequestHandler) -> None:
    pass


def serve(source: Live | dict[str, Any], bind: tuple[str, int]) -> None:
    """Serve until SIGINT or SIGTERM; says where. OSError where it cannot."""

    async def run() -> None:
        server = Server(source, bind)
        serving = asyncio.ensure_future(server.run())
        for number in (signal.SIGINT, signal.SIGTERM):  # whatever a shell has made of them
            asyncio.get_running_loop().add_signal_handler(number, serving.cancel)
        print(f"view: {server.url}", flush=True)
        with suppress(asyncio.CancelledError):
            await serving

    asyncio.run(run())
