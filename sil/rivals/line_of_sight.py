# SPDX-License-Identifier: MIT
"""Line-of-sight guidance along a path, with integral action (ILOS) or adaptation (ALOS).

  ILOS   ψ_d = χ_p − atan((y + κ y_i)/Δ)        ẏ_i = Δ y/(Δ² + (y + κ y_i)²)
  ALOS   ψ_d = χ_p − β̂ − atan(y/Δ)              β̂̇ = γ Δ y/√(Δ² + y²)

y: cross-track error, χ_p: the path's course, Δ: look-ahead, β̂: crab angle. Both feed the path's
curvature forward to the heading autopilot: r_d = κ_p u. Source: Fossen, Handbook of Marine Craft
Hydrodynamics and Motion Control, 2nd ed., chapter 12; for ALOS Fossen, An adaptive line-of-sight
(ALOS) guidance law for path following of aircraft and marine craft, IEEE Transactions on Control
Systems Technology 31 (6), 2023.
"""

import math
from dataclasses import dataclass

from sil.rivals.helm import Autopilot, Known, Seen, Thrust, allocate
from sil.rivals.path import Path


@dataclass(frozen=True)
class Gains:
    """`ahead_m`: Δ; `learns`: κ (ILOS, 1/s) or γ (ALOS, 1/(m s)); `omega`: the autopilot's."""

    ahead_m: float
    learns: float
    omega: float


class LineOfSight:
    """A boat on a path. `adapts`: ALOS, else ILOS."""

    def __init__(self, known: Known, path: Path, gains: Gains, *, adapts: bool) -> None:
        self._known, self._path, self._gains, self._adapts = known, path, gains, adapts
        self._autopilot = Autopilot(known, gains.omega)
        self._learnt = 0.0  # y_i, m, or β̂, rad
        self._t_s: float | None = None

    def steer(self, seen: Seen) -> Thrust:
        """See `Helm`."""
        h_s = 0.0 if self._t_s is None else seen.t_s - self._t_s
        self._t_s = seen.t_s
        at = self._path.beside(seen.x, seen.y)
        ahead, learns, y = self._gains.ahead_m, self._gains.learns, at.y_m
        if self._adapts:
            psi_d = at.course_rad - self._learnt - math.atan(y / ahead)
            self._learnt += learns * ahead * y / math.hypot(ahead, y) * h_s
        else:
            both = y + learns * self._learnt
            psi_d = at.course_rad - math.atan(both / ahead)
            self._learnt += ahead * y / (ahead * ahead + both * both) * h_s
        r_d = at.curvature_1pm * at.speed_mps
        # The speed along the path is the plan's, whatever the crab angle.
        off = seen.psi - at.course_rad
        along = seen._replace(u=math.cos(off) * seen.u - math.sin(off) * seen.v)
        wrench = self._autopilot.wrench(along, psi_d, r_d, at.speed_mps, h_s)
        return allocate(self._known, *wrench)
