# SPDX-License-Identifier: MIT
"""Decodes ESC_INFO and ESC_STATUS (MAVLink 2), which pymavlink's wheel lacks."""

from math import nan
from typing import Any

from sil.wire.mavlink_ear import Ear
from sil.wire.mavlink_messages import ESC_INFO

_GROUP = 4
_UNKNOWN_TEMPERATURE = 32767

#: By ESC index: fields of `sil.logs.schema.ESC`.
Escs = dict[int, dict[str, float]]


def decode(message_id: int, frame: bytes) -> Escs:
    """The ESCs of a whole frame, in ESC_INFO those online; ValueError for a wrong checksum."""
    heard = list(Ear(stream=False).hear(frame))
    if len(heard) != 1 or not heard[0].fields:
        raise ValueError(f"message {message_id} with a wrong checksum")
    values = heard[0].fields
    return _info(values) if message_id == ESC_INFO else _status(values)


def _status(values: tuple[Any, ...]) -> Escs:
    rpm, voltage, current = values[1:5], values[5:9], values[9:13]
    return {
        int(values[13]) + i: {"rpm": rpm[i], "voltage_V": voltage[i], "current_A": current[i]}
        for i in range(_GROUP)
    }


def _info(values: tuple[Any, ...]) -> Escs:
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
