# SPDX-License-Identifier: MIT
"""Whole MAVLink messages, version 2 and 1, out of whatever bytes come.

pymavlink's parser gives an object a message; this one gives the fields of those that are read
and checks the checksum of the others, in a tenth of the time. Tests hold it against pymavlink's.
"""

import re
from collections.abc import Iterator
from typing import Any, NamedTuple

from fastcrc import crc16

from sil.wire.mavlink_frames import HEADER, MAGIC_2, end_of
from sil.wire.mavlink_messages import LAYOUTS, SEEDS

_BEGIN = re.compile(rb"[\xfd\xfe]")


class Message(NamedTuple):
    """`fields` as `mavlink_messages.LAYOUTS` has them, empty where nobody reads them.

    None: of a message that is not known here, so that nobody checked it.
    """

    number: int
    system: int
    component: int
    fields: tuple[Any, ...] | None


class Ear:
    """What hears one sender of bytes, or many of datagrams.

    `stream`: a message may begin in one chunk and end in a later one; else a chunk is a datagram,
    in which they begin and end. Counted are `heard` bytes, and those of them that were `damaged`:
    no part of a whole valid message.
    """

    def __init__(self, *, stream: bool) -> None:
        self.heard = 0
        self.damaged = 0
        self._stream = stream
        self._rest = b""

    def hear(self, chunk: bytes) -> Iterator[Message]:
        """Yields the messages that end in this chunk, in order; all are to be taken."""
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
        """The bytes that come next follow others than those that came last."""
        self.damaged += len(self._rest)
        self._rest = b""


def _message(data: bytes, at: int, end: int) -> Message | None:
    """The message data[at:end], where its checksum and its length are right."""
    if data[at] == MAGIC_2:
        number = data[at + 7] | data[at + 8] << 8 | data[at + 9] << 16
        system, component, begin = data[at + 5], data[at + 6], at + 10
    else:
        system, component, number, begin = data[at + 3], data[at + 4], data[at + 5], at + 6
    stop = begin + data[at + 1]
    seed = SEEDS.get(number)
    if seed is None:
        # Nobody can check it; what follows has to be a beginning.
        follows = end == len(data) or data[end] in HEADER
        return Message(number, system, component, None) if follows else None
    crc: int = crc16.mcrf4xx(data[at + 1 : stop] + bytes((seed,)))
    if crc != data[stop] | data[stop + 1] << 8:
        return None
    layout = LAYOUTS.get(number)
    if layout is None:
        return Message(number, system, component, ())
    if stop - begin > layout.size:
        # A newer sender's extensions.
        return Message(number, system, component, layout.unpack_from(data, begin))
    payload = data[begin:stop].ljust(layout.size, b"\0")
    return Message(number, system, component, layout.unpack(payload))
