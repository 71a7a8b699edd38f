# SPDX-License-Identifier: MIT
"""Listens at a MAVLink address; cannot send.

`udpin:HOST:PORT`: datagrams sent there. `mcast:[GROUP:PORT[:ADDRESS]]`: as in
`sil.wire.mavlink_mcast`. `tcp:HOST:PORT`: connects to a server. `/dev/…[:BAUD]`: a serial line.
"""

import asyncio
import os
import socket
from collections.abc import Callable, Iterable
from contextlib import suppress

from sil.view import alarm
from sil.wire import mavlink_mcast, tcp
from sil.wire.mavlink_ear import Ear, Message
from sil.wire.serial_line import line_of, open_line

Take = Callable[[Iterable[Message]], None]

_RETRY_S = 1.0
_MOST_BYTES = 65536
_MOST_DATAGRAMS = 256  # in a row, before the page is served again


class Listener:
    """Listens at one address. ValueError if it is invalid, OSError if it cannot be opened.

    `ear` counts bytes. A server or serial line that is absent or lost is retried every second;
    meanwhile `trouble` names the problem and its remedy.
    """

    def __init__(self, address: str) -> None:
        self.address = address
        self.trouble: str | None = None
        try:
            self._socket = _socket_of(address)
        except ValueError as error:
            raise ValueError(f'"{address}": {error}') from None
        self.ear = Ear(stream=self._socket is None)

    async def run(self, take: Take) -> None:
        """Pass all messages to `take` until cancelled."""
        if self._socket is not None:
            await self._hear_datagrams(self._socket, take)
        while True:
            try:
                if self.address.startswith("tcp:"):
                    await self._hear_server(take)
                    self.trouble = "the server has ended the connection; check that it still runs"
                else:
                    await self._hear_line(take)
                    self.trouble = "the device is gone; check its cable"
            except OSError as error:
                self.trouble = alarm.of_error(error)
            self.ear.forget()
            await asyncio.sleep(_RETRY_S)

    async def _hear_datagrams(self, end: socket.socket, take: Take) -> None:
        def hear() -> None:
            with suppress(BlockingIOError):
                for _ in range(_MOST_DATAGRAMS):
                    take(self.ear.hear(end.recv(_MOST_BYTES)))

        loop = asyncio.get_running_loop()
        loop.add_reader(end, hear)
        try:
            await loop.create_future()
        finally:
            loop.remove_reader(end)
            end.close()

    async def _hear_server(self, take: Take) -> None:
        host, port = mavlink_mcast.host_and_port(self.address.removeprefix("tcp:"))
        reader, writer = await asyncio.open_connection(host, port)
        tcp.notice_loss(writer.get_extra_info("socket"))
        self.trouble = None
        try:
            while data := await reader.read(_MOST_BYTES):
                take(self.ear.hear(data))
        finally:
            writer.close()
            with suppress(OSError):
                await writer.wait_closed()

    async def _hear_line(self, take: Take) -> None:
        loop, ended = asyncio.get_running_loop(), asyncio.Event()
        line = open_line(*line_of(self.address))
        self.trouble = None

        def hear() -> None:
            try:
                data = os.read(line, _MOST_BYTES)
            except BlockingIOError:
                return
            except OSError:
                data = b""
            if data:
                take(self.ear.hear(data))
            else:
                ended.set()

        loop.add_reader(line, hear)
        try:
            await ended.wait()
        finally:
            loop.remove_reader(line)
            os.close(line)


def _socket_of(address: str) -> socket.socket | None:
    """The socket that receives datagrams; None if the address is a stream's."""
    scheme, _, rest = address.partition(":")
    if scheme == "mcast":
        group = mavlink_mcast.group_of(rest)
        try:
            return mavlink_mcast.listener(group)
        except OSError as error:
            raise OSError(f"{address}: {alarm.of_error(error)}") from None
    if scheme == "udpin":
        at = mavlink_mcast.udp_place(rest)
        end = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        try:
            end.bind(at)
        except OSError as error:
            end.close()
            raise OSError(f"{address}: {alarm.of_error(error)}") from None
        end.setblocking(False)
        return end
    if scheme == "tcp":
        mavlink_mcast.host_and_port(rest)
    elif not address.startswith("/dev/"):
        wanted = "mcast:, udpin:HOST:PORT, tcp:HOST:PORT or /dev/…"
        raise ValueError(f"no file, no folder and no MAVLink address; addresses are {wanted}")
    else:
        line_of(address)
    return None
