# SPDX-License-Identifier: MIT
"""The lockstep world: a virtual clock, hulls, and every vessel ticked in turn in one thread.

The firmware learns nothing but what arrives as bytes; the hulls are moved by nothing but decoded
frames. At each tick time t the units send the state at t, the boats tick, leaders before their
followers, and the plant is carried to t + h under the commands that the ESCs then hold.
"""

from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from sil import metrics
from sil.clock import Clock
from sil.plant import hull, propeller, sensors
from sil.plant.hull import Array
from sil.recording import Recorder
from sil.scenario import Scenario
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
    digest: str


class World:
    """One scenario, ready to be sailed once.

    `param_overrides` go to every boat, over what the scenario says. ValueError where the firmware
    refuses a parameter; it names the boat and the parameter.
    """

    def __init__(self, scenario: Scenario, param_overrides: dict[str, float]) -> None:
        self._scenario = scenario
        self._h_us = round(1e6 / scenario.rate_hz)
        seeds = np.random.SeedSequence(scenario.seed).spawn(3)
        clock_rng, self._sensor_rng, link_rng = (np.random.default_rng(seed) for seed in seeds)

        clocks = [self._clock(clock_rng) for _ in range(len(scenario.boat) + 1)]
        rate_hz = scenario.navigation.rate_hz
        self._leader = VirtualLeader(rate_hz, clocks[0])
        self._boats = [
            Vessel(
                agent,
                self._parameters(agent, param_overrides),
                scenario.scalar,
                navigation_rate_hz=rate_hz,
                navigation_message=scenario.navigation.message,
                clock=clocks[agent],
            )
            for agent in range(1, len(scenario.boat) + 1)
        ]
        self._agents: list[VirtualLeader | Vessel] = [self._leader, *self._boats]
        for boat, vessel in zip(scenario.boat, self._boats, strict=True):
            leader = self._agents[boat.follows]
            for sender, receiver in ((leader, vessel), (vessel, leader)):
                link = Link(link_rng, **scenario.link.model_dump())
                sender.outbox.append(link)
                receiver.inbox.append(link)

        self._eta = np.array([scenario.leader.eta, *(boat.eta for boat in scenario.boat)])
        self._nu = np.array([scenario.leader.nu, *(boat.nu for boat in scenario.boat)])
        self._hulls = hull.stack(scenario.hulls())
        self._propellers = propeller.stack(scenario.propeller_pairs())
        n = len(self._boats)
        self._thrust = np.zeros((n, 2))
        self._rpm = np.zeros((n, 2))
        self._command = np.zeros((n, 2))
        self._tau = np.zeros((3, n + 1, 2))
        self._no_force = np.zeros((n + 1, 3))
        self._sigma = scenario.navigation.noise.sigma

    def run(self, recording: Path, progress: Progress) -> Run:
        """Sails the scenario; writes `recording`, calls `progress` with the share that is done."""
        header = {"boats": [boat.header() for boat in self._boats]}
        with Recorder(recording, header) as recorder:
            for agent in self._agents:
                agent.record = recorder.record
            release_us = self._start()
            trace, states = self._sail(release_us, progress)
            return Run(trace, states, recorder.digest())

    def _clock(self, rng: np.random.Generator) -> Clock:
        clocks = self._scenario.clocks
        offset_us = round(1e6 * clocks.offset_s * rng.random())
        return Clock(offset_us, clocks.drift_ppm * rng.uniform(-1.0, 1.0))

    def _parameters(self, agent: int, overrides: dict[str, float]) -> dict[str, float]:
        boat = self._scenario.boat[agent - 1]
        own = {
            "MAV_SYSID": agent,
            "FORM_LEADER": boat.follows or VIRTUAL_LEADER_SYSTEM,
            "FORM_OFS_N": boat.offset_m[0],
            "FORM_OFS_E": boat.offset_m[1],
            "CTL_RATE": self._scenario.rate_hz,
        }
        return {**own, **self._scenario.firmware_parameters(boat), **overrides}

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

    def _sail(
        self, release_us: int, progress: Progress
    ) -> tuple[dict[str, Array], list[dict[str, float]]]:
        """Releases the hulls and sails to the scenario's end: trace, seconds in each state."""
        scenario = self._scenario
        h_s = 1e-6 * self._h_us
        ticks = round(scenario.duration_s / h_s) + 1
        t_s: Array = np.arange(ticks, dtype=np.float64) * np.float64(h_s)
        reference = scenario.leader.tau(t_s[:, None] + np.array([0.0, 0.5 * h_s, h_s]))
        agents = len(self._boats) + 1
        eta, nu = np.empty((ticks, agents, 3)), np.empty((ticks, agents, 3))
        tau = np.empty((ticks, agents - 1, 2))
        states: list[Counter[str]] = [Counter() for _ in self._boats]
        for k in range(ticks):
            if k > 0:  # the tick of the release has been
                self._tick(release_us + k * self._h_us)
            eta[k], nu[k] = self._eta, self._nu
            self._advance(reference[k], h_s)
            tau[k] = self._tau[0, 1:]
            for count, boat in zip(states, self._boats, strict=True):
                count[boat.state] += 1
            if k % 100 == 0:
                progress(k / ticks)
        progress(1.0)
        follows = [boat.follows for boat in scenario.boat]
        offset_m = np.array([boat.offset_m for boat in scenario.boat])
        half_yaw = 0.5 * tau[..., 1] / self._propellers[:, 0]
        thrust = np.stack([0.5 * tau[..., 0] + half_yaw, 0.5 * tau[..., 0] - half_yaw], axis=-1)
        trace: dict[str, Array] = {
            "t_s": t_s,
            "eta": eta,
            "nu": nu,
            "error": metrics.formation_error(eta, follows, offset_m),
            "tau": tau,
            "thrust": thrust,
        }
        return trace, [{name: n * h_s for name, n in count.items()} for count in states]

    def _tick(self, t_us: int) -> None:
        """Everything that goes over a wire at `t_us`; the hulls stay where they are."""
        sensed = sensors.measure(self._eta, self._nu, self._sigma, self._sensor_rng)
        eta, nu = (array.tolist() for array in sensed)
        rpm = self._rpm.tolist()
        # The virtual leader knows its state: it is a reference, not a measurement.
        self._leader.tick(t_us, self._eta[0].tolist(), self._nu[0].tolist())
        for i, boat in enumerate(self._boats):
            self._command[i] = boat.tick(t_us, eta[i + 1], nu[i + 1], rpm[i])
        # What a follower says without delay reaches its leader at the same instant.
        for agent in self._agents:
            agent.listen(t_us)

    def _advance(self, reference: Array, h_s: float) -> None:
        """Carries propellers and hulls over one step; `reference` (3, 2): agent 0's input."""
        propeller.advance(self._thrust, self._command, self._tau[:, 1:], self._propellers, h_s)
        propeller.shaft_speed(self._thrust, self._propellers, self._rpm)
        self._tau[:, 0] = reference
        hull.advance(self._eta, self._nu, self._tau, self._no_force, self._hulls, h_s)
