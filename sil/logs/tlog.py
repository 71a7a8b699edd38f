# SPDX-License-Identifier: MIT
"""Telemetry logs: for each packet the time (u64 us since 1970, big endian), then the packet."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

from pymavlink.dialects.v20 import common as mavlink  # type: ignore[import-untyped]

from sil.logs import esc_messages, telemetry, track
from sil.logs.output import Origin
from sil.view.messages import ESC_INFO, ESC_STATUS

_TIME = 8
_V1, _V2 = 0xFE, 0xFD
_LATEST_US = 4_102_444_800_000_000  # the year 2100: a time after that is none
_VEHICLE = 1  # the component of an autopilot
_ORIGIN = mavlink.MAVLINK_MSG_ID_GPS_GLOBAL_ORIGIN
_HEARTBEAT = mavlink.MAVLINK_MSG_ID_HEARTBEAT
NEEDED = telemetry.MESSAGES | track.MESSAGES | {ESC_INFO, ESC_STATUS}


class Packet(NamedTuple):
    """One packet with its time, UNIX us."""

    t_us: int
    system: int
    component: int
    message_id: int
    frame: bytes

    @property
    def size(self) -> int:
        """Bytes in the file."""
        return _TIME + len(self.frame)

    @property
    def payload(self) -> bytes:
        """Without header, checksum and signature."""
        begin = 10 if self.frame[0] == _V2 else 6
        return self.frame[begin : begin + self.frame[1]]

    def decoded(self) -> Any:
        """The message of pymavlink, or the ESCs of an ESC message; None where it is damaged."""
        try:
            if self.message_id in (ESC_INFO, ESC_STATUS):
                return esc_messages.decode(self.message_id, self.frame)
            return mavlink.MAVLink(None).decode(bytearray(self.frame))
        except (mavlink.MAVError, ValueError):
            return None


@dataclass
class Facts:
    """Who is heard in a tlog: origins of local frames, components that tell states, leaders."""

    packets: int = 0
    origins: dict[int, Origin] = field(default_factory=dict)
    components: dict[int, set[int]] = field(default_factory=dict)
    leaders: set[int] = field(default_factory=set)

    @property
    def owner(self) -> int | None:
        """The system aboard which it was written, None where that is not clear.

        A boat hears no other one's navigation unit, which shares its system id.
        """
        with_unit = [s for s, told in self.components.items() if _VEHICLE in told and len(told) > 1]
        return with_unit[0] if len(with_unit) == 1 else None


def packets(content: bytes, damaged: list[int]) -> Iterator[Packet]:
    """The packets of a tlog; appends to `damaged` how many bytes between them are none."""
    at, size, lost = 0, len(content), 0
    while at < size:
        end = _end(content, at)
        if end is None:
            at, lost = at + 1, lost + 1
            continue
        if lost:
            damaged.append(lost)
            lost = 0
        yield _packet(content, at, end)
        at = end
    if lost:
        damaged.append(lost)


def facts(path: Path) -> Facts:
    """Reads a tlog once. ValueError for a file that holds no packet at all."""
    found = Facts()
    for packet in packets(path.read_bytes(), []):
        found.packets += 1
        _note(found, packet)
    if not found.packets:
        raise ValueError(f"{path}: holds no MAVLink packet, it is no tlog")
    return found


def _note(found: Facts, packet: Packet) -> None:
    heard, told = packet.message_id, found.components.get(packet.system, set())
    states = heard in track.POSES and packet.component not in told
    if not states and heard not in (_ORIGIN, _HEARTBEAT):
        return
    message = packet.decoded()
    if message is None:
        return
    if states:
        found.components.setdefault(packet.system, set()).add(packet.component)
    elif heard == _ORIGIN:
        found.origins.setdefault(packet.system, track.origin_of(message))
    elif message.type == mavlink.MAV_TYPE_GENERIC and packet.component == _VEHICLE:
        found.leaders.add(packet.system)


def _end(content: bytes, at: int) -> int | None:
    """Where the record at `at` ends; None where none begins there."""
    end = _whole(content, at)
    if end is None:
        return None
    # the next one, or what is left of it, begins there
    return end if len(content) - end <= _TIME or _begins(content, end) else None


def _begins(content: bytes, at: int) -> bool:
    begin = at + _TIME
    time_us = int.from_bytes(content[at:begin], "big")
    return begin < len(content) and content[begin] in (_V1, _V2) and time_us < _LATEST_US


def _whole(content: bytes, at: int) -> int | None:
    begin = at + _TIME
    if not _begins(content, at) or begin + 3 > len(content):
        return None
    second = content[begin] == _V2
    overhead = 12 + (13 if content[begin + 2] & 1 else 0) if second else 8
    end = begin + content[begin + 1] + overhead
    return end if end <= len(content) else None


def _packet(content: bytes, at: int, end: int) -> Packet:
    frame = content[at + _TIME : end]
    t_us = int.from_bytes(content[at : at + _TIME], "big")
    if frame[0] == _V2:
        return Packet(t_us, frame[5], frame[6], int.from_bytes(frame[7:10], "little"), frame)
    return Packet(t_us, frame[3], frame[4], frame[5], frame)
