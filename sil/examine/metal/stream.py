# SPDX-License-Identifier: MIT
"""Converts one boat of a recording to the input of `flotilla_player` (firmware/cortex_m).

It omits the recorded output; the player must print that output's digest.
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
    """Input and output of one boat (0 …): its own time in us, channel, bytes."""
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
                raise ValueError("the recorded boat was restarted; the player cannot replay that")
            yield clock.at(t_us), channel, bytes([bool(value)])
        else:
            yield clock.at(t_us), channel, data


def stream_of(recording: Recording, boat: int, seconds: float) -> tuple[bytes, str]:
    """The stream of the first `seconds`, and the SHA-256 (hexadecimal) of the boat's output.

    ValueError if the player cannot play it.
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
        if t_us != answered_us:  # a boat has output in every tick
            stream += _record(t_us, _TICK, b"")
        answered_us = t_us
        said.update(_record(t_us, channel, data))
    return bytes(stream), said.hexdigest()
