# SPDX-License-Identifier: MIT
"""An operator at a ground station: arms boats and sets their mode by MAVLink commands."""

from pymavlink.dialects.v20 import common as mavlink

from sil.wire.heartbeat import state_of
from sil.wire.mavlink_frames import frames

SYSTEM, COMPONENT = 255, mavlink.MAV_COMP_ID_MISSIONPLANNER

_READ = {
    mavlink.MAVLINK_MSG_ID_HEARTBEAT,
    mavlink.MAVLINK_MSG_ID_STATUSTEXT,
}


class Operator:
    """One ground station.

    By system id: `state`, from the last HEARTBEAT that contains one, and the last `text`
    (STATUSTEXT).
    """

    def __init__(self) -> None:
        self.state: dict[int, str] = {}
        self.text: dict[int, str] = {}
        self._mav = mavlink.MAVLink(None, SYSTEM, COMPONENT)

    def arm(self, system: int) -> bytes:
        """The command to arm."""
        return self._command(system, mavlink.MAV_CMD_COMPONENT_ARM_DISARM, 1.0)

    def disarm(self, system: int) -> bytes:
        """The command to disarm."""
        return self._command(system, mavlink.MAV_CMD_COMPONENT_ARM_DISARM, 0.0)

    def set_parameter(self, system: int, name: str, value: float) -> bytes:
        """The PARAM_SET that sets a parameter."""
        wish = mavlink.MAVLink_param_set_message(
            system,
            mavlink.MAV_COMP_ID_AUTOPILOT1,
            name.encode(),
            value,
            mavlink.MAV_PARAM_TYPE_REAL32,
        )
        return self._pack(wish)

    def set_mode(self, system: int, mode: int) -> bytes:
        """The command to change to MANUAL, HOLD or FORMATION."""
        custom = float(mavlink.MAV_MODE_FLAG_CUSTOM_MODE_ENABLED)
        return self._command(system, mavlink.MAV_CMD_DO_SET_MODE, custom, float(mode))

    def sticks(self, system: int, ahead: float) -> bytes:
        """MANUAL_CONTROL: `ahead` in [-1, 1] of full thrust, no turn."""
        x = round(1000 * ahead)
        return self._pack(mavlink.MAVLink_manual_control_message(system, x, 0, 500, 0, 0))

    def set_interval(self, system: int, message: float, interval_us: float) -> bytes:
        """The command to send a message every `interval_us`."""
        return self._command(system, mavlink.MAV_CMD_SET_MESSAGE_INTERVAL, message, interval_us)

    def on_mavlink(self, data: bytes) -> None:
        """Process whole frames that a boat sends."""
        for message_id, system, _, frame in frames(data):
            if message_id not in _READ:
                continue
            message = self._mav.decode(bytearray(frame))
            if message_id == mavlink.MAVLINK_MSG_ID_HEARTBEAT:
                state = state_of(message.custom_mode, message.base_mode, message.system_status)
                if state is not None:
                    self.state[system] = state
            elif message_id == mavlink.MAVLINK_MSG_ID_STATUSTEXT:
                self.text[system] = message.text

    def _command(self, system: int, command: int, *params: float) -> bytes:
        seven = (*params, *(0.0,) * (7 - len(params)))
        message = mavlink.MAVLink_command_long_message(
            system, mavlink.MAV_COMP_ID_AUTOPILOT1, command, 0, *seven
        )
        return self._pack(message)

    def _pack(self, message: mavlink.MAVLink_message) -> bytes:
        frame: bytes = message.pack(self._mav)
        self._mav.seq = (self._mav.seq + 1) & 0xFF
        return frame
