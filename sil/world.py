# SPDX-License-Identifier: MIT
"""The lockstep world: a virtual clock, hulls, and every vessel ticked in turn in one thread.

The firmware learns nothing but what arrives as bytes; the hulls are moved by nothing but decoded
frames. At each tick time t the units send the state at t, the boats tick, leaders before their
followers, and the plant is carried to t + h under the commands that the ESCs then hold.
"""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from sil.bodies import fleet_of
from sil.clock import Clock
from sil.plant import sensors
from sil.plant.hull import Array
from sil.recording import Recorder
from sil.scenario import Scenario
from sil.streams import Stream, generator
from sil.trace import Tracer
from sil.vessel import VIRTUAL_LEADER_SYSTEM, Vessel, VirtualLeader
from sil.wire.link import Link
from sil.wire.operator import FORMATION, HOLD, Operator

Progress = Callable[[float], None]

_WARM_UP_S = 2.0
_PATIENCE_S = 30.0
_RETRY_S = 1.0


class StartError(RuntimeError):
    """The boats could not be armed or put into FORMATION; says which, and the boat's reason."""


@dataclass(frozen=True)
class Run:
    """What is left of a run: `trace` as in trace.npz, seconds in each state, digest."""

    trace: dict[str, Array]
    states: list[dict[str, float]]
    digest: str | None


def clocks_of(scenario: Scenario) -> list[Clock]:
    """A clock for every agent, as wrong as the scenario wants."""
    rng = generator(scenario.seed, Stream.CLOCKS)
    clocks = scenario.clocks
    return [
        Clock(
            round(1e6 * clocks.offset_s * rng.random()), clocks.drift_ppm * rng.uniform(-1.0, 1.0)
        )
        for _ in range(len(scenario.boat) + 1)
    ]


def parameters_of(scenario: Scenario, agent: int, overrides: dict[str, float]) -> dict[str, float]:
    """Firmware parameters of boat `agent`: its place, the scenario's, then `overrides`."""
    boat = scenario.boat[agent - 1]
    own = {
        "MAV_SYSID": agent,
        "FORM_LEADER": boat.follows or VIRTUAL_LEADER_SYSTEM,
        "FORM_OFS_N": boat.offset_m[0],
        "FORM_OFS_E": boat.offset_m[1],
        "CTL_RATE": scenario.rate_hz,
    }
    return {**own, **scenario.firmware_parameters(boat), **overrides}


class World:
    """One scenario, ready to be sailed once.

    `param_overrides` go to every boat, over what the scenario says. ValueError where the firmware
    refuses a parameter; it names the boat and the parameter.
    """

    def __init__(self, scenario: Scenario, param_overrides: dict[str, float]) -> None:
        self._scenario = scenario
        self._h_us = round(1e6 / scenario.rate_hz)
        self._sensor_rng = generator(scenario.seed, Stream.SENSORS)
        link_rng = generator(scenario.seed, Stream.LINKS)
        clocks = clocks_of(scenario)
        self._leader = VirtualLeader(scenario.leader_unit(), clocks[0])
        agents = range(1, len(scenario.boat) + 1)
        self._parameters = [parameters_of(scenario, agent, param_overrides) for agent in agents]
        self._boats = [
            Vessel(
                agent,
                self._parameters[agent - 1],
                scenario.scalar,
                navigation=scenario.boat_unit(scenario.boat[agent - 1]),
                clock=clocks[agent],
            )
            for agent in agents
        ]
        self._agents: list[VirtualLeader | Vessel] = [self._leader, *self._boats]
        for boat, vessel in zip(scenario.boat, self._boats, strict=True):
            leader = self._agents[boat.follows]
            for sender, receiver in ((leader, vessel), (vessel, leader)):
                link = Link(link_rng, **scenario.link.model_dump())
                sender.outbox.append(link)
                receiver.inbox.append(link)

        self._fleet = fleet_of(scenario)
        self._command: Array = np.zeros((len(self._boats), 2))
        self._sigma = scenario.navigation.noise.sigma

    def run(self, recording: Path, progress: Progress) -> Run:
        """Sails the scenario; writes `recording`, calls `progress` with the share that is done."""
        header = {"boats": [boat.header() for boat in self._boats]}
        with Recorder(recording, header) as recorder:
            for agent in self._agents:
                agent.record = recorder.record
            release_us = self._start()
            tracer = self._sail(release_us, progress)
            return Run(tracer.trace(), tracer.seconds(), recorder.digest())

    def _start(self) -> int:
        """Arms the boats and puts them into FORMATION, all hulls held; the time when that was."""
        operator = Operator()
        boats = self._boats
        ask_us = round(1e6 * _WARM_UP_S)
        for t_us in range(0, round(1e6 * _PATIENCE_S), self._h_us):
            if t_us >= ask_us:
                ask_us = t_us + round(1e6 * _RETRY_S)
                ready = all(operator.armed.get(boat.system, False) for boat in boats)
                for boat in boats:
                    boat.hear(t_us, operator.arm(boat.system))
                    if ready:
                        # All of them in one tick, or back to HOLD first and once more.
                        if operator.mode[boat.system] != HOLD:
                            boat.hear(t_us, operator.set_mode(boat.system, HOLD))
                        boat.hear(t_us, operator.set_mode(boat.system, FORMATION))
            self._tick(t_us)
            for boat in boats:
                operator.on_mavlink(boat.sent)
            if all(operator.mode.get(boat.system) == FORMATION for boat in boats):
                return t_us
        refusals = [
            f"boat {boat.system}: {operator.text.get(boat.system, 'says nothing')}"
            for boat in boats
            if operator.mode.get(boat.system) != FORMATION
        ]
        raise StartError(f"not in FORMATION after {_PATIENCE_S:g} s: {'; '.join(refusals)}")

    def _sail(self, release_us: int, progress: Progress) -> Tracer:
        """Releases the hulls and sails to the scenario's end."""
        tracer = Tracer(self._scenario, self._fleet, self._parameters)
        for k in range(tracer.ticks):
            if k > 0:  # the tick of the release has been
                self._tick(release_us + k * self._h_us)
            tracer.step(k, self._command, [boat.state for boat in self._boats])
            if k % 100 == 0:
                progress(k / tracer.ticks)
        progress(1.0)
        return tracer

    def _tick(self, t_us: int) -> None:
        """Everything that goes over a wire at `t_us`; the hulls stay where they are."""
        sensed = sensors.measure(self._fleet.eta, self._fleet.nu, self._sigma, self._sensor_rng)
        eta, nu = (array.tolist() for array in sensed)
        rpm = self._fleet.rpm.tolist()
        # The virtual leader knows its state: it is a reference, not a measurement.
        self._leader.tick(t_us, self._fleet.eta[0].tolist(), self._fleet.nu[0].tolist())
        for i, boat in enumerate(self._boats):
            self._command[i] = boat.tick(t_us, eta[i + 1], nu[i + 1], rpm[i])
        # What a follower says without delay reaches its leader at the same instant.
        for agent in self._agents:
            agent.listen(t_us)
