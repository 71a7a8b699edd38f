# SPDX-License-Identifier: MIT
"""A boat's motion and commands from its wires, as a table for the identification of its hull.

One row for each state from the navigation unit, at the time when the boat received it: the unit's
values, noise and delay included, and the last command to each propeller until then. Columns:

    t_s             since the first row
    north_m east_m  from the unit's origin            yaw_rad          clockwise from north, (−π, π]
    surge_mps sway_mps yaw_rate_radps                 over ground, in the boat's axes
    port stbd       RawCommand over 8191, −1 … 1, as sent: a propeller that is reversed by THR_…_DIR
                    has the other sign
"""

from collections.abc import Iterable, Iterator
from math import remainder, tau
from pathlib import Path
from typing import Any, NamedTuple

from pymavlink.dialects.v20 import common as mavlink

from sil.common import files
from sil.lockstep.recording import CAN_OUT, MAVLINK_IN, Recording
from sil.logs import candump
from sil.wire.axes import aboard, yaw
from sil.wire.dronecan import RAW_COMMAND, RawCommand
from sil.wire.dronecan_transfer import Receiver, message_subject
from sil.wire.mavlink_frames import frames
from sil.wire.tlog import of_links

COLUMNS = "t_s,north_m,east_m,yaw_rad,surge_mps,sway_mps,yaw_rate_radps,port,stbd"
_FULL = 8191.0
_ODOMETRY = mavlink.MAVLINK_MSG_ID_ODOMETRY
_LOCAL = mavlink.MAVLINK_MSG_ID_LOCAL_POSITION_NED
_ATTITUDE = mavlink.MAVLINK_MSG_ID_ATTITUDE
_READ = {_ODOMETRY, _LOCAL, _ATTITUDE}
_AUTOPILOT = 1
_HALF = 1 << 31  # half the period of a clock that wraps around, ms
_ABOARD = {mavlink.MAV_FRAME_BODY_FRD, mavlink.MAV_FRAME_BODY_NED}


class Row(NamedTuple):
    """One row of the table."""

    t_s: float
    north_m: float
    east_m: float
    yaw_rad: float
    surge_mps: float
    sway_mps: float
    yaw_rate_radps: float
    port: float
    stbd: float


class _Event(NamedTuple):
    """Something on a wire: a MAVLink frame (`can_id` None), or a CAN frame."""

    t_us: int
    can_id: int | None
    data: bytes


class OwnMotion:
    """Makes rows from the traffic on the wires of the boat with this system id.

    `port`, `stbd`: indices of its ESCs.
    """

    def __init__(self, system: int, port: int = 0, stbd: int = 1) -> None:
        self._system, self._escs = system, (port, stbd)
        subject = message_subject(RAW_COMMAND)
        self._bus = Receiver({subject: RAW_COMMAND})
        self._mav = mavlink.MAVLink(None)
        self._attitude: Any = None
        self._commands = (0.0, 0.0)
        self._begin_us: int | None = None

    def on_can(self, t_us: int, can_id: int, data: bytes) -> None:
        """Process a frame of the boat's bus."""
        payload = self._bus.on_frame(can_id, data, t_us)
        if payload is None:
            return
        told = RawCommand.decode(payload).cmd
        if len(told) > max(self._escs):
            port, stbd = (told[index] / _FULL for index in self._escs)
            self._commands = port, stbd

    def on_mavlink(self, t_us: int, frame: bytes) -> Iterator[Row]:
        """Process whole frames that the boat received; yield a row for each state of its unit."""
        for message_id, system, component, one in frames(frame):
            if message_id not in _READ or system != self._system or component == _AUTOPILOT:
                continue
            message: Any = self._mav.decode(bytearray(one))
            if message_id == _ATTITUDE:
                self._attitude = message
            elif (motion := self._motion(message)) is not None:
                if self._begin_us is None:
                    self._begin_us = t_us
                yield Row(1e-6 * (t_us - self._begin_us), *motion, *self._commands)

    def _motion(self, message: Any) -> tuple[float, float, float, float, float, float] | None:
        if message.get_msgId() == _LOCAL:
            if self._attitude is None:
                return None
            psi, r = self._attitude.yaw, self._attitude.yawspeed
            since_ms = (message.time_boot_ms - self._attitude.time_boot_ms + _HALF) % (2 * _HALF)
            psi = remainder(psi + 1e-3 * (since_ms - _HALF) * r, tau)
            return message.x, message.y, psi, *aboard(psi, message.vx, message.vy), r
        if message.frame_id != mavlink.MAV_FRAME_LOCAL_NED:
            return None
        psi = yaw(*message.q)
        velocity = message.vx, message.vy
        if message.child_frame_id == mavlink.MAV_FRAME_LOCAL_NED:
            velocity = aboard(psi, *velocity)
        elif message.child_frame_id not in _ABOARD:
            return None
        return message.x, message.y, psi, *velocity, message.yawspeed


def of_run(recording: Path, agent: int) -> Iterator[Row]:
    """The rows of an agent in a run's recording.bin; ValueError if that is damaged."""
    record = Recording(recording)
    own = record.header["boats"][agent - 1]["parameters"]
    escs = round(own["ESC_PORT"]), round(own["ESC_STBD"])
    channels = {MAVLINK_IN: None, CAN_OUT: 0}
    events = (
        _Event(t_us, None, data)
        if where & 0xFF == MAVLINK_IN
        else _Event(t_us, int.from_bytes(data[:4], "little"), data[4:])
        for t_us, where, data in record
        if where >> 8 == agent and where & 0xFF in channels
    )
    return _rows(events, OwnMotion(round(own["MAV_SYSID"]), *escs))


def of_logs(folder: Path, system: int, port: int = 0, stbd: int = 1) -> Iterator[Row]:
    """The rows of `flotillad --log`: of the last candump log in a folder and the tlogs beside it.

    ValueError if either is missing.
    """
    tlogs, buses = sorted(folder.glob("*.tlog")), sorted(folder.glob("can-*.log"))
    if not tlogs or not buses:
        raise ValueError(f"{folder}: no logs of a boat (a .tlog and a can-….log)")
    number = buses[-1].stem.removeprefix("can-")
    said = of_links(path for path in tlogs if path.stem.endswith(f"-{number}"))
    events = [_Event(packet.t_us, None, packet.frame) for packet in said]
    events += [_Event(one.t_us, one.can_id, one.data) for one in candump.frames(buses[-1], [])]
    events.sort(key=lambda event: event.t_us)
    return _rows(events, OwnMotion(system, port, stbd))


def leave(out: Path, system: int = 1, port: int = 0, stbd: int = 1) -> Path:
    """Write motionN.csv into a run's folder, from its recording or boat N's logs; return its path.

    `port`, `stbd`: ESC indices of a live run's boat. ValueError or OSError if there is nothing to
    read.
    """
    path, recording = out / f"motion{system}.csv", out / "recording.bin"
    if recording.exists():
        write(path, of_run(recording, system))
    else:
        write(path, of_logs(out / f"boat{system}" / "log", system, port, stbd))
    return path


def write(path: Path, rows: Iterable[Row]) -> int:
    """Write the table, whole or not at all; return the number of rows."""
    lines = [
        ",".join(f"{value:.6g}" if i else f"{value:.6f}" for i, value in enumerate(row))
        for row in rows
    ]
    files.replace(path, "\n".join([COLUMNS, *lines, ""]).encode())
    return len(lines)


def _rows(events: Iterable[_Event], motion: OwnMotion) -> Iterator[Row]:
    for event in events:
        if event.can_id is None:
            yield from motion.on_mavlink(event.t_us, event.data)
        else:
            motion.on_can(event.t_us, event.can_id, event.data)
