# SPDX-License-Identifier: MIT
"""One boat of a recording as the stream that `flotilla_player` reads: firmware/cortex_m.

The recorded answers are not in it, but their digest is what the player has to print.
"""

import hashlib
import struct
from collections.abc import Iterator

import flotilla

from sil.lockstep.recording import BUS, CAN_OUT, CLOCK, HOST, MAVLINK_OUT, Recording
from sil.wire.clock import Clock

_HEAD = struct.Struct("<QHH")
_HOST_EVENT = struct.Struct("<Bq")
_BUS, _TICK, _BOAT = 32, 33, 34


def _record(t_us: int, port: int, data: bytes) -> bytes:
    return _HEAD.pack(max(t_us, 0), port, len(data)) + data


def _of_boat(recording: Recording, boat: int) -> Iterator[tuple[int, int, bytes]]:
    """What one boat (0 …) heard and said: its own time in us, channel, bytes."""
    clock = Clock(**recording.header["boats"][boat]["clock"])
    for t_us, port, data in recording:
        if (port >> 8) - 1 != boat:
            continue
        channel = port & 0xFF
        if channel == HOST:
            event, value = _HOST_EVENT.unpack(data)
            if event == CLOCK:
                clock = Clock(value, clock.drift_ppm)
                continue
            if event != BUS:
                raise ValueError("the recorded boat was started again")
            yield clock.at(t_us), channel, bytes([bool(value)])
        else:
            yield clock.at(t_us), channel, data


def stream_of(recording: Recording, boat: int, seconds: float) -> tuple[bytes, str]:
    """The stream, and the SHA-256 in hexadecimal of what the boat said, of the first `seconds`.

    ValueError where the player cannot play it.
    """
    header = recording.header["boats"][boat]
    values = flotilla.Boat(header["parameters"], header["links"], header["scalar"]).parameters()
    setup = struct.pack(f"<I{len(values)}f", header["links"], *values.values())
    stream, said = bytearray(_record(0, _BOAT, setup)), hashlib.sha256()
    first_us, answered_us = None, None
    for t_us, channel, data in _of_boat(recording, boat):
        first_us = t_us if first_us is None else first_us
        answers = MAVLINK_OUT <= channel <= CAN_OUT
        if t_us - first_us > seconds * 1e6 and not (answers and t_us == answered_us):
            break
        if not answers:
            answered_us = None
            stream += _record(t_us, _BUS if channel == HOST else channel, data)
            continue
        if t_us != answered_us:  # a boat has something to say in every tick
            stream += _record(t_us, _TICK, b"")
        answered_us = t_us
        said.update(_record(t_us, channel, data))
    return bytes(stream), said.hexdigest()
