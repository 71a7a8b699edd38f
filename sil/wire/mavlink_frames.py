# SPDX-License-Identifier: MIT
"""Walks the MAVLink 2 frames of a chunk by their length bytes, without decoding them."""

from collections.abc import Iterator

_MAGIC = 0xFD
_HEADER, _CRC, _SIGNATURE = 10, 2, 13
_SIGNED = 1


def frames(data: bytes) -> Iterator[tuple[int, int, int, bytes]]:
    """Yields (message id, system id, component id, frame) in order, for whole frames only.

    CRCs are not checked: who decodes a frame does that. Where something else than a frame begins,
    the lengths that follow are not trusted to skip what they cover, and every 0xFD that may begin
    a frame is yielded: garbage hides no frame behind it. Source: MAVLink 2 packet format.
    """
    size = len(data)
    at = data.find(_MAGIC)
    clean = at == 0
    while 0 <= at <= size - _HEADER - _CRC:
        flags = data[at + 2]
        end = at + _HEADER + data[at + 1] + _CRC + (_SIGNATURE if flags & _SIGNED else 0)
        whole = end <= size and not flags & ~_SIGNED
        if whole:
            message_id = int.from_bytes(data[at + 7 : at + 10], "little")
            yield message_id, data[at + 5], data[at + 6], data[at:end]
        clean = clean and whole and (end == size or data[end] == _MAGIC)
        at = data.find(_MAGIC, end if clean else at + 1)
