# SPDX-License-Identifier: MIT
"""The geographic origins of boat and leader, which make their positions comparable."""

from __future__ import annotations

import math

import pytest

from tests.target.course import Course
from tests.target.sea import Sea, named
from tests.target.stations import BOAT, LEADER, ORIGIN, Station, origin


@pytest.mark.parametrize("whose", [LEADER, BOAT], ids=["leader", "own"])
def test_the_origin_of_another_component_does_not_count(sea: Sea, whose: int) -> None:
    sea.run(1.5)
    error = sea.snapshot()["error"]
    sea.say(origin(0, ORIGIN[0] + 5000, ORIGIN[1]), sender=Station(whose, 250))
    sea.run(0.2)
    assert sea.snapshot()["error"] == pytest.approx(error, abs=1e-3)


@pytest.mark.parametrize("whose", ["own", "leader"])
def test_without_both_origins_a_leaders_local_position_does_not_count(sea: Sea, whose: str) -> None:
    getattr(sea, whose).origin_on = False
    sea.run(3.0)
    assert sea.condition("own_fresh") and not sea.condition("leader_fresh")
    getattr(sea, whose).origin_on = True
    sea.run(1.2)
    assert sea.condition("leader_fresh")


def test_origins_of_boat_and_leader_may_differ() -> None:
    sea = Sea(own=Course(), leader=Course())
    sea.leader.origin_on = False
    shift_north, shift_east = 250, -400  # 1e-7 degrees
    sea.say(origin(0, ORIGIN[0] + shift_north, ORIGIN[1] + shift_east), sender=sea.leader.station)
    sea.run(0.3)
    error = sea.snapshot()["error"]
    radius = 6_371_000.0  # 1 % suffices: the ellipsoid's two radii differ by less
    latitude = math.radians(ORIGIN[0] * 1e-7)
    assert -error["x_m"] == pytest.approx(math.radians(shift_north * 1e-7) * radius, rel=0.01)
    assert -error["y_m"] == pytest.approx(
        math.radians(shift_east * 1e-7) * radius * math.cos(latitude), rel=0.01
    )


@pytest.mark.parametrize(
    ("latitude", "longitude"), [(900000001, 0), (-900000001, 0), (0, 1800000001), (0, -(2**31))]
)
def test_an_origin_off_the_globe_is_refused(sea: Sea, latitude: int, longitude: int) -> None:
    sea.own.origin_on = False
    sea.say(origin(0, latitude, longitude), sender=sea.own.station)
    sea.run(1.0)
    assert sea.counter("mavlink_bad_value") == 1
    assert not named(sea.ticks, "GPS_GLOBAL_ORIGIN") and not sea.condition("leader_fresh")
