# SPDX-License-Identifier: MIT
"""A vessel's position does not depend on the source, component, link or origin that reports it."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from tests.target.course import Course
from tests.target.hull import Afloat, Hull, s_curve
from tests.target.operator_words import param_set
from tests.target.sea import Sea, at_sea, texts
from tests.target.stations import (
    BOAT,
    LEADER,
    NAVIGATION,
    ORIGIN,
    Station,
    attitude,
    local_position,
    odometry,
    origin,
)

OFF_M = 300.0


def sailing() -> Afloat:
    """A boat in FORMATION with two links; unit and leader send on the first."""
    sea = Afloat({"FS_LEADER_ACT": 0}, Hull([-2.0, 1.0, 0.3, 0, 0, 0]), s_curve, links=2)
    sea.enter_formation()
    sea.run(8.0)
    assert sea.state == "FORMATION" and sea.counter("mavlink_jump") == 0
    return sea


def pair(truth: Course, now_us: int) -> list[object]:
    return [attitude(truth, now_us), local_position(truth, now_us)]


def farthest_while_driven(sea: Afloat, seconds: float) -> float:
    """The greatest distance from the slot, by the boat's own estimate."""
    far_m = 0.0
    for _ in range(round(100 * seconds)):
        sea.step()
        error = sea.snapshot()["error"]
        if any(sea.commands) and error:
            far_m = max(far_m, math.hypot(error["x_m"], error["y_m"]))
    return far_m


@pytest.mark.parametrize("component", [10, NAVIGATION - 1, NAVIGATION + 1])
@pytest.mark.parametrize("link", [0, 1])
def test_no_other_component_takes_the_own_units_place_while_armed(
    component: int, link: int
) -> None:
    sea = sailing()
    other = Station(BOAT, component)
    far_m = 0.0
    for _ in range(40):
        there = replace(sea.own.truth(sea.now_us), north=OFF_M)
        sea.say(origin(sea.now_us), *pair(there, sea.now_us), sender=other, link=link)
        far_m = max(far_m, farthest_while_driven(sea, 0.05))
    assert sea.state == "FORMATION" and far_m < 2.0
    sea.own.on = False
    for _ in range(40):
        there = replace(sea.own.truth(sea.now_us), north=OFF_M)
        sea.say(origin(sea.now_us), *pair(there, sea.now_us), sender=other, link=link)
        sea.run(0.05)
    assert sea.state == "HOLD" and not sea.condition("own_fresh"), "nor when the unit is silent"


def test_the_same_component_on_another_link_is_not_the_own_unit() -> None:
    sea = sailing()
    far_m = 0.0
    for _ in range(40):
        there = replace(sea.own.truth(sea.now_us), north=OFF_M)
        sea.say(odometry(there, sea.now_us), sender=Station(BOAT, NAVIGATION), link=1)
        far_m = max(far_m, farthest_while_driven(sea, 0.05))
    assert sea.state == "FORMATION" and far_m < 2.0 and sea.counter("mavlink_jump") == 0


@pytest.mark.parametrize(("component", "link"), [(10, 0), (10, 1), (NAVIGATION, 1)])
def test_a_disarmed_boat_takes_another_unit_only_half_a_minute_after_its_own_was_lost(
    component: int, link: int
) -> None:
    sea = Sea(links=2)
    sea.run(1.0)
    sea.own.on = False
    other = Station(BOAT, component)

    def sail_beside_another(seconds: float) -> set[bool]:
        seen = set()
        for _ in range(round(20 * seconds)):
            there = replace(sea.own.course, north=OFF_M)
            sea.say(origin(sea.now_us), odometry(there, sea.now_us), sender=other, link=link)
            sea.run(0.05)
            seen.add(sea.condition("own_fresh"))
        return seen

    sail_beside_another(1.0)
    assert sail_beside_another(28.0) == {False}
    if link == 1:
        assert "navigation data ignored: disarm, or set NAV_LINK" in texts(sea.ticks)
    sail_beside_another(4.0)
    assert sea.condition("own_fresh")
    sea.arm()
    assert sea.state == "HOLD"


def test_an_own_unit_that_restarts_beside_a_namesake_is_the_own_unit_again() -> None:
    sea = Sea(links=2)
    sea.run(1.0)
    other = Station(BOAT, 10)
    sea.own.on = False
    for k in range(500):
        there = replace(sea.own.course, north=OFF_M)
        sea.say(origin(sea.now_us), odometry(there, sea.now_us), sender=other, link=1)
        if k == 400:
            sea.own.clock_offset_us = -sea.now_us
            sea.own.on = True
        sea.run(0.05)
    assert sea.condition("own_fresh") and sea.condition("own_steady")
    assert sea.own_course().north == pytest.approx(sea.own.course.north, abs=0.1)


@pytest.mark.parametrize("pin", [{"NAV_COMPID": 10.0}, {"NAV_LINK": 1.0}])
def test_only_the_source_set_by_parameters_is_used(pin: dict[str, float]) -> None:
    sea = Sea(pin, links=2)
    sea.run(1.0)
    assert sea.snapshot()["own_age_s"] is None
    other = Station(BOAT, 10)
    for _ in range(20):
        sea.say(origin(sea.now_us), odometry(sea.own.course, sea.now_us), sender=other, link=1)
        sea.run(0.05)
    assert sea.condition("own_fresh")


def test_a_pin_that_is_set_later_changes_the_source() -> None:
    sea = Sea(links=2)
    sea.run(1.0)
    assert sea.condition("own_fresh")
    sea.say(param_set("NAV_COMPID", 10.0))
    sea.run(0.2)
    assert sea.snapshot()["own_age_s"] is None


@pytest.mark.parametrize("agent", ["own", "leader"])
def test_a_change_of_message_kind_does_not_move_a_vessel(agent: str) -> None:
    sea = sailing()
    whose = getattr(sea, agent)
    whose.on = False
    far_m = 0.0
    for k in range(40):
        there = replace(whose.truth(sea.now_us), north=OFF_M)
        sea.say(*pair(there, sea.now_us), sender=whose.station)
        far_m = max(far_m, farthest_while_driven(sea, 0.05))
        if 12 <= k < 30:
            assert not sea.condition(f"{agent}_steady")
    assert sea.state == "HOLD" and sea.counter("mavlink_jump") > 0 and far_m < 2.0


@pytest.mark.parametrize("agent", ["own", "leader"])
def test_another_kind_of_message_with_the_same_position_keeps_the_formation(agent: str) -> None:
    sea = sailing()
    whose = getattr(sea, agent)
    whose.on = False
    for _ in range(100):
        sea.say(*pair(whose.truth(sea.now_us), sea.now_us), sender=whose.station)
        sea.run(0.05)
        assert sea.state == "FORMATION"
    assert sea.counter("mavlink_jump") == 0


@pytest.mark.parametrize("agent", ["own", "leader"])
def test_another_origin_does_not_move_a_vessel_at_once(agent: str) -> None:
    """The new origin is a kilometre north."""
    sea = sailing()
    whose = getattr(sea, agent)
    whose.origin_on = False
    sea.say(origin(sea.now_us, latitude=ORIGIN[0] + 90_000), sender=whose.station)
    assert farthest_while_driven(sea, 0.9) < 2.0
    assert sea.state == "HOLD" and not sea.condition(f"{agent}_steady")
    assert sea.counter("mavlink_jump") > 0
    assert any("jump" in text for text in texts(sea.ticks))
    sea.run(2.5)
    assert sea.condition(f"{agent}_steady"), "it is there, after all"


@pytest.mark.parametrize("agent", ["own", "leader"])
def test_an_origin_that_moves_with_its_positions_changes_nothing(agent: str) -> None:
    """By 0.001 degree, 111.2 m."""
    sea = sailing()
    whose = getattr(sea, agent)
    whose.origin_on = False
    moved = whose.measured
    sea.say(origin(sea.now_us, latitude=ORIGIN[0] + 10_000), sender=whose.station)
    whose.measured = lambda now_us: replace(moved(now_us), north=moved(now_us).north - 111.19)
    for _ in range(300):
        sea.step()
        assert sea.state == "FORMATION"
        error = sea.snapshot()["error"]
        assert math.hypot(error["x_m"], error["y_m"]) < 2.0
    assert sea.counter("mavlink_jump") == 0


@pytest.mark.parametrize("agent", ["own", "leader"])
@pytest.mark.parametrize("by", ["place", "origin"])
def test_a_reset_of_the_estimate_does_not_hide_a_jump(agent: str, by: str) -> None:
    """A jump of 150 m, within FORM_DIST_MAX, is accepted at once but not followed unasked."""
    sea = sailing()
    whose = getattr(sea, agent)
    whose.on = whose.origin_on = False
    if by == "origin":
        sea.say(origin(sea.now_us, latitude=ORIGIN[0] + 13_500), sender=whose.station)
    off_m = 150.0 if by == "place" else 0.0
    far_m = 0.0
    for _ in range(120):
        truth = whose.truth(sea.now_us)
        there = replace(truth, north=truth.north + off_m)
        sea.say(odometry(there, sea.now_us, reset_counter=1), sender=whose.station)
        far_m = max(far_m, farthest_while_driven(sea, 0.05))
    assert sea.state == "HOLD" and far_m < 3.0
    assert any("jump" in text for text in texts(sea.ticks))


@pytest.mark.parametrize("component", [5, 13])
def test_no_other_component_of_the_leader_takes_the_place_of_the_one_that_is_heard(
    component: int,
) -> None:
    """It begins at the leader's position and drifts off, too slowly for a jump."""
    sea = Afloat({"FS_LEADER_ACT": 0}, Hull([-2.0, 1.0, 0.3, 0, 0, 0]), s_curve)
    sea.leader.station = Station(LEADER, 9)
    sea.enter_formation()
    sea.run(8.0)
    other = Station(LEADER, component)
    for k in range(200):
        there = sea.leader.truth(sea.now_us)
        there = replace(there, east=there.east + 0.05 * k)
        sea.say(origin(sea.now_us), *pair(there, sea.now_us), sender=other)
        sea.run(0.05)
    apart = sea.own.truth(sea.now_us).minus(sea.leader.truth(sea.now_us))
    assert sea.state == "FORMATION" and math.hypot(*apart[:2]) < 1.0


@pytest.mark.parametrize("near", [True, False])
def test_another_component_of_a_silent_leader_counts_if_it_is_at_the_same_position(
    near: bool,
) -> None:
    sea = sailing()
    sea.leader.on = False
    other = Station(LEADER, 5)
    steady = set()
    for k in range(60):
        there = sea.leader.truth(sea.now_us)
        there = there if near else replace(there, east=there.east + OFF_M)
        sea.say(origin(sea.now_us), *pair(there, sea.now_us), sender=other)
        sea.run(0.05)
        if 22 <= k < 38:
            steady.add(sea.condition("leader_steady"))
    assert steady == {near} and sea.state == "HOLD"


def test_a_component_whose_global_position_is_unknown_gives_way_to_one_that_is_located() -> None:
    sea = Sea(own=Course())
    sea.leader.on = False
    first, second = Station(LEADER, 9), Station(LEADER, 13)
    for k in range(40):
        sea.say(odometry(Course(5.0), sea.now_us), sender=first)
        if k > 10:
            sea.say(origin(sea.now_us), odometry(Course(1.0), sea.now_us), sender=second)
        sea.run(0.05)
    assert -sea.snapshot()["error"]["x_m"] == pytest.approx(1.0, abs=0.01)


def test_a_unit_that_restarts_somewhere_else_jumps() -> None:
    sea = at_sea({"FS_LEADER_ACT": 0})
    sea.leader.on = False
    sea.run(1.5)
    sea.leader.clock_offset_us = -sea.now_us
    sea.leader.course = replace(sea.leader.course, north=sea.leader.course.north + OFF_M)
    sea.leader.on = True
    jumps = 0
    for _ in range(200):
        sea.step()
        jumps += not sea.condition("leader_steady")
    assert jumps > 90
