# SPDX-License-Identifier: MIT
"""A station's links that end: they are reported and opened again."""

import os
import select
import socket
from collections.abc import Iterator
from contextlib import closing

import pytest

from sil.fleet.ends import End, RealTime, end_at
from sil.fleet.station import Station
from tests.linux.process import LOOPBACK
from tests.sil.view.feed import BEAT, said

_PATIENCE_S = 200.0


class TenTimesFaster(RealTime):
    """A second is over in 0.1 s."""

    def now_s(self) -> float:
        return 10.0 * super().now_s()


class Server:
    """A TCP server, and one client's connection."""

    def __init__(self, port: int = 0) -> None:
        self.socket = socket.create_server((LOOPBACK, port))
        self.port = self.socket.getsockname()[1]
        self.address = f"tcp:{LOOPBACK}:{self.port}"

    def is_called(self) -> bool:
        return is_readable(self.socket)

    def close(self) -> None:
        self.socket.close()


def is_readable(end: socket.socket) -> bool:
    return bool(select.select([end], [], [], 0.0)[0])


@pytest.fixture
def servers() -> Iterator[tuple[Server, Server]]:
    with closing(Server()) as one, closing(Server()) as other:
        yield one, other


def test_of_two_links_the_one_that_ends_is_reported_and_opened_again(
    servers: tuple[Server, Server],
) -> None:
    one, _ = servers
    told: list[str] = []
    ends = [end_at(each.address) for each in servers]
    with closing(Station(ends, clock=TenTimesFaster())) as station:
        station.told = told.append
        first = one.socket.accept()[0]
        one.close()
        first.close()
        assert not station.run(35.0, lambda: len(told) > 1)  # refused several times
        assert told == [f"{one.address}: the other side has ended the connection; trying again"]
        with closing(Server(one.port)) as again:
            assert station.run(_PATIENCE_S, again.is_called)
            second = again.socket.accept()[0]
            second.sendall(said(7, BEAT))
            assert station.run(_PATIENCE_S, lambda: 7 in station.fleet.systems)
            assert told[1:] == [f"{one.address}: connected again"]
            # The station's messages go there again.
            assert station.run(_PATIENCE_S, lambda: is_readable(second))
            second.close()


def test_the_last_link_that_ends_is_an_error(servers: tuple[Server, Server]) -> None:
    one, _ = servers
    with closing(Station([end_at(one.address)], clock=TenTimesFaster())) as station:
        one.socket.accept()[0].close()
        with pytest.raises(OSError, match="the other side has ended the connection"):
            station.run(_PATIENCE_S)


@pytest.mark.parametrize("scheme", ["udpin", "udpout"])
def test_an_ipv6_address_of_a_udp_link_is_refused(scheme: str) -> None:
    with pytest.raises(ValueError, match="::1 is an IPv6 address: give an IPv4 address"):
        end_at(f"{scheme}:[::1]:14550")


def test_a_server_that_vanishes_silently_is_noticed(servers: tuple[Server, Server]) -> None:
    one, _ = servers
    end = end_at(one.address)
    assert_notices_loss(end)
    end.close()
    end.reopen()
    assert_notices_loss(end)
    end.close()


def assert_notices_loss(end: End) -> None:
    with socket.socket(fileno=os.dup(end.fileno())) as connection:
        assert connection.getsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE) == 1
        options = socket.TCP_KEEPIDLE, socket.TCP_KEEPINTVL, socket.TCP_KEEPCNT
        told = [connection.getsockopt(socket.IPPROTO_TCP, option) for option in options]
        assert told == [5, 2, 3]
        assert connection.getsockopt(socket.IPPROTO_TCP, socket.TCP_USER_TIMEOUT) == 11_000
