# SPDX-License-Identifier: MIT
"""TCP connections whose other side may vanish silently, with its router's power or its radio.

Source: Linux, tcp(7).
"""

import errno
import os
import socket
from typing import Any

_IDLE_S, _EVERY_S, _PROBES = 5, 2, 3
_LOST_S = _IDLE_S + _EVERY_S * _PROBES
_TRIES = 2  # after the first one: an unanswered connection fails after 7 s


def notice_loss(connection: socket.socket) -> None:
    """Make a connection fail when the other side has acknowledged nothing for 11 s."""
    connection.setsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE, 1)
    for option, value in (
        (socket.TCP_KEEPIDLE, _IDLE_S),
        (socket.TCP_KEEPINTVL, _EVERY_S),
        (socket.TCP_KEEPCNT, _PROBES),
        (socket.TCP_USER_TIMEOUT, 1000 * _LOST_S),  # there are no probes while data is on its way
    ):
        connection.setsockopt(socket.IPPROTO_TCP, option, value)


def begin_connection(family: int, server: Any) -> socket.socket:
    """Begin a connection without waiting; if it fails later, reading it fails. OSError."""
    connection = socket.socket(family, socket.SOCK_STREAM)
    connection.setblocking(False)
    notice_loss(connection)
    connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_SYNCNT, _TRIES)
    number = connection.connect_ex(server)
    if number not in (0, errno.EINPROGRESS):
        connection.close()
        raise OSError(number, os.strerror(number))
    return connection
