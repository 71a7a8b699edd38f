# SPDX-License-Identifier: MIT
"""The reference of the lockstep world, of Python classes and a loop: slow, one run, easy to change.

`sil.lockstep.world` must equal it byte for byte; tests replace units and ESCs in it.
"""

import flotilla
import numpy as np

from sil.lockstep.trace import Tracer
from sil.lockstep.world import Run
from sil.scenario.agents import clocks_of, parameters_of, slots_of
from sil.scenario.fleet_bodies import bodies_of
from sil.scenario.scenario import Scenario
from sil.scenario.streams import Stream, generator
from sil.scenario.virtual_leaders import VirtualLeaders
from sil.wire.link import Link
from sil.wire.operator import Operator, start_requests
from tests.loop.vessel import Vessel, VirtualLeader
from tests.target.reference_fleet import SplitMix64

Record = tuple[int, int, bytes]


class ObjectWorld:
    """One scenario, to be sailed once; `records`: everything on the wires."""

    def __init__(self, scenario: Scenario) -> None:
        self.records: list[Record] = []
        self.scenario = scenario
        self.h_us = round(1e6 / scenario.rate_hz)
        self.parameters = parameters_of(scenario, {})
        clocks = clocks_of(scenario)
        self.leader = VirtualLeader(scenario.leader_unit(), clocks[0])
        self.boats = [
            Vessel(
                agent,
                self.parameters[agent - 1],
                scenario.scalar,
                navigation=scenario.boat_unit(boat),
                clock=clocks[agent],
            )
            for agent, boat in enumerate(scenario.boat, start=1)
        ]
        self.agents: list[VirtualLeader | Vessel] = [self.leader, *self.boats]
        for agent in self.agents:
            agent.record = lambda *record: self.records.append(record)
        seeds = generator(scenario.seed, Stream.LINKS)
        for pair in scenario.pairs():
            ends = [self.agents[agent] for agent in pair]
            for sender, receiver in (ends, ends[::-1]):
                rng = SplitMix64(int(seeds.integers(1 << 64, dtype=np.uint64)))
                link = Link(rng, **scenario.link.quality)
                sender.outbox.append(link)
                receiver.inbox.append(link)
        self.bodies = bodies_of([scenario])
        self.sigma = scenario.navigation.noise.sigma
        self.rng = generator(scenario.seed, Stream.SENSORS)
        self.command = np.zeros((len(self.boats), 2))

    def run(self) -> Run:
        release_us = self.start()
        tracer = Tracer([self.scenario], self.bodies, [slots_of(self.parameters)])
        leaders = VirtualLeaders([self.scenario])
        for k in range(tracer.ticks):
            if k > 0:
                self.tick(release_us + k * self.h_us)
            states = [flotilla.STATES.index(boat.state) for boat in self.boats]
            leaders.advance(k, self.bodies, self.command)
            tracer.note(k, np.array(states, np.uint8))
        return Run(tracer.trace(0), tracer.seconds(0), None)

    def start(self) -> int:
        operator = Operator()
        for t_us in range(0, 30_000_000, self.h_us):
            if t_us >= 2_000_000 and t_us % 1_000_000 < self.h_us:
                states = [boat.state for boat in self.boats]
                for boat, state in zip(self.boats, states, strict=True):
                    slow_Hz, armed = boat.parameters["SR_SLOW"], "DISARMED" not in states
                    for request in start_requests(slow_Hz, armed, state == "HOLD"):
                        boat.hear(t_us, operator.ask(boat.system, request))
            self.tick(t_us)
            if all(boat.state == "FORMATION" for boat in self.boats):
                return t_us
        raise AssertionError([boat.state for boat in self.boats])

    def tick(self, t_us: int) -> None:
        eta, nu = self.bodies.eta, self.bodies.nu
        measured = eta, nu
        if self.sigma.any():
            noise = self.rng.standard_normal((2, *eta.shape))
            measured = eta + self.sigma[0] * noise[0], nu + self.sigma[1] * noise[1]
        self.leader.tick(t_us, eta[0].tolist(), nu[0].tolist())
        eta_m, nu_m = (array[1:].tolist() for array in measured)
        rpm = self.bodies.rpm.tolist()
        for i, boat in enumerate(self.boats):
            self.command[i] = boat.tick(t_us, eta_m[i], nu_m[i], rpm[i])
        for agent in self.agents:
            agent.listen(t_us)
