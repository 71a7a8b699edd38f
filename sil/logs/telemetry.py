# SPDX-License-Identifier: MIT
"""A boat's own MAVLink telemetry except its position: law, state, texts, battery.

See firmware/docs/MAVLINK.md. Messages are pymavlink's; times are the log's, ns.
"""

from math import hypot
from typing import Any

from foxglove.messages import LogLevel
from pymavlink.dialects.v20 import common as mavlink

from sil.logs.output import Output
from sil.wire.heartbeat import state_of

#: Fields of `sil.logs.schema.LAW` by the names of NAMED_VALUE_FLOAT.
LAW_NAMES = {
    "E_X": "error_x_m",
    "E_Y": "error_y_m",
    "E_PSI": "error_psi_rad",
    "U_STAR": "wanted_u_mps",
    "R_STAR": "wanted_r_radps",
    "LACK_X": "lack_X_N",
    "LACK_N": "lack_N_Nm",
    "NAV_AGE": "own_age_s",
    "LEAD_AGE": "leader_age_s",
    "LEAD_UNC": "leader_uncertainty_m",
    "UNK_X": "unknown_X_N",
    "UNK_N": "unknown_N_Nm",
    "CUR_N": "current_north_mps",
    "CUR_E": "current_east_mps",
    "OVERRUNS": "overruns",
    "T_PORT": "thrust_port_N",
    "T_STBD": "thrust_stbd_N",
    "T_MAX": "thrust_max_N",
    "T_MIN": "thrust_min_N",
    "LEADER": "leader",
    "COND": "conditions",
    "COND2": "conditions2",
    "DEPTH": "depth",
    "SEP_M": "separation_m",
    "LRN_BAL": "learnt_balance",
    "LRN_DRAG": "learnt_drag",
    "LRN_YAWD": "learnt_yaw_damping",
}
MESSAGES = frozenset(
    (
        mavlink.MAVLINK_MSG_ID_HEARTBEAT,
        mavlink.MAVLINK_MSG_ID_NAMED_VALUE_FLOAT,
        mavlink.MAVLINK_MSG_ID_STATUSTEXT,
        mavlink.MAVLINK_MSG_ID_SYS_STATUS,
    )
)
_LEVELS = (
    *[LogLevel.Fatal] * 3,
    LogLevel.Error,
    LogLevel.Warning,
    *[LogLevel.Info] * 2,
    LogLevel.Debug,
)
_STATE_LEVELS = {"FAULT": LogLevel.Error, "COAST": LogLevel.Warning}
_TEXT_BYTES = 50
_ROUND_NS, _FORGOTTEN_NS = 50_000_000, 5_000_000_000
_NO_VOLTAGE, _NO_CURRENT = 65535, -1


def _state_of(heartbeat: Any, *, tells_law: bool) -> str | None:
    """The supervisor's state in a HEARTBEAT; None if no Flotilla boat sent it."""
    kinds = [
        (mavlink.MAV_TYPE_SURFACE_BOAT, mavlink.MAV_AUTOPILOT_GENERIC),
        (mavlink.MAV_TYPE_ONBOARD_CONTROLLER, mavlink.MAV_AUTOPILOT_INVALID),
    ]
    if tells_law:  # a boat with MAV_AUTOPILOT 1 sends the law; other autopilots do not
        kinds.append((mavlink.MAV_TYPE_SURFACE_BOAT, mavlink.MAV_AUTOPILOT_ARDUPILOTMEGA))
    if (heartbeat.type, heartbeat.autopilot) not in kinds:
        return None
    return state_of(heartbeat.custom_mode, heartbeat.base_mode, heartbeat.system_status)


class Telemetry:
    """Writes `/BOAT/status`, `/BOAT/law` and `/BOAT/log`.

    NAMED_VALUE_FLOATs arrive one by one, over several links in any order. With `tells_law`, those
    within 50 ms are merged into one message, completed with the last values of the others. Call
    `end` after the last message.
    """

    def __init__(self, output: Output, boat: str, *, tells_law: bool) -> None:
        self._output = output
        self._boat = boat
        self._tells_law = tells_law
        self._said: dict[str, tuple[int, float]] = {}
        self._round_ns: int | None = None
        self._state: str | None = None
        self._battery: dict[str, float] = {}
        self._text = (0, b"")

    def take(self, t_ns: int, message: Any) -> None:
        """Process a message of MESSAGES; ignores others."""
        kind = message.get_msgId()
        if kind == mavlink.MAVLINK_MSG_ID_NAMED_VALUE_FLOAT:
            self._take_value(t_ns, message)
        elif kind == mavlink.MAVLINK_MSG_ID_HEARTBEAT:
            self._take_heartbeat(t_ns, message)
        elif kind == mavlink.MAVLINK_MSG_ID_STATUSTEXT:
            self._take_text(t_ns, message)
        elif kind == mavlink.MAVLINK_MSG_ID_SYS_STATUS:
            self._battery = {}
            if message.voltage_battery != _NO_VOLTAGE:
                self._battery["battery_V"] = 0.001 * message.voltage_battery
            if message.current_battery != _NO_CURRENT:
                self._battery["battery_A"] = 0.01 * message.current_battery

    def law(self, t_ns: int) -> dict[str, float]:
        """Fields of `sil.logs.schema.LAW` received in the last five seconds."""
        return {
            field: value for field, (at, value) in self._said.items() if t_ns - at <= _FORGOTTEN_NS
        }

    def end(self) -> None:
        """Write the values of the last, unfinished 50 ms."""
        if self._round_ns is not None and self._tells_law:
            law = self.law(self._round_ns)
            if "error_x_m" in law and "error_y_m" in law:
                law["error_m"] = hypot(law["error_x_m"], law["error_y_m"])
            self._output.own(self._round_ns, f"/{self._boat}/law", "Law", law)
        self._round_ns = None

    def _take_value(self, t_ns: int, message: Any) -> None:
        field = LAW_NAMES.get(message.name)
        if field is None:
            return
        if self._round_ns is None or not 0 <= t_ns - self._round_ns < _ROUND_NS:
            self.end()
            self._round_ns = t_ns
        self._said[field] = (t_ns, message.value)

    def _take_heartbeat(self, t_ns: int, message: Any) -> None:
        state = _state_of(message, tells_law=bool(self._said))
        if state is None:
            return
        if state != self._state:
            change = f"{self._state} → {state}" if self._state else state
            level = _STATE_LEVELS.get(state, LogLevel.Info)
            self._output.log(t_ns, self._boat, level, change)
            self._state = state
        status = {"state": state, **self._battery}
        self._output.own(t_ns, f"/{self._boat}/status", "Status", status)

    def _take_text(self, t_ns: int, message: Any) -> None:
        """Join the chunks of a long text: they share an id, and the last one is not full."""
        piece = message.text.encode("utf-8", "replace")
        number, begun = self._text
        if message.id and message.chunk_seq and message.id == number:
            piece = begun + piece
        self._text = (message.id, piece)
        if message.id and len(message.text) == _TEXT_BYTES:
            return
        level = _LEVELS[min(message.severity, len(_LEVELS) - 1)]
        self._output.log(t_ns, self._boat, level, piece.decode("utf-8", "replace"))
        self._text = (0, b"")
