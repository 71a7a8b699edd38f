# SPDX-License-Identifier: MIT
"""Parses MAVLink messages, versions 2 and 1, from arbitrary bytes.

Ten times as fast as pymavlink's parser, which makes an object per message: this one unpacks the
fields only of messages that views and logs read. It checks the checksum of every known message.
Tests compare it with pymavlink's.
"""

import re
from collections.abc import Iterator
from typing import Any, NamedTuple

from fastcrc import crc16

from sil.wire.mavlink_frames import HEADER, MAGIC_2, end_of
from sil.wire.mavlink_messages import LAYOUTS, SEEDS

_BEGIN = re.compile(rb"[\xfd\xfe]")


class Message(NamedTuple):
    """`fields` in the order of `mavlink_messages.LAYOUTS`; empty if a message is not read here.

    None for an unknown message, whose checksum cannot be verified.
    """

    number: int
    system: int
    component: int
    fields: tuple[Any, ...] | None


class Ear:
    """A parser for one byte stream, or for datagrams of any number of senders.

    `stream`: a message may span chunks; otherwise each chunk is a datagram of whole messages.
    Counts bytes: `heard` are all, `damaged` those that are not part of a valid message.
    """

    def __init__(self, *, stream: bool) -> None:
        self.heard = 0
        self.damaged = 0
        self._stream = stream
        self._rest = b""

    def hear(self, chunk: bytes) -> Iterator[Message]:
        """Yield the messages that end in this chunk, in order; exhaust the iterator."""
        self.heard += len(chunk)
        data, self._rest = self._rest + chunk, b""
        at, size = 0, len(data)
        while at < size:
            end = end_of(data, at)
            if end > size:
                if self._stream:
                    self._rest = data[at:]
                    return
                end = 0
            message = _message(data, at, end) if end else None
            if message is not None:
                yield message
                at = end
                continue
            begin = _BEGIN.search(data, at + 1)
            next_at = begin.start() if begin else size
            self.damaged += next_at - at
            at = next_at

    def forget(self) -> None:
        """Drop an incomplete message: the next chunk begins a new stream."""
        self.damaged += len(self._rest)
        self._rest = b""


def _message(data: bytes, at: int, end: int) -> Message | None:
    """The message data[at:end]; None if its checksum is wrong."""
    if data[at] == MAGIC_2:
        number = data[at + 7] | data[at + 8] << 8 | data[at + 9] << 16
        system, component, begin = data[at + 5], data[at + 6], at + 10
    else:
        system, component, number, begin = data[at + 3], data[at + 4], data[at + 5], at + 6
    stop = begin + data[at + 1]
    seed = SEEDS.get(number)
    if seed is None:
        # Its checksum cannot be verified: accept it only if a frame or nothing follows.
        follows = end == len(data) or data[end] in HEADER
        return Message(number, system, component, None) if follows else None
    crc: int = crc16.mcrf4xx(data[at + 1 : stop] + bytes((seed,)))
    if crc != data[stop] | data[stop + 1] << 8:
        return None
    layout = LAYOUTS.get(number)
    if layout is None:
        return Message(number, system, component, ())
    if stop - begin > layout.size:
        # Extension fields of a newer sender.
        return Message(number, system, component, layout.unpack_from(data, begin))
    payload = data[begin:stop].ljust(layout.size, b"\0")
    return Message(number, system, component, layout.unpack(payload))
