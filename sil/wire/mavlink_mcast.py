# SPDX-License-Identifier: MIT
"""MAVLink by UDP where many may listen: a multicast group, or one address that is sent to.

`mcast:[GROUP:PORT[:ADDRESS]]`: pymavlink's group where none is given, on the interface that has
the address; without an address nothing leaves the machine. `udpout:HOST:PORT`: one listener.
"""

import ipaddress
import socket
import struct
from contextlib import suppress
from typing import NamedTuple

LOOPBACK = "127.0.0.1"
_IP_MULTICAST_ALL = 49  # Linux; Python has no name for it


class Group(NamedTuple):
    """A multicast group, and the address of the interface it is used on."""

    host: str = "239.255.145.50"
    port: int = 14550
    interface: str = LOOPBACK


def group_of(text: str) -> Group:
    """The group of what follows "mcast:"; ValueError."""
    parts = text.split(":") if text else []
    match parts:
        case []:
            group = Group()
        case [host, port, *interface] if len(interface) < 2:
            group = Group(host, port_of(port), *interface)
        case _:
            raise ValueError("must be mcast:[GROUP:PORT[:ADDRESS]]")
    ipaddress.IPv4Address(group.interface)
    if not ipaddress.IPv4Address(group.host).is_multicast:
        raise ValueError(f"{group.host} is no multicast group")
    return group


def port_of(text: str, least: int = 1) -> int:
    """A UDP or TCP port; ValueError."""
    if not (text.isascii() and text.isdecimal()) or not least <= int(text) < 1 << 16:
        raise ValueError(f'"{text}" is no port from {least} to 65535')
    return int(text)


def host_and_port(text: str, least: int = 1) -> tuple[str, int]:
    """The two of HOST:PORT; ValueError."""
    host, _, port = text.rpartition(":")
    if not host:
        raise ValueError(f'"{text}" is not HOST:PORT')
    return host.strip("[]"), port_of(port, least)


def listener(group: Group) -> socket.socket:
    """A socket that hears the group on its interface only, beside others; OSError."""
    ear = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    try:
        ear.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        ear.bind((group.host, group.port))
        with suppress(OSError):
            ear.setsockopt(socket.IPPROTO_IP, _IP_MULTICAST_ALL, 0)
        _join(ear, group)
        ear.setblocking(False)
    except OSError:
        ear.close()
        raise
    return ear


def _join(end: socket.socket, group: Group) -> None:
    membership = struct.pack(
        "4s4s", socket.inet_aton(group.host), socket.inet_aton(group.interface)
    )
    end.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, membership)


class Mouth:
    """Says to whoever listens there what it is given; a `send` as `sil.wire.link.Link` has it.

    ValueError for an address that is none, OSError where the network refuses it.
    """

    def __init__(self, address: str) -> None:
        scheme, _, rest = address.partition(":")
        try:
            if scheme not in ("mcast", "udpout"):
                raise ValueError("must be mcast:[GROUP:PORT[:ADDRESS]] or udpout:HOST:PORT")
            group = group_of(rest) if scheme == "mcast" else None
            self._to = group[:2] if group else host_and_port(rest)
        except ValueError as error:
            raise ValueError(f'"{address}": {error}') from None
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        try:
            if group is not None:
                self._speak_to(group)
            self._socket.connect(self._to)
        except OSError as error:
            self._socket.close()
            raise OSError(f"{address}: {error}") from None
        self._socket.setblocking(False)

    def _speak_to(self, group: Group) -> None:
        hops = 0 if group.interface == LOOPBACK else 1
        interface = socket.inet_aton(group.interface)
        self._socket.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_IF, interface)
        self._socket.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_TTL, hops)
        # Who joined on another interface of this machine hears the loopback's too, once it is in.
        _join(self._socket, group)

    def send(self, data: bytes, t_us: int) -> None:  # noqa: ARG002
        """Says whole messages now, or loses them: nobody listens, no network, a queue is full."""
        if data:
            with suppress(OSError):
                self._socket.send(data)

    def close(self) -> None:
        """Says no more."""
        self._socket.close()
