# SPDX-License-Identifier: MIT
"""A boat among other vessels: its depth report, collision avoidance, HOLD."""

from __future__ import annotations

import math
from typing import Any

import pytest
from pymavlink.dialects.v20 import common as mavlink

from tests.dialect import dialect
from tests.target.course import Course
from tests.target.hull import Afloat
from tests.target.plans import at
from tests.target.sea import Sea, acks
from tests.target.stations import (
    BOAT,
    FORMATION,
    SET_MODE,
    STRANGER,
    TEMPORARILY_REJECTED,
    Station,
    heartbeat,
    local_position,
    origin,
)

LEAST_M = 2.0
OWN = Course(0.0, 0.0, 0.0)
LEADER = Course(20.0, 0.0, 0.0, 0.5)


def boat(least_m: float = LEAST_M, links: int = 1) -> Sea:
    return Sea({"FS_SEP_M": least_m}, links=links, own=OWN, leader=LEADER)


def meet(
    sea: Sea, north_m: float, seconds: float = 0.0, kind: int = mavlink.MAV_TYPE_SURFACE_BOAT
) -> None:
    """A vessel reports that position ten times a second, at least once."""
    station = Station(BOAT + 1)
    sea.say(heartbeat(kind), origin(sea.now_us), sender=station)
    for _ in range(max(1, round(10 * seconds))):
        here = local_position(Course(north_m, 0.0, 0.0), sea.now_us)
        sea.say(here, sender=station)
        sea.run(0.1)


def depth(value: float) -> Any:
    return mavlink.MAVLink_named_value_float_message(0, b"DEPTH", value)


def beacon() -> Any:
    """FLEET_BEACON of a boat without a table."""
    kind = dialect().MAVLink_fleet_beacon_message
    return kind(**dict.fromkeys(kind.fieldnames, 0))


def told(sea: Sea, name: str, link: int = 0) -> list[float]:
    found = [m for tick in sea.ticks for m in tick.named("NAMED_VALUE_FLOAT", link)]
    return [m.value for m in found if m.name == name]


def test_the_depth_in_the_tree_is_sent_once_a_second_on_every_link() -> None:
    sea = boat(links=2)
    sea.run(3.0)
    # The leader's own depth is not known: it is a virtual one.
    assert told(sea, "DEPTH", 0) == told(sea, "DEPTH", 1) == [1.0] * 3
    sea.say(depth(4.0), sender=sea.leader.station)
    sea.run(1.0)
    assert told(sea, "DEPTH")[-1] == 1.0
    sea.say(heartbeat(), beacon(), depth(4.0), sender=sea.leader.station)
    sea.run(1.0)
    assert told(sea, "DEPTH")[-1] == 5.0
    sea.say(depth(4.5), depth(251.0), depth(-1.0), sender=sea.leader.station)
    sea.say(depth(7.0), sender=Station(sea.leader.station.system, 154))  # another component of it
    sea.run(1.0)
    assert told(sea, "DEPTH")[-1] == 5.0


def test_without_fs_sep_m_no_depth_is_sent_and_no_vessel_is_watched() -> None:
    sea = boat(least_m=0.0)
    sea.enter_formation()
    meet(sea, 3.0, 1.0)
    assert not told(sea, "DEPTH") and not told(sea, "SEP_M")
    assert sea.snapshot()["separation_m"] is None
    assert sea.condition("clear") and not sea.snapshot()["limited"]["yielding"]


def test_formation_is_refused_while_a_vessel_is_nearer_than_fs_sep_m() -> None:
    sea = boat()
    sea.enter_hold()
    meet(sea, 1.9)
    tick = sea.mode(FORMATION)
    assert acks(tick) == [(SET_MODE, TEMPORARILY_REJECTED)]
    texts = [m.text for m in tick.named("STATUSTEXT")]
    assert "Refused: a vessel is nearer than FS_SEP_M" in texts
    assert not sea.condition("clear")
    meet(sea, 2.1)
    assert sea.condition("clear")
    sea.mode(FORMATION)
    assert sea.state == "FORMATION"


def test_a_vessel_that_comes_too_near_does_not_end_formation() -> None:
    sea = boat()
    sea.enter_formation()
    meet(sea, 1.0, 1.0)
    assert not sea.condition("clear") and sea.state == "FORMATION"


def test_a_boat_yields_to_a_vessel_ahead_reports_the_distance_and_then_continues() -> None:
    sea = boat()
    sea.enter_formation()
    sea.run(1.0)
    alone = sea.snapshot()
    assert not alone["limited"]["yielding"] and alone["separation_m"] is None
    ahead = alone["virtual_velocity"]
    meet(sea, 3.0, 2.0)
    near = sea.snapshot()
    assert near["limited"]["yielding"]
    # 1.5 m/s for four seconds leads through it.
    nearest_m, now_m = told(sea, "SEP_M")
    assert nearest_m < 0.7 and now_m < 0.7 and near["separation_m"] < 0.7
    wanted = near["virtual_velocity"]
    assert wanted["u_mps"] < 0.5 * ahead["u_mps"] or abs(wanted["r_radps"]) > 0.5
    sea.run(3.5)  # forgotten
    after = sea.snapshot()
    assert not after["limited"]["yielding"] and after["separation_m"] is None
    assert after["virtual_velocity"]["u_mps"] > 0.9 * ahead["u_mps"]


@pytest.mark.parametrize("apart_s", [0.0, 5.0, -5.0, 600.0])
def test_a_boat_keeps_clear_of_both_of_two_vessels_with_one_system_id(apart_s: float) -> None:
    """Moored: one in the way, the other far off; apart_s lie between the starts of their clocks."""
    sea = Afloat({"FS_SEP_M": LEAST_M}, leader=LEADER)
    sea.enter_formation()
    places = [Course(12.0, 0.2), Course(12.0, 60.0)]
    twins = [Station(STRANGER), Station(STRANGER)]
    nearest_m = math.inf
    for k in range(600):
        place, twin = places[k % 2], twins[k % 2]
        clock_us = sea.now_us + 10**9 + round(1e6 * apart_s) * (k % 2)
        if k % 20 < 2:
            sea.say(heartbeat(), origin(clock_us), sender=twin)
        sea.say(local_position(place, clock_us), sender=twin)
        sea.run(0.05)
        here = sea.hull.seen
        nearest_m = min(nearest_m, math.hypot(here.north - 12.0, here.east - 0.2))
    assert sea.state == "FORMATION" and sea.hull.seen.north > 15.0
    assert nearest_m > 0.9 * LEAST_M


@pytest.mark.parametrize(
    "kind",
    [
        mavlink.MAV_TYPE_GENERIC,
        mavlink.MAV_TYPE_GCS,
        mavlink.MAV_TYPE_ONBOARD_CONTROLLER,
        mavlink.MAV_TYPE_GIMBAL,
    ],
)
def test_systems_that_are_no_vessels_are_no_obstacles(kind: int) -> None:
    sea = boat()
    sea.enter_formation()
    meet(sea, 1.0, 1.0, kind)
    assert sea.condition("clear") and sea.snapshot()["separation_m"] is None


@pytest.mark.parametrize("component", [None, 1, 191])
def test_the_depth_of_an_echo_sounder_does_not_make_a_stranger_a_member(
    component: int | None,
) -> None:
    """A boat yields to a stranger that comes straight at it, not to a member that is deeper.

    `component`: the one that speaks Flotilla's dialect, an autopilot or its companion.
    """
    sea = boat()
    sea.enter_formation()
    autopilot, ours = Station(STRANGER), Station(STRANGER, component or 1)
    beat = mavlink.MAVLink_heartbeat_message(mavlink.MAV_TYPE_SURFACE_BOAT, 3, 4, 0, 4, 3)
    for k in range(20):
        if k % 10 == 0:
            sea.say(beat, origin(sea.now_us), sender=autopilot)
            if component is not None:
                sea.say(beacon(), sender=ours)
            sea.say(depth(12.0), sender=ours)
        sea.say(local_position(Course(6.0, 0.0, math.pi, 0.5), sea.now_us), sender=autopilot)
        sea.run(0.1)
    assert sea.snapshot()["limited"]["yielding"] == (component is None)


MOORED, UNKNOWN_STATUS = mavlink.AIS_NAV_STATUS_MOORED, 15


def ship(north_m: float, heard_s_ago: int, speed_mps: float, status: int = UNKNOWN_STATUS) -> Any:
    """AIS_VESSEL of a ship that goes north."""
    place = at(north_m, 0.0)
    flags = mavlink.AIS_FLAGS_VALID_COG | mavlink.AIS_FLAGS_VALID_VELOCITY
    fields = (211000001, place.x, place.y, 0, 0, round(100 * speed_mps), 0, status, 37)
    return mavlink.MAVLink_ais_vessel_message(*fields, 0, 0, 0, 0, b"", b"", heard_s_ago, flags)


@pytest.mark.parametrize(("speed_mps", "status"), [(1.0, MOORED), (0.2, UNKNOWN_STATUS)])
def test_a_ship_at_rest_that_reports_every_three_minutes_is_not_forgotten_between(
    speed_mps: float, status: int
) -> None:
    sea = boat()
    sea.enter_formation()
    sea.say(ship(30.0, 200, speed_mps, status))
    sea.run(0.2)
    near_m = sea.snapshot()["separation_m"]
    assert near_m is not None and near_m > 5.0  # nor is its place uncertain
    sea.say(ship(1.0, 0, 0.0, status))
    sea.run(35.0)
    assert not sea.condition("clear")


def test_a_ship_under_way_is_forgotten_after_half_a_minute() -> None:
    sea = boat()
    sea.settle()
    sea.say(ship(1.0, 0, 0.0, MOORED), ship(1.0, 0, 0.4))
    sea.run(0.2)
    assert not sea.condition("clear")
    sea.run(30.0)
    assert sea.condition("clear")


def test_a_change_of_the_own_origin_moves_no_ship() -> None:
    sea = boat()
    sea.settle()
    sea.say(ship(1.0, 0, 0.0, MOORED))
    sea.own.origin_on = False
    for north_m in (0.0, 0.5, -0.9, -1.1):
        place = at(north_m, 0.0)
        sea.say(origin(sea.now_us, place.x, place.y), sender=sea.own.station)
        sea.run(1.0)
        assert sea.condition("clear") == (north_m < -1.0), north_m
