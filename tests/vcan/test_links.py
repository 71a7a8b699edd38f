# SPDX-License-Identifier: MIT
"""MAVLink links on a network that appears late and disappears, in a network namespace."""

import socket
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.flotillad import needs_flotillad
from tests.linux.process import RealSea
from tests.vcan.bus import run

FAR = "198.51.100.7"  # nobody's: RFC 5737
PORT = 14550


@pytest.fixture
def sea(tmp_path: Path) -> Iterator[RealSea]:
    needs_flotillad()
    with RealSea(0, tmp_path) as sea:
        yield sea


def hear(sea: RealSea) -> None:
    """Wait until a message reaches the far address."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as far:
        far.bind((FAR, PORT))
        far.setblocking(False)
        heard: list[bytes] = []

        def word() -> bool:
            try:
                heard.append(far.recv(4096))
            except BlockingIOError:
                return False
            return True

        sea.until(word)


@pytest.mark.parametrize("kind", ["udpout", "udpbcast"])
def test_a_link_to_a_network_that_comes_late_and_goes_works_while_it_is_there(
    sea: RealSea, kind: str
) -> None:
    sea.start(f"--mavlink={kind}:{FAR}:{PORT}")
    sea.until(sea.ready)
    for _ in range(2):
        run("ip", "address", "add", f"{FAR}/32", "dev", "lo")
        try:
            hear(sea)
        finally:
            run("ip", "address", "del", f"{FAR}/32", "dev", "lo")
        beats = len(sea.named("HEARTBEAT"))
        sea.until(lambda beats=beats: len(sea.named("HEARTBEAT")) > beats + 1)
