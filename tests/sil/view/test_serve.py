# SPDX-License-Identifier: MIT
"""The server of the page, with real sockets and clients."""

import asyncio
import json
import random
import socket
import urllib.request
from collections.abc import Awaitable, Callable
from contextlib import suppress
from itertools import pairwise
from typing import Any

import pytest
from pymavlink.dialects.v20 import common as mavlink
from tornado.httpclient import AsyncHTTPClient, HTTPClientError
from tornado.websocket import websocket_connect

from sil.live.free_port import free_port
from sil.view.history import column, numbers
from sil.view.live_source import Live
from sil.view.serve import Server, _Frames
from sil.wire.mavlink_mcast import LOOPBACK
from tests.sil.view.feed import BEAT, attitude, local, origin, said
from tests.turns import some

_PATIENCE_S = 20.0
Use = Callable[[str], Awaitable[Any]]


def served(source: Any, use: Use, port: int = 0) -> Any:
    """The result of `use` with the URL of a running server."""

    async def run() -> Any:
        server = Server(source, (LOOPBACK, port))
        running = asyncio.ensure_future(server.run())
        try:
            async with asyncio.timeout(_PATIENCE_S):
                return await use(server.url)
        finally:
            running.cancel()
            with suppress(asyncio.CancelledError):
                await running

    return asyncio.run(run())


class Sender:
    """A context manager that repeatedly sends given data to a port."""

    def __init__(self, port: int, say: Callable[[], list[bytes]]) -> None:
        self._port, self._say = port, say
        self._end = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)

    async def __aenter__(self) -> None:
        self._running = asyncio.ensure_future(self._run())

    async def __aexit__(self, *_: object) -> None:
        self._running.cancel()
        self._end.close()

    async def _run(self) -> None:
        while True:
            for data in self._say():
                self._end.sendto(data, (LOOPBACK, self._port))
            await asyncio.sleep(0.02)


async def frame_in_which(url: str, seen: Callable[[dict[str, Any]], object]) -> dict[str, Any]:
    page = await websocket_connect(f"ws{url.removeprefix('http')}live")
    try:
        while (message := await page.read_message()) is not None:
            frame: dict[str, Any] = json.loads(message)
            if seen(frame):
                return frame
    finally:
        page.close()
        while await page.read_message() is not None:
            pass
    raise AssertionError("the server has closed the connection")


def fleet_of(count: int) -> list[bytes]:
    ids = range(1, count + 1)
    return [said(i, BEAT, origin(1, 2), attitude(0.1), local(float(i), 0.0)) for i in ids]


def test_a_page_is_sent_ten_frames_a_second_and_never_more() -> None:
    port = free_port()

    async def use(url: str) -> list[float]:
        async with Sender(port, lambda: fleet_of(4)):
            frame = await frame_in_which(url, lambda frame: frame["heard"]["vessels"] == 4)
            assert [v["x_m"] for v in frame["vessels"]] == [1.0, 2.0, 3.0, 4.0]
            heard = frame["heard"]
            assert heard["address"] == f"udpin:{LOOPBACK}:{port}" and heard["damaged"] == 0
            times: list[float] = []
            await frame_in_which(url, lambda f: times.append(f["t_s"]) or len(times) == 6)
            return times

    times = served(Live(f"udpin:{LOOPBACK}:{port}", 1.0), use)
    # a busy machine may leave frames out, but hardly ever all, and never adds any
    assert times[-1] - times[0] > 0.4
    assert min(b - a for a, b in pairwise(times)) < 0.15


def test_garbage_and_a_hundred_systems_leave_the_page_up_and_are_counted() -> None:
    rng, port = random.Random(2), free_port()

    def say() -> list[bytes]:
        return [*fleet_of(100), rng.randbytes(700), b"\xfd" * 300, said(255, attitude(0.0))]

    async def use(url: str) -> dict[str, Any]:
        async with Sender(port, say):
            return await frame_in_which(
                url, lambda f: f["heard"]["vessels"] == 100 and f["heard"]["damaged"] > 3000
            )

    frame = served(Live(f"udpin:{LOOPBACK}:{port}", 1.0), use)
    assert frame["heard"]["ignored"] > 0 and frame["heard"]["bytes_per_s"] > 0
    assert all(v["state"] == "FORMATION" for v in some(frame["vessels"]))


def test_a_page_that_does_not_read_does_not_delay_others() -> None:
    port = free_port()

    async def use(url: str) -> None:
        host, at = url.removeprefix("http://").rstrip("/").split(":")
        with socket.create_connection((host, int(at))) as deaf:
            deaf.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 2048)
            deaf.send(
                f"GET /live HTTP/1.1\r\nHost: {host}:{at}\r\nUpgrade: websocket\r\n"
                "Connection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
                "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n".encode()
            )
            async with Sender(port, lambda: fleet_of(200)):
                count = iter(range(25))
                await frame_in_which(url, lambda _: next(count) == 24)

    served(Live(f"udpin:{LOOPBACK}:{port}", 1.0), use)


def test_another_sites_page_is_sent_nothing() -> None:
    async def use(url: str) -> int:
        request = urllib.request.Request(f"{url}live", headers={"Origin": "http://elsewhere"})
        for name, text in (
            ("Upgrade", "websocket"),
            ("Connection", "Upgrade"),
            ("Sec-WebSocket-Version", "13"),
            ("Sec-WebSocket-Key", "dGhlIHNhbXBsZSBub25jZQ=="),
        ):
            request.add_header(name, text)
        with pytest.raises(HTTPClientError) as refused:
            await AsyncHTTPClient().fetch(request.full_url, headers=dict(request.header_items()))
        return refused.value.code

    assert served(Live(f"udpin:{LOOPBACK}:{free_port()}", 1.0), use) == 403


def test_the_page_asks_for_nothing_elsewhere_and_a_replay_has_its_history() -> None:
    history = {"title": "a run", "t_s": column([0.0, 1.0]), "vessels": []}

    async def use(url: str) -> tuple[Any, Any]:
        client = AsyncHTTPClient()
        return await client.fetch(url), await client.fetch(f"{url}history")

    page, told = served(history, use)
    policy = page.headers["Content-Security-Policy"]
    assert "default-src 'none'" in policy and "http" not in policy
    assert list(numbers(json.loads(told.body)["t_s"])) == [0.0, 1.0]


async def said_url(url: str) -> str:
    assert (await AsyncHTTPClient().fetch(url)).code == 200
    return url


def test_where_a_port_is_taken_the_next_free_one_is() -> None:
    history = {"title": "", "t_s": column([0.0]), "vessels": []}
    with socket.create_server((LOOPBACK, 0)) as taken:
        port = taken.getsockname()[1]
        url = served(history, said_url, port)
        assert port < int(url.rstrip("/").rpartition(":")[2]) < port + 20


def test_after_the_source_ends_the_page_is_a_replay() -> None:
    port = free_port()

    async def run() -> tuple[str, dict[str, Any]]:
        server = Server(Live(f"udpin:{LOOPBACK}:{port}", 1.0), (LOOPBACK, 0))
        running = asyncio.ensure_future(server.run())
        async with Sender(port, lambda: fleet_of(3)):
            await frame_in_which(server.url, lambda frame: frame["t_s"] > 0.5)
        page = await websocket_connect(f"ws{server.url.removeprefix('http')}live")
        server.end()
        while (message := await page.read_message()) is not None:
            if message == '{"over":true}':
                break
        page.close()
        client = AsyncHTTPClient()
        told = json.loads((await client.fetch(f"{server.url}history")).body)
        text = (await client.fetch(server.url)).body.decode()
        running.cancel()
        with suppress(asyncio.CancelledError):
            await running
        return text, told

    text, told = asyncio.run(asyncio.wait_for(run(), _PATIENCE_S))
    assert [vessel["id"] for vessel in told["vessels"]] == [1, 2, 3]
    assert told["origin_deg"] == pytest.approx([1e-7, 2e-7])
    assert numbers(told["t_s"])[-1] > 0.3 and f"udpin:{LOOPBACK}:{port}" in told["title"]
    assert '<body class="replay">' in text


def test_texts_are_sent_again_to_a_page_that_is_opened_later() -> None:
    port = free_port()
    text = said(1, mavlink.MAVLink_statustext_message(2, b"low battery"))

    async def use(url: str) -> list[Any]:
        async with Sender(port, lambda: [*fleet_of(1), text]):
            frames = [await frame_in_which(url, lambda f: f.get("texts")) for _ in range(2)]
        return [[told[0], *told[2:]] for frame in frames for told in frame["texts"]]

    assert served(Live(f"udpin:{LOOPBACK}:{port}", 1.0), use) == 2 * [[1, 1, 2, "low battery"]]


def test_page_that_reconnects_after_the_end_is_sent_the_end() -> None:
    async def run() -> str | bytes | None:
        server = Server(Live(f"udpin:{LOOPBACK}:{free_port()}", 1.0), (LOOPBACK, 0))
        running = asyncio.ensure_future(server.run())
        await asyncio.sleep(0)
        server.end()
        page = await websocket_connect(f"ws{server.url.removeprefix('http')}live")
        told = await page.read_message()
        page.close()
        assert await page.read_message() is None
        running.cancel()
        with suppress(asyncio.CancelledError):
            await running
        return told

    assert asyncio.run(asyncio.wait_for(run(), _PATIENCE_S)) == '{"over":true}'


def test_the_end_is_sent_to_a_page_that_is_still_receiving_a_frame() -> None:
    class Slow(_Frames):
        def __init__(self) -> None:
            self.initialize(set(), lambda: False)
            self.told: list[Any] = []

        def write_message(self, message: Any, binary: bool = False) -> "asyncio.Future[None]":
            self.told.append(message)
            return asyncio.get_running_loop().create_future()

    async def run() -> list[Any]:
        page = Slow()
        for text in ("first", "second"):
            page.tell(text)
        page.end()
        return page.told

    assert asyncio.run(run()) == ["first", '{"over":true}']


def test_missing_server_is_reported_with_a_remedy() -> None:
    async def use(url: str) -> dict[str, Any]:
        return await frame_in_which(url, lambda frame: frame["heard"]["alarm"])

    frame = served(Live(f"tcp:{LOOPBACK}:{free_port()}", 1.0), use)
    assert "nothing listens there; check that the server runs" in frame["heard"]["alarm"]


def test_silence_is_reported_after_three_seconds() -> None:
    async def use(url: str) -> dict[str, Any]:
        return await frame_in_which(url, lambda frame: frame["heard"]["alarm"])

    frame = served(Live(f"udpin:{LOOPBACK}:{free_port()}", 1.0), use)
    assert 3.0 <= frame["t_s"] < 6.0
    assert frame["heard"]["alarm"].startswith("nothing heard for 3 s: check that the boats")


def test_another_sites_name_for_this_machine_opens_no_page() -> None:
    async def use(url: str) -> list[int]:
        client, port, codes = AsyncHTTPClient(), url.rstrip("/").rpartition(":")[2], []
        for name in ("elsewhere.example", "127.0.0.1.example", "localhost", LOOPBACK, "[::1]"):
            headers = {"Host": f"{name}:{port}"}
            answer = await client.fetch(url, headers=headers, raise_error=False)
            codes.append(answer.code)
        return codes

    assert served({"title": "", "t_s": column([0.0]), "vessels": []}, use) == [
        404,
        404,
        200,
        200,
        200,
    ]
