# SPDX-License-Identifier: MIT
"""The inputs of every rival: noisy states, and a hull as its firmware would know it.

Also the heading autopilot and the speed loop, which line-of-sight guidance needs as inner loops:

  N = m33 (ω² e_ψ + 2 ω (r_d − r)) + d33 r_d + k ∫ e_ψ dt        X = d11 u_d + k_u (u_d − u) + k_i ∫

Source: Fossen, Handbook of Marine Craft Hydrodynamics and Motion Control, 2nd ed., chapter 15.
"""

import math
from dataclasses import dataclass
from typing import NamedTuple, Protocol

Thrust = tuple[float, float]


@dataclass(frozen=True)
class Known:
    """The hull from the firmware's parameters, SI, with linear drag; thrust of one propeller.

    No rival knows the current, nor that one propeller is weak.
    """

    m11: float
    m22: float
    m33: float
    d11: float
    d22: float
    d33: float
    arm_m: float
    most_N: float


class Seen(NamedTuple):
    """A navigation unit's state: place (m), heading (rad), velocity over ground in body axes."""

    t_s: float
    x: float
    y: float
    psi: float
    u: float
    v: float
    r: float


class Helm(Protocol):
    """Steers one boat."""

    def steer(self, seen: Seen) -> Thrust:
        """Desired thrusts, port and starboard, N, until the next state."""


def wrap(angle: float) -> float:
    """Wrap an angle, rad, to [−π, π)."""
    return (angle + math.pi) % (2.0 * math.pi) - math.pi


def allocate(known: Known, surge_N: float, yaw_Nm: float) -> Thrust:
    """Thrusts of both propellers within their limits; the yaw moment has priority."""
    half = max(-known.most_N, min(known.most_N, 0.5 * yaw_Nm / known.arm_m))
    room = known.most_N - abs(half)
    each = max(-room, min(room, 0.5 * surge_N))
    return each + half, each - half


class Autopilot:
    """Controls heading and speed.

    `omega`: bandwidth of the heading loop, rad/s; `u_gain`: gain of the speed loop, 1/s.
    """

    def __init__(self, known: Known, omega: float, u_gain: float = 1.0) -> None:
        self._known, self._omega, self._u_gain = known, omega, u_gain
        self._yaw_Nm = self._surge_N = 0.0

    def wrench(
        self, seen: Seen, psi_d: float, r_d: float, u_d: float, h_s: float
    ) -> tuple[float, float]:
        """Surge force and yaw moment towards a heading, its rate and a speed over ground."""
        hull, w = self._known, self._omega
        off = wrap(psi_d - seen.psi)
        yaw = hull.m33 * (w * w * off + 2.0 * w * (r_d - seen.r)) + hull.d33 * r_d + self._yaw_Nm
        slow = u_d - seen.u
        surge = hull.d11 * u_d + hull.m11 * self._u_gain * slow + self._surge_N
        if abs(yaw) < hull.arm_m * hull.most_N:
            self._yaw_Nm += 0.1 * w * w * w * hull.m33 * off * h_s
        if abs(surge) < hull.most_N:
            self._surge_N += 0.25 * self._u_gain**2 * hull.m11 * slow * h_s
        return surge, yaw
