# SPDX-License-Identifier: MIT
"""A boat sends no position relative to an origin that is outdated or unknown to followers."""

from __future__ import annotations

from itertools import product
from typing import Any

import pytest
from pymavlink.dialects.v20 import common as mavlink

from tests.each_push import few
from tests.target.course import Course
from tests.target.sea import Sea, Tick, acks, named
from tests.target.stations import (
    ORIGIN,
    attitude,
    local_position,
    odometry,
    origin,
)

NEW = (ORIGIN[0] + 50_000, ORIGIN[1] - 30_000, ORIGIN[2])
LINKS = pytest.mark.parametrize("bytes_per_s", [0, 400, 1200], ids=["free", "400", "1200"])
ON_THE_GLOBE = {"GLOBAL_POSITION_INT", "FOLLOW_TARGET", "GPS_GLOBAL_ORIGIN"}


def two_links(bytes_per_s: int, **how: Any) -> Sea:
    """A sea with two links, the second one slow."""
    sea = Sea(links=2, **how)
    if bytes_per_s:
        sea.boat.limit_link(1, bytes_per_s)
    return sea


@LINKS
@pytest.mark.parametrize("silent_s", [0.0, 1.5])
def test_after_a_restart_of_its_unit_no_position_is_sent_before_the_origin(
    bytes_per_s: int, silent_s: float
) -> None:
    sea = two_links(bytes_per_s, own=Course(1.0, 2.0, 0.3))
    sea.run(10.0)
    for link in (0, 1):
        assert named(sea.ticks[-200:], "LOCAL_POSITION_NED", link)
    sea.own.on = False
    sea.run(silent_s)
    sea.own.clock_offset_us = -sea.now_us
    sea.own.origin_on = False
    sea.own.course = Course(-7.0, 3.0, 0.3)
    sea.own.on = True
    for _ in range(50):
        for tick in sea.run(0.1):
            for link in (0, 1):
                for m in tick.named("LOCAL_POSITION_NED", link):
                    assert m.x == pytest.approx(1.0, abs=0.1), "the new frame, the old origin"
    assert sea.condition("own_fresh")
    ticks = sea.run(2.0)
    for link in (0, 1):
        assert not named(ticks, "LOCAL_POSITION_NED", link)
        assert named(ticks, "ATTITUDE", link)
        assert not {m.get_type() for t in ticks for m in t.messages(link)} & ON_THE_GLOBE
    for message_id in (32, 33, 49, 144):
        assert acks(sea.order(512, float(message_id))) == [(512, 1)]
    sea.say(origin(0, *NEW), sender=sea.own.station)
    told_in_order(sea.run(3.0), Course(-7.0, 3.0), NEW)


def told_in_order(ticks: list[Tick], where: Course, place: tuple[int, int, int]) -> None:
    """Assert that each link gets that origin first, in the tick of the first position from it."""
    for link in (0, 1):
        first = next(t for t in ticks if t.named("LOCAL_POSITION_NED", link))
        kinds = [m.get_type() for m in first.messages(link)]
        assert "GPS_GLOBAL_ORIGIN" in [
            m.get_type() for t in ticks if t.now_us <= first.now_us for m in t.messages(link)
        ]
        if "GPS_GLOBAL_ORIGIN" in kinds:
            assert kinds.index("GPS_GLOBAL_ORIGIN") < kinds.index("LOCAL_POSITION_NED")
        for m in named(ticks, "GPS_GLOBAL_ORIGIN", link):
            assert (m.latitude, m.longitude) == place[:2]
        for m in named(ticks, "LOCAL_POSITION_NED", link):
            assert (m.x, m.y) == pytest.approx((where.north, where.east), abs=0.1)


@pytest.mark.parametrize(
    ("bytes_per_s", "busy"), few(product((0, 400, 1200), (False, True)), [(0, False), (1200, True)])
)
def test_a_new_origin_is_sent_before_any_position_relative_to_it(
    bytes_per_s: int, busy: bool
) -> None:
    """At any phase of the link's schedule."""
    old, new = Course(1.0, 2.0, 0.3), Course(-400.0, 300.0, 0.3)
    for delay in range(0, 30, 3):
        sea = two_links(bytes_per_s, own=old)
        sea.own.origin_on = False
        sea.say(origin(), sender=sea.own.station)
        sea.run(3.0 + delay * 0.01)
        place: tuple[int, int, int] = ORIGIN
        known: dict[int, tuple[int, int]] = {0: ORIGIN[:2], 1: ORIGIN[:2]}
        for k in range(400):
            if k == 100:
                sea.own.course, place = new, NEW
                sea.say(origin(0, *place), sender=sea.own.station)
                sea.say(odometry(new, sea.now_us), sender=sea.own.station)
                sea.own.next_us = sea.now_us + 50_000
            if busy:
                ping = mavlink.MAVLink_ping_message(1, k, 0, 0)
                sea.say(*[ping] * 20, link=1)
            tick = sea.step()
            for link in (0, 1):
                for m in tick.messages(link):
                    if m.get_type() == "GPS_GLOBAL_ORIGIN":
                        known[link] = (m.latitude, m.longitude)
                    if m.get_type() == "LOCAL_POSITION_NED":
                        there = old if known[link] == ORIGIN[:2] else new
                        assert m.x == pytest.approx(there.north, abs=0.5), (delay, k)
        assert known == {0: NEW[:2], 1: NEW[:2]}
        for link in (0, 1):
            assert named(sea.ticks[-300:], "LOCAL_POSITION_NED", link)


@LINKS
def test_a_new_origin_leaves_in_the_tick_of_the_first_position(bytes_per_s: int) -> None:
    sea = two_links(bytes_per_s, own=Course(1.0, 2.0, 0.3))
    sea.own.origin_on = False
    sea.say(origin(), sender=sea.own.station)
    sea.run(5.05)
    near = (ORIGIN[0] + 40, ORIGIN[1], ORIGIN[2])  # 0.44 m: no jump
    sea.say(origin(0, *near), sender=sea.own.station)
    sea.say(odometry(sea.own.course, sea.now_us), sender=sea.own.station)
    tick = sea.step()
    for link in (0, 1):
        (told,) = tick.named("GPS_GLOBAL_ORIGIN", link)
        assert (told.latitude, told.longitude) == near[:2]


# A late copy is not a reboot.


def follow_target(truth: Course, time_us: int) -> Any:
    """FOLLOW_TARGET of a leader that also sends local positions."""
    north, east = truth.velocity_n
    return mavlink.MAVLink_follow_target_message(
        time_us // 1000,
        15,
        ORIGIN[0] + round(truth.north / 0.0111),
        ORIGIN[1],
        488.0,
        [north, east, 0.0],
        [0.0] * 3,
        [1.0, 0.0, 0.0, 0.0],
        [0.0] * 3,
        [0.0] * 3,
        0,
    )


@pytest.mark.parametrize("late_s", [0.2, 0.6, 1.1, 1.6, 4.0])
@pytest.mark.parametrize("every", [1, 8, 20])
def test_a_late_copy_of_another_source_is_not_taken_for_a_restart(
    late_s: float, every: int
) -> None:
    """FOLLOW_TARGET by a slow path beside fresh positions: the origin stays known."""
    sea = Sea(own=Course())
    sea.leader.on = False
    truth = Course(5.0, 5.0)
    for k in range(600):
        if k % 10 == 0:
            said = [local_position(truth, sea.now_us), attitude(truth, sea.now_us)]
            if k == 0:
                said.insert(0, origin())
            sea.say(*said, sender=sea.leader.station)
        if k > 100 and k % (10 * every) == 5:
            late = follow_target(truth, sea.now_us - round(late_s * 1e6))
            jittered = follow_target(truth, sea.now_us - round(late_s * 1e6) - 300_000)
            sea.say(late, jittered, sender=sea.leader.station)
        sea.step()
        if k > 100:
            assert sea.condition("leader_fresh"), k
            assert sea.snapshot()["error"]["x_m"] == pytest.approx(-5.0, abs=0.3)


def test_a_late_attitude_and_a_late_odometry_are_no_reboot_either() -> None:
    sea = Sea(own=Course())
    sea.leader.on = False
    truth = Course(5.0, 5.0)
    for k in range(600):
        if k % 10 == 0:
            said = [local_position(truth, sea.now_us), attitude(truth, sea.now_us)]
            if k == 0:
                said.insert(0, origin())
            sea.say(*said, sender=sea.leader.station)
        if k in (150, 250, 340):  # stamps that go back, each further
            stamp = sea.now_us - 1_600_000 - 10_000 * k
            sea.say(odometry(truth, stamp), attitude(truth, stamp), sender=sea.leader.station)
        sea.step()
        if k > 100:
            assert sea.condition("leader_fresh"), k
