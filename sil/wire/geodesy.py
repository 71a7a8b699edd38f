# SPDX-License-Identifier: MIT
"""Local frames on the WGS 84 ellipsoid, for units that send global positions.

A frame is the tangent plane of the water at its origin, x north, y east there. A vessel lies on the
water vertically below its point of the plane; all water is at one height above the ellipsoid.
Written independently of the firmware: reduced latitudes, Bowring's formula and iteration on the
height of the water, where the firmware intersects a line with the sea and scales.
Source: Bowring, Transformation from spatial to geographical coordinates, Survey Review 23, 1976.
"""

from math import atan2, cos, degrees, hypot, radians, sin, sqrt, tan
from typing import NamedTuple, Self

_A_M = 6_378_137.0
_F = 1.0 / 298.257223563
_B_M = _A_M * (1.0 - _F)
_E2 = 1.0 - (_B_M / _A_M) ** 2
_E2_SECOND = (_A_M / _B_M) ** 2 - 1.0

Vector = tuple[float, float, float]


class Geodetic(NamedTuple):
    """A pose on the globe: degE7, degE7, heading clockwise from the true north there (rad)."""

    latitude: int
    longitude: int
    psi: float


def _ecef(phi: float, lam: float, height_m: float) -> Vector:
    """Earth-centred coordinates (m) of a point, by its reduced latitude."""
    beta = atan2(_B_M * sin(phi), _A_M * cos(phi))
    p = _A_M * cos(beta) + height_m * cos(phi)
    return p * cos(lam), p * sin(lam), _B_M * sin(beta) + height_m * sin(phi)


def _bowring(x: float, y: float, z: float) -> tuple[float, float, float]:
    """Latitude, longitude (rad) and height (m) of an earth-centred point near the sea."""
    p = hypot(x, y)
    beta = atan2(z * _A_M, p * _B_M)
    phi = atan2(z + _E2_SECOND * _B_M * sin(beta) ** 3, p - _E2 * _A_M * cos(beta) ** 3)
    height = p * cos(phi) + z * sin(phi) - _A_M * sqrt(1.0 - _E2 * sin(phi) ** 2)
    return phi, atan2(y, x), height


class LocalFrame:
    """The tangent plane at a point (degE7) of a water at a height (m)."""

    def __init__(self, latitude: int, longitude: int, height_m: float = 0.0) -> None:
        self.origin_degE7 = (latitude, longitude)
        self._phi, self._lam = radians(latitude * 1e-7), radians(longitude * 1e-7)
        self._height_m = height_m
        self._origin = _ecef(self._phi, self._lam, height_m)
        sp, cp, sl, cl = sin(self._phi), cos(self._phi), sin(self._lam), cos(self._lam)
        self._axes: tuple[Vector, Vector, Vector] = (
            (-sp * cl, -sp * sl, cp),
            (-sl, cl, 0.0),
            (cp * cl, cp * sl, sp),
        )

    def moved(self, north_m: float, east_m: float) -> Self:
        """The frame with its origin shifted by these distances, rounded to degE7."""
        latitude, longitude, _ = self.geodetic(north_m, east_m, 0.0)
        return type(self)(latitude, longitude, self._height_m)

    def geodetic(self, north_m: float, east_m: float, psi: float) -> Geodetic:
        """Convert a pose of this frame to latitude, longitude and true heading."""
        phi, lam = self._degrees(north_m, east_m)
        return Geodetic(
            round(degrees(phi) * 1e7), round(degrees(lam) * 1e7), psi - self._convergence(phi, lam)
        )

    def seen_from(self, other: "LocalFrame", north_m: float, east_m: float, psi: float) -> Vector:
        """Convert a pose of this frame to `other`: north (m), east (m), heading (rad)."""
        phi, lam = self._degrees(north_m, east_m)
        point = _ecef(phi, lam, self._height_m)
        d = tuple(p - o for p, o in zip(point, other._origin, strict=True))
        north, east = (sum(a * b for a, b in zip(axis, d, strict=True)) for axis in other._axes[:2])
        turn = other._convergence(phi, lam) - self._convergence(phi, lam)
        return north, east, psi + turn

    def _degrees(self, north_m: float, east_m: float) -> tuple[float, float]:
        """Latitude and longitude, rad, of the water below a point of the plane."""
        up_m = 0.0
        for _ in range(3):
            x, y, z = (
                o + north_m * n + east_m * e + up_m * u
                for o, n, e, u in zip(self._origin, *self._axes, strict=True)
            )
            phi, lam, height_m = _bowring(x, y, z)
            up_m -= height_m - self._height_m
        return phi, lam

    def _convergence(self, phi: float, lam: float) -> float:
        """Angle, rad, from this frame's north clockwise to the true north of a point.

        Seen from above the frame's origin; on a sphere, which is accurate enough for an angle.
        """
        half = tan(0.5 * (lam - self._lam))
        return -2.0 * atan2(half * sin(0.5 * (phi + self._phi)), cos(0.5 * (phi - self._phi)))
