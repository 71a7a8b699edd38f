# SPDX-License-Identifier: MIT
"""WGS 84 by iteration, independent of the boat's own geodesy."""

from __future__ import annotations

import math

import numpy as np

A_M = 6378137.0
E2 = 0.0066943799901413165


class Globe:
    """A local north-east frame at an origin in degE7 and mm, as in GPS_GLOBAL_ORIGIN."""

    def __init__(self, latitude: int, longitude: int, altitude_mm: int = 0) -> None:
        phi, lam = math.radians(latitude * 1e-7), math.radians(longitude * 1e-7)
        self.height_m = altitude_mm * 1e-3
        n = A_M / math.sqrt(1 - E2 * math.sin(phi) ** 2)
        self.origin = np.array(
            [
                (n + self.height_m) * math.cos(phi) * math.cos(lam),
                (n + self.height_m) * math.cos(phi) * math.sin(lam),
                (n * (1 - E2) + self.height_m) * math.sin(phi),
            ]
        )
        self.north = np.array(
            [-math.sin(phi) * math.cos(lam), -math.sin(phi) * math.sin(lam), math.cos(phi)]
        )
        self.east = np.array([-math.sin(lam), math.cos(lam), 0.0])

    def degrees(self, north_m: float, east_m: float) -> tuple[float, float]:
        """Latitude and longitude, in degE7, of a point of the plane that touches at the origin."""
        x, y, z = self.origin + north_m * self.north + east_m * self.east
        p = math.hypot(x, y)
        phi = math.atan2(z, p * (1 - E2))
        for _ in range(20):  # tan φ = (Z + e² N sin φ) / p
            n = A_M / math.sqrt(1 - E2 * math.sin(phi) ** 2)
            phi = math.atan2(z + E2 * n * math.sin(phi), p)
        return math.degrees(phi) * 1e7, math.degrees(math.atan2(y, x)) * 1e7

    def local(self, other: Globe) -> tuple[float, float]:
        """Another frame's origin, north and east of this one's."""
        away = other.origin - self.origin
        return float(away @ self.north), float(away @ self.east)
