# SPDX-License-Identifier: MIT
"""Listening at addresses of every kind: input is heard, nothing is sent."""

import asyncio
import os
import pty
import re
import socket
import tty
from collections.abc import Callable

import psutil
import pytest
from pymavlink import mavutil

from sil.live.free_port import free_port
from sil.view.hear import Listener
from sil.view.seen_fleet import Fleet
from sil.wire.mavlink_mcast import LOOPBACK, Mouth
from tests.sil.view.feed import BEAT, attitude, said
from tests.turns import some

_PATIENCE_S = 20.0


async def heard(listener: Listener, say: Callable[[], object], wanted: set[int]) -> Fleet:
    """The fleet after all wanted systems were heard; calls `say` repeatedly meanwhile."""
    fleet = Fleet(1.0)
    running = asyncio.ensure_future(listener.run(lambda messages: fleet.hear(messages, 0.0)))
    try:
        async with asyncio.timeout(_PATIENCE_S):
            while not wanted <= fleet.systems.keys():
                say()
                await asyncio.sleep(0.02)
                if running.done():
                    running.result()
    finally:
        running.cancel()
        await asyncio.gather(running, return_exceptions=True)
    return fleet


def test_datagrams_of_many_boats_are_heard_and_garbage_between_them_is_counted() -> None:
    port = free_port()
    listener = Listener(f"udpin:{LOOPBACK}:{port}")
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as end:

        def say() -> None:
            for system in range(1, 101):
                end.sendto(said(system, BEAT, attitude(0.1)), (LOOPBACK, port))
            end.sendto(b"no message at all", (LOOPBACK, port))

        fleet = asyncio.run(heard(listener, say, set(range(1, 101))))
        assert all(vessel.kind == "boat" for vessel in some(fleet.systems.values()))
        assert listener.ear.damaged % 17 == 0
        end.setblocking(False)
        with pytest.raises(BlockingIOError):
            end.recv(100)


def test_messages_of_pymavlink_to_its_multicast_group_are_heard() -> None:
    group = f"239.255.145.61:{free_port()}"
    listener, mouth = Listener(f"mcast:{group}"), Mouth(f"mcast:{group}")
    fleet = asyncio.run(heard(listener, lambda: mouth.send(said(5, BEAT), 0), {5}))
    assert set(fleet.systems) == {5}
    mouth.close()


def test_pymavlink_receives_messages_sent_to_the_group() -> None:
    port = free_port()
    try:
        station = mavutil.mavlink_connection(f"mcast:239.255.145.62:{port}")
    except OSError as error:
        pytest.skip(f"pymavlink joins on the default route's interface: {error}")
    mouth = Mouth(f"mcast:239.255.145.62:{port}")
    try:
        message = None
        for _ in range(100):
            mouth.send(said(6, BEAT), 0)
            message = station.recv_match(type="HEARTBEAT", blocking=True, timeout=0.1)
            if message is not None:
                break
        assert message is not None and message.get_srcSystem() == 6
    finally:
        mouth.close()
        station.close()


def test_a_server_is_heard_and_reconnected_and_sent_nothing() -> None:
    port = free_port()

    async def run() -> list[bytes]:
        told: list[bytes] = []
        listener = Listener(f"tcp:{LOOPBACK}:{port}")

        async def serve(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
            for system in (len(told) + 1, len(told) + 11):
                writer.write(said(system, BEAT)[:9])
                await writer.drain()
                writer.write(said(system, BEAT)[9:])
            writer.write_eof()
            told.append(await reader.read())
            writer.close()

        server = await asyncio.start_server(serve, LOOPBACK, port)
        async with server:
            await heard(listener, lambda: None, {1, 2, 11, 12})
        assert listener.ear.damaged == 0
        return told

    assert set(asyncio.run(run())) == {b""}


def test_a_server_that_vanishes_silently_is_noticed() -> None:
    port = free_port()
    writers: list[asyncio.StreamWriter] = []

    def say() -> None:
        """Say something as soon as the listener's connection probes whether the server is there."""
        for end in psutil.Process().net_connections("tcp4"):
            if end.raddr and end.raddr.port == port:
                with socket.socket(fileno=os.dup(end.fd)) as connection:
                    if connection.getsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE):
                        writers[0].write(said(1, BEAT))

    async def run() -> None:
        def serve(_: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
            writers.append(writer)

        async with await asyncio.start_server(serve, LOOPBACK, port):
            await heard(Listener(f"tcp:{LOOPBACK}:{port}"), say, {1})
            writers[0].close()

    asyncio.run(run())


def test_a_serial_line_is_heard_and_written_nothing() -> None:
    master, slave = pty.openpty()
    tty.setraw(master)
    os.set_blocking(master, False)
    listener = Listener(f"{os.ttyname(slave)}:115200")
    wire = said(3, BEAT) + said(4, BEAT)

    def say() -> None:
        os.write(master, wire[:30])
        os.write(master, wire[30:])

    fleet = asyncio.run(heard(listener, say, {3, 4}))
    assert set(fleet.systems) == {3, 4}
    with pytest.raises(BlockingIOError):
        os.read(master, 100)
    os.close(master)
    os.close(slave)


@pytest.mark.parametrize(
    "address",
    [
        "",
        "nowhere",
        "udpin:",
        "udpin:127.0.0.1",
        "udpin:127.0.0.1:0",
        "udpin:127.0.0.1:65536",
        "udpin:[::1]:14550",
        "tcp:x",
        "mcast:1",
        "mcast:127.0.0.1:14550",
        "mcast:239.255.145.50:14550:here",
        "/dev/null:7",
        "udpout:127.0.0.1:14550",
    ],
)
def test_an_invalid_address_is_refused(address: str) -> None:
    with pytest.raises(ValueError, match=f'^"{re.escape(address)}": '):
        Listener(address)


def test_an_address_in_use_is_refused() -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as end:
        end.bind((LOOPBACK, 0))
        port = end.getsockname()[1]
        with pytest.raises(OSError, match=str(port)):
            Listener(f"udpin:{LOOPBACK}:{port}")
