# SPDX-License-Identifier: MIT
"""The live world: real flotillad processes on a real bus, hulls and ESCs in real time.

Each boat has a flotillad, a CAN bus and two UDP links: to its navigation unit and its radio. This
process is everything else: hulls, navigation units, ESCs, the virtual leader, the radio between
them all, and the operator. It processes input as it arrives. At each control tick it steps the
hulls and sends their state, stamped with the time of the tick.
"""

import select
import subprocess
import time
from collections.abc import Callable
from contextlib import ExitStack
from functools import partial
from pathlib import Path

import flotilla
import numpy as np

from sil import ROOT
from sil.live.live_vessel import LiveBoat, LiveLeader
from sil.live.tcp_door import Door, TcpDoor
from sil.lockstep.start import StartError
from sil.lockstep.trace import Tracer
from sil.lockstep.world import Progress
from sil.plant.hull import Array
from sil.plant.sensors import Sensors
from sil.scenario.agents import clocks_of, parameters_of, slots_of
from sil.scenario.fleet_bodies import bodies_of
from sil.scenario.scenario import Scenario
from sil.scenario.streams import SENSOR_STREAMS, Stream, generator
from sil.scenario.told_plan import items_of
from sil.scenario.virtual_leaders import VirtualLeaders
from sil.wire.heartbeat import AUTO, FORMATION, HOLD
from sil.wire.link import Link
from sil.wire.mavlink_mcast import Mouth
from sil.wire.operator import Operator, plan_upload, start_requests
from sil.wire.plan_upload import PlanUpload

IS_CLONE = (ROOT / "CMakeLists.txt").exists()
FLOTILLAD = ROOT / ("build/release/firmware" if IS_CLONE else "bin") / "flotillad"

_PATIENCE_S = 30.0
_LAST_MCAST_BUS = 9
_RETRY_US = 500_000
_WARM_UP_US = 2_000_000
_TCP_STEP = 10
_NOT_ARMED = (None, "DISARMED", "FAULT")


def now_us() -> int:
    """The world's time, us: the monotonic clock, which flotillad reads too."""
    return time.monotonic_ns() // 1000


def buses_of(first: str, boats: int) -> list[str]:
    """Addresses of the boats' buses: `first` for boat 1, the next number for each further boat.

    ValueError unless `first` is mcast:N or socketcan:NAMEn.
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
    last = number + boats - 1
    if scheme == "mcast" and last > _LAST_MCAST_BUS:
        raise ValueError(
            f'--bus "{first}": {boats} boats need mcast:{number} to mcast:{last}, '
            f"but mcast:{_LAST_MCAST_BUS} is the last one"
        )
    return [f"{scheme}:{name}{number + i}" for i in range(boats)]


class LiveWorld:
    """One scenario, ready to be sailed once in real time. A context manager.

    `bus`: address of boat 1's bus. `mavlink`: address to which all radio traffic is repeated, as
    for `sil.wire.mavlink_mcast.Mouth`; None: nowhere. `gcs`: the ground station with which every
    boat has a link of its own, udpout:HOST:PORT. `tcp_from`: TCP port of boat 1 on this machine;
    each further boat's is 10 higher; None: none. ValueError for an invalid address; can.CanError or
    OSError if it cannot be opened.
    """

    def __init__(
        self,
        scenario: Scenario,
        bus: str,
        param_overrides: dict[str, float],
        mavlink: str | None = None,
        gcs: str | None = None,
        tcp_from: int | None = None,
    ) -> None:
        if gcs is not None and not gcs.startswith("udpout:"):
            raise ValueError(f'--gcs "{gcs}": must be udpout:HOST:PORT')
        self._scenario = scenario
        self._gcs = [] if gcs is None else [gcs]
        link_rng = generator(scenario.seed, Stream.LINKS)
        clocks = clocks_of(scenario)
        self._parameters = parameters_of(scenario, param_overrides)
        self._command: Array = np.zeros((len(scenario.boat), 2))
        self._leader_boat = scenario.leader.boat
        led = {0: self._parameters[self._leader_boat - 1]} if self._leader_boat else {}
        self._leaders = VirtualLeaders([scenario], led)
        self._bodies = bodies_of([scenario])
        self._sensors = Sensors(
            [scenario.navigation.noise],
            [[generator(scenario.seed, stream)] for stream in SENSOR_STREAMS],
            self._bodies,
            1.0 / scenario.rate_hz,
        )
        self._h_us = round(1e6 / scenario.rate_hz)
        self._operator = Operator()
        self._leader = LiveLeader(scenario.leader_unit(), clocks[0])
        self.late_us = 0
        self.release_unix_s = 0.0
        with ExitStack() as opened:
            mouths = [Mouth(address) for address in (mavlink,) if address is not None]
            for mouth in mouths:
                opened.callback(mouth.close)
            self.boats: list[LiveBoat] = []
            for agent, address in enumerate(buses_of(bus, len(scenario.boat)), start=1):
                own = self._parameters[agent - 1]
                self.boats.append(LiveBoat(scenario, agent, address, own, clocks[agent]))
                opened.callback(self.boats[-1].close)
            self._tcp: list[TcpDoor] = []
            for i, boat in enumerate(self.boats if tcp_from is not None else []):
                self._tcp.append(TcpDoor(boat.system, (tcp_from or 0) + _TCP_STEP * i))
                opened.callback(self._tcp[-1].close)
            self._opened = opened.pop_all()
        agents: list[LiveLeader | LiveBoat] = [self._leader, *self.boats]
        self._plan: PlanUpload | None = None
        if self._leader_boat is not None:
            self._plan = plan_upload(self._leader_boat, items_of(scenario.leader))
            hear_plan = partial(self._leaders.hear, 0)
            self.boats[self._leader_boat - 1].ears += [self._plan.on_mavlink, hear_plan]
        for pair in scenario.pairs():
            ends = [agents[agent] for agent in pair]
            for sender, receiver in (ends, ends[::-1]):
                link = Link(link_rng, **scenario.link.quality)
                sender.outbox.append(link)
                receiver.inbox.append(link)
        self._mouths = mouths
        for vessel in agents:
            vessel.outbox += mouths

    def doors(self) -> list[Door]:
        """The boats' TCP ports."""
        return [each.door for each in self._tcp]

    def __enter__(self) -> "LiveWorld":
        return self

    def __exit__(self, *_: object) -> None:
        self._opened.close()

    def run(self, program: Path, out: Path, progress: Progress) -> Tracer:
        """Start the boats' processes, sail the scenario, return the motion since the release."""
        for i, boat in enumerate(self.boats):
            folder = out / f"boat{boat.system}"
            boat.more_links += [*self._gcs, *(door.address for door in self._tcp[i : i + 1])]
            boat.start(program, folder, f"--log={folder / 'log'}")
        tick_us = self._start()
        self.release_unix_s = time.time() + 1e-6 * (tick_us - now_us())
        tracer = Tracer([self._scenario], self._bodies, [slots_of(self._parameters)])
        for k in range(tracer.ticks):
            for i, boat in enumerate(self.boats):
                self._command[i] = boat.command(tick_us)
            told = self._operator.state
            states = [flotilla.STATES.index(told[boat.system]) for boat in self.boats]
            self._leaders.advance(k, self._bodies, self._command, tick_us)
            tracer.note(k, np.array(states, np.uint8))
            tick_us += self._h_us
            self._until(tick_us)
            self._send(tick_us)
            if k % 100 == 0:
                self._check_processes()
                progress(k / tracer.ticks)
        progress(1.0)
        return tracer

    def _start(self) -> int:
        """Arm the boats and set their modes while the hulls are held; return the last tick (us)."""
        operator, boats = self._operator, self.boats
        begin_us = tick_us = now_us()
        ask_us = begin_us + _WARM_UP_US
        while tick_us < begin_us + 1e6 * _PATIENCE_S:
            if tick_us >= ask_us:
                ask_us = tick_us + _RETRY_US
                ready = not any(operator.state.get(boat.system) in _NOT_ARMED for boat in boats)
                for boat, parameters in zip(boats, self._parameters, strict=True):
                    slow_Hz = parameters.get("SR_SLOW", 1.0)
                    mode = self._mode_of(boat.system)
                    for request in start_requests(slow_Hz, ready, holds=True, mode=mode):
                        boat.radio.send(operator.ask(boat.system, request))
            if tick_us >= begin_us + _WARM_UP_US:
                self._send_plan(tick_us)
            tick_us += self._h_us
            self._until(tick_us)
            self._send(tick_us)
            if all(operator.state.get(boat.system) == self._wanted(boat.system) for boat in boats):
                return tick_us
            self._check_processes()
        words = [
            f"boat {boat.system}: {operator.text.get(boat.system, 'no STATUSTEXT received')}"
            for boat in boats
            if operator.state.get(boat.system) != self._wanted(boat.system)
        ]
        if self._plan is not None and self._plan.fault:
            words.append(f"the plan: {self._plan.fault}")
        raise StartError(f"not in the wanted mode after {_PATIENCE_S:g} s: {'; '.join(words)}")

    def _send_plan(self, t_us: int) -> None:
        """The operator's messages about the plan, which listeners of the radio hear too."""
        if self._plan is None or self._leader_boat is None:
            return
        if data := self._plan.say(t_us):
            self.boats[self._leader_boat - 1].radio.send(data)
            for mouth in self._mouths:
                mouth.send(data, t_us)

    def _wanted(self, system: int) -> str:
        """The state in which a boat counts as ready."""
        return "AUTO" if system == self._leader_boat else "FORMATION"

    def _mode_of(self, system: int) -> int:
        """The mode to request of a boat: AUTO once it has its plan and all others follow."""
        if self._plan is None or system != self._leader_boat:
            return FORMATION
        others = [boat.system for boat in self.boats if boat.system != system]
        formed = all(self._operator.state.get(other) == "FORMATION" for other in others)
        return AUTO if formed and self._plan.done else HOLD

    def _check_processes(self) -> None:
        for boat in self.boats:
            if boat.process is not None and (status := boat.process.poll()) is not None:
                raise StartError(f"boat {boat.system}: {boat.last_words(status)}")

    def _until(self, tick_us: int) -> None:
        """Process input as it arrives until `tick_us`."""
        ends: list[LiveBoat | TcpDoor] = [*self.boats, *self._tcp]
        while True:
            t_us = now_us()
            for boat in self.boats:
                boat.listen(t_us, self._operator)
            self._leader.listen(t_us)
            for door in self._tcp:
                door.pass_on()
            left_us = tick_us - now_us()
            if left_us <= 0:
                self.late_us = max(self.late_us, -left_us)
                return
            # rebuilt each time: a client that has left closes its descriptor
            waiting = [fd for end in ends for fd in end.descriptors()]
            select.select(waiting, [], [], 1e-6 * left_us)

    def _send(self, tick_us: int) -> None:
        """Measure and send each vessel's state, stamped `tick_us`."""
        self._sensors.measure()
        eta, nu = self._sensors.eta.tolist(), self._sensors.nu.tolist()
        rpm = self._bodies.rpm.tolist()
        self._leader.send(tick_us, eta[0], nu[0])
        for i, boat in enumerate(self.boats):
            boat.send(tick_us, eta[i + 1], nu[i + 1], rpm[i])


def build(say: Callable[[str], None]) -> Path:
    """Path of flotillad; in a clone, rebuilt if older than its sources; StartError."""
    if not IS_CLONE:
        if not FLOTILLAD.exists():
            raise StartError("this wheel has no flotillad: live runs need Linux")
        return FLOTILLAD
    command = [str(ROOT / "tools" / "build"), "release", "flotillad"]
    if not FLOTILLAD.exists():
        say("building flotillad: the first time, this takes minutes")
    done = subprocess.run(command, capture_output=True, text=True, check=False)  # noqa: S603
    if done.returncode != 0:
        say(done.stdout + done.stderr)
        raise StartError("flotillad could not be built; see the compiler's output above")
    return FLOTILLAD
