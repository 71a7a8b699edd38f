# SPDX-License-Identifier: MIT
"""A fleet with injected faults, and the messages on its wires."""

from __future__ import annotations

import struct
from typing import Any, NamedTuple

import numpy as np
from pymavlink.dialects.v20 import common as mavlink

from sil.lockstep.recording import CAN_IN, CAN_OUT, MAVLINK_IN, MAVLINK_OUT
from sil.wire.dronecan import ESC_STATUS, EscStatus
from sil.wire.dronecan_transfer import Receiver, message_subject
from tests.target.twin_fleets import H_US, LOCAL, Twins

_HEAD = struct.Struct("<QHH")
NAVIGATION, RADIO = 0, 1


class Record(NamedTuple):
    t_us: int
    agent: int
    channel: int
    data: bytes


class Troubled(Twins):
    """A leader and two boats in a row in FORMATION: agents 0, 1, 2. `commands` of the last tick."""

    def __init__(self, clock: tuple[int, float] = (0, 0.0), **radio: float) -> None:
        super().__init__()
        self.commands = np.zeros((2, 2))
        self.leader(unit=LOCAL, clock=clock)
        for i in (1, 2):
            own = {"MAV_SYSID": i, "FORM_LEADER": 100 if i == 1 else 1, "FORM_OFS_N": -3.0}
            self.boat(own, clock=clock, at=(10.0 - 5.0 * i, 5.0))
            self.tie(i - 1, i, **radio)
        self.enter_formation()
        self.tick(100)
        self.take()

    def both(self, method: str, *arguments: Any, **named: Any) -> Any:
        return getattr(self.fleet, method)(*arguments, **named)

    def tick(self, ticks: int = 1) -> None:
        for _ in range(ticks):
            eta, nu, _, rpm = self._sensed()
            self.fleet.tick(self.t_us, eta, nu, None, rpm, self.commands)
            self._move(self.commands)
            self.t_us += H_US

    def sail(self, ticks: int) -> list[Record]:
        """Sail; the records of that time."""
        self.tick(ticks)
        return self.take()

    def take(self) -> list[Record]:
        """The records since the last call."""
        return records_of(self.fleet)

    def fail(self, agent: int, kind: str, **named: Any) -> None:
        self.fleet.set_fault(agent, kind, self.t_us, **named)

    def heal(self, agent: int, kind: str, **named: Any) -> None:
        self.fleet.clear_fault(agent, kind, self.t_us, **named)

    def conditions(self, agent: int) -> dict[str, bool]:
        conditions: dict[str, bool] = self.fleet.snapshot(agent)["conditions"]
        return conditions


def records_of(fleet: Any) -> list[Record]:
    """The records of run 0 since the last call."""
    return parsed(fleet.take_records(0))


def parsed(data: bytes) -> list[Record]:
    """The records in the bytes that `take_records` returned."""
    at, records = 0, []
    while at < len(data):
        t_us, port, length = _HEAD.unpack_from(data, at)
        at += _HEAD.size
        records.append(Record(t_us, port >> 8, port & 0xFF, data[at : at + length]))
        at += length
    return records


def heard(records: list[Record], agent: int, link: int) -> list[tuple[int, bytes]]:
    """Time and chunk of everything that an agent's boat received."""
    return [(r.t_us, r.data) for r in records if r[1:3] == (agent, MAVLINK_IN + link)]


def said(records: list[Record], agent: int, link: int = RADIO) -> list[tuple[int, bytes]]:
    """Time and chunk of everything that an agent sent."""
    return [(r.t_us, r.data) for r in records if r[1:3] == (agent, MAVLINK_OUT + link)]


def frames(records: list[Record], agent: int, *, to_boat: bool) -> list[tuple[int, bytes]]:
    """The CAN frames that a boat received, or that it sent."""
    channel = CAN_IN if to_boat else CAN_OUT
    found = [r.data for r in records if r[1:3] == (agent, channel)]
    return [(int.from_bytes(data[:4], "little"), data[4:]) for data in found]


def reports(twins: Twins) -> list[EscStatus]:
    """Compare the twins; the reports of the first boat's ESCs since the last comparison."""
    receiver = Receiver({message_subject(ESC_STATUS): ESC_STATUS})
    agent = twins.numbers[twins.boats[0]]
    on_bus = frames(parsed(twins.compare()), agent, to_boat=True)
    payloads = [receiver.on_frame(can_id, data, 0) for can_id, data in on_bus]
    return [EscStatus.decode(payload) for payload in payloads if payload is not None]


def messages(chunks: list[tuple[int, bytes]], kind: str) -> list[Any]:
    """The messages of a kind, decoded by pymavlink."""
    reader = mavlink.MAVLink(None)
    reader.robust_parsing = True
    found = [m for _, data in chunks for m in reader.parse_buffer(bytearray(data)) or []]
    return [m for m in found if m.get_type() == kind]
