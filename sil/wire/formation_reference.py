# SPDX-License-Identifier: MIT
"""The motion of a formation's root, as a boat sends it: FORMATION_REFERENCE.

Source: firmware/link/mavlink/flotilla.xml; on the wire, fields are sorted by size, the widest
first.
"""

import struct
from collections.abc import Iterator
from typing import NamedTuple

from sil.wire.geodesy import LocalFrame
from sil.wire.mavlink_frames import HEADER, MAGIC_2, frames
from sil.wire.mavlink_messages import FORMATION_REFERENCE

# time; origin, place, offset; age, sequence; heading u v r and their rates; root, maker, flags
_LAYOUT = struct.Struct("<I6i2H8h3B")
_NUMBER = FORMATION_REFERENCE.to_bytes(3, "little")
_STEP = 1.0 / 1024.0


class Told(NamedTuple):
    """Place in the receiver's frame (m), surge (m/s), and the age of both (us)."""

    north_m: float
    east_m: float
    u_mps: float
    age_us: int


class Ear:
    """Receives the motion of the root from the boat that makes it, with system id `system`.

    References that the boat only passes on are ignored. `frame`: frame of the places returned.
    """

    def __init__(self, system: int, frame: LocalFrame, height_m: float) -> None:
        self._system = system
        self._frame, self._height_m = frame, height_m
        self._plane = frame

    def hear(self, data: bytes) -> Iterator[Told]:
        """Read whole frames."""
        if _NUMBER not in data:
            return
        for message_id, system, _, frame in frames(data):
            if message_id != FORMATION_REFERENCE or system != self._system:
                continue
            size = frame[1]
            payload = frame[HEADER[MAGIC_2] : HEADER[MAGIC_2] + size].ljust(_LAYOUT.size, b"\0")
            _, latitude, longitude, north, east, *rest = _LAYOUT.unpack_from(payload)
            age_ms, u, root, maker = rest[2], rest[5], rest[12], rest[13]
            if root != self._system or maker != self._system:
                continue
            place = (_STEP * north, _STEP * east)
            yield Told(*self._seen(latitude, longitude, *place), _STEP * u, 1000 * age_ms)

    def _seen(
        self, latitude: int, longitude: int, north_m: float, east_m: float
    ) -> tuple[float, float]:
        if (latitude, longitude) == self._frame.origin_degE7:
            return north_m, east_m
        if (latitude, longitude) != self._plane.origin_degE7:
            self._plane = LocalFrame(latitude, longitude, self._height_m)
        return self._plane.seen_from(self._frame, north_m, east_m, 0.0)[:2]
