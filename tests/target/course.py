# SPDX-License-Identifier: MIT
"""The true state of a level boat: north-east position, heading, body velocity. SI, radians."""

from __future__ import annotations

import math
from dataclasses import dataclass


def wrap(angle: float) -> float:
    return math.atan2(math.sin(angle), math.cos(angle))


@dataclass(frozen=True)
class Course:
    """A state at t = 0; body velocity and yaw rate are constant from then on."""

    north: float = 0.0
    east: float = 0.0
    psi: float = 0.0
    u: float = 0.0
    v: float = 0.0
    r: float = 0.0

    def at(self, t_s: float) -> Course:
        if self.r == 0.0:
            ahead, abeam = t_s, 0.0
        else:
            ahead = math.sin(self.r * t_s) / self.r
            abeam = (1.0 - math.cos(self.r * t_s)) / self.r
        forward, starboard = self.u * ahead - self.v * abeam, self.u * abeam + self.v * ahead
        c, s = math.cos(self.psi), math.sin(self.psi)
        return Course(
            self.north + c * forward - s * starboard,
            self.east + s * forward + c * starboard,
            wrap(self.psi + self.r * t_s),
            self.u,
            self.v,
            self.r,
        )

    @property
    def velocity_n(self) -> tuple[float, float]:
        c, s = math.cos(self.psi), math.sin(self.psi)
        return c * self.u - s * self.v, s * self.u + c * self.v

    def minus(self, other: Course) -> tuple[float, float, float]:
        """The difference ahead, to starboard and in heading, in this boat's axes."""
        c, s = math.cos(self.psi), math.sin(self.psi)
        north, east = self.north - other.north, self.east - other.east
        return c * north + s * east, -s * north + c * east, wrap(self.psi - other.psi)

    def close_to(self, other: Course, tolerance: float = 1e-4) -> bool:
        return (
            math.hypot(self.north - other.north, self.east - other.east) < tolerance
            and abs(wrap(self.psi - other.psi)) < tolerance
            and math.hypot(self.u - other.u, self.v - other.v) < tolerance
            and abs(self.r - other.r) < tolerance
        )


def quaternion(roll: float, pitch: float, yaw: float) -> list[float]:
    """Body to north-east-down, w first."""
    cr, sr = math.cos(roll / 2), math.sin(roll / 2)
    cp, sp = math.cos(pitch / 2), math.sin(pitch / 2)
    cy, sy = math.cos(yaw / 2), math.sin(yaw / 2)
    return [
        cr * cp * cy + sr * sp * sy,
        sr * cp * cy - cr * sp * sy,
        cr * sp * cy + sr * cp * sy,
        cr * cp * sy - sr * sp * cy,
    ]


#: A leader that keeps every propeller busy, and a boat that is carried along behind it.
TURN, BEHIND = Course(4.0, 3.0, 0.5, 0.6, 0.0, 0.2), Course(3.7, 2.8, 0.45, 0.6, 0.0, 0.2)
