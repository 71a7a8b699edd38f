# SPDX-License-Identifier: MIT
"""Logs of flotillad (tlog, with the CAN logs beside it) and ArduPilot's (tlog, .bin).

Motion comes from ODOMETRY, or from ATTITUDE and LOCAL_POSITION_NED; in a .bin from XKF1. Commands
come from esc.RawCommand in the CAN logs, with the indices ESC_PORT and ESC_STBD, or 0 and 1.
Otherwise they come from SERVO_OUTPUT_RAW, in a .bin from RCOU, by the outputs whose SERVOn_FUNCTION
is ThrottleLeft (73) and ThrottleRight (74), or 1 and 3. Times are the log's.
"""

from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import closing
from itertools import chain
from math import inf, radians
from pathlib import Path
from typing import Any

from pymavlink import DFReader
from pymavlink.dialects.v20 import common as mavlink

from sil.identify.series import Series
from sil.identify.voyage_log import BadLogError, VoyageLog
from sil.logs import candump, tlog_reader
from sil.wire.axes import aboard, yaw
from sil.wire.dronecan import RAW_COMMAND, RawCommand
from sil.wire.dronecan_transfer import Receiver, message_subject
from sil.wire.tlog import packets

_FULL_RAW, _ESCS = 8191.0, 20
_AUTOPILOT = 1
_LEFT, _RIGHT = 73, 74
_STOP_US, _FULL_US = 1500.0, 400.0
_DATAFLASH = b"\xa3\x95"
_ODOMETRY, _LOCAL, _ATTITUDE = "ODOMETRY", "LOCAL_POSITION_NED", "ATTITUDE"
_HEARD = frozenset(
    getattr(mavlink, f"MAVLINK_MSG_ID_{name}")
    for name in (_ODOMETRY, _LOCAL, _ATTITUDE, "SERVO_OUTPUT_RAW", "PARAM_VALUE")
)


def read_tlog(path: Path) -> VoyageLog:
    """A telemetry log, with the CAN logs of the same time beside it. Raises `BadLogError`."""
    messages = list(_decoded(path))
    names = {name for _, _, name, _ in messages}
    kinds = {_ODOMETRY} if _ODOMETRY in names else {_LOCAL, _ATTITUDE}
    sources = Counter((s, c) for _, (s, c), name, _ in messages if name in kinds)
    system = _whose(path, {s for s, _ in sources})
    # A boat's component 1 sends the estimate of its own model; its navigation unit is better.
    own = [key for key in sources if key[0] == system]
    unit = max(own, key=lambda key: (key[1] != _AUTOPILOT, sources[key]))
    series = Series(path.stem, aboard=_ODOMETRY in kinds)
    outputs, escs = _Outputs(path), {"ESC_PORT": 0, "ESC_STBD": 1}
    for t_s, source, name, message in messages:
        if source == unit and name in kinds:
            _motion(series, t_s, name, message)
        elif source[0] == system and name == "PARAM_VALUE":
            outputs.parameter(message.param_id, message.param_value)
            if message.param_id in escs and 0 <= message.param_value < _ESCS:
                escs[message.param_id] = int(message.param_value)
        elif source[0] == system and name == "SERVO_OUTPUT_RAW":
            raw = [getattr(message, f"servo{k}_raw", 0) for k in range(1, 17)]
            outputs.heard.append((t_s, raw))
    buses = _buses_beside(path, messages[0][0], messages[-1][0])
    commands = list(_raw_commands(buses, escs["ESC_PORT"], escs["ESC_STBD"]))
    series.commands = commands or outputs.commands()
    return series.log()


def read_bin(path: Path) -> VoyageLog:
    """ArduPilot's DataFlash log. Raises `BadLogError`."""
    series, outputs = Series(path.stem), _Outputs(path)
    with path.open("rb") as file:
        if file.read(len(_DATAFLASH)) != _DATAFLASH:
            raise BadLogError(f"{path}: is no DataFlash log: one begins with the bytes A3 95")
    last_gyro = 0.0
    with closing(DFReader.DFReader_binary(str(path))) as log:
        while (message := log.recv_match(type=["XKF1", "IMU", "RCOU", "PARM"])) is not None:
            kind, t_s = message.get_type(), getattr(message, "TimeUS", 0) * 1e-6
            if kind == "PARM":
                outputs.parameter(message.Name, message.Value)
            elif kind == "RCOU":
                outputs.heard.append((t_s, [getattr(message, f"C{k}", 0) for k in range(1, 15)]))
            elif kind == "IMU" and getattr(message, "I", 0) == 0:
                last_gyro = message.GyrZ
            elif kind == "XKF1" and getattr(message, "C", 0) == 0:
                series.position.append((t_s, message.PN, message.PE))
                series.velocity.append((t_s, message.VN, message.VE))
                series.heading.append((t_s, radians(message.Yaw)))
                series.rate.append((t_s, last_gyro))
    series.commands = outputs.commands()
    return series.log()


class _Outputs:
    """An autopilot's servo outputs, and which of them are the propellers."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self.heard: list[tuple[float, list[int]]] = []
        self._of = {_LEFT: 1, _RIGHT: 3}

    def parameter(self, name: str, value: float) -> None:
        if name.startswith("SERVO") and name.endswith("_FUNCTION") and value in self._of:
            self._of[int(value)] = int(name.removeprefix("SERVO").removesuffix("_FUNCTION"))

    def commands(self) -> list[tuple[float, float, float]]:
        port, stbd = self._of[_LEFT] - 1, self._of[_RIGHT] - 1
        logged = min((len(raw) for _, raw in self.heard), default=inf)
        if (last := max(port, stbd) + 1) > logged:
            raise BadLogError(
                f"{self._path}: SERVO{last}_FUNCTION is a propeller's, but the log has only "
                f"outputs 1 to {logged}. Connect the propeller to one of them"
            )
        return [(t_s, _share(raw[port]), _share(raw[stbd])) for t_s, raw in self.heard]


def _share(pulse_us: float) -> float:
    """A pulse as −1 … 1; no pulse is a stop."""
    return min(1.0, max(-1.0, (pulse_us - _STOP_US) / _FULL_US)) if pulse_us else 0.0


def _decoded(path: Path) -> Iterator[tuple[float, tuple[int, int], str, Any]]:
    for packet in packets(path.read_bytes(), []):
        message = tlog_reader.decoded(packet) if packet.message_id in _HEARD else None
        if message is not None:
            source = packet.system, packet.component
            yield packet.t_us * 1e-6, source, message.get_type(), message


def _whose(path: Path, systems: set[int]) -> int:
    """The system id of the vessel that wrote the log."""
    if not systems:
        raise BadLogError(
            f"{path}: contains neither ODOMETRY nor LOCAL_POSITION_NED with ATTITUDE. Set the "
            "navigation unit to send them, and log again"
        )
    owner = tlog_reader.facts(path).owner if len(systems) > 1 else systems.pop()
    if owner is None:
        raise BadLogError(
            f"{path}: contains several vessels and names no owner; use the boat's own log"
        )
    return owner


def _motion(series: Series, t_s: float, name: str, message: Any) -> None:
    if name == _ATTITUDE:
        series.heading.append((t_s, message.yaw))
        series.rate.append((t_s, message.yawspeed))
        return
    series.position.append((t_s, message.x, message.y))
    if name == _LOCAL:
        series.velocity.append((t_s, message.vx, message.vy))
        return
    psi = yaw(*message.q)
    series.heading.append((t_s, psi))
    series.rate.append((t_s, message.yawspeed))
    velocity = message.vx, message.vy
    if message.child_frame_id == mavlink.MAV_FRAME_LOCAL_NED:
        velocity = aboard(psi, *velocity)
    series.velocity.append((t_s, *velocity))


def _buses_beside(path: Path, first_s: float, last_s: float) -> list[Path]:
    """The CAN logs beside a tlog that were written at the same time.

    Tlogs and CAN logs are numbered independently: equal numbers may belong to different runs.
    """
    begun = []
    for log in path.parent.glob("can-*.log"):
        if (first := next(candump.frames(log, []), None)) is not None:
            begun.append((first.t_us * 1e-6, log))
    begun.sort()
    ends_s = [*(t_s for t_s, _ in begun[1:]), inf]
    return [
        log
        for (begins_s, log), end_s in zip(begun, ends_s, strict=False)
        if begins_s <= last_s and end_s >= first_s
    ]


def _raw_commands(
    paths: Sequence[Path], port: int, stbd: int
) -> Iterator[tuple[float, float, float]]:
    """Commands to the propellers in logs of a boat's bus; `port`, `stbd`: indices of the ESCs."""
    receiver = Receiver({message_subject(RAW_COMMAND): RAW_COMMAND})
    for frame in chain.from_iterable(candump.frames(path, []) for path in paths):
        payload = receiver.on_frame(frame.can_id, frame.data, frame.t_us)
        if payload is not None:
            raw = RawCommand.decode(payload).cmd
            if len(raw) > max(port, stbd):
                yield frame.t_us * 1e-6, raw[port] / _FULL_RAW, raw[stbd] / _FULL_RAW
