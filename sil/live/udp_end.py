# SPDX-License-Identifier: MIT
"""The simulator's end of a UDP link to a flotillad."""

import socket
from contextlib import suppress

LOOPBACK = "127.0.0.1"


class UdpEnd:
    """The simulator's end; `address` is the option for the flotillad, which sends first."""

    def __init__(self) -> None:
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.bind((LOOPBACK, 0))
        self.socket.setblocking(False)
        self.address = f"udpout:{LOOPBACK}:{self.socket.getsockname()[1]}"
        self._peer: tuple[str, int] | None = None

    def receive(self) -> list[bytes]:
        """The datagrams that have come."""
        chunks = []
        with suppress(BlockingIOError):
            while True:
                data, self._peer = self.socket.recvfrom(4096)
                chunks.append(data)
        return chunks

    def send(self, data: bytes) -> None:
        """Send a datagram; does nothing until the flotillad has been heard."""
        # A killed flotillad's port refuses; losing a datagram is harmless, MAVLink repeats itself.
        if self._peer is not None and data:
            with suppress(ConnectionRefusedError):
                self.socket.sendto(data, self._peer)
