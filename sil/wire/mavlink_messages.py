# SPDX-License-Identifier: MIT
"""The MAVLink messages that views, logs and stations read: numbers and wire layouts.

Layouts and checksum seeds are pymavlink's, except for messages that its wheel lacks.
Source: mavlink.io, common message set.
"""

from struct import Struct

from pymavlink.dialects.v20 import ardupilotmega as mavlink

HEARTBEAT, SYS_STATUS, PARAM_VALUE, ATTITUDE = 0, 1, 22, 30
LOCAL_POSITION_NED, GLOBAL_POSITION_INT, GPS_GLOBAL_ORIGIN = 32, 33, 49
POSITION_TARGET_LOCAL_NED, FOLLOW_TARGET, NAMED_VALUE_FLOAT, STATUSTEXT = 85, 144, 251, 253
MISSION_CURRENT, MISSION_COUNT, MISSION_CLEAR_ALL = 42, 44, 45
MISSION_ACK, MISSION_ITEM_INT, COMMAND_ACK = 47, 73, 77
ESC_INFO, ESC_STATUS, ODOMETRY = 290, 291, 331
FORMATION_REFERENCE, FORMATION_FUTURE = 53100, 53101
FLEET_BEACON, FLEET_TABLE = 53102, 53103

SEEDS: dict[int, int] = {
    **{number: kind.crc_extra for number, kind in mavlink.mavlink_map.items()},
    ESC_INFO: 251,
    ESC_STATUS: 10,
    FORMATION_REFERENCE: 131,
    FORMATION_FUTURE: 89,
    FLEET_BEACON: 241,
    FLEET_TABLE: 200,
}
"""Checksum seed (CRC_EXTRA) of every known message, by its number."""

_READ = (
    HEARTBEAT,
    SYS_STATUS,
    PARAM_VALUE,
    ATTITUDE,
    LOCAL_POSITION_NED,
    GLOBAL_POSITION_INT,
    GPS_GLOBAL_ORIGIN,
    POSITION_TARGET_LOCAL_NED,
    FOLLOW_TARGET,
    NAMED_VALUE_FLOAT,
    STATUSTEXT,
    ODOMETRY,
    MISSION_CURRENT,
    MISSION_COUNT,
    MISSION_CLEAR_ALL,
    MISSION_ACK,
    MISSION_ITEM_INT,
    COMMAND_ACK,
)

LAYOUTS: dict[int, Struct] = {
    **{number: mavlink.mavlink_map[number].unpacker for number in _READ},
    ESC_INFO: Struct("<Q4IH4H4hBBBB"),
    ESC_STATUS: Struct("<Q4i4f4fB"),
    FLEET_BEACON: Struct("<IHHHBBB"),
    FLEET_TABLE: Struct("<HHHHBB192B"),
}
"""Fields of messages that are read, in the order of the wire: the widest first, extensions last."""
