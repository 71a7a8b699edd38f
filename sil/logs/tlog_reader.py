# SPDX-License-Identifier: MIT
"""Reads telemetry logs: decodes packets, finds the vessels in a log and its owner."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from pymavlink.dialects.v20 import common as mavlink

from sil.logs import esc_messages, telemetry, track
from sil.logs.output import Origin
from sil.wire.mavlink_messages import ESC_INFO, ESC_STATUS
from sil.wire.tlog import Packet, packets

_VEHICLE = 1  # component id of an autopilot
_ORIGIN = mavlink.MAVLINK_MSG_ID_GPS_GLOBAL_ORIGIN
_HEARTBEAT = mavlink.MAVLINK_MSG_ID_HEARTBEAT
NEEDED = telemetry.MESSAGES | track.MESSAGES | {ESC_INFO, ESC_STATUS}


@dataclass
class Facts:
    """Vessels in a tlog: origins of local frames, components that send states, leaders."""

    packets: int = 0
    origins: dict[int, Origin] = field(default_factory=dict)
    components: dict[int, set[int]] = field(default_factory=dict)
    leaders: set[int] = field(default_factory=set)

    @property
    def owner(self) -> int | None:
        """The system that wrote the log; None if ambiguous.

        Only a boat's own log contains its navigation unit, which has the boat's system id.
        """
        with_unit = [s for s, told in self.components.items() if _VEHICLE in told and len(told) > 1]
        return with_unit[0] if len(with_unit) == 1 else None


def decoded(packet: Packet) -> Any:
    """The pymavlink message, or the ESCs of an ESC message; None if the packet is damaged."""
    try:
        if packet.message_id in (ESC_INFO, ESC_STATUS):
            return esc_messages.decode(packet.message_id, packet.frame)
        return mavlink.MAVLink(None).decode(bytearray(packet.frame))
    except (mavlink.MAVError, ValueError):
        return None


def facts(path: Path) -> Facts:
    """Read a tlog once; ValueError for a file without any packet."""
    found = Facts()
    for packet in packets(path.read_bytes(), []):
        found.packets += 1
        _note(found, packet)
    if not found.packets:
        raise ValueError(f"{path}: contains no MAVLink packet; expected a telemetry log (.tlog)")
    return found


def _note(found: Facts, packet: Packet) -> None:
    heard, told = packet.message_id, found.components.get(packet.system, set())
    states = heard in track.POSES and packet.component not in told
    if not states and heard not in (_ORIGIN, _HEARTBEAT):
        return
    message = decoded(packet)
    if message is None:
        return
    if states:
        found.components.setdefault(packet.system, set()).add(packet.component)
    elif heard == _ORIGIN:
        found.origins.setdefault(packet.system, track.origin_of(message))
    elif message.type == mavlink.MAV_TYPE_GENERIC and packet.component == _VEHICLE:
        found.leaders.add(packet.system)
