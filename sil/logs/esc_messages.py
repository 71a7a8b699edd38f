# SPDX-License-Identifier: MIT
"""ESC_INFO and ESC_STATUS, which pymavlink's wheel does not know: frames of MAVLink 2.

Source: mavlink.io, common message set; fields on the wire are ordered by their size.
"""

from math import nan
from struct import Struct

from pymavlink.mavutil import x25crc  # type: ignore[import-untyped]

ESC_INFO, ESC_STATUS = 290, 291

_CRC_EXTRA = {ESC_INFO: 251, ESC_STATUS: 10}
_INFO, _STATUS = Struct("<Q4IH4H4h4B"), Struct("<Q4i4f4fB")
_GROUP = 4
_UNKNOWN_TEMPERATURE = 32767

#: Of each ESC's index, fields of `sil.logs.schema.ESC`.
Escs = dict[int, dict[str, float]]


def decode(message_id: int, frame: bytes) -> Escs:
    """The ESCs of a whole frame; of ESC_INFO those that are there. ValueError for a wrong CRC."""
    end = 10 + frame[1]
    crc = x25crc(frame[1:end])
    crc.accumulate(bytes([_CRC_EXTRA[message_id]]))
    if crc.crc != int.from_bytes(frame[end : end + 2], "little"):
        raise ValueError(f"message {message_id} with a wrong checksum")
    layout = _INFO if message_id == ESC_INFO else _STATUS
    # zeros at the end are not sent
    values = layout.unpack(frame[10:end][: layout.size].ljust(layout.size, b"\0"))
    return _info(values) if message_id == ESC_INFO else _status(values)


def _status(values: tuple[float, ...]) -> Escs:
    rpm, voltage, current = values[1:5], values[5:9], values[9:13]
    return {
        int(values[13]) + i: {"rpm": rpm[i], "voltage_V": voltage[i], "current_A": current[i]}
        for i in range(_GROUP)
    }


def _info(values: tuple[float, ...]) -> Escs:
    errors, temperature, online = values[1:5], values[10:14], int(values[17])
    return {
        int(values[14]) + i: {
            "errors": errors[i],
            "temperature_degC": nan
            if temperature[i] == _UNKNOWN_TEMPERATURE
            else 0.01 * temperature[i],
        }
        for i in range(_GROUP)
        if online >> i & 1
    }
