# SPDX-License-Identifier: MIT
"""Local frames against numerically integrated geodesics of the WGS 84 ellipsoid."""

from math import atan2, cos, degrees, hypot, pi, radians, sin, sqrt, tan
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from sil.wire.geodesy import LocalFrame

A_M, E2 = 6378137.0, 6.69437999014e-3
METRES = st.floats(-3000.0, 3000.0)
ORIGINS = [
    (487_000_000, 22_950_000),
    (0, 1_799_990_000),
    (-330_000_000, -1_220_000_000),
    (600_000_000, 50_000_000),
    (-780_000_000, 0),
]


def sail(phi: float, lam: float, north_m: float, east_m: float) -> tuple[float, float, float]:
    """The end of the geodesic that begins towards (north, east), and its azimuth there; radians.

    Its length is that of the way along the tangent, which at 5 km differs by 0.5 mm.
    """

    def along(_: float, state: Any) -> list[float]:
        phi, _, alpha = state
        w2 = 1.0 - E2 * sin(phi) ** 2
        meridian, prime = A_M * (1.0 - E2) / w2**1.5, A_M / sqrt(w2)
        east = sin(alpha) / prime
        return [cos(alpha) / meridian, east / cos(phi), east * tan(phi)]

    start = [phi, lam, atan2(east_m, north_m)]
    length = hypot(north_m, east_m)
    way = solve_ivp(along, (0.0, length), start, method="DOP853", rtol=1e-13, atol=1e-15)
    return float(way.y[0, -1]), float(way.y[1, -1]), float(way.y[2, -1])


def metres(phi: float, lam: float, other: tuple[float, float]) -> float:
    """Distance of two close points, m."""
    east = (lam - other[1] + pi) % (2.0 * pi) - pi
    return A_M * hypot(phi - other[0], east * cos(phi))


@pytest.mark.parametrize("origin", ORIGINS)
@pytest.mark.parametrize("local", [(1400.0, 1400.0), (-2000.0, 300.0), (0.0, -3000.0), (5.0, 0.0)])
def test_a_local_point_is_where_the_geodesic_leads(
    origin: tuple[int, int], local: tuple[float, float]
) -> None:
    phi, lam = (radians(1e-7 * angle) for angle in origin)
    north, east, azimuth = sail(phi, lam, *local)
    frame = LocalFrame(*origin)
    assert metres(north, east, frame._degrees(*local)) < 2e-4
    # A vessel that heads along the geodesic does so at both of its ends.
    pose = frame.geodetic(*local, atan2(local[1], local[0]))
    assert abs((pose.psi - azimuth + pi) % (2.0 * pi) - pi) < 1e-7
    assert abs(pose.latitude - degrees(north) * 1e7) < 0.51


@pytest.mark.parametrize("origin", ORIGINS)
@given(north=METRES, east=METRES)
def test_the_same_vessel_in_another_frame_is_at_the_same_place(
    origin: tuple[int, int], north: float, east: float
) -> None:
    here = LocalFrame(*origin)
    there = here.moved(1400.0, 1400.0)
    seen = here.seen_from(there, north, east, 1.0)
    assert metres(*here._degrees(north, east), there._degrees(seen[0], seen[1])) < 1e-6
    back = there.seen_from(here, *seen)
    assert back == pytest.approx((north, east, 1.0), abs=1e-6)


def test_a_frame_that_was_moved_begins_there_to_the_next_step_of_degE7() -> None:
    here = LocalFrame(487_000_000, 22_950_000)
    there = here.moved(1400.0, -1400.0)
    north, east, _ = there.seen_from(here, 0.0, 0.0, 0.0)
    assert (north, east) == pytest.approx((1400.0, -1400.0), abs=0.006)


def test_on_a_lake_above_the_sea_the_same_metres_span_fewer_degrees() -> None:
    sea = LocalFrame(487_000_000, 22_950_000).geodetic(3000.0, -3000.0, 0.0)
    lake = LocalFrame(487_000_000, 22_950_000, 500.0).geodetic(3000.0, -3000.0, 0.0)
    fewer = 1.0 - 500.0 / 6_371_000.0
    assert lake.latitude - 487_000_000 == pytest.approx(
        fewer * (sea.latitude - 487_000_000), abs=1.5
    )
    assert lake.longitude - 22_950_000 == pytest.approx(
        fewer * (sea.longitude - 22_950_000), abs=1.5
    )
    assert sea.latitude - lake.latitude == pytest.approx(21.2, abs=2.0)
