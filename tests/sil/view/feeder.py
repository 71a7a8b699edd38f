# SPDX-License-Identifier: MIT
"""A view with a made-up fleet: the page and its WebSocket on loopback, in a thread."""

import asyncio
import json
import math
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from typing import Any

import tornado.httpserver
import tornado.netutil
import tornado.web
import tornado.websocket

from sil.view import page

Message = str | bytes | None
Frames = Callable[[float], Message]


def boat(number: int, t_s: float, **changes: object) -> dict[str, Any]:
    """Boat `number` of a column of two boats, 6 m apart, that sails on a circle."""
    row, side = divmod(number - 1, 2)
    phase = 0.05 * t_s - 0.2 * (row + 1)
    x_m, y_m = 30.0 * math.sin(phase), 30.0 * (1.0 - math.cos(phase)) + 6.0 * side
    error_m = 0.02 + 3.0 * math.exp(-0.1 * t_s) * (1.0 + 0.3 * math.sin(number))
    esc = {"rpm": 1200 + 10 * number, "voltage_V": 24.1, "current_A": 3.2, "temperature_C": 31}
    return {
        "id": number,
        "kind": "boat",
        "x_m": x_m + 0.7 * error_m,
        "y_m": y_m,
        "psi_rad": phase,
        "u_mps": 1.5,
        "v_mps": 0.02,
        "length_m": 1.2,
        "leader": max(number - 2, 0) or 100,
        "slot": [x_m, y_m],
        "error_m": error_m,
        "thrust_N": [3.0 + math.sin(t_s + number), 2.5],
        "limits_N": [-20.0, 20.0],
        "state": "FORMATION",
        "held": [],
        "text": None,
        "link_age_s": 0.05,
        "leader_age_s": 0.1,
        "battery_V": 24.1,
        "escs": [{**esc, "errors": 0}, {**esc, "errors": 2}],
        **changes,
    }


def leader(t_s: float) -> dict[str, Any]:
    """A virtual leader before them."""
    phase = 0.05 * t_s
    place = {"x_m": 30.0 * math.sin(phase), "y_m": 30.0 * (1.0 - math.cos(phase)) + 3.0}
    motion = {"psi_rad": phase, "u_mps": 1.5, "v_mps": 0.0, "link_age_s": 0.02}
    unknown = dict.fromkeys(
        ("length_m", "leader", "slot", "error_m", "thrust_N", "limits_N", "state", "text")
    )
    return {"id": 100, "kind": "leader", **place, **motion, **unknown, "held": [], "escs": []}


def frame(t_s: float, vessels: list[Any], *texts: tuple[int, float, int, int, str]) -> str:
    heard = {"address": "mcast:", "bytes_per_s": 12345.0, "damaged": 7, "ignored": 3}
    content = {
        "t_s": t_s,
        "heard": {**heard, "vessels": len(vessels)},
        "table": "table 3, boat 1 leads",
        "vessels": vessels,
        "texts": texts,
    }
    return json.dumps(content)


def fleet(boats: int) -> Frames:
    """That many boats behind a virtual leader."""
    return lambda t_s: frame(t_s, [leader(t_s), *(boat(n + 1, t_s) for n in range(boats))])


class Feeder:
    """Serves the live page at `url` and sends `frames`, which may be exchanged, ten times a second.

    It sends nothing while they are None. `begin_s`: the time that the first frame says.
    """

    def __init__(self, frames: Frames, begin_s: float = 0.0) -> None:
        self.frames = frames
        self.begin_s = begin_s
        self.port = 0
        self._loop = asyncio.new_event_loop()
        self._sockets: set[tornado.websocket.WebSocketHandler] = set()
        self._ready = threading.Event()

    @property
    def url(self) -> str:
        return f"http://127.0.0.1:{self.port}/"

    def serve(self) -> None:
        asyncio.set_event_loop(self._loop)
        self._loop.run_until_complete(self._serve())
        self._loop.close()

    def start(self, port: int = 0) -> None:
        self.port = port
        self._thread = threading.Thread(target=self.serve)
        self._thread.start()
        assert self._ready.wait(30)

    def stop(self) -> None:
        self._loop.call_soon_threadsafe(self._stopped.set)
        self._thread.join()

    def _send(self, message: str | bytes) -> None:
        for socket in self._sockets:
            # a page that has just been left
            with suppress(tornado.websocket.WebSocketClosedError):
                socket.write_message(message, binary=isinstance(message, bytes))

    async def _serve(self) -> None:
        self._stopped = asyncio.Event()
        server = tornado.httpserver.HTTPServer(_application(self._sockets))
        sockets = tornado.netutil.bind_sockets(self.port, "127.0.0.1", reuse_port=False)
        self.port = sockets[0].getsockname()[1]
        server.add_sockets(sockets)
        began_s = self._loop.time()
        self._ready.set()
        while not self._stopped.is_set():
            message = self.frames(self.begin_s + self._loop.time() - began_s)
            if message is not None:
                self._send(message)
            await asyncio.sleep(0.1)
        server.stop()
        for socket in list(self._sockets):
            socket.close()
        await server.close_all_connections()


def _application(sockets: set[tornado.websocket.WebSocketHandler]) -> tornado.web.Application:
    class Live(tornado.websocket.WebSocketHandler):
        def open(self, *args: str, **kwargs: str) -> None:
            sockets.add(self)

        def on_close(self) -> None:
            sockets.discard(self)

        def on_message(self, message: str | bytes) -> None:
            """Required by tornado; the page sends nothing."""

    class Page(tornado.web.RequestHandler):
        def get(self) -> None:
            self.finish(page.live())

    return tornado.web.Application([("/", Page), ("/live", Live)])


@contextmanager
def feeding(frames: Frames, port: int = 0, begin_s: float = 0.0) -> Iterator[Feeder]:
    feeder = Feeder(frames, begin_s)
    feeder.start(port)
    try:
        yield feeder
    finally:
        feeder.stop()
