# SPDX-License-Identifier: MIT
"""A station's ends of MAVLink links, both ways.

`udpin:HOST:PORT`: boats send to this address; answers go back to the sender. `udpout:HOST:PORT`: a
boat or a router listens at this address. `tcp:HOST:PORT`: a server. `/dev/…[:BAUD]`: a serial line.
"""

import os
import select
import socket
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from functools import partial
from typing import Protocol

from sil.live.tcp_door import split
from sil.view import alarm
from sil.wire import tcp
from sil.wire.mavlink_mcast import host_and_port, udp_place
from sil.wire.serial_line import line_of, open_line

Peer = tuple[str, int] | None
"""The other side of a link: one of several peers at a `udpin`, None elsewhere."""

_MOST_BYTES = 65536
_CONNECT_S = 5.0


class End(Protocol):
    """One link's end; `address` as the caller wrote it."""

    address: str

    def fileno(self) -> int:
        """The descriptor to wait for."""

    def receive(self) -> list[tuple[Peer, bytes]]:
        """Whole frames received, and their senders. OSError if no more can come."""

    def send(self, frame: bytes, peer: Peer) -> None:
        """Send a frame to a peer; None: to all peers heard so far."""

    def close(self) -> None:
        """Close the end."""

    def reopen(self) -> None:
        """Open it again after `close`, not waiting for the other side; OSError if that fails."""
        raise OSError(f"{self.address}: cannot be opened again")


class Clock(Protocol):
    """The current time, the date, and a way to wait."""

    def now_s(self) -> float:
        """The current time from an arbitrary origin, s."""

    def unix_s(self) -> float:
        """The date and time of day, s since 1970 (UTC)."""

    def wait(self, ends: Sequence[End], for_s: float) -> Sequence[End]:
        """Wait at most `for_s`; return the ends that have received something."""


class RealTime:
    """The computer's clocks."""

    def now_s(self) -> float:
        """The current time, s."""
        return time.monotonic()

    def unix_s(self) -> float:
        """The date and time of day, s."""
        return time.time()

    def wait(self, ends: Sequence[End], for_s: float) -> Sequence[End]:
        """Wait for the descriptors."""
        return select.select(ends, [], [], for_s)[0]


class _Udp(End):
    """A socket for datagrams, which `begin` binds or connects; never ends."""

    def __init__(self, address: str, begin: Callable[[socket.socket], None]) -> None:
        self.address = address
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        try:
            begin(self._socket)
        except OSError:
            self._socket.close()
            raise
        self._socket.setblocking(False)

    def fileno(self) -> int:
        """The socket's."""
        return self._socket.fileno()

    def close(self) -> None:
        """Close the socket."""
        self._socket.close()


class UdpIn(_Udp):
    """Waits at an address for boats that send there."""

    def __init__(self, address: str, at: tuple[str, int]) -> None:
        super().__init__(address, lambda end: end.bind(at))
        self._peers: dict[Peer, None] = {}

    def receive(self) -> list[tuple[Peer, bytes]]:
        """The datagrams that have come."""
        heard: list[tuple[Peer, bytes]] = []
        with suppress(OSError):
            while True:
                data, peer = self._socket.recvfrom(_MOST_BYTES)
                self._peers[peer] = None
                heard.append((peer, data))
        return heard

    def send(self, frame: bytes, peer: Peer) -> None:
        """Send a datagram; it is lost if the receiver no longer listens."""
        for each in self._peers if peer is None else (peer,):
            with suppress(OSError):
                self._socket.sendto(frame, each or ("", 0))


class UdpOut(_Udp):
    """Sends to an address, and receives answers from there."""

    def __init__(self, address: str, to: tuple[str, int]) -> None:
        super().__init__(address, lambda end: end.connect(to))

    def receive(self) -> list[tuple[Peer, bytes]]:
        """The datagrams that have come."""
        heard: list[tuple[Peer, bytes]] = []
        with suppress(OSError):
            while True:
                heard.append((None, self._socket.recv(_MOST_BYTES)))
        return heard

    def send(self, frame: bytes, peer: Peer) -> None:  # noqa: ARG002
        """Send a datagram; it is lost if no program listens."""
        with suppress(OSError):
            self._socket.send(frame)


class Stream(End):
    """A TCP connection or a serial line, by its descriptor, which it owns.

    `again` reopens the line, or begins a new connection.
    """

    def __init__(self, address: str, descriptor: int, again: Callable[[], int]) -> None:
        self.address = address
        self._again = again
        self._begun = b""  # beginning of a frame whose rest has not come yet
        self._take(descriptor)

    def fileno(self) -> int:
        """The descriptor."""
        return self._descriptor

    def receive(self) -> list[tuple[Peer, bytes]]:
        """The whole frames received. OSError if the other side is gone."""
        whole: list[bytes] = []
        with suppress(BlockingIOError):
            data = os.read(self._descriptor, _MOST_BYTES)
            if not data:
                raise ConnectionResetError(f"{self.address}: the other side has ended")
            whole, self._begun = split(self._begun + data)
        return [(None, b"".join(whole))] if whole else []

    def send(self, frame: bytes, peer: Peer) -> None:  # noqa: ARG002
        """Send a frame; it is lost if the line has no room for it."""
        with suppress(OSError):
            os.write(self._descriptor, frame)

    def close(self) -> None:
        """Close the descriptor."""
        os.close(self._descriptor)

    def reopen(self) -> None:
        """Open the line, or begin a connection. OSError."""
        self._take(self._again())

    def _take(self, descriptor: int) -> None:
        self._descriptor = descriptor
        self._begun = b""
        os.set_blocking(descriptor, False)


def _connected(address: str, to: tuple[str, int]) -> Stream:
    connection = socket.create_connection(to, _CONNECT_S)
    tcp.notice_loss(connection)
    family, server = connection.family, connection.getpeername()
    return Stream(
        address, connection.detach(), lambda: tcp.begin_connection(family, server).detach()
    )


def end_at(address: str, option: str = "--mavlink") -> End:
    """Open the end at this address. ValueError if it is malformed, OSError if it fails."""
    scheme, _, rest = address.partition(":")
    try:
        if scheme == "udpin":
            return UdpIn(address, udp_place(rest))
        if scheme == "udpout":
            return UdpOut(address, udp_place(rest))
        if scheme == "tcp":
            return _connected(address, host_and_port(rest))
        if address.startswith("/dev/"):
            line = partial(open_line, *line_of(address), os.O_RDWR)
            return Stream(address, line(), line)
        raise ValueError("must be udpin:HOST:PORT, udpout:HOST:PORT, tcp:HOST:PORT or /dev/…")
    except ValueError as error:
        raise ValueError(f'{option} "{address}": {error}') from None
    except OSError as error:
        raise OSError(f"{address}: {alarm.of_error(error)}") from None
