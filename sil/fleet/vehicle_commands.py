# SPDX-License-Identifier: MIT
"""Translates a ground station's commands to one vehicle into wishes for a whole fleet."""

from math import isfinite

from pymavlink.dialects.v20 import ardupilotmega as mavlink

from sil.fleet.actions import Wish, is_on_globe
from sil.wire.heartbeat import AUTO, FORMATION, HOLD, LOITER, RTL

#: Commands that may be refused for their values; all others are unsupported.
KNOWN = (
    mavlink.MAV_CMD_COMPONENT_ARM_DISARM,
    mavlink.MAV_CMD_DO_SET_MODE,
    mavlink.MAV_CMD_DO_REPOSITION,
)

_CUSTOM = mavlink.MAV_MODE_FLAG_CUSTOM_MODE_ENABLED
_OF_MODE = {HOLD: "hold", FORMATION: "follow", AUTO: "auto", LOITER: "loiter", RTL: "return"}
_FORCED = 21196.0  # COMPONENT_ARM_DISARM, param2: without the checks
_MAVSDK_HOLD = 4.0, 3.0  # mode and sub mode
_CHANGES_MODE = float(mavlink.MAV_DO_REPOSITION_FLAGS_CHANGE_MODE)
_GLOBAL_FRAMES = (
    mavlink.MAV_FRAME_GLOBAL,
    mavlink.MAV_FRAME_GLOBAL_RELATIVE_ALT,
    mavlink.MAV_FRAME_GLOBAL_INT,
    mavlink.MAV_FRAME_GLOBAL_RELATIVE_ALT_INT,
)


def wish_of(message: mavlink.MAVLink_message) -> Wish | None:
    """Translate a COMMAND_LONG, COMMAND_INT or SET_MODE; None if it must be refused."""
    if message.get_type() == "SET_MODE":
        return _mode_wish(message.base_mode, message.custom_mode)
    number = message.command
    if number == mavlink.MAV_CMD_COMPONENT_ARM_DISARM:
        arms = {0.0: "stop", 1.0: "arm"}.get(message.param1)
        forced = arms == "arm" and message.param2 == _FORCED
        return None if arms is None or forced else Wish(arms)
    if number == mavlink.MAV_CMD_DO_SET_MODE:
        mode = message.param2, message.param3
        known = message.param3 == 0.0 or mode == _MAVSDK_HOLD
        # PX4's OFFBOARD has the same number; its request has other flags, or NaN behind it.
        rest = (message.param4, message.param5, message.param6, message.param7)
        plain = message.param1 == _CUSTOM and not any(rest)
        known = known and (plain or message.param2 != FORMATION)
        return _mode_wish(message.param1, message.param2) if known else None
    if number == mavlink.MAV_CMD_NAV_RETURN_TO_LAUNCH:
        return Wish("return")
    return _go_wish(message) if number == mavlink.MAV_CMD_DO_REPOSITION else None


def _mode_wish(base: float, custom: float) -> Wish | None:
    is_custom = isfinite(base) and int(base) & _CUSTOM
    action = _OF_MODE.get(int(custom)) if isfinite(custom) and custom == int(custom) else None
    return Wish(action) if is_custom and action else None


def _go_wish(message: mavlink.MAVLink_message) -> Wish | None:
    if message.param1 > 0.0:  # a speed, which the fleet would not keep to
        return None
    if message.param2 != _CHANGES_MODE:  # moves only the target of a boat in GUIDED
        return None
    if message.get_type() == "COMMAND_LONG":
        place = message.param5, message.param6
    elif message.frame in _GLOBAL_FRAMES:
        place = 1e-7 * message.x, 1e-7 * message.y
    else:
        return None
    return Wish("go", place=place) if is_on_globe(*place) else None
