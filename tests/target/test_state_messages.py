# SPDX-License-Identifier: MIT
"""A state arrives as ODOMETRY, or as two messages that complete each other."""

from __future__ import annotations

import pytest

from tests.target.agent import START_US
from tests.target.course import Course, quaternion
from tests.target.sea import Sea, named
from tests.target.stations import attitude, local_position, odometry, origin


def test_the_own_state_may_come_as_local_position_and_attitude(sea: Sea) -> None:
    sea.own.on = False
    truth = Course(4.0, -3.0, 1.2, 0.8, -0.1, 0.15)
    for _ in range(10):
        here = truth.at((sea.now_us - START_US) * 1e-6)
        sea.say(
            local_position(here, sea.now_us), attitude(here, sea.now_us), sender=sea.own.station
        )
        sea.run(0.1)
    assert sea.condition("own_fresh")
    last = named(sea.ticks, "LOCAL_POSITION_NED")[-1].time_boot_ms
    assert sea.own_course().close_to(truth.at((last * 1000 - START_US) * 1e-6), 5e-3)


def test_a_leader_may_send_local_position_and_attitude(sea: Sea) -> None:
    sea.leader.on = False
    truth = Course(4.0, -3.0, 1.2)
    for _ in range(10):
        sea.say(
            origin(sea.now_us),
            local_position(truth, sea.now_us),
            attitude(truth, sea.now_us),
            sender=sea.leader.station,
        )
        sea.run(0.1)
    assert sea.condition("leader_fresh")
    ahead, starboard, turn = sea.own.course.minus(truth)
    error = sea.snapshot()["error"]
    assert (error["x_m"], error["y_m"]) == pytest.approx((ahead, starboard), abs=1e-3)
    assert error["psi_rad"] == pytest.approx(turn, abs=1e-4)


@pytest.mark.parametrize("missing", ["LOCAL_POSITION_NED", "ATTITUDE"])
def test_position_or_attitude_alone_is_no_state(sea: Sea, missing: str) -> None:
    sea.own.on = False
    for _ in range(20):
        half = attitude if missing == "LOCAL_POSITION_NED" else local_position
        sea.say(half(Course(), sea.now_us), sender=sea.own.station)
        sea.run(0.05)
    assert not sea.condition("own_fresh")


@pytest.mark.parametrize("agent", ["own", "leader"])
@pytest.mark.parametrize("silent", ["LOCAL_POSITION_NED", "ATTITUDE"])
def test_a_state_in_two_messages_is_as_old_as_the_older_of_them(
    sea: Sea, agent: str, silent: str
) -> None:
    whose = getattr(sea, agent)
    whose.on = False
    limit_us = {"own": 500_000, "leader": 1_000_000}[agent]
    halves = {"LOCAL_POSITION_NED": local_position, "ATTITUDE": attitude}
    for k in range(60):
        both = [
            half(whose.course, sea.now_us)
            for name, half in halves.items()
            if name != silent or k < 20
        ]
        sea.say(origin(), *both, sender=whose.station)
        sea.run(0.05)
        if k == 19:
            assert sea.condition(f"{agent}_fresh")
            heard_us = sea.now_us - 50_000
        if k > 19 and sea.ticks[-1].now_us - heard_us > limit_us + 50_000:
            assert not sea.condition(f"{agent}_fresh"), sea.now_us - heard_us


@pytest.mark.parametrize("late_us", [0, 10_000, 100_000])
def test_an_older_heading_does_not_replace_a_newer_one(sea: Sea, late_us: int) -> None:
    sea.own.on = False
    for _ in range(10):
        sea.say(
            local_position(Course(), sea.now_us),
            attitude(Course(), sea.now_us),
            sender=sea.own.station,
        )
        sea.run(0.05)
    stamp_us = sea.now_us - 50_000
    sea.say(attitude(Course(psi=2.0), stamp_us - late_us), sender=sea.own.station)
    sea.say(local_position(Course(), sea.now_us), sender=sea.own.station)
    sea.run(0.11)
    assert sea.own_course().psi == pytest.approx(0.0, abs=1e-3)
    assert sea.counter("mavlink_old_stamp") == 1


def test_a_quaternion_a_little_off_its_length_is_normalised(sea: Sea) -> None:
    sea.own.on = False
    q = [0.98 * x for x in quaternion(0, 0, 0.7)]
    sea.say(odometry(Course(), sea.now_us, q=q), sender=sea.own.station)
    sea.step()
    assert sea.own_course().psi == pytest.approx(0.7, abs=1e-4)


@pytest.mark.parametrize("offset_s", [0.0, -9.0, 1.7e9], ids=["the boat's", "another boot", "Unix"])
def test_the_navigation_units_clock_may_be_any(offset_s: float) -> None:
    sea = Sea(own=Course(0, 0, 0, 1.0))
    sea.own.clock_offset_us = round(offset_s * 1e6)
    sea.run(3.0)
    assert sea.condition("own_fresh")
    m = named(sea.ticks, "LOCAL_POSITION_NED")[-1]
    assert abs(m.time_boot_ms - sea.now_us / 1000) < 200, "own stamps are in the boat's own clock"
    assert m.x == pytest.approx(sea.own.truth(m.time_boot_ms * 1000).north, abs=0.01)
