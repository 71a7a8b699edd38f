# SPDX-License-Identifier: MIT
"""A ground station's half of the mission protocol: sends a boat its plan.

Source: mavlink.io, mission protocol: MISSION_COUNT is repeated every 1,500 ms until the boat
requests an item, at most five times; then each MISSION_REQUEST_INT is answered by an item, until
MISSION_ACK.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

from pymavlink.dialects.v20 import ardupilotmega as mavlink

from sil.wire.mavlink_frames import frames

_RETRY_US, _TRIES = 1_500_000, 5
_READ = {
    mavlink.MAVLINK_MSG_ID_MISSION_REQUEST_INT,
    mavlink.MAVLINK_MSG_ID_MISSION_REQUEST,
    mavlink.MAVLINK_MSG_ID_MISSION_ACK,
}


class PlanItem(NamedTuple):
    """A MAV_CMD with its four parameters and its place, degE7 (0, 0: none)."""

    command: int
    params: tuple[float, float, float, float]
    latitude: int = 0
    longitude: int = 0


def speed_item(speed_mps: float) -> PlanItem:
    """An item that sets the speed from here on."""
    return PlanItem(mavlink.MAV_CMD_DO_CHANGE_SPEED, (1.0, speed_mps, -1.0, 0.0))


def waypoint_item(latitude: int, longitude: int, radius_m: float) -> PlanItem:
    """A place (degE7) that the rounded corner may miss by `radius_m`; 0: the boat's WP_RADIUS."""
    params = (0.0, radius_m, 0.0, math.nan)
    return PlanItem(mavlink.MAV_CMD_NAV_WAYPOINT, params, latitude, longitude)


def voyage_item(latitude: int, longitude: int, share: float, room_m: float) -> PlanItem:
    """A voyage that measures the hull, around a place (degE7); 0, 0: the boat's defaults."""
    return PlanItem(mavlink.MAV_CMD_USER_1, (share, room_m, 0.0, 0.0), latitude, longitude)


class PlanUpload:
    """One plan on its way to one boat.

    `done`: the boat has accepted the plan. `fault`: the reason why it never will, "" while it still
    may.
    """

    def __init__(self, system: int, items: Sequence[PlanItem], station: int, component: int):
        self.done = False
        self.fault = ""
        self._boat = (system, mavlink.MAV_COMP_ID_AUTOPILOT1)
        self._items = items
        self._mav = mavlink.MAVLink(None, station, component)
        self._said = b""
        self._again_us: int | None = None
        self._tries = 0

    def say(self, t_us: int) -> bytes:
        """All messages that are due at `t_us`; call often."""
        if self._again_us is None or t_us >= self._again_us:
            self._count(t_us)
        said, self._said = self._said, b""
        return said

    def on_mavlink(self, data: bytes, t_us: int) -> None:
        """Process whole frames that the boat sends; answers are for the next `say`."""
        if self.done or self.fault or self._again_us is None:
            return
        for message_id, system, component, frame in frames(data):
            if message_id not in _READ or (system, component) != self._boat:
                continue
            message = self._mav.decode(bytearray(frame))
            mine = message.target_system == self._mav.srcSystem
            if not mine or message.mission_type != mavlink.MAV_MISSION_TYPE_MISSION:
                continue
            if message_id == mavlink.MAVLINK_MSG_ID_MISSION_ACK:
                self._end(message.type)
            elif message.seq < len(self._items):
                self._tries, self._again_us = 0, t_us + _RETRY_US
                self._send(self._message(message.seq))

    def _count(self, t_us: int) -> None:
        if self.done or self.fault:
            return
        if self._tries == _TRIES:
            self.fault = "the boat does not answer"
            return
        self._tries, self._again_us = self._tries + 1, t_us + _RETRY_US
        self._send(mavlink.MAVLink_mission_count_message(*self._boat, len(self._items), 0))

    def _end(self, result: int) -> None:
        self.done = result == mavlink.MAV_MISSION_ACCEPTED
        if not self.done:
            self.fault = mavlink.enums["MAV_MISSION_RESULT"][result].name

    def _message(self, seq: int) -> mavlink.MAVLink_message:
        command, params, x, y = self._items[seq]
        frame = mavlink.MAV_FRAME_GLOBAL_RELATIVE_ALT_INT
        return mavlink.MAVLink_mission_item_int_message(
            *self._boat, seq, frame, command, 0, 1, *params, x, y, 0.0, 0
        )

    def _send(self, message: mavlink.MAVLink_message) -> None:
        self._said += message.pack(self._mav)
        self._mav.seq = (self._mav.seq + 1) & 0xFF
