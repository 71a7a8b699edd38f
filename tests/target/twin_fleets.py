# SPDX-License-Identifier: MIT
"""`flotilla.Fleet` beside its reference: equal input must give equal output."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import Any

import flotilla
import numpy as np
from numpy.typing import NDArray

from sil.wire.heartbeat import FORMATION
from tests.target.reference_fleet import ReferenceFleet
from tests.target.stations import ARM, SET_MODE

H_US = 10_000
LOCAL = (100.0, "local", 0.0)
EXACT = (0, 0.0)

# Each boat of a diamond: the agent it follows (0 the virtual leader), north, east.
DIAMOND = ((0, 0.0, 0.0), (1, -2.0, 2.0), (1, -2.0, -2.0), (2, -2.0, -2.0))
# Surge and yaw of a small hull: its mass, damping, greatest thrust and lever arm of a propeller.
_MASS, _DAMPING = np.array((1.0, 0.35)), np.array((3.4, 0.86))
_THRUST_N, _ARM_M = 10.0, 0.25


class Twins:
    """Both fleets, and hulls moved by the first one's commands; compares at every step."""

    def __init__(self, scalar: str = "float") -> None:
        self.fleet: Any = flotilla.Fleet(scalar, record=True)
        self.reference = ReferenceFleet(scalar, record=True)
        self.t_us = 0
        self.leaders: list[int] = []
        self.boats: list[int] = []
        self.numbers: list[int] = []  # of each agent in its run
        self._runs: Counter[int] = Counter()
        self.eta: NDArray[np.float64] = np.zeros((0, 3))
        self.nu: NDArray[np.float64] = np.zeros((0, 3))
        self.commands: NDArray[np.float64] = np.zeros((0, 2))  # of the last tick

    def both(self, method: str, *arguments: Any, **named: Any) -> Any:
        """Call both; their equal result."""
        answers = [getattr(f, method)(*arguments, **named) for f in (self.fleet, self.reference)]
        assert answers[0] == answers[1], method
        return answers[0]

    def leader(self, run: int = 0, system: int = 100, unit: Any = LOCAL, clock: Any = EXACT) -> int:
        self.leaders.append(self.both("add_leader", run, system, unit, clock))
        self._place(run, 10.0, 5.0)
        return self.leaders[-1]

    def boat(
        self,
        parameters: dict[str, float],
        run: int = 0,
        unit: Any = LOCAL,
        clock: Any = EXACT,
        at: tuple[float, float] = (0.0, 0.0),
    ) -> int:
        self.boats.append(self.both("add_boat", run, parameters, unit, clock))
        self._place(run, *at)
        return self.boats[-1]

    def _place(self, run: int, north: float, east: float) -> None:
        self.numbers.append(self._runs[run])
        self._runs[run] += 1
        self.eta = np.vstack((self.eta, (north, east, 0.3)))
        self.nu = np.vstack((self.nu, (0.0, 0.0, 0.0)))

    def tie(self, one: int, other: int, **quality: float) -> list[int]:
        """A radio link each way."""
        ways = ((one, other), (other, one))
        return [
            self.both("connect", *way, **quality, seed=7 * self.numbers[way[0]] + i)
            for i, way in enumerate(ways)
        ]

    def diamond(
        self,
        run: int = 0,
        unit: Any = LOCAL,
        clock: Any = EXACT,
        east: float = 0.0,
        **quality: float,
    ) -> list[int]:
        """A leader, four boats behind it and their links, in this order; the links."""
        agents = [self.leader(run, unit=unit, clock=clock)]
        links = []
        for i, (follows, ahead, beside) in enumerate(DIAMOND, start=1):
            parameters = {
                "MAV_SYSID": i,
                "FORM_LEADER": follows or 100,
                "FORM_OFS_N": ahead,
                "FORM_OFS_E": beside,
            }
            own_clock = (clock[0] * i, clock[1] * (-1) ** i)
            agents.append(self.boat(parameters, run, unit, own_clock, (ahead, east + 2 * beside)))
            links += self.tie(agents[follows], agents[-1], **quality)
        return links

    def tick(self, ticks: int = 1) -> None:
        """Tick both, and move the hulls under their commands."""
        for _ in range(ticks):
            eta, nu, degE7, rpm = self._sensed()
            commands = np.full((2, len(self.boats), 2), np.nan)
            for fleet, command in zip((self.fleet, self.reference), commands, strict=True):
                fleet.tick(self.t_us, eta, nu, degE7, rpm, command)
            assert np.array_equal(*commands), self.t_us
            assert np.array_equal(self.fleet.states, self.reference.states), self.t_us
            for agent in range(len(self.eta)):
                self.both("sent", agent)
            self.commands = commands[0]
            self._move(self.commands)
            self.t_us += H_US

    def _sensed(self) -> tuple[Any, ...]:
        degE7 = np.array([487_000_000, 22_950_000]) + 90.0 * self.eta[:, :2]
        phase = np.array(self.numbers)[self.boats, np.newaxis] + (0.0, 0.5)
        rpm = 700.0 * np.sin(1e-6 * self.t_us + phase)
        return self.eta, self.nu, degE7.astype(np.int32), rpm

    def _move(self, command: NDArray[np.float64]) -> None:
        h, t = 1e-6 * H_US, 1e-6 * self.t_us
        for agent in self.leaders:
            self.nu[agent] = (0.4, 0.05 * np.sin(t), 0.2 * np.cos(0.3 * t))
        force = _THRUST_N * np.column_stack(
            (command.sum(axis=1), _ARM_M * (command[:, 0] - command[:, 1]))
        )
        boats = self.nu[self.boats]
        boats[:, ::2] += h * (force - _DAMPING * boats[:, ::2]) / _MASS
        self.nu[self.boats] = boats
        c, s = np.cos(self.eta[:, 2]), np.sin(self.eta[:, 2])
        u, v, r = self.nu.T
        self.eta += h * np.column_stack((c * u - s * v, s * u + c * v, r))

    def enter_formation(self, boats: Sequence[int] | None = None) -> None:
        """Arm the boats and put them into FORMATION; takes some seconds."""
        boats = self.boats if boats is None else boats
        self.tick(200)
        self.both("command", boats, self.t_us, ARM, (1.0,))
        self.tick(120)
        self.both("command", boats, self.t_us, SET_MODE, (1.0, FORMATION))
        self.tick(2)

    def on_bus(self, frames: Sequence[tuple[int, bytes]]) -> None:
        """Frames on the first boat's bus."""
        for can_id, data in frames:
            self.both("on_can", self.boats[0], can_id, data, self.t_us)

    def state(self, boat: int) -> str:
        name: str = flotilla.STATES[self.fleet.states[self.boats.index(boat)]]
        return name

    def compare(self, run: int = 0) -> bytes:
        """Compare the run's records since the last call, and every boat's snapshot."""
        records: bytes = self.both("take_records", run)
        for boat in self.boats:
            self.both("snapshot", boat)
            self.both("parameters", boat)
        return records


def alone() -> Twins:
    """One boat without any input."""
    twins = Twins()
    twins.boat({"MAV_SYSID": 1})
    return twins


def in_formation() -> Twins:
    """Four boats whose propellers turn."""
    twins = Twins()
    twins.diamond()
    twins.enter_formation()
    twins.tick(100)
    return twins
