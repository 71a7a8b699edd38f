# SPDX-License-Identifier: MIT
"""Telemetry logs (tlog): each packet follows its time (u64 us since 1970, big endian)."""

from collections.abc import Iterable, Iterator
from heapq import merge
from operator import attrgetter
from pathlib import Path
from typing import NamedTuple

from sil.wire.mavlink_frames import HEADER, MAGIC_2, end_of

_TIME = 8
_LATEST_US = 4_102_444_800_000_000  # the year 2100; a later time stamp is invalid


class Packet(NamedTuple):
    """One packet with its time, UNIX us."""

    t_us: int
    system: int
    component: int
    message_id: int
    frame: bytes

    @property
    def size(self) -> int:
        """Bytes in the file."""
        return _TIME + len(self.frame)

    @property
    def payload(self) -> bytes:
        """The frame without header, checksum and signature."""
        begin = HEADER[self.frame[0]]
        return self.frame[begin : begin + self.frame[1]]


def of_links(tlogs: Iterable[Path]) -> Iterator[Packet]:
    """The packets of a boat's tlogs, one tlog for each link, in order of time."""
    return merge(*(packets(path.read_bytes(), []) for path in tlogs), key=attrgetter("t_us"))


def packets(content: bytes, damaged: list[int]) -> Iterator[Packet]:
    """The packets of a tlog; appends to `damaged` the length of each gap between them.

    A packet is recognised by its length, not its checksum, so unknown messages are kept too.
    """
    at, size, lost = 0, len(content), 0
    while at < size:
        end = _end(content, at)
        if end is None:
            at, lost = at + 1, lost + 1
            continue
        if lost:
            damaged.append(lost)
            lost = 0
        yield _packet(content, at, end)
        at = end
    if lost:
        damaged.append(lost)


def _end(content: bytes, at: int) -> int | None:
    """Index after the record at `at`; None if none begins there."""
    end = _whole(content, at)
    if end is None:
        return None
    # the next record, or a truncated one, begins there
    return end if len(content) - end <= _TIME or _begins(content, end) else None


def _begins(content: bytes, at: int) -> bool:
    begin = at + _TIME
    time_us = int.from_bytes(content[at:begin], "big")
    return begin < len(content) and content[begin] in HEADER and time_us < _LATEST_US


def _whole(content: bytes, at: int) -> int | None:
    begin = at + _TIME
    if not _begins(content, at):
        return None
    end = end_of(content, begin)
    return end if 0 < end <= len(content) else None


def _packet(content: bytes, at: int, end: int) -> Packet:
    frame = content[at + _TIME : end]
    t_us = int.from_bytes(content[at : at + _TIME], "big")
    if frame[0] == MAGIC_2:
        return Packet(t_us, frame[5], frame[6], int.from_bytes(frame[7:10], "little"), frame)
    return Packet(t_us, frame[3], frame[4], frame[5], frame)
