# SPDX-License-Identifier: MIT
"""An operator at a ground station: arms boats, sets their mode and sends plans by MAVLink."""

from collections.abc import Sequence

from pymavlink.dialects.v20 import ardupilotmega as mavlink

from sil.wire.heartbeat import FORMATION, HOLD, state_of
from sil.wire.mavlink_frames import frames
from sil.wire.mavlink_messages import ESC_INFO, ESC_STATUS
from sil.wire.plan_upload import PlanItem, PlanUpload
from sil.wire.texts import CHUNK_BYTES, Texts

SYSTEM, COMPONENT = 255, mavlink.MAV_COMP_ID_MISSIONPLANNER

#: A MAV_CMD and its first parameters.
Request = tuple[int, tuple[float, ...]]
ARM: Request = (mavlink.MAV_CMD_COMPONENT_ARM_DISARM, (1.0,))
DISARM: Request = (mavlink.MAV_CMD_COMPONENT_ARM_DISARM, (0.0,))

_CUSTOM_MODE = float(mavlink.MAV_MODE_FLAG_CUSTOM_MODE_ENABLED)
_READ = {
    mavlink.MAVLINK_MSG_ID_HEARTBEAT,
    mavlink.MAVLINK_MSG_ID_STATUSTEXT,
}


def mode_request(mode: int) -> Request:
    """The request to change to MANUAL, HOLD, FORMATION or AUTO."""
    return mavlink.MAV_CMD_DO_SET_MODE, (_CUSTOM_MODE, float(mode))


def plan_upload(system: int, items: Sequence[PlanItem]) -> PlanUpload:
    """The operator's side of the transfer of a plan to a boat."""
    return PlanUpload(system, items, SYSTEM, COMPONENT)


def start_requests(
    slow_Hz: float, all_armed: bool, holds: bool, mode: int = FORMATION
) -> list[Request]:
    """Requests that an operator repeats to a boat until all boats are in their `mode`.

    They are: ESC_STATUS and ESC_INFO, which boats send only on request, at the rate of their
    SR_SLOW; to arm; and once all boats are armed, `mode`, through HOLD unless the boat `holds`.
    """
    asked: list[Request] = []
    if slow_Hz > 0:
        intervals_us = ((ESC_STATUS, 1e6 / slow_Hz), (ESC_INFO, 1e6 * max(5, 1 / slow_Hz)))
        asked = [
            (mavlink.MAV_CMD_SET_MESSAGE_INTERVAL, (float(message), us))
            for message, us in intervals_us
        ]
    asked.append(ARM)
    if all_armed:
        asked += [mode_request(one) for one in ((mode,) if holds else (HOLD, mode))]
    return asked


def next_request(state: str, mode: int = FORMATION) -> Request | None:
    """The request that brings a boat one step from `state` to `mode`; None if none is needed."""
    return {"FAULT": DISARM, "DISARMED": ARM, "HOLD": mode_request(mode)}.get(state)


class Operator:
    """One ground station.

    By system id: `state`, from the last HEARTBEAT that contains one, and the last whole `text`
    (of STATUSTEXTs).
    """

    def __init__(self) -> None:
        self.state: dict[int, str] = {}
        self.text: dict[int, str] = {}
        self._texts: dict[int, Texts] = {}
        self._mav = mavlink.MAVLink(None, SYSTEM, COMPONENT)

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

    def sticks(self, system: int, ahead: float) -> bytes:
        """MANUAL_CONTROL: `ahead` in [-1, 1] of full thrust, no turn."""
        x = round(1000 * ahead)
        return self._pack(mavlink.MAVLink_manual_control_message(system, x, 0, 500, 0, 0))

    def ask(self, system: int, request: Request) -> bytes:
        """The COMMAND_LONG of a request."""
        command, params = request
        seven = (*params, *(0.0,) * (7 - len(params)))
        message = mavlink.MAVLink_command_long_message(
            system, mavlink.MAV_COMP_ID_AUTOPILOT1, command, 0, *seven
        )
        return self._pack(message)

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
                piece = message.text.encode().ljust(CHUNK_BYTES, b"\0")
                texts = self._texts.setdefault(system, Texts())
                texts.hear(message.get_srcComponent(), piece, message.id, message.chunk_seq, 0.0)
                if texts.last:
                    self.text[system] = texts.last

    def _pack(self, message: mavlink.MAVLink_message) -> bytes:
        frame: bytes = message.pack(self._mav)
        self._mav.seq = (self._mav.seq + 1) & 0xFF
        return frame
