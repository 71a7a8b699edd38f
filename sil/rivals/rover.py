# SPDX-License-Identifier: MIT
"""Steers a boat as the documentation of ArduPilot's Rover and its Follow mode describes.

This is our own implementation, from the documentation of Rover's parameters. It contains none of
Rover's code and models nothing beyond the documentation. Navigation (PSC_*): desired velocity = the
target's + PSC_POS_P × position error; desired acceleration = PSC_VEL_P × velocity error, along the
boat for its speed, across it for its turn, a_y/u. Inner loops: rate and speed (ATC_STR_RAT_*,
ATC_SPEED_*) with feed-forward, proportional and integral part, in shares of full thrust. Follow
(FOLL_*): the target is the leader's last received state, extrapolated by its velocity, with an
offset to north and east; FOLL_POS_P replaces PSC_POS_P.
"""

import math
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass

from sil.rivals.helm import Known, Seen, Thrust, allocate, wrap
from sil.rivals.path import Path

_LEAST_MPS = 0.2  # below this speed, a boat turns by its heading error alone
_TURN_P = 2.0  # ATC_STR_ANG_P
_FASTEST_RADPS = 0.8
_PIVOT_RAD = math.radians(60.0)  # WP_PIVOT_ANGLE: beyond this angle, a boat turns before it goes on


@dataclass(frozen=True)
class Gains:
    """PSC_POS_P, PSC_VEL_P (1/s), ATC_STR_RAT_P (share per rad/s); for speed and rate, I = P."""

    pos: float
    vel: float
    rate: float


@dataclass(frozen=True)
class Target:
    """The desired place (m), velocity and acceleration of a boat, north and east."""

    x: float
    y: float
    vx: float
    vy: float
    ax: float = 0.0
    ay: float = 0.0


Aim = Callable[[Seen], Target]


class Rover:
    """Steers towards `target(seen)`."""

    def __init__(self, known: Known, target: Aim, gains: Gains) -> None:
        self._known, self._target, self._gains = known, target, gains
        self._rate_i = self._speed_i = 0.0
        self._u_d = 0.0
        self._t_s: float | None = None

    def steer(self, seen: Seen) -> Thrust:
        """See `Helm`."""
        h_s = 0.0 if self._t_s is None else seen.t_s - self._t_s
        self._t_s = seen.t_s
        to, g = self._target(seen), self._gains
        cos, sin = math.cos(seen.psi), math.sin(seen.psi)
        vx = to.vx + g.pos * (to.x - seen.x)
        vy = to.vy + g.pos * (to.y - seen.y)
        ax = to.ax + g.vel * (vx - (cos * seen.u - sin * seen.v))
        ay = to.ay + g.vel * (vy - (sin * seen.u + cos * seen.v))
        across = -sin * ax + cos * ay
        off = wrap(math.atan2(vy, vx) - seen.psi) if math.hypot(vx, vy) > 0.1 else 0.0
        pivots = abs(off) > _PIVOT_RAD
        r_d = across / seen.u if seen.u > _LEAST_MPS and not pivots else _TURN_P * off
        r_d = max(-_FASTEST_RADPS, min(_FASTEST_RADPS, r_d))
        return self._loops(seen, r_d, 0.0 if pivots else cos * vx + sin * vy, h_s)

    def _loops(self, seen: Seen, r_d: float, u_d: float, h_s: float) -> Thrust:
        hull, p = self._known, self._gains.rate
        most_N, most_Nm = 2.0 * hull.most_N, 2.0 * hull.most_N * hull.arm_m
        turn = hull.d33 / most_Nm * r_d + p * (r_d - seen.r) + self._rate_i
        push = hull.d11 / most_N * u_d + 0.6 * (u_d - seen.u) + self._speed_i
        # Integrals stop while the propellers are at their limits.
        if abs(turn) + abs(push) < 1.0:
            self._rate_i = max(-0.5, min(0.5, self._rate_i + p * (r_d - seen.r) * h_s))
            self._speed_i = max(-0.5, min(0.5, self._speed_i + 0.2 * (u_d - seen.u) * h_s))
        return allocate(hull, most_N * push, most_Nm * turn)


def on_path(path: Path) -> Aim:
    """The plan's vessel beside the boat, like the S-curves that Rover's navigation follows."""

    def target(seen: Seen) -> Target:
        at = path.beside(seen.x, seen.y)
        x, y, psi = path.motion[at.k, :3]
        cos, sin = math.cos(psi), math.sin(psi)
        u, bend = at.speed_mps, at.curvature_1pm
        across = bend * u * u
        return Target(x, y, u * cos, u * sin, -sin * across, cos * across)

    return target


class Heard:
    """A leader's states, as a follower receives them: late, some lost; the newest counts."""

    def __init__(self, delay_s: float, lost: Callable[[], bool], every_s: float) -> None:
        self._delay_s, self._lost, self._every_s = delay_s, lost, every_s
        self._on_the_way: deque[Seen] = deque()
        self._last: Seen | None = None
        self._next_s = 0.0

    def say(self, leader: Seen) -> None:
        """Take a new state from the leader's unit."""
        if leader.t_s >= self._next_s:
            self._next_s = leader.t_s + self._every_s - 1e-6
            if not self._lost():
                self._on_the_way.append(leader)

    def follow(self, offset_m: tuple[float, float]) -> Aim:
        """Aim at the place beside the leader, extrapolated to the follower's time."""

        def target(seen: Seen) -> Target:
            while self._on_the_way and self._on_the_way[0].t_s + self._delay_s <= seen.t_s:
                self._last = self._on_the_way.popleft()
            told = self._last
            if told is None:
                return Target(seen.x, seen.y, 0.0, 0.0)
            cos, sin = math.cos(told.psi), math.sin(told.psi)
            vx, vy = cos * told.u - sin * told.v, sin * told.u + cos * told.v
            since = seen.t_s - told.t_s
            x, y = told.x + since * vx + offset_m[0], told.y + since * vy + offset_m[1]
            return Target(x, y, vx, vy)

        return target
