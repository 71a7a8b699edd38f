# SPDX-License-Identifier: MIT
"""The reference for `flotilla.Fleet`: the same of Python classes, slow."""

from __future__ import annotations

import struct
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pymavlink.dialects.v20 import common as mavlink

from sil.lockstep.recording import CAN_IN
from sil.scenario.wiring import NAVIGATION_COMPONENT, ORIGIN
from sil.wire.clock import Clock
from sil.wire.geodesy import Geodetic
from sil.wire.link import Link
from sil.wire.navigation_unit import NavigationUnit, Settings
from sil.wire.operator import COMPONENT, SYSTEM
from tests.loop.vessel import Vessel, VirtualLeader

STATES = (
    *("DISARMED", "HOLD", "MANUAL", "FORMATION", "COAST", "TEST", "FAULT"),
    *("AUTO", "GUIDED", "LOITER", "RTL"),
)
_NOWHERE = (0, 0)

Array = NDArray[Any]
Unit = tuple[Any, ...]


class SplitMix64:
    """Uniform numbers. Source: Steele, Lea, Flood, Fast splittable generators, OOPSLA 2014."""

    def __init__(self, seed: int) -> None:
        self._state = seed

    def random(self) -> float:
        self._state = (self._state + 0x9E3779B97F4A7C15) % 2**64
        z = self._state
        z = (z ^ z >> 30) * 0xBF58476D1CE4E5B9 % 2**64
        z = (z ^ z >> 27) * 0x94D049BB133111EB % 2**64
        return ((z ^ z >> 31) >> 11) * 2.0**-53


class Told:
    """A geodetic frame whose positions are given, not computed."""

    def __init__(self) -> None:
        self.degE7 = _NOWHERE

    def geodetic(self, _north_m: float, _east_m: float, psi: float) -> Geodetic:
        return Geodetic(*self.degE7, psi)


def settings_of(unit: Unit) -> Settings:
    faults = unit[4] if len(unit) > 4 else ()
    rate_hz, message, attitude_rate_hz = unit[:3]
    return Settings(rate_hz, message, attitude_rate_hz, (0.0, 0.0), *faults)


def unit_of(system: int, component: int, unit: Unit) -> Any:
    origin = unit[3] if len(unit) > 3 else ORIGIN
    made: Any = NavigationUnit(
        system,
        component,
        vehicle_type=mavlink.MAV_TYPE_GENERIC,
        origin=origin,
        settings=settings_of(unit),
    )
    made._world = Told()
    return made


class Radio(Link):
    """A link that damages chunks on request."""

    bit: int | None = None

    def send(self, data: bytes, now_us: int) -> None:
        if self.bit is not None and data:
            at = self.bit % (8 * len(data))
            damaged = bytearray(data)
            damaged[at // 8] ^= 1 << at % 8
            data, self.bit = bytes(damaged), None
        super().send(data, now_us)


class Leader(VirtualLeader):
    outbox: list[Any]

    def __init__(self, agent: int, system: int, unit: Unit, clock: Clock) -> None:
        self.system = system
        super().__init__(settings_of(unit), clock)
        self._unit = unit_of(system, mavlink.MAV_COMP_ID_AUTOPILOT1, unit)
        self._port = agent << 8
        self.sent = b""
        self.outbox.append(self)

    def send(self, data: bytes, _t_us: int) -> None:
        """Record a chunk sent over the radio."""
        self.sent = data

    def tick(self, t_us: int, eta: Sequence[float], nu: Sequence[float]) -> None:
        self.sent = b""
        super().tick(t_us, eta, nu)


class Boat(Vessel):
    def __init__(
        self, agent: int, parameters: dict[str, float], scalar: str, unit: Unit, clock: Clock
    ) -> None:
        super().__init__(agent, parameters, scalar, navigation=settings_of(unit), clock=clock)
        self._unit = unit_of(self.system, NAVIGATION_COMPONENT, unit)

    def on_can(self, t_us: int, can_id: int, data: bytes) -> None:
        now_us = self._clock.at(t_us)
        self.record(t_us, self._port + CAN_IN, can_id.to_bytes(4, "little") + data)
        self.boat.on_can(can_id, data, now_us)
        for esc in self._escs:
            esc.on_can(can_id, data, now_us)


class Run:
    """State of one run: its recording, and its operator's sequence number."""

    def __init__(self) -> None:
        self.agents = 0
        self.records: list[bytes] = []
        self.mav = mavlink.MAVLink(None, SYSTEM, COMPONENT)


class ReferenceFleet:
    """The interface of `flotilla.Fleet`; `profile` measures nothing."""

    def __init__(self, scalar: str = "float", record: bool = False, profile: bool = False) -> None:
        self._scalar, self._record = scalar, record
        self._agents: list[Leader | Boat] = []
        self._boats: list[Boat] = []
        self._runs: dict[int, Run] = {}
        self._run_of: list[Run] = []
        self._links: list[Radio] = []

    def _add(self, run: int, make: Any) -> int:
        mine = self._runs.setdefault(run, Run())
        agent = make(mine.agents)
        port = mine.agents << 8 if isinstance(agent, Leader) else 0
        if self._record:
            agent.record = lambda t_us, where, data: mine.records.append(
                struct.pack("<QHH", t_us, port + where, len(data)) + data
            )
        mine.agents += 1
        self._agents.append(agent)
        self._run_of.append(mine)
        return len(self._agents) - 1

    def add_leader(self, run: int, system: int, unit: Unit, clock: tuple[int, float]) -> int:
        return self._add(run, lambda agent: Leader(agent, system, unit, Clock(*clock)))

    def add_boat(
        self, run: int, parameters: dict[str, float], unit: Unit, clock: tuple[int, float]
    ) -> int:
        index = self._add(
            run, lambda agent: Boat(agent, parameters, self._scalar, unit, Clock(*clock))
        )
        boat = self._agents[index]
        assert isinstance(boat, Boat)
        self._boats.append(boat)
        return index

    def connect(
        self,
        sender: int,
        receiver: int,
        delay_s: float = 0.0,
        jitter_s: float = 0.0,
        loss: float = 0.0,
        rate_Bps: float = 0.0,
        seed: int = 0,
    ) -> int:
        link = Radio(
            SplitMix64(seed), delay_s=delay_s, jitter_s=jitter_s, loss=loss, rate_Bps=rate_Bps
        )
        self._links.append(link)
        self._agents[sender].outbox.append(link)
        self._agents[receiver].inbox.append(link)
        return len(self._links) - 1

    def set_link(
        self, link: int, delay_s: float, jitter_s: float, loss: float, rate_Bps: float
    ) -> None:
        radio = self._links[link]
        radio.delay_s, radio.jitter_s, radio.loss = delay_s, jitter_s, loss
        radio.rate_Bps = rate_Bps

    def corrupt(self, link: int, offset_bit: int) -> None:
        self._links[link].bit = offset_bit

    def tick(
        self, t_us: int, eta: Array, nu: Array, degE7: Array | None, rpm: Array, command: Array
    ) -> None:
        agent: Any
        for i, agent in enumerate(self._agents):
            agent._unit._world.degE7 = _NOWHERE if degE7 is None else tuple(degE7[i].tolist())
            if isinstance(agent, Leader):
                agent.tick(t_us, eta[i].tolist(), nu[i].tolist())
        k = 0
        for i, agent in enumerate(self._agents):
            if isinstance(agent, Boat):
                command[k] = agent.tick(t_us, eta[i].tolist(), nu[i].tolist(), rpm[k].tolist())
                k += 1
        for agent in self._agents:
            agent.listen(t_us)

    def hear(self, agent: int, data: bytes, t_us: int, link: int = 1) -> None:
        self._agents[agent].hear(t_us, data, link)

    def on_can(self, agent: int, can_id: int, data: bytes, t_us: int) -> None:
        self._agents[agent].on_can(t_us, can_id, data)

    def command(
        self, agents: Sequence[int], t_us: int, command: int, params: Sequence[float]
    ) -> None:
        seven = (*params, *(0.0,) * (7 - len(params)))
        for agent in agents:
            mav = self._run_of[agent].mav
            message = mavlink.MAVLink_command_long_message(
                self._agents[agent].system, mavlink.MAV_COMP_ID_AUTOPILOT1, command, 0, *seven
            )
            self.hear(agent, message.pack(mav), t_us)
            mav.seq = (mav.seq + 1) & 0xFF

    @property
    def states(self) -> Array:
        return np.array([STATES.index(boat.state) for boat in self._boats], np.uint8)

    def sent(self, agent: int) -> bytes:
        return self._agents[agent].sent

    def snapshot(self, agent: int) -> dict[str, Any]:
        return self._agents[agent].boat.snapshot()

    def parameters(self, agent: int) -> dict[str, float]:
        return self._agents[agent].boat.parameters()

    def take_records(self, run: int) -> bytes:
        records = self._runs[run].records
        taken = b"".join(records)
        records.clear()
        return taken

    def profile(self) -> dict[str, float]:
        return {}
