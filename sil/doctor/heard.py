# SPDX-License-Identifier: MIT
"""MAVLink heard on one link while the doctor listens, and the latency of answers to TIMESYNC."""

import os
import select
import socket
import termios
import time
from collections import Counter, defaultdict
from collections.abc import Sequence
from pathlib import Path
from statistics import median
from typing import Any

from pymavlink.dialects.v20 import ardupilotmega as mavlink

from sil.doctor.boat_file import Link
from sil.wire import signing
from sil.wire.mavlink_mcast import udp_place
from sil.wire.serial_line import open_line

#: The doctor's ids on the radio: a ground station's system id, but it sends no station's heartbeat.
SYSTEM, COMPONENT = 255, mavlink.MAV_COMP_ID_ONBOARD_COMPUTER4
_ASK_S = 0.25
_MOST_BYTES = 65536
Sender = tuple[int, int]  # system id and component id


class Heard:
    """Senders by system and component: messages by name, latencies; bytes that are not MAVLink."""

    def __init__(self) -> None:
        self.counts: dict[Sender, Counter[str]] = defaultdict(Counter)
        self.unsigned: Counter[Sender] = Counter()
        self.round_trips_s: dict[Sender, list[float]] = defaultdict(list)
        self.last: dict[tuple[int, str], Any] = {}
        self.texts: list[str] = []
        self.bytes = 0
        self.damaged = 0
        self._parser = mavlink.MAVLink(None)
        self._parser.robust_parsing = True

    def hear(self, data: bytes, now_ns: int) -> None:
        """Process received bytes."""
        self.bytes += len(data)
        for message in self._parser.parse_buffer(data) or []:
            name = message.get_type()
            if name == "BAD_DATA":
                self.damaged += len(message.data)
                continue
            self._take(message, name, now_ns)

    def _take(self, message: Any, name: str, now_ns: int) -> None:
        sender = (message.get_srcSystem(), message.get_srcComponent())
        self.counts[sender][name] += 1
        self.unsigned[sender] += not message.get_signed() and name != "RADIO_STATUS"
        if name == "TIMESYNC" and message.tc1 != 0:
            took_s = 1e-9 * (now_ns - message.ts1)
            if 0.0 <= took_s < 10.0:  # an answer to the doctor, not to another station
                self.round_trips_s[sender].append(took_s)
        elif name == "NAMED_VALUE_FLOAT":
            self.last[sender[0], str(message.name)] = message.value
        elif name == "STATUSTEXT":
            self.texts.append(str(message.text))
        elif name == "HEARTBEAT":
            self.last[sender[0], name] = message

    def latency_s(self, sender: Sender) -> float | None:
        """Half of the median round-trip time; None without an answer."""
        trips = self.round_trips_s.get(sender)
        return median(trips) / 2 if trips else None


class Post:
    """An open link. OSError if it cannot be opened, ValueError if its address is invalid.

    `device`: path of a serial line on this computer. `ask`: send to the process that waits at a
    udpin address, like another program of this computer.
    """

    def __init__(self, link: Link, device: Path = Path(), *, ask: bool = False) -> None:
        self.link = link
        self.heard = Heard()
        self._socket: socket.socket | None = None
        self._peers: set[Any] = set()
        self._mouth = mavlink.MAVLink(None, srcSystem=SYSTEM, srcComponent=COMPONENT)
        if link.scheme == "serial":
            self._end = _open_line(device, link.rest.rpartition(":")[2])
            return
        at = udp_place(link.rest if ":" in link.rest else f"127.0.0.1:{link.rest}")
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        try:
            if link.scheme == "udpin" and not ask:
                self._socket.bind(at)
            else:
                self._peers.add(("127.0.0.1" if at[0] == "0.0.0.0" else at[0], at[1]))  # noqa: S104
        except OSError:
            self._socket.close()
            raise
        self._socket.setblocking(False)
        self._end = self._socket.fileno()

    def fileno(self) -> int:
        """The descriptor, for select."""
        return self._end

    def close(self) -> None:
        """Close the link, so that others can use it."""
        if self._socket is None:
            os.close(self._end)
        else:
            self._socket.close()

    def take(self) -> None:
        """Process everything received."""
        try:
            if self._socket is None:
                data = os.read(self._end, _MOST_BYTES)
            else:
                data, peer = self._socket.recvfrom(_MOST_BYTES)
                self._peers.add(peer)
        except OSError:  # no process listens there yet
            return
        self.heard.hear(data, time.monotonic_ns())

    def ask(self, key: bytes | None) -> None:
        """Send TIMESYNC and a heartbeat to all peers."""
        if key is not None:
            self._mouth.signing.secret_key = key
            self._mouth.signing.sign_outgoing = True
            self._mouth.signing.timestamp = signing.now()
        for message in (
            mavlink.MAVLink_heartbeat_message(
                mavlink.MAV_TYPE_ONBOARD_CONTROLLER, mavlink.MAV_AUTOPILOT_INVALID, 0, 0, 0, 3
            ),
            mavlink.MAVLink_timesync_message(0, time.monotonic_ns()),
        ):
            self._send(message.pack(self._mouth))

    def _send(self, data: bytes) -> None:
        try:
            if self._socket is None:
                os.write(self._end, data)
                return
            for peer in self._peers:
                self._socket.sendto(data, peer)
        except OSError:
            return  # the peer is gone; its silence is judged later


def listen(posts: Sequence[Post], seconds: float, key: bytes | None = None) -> None:
    """Listen to all links for `seconds`, and send time requests repeatedly."""
    end_s = time.monotonic() + seconds
    ask_s = 0.0
    while (now_s := time.monotonic()) < end_s:
        if now_s >= ask_s:
            ask_s = now_s + _ASK_S
            for post in posts:
                post.ask(key)
        ready, _, _ = select.select(posts, [], [], min(end_s, ask_s) - now_s)
        for post in ready:
            post.take()


def _open_line(device: Path, baud: str) -> int:
    """Open a serial line for reading and writing."""
    speed = getattr(termios, f"B{baud}", None)
    if speed is None:
        raise ValueError(f"{baud} is not a baud rate of a serial line")
    return open_line(device, speed, os.O_RDWR)
