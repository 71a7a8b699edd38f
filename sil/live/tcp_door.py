# SPDX-License-Identifier: MIT
"""A TCP port of a simulated boat, as in other simulators; ground stations command it there."""

import socket
from contextlib import suppress
from typing import NamedTuple

from sil.live.udp_end import LOOPBACK, UdpEnd
from sil.wire.mavlink_frames import end_of

_TRIES = 200


class _Client:
    """A connected ground station."""

    def __init__(self, connection: socket.socket) -> None:
        self.socket = connection
        self.socket.setblocking(False)
        self.begun = b""  # beginning of a frame whose rest has not come yet
        self.waiting = b""  # rest of messages that the socket could not take

    def send(self, messages: bytes) -> None:
        """Send whole messages, or none while earlier ones wait: a slow reader loses some."""
        rest = self.waiting or messages
        with suppress(BlockingIOError):
            rest = rest[self.socket.send(rest) :]
        self.waiting = rest


class Door(NamedTuple):
    """The address of a boat's port."""

    system: int
    port: int
    wished: int


class TcpDoor:
    """A server on the loopback interface, and its link to the boat.

    The port is `wished` or the next free one. OSError if none is free.
    """

    def __init__(self, system: int, wished: int) -> None:
        self._boat = UdpEnd()
        self.address = self._boat.address
        self._clients: list[_Client] = []
        self._server = _listening(wished)
        self.door = Door(system, self._server.getsockname()[1], wished)

    def descriptors(self) -> list[int]:
        """The descriptors to wait for."""
        sockets = (self._server, self._boat.socket, *(c.socket for c in self._clients))
        return [each.fileno() for each in sockets]

    def pass_on(self) -> None:
        """Accept new clients; pass on everything that has arrived, in both directions."""
        with suppress(BlockingIOError, ConnectionAbortedError):
            while True:
                self._clients.append(_Client(self._server.accept()[0]))
        self._clients = [client for client in self._clients if self._hear(client)]
        for data in self._boat.receive():
            for client in self._clients:
                with suppress(OSError):  # the client is gone: the next call notices
                    client.send(data)

    def close(self) -> None:
        """Close all sockets."""
        for client in self._clients:
            client.socket.close()
        self._server.close()
        self._boat.socket.close()

    def _hear(self, client: _Client) -> bool:
        """Pass on a client's frames, each as a datagram; False if it has left."""
        try:
            while data := client.socket.recv(4096):
                whole, client.begun = split(client.begun + data)
                for frame in whole:
                    self._boat.send(frame)
        except BlockingIOError:
            return True
        except OSError:
            pass
        client.socket.close()
        return False


def split(data: bytes) -> tuple[list[bytes], bytes]:
    """The whole MAVLink frames in a stream's bytes, and the beginning of the next one."""
    whole: list[bytes] = []
    at = 0
    while at < len(data):
        end = end_of(data, at)
        if end > len(data):
            break
        if end:
            whole.append(data[at:end])
        at = end or at + 1
    return whole, data[at:]


def _listening(wished: int) -> socket.socket:
    for port in range(wished, wished + _TRIES):
        server = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
        server.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            server.bind((LOOPBACK, port))
            server.listen()
        except OSError:
            server.close()
            continue
        server.setblocking(False)
        return server
    raise OSError(f"no TCP port is free from {wished} to {wished + _TRIES - 1}")
