# SPDX-License-Identifier: MIT
"""MAVLink over UDP: to a multicast group with any number of listeners, or to one address.

`mcast:[GROUP:PORT[:ADDRESS]]`: by default pymavlink's group; sent on the interface with that
address; without an address nothing leaves the machine. `udpout:HOST:PORT`: one listener.
"""

import ipaddress
import socket
import struct
from contextlib import suppress
from typing import NamedTuple

LOOPBACK = "127.0.0.1"
_IP_MULTICAST_ALL = 49  # Linux; Python has no name for it


class Group(NamedTuple):
    """A multicast group, its port and the address of the interface to use."""

    host: str = "239.255.145.50"
    port: int = 14550
    interface: str = LOOPBACK


def group_of(text: str) -> Group:
    """Parse the text after "mcast:"; ValueError if it is invalid."""
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
        raise ValueError(f"{group.host} is not a multicast group (224.0.0.0 to 239.255.255.255)")
    return group


def port_of(text: str, least: int = 1) -> int:
    """Parse a UDP or TCP port; ValueError if it is not in `least` … 65535."""
    if not (text.isascii() and text.isdecimal()) or not least <= int(text) < 1 << 16:
        raise ValueError(f'"{text}" is not a port from {least} to 65535')
    return int(text)


def host_and_port(text: str, least: int = 1) -> tuple[str, int]:
    """Parse HOST:PORT; ValueError if it is invalid."""
    host, _, port = text.rpartition(":")
    if not host:
        raise ValueError(f'"{text}" is not HOST:PORT')
    return host.strip("[]"), port_of(port, least)


def udp_place(text: str) -> tuple[str, int]:
    """Parse HOST:PORT of a UDP link; ValueError if it is invalid or IPv6."""
    host, port = host_and_port(text)
    if ":" in host:
        raise ValueError(f"{host} is an IPv6 address: give an IPv4 address, 127.0.0.1 for example")
    return host, port


def listener(group: Group) -> socket.socket:
    """A shared socket that receives the group on its interface only; OSError if refused."""
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
    """Sends to an address; its `send` has the signature of `sil.wire.link.Link`'s.

    ValueError for an invalid address, OSError if the network refuses it.
    """

    def __init__(self, address: str) -> None:
        scheme, _, rest = address.partition(":")
        try:
            if scheme not in ("mcast", "udpout"):
                raise ValueError("must be mcast:[GROUP:PORT[:ADDRESS]] or udpout:HOST:PORT")
            group = group_of(rest) if scheme == "mcast" else None
            self._to = group[:2] if group else udp_place(rest)
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
        # Once the loopback is a member, listeners that joined on another interface hear it too.
        _join(self._socket, group)

    def send(self, data: bytes, t_us: int) -> None:  # noqa: ARG002
        """Send whole messages; they are lost if nobody listens, the network or the queue fails."""
        if data:
            with suppress(OSError):
                self._socket.send(data)

    def close(self) -> None:
        """Close the socket."""
        self._socket.close()
