# SPDX-License-Identifier: MIT
"""A station's ends of MAVLink links, both ways.

`udpin:HOST:PORT`: boats send there, and are answered where they sent from. `udpout:HOST:PORT`: a
boat or a router listens there. `tcp:HOST:PORT`: a server. `/dev/…[:BAUD]`: a serial line.
"""

import os
import select
import socket
import termios
import time
from collections.abc import Sequence
from contextlib import suppress
from typing import Protocol

from sil.live.tcp_door import split
from sil.view import alarm
from sil.wire.mavlink_mcast import host_and_port
from sil.wire.serial_line import line_of, open_line

Peer = tuple[str, int] | None
"""Who is at the other side: one of several at a `udpin`, None elsewhere."""

_MOST_BYTES = 65536
_CONNECT_S = 5.0


class End(Protocol):
    """One link's end; `address` as the caller spelled it."""

    address: str

    def fileno(self) -> int:
        """The descriptor to wait for."""

    def receive(self) -> list[tuple[Peer, bytes]]:
        """Whole frames that have come, and from whom. OSError if nothing will come any more."""

    def send(self, frame: bytes, peer: Peer) -> None:
        """Send a frame to a peer, to all that have been heard if it is None."""

    def close(self) -> None:
        """Close it."""


class Clock(Protocol):
    """The time, and waiting for it."""

    def now_s(self) -> float:
        """Now, from any beginning."""

    def wait(self, ends: Sequence[End], for_s: float) -> Sequence[End]:
        """The ends at which something has come, after `for_s` at most."""


class RealTime:
    """The monotonic clock."""

    def now_s(self) -> float:
        """Now."""
        return time.monotonic()

    def wait(self, ends: Sequence[End], for_s: float) -> Sequence[End]:
        """Wait for the descriptors."""
        return select.select(ends, [], [], for_s)[0]


class UdpIn:
    """Waits at an address for boats that send there."""

    def __init__(self, address: str, at: tuple[str, int]) -> None:
        self.address = address
        self._peers: dict[Peer, None] = {}
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        try:
            self._socket.bind(at)
        except OSError:
            self._socket.close()
            raise
        self._socket.setblocking(False)

    def fileno(self) -> int:
        """The socket's."""
        return self._socket.fileno()

    def receive(self) -> list[tuple[Peer, bytes]]:
        """The datagrams that have come."""
        heard: list[tuple[Peer, bytes]] = []
        with suppress(BlockingIOError, ConnectionRefusedError):
            while True:
                data, peer = self._socket.recvfrom(_MOST_BYTES)
                self._peers[peer] = None
                heard.append((peer, data))
        return heard

    def send(self, frame: bytes, peer: Peer) -> None:
        """Send a datagram; it is lost where nobody listens any more."""
        for each in self._peers if peer is None else (peer,):
            with suppress(OSError):
                self._socket.sendto(frame, each or ("", 0))

    def close(self) -> None:
        """Close the socket."""
        self._socket.close()


class UdpOut:
    """Sends to an address, and hears whoever answers from there."""

    def __init__(self, address: str, to: tuple[str, int]) -> None:
        self.address = address
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        try:
            self._socket.connect(to)
        except OSError:
            self._socket.close()
            raise
        self._socket.setblocking(False)

    def fileno(self) -> int:
        """The socket's."""
        return self._socket.fileno()

    def receive(self) -> list[tuple[Peer, bytes]]:
        """The datagrams that have come."""
        heard: list[tuple[Peer, bytes]] = []
        with suppress(BlockingIOError, ConnectionRefusedError):
            while True:
                heard.append((None, self._socket.recv(_MOST_BYTES)))
        return heard

    def send(self, frame: bytes, peer: Peer) -> None:  # noqa: ARG002
        """Send a datagram; it is lost where nobody listens."""
        with suppress(OSError):
            self._socket.send(frame)

    def close(self) -> None:
        """Close the socket."""
        self._socket.close()


class Stream:
    """A TCP connection or a serial line, by its descriptor, which it owns."""

    def __init__(self, address: str, descriptor: int) -> None:
        self.address = address
        self._descriptor = descriptor
        self._begun = b""  # of a frame that has not come whole
        os.set_blocking(descriptor, False)

    def fileno(self) -> int:
        """The descriptor."""
        return self._descriptor

    def receive(self) -> list[tuple[Peer, bytes]]:
        """The frames that have come whole. OSError where the other side is gone."""
        whole: list[bytes] = []
        with suppress(BlockingIOError):
            data = os.read(self._descriptor, _MOST_BYTES)
            if not data:
                raise ConnectionResetError(f"{self.address}: the other side has ended")
            whole, self._begun = split(self._begun + data)
        return [(None, b"".join(whole))] if whole else []

    def send(self, frame: bytes, peer: Peer) -> None:  # noqa: ARG002
        """Send a frame; a line that has no room for it loses it."""
        with suppress(OSError):
            os.write(self._descriptor, frame)

    def close(self) -> None:
        """Close the descriptor."""
        os.close(self._descriptor)


def end_at(address: str, option: str = "--mavlink") -> End:
    """Open the end at this address. ValueError if it is malformed, OSError if it fails."""
    scheme, _, rest = address.partition(":")
    try:
        if scheme == "udpin":
            return UdpIn(address, host_and_port(rest))
        if scheme == "udpout":
            return UdpOut(address, host_and_port(rest))
        if scheme == "tcp":
            connection = socket.create_connection(host_and_port(rest), _CONNECT_S)
            return Stream(address, connection.detach())
        if address.startswith("/dev/"):
            return Stream(address, open_line(*line_of(address), os.O_RDWR))
        raise ValueError("must be udpin:HOST:PORT, udpout:HOST:PORT, tcp:HOST:PORT or /dev/…")
    except ValueError as error:
        raise ValueError(f'{option} "{address}": {error}') from None
    except (OSError, termios.error) as error:
        raise OSError(f"{address}: {alarm.of_error(error)}") from None
