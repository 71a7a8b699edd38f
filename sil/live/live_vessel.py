# SPDX-License-Identifier: MIT
"""The vessels of a live run: each boat's flotillad with its bus and links, the virtual leader."""

import signal
import subprocess
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Protocol

import can

from sil.live.ordinary_user import ordinary_user
from sil.live.parameter_file import set_up
from sil.live.udp_end import UdpEnd
from sil.scenario.scenario import Scenario
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
from sil.wire.operator import Operator


class Outlet(Protocol):
    """A destination of a vessel's radio: another vessel or a listener."""

    def send(self, data: bytes, t_us: int) -> None:
        """Accept a chunk sent at `t_us`."""


class LiveBoat:
    """A flotillad, its bus with two ESCs, its navigation unit and its radio.

    `more_links`: addresses of further MAVLink links of the flotillad. `escs_speak`: whether the
    ESCs' frames are sent on the bus. `ears`: called with every message that the boat sends by
    radio, and its time, us.
    """

    def __init__(
        self,
        scenario: Scenario,
        agent: int,
        bus: str,
        parameters: dict[str, float],
        clock: Clock,
    ) -> None:
        self.system = agent
        self.bus = bus
        self.inbox: list[Link] = []
        self.outbox: list[Outlet] = []
        self.ears: list[Callable[[bytes, int], None]] = []
        self.process: subprocess.Popen[bytes] | None = None
        self._words = Path()
        self.more_links: list[str] = []
        self.escs_speak = True
        self._parameters = parameters
        self._clock = clock
        self.navigation = UdpEnd()
        self.radio = UdpEnd()
        self.can = self._open()
        self._unit = NavigationUnit(
            agent,
            NAVIGATION_COMPONENT,
            vehicle_type=0,
            origin=ORIGIN,
            settings=scenario.boat_unit(scenario.boat[agent - 1]),
        )
        indices = (parameters.get("ESC_PORT", 0), parameters.get("ESC_STBD", 1))
        self._escs = [
            EscNode(node, int(index)) for node, index in zip(ESC_NODES, indices, strict=True)
        ]

    def _open(self) -> can.BusABC:
        scheme, _, channel = self.bus.partition(":")
        return can.Bus(interface=scheme, channel=channel)

    def reopen(self) -> None:
        """Reopen the bus after its interface was recreated."""
        self.can.shutdown()
        self.can = self._open()

    def start(self, program: Path, folder: Path, *more: str) -> None:
        """Start the flotillad with `more` options; its output goes to `folder`/flotillad.log."""
        folder.mkdir(parents=True, exist_ok=True)
        self._words = folder / "flotillad.log"
        set_up(folder / "state", self._parameters)
        options = [f"--can={self.bus}", f"--state-dir={folder / 'state'}"]
        links = [self.navigation.address, self.radio.address, *self.more_links]
        options += [f"--mavlink={address}" for address in links]
        options += [f"--param={name}={value!r}" for name, value in self._parameters.items()]
        options += [f"--stats={folder / 'stats.json'}", *more]
        with self._words.open("ab") as log:
            self.process = subprocess.Popen(  # noqa: S603
                [*ordinary_user(), program, *options],
                stdin=subprocess.DEVNULL,
                stdout=log,
                stderr=log,
            )

    def last_words(self, status: int) -> str:
        """The last line that its flotillad printed, or its exit status if there is none."""
        lines = self._words.read_text(encoding="utf-8", errors="replace").splitlines()
        return lines[-1] if lines else f"flotillad ended with status {status}, see {self._words}"

    def close(self) -> None:
        """Terminate the flotillad, kill it after 5 s; close bus and sockets."""
        if self.process is not None and self.process.poll() is None:
            self.process.send_signal(signal.SIGTERM)
            try:
                self.process.wait(timeout=5.0)
            except subprocess.TimeoutExpired:
                self.process.kill()
                self.process.wait()
        self.can.shutdown()
        self.navigation.socket.close()
        self.radio.socket.close()

    def descriptors(self) -> list[int]:
        """The descriptors to wait for: bus, navigation, radio."""
        sockets = (self.navigation.socket, self.radio.socket)
        return [self.can.fileno(), *(s.fileno() for s in sockets)]

    def listen(self, t_us: int, operator: Operator) -> None:
        """Process everything that has arrived from the flotillad and the radio."""
        with suppress(can.CanError):  # the interface is down or gone
            while (message := self.can.recv(0.0)) is not None:
                if not message.is_error_frame:
                    for esc in self._escs:
                        esc.on_can(message.arbitration_id, bytes(message.data), t_us)
        for data in self.navigation.receive():
            self._unit.on_mavlink(data, self._clock.at(t_us))
        for data in self.radio.receive():
            operator.on_mavlink(data)
            for ear in self.ears:
                ear(data, t_us)
            for link in self.outbox:
                link.send(data, t_us)
        for link in self.inbox:
            for data in link.receive(t_us):
                self.radio.send(data)

    def send(self, t_us: int, eta: list[float], nu: list[float], rpm: list[float]) -> None:
        """Send the state at `t_us` and the ESCs' frames."""
        self.navigation.send(self._unit.tick(self._clock.at(t_us), eta, nu))
        for esc, shaft in zip(self._escs, rpm, strict=True):
            for can_id, data in esc.tick(t_us, shaft, BATTERY_V, float("nan")):
                # A full queue loses a report; the next one follows in 40 ms.
                with suppress(can.CanError):
                    if self.escs_speak:
                        self.can.send(can.Message(arbitration_id=can_id, data=data))

    def command(self, t_us: int) -> tuple[float, float]:
        """The ESCs' current commands to their motors, in [-1, 1]: port, starboard."""
        port, stbd = self._escs
        return port.command(t_us), stbd.command(t_us)


class LiveLeader:
    """Agent 0, the virtual leader: sends its state by radio to its followers."""

    def __init__(self, navigation: Settings, clock: Clock) -> None:
        self.inbox: list[Link] = []
        self.outbox: list[Outlet] = []
        self._clock = clock
        self._unit = NavigationUnit(
            VIRTUAL_LEADER_SYSTEM, 1, vehicle_type=0, origin=ORIGIN, settings=navigation
        )

    def listen(self, t_us: int) -> None:
        """Process everything that has arrived by radio."""
        for link in self.inbox:
            for data in link.receive(t_us):
                self._unit.on_mavlink(data, self._clock.at(t_us))

    def send(self, t_us: int, eta: list[float], nu: list[float]) -> None:
        """Send its state at `t_us`."""
        data = self._unit.tick(self._clock.at(t_us), eta, nu)
        if data:
            for link in self.outbox:
                link.send(data, t_us)
