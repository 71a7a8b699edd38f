# SPDX-License-Identifier: MIT
"""Runs of one shape, sailed together: one flotilla.Fleet holds all their boats and wires.

The firmware's only input are bytes; only decoded frames move the hulls. At each tick time t the
units send the state at t, the boats tick, leaders before their followers, and the plant advances to
t + h under the ESCs' commands of that time.
"""

from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

import flotilla
import numpy as np

from sil.lockstep.recording import Recorder
from sil.lockstep.trace import States
from sil.plant.hull import Array
from sil.plant.sensors import Sensors
from sil.scenario.agents import clocks_of, parameters_of, slots_of, units_of
from sil.scenario.fleet_bodies import bodies_of
from sil.scenario.reported_places import Told
from sil.scenario.scenario import Scenario
from sil.scenario.streams import SENSOR_STREAMS, Stream, generator
from sil.scenario.wiring import VIRTUAL_LEADER_SYSTEM

# Ticks between two collections of a fleet's records, to limit memory.
_TAKE = 32
_GCS_US = 1_000_000


class Batch:
    """R independent runs of N boats each, ready to be sailed once.

    Agents of `fleet` are the rows of `bodies`: the virtual leaders, then the boats, run by run.
    `command` (R N, 2): the ESCs' commands to their motors in the last tick. `sensors`: of all
    agents. `without_gcs`: agents whose ground station is silent; others with FS_GCS_S hear one.
    `recorders`: one per run; set them to record. ValueError if the firmware refuses a parameter.
    """

    def __init__(
        self,
        scenarios: Sequence[Scenario],
        param_overrides: dict[str, float],
        *,
        record: bool = False,
        profile: bool = False,
        inject_failures: bool = False,
    ) -> None:
        first = scenarios[0]
        self.scenarios = scenarios
        self.boats = len(first.boat)
        self.h_us = round(1e6 / first.rate_hz)
        self.fleet = flotilla.Fleet(
            scalar=first.scalar, record=record, profile=profile, inject_failures=inject_failures
        )
        self.recorders: list[Recorder] = []
        self._ticks = 0
        self._units = [units_of(one) for one in scenarios]
        self._clocks = [clocks_of(one) for one in scenarios]
        boats = [unit for run in self._units for unit in run[1:]]
        self._told = Told([*(run[0] for run in self._units), *boats])
        for run in range(len(scenarios)):
            unit, clock = self._aboard(run, 0)
            self.fleet.add_leader(run, VIRTUAL_LEADER_SYSTEM, unit, clock)
        self.slots: list[Array] = []
        self.without_gcs: set[int] = set()
        self._gcs: list[int] = []
        for run, scenario in enumerate(scenarios):
            parameters = parameters_of(scenario, param_overrides)
            for agent, own in enumerate(parameters, start=1):
                self.fleet.add_boat(run, own, *self._aboard(run, agent))
            self.slots.append(slots_of(parameters))
            self._connect(run, scenario)
            # Boats with a ground station timeout (FS_GCS_S) get a ground station.
            waits = zip(self.agents(run), parameters, strict=True)
            self._gcs += [agent for agent, own in waits if own.get("FS_GCS_S", 0.0) > 0.0]
        self.bodies = bodies_of(scenarios)
        self.command: Array = np.zeros((len(scenarios) * self.boats, 2))
        self.sensors = Sensors(
            [one.navigation.noise for one in scenarios],
            [[generator(one.seed, stream) for one in scenarios] for stream in SENSOR_STREAMS],
            self.bodies,
            1e-6 * self.h_us,
        )

    def _aboard(self, run: int, agent: int) -> tuple[Any, Any]:
        """Unit and clock of a run's agent, as arguments of flotilla.Fleet."""
        unit, clock = self._units[run][agent], self._clocks[run][agent]
        origin = self._told.origins[self.row(run, agent)]
        faults = (unit.delay_s, unit.timesync, unit.dropout_every_s, unit.dropout_s)
        told = (unit.rate_hz, unit.message, unit.attitude_rate_hz, origin, faults)
        return told, (clock.offset_us, clock.drift_ppm)

    def _connect(self, run: int, scenario: Scenario) -> None:
        rng = generator(scenario.seed, Stream.LINKS)
        for pair in scenario.pairs():
            ends = [self.row(run, agent) for agent in pair]
            for sender, receiver in (ends, ends[::-1]):
                seed = int(rng.integers(1 << 64, dtype=np.uint64))
                self.fleet.connect(sender, receiver, **scenario.link.quality, seed=seed)

    def row(self, run: int, agent: int) -> int:
        """The fleet's index of a run's agent."""
        return run if agent == 0 else len(self.scenarios) + run * self.boats + agent - 1

    def agents(self, run: int) -> range:
        """The fleet's indices of a run's boats."""
        begin = self.row(run, 1)
        return range(begin, begin + self.boats)

    def leading(self, run: int) -> int:
        """The fleet's index of the boat that leads a run; it must have one."""
        boat = self.scenarios[run].leader.boat
        assert boat is not None
        return self.row(run, boat)

    @property
    def led(self) -> list[int]:
        """Runs in which a boat leads."""
        return [run for run, one in enumerate(self.scenarios) if one.leader.boat is not None]

    def header(self, run: int) -> dict[str, Any]:
        """The recording's header, from which a replay builds the boats of a run."""
        boats = [
            {
                "parameters": self.fleet.parameters(agent),
                "links": 2,
                "scalar": self.scenarios[run].scalar,
                "clock": asdict(clock),
            }
            for agent, clock in zip(self.agents(run), self._clocks[run][1:], strict=True)
        ]
        return {"boats": boats}

    @property
    def states(self) -> States:
        """States (R, N) after the last tick, as indices of `flotilla.STATES`."""
        states: States = self.fleet.states
        return states.reshape(-1, self.boats)

    def tick(self, t_us: int) -> None:
        """Exchange all messages of the tick `t_us`; does not move the hulls."""
        self.sensors.measure()
        eta = self._told.poses(self.sensors.eta)
        told = (eta, self.sensors.nu, self._told.degE7)
        if self._gcs and t_us % _GCS_US < self.h_us:
            self.fleet.heartbeat([a for a in self._gcs if a not in self.without_gcs], t_us)
        self.fleet.tick(t_us, *told, self.bodies.rpm, self.command)
        self._ticks += 1
        if self.recorders and self._ticks % _TAKE == 0:
            self.take()

    def take(self) -> None:
        """Pass the collected records to the recorders."""
        for run, recorder in enumerate(self.recorders):
            recorder.write(self.fleet.take_records(run))
