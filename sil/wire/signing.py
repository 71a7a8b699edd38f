# SPDX-License-Identifier: MIT
"""Makes and checks signatures of MAVLink 2 frames.

    signature = first 48 bits of SHA-256(key ‖ header ‖ payload ‖ checksum ‖ link ‖ time)

The time counts 10 µs since 2015-01-01. Source: mavlink.io, message signing.
"""

import hashlib
import os
import stat
import struct
import time
from pathlib import Path

from fastcrc import crc16

from sil.wire.mavlink_frames import HEADER, MAGIC_2
from sil.wire.mavlink_messages import SEEDS

KEY_BYTES = 32
_EPOCH_S, _PER_S = 1_420_070_400, 100_000
_SIGNED, _BLOCK, _SIGNATURE = 1, 13, 6
_LATE = 60 * _PER_S
_OTHERS = stat.S_IRWXG | stat.S_IRWXO


def read_key(path: Path) -> bytes:
    """Read a key as flotillad does: 32 bytes or 64 hexadecimal digits.

    OSError if it cannot be read; ValueError if it is not a key, or if others may use it.
    """
    with path.open("rb") as file:
        mode = stat.S_IMODE(os.fstat(file.fileno()).st_mode)
        content = file.read(2 * KEY_BYTES + 2)
    if mode & _OTHERS:
        raise ValueError(f"{path}: mode {mode:04o} lets others use the key: chmod 600 {path}")
    if len(content) == KEY_BYTES:
        return content
    try:
        key = bytes.fromhex(content.decode("ascii"))
    except ValueError:
        key = b""
    if len(key) != KEY_BYTES:
        raise ValueError(f"{path}: a key is 32 bytes, or 64 hexadecimal digits")
    return key


def is_signed(frame: bytes) -> bool:
    """Whether a whole frame has a signature, valid or not."""
    return frame[0] == MAGIC_2 and bool(frame[2] & _SIGNED)


def numbered(frame: bytes, sequence: int) -> bytes:
    """An unsigned MAVLink 2 frame with another sequence number."""
    return _checked(frame[1:4] + bytes([sequence]) + frame[5:-2])


class Signer:
    """The holder of a key. `link`: distinguishes this sender from others with the same ids."""

    def __init__(self, key: bytes, link: int) -> None:
        self._key, self._link = key, link
        self._last = 0
        self._heard: dict[bytes, int] = {}  # time of the last valid frame, by ids and link

    def sign(self, frame: bytes) -> bytes:
        """An unsigned MAVLink 2 frame with its signature."""
        self._last = max(self._last + 1, now())
        body = bytes([frame[1], _SIGNED]) + frame[3:-2]
        block = bytes([self._link]) + self._last.to_bytes(6, "little")
        whole = _checked(body) + block
        return whole + self._signature(whole)

    def verifies(self, frame: bytes) -> bool:
        """Whether a whole frame is signed with the key, is new, and is less than a minute old."""
        at, sender = self._stamp(frame), frame[5:7] + frame[-_BLOCK : 1 - _BLOCK]
        if at is None or at <= self._heard.get(sender, now() - _LATE):
            return False
        self._heard[sender] = at
        return True

    def late_s(self, frame: bytes) -> float | None:
        """Age of a frame that is signed with the key and at least a minute old, s; else None."""
        at = self._stamp(frame)
        late = 0 if at is None else now() - at
        return late / _PER_S if late >= _LATE else None

    def _stamp(self, frame: bytes) -> int | None:
        """The time of a whole frame that is signed with the key; None if it is not."""
        whole, signature = frame[:-_SIGNATURE], frame[-_SIGNATURE:]
        if not is_signed(frame) or signature != self._signature(whole):
            return None
        return int.from_bytes(whole[-6:], "little")

    def _signature(self, whole: bytes) -> bytes:
        return hashlib.sha256(self._key + whole).digest()[:_SIGNATURE]


def _checked(body: bytes) -> bytes:
    """Make a frame from its header (without the magic byte) and its payload, with a checksum."""
    number = int.from_bytes(body[6 : HEADER[MAGIC_2] - 1], "little")
    checksum = crc16.mcrf4xx(body + bytes([SEEDS[number]]))
    return bytes([MAGIC_2]) + body + struct.pack("<H", checksum)


def now() -> int:
    """The current time as signatures have it: in 10 us since 2015 (UTC)."""
    return round((time.time() - _EPOCH_S) * _PER_S)
