# SPDX-License-Identifier: MIT
"""The oracle of `flotilla.Fleet` and `sil.lockstep.world`: each vessel is a Python object.

Each has its own clock; the fleet's messages at every tick must equal these byte for byte.
"""

from collections.abc import Callable, Sequence
from dataclasses import asdict
from typing import Any

import flotilla
from pymavlink.dialects.v20 import common as mavlink

from sil.lockstep.recording import CAN_IN, CAN_OUT, MAVLINK_IN, MAVLINK_OUT
from sil.scenario.wiring import (
    BATTERY_V,
    ESC_NODES,
    NAVIGATION_COMPONENT,
    ORIGIN,
    VIRTUAL_LEADER_SYSTEM,
)
from sil.wire.clock import Clock
from sil.wire.esc_node import EscNode
from sil.wire.link import Link
from sil.wire.navigation_unit import NavigationUnit, Settings

Record = Callable[[int, int, bytes], None]
Sensed = Sequence[float]

_NAVIGATION, _RADIO = 0, 1


def _nowhere(t_us: int, port: int, data: bytes) -> None:
    pass


class VirtualLeader:
    """Agent 0: not a boat, but a MAVLink vehicle that sends its state.

    `record` is told of every chunk and frame: the world's time in us, port, bytes.
    """

    system = VIRTUAL_LEADER_SYSTEM

    def __init__(self, navigation: Settings, clock: Clock) -> None:
        self._clock = clock
        self.record: Record = _nowhere
        self._unit = NavigationUnit(
            self.system,
            mavlink.MAV_COMP_ID_AUTOPILOT1,
            vehicle_type=mavlink.MAV_TYPE_GENERIC,
            origin=ORIGIN,
            settings=navigation,
        )
        self.inbox: list[Link] = []
        self.outbox: list[Link] = []

    def listen(self, t_us: int) -> None:
        """Takes what has come over the radio."""
        for link in self.inbox:
            for data in link.receive(t_us):
                self._unit.on_mavlink(data, self._clock.at(t_us))

    def tick(self, t_us: int, eta: Sensed, nu: Sensed) -> None:
        """Sends its state of the world's time `t_us`."""
        data = self._unit.tick(self._clock.at(t_us), eta, nu)
        if data:
            self.record(t_us, MAVLINK_OUT + _RADIO, data)
            for link in self.outbox:
                link.send(data, t_us)


class Vessel:
    """A boat: firmware, navigation unit (MAVLink link 0), radio (link 1), two ESCs (CAN).

    `sent` is what the firmware said over the radio in the last tick. `record` is told of every
    chunk and frame: the world's time in us, port, bytes.
    """

    def __init__(
        self,
        agent: int,
        parameters: dict[str, float],
        scalar: str,
        *,
        navigation: Settings,
        clock: Clock,
    ) -> None:
        self.boat = flotilla.Boat(parameters, links=2, scalar=scalar)
        self.parameters = self.boat.parameters()
        self.system = int(self.parameters["MAV_SYSID"])
        self.inbox: list[Link] = []
        self.outbox: list[Link] = []
        self.sent = b""
        self._scalar = scalar
        self._clock = clock
        self.record: Record = _nowhere
        self._port = agent << 8
        self._unit = NavigationUnit(
            self.system,
            NAVIGATION_COMPONENT,
            vehicle_type=mavlink.MAV_TYPE_GENERIC,
            origin=ORIGIN,
            settings=navigation,
        )
        self._escs = tuple(
            EscNode(node, int(self.parameters[name]))
            for node, name in zip(ESC_NODES, ("ESC_PORT", "ESC_STBD"), strict=True)
        )

    def header(self) -> dict[str, Any]:
        """The recording's header, from which a replay builds the same boat."""
        return {
            "parameters": self.parameters,
            "links": 2,
            "scalar": self._scalar,
            "clock": asdict(self._clock),
        }

    @property
    def state(self) -> str:
        """Name of the supervisor's state."""
        name: str = self.boat.state
        return name

    def hear(self, t_us: int, data: bytes, link: int = _RADIO) -> None:
        """Pass bytes to the firmware at the world's time `t_us`."""
        self.record(t_us, self._port + MAVLINK_IN + link, data)
        self.boat.on_mavlink(data, self._clock.at(t_us), link)

    def listen(self, t_us: int) -> None:
        """Takes what has come over the radio."""
        for link in self.inbox:
            for data in link.receive(t_us):
                self.hear(t_us, data)

    def tick(self, t_us: int, eta: Sensed, nu: Sensed, rpm: Sequence[float]) -> tuple[float, float]:
        """One control tick of the firmware and all that is wired to it.

        eta = [x y psi] and nu = [u v r] as the sensors have them, rpm of the port and starboard
        shaft. Returns the ESCs' commands to their motors, in [-1, 1]: port, starboard.
        """
        now_us = self._clock.at(t_us)
        data = self._unit.tick(now_us, eta, nu)
        if data:
            self.hear(t_us, data, _NAVIGATION)
        for esc, shaft in zip(self._escs, rpm, strict=True):
            for can_id, payload in esc.tick(now_us, shaft, BATTERY_V, float("nan")):
                self.record(t_us, self._port + CAN_IN, can_id.to_bytes(4, "little") + payload)
                self.boat.on_can(can_id, payload, now_us)
        self.listen(t_us)
        self._send(t_us, now_us)
        port_esc, stbd_esc = self._escs
        return port_esc.command(now_us), stbd_esc.command(now_us)

    def _send(self, t_us: int, now_us: int) -> None:
        out = self.boat.tick(now_us)
        self.sent = b""
        for can_id, payload in out.can:
            self.record(t_us, self._port + CAN_OUT, can_id.to_bytes(4, "little") + payload)
            for esc in self._escs:
                esc.on_can(can_id, payload, now_us)
        for link, data in out.mavlink:
            self.record(t_us, self._port + MAVLINK_OUT + link, data)
            if link == _NAVIGATION:
                self._unit.on_mavlink(data, now_us)
            else:
                self.sent = data
                for radio in self.outbox:
                    radio.send(data, t_us)
