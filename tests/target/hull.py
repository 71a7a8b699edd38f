# SPDX-License-Identifier: MIT
"""A boat that moves under its own thrust, in moving water: the paper's vessel (eq:1)."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from tests.target.agent import START_US, Agent
from tests.target.bus import FULL_SCALE
from tests.target.course import Course, wrap
from tests.target.sea import Sea, Tick
from tests.target.stations import BOAT, LEADER, LEADER_COMPONENT, NAVIGATION, Station

M11, M22, M33, D11, D22, D33 = 1.012, 1.982, 0.354, 3.436, 18.99, 0.864
ARM_M, GREATEST_N = 0.25, 20.0  # of each propeller

#: Surge force and yaw moment, N and N m, at a time in s.
Thrusting = Callable[[float], tuple[float, float]]


def s_curve(t_s: float) -> tuple[float, float]:
    """The input of the paper's leader."""
    return 2.0, 0.3 * math.sin(0.3 * t_s)


def wrench(commands: tuple[int, ...]) -> tuple[float, float]:
    """Surge force and yaw moment, N and N m, of raw commands (port, starboard)."""
    port, stbd = (GREATEST_N * command / FULL_SCALE for command in commands)
    return port + stbd, ARM_M * (port - stbd)


@dataclass
class Hull:
    """q: x, y (m) and ψ (rad) over ground; u, v (m/s) and r (rad/s) relative to the water."""

    q: list[float] = field(default_factory=lambda: [0.0] * 6)
    current: tuple[float, float] = (0.0, 0.0)  # north, east, m/s
    push: tuple[float, float] = (0.0, 0.0)  # N and N m, unknown to the boat

    def rates(self, q: list[float], X: float, N: float) -> list[float]:
        _, _, psi, u, v, r = q
        c, s = math.cos(psi), math.sin(psi)
        return [
            c * u - s * v + self.current[0],
            s * u + c * v + self.current[1],
            r,
            (X + M22 * v * r - D11 * u) / M11,
            (-M11 * u * r - D22 * v) / M22,
            (N - (M22 - M11) * u * v - D33 * r) / M33,
        ]

    def advance(self, X: float, N: float, h: float) -> None:
        """Integrate by the midpoint method with constant wrench."""
        X, N = X + self.push[0], N + self.push[1]
        half = [x + h / 2 * k for x, k in zip(self.q, self.rates(self.q, X, N), strict=True)]
        self.q = [x + h * k for x, k in zip(self.q, self.rates(half, X, N), strict=True)]

    @property
    def seen(self) -> Course:
        """The state over ground, as a navigation unit measures it."""
        x, y, psi, u, v, r = self.q
        c, s = math.cos(psi), math.sin(psi)
        north, east = self.current
        return Course(x, y, wrap(psi), u + c * north + s * east, v + c * east - s * north, r)


@dataclass
class Helmsman(Agent):
    """A sender whose state is that of a hull."""

    hull: Hull = field(default_factory=Hull)

    def truth(self, now_us: int) -> Course:
        return self.hull.seen


class Afloat(Sea):
    """A sea whose boat and leader move under their own thrust."""

    def __init__(
        self,
        parameters: dict[str, float] | None = None,
        hull: Hull | None = None,
        leader: Thrusting | Course | None = None,
        own_period_us: int = 50_000,
        **how: Any,
    ) -> None:
        course = leader if isinstance(leader, Course) else None
        super().__init__(parameters, leader=course, **how)
        self.hull = hull or Hull()
        self.own = Helmsman(
            Station(BOAT, NAVIGATION),
            Course(),
            own_period_us,
            beats=False,
            tells_fix=True,
            hull=self.hull,
        )
        self.thrusting = leader if callable(leader) else None
        if self.thrusting:
            station = Station(LEADER, LEADER_COMPONENT)
            self.leader = Helmsman(station, Course(), 100_000, hull=Hull())

    def tick_only(self) -> Tick:
        t_s = (self.now_us - START_US) * 1e-6
        tick = super().tick_only()
        h = self.period_us * 1e-6
        self.hull.advance(*wrench(self.obeyed(tick.commands)), h)
        if self.thrusting and isinstance(self.leader, Helmsman):
            self.leader.hull.advance(*self.thrusting(t_s), h)
        return tick

    def obeyed(self, commands: tuple[int, ...]) -> tuple[int, ...]:
        """The thrust commands that the propellers obey."""
        return commands

    def off_slot(self, north: float = 0.0, east: float = 0.0) -> tuple[float, float, float]:
        """The boat's pose relative to that slot, in its own axes: m, m, rad."""
        leader = self.leader.truth(self.now_us)
        slot = Course(leader.north + north, leader.east + east, leader.psi)
        return self.hull.seen.minus(slot)
