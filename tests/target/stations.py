# SPDX-License-Identifier: MIT
"""MAVLink senders around a boat, by pymavlink: they share no mistake with our codec."""

from __future__ import annotations

import functools
import math
import struct
from collections.abc import Iterable
from typing import Any

from pymavlink.dialects.v10 import common as mavlink1
from pymavlink.dialects.v20 import common as mavlink

from tests.dialect import dialect
from tests.target.course import Course, quaternion

BOAT, LEADER, GCS, STRANGER = 2, 1, 255, 77
NAVIGATION, LEADER_COMPONENT, GCS_COMPONENT = 197, 1, 190
#: MAV_CMD.
SET_MODE, TERMINATE, REPOSITION, PAUSE, FENCE_ENABLE, MOTOR_TEST = 176, 185, 192, 193, 207, 209
STORAGE, STANDARD_MODE, ARM, GET_INTERVAL, SET_INTERVAL = 245, 262, 400, 510, 511
REQUEST_MESSAGE = 512
FORCE = 21196  # the number that arms by force
#: MAV_RESULT.
ACCEPTED, TEMPORARILY_REJECTED, DENIED, UNSUPPORTED = 0, 1, 2, 3
#: Modes, as a heartbeat's custom_mode.
MANUAL, HOLD, LOITER, FORMATION, AUTO, RTL, GUIDED = 0, 4, 5, 6, 10, 11, 15
ARMED_BIT = 128
ORIGIN = (473977420, 85455940, 488000)
UNKNOWN_COVARIANCE = [math.nan] + [0.0] * 20


class Station:
    """One system and component with pymavlink's own encoder and sequence numbers."""

    def __init__(self, system: int, component: int = 1) -> None:
        self.system, self.component = system, component
        self.encoder = mavlink.MAVLink(None, system, component)

    def pack(self, *messages: Any, version1: bool = False) -> bytes:
        wire = b""
        for message in messages:
            if version1:  # the v2 dialect would put extensions into v1 frames
                kind = getattr(mavlink1, type(message).__name__)
                packed = kind(*[getattr(message, name) for name in kind.fieldnames])
            else:
                packed = message
            wire += bytes(packed.pack(self.encoder))
            self.encoder.seq = (self.encoder.seq + 1) % 256
        return wire


def odometry(truth: Course, time_us: int, **changes: Any) -> Any:
    """ODOMETRY of a level boat: LOCAL_NED, velocity in BODY_FRD; `changes` override fields."""
    fields: dict[str, Any] = {
        "time_usec": time_us,
        "frame_id": 1,
        "child_frame_id": 12,
        "x": truth.north,
        "y": truth.east,
        "z": 0.0,
        "q": quaternion(0.0, 0.0, truth.psi),
        "vx": truth.u,
        "vy": truth.v,
        "vz": 0.0,
        "rollspeed": 0.0,
        "pitchspeed": 0.0,
        "yawspeed": truth.r,
        "pose_covariance": UNKNOWN_COVARIANCE,
        "velocity_covariance": UNKNOWN_COVARIANCE,
        "reset_counter": 0,
        "estimator_type": 8,
        "quality": 0,
    }
    return mavlink.MAVLink_odometry_message(**(fields | changes))


def local_position(truth: Course, time_us: int, **changes: Any) -> Any:
    north, east = truth.velocity_n
    fields = {
        "time_boot_ms": time_us // 1000 % 2**32,
        "x": truth.north,
        "y": truth.east,
        "z": 0.0,
        "vx": north,
        "vy": east,
        "vz": 0.0,
    }
    return mavlink.MAVLink_local_position_ned_message(**(fields | changes))


def attitude(truth: Course, time_us: int, **changes: Any) -> Any:
    fields = {
        "time_boot_ms": time_us // 1000 % 2**32,
        "roll": 0.0,
        "pitch": 0.0,
        "yaw": truth.psi,
        "rollspeed": 0.0,
        "pitchspeed": 0.0,
        "yawspeed": truth.r,
    }
    return mavlink.MAVLink_attitude_message(**(fields | changes))


def state_messages(kind: str, truth: Course, now_us: int, **changes: Any) -> list[Any]:
    """A whole state in messages of that kind; `changes` apply to the kind's own message."""
    if kind == "ODOMETRY":
        q = quaternion(0.0, 0.0, truth.psi)
        for k in range(4):
            q[k] = changes.pop(f"q{k}", q[k])
        return [odometry(truth, now_us, **({"q": q} | changes))]
    changed = {"LOCAL_POSITION_NED": {}, "ATTITUDE": {}, kind: changes}
    return [
        local_position(truth, now_us, **changed["LOCAL_POSITION_NED"]),
        attitude(truth, now_us, **changed["ATTITUDE"]),
    ]


def origin(
    time_us: int = 0,
    latitude: int = ORIGIN[0],
    longitude: int = ORIGIN[1],
    altitude: int = ORIGIN[2],
) -> Any:
    return mavlink.MAVLink_gps_global_origin_message(latitude, longitude, altitude, time_us)


def gps(fix_type: int = 3, hdop: float = 1.0) -> Any:
    return mavlink.MAVLink_gps_raw_int_message(
        0, fix_type, ORIGIN[0], ORIGIN[1], 0, round(100 * hdop), 65535, 0, 0, 9
    )


def heartbeat(kind: int = mavlink.MAV_TYPE_SURFACE_BOAT) -> Any:
    return mavlink.MAVLink_heartbeat_message(kind, 0, 0, 0, 4, 3)


def command_long(
    command: int, *params: float, target: tuple[int, int] = (BOAT, 1), confirmation: int = 0
) -> Any:
    """COMMAND_LONG; unused parameters are NaN as MAVSDK's, of a mode 0 as Rover clients'."""
    unused = 0.0 if command == SET_MODE else math.nan
    filled = [*params, *[unused] * (7 - len(params))]
    return mavlink.MAVLink_command_long_message(*target, command, confirmation, *filled)


def decode(chunks: Iterable[bytes]) -> list[Any]:
    """All messages in the chunks; damaged frames appear as BAD_DATA.

    By our own dialect: the wheel's lacks ESC_STATUS, CURRENT_MODE and others.
    """
    parser = dialect().MAVLink(None)
    parser.robust_parsing = True
    return [message for chunk in chunks for message in parser.parse_buffer(chunk) or []]


def decode_named(chunks: Iterable[bytes], name: str) -> list[Any]:
    """The messages of one name; skips chunks that are whole frames of others."""
    number = _numbers()[name]
    some = [chunk for chunk in chunks if _may_have(chunk, number)]
    if not some:
        return []
    return [message for message in decode(some) if message.get_type() == name]


def float32(value: float) -> float:
    """The nearest number of 32 bits, as messages carry it."""
    return float(struct.unpack("<f", struct.pack("<f", value))[0])


def kind_of(message_id: int) -> str:
    """The message's name in our dialect."""
    return str(dialect().mavlink_map[message_id].msgname)


@functools.cache
def _numbers() -> dict[str, int]:
    return {kind.msgname: number for number, kind in dialect().mavlink_map.items()}


def _may_have(chunk: bytes, number: int) -> bool:
    at = 0
    while len(chunk) >= at + 12 and chunk[at] == 0xFD:
        if int.from_bytes(chunk[at + 7 : at + 10], "little") == number:
            return True
        at += 12 + chunk[at + 1] + 13 * (chunk[at + 2] & 1)  # with its signature
    return at != len(chunk)
