# SPDX-License-Identifier: MIT
"""CAN over UDP multicast for python-can: the interface `mcast`; DroneCAN specification 4.2.

A packet is little endian: u16 magic 0x2934, u16 CRC-16-CCITT-FALSE of all that follows, u16 flags
(bit 0: CAN FD), u32 identifier with bit 31 for an extended one, data. Bus N is 239.65.82.N, port
57732. There is no arbitration and no back-pressure: a slow receiver's kernel drops frames silently.
"""

import ipaddress
import re
import select
import socket
import struct
import time
from binascii import crc_hqx
from collections import Counter

import can
from can.typechecking import CanFilters

PORT = 57732
LOOPBACK = "127.0.0.1"

_MAGIC = 0x2934
_EXTENDED = 1 << 31
_FD = 1
_HEADER = struct.Struct("<HHHI")
_BODY = struct.Struct("<HI")
_MAX_PACKET = 128


def pack(message: can.Message) -> bytes:
    """The packet of a frame; CanOperationError unless it is a classic CAN data frame."""
    if message.is_fd or message.is_remote_frame or message.is_error_frame or message.dlc > 8:
        raise can.CanOperationError(f"mcast carries classic data frames only, not {message}")
    can_id = message.arbitration_id | (_EXTENDED if message.is_extended_id else 0)
    body = _BODY.pack(0, can_id) + bytes(message.data)
    return struct.pack("<HH", _MAGIC, crc_hqx(body, 0xFFFF)) + body


def unpack(packet: bytes, timestamp_s: float) -> can.Message | str:
    """The frame in a packet, or why it is rejected: `malformed`, `crc`, `fd`."""
    if len(packet) < _HEADER.size:
        return "malformed"
    magic, crc, flags, can_id = _HEADER.unpack_from(packet)
    if magic != _MAGIC:
        return "malformed"
    if crc_hqx(packet[4:], 0xFFFF) != crc:
        return "crc"
    if flags & _FD:
        return "fd"
    extended = bool(can_id & _EXTENDED)
    can_id &= ~_EXTENDED
    data = packet[_HEADER.size :]
    if len(data) > 8 or can_id >> (29 if extended else 11):
        return "malformed"
    return can.Message(
        timestamp=timestamp_s, arbitration_id=can_id, is_extended_id=extended, data=data
    )


class McastBus(can.BusABC):
    """Bus "N" on 127.0.0.1, or "N:ADDRESS" on the interface that has the address.

    Without an address no packet leaves the machine: simulated throttle must not reach a real boat.
    Own frames are not received. `counters` counts rejected packets by reason.
    CanInitializationError: the channel is invalid or the network refuses.
    """

    def __init__(
        self,
        channel: str | int = "0",
        can_filters: CanFilters | None = None,
        **_: object,  # options of other backends, such as a bit rate
    ) -> None:
        # Set before anything can fail: shutdown() and the base's __del__ read them.
        self.counters: Counter[str] = Counter()
        self._sender = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._receiver = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._channel = str(channel)
        self.channel_info = f"mcast:{channel}"
        try:
            number, address = _parse(self._channel)
            self._group = f"239.65.82.{number}", PORT
            self._connect(address or LOOPBACK, hops=1 if address else 0)
        except (OSError, ValueError) as error:
            self.shutdown()
            raise can.CanInitializationError(f"{self.channel_info}: {error}") from error
        super().__init__(channel=channel, can_filters=can_filters)

    def _connect(self, address: str, hops: int) -> None:
        """Open the sockets that send and receive on the interface of `address`."""
        interface = socket.inet_aton(address)
        self._sender.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_IF, interface)
        self._sender.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_TTL, hops)
        self._sender.bind((address, 0))
        self._own = self._sender.getsockname()
        self._receiver.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        self._receiver.bind(self._group)
        membership = socket.inet_aton(self._group[0]) + interface
        self._receiver.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, membership)
        self._receiver.setblocking(False)

    def send(self, msg: can.Message, timeout: float | None = None) -> None:  # noqa: ARG002
        """Send a frame at once; CanOperationError when the network refuses it."""
        packet = pack(msg)
        try:
            self._sender.sendto(packet, self._group)
        except OSError as error:
            raise can.CanOperationError(f"{self.channel_info}: {error}") from error

    def _recv_internal(self, timeout: float | None) -> tuple[can.Message | None, bool]:
        """The next frame within `timeout` seconds, and that it is not filtered."""
        deadline_s = None if timeout is None else time.monotonic() + timeout
        while True:
            left_s = None if deadline_s is None else max(0.0, deadline_s - time.monotonic())
            if not select.select([self._receiver], [], [], left_s)[0]:
                return None, False
            try:
                packet, source = self._receiver.recvfrom(_MAX_PACKET)
            except BlockingIOError:  # its UDP checksum was wrong
                continue
            if source == self._own:
                continue
            frame = unpack(packet, time.time())
            if isinstance(frame, can.Message):
                frame.channel = self._channel
                return frame, False
            self.counters[frame] += 1

    def flush_tx_buffer(self) -> None:
        """Do nothing: send() has no buffer. PyPI dronecan calls this after each frame."""

    def fileno(self) -> int:
        """Descriptor that is readable when a packet waits; -1 after shutdown."""
        return self._receiver.fileno()

    def shutdown(self) -> None:
        """Close the sockets; may be called again."""
        super().shutdown()
        self._sender.close()
        self._receiver.close()


def _parse(channel: str) -> tuple[int, str]:
    """Parse bus number and address (empty if absent); ValueError if invalid."""
    match = re.fullmatch(r"(\d{1,3})(?::(.+))?", channel)
    if not match or int(match[1]) > 255:
        raise ValueError("the channel must be N or N:ADDRESS, N from 0 to 255")
    return int(match[1]), str(ipaddress.IPv4Address(match[2])) if match[2] else ""
