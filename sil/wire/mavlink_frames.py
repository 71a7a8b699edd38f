# SPDX-License-Identifier: MIT
"""Finds MAVLink frames by their length bytes, without decoding them.

Source: mavlink.io, packet serialization.
"""

from collections.abc import Iterator

MAGIC_2, MAGIC_1 = 0xFD, 0xFE
HEADER = {MAGIC_2: 10, MAGIC_1: 6}
_CRC, _SIGNATURE = 2, 13
_SIGNED = 1


def end_of(data: bytes, at: int) -> int:
    """Index after the frame that may begin at `at`; 0 if none begins there.

    If the frame's header is cut off, this is the least possible index.
    """
    header = HEADER.get(data[at])
    if header is None:
        return 0
    if at + header > len(data):
        return at + header + _CRC
    flags = data[at + 2] if data[at] == MAGIC_2 else 0
    if flags & ~_SIGNED:
        return 0
    return at + header + data[at + 1] + _CRC + (_SIGNATURE if flags else 0)


def frames(data: bytes) -> Iterator[tuple[int, int, int, bytes]]:
    """Yield (message id, system id, component id, frame) of whole MAVLink 2 frames, in order.

    CRCs are left to the decoder. After the first byte that is not part of a frame, length bytes are
    no longer trusted: every 0xFD that may begin a frame yields one, so garbage cannot hide a frame.
    """
    at = data.find(MAGIC_2)
    clean = at == 0
    while at >= 0:
        end = end_of(data, at)
        whole = 0 < end <= len(data)
        if whole:
            message_id = int.from_bytes(data[at + 7 : at + 10], "little")
            yield message_id, data[at + 5], data[at + 6], data[at:end]
        clean = clean and whole and (end == len(data) or data[end] == MAGIC_2)
        at = data.find(MAGIC_2, end if clean else at + 1)
