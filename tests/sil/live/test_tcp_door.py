# SPDX-License-Identifier: MIT
"""The TCP ports of a live run's boats."""

from __future__ import annotations

import random
import select
import socket
import time
from collections.abc import Callable, Iterator
from contextlib import closing, suppress

import pytest
from pymavlink.dialects.v20 import common as mavlink

from sil.live.tcp_door import TcpDoor, split

LOOPBACK = "127.0.0.1"


def frames(count: int) -> list[bytes]:
    packer = mavlink.MAVLink(None, 250, 190)
    return [
        bytes(
            mavlink.MAVLink_statustext_message(6, b"x" * (k % 50)).pack(packer, force_mavlink1=odd)
        )
        for k in range(count)
        for odd in (False, True)
    ]


def test_a_stream_in_any_pieces_is_its_frames() -> None:
    dice = random.Random(4)
    sent = frames(60)
    stream, got, begun = b"\x00\x17" + b"".join(sent), [], b""
    while stream:
        size = dice.randint(1, 40)
        whole, begun = split(begun + stream[:size])
        got += whole
        stream = stream[size:]
    assert got == sent and begun == b""


class Berth:
    """A door, and the boat's end of its link."""

    def __init__(self, wished: int) -> None:
        self.door = TcpDoor(1, wished)
        self.port = self.door.door.port
        _, host, port = self.door.address.split(":")
        self.boat = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.boat.connect((host, int(port)))
        self.boat.setblocking(False)

    def close(self) -> None:
        self.door.close()
        self.boat.close()

    def client(self) -> socket.socket:
        client = socket.create_connection((LOOPBACK, self.port))
        client.setblocking(False)
        return client

    def until(self, done: Callable[[], object]) -> None:
        end_s = time.monotonic() + 60.0  # beside a build
        while not done():
            assert time.monotonic() < end_s
            select.select(self.door.descriptors(), [], [], 0.05)
            self.door.pass_on()


def received(end: socket.socket) -> bytes:
    data = b""
    with suppress(BlockingIOError):
        while chunk := end.recv(65536):
            data += chunk
    return data


@pytest.fixture
def berth() -> Iterator[Berth]:
    with socket.create_server((LOOPBACK, 0)) as probe:
        free = probe.getsockname()[1]
    with closing(Berth(free)) as berth:
        yield berth


def test_two_clients_hear_the_boat_and_each_is_heard(berth: Berth) -> None:
    said = frames(2)
    with berth.client() as one, berth.client() as two:
        got = {one: b"", two: b""}

        def heard() -> bool:
            for end in got:
                got[end] += received(end)
            return all(said[0] in each for each in got.values())

        berth.boat.send(said[0])
        berth.until(lambda: (berth.boat.send(said[0]), heard())[1])
        two.sendall(said[1][:9])
        berth.door.pass_on()
        two.sendall(said[1][9:] + said[2])
        datagrams: list[bytes] = []

        def hears() -> bool:
            with suppress(BlockingIOError):
                while True:
                    datagrams.append(berth.boat.recv(4096))
            return len(datagrams) == 2

        berth.until(hears)
        assert datagrams == [said[1], said[2]]


def test_a_client_that_leaves_or_reads_nothing_does_not_block_others(berth: Berth) -> None:
    said = frames(1)[0]
    with berth.client() as listener, berth.client():  # the second one reads nothing
        berth.client().close()
        got = b""

        def heard() -> bool:
            nonlocal got
            for _ in range(500):
                berth.boat.send(said)
                berth.door.pass_on()
                got += received(listener)
            return len(got) > 20_000 * len(said)

        berth.until(heard)
        assert got.replace(said, b"") == b""


def test_if_its_port_is_in_use_the_next_free_one_is_taken(berth: Berth) -> None:
    with closing(TcpDoor(1, berth.port)) as other:
        assert other.door.port > other.door.wished == berth.port
