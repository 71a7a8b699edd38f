# SPDX-License-Identifier: MIT
"""The live world: real flotillad processes on a real bus, hulls and ESCs in real time.

Each boat has a flotillad, a CAN bus and two UDP links: its navigation unit and its radio. This
process is everything else: hulls, navigation units, ESCs, the virtual leader, the radio between
them all, and the operator. It takes what arrives when it arrives, and on a grid of control ticks
it carries the hulls on and sends the state of that instant, stamped with that instant.
"""

import os
import select
import signal
import socket
import subprocess
import time
from collections.abc import Callable
from contextlib import ExitStack, suppress
from pathlib import Path

import can
import numpy as np

from sil.clock import Clock
from sil.plant import sensors
from sil.plant.hull import Array
from sil.scenario import Scenario
from sil.trace import Tracer
from sil.vessel import BATTERY_V, ESC_NODES, NAVIGATION_COMPONENT, ORIGIN, VIRTUAL_LEADER_SYSTEM
from sil.wire.esc_node import EscNode
from sil.wire.link import Link
from sil.wire.navigation_unit import NavigationUnit
from sil.wire.operator import FORMATION, HOLD, Operator
from sil.world import Progress, StartError, clocks_of, fleet_of, parameters_of

ROOT = Path(__file__).parent.parent
FLOTILLAD = ROOT / "build" / "release" / "firmware" / "flotillad"

_LOOPBACK = "127.0.0.1"
_PATIENCE_S = 30.0
_RETRY_US = 500_000
_NAMES = {HOLD: "HOLD", FORMATION: "FORMATION"}


def now_us() -> int:
    """The world's time: the clock that flotillad reads too."""
    return time.monotonic_ns() // 1000


def buses_of(first: str, boats: int) -> list[str]:
    """Addresses of the boats' buses: the first is boat 1's, boat i takes the next one.

    ValueError where `first` is neither mcast:N nor socketcan:NAMEn.
    """
    scheme, _, channel = first.partition(":")
    digits = len(channel) - len(channel.rstrip("0123456789"))
    if (
        scheme not in ("mcast", "socketcan")
        or digits == 0
        or (scheme == "mcast") != (digits == len(channel))
    ):
        raise ValueError(f'--bus "{first}": must be mcast:N or socketcan:NAMEn, as socketcan:vcan0')
    name, number = channel[:-digits], int(channel[-digits:])
    return [f"{scheme}:{name}{number + i}" for i in range(boats)]


class _Udp:
    """One end of a UDP link whose other end is a flotillad that talks first."""

    def __init__(self) -> None:
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.bind((_LOOPBACK, 0))
        self.socket.setblocking(False)
        self.address = f"udpout:{_LOOPBACK}:{self.socket.getsockname()[1]}"
        self._peer: tuple[str, int] | None = None

    def receive(self) -> list[bytes]:
        chunks = []
        with suppress(BlockingIOError):
            while True:
                data, self._peer = self.socket.recvfrom(4096)
                chunks.append(data)
        return chunks

    def send(self, data: bytes) -> None:
        # A flotillad that was killed refuses; MAVLink repeats itself.
        if self._peer is not None and data:
            with suppress(ConnectionRefusedError):
                self.socket.sendto(data, self._peer)


class LiveBoat:
    """A flotillad, its bus with two ESCs, its navigation unit and its radio."""

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
        self.outbox: list[Link] = []
        self.process: subprocess.Popen[bytes] | None = None
        self._parameters = parameters
        self._clock = clock
        self._operator: Operator | None = None
        self.navigation = _Udp()
        self.radio = _Udp()
        scheme, _, channel = bus.partition(":")
        self.can = can.Bus(interface=scheme, channel=channel)
        self._unit = NavigationUnit(
            agent,
            NAVIGATION_COMPONENT,
            vehicle_type=0,
            origin=ORIGIN,
            rate_hz=scenario.navigation.rate_hz,
            message=scenario.navigation.message,
        )
        indices = (parameters.get("ESC_PORT", 0), parameters.get("ESC_STBD", 1))
        self._escs = [
            EscNode(node, int(index)) for node, index in zip(ESC_NODES, indices, strict=True)
        ]

    def start(self, program: Path, folder: Path) -> None:
        """Starts the flotillad; its words go to `folder`/flotillad.log."""
        folder.mkdir(parents=True, exist_ok=True)
        options = [f"--can={self.bus}", f"--state-dir={folder / 'state'}"]
        options += [f"--mavlink={link.address}" for link in (self.navigation, self.radio)]
        options += [f"--param={name}={value!r}" for name, value in self._parameters.items()]
        options += [f"--stats={folder / 'stats.json'}"]
        with (folder / "flotillad.log").open("ab") as log:
            self.process = subprocess.Popen(  # noqa: S603
                [program, *options], stdin=subprocess.DEVNULL, stdout=log, stderr=log
            )

    def close(self) -> None:
        """Asks the flotillad to leave, and sees to it."""
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
        """What to wait for."""
        sockets = (self.navigation.socket, self.radio.socket)
        return [self.can.fileno(), *(s.fileno() for s in sockets)]

    def listen(self, t_us: int, operator: Operator) -> None:
        """Takes what has arrived from the flotillad and from the radio."""
        while (message := self.can.recv(0.0)) is not None:
            if not message.is_error_frame:
                for esc in self._escs:
                    esc.on_can(message.arbitration_id, bytes(message.data), t_us)
        for data in self.navigation.receive():
            self._unit.on_mavlink(data, self._clock.at(t_us))
        for data in self.radio.receive():
            operator.on_mavlink(data)
            for link in self.outbox:
                link.send(data, t_us)
        for link in self.inbox:
            for data in link.receive(t_us):
                self.radio.send(data)

    def send(self, t_us: int, eta: list[float], nu: list[float], rpm: list[float]) -> None:
        """The state of the instant `t_us` and what the ESCs have to say."""
        self.navigation.send(self._unit.tick(self._clock.at(t_us), eta, nu))
        for esc, shaft in zip(self._escs, rpm, strict=True):
            for can_id, data in esc.tick(t_us, shaft, BATTERY_V, float("nan")):
                # A full queue loses a report; the next one comes in 40 ms.
                with suppress(can.CanError):
                    self.can.send(can.Message(arbitration_id=can_id, data=data))

    def command(self, t_us: int) -> tuple[float, float]:
        """What the ESCs tell their motors now, in [-1, 1]: port, starboard."""
        port, stbd = self._escs
        return port.command(t_us), stbd.command(t_us)


class _LiveLeader:
    """Agent 0: sends its state over the radio of its followers."""

    def __init__(self, rate_hz: float, clock: Clock) -> None:
        self.inbox: list[Link] = []
        self.outbox: list[Link] = []
        self._clock = clock
        self._unit = NavigationUnit(
            VIRTUAL_LEADER_SYSTEM, 1, vehicle_type=0, origin=ORIGIN, rate_hz=rate_hz
        )

    def listen(self, t_us: int) -> None:
        for link in self.inbox:
            for data in link.receive(t_us):
                self._unit.on_mavlink(data, self._clock.at(t_us))

    def send(self, t_us: int, eta: list[float], nu: list[float]) -> None:
        data = self._unit.tick(self._clock.at(t_us), eta, nu)
        if data:
            for link in self.outbox:
                link.send(data, t_us)


class LiveWorld:
    """One scenario, ready to be sailed once in real time. A context manager.

    `bus`: address of boat 1's bus. ValueError where it is none; can.CanError or OSError where it
    cannot be opened.
    """

    def __init__(self, scenario: Scenario, bus: str, param_overrides: dict[str, float]) -> None:
        self._scenario = scenario
        seeds = np.random.SeedSequence(scenario.seed).spawn(3)
        clock_rng, self._sensor_rng, link_rng = (np.random.default_rng(seed) for seed in seeds)
        clocks = clocks_of(scenario, clock_rng)
        self._fleet = fleet_of(scenario)
        # Compiled now, not when the boats are under way.
        fleet_of(scenario).advance(np.zeros((len(scenario.boat), 2)), np.zeros((3, 2)), 1e-3)
        self._sigma = scenario.navigation.noise.sigma
        self._h_us = round(1e6 / scenario.rate_hz)
        self._operator = Operator()
        self._leader = _LiveLeader(scenario.navigation.rate_hz, clocks[0])
        self.late_us = 0
        with ExitStack() as opened:
            self.boats: list[LiveBoat] = []
            for agent, address in enumerate(buses_of(bus, len(scenario.boat)), start=1):
                own = parameters_of(scenario, agent, param_overrides)
                self.boats.append(LiveBoat(scenario, agent, address, own, clocks[agent]))
                opened.callback(self.boats[-1].close)
            self._opened = opened.pop_all()
        agents: list[_LiveLeader | LiveBoat] = [self._leader, *self.boats]
        for boat, live in zip(scenario.boat, self.boats, strict=True):
            leader = agents[boat.follows]
            for sender, receiver in ((leader, live), (live, leader)):
                link = Link(link_rng, **scenario.link.model_dump())
                sender.outbox.append(link)
                receiver.inbox.append(link)
        self._command: Array = np.zeros((len(self.boats), 2))

    def __enter__(self) -> "LiveWorld":
        return self

    def __exit__(self, *_: object) -> None:
        self._opened.close()

    def run(self, program: Path, out: Path, progress: Progress) -> Tracer:
        """Starts the boats' processes and sails the scenario, in real time."""
        for boat in self.boats:
            boat.start(program, out / f"boat{boat.system}")
        tick_us = self._start()
        tracer = Tracer(self._scenario, self._fleet)
        for k in range(tracer.ticks):
            for i, boat in enumerate(self.boats):
                self._command[i] = boat.command(tick_us)
            tracer.step(k, self._command, [self._state(boat) for boat in self.boats])
            tick_us += self._h_us
            self._until(tick_us)
            self._send(tick_us)
            if k % 100 == 0:
                progress(k / tracer.ticks)
        progress(1.0)
        return tracer

    def _state(self, boat: LiveBoat) -> str:
        mode, armed = self._operator.mode.get(boat.system), self._operator.armed.get(boat.system)
        return _NAMES.get(mode or 0, "?") if armed else "DISARMED"

    def _start(self) -> int:
        """Arms the boats and puts them into FORMATION, all hulls held; the tick when that was."""
        operator, boats = self._operator, self.boats
        begin_us = tick_us = now_us()
        ask_us = begin_us + 2_000_000
        while tick_us < begin_us + 1e6 * _PATIENCE_S:
            if tick_us >= ask_us:
                ask_us = tick_us + _RETRY_US
                ready = all(operator.armed.get(boat.system, False) for boat in boats)
                for boat in boats:
                    boat.radio.send(operator.arm(boat.system))
                    if ready:
                        boat.radio.send(operator.set_mode(boat.system, FORMATION))
            tick_us += self._h_us
            self._until(tick_us)
            self._send(tick_us)
            if all(operator.mode.get(boat.system) == FORMATION for boat in boats):
                return tick_us
            self._check_processes()
        words = [
            f"boat {boat.system}: {operator.text.get(boat.system, 'says nothing')}"
            for boat in boats
            if operator.mode.get(boat.system) != FORMATION
        ]
        raise StartError(f"not in FORMATION after {_PATIENCE_S:g} s: {'; '.join(words)}")

    def _check_processes(self) -> None:
        for boat in self.boats:
            if boat.process is not None and (status := boat.process.poll()) is not None:
                raise StartError(f"flotillad of boat {boat.system} left with status {status}")

    def _until(self, tick_us: int) -> None:
        """Takes what arrives until `tick_us`, when it arrives."""
        waiting = [fd for boat in self.boats for fd in boat.descriptors()]
        while True:
            t_us = now_us()
            for boat in self.boats:
                boat.listen(t_us, self._operator)
            self._leader.listen(t_us)
            left_us = tick_us - now_us()
            if left_us <= 0:
                self.late_us = max(self.late_us, -left_us)
                return
            select.select(waiting, [], [], 1e-6 * left_us)

    def _send(self, tick_us: int) -> None:
        """The state of the instant `tick_us` to everybody whom it concerns."""
        sensed = sensors.measure(self._fleet.eta, self._fleet.nu, self._sigma, self._sensor_rng)
        eta, nu = (array.tolist() for array in sensed)
        rpm = self._fleet.rpm.tolist()
        self._leader.send(tick_us, self._fleet.eta[0].tolist(), self._fleet.nu[0].tolist())
        for i, boat in enumerate(self.boats):
            boat.send(tick_us, eta[i + 1], nu[i + 1], rpm[i])


def build(say: Callable[[str], None]) -> Path:
    """The flotillad of this checkout, built where it is older than its sources."""
    if not (ROOT / "CMakeLists.txt").exists():
        return FLOTILLAD
    environment = {**os.environ, "PATH": f"{ROOT / '.venv' / 'bin'}:{os.environ['PATH']}"}
    for command in (
        ["cmake", "--preset", "release"],
        ["cmake", "--build", "--preset", "release", "--target", "flotillad"],
    ):
        done = subprocess.run(  # noqa: S603
            command, cwd=ROOT, env=environment, capture_output=True, text=True, check=False
        )
        if done.returncode != 0:
            say(done.stdout + done.stderr)
            raise StartError("flotillad could not be built")
    return FLOTILLAD
