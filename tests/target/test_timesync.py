# SPDX-License-Identifier: MIT
"""TIMESYNC: the boat's answers, and the estimated age of its leader's state."""

from __future__ import annotations

import random
from collections import defaultdict
from itertools import pairwise

import flotilla
import pytest
from pymavlink.dialects.v20 import common as mavlink

from tests.target.agent import START_US
from tests.target.course import Course
from tests.target.operator_words import param_set
from tests.target.sea import Sea, Tick, named
from tests.target.stations import BOAT, GCS, LEADER, NAVIGATION, STRANGER, Station, odometry, origin


def asks(tick: Tick, link: int) -> int:
    return len([m for m in tick.named("TIMESYNC", link) if m.tc1 == 0])


@pytest.mark.parametrize("link", [0, 1])
@pytest.mark.parametrize("ts1", [1, 123_456_789, 2**62 + 12345, 2**63 - 1, -1, -(2**63)])
def test_a_timesync_request_is_answered_with_its_own_stamp(ts1: int, link: int) -> None:
    sea = Sea(links=2)
    sea.settle()
    sea.say(mavlink.MAVLink_timesync_message(0, ts1), link=link)
    tick = sea.step()
    (answer,) = [m for m in tick.named("TIMESYNC", link) if m.tc1 != 0]
    assert answer.ts1 == ts1
    assert answer.tc1 == tick.now_us * 1000
    assert not [m for m in tick.named("TIMESYNC", 1 - link) if m.tc1 != 0]


@pytest.mark.parametrize("answer", [(1, 0), (-1, 5), (2**63 - 1, 2**63 - 1), (10**18, -1)])
def test_a_timesync_answer_is_not_answered(sea: Sea, answer: tuple[int, int]) -> None:
    sea.settle()
    sea.say(mavlink.MAVLink_timesync_message(*answer))
    assert not [m for m in named(sea.run(0.1), "TIMESYNC") if m.tc1 != 0]


@pytest.mark.parametrize(
    "offset_s", [0.0, 5 * 3600.0, -9.5, 1.7e9], ids=["none", "hours", "earlier", "Unix"]
)
@pytest.mark.parametrize("delay_s", [0.0, 0.02, 0.1])
def test_timesync_tells_how_old_the_leaders_state_is(offset_s: float, delay_s: float) -> None:
    sea = Sea(leader=Course(5, 5, 0.5, 0.5))
    sea.leader.answers_timesync = True
    sea.leader.clock_offset_us = round(offset_s * 1e6)
    sea.leader.delay_us = round(delay_s * 1e6)
    sea.run(2.0)
    for _ in range(500):
        tick = sea.step()
        arrived = (tick.now_us - START_US - sea.leader.delay_us) // 100_000 * 100_000 + START_US
        assert sea.snapshot()["leader_age_s"] == pytest.approx(
            (tick.now_us - arrived) * 1e-6, abs=0.005
        )


def test_without_timesync_a_leaders_age_is_counted_from_its_fastest_message(sea: Sea) -> None:
    sea.leader.clock_offset_us = 7 * 3600 * 1_000_000
    sea.run(2.0)
    assert 0.0 <= sea.snapshot()["leader_age_s"] <= 0.105


def test_a_leader_whose_messages_are_too_long_on_the_way_is_stale() -> None:
    sea = Sea({"FS_LEADER_S": 0.5})
    sea.leader.answers_timesync = True
    sea.leader.clock_offset_us = 3600 * 1_000_000
    sea.leader.delay_us = 700_000
    sea.run(5.0)
    assert not sea.condition("leader_fresh")
    assert sea.snapshot()["leader_age_s"] == pytest.approx(0.75, abs=0.06)


@pytest.mark.parametrize(
    "liar",
    [Station(STRANGER, 1), Station(GCS, 190), Station(BOAT, NAVIGATION)],
    ids=["77", "255", "own"],
)
def test_answers_of_others_do_not_shift_the_leaders_clock(sea: Sea, liar: Station) -> None:
    sea.leader.answers_timesync = True
    sea.run(2.0)
    for _ in range(300):
        tick = sea.step()
        for m in tick.named("TIMESYNC"):
            if m.tc1 == 0:
                sea.say(mavlink.MAVLink_timesync_message(m.ts1 + 10**12, m.ts1), sender=liar)
        assert sea.snapshot()["leader_age_s"] < 0.105
        assert sea.condition("leader_fresh")


def test_answers_to_questions_never_asked_do_not_shift_the_leaders_clock(sea: Sea) -> None:
    rng = random.Random(5)
    sea.leader.answers_timesync = True
    sea.run(2.0)
    for _ in range(300):
        tc1, ts1 = rng.randrange(1, 2**62), rng.randrange(-(2**62), 2**62)
        sea.say(mavlink.MAVLink_timesync_message(tc1, ts1), sender=sea.leader.station)
        sea.step()
        assert 0.0 <= sea.snapshot()["leader_age_s"] < 0.105


def test_a_boat_and_its_follower_agree_about_time() -> None:
    """Two boats: the follower's leader is a flotilla.Boat hours ahead, with 50 ms latency."""
    sea = Sea({"CTL_RATE": 100})
    sea.leader.on = False
    ahead_us, delay = 4 * 3600 * 1_000_000, 5
    first = flotilla.Boat({"MAV_SYSID": LEADER, "FORM_LEADER": 100})
    unit = Station(LEADER, NAVIGATION)
    to_first: dict[int, bytes] = defaultdict(bytes)
    to_second: dict[int, bytes] = defaultdict(bytes)
    course = Course(5.0, 5.0, 0.5, 0.5, 0.0, 0.1)
    for k in range(600):
        there_us = sea.now_us + ahead_us
        if k % 5 == 0:
            here = course.at((sea.now_us - START_US) * 1e-6)
            first.on_mavlink(unit.pack(origin(), odometry(here, there_us)), there_us)
        first.on_mavlink(to_first.pop(k, b""), there_us)
        for _, data in first.tick(there_us).mavlink:
            to_second[k + delay] += data
        sea.boat.on_mavlink(to_second.pop(k, b""), sea.now_us)
        for _, data in sea.step().mavlink:
            to_first[k + delay] += data
    truth = course.at((sea.ticks[-1].now_us - START_US) * 1e-6)
    ahead, starboard, turn = sea.own.course.minus(truth)
    error = sea.snapshot()["error"]
    assert sea.condition("leader_fresh")
    assert (error["x_m"], error["y_m"]) == pytest.approx((ahead, starboard), abs=0.02)
    assert error["psi_rad"] == pytest.approx(turn, abs=0.005)


@pytest.mark.parametrize(("rate_Hz", "often"), [(1.0, 10), (0.0, 10), (5.0, 10), (0.2, 2)])
def test_a_slow_radio_is_asked_at_the_rate_of_sr_slow_and_the_own_unit_every_second(
    rate_Hz: float, often: int
) -> None:
    sea = Sea({"SR_SLOW": rate_Hz}, links=2)  # the unit speaks on link 0
    sea.settle()
    ticks = sea.run(10.0)
    assert [sum(asks(tick, link) for tick in ticks) for link in (0, 1)] == [10, often]


@pytest.mark.parametrize("after_s", [0.04, 0.3, 0.97, 5.0])
def test_timesync_requests_follow_a_raised_sr_slow_at_once(after_s: float) -> None:
    sea = Sea({"SR_SLOW": 0.1}, links=2)
    sea.settle()
    sea.run(30.0)
    while not asks(sea.step(), 1):
        pass
    asked_us = [sea.now_us]
    sea.run(after_s)
    sea.say(param_set("SR_SLOW", 1.0))
    changed_us = sea.now_us
    asked_us += [tick.now_us for tick in sea.run(3.0) if asks(tick, 1)]
    assert asked_us[1] - max(asked_us[0], changed_us - 100_000) <= 1_100_000
    assert max(b - a for a, b in pairwise(asked_us[1:])) <= 1_010_000


def test_an_answer_on_another_link_than_the_units_says_nothing_of_its_age() -> None:
    sea = Sea({"NAV_LAG_S": -1.0, "FORM_LAG_S": 0.0}, links=2)
    sea.own.delay_us = 3_000_000
    for _ in range(900):
        for asked in sea.step().named("TIMESYNC", 1):
            if asked.tc1 == 0:
                late_ns = 1000 * (sea.now_us - sea.own.delay_us)
                answer = mavlink.MAVLink_timesync_message(late_ns, asked.ts1)
                sea.say(answer, sender=Station(BOAT, NAVIGATION), link=1)
    assert not sea.condition("own_timed")


@pytest.mark.parametrize("who", ["own", "leader"])
def test_a_sender_whose_answers_stop_is_still_followed_and_its_late_states_are_late(
    who: str,
) -> None:
    """Clocks may drift apart by 0.2 s in 17 minutes."""
    sea = Sea({"NAV_LAG_S": -1.0, "FORM_LAG_S": -1.0, "FS_NAV_S": 0.2, "FS_LEADER_S": 0.2})
    sea.own.answers_timesync = sea.leader.answers_timesync = True
    sea.run(5.0)
    sea.enter_formation()
    sender = getattr(sea, who)
    sender.answers_timesync = False
    sea.period_us = 100_000  # a step for each message, to save time
    for _ in range(20):
        sea.run(60.0)
        assert sea.state == "FORMATION" and sea.condition(f"{who}_timed")
    sender.delay_us = 350_000
    sea.run(10.0)
    assert not sea.condition(f"{who}_fresh")
