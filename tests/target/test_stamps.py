# SPDX-License-Identifier: MIT
"""Time stamps of states: repeated, older, from the future, or of a restarted clock."""

from __future__ import annotations

import pytest

from tests.target.course import Course
from tests.target.sea import Sea, assert_finite
from tests.target.stations import odometry, origin, state_messages


@pytest.mark.parametrize("agent", ["own", "leader"])
@pytest.mark.parametrize("kind", ["ODOMETRY", "LOCAL_POSITION_NED"])
def test_a_duplicate_and_an_older_state_are_counted_and_ignored(
    sea: Sea, agent: str, kind: str
) -> None:
    whose = getattr(sea, agent)
    sea.speak_for(whose, kind)
    stamp_us, good = sea.now_us - 50_000, sea.own_course()
    error = sea.snapshot()["error"]
    elsewhere = Course(500.0, 500.0, 2.0, 1.0, 1.0, 1.0)
    for late_us in (0, 50_000, 100_000, 300_000):
        before = sea.counter("mavlink_old_stamp")
        sent = state_messages(kind, elsewhere, stamp_us - late_us)
        sea.say(*sent[:1], sender=whose.station)  # the heading alone has a test of its own
        sea.run(0.05)
        assert sea.counter("mavlink_old_stamp") == before + 1
        assert sea.own_course().close_to(good, 1e-3)
        assert sea.snapshot()["error"] == pytest.approx(error, abs=1e-3)


@pytest.mark.parametrize("agent", ["own", "leader"])
def test_an_old_state_does_not_keep_a_state_fresh(sea: Sea, agent: str) -> None:
    sea.run(1.0)
    whose = getattr(sea, agent)
    whose.on = False
    frozen_us = sea.now_us
    for _ in range(20):
        sea.say(origin(), odometry(whose.course, frozen_us), sender=whose.station)
        sea.run(0.1)
        if sea.now_us - frozen_us > 1_150_000:
            assert not sea.condition(f"{agent}_fresh")


@pytest.mark.parametrize("agent", ["own", "leader"])
def test_a_clock_that_starts_anew_is_believed_after_a_while(sea: Sea, agent: str) -> None:
    sea.run(2.0)
    getattr(sea, agent).clock_offset_us = -sea.now_us
    sea.run(3.0)
    assert sea.condition(f"{agent}_fresh")
    assert sea.counter("mavlink_old_stamp") > 0
    assert sea.snapshot()[f"{agent}_age_s"] < 0.15


@pytest.mark.parametrize("agent", ["own", "leader"])
def test_one_stamp_from_the_future_does_not_poison_the_track(sea: Sea, agent: str) -> None:
    sea.run(2.0)
    whose = getattr(sea, agent)
    sea.say(odometry(whose.course, sea.now_us + 3_600_000_000), sender=whose.station)
    sea.run(3.0)
    assert sea.condition(f"{agent}_fresh")
    assert 0.0 <= sea.snapshot()[f"{agent}_age_s"] < 0.15


@pytest.mark.parametrize("kind", ["ODOMETRY", "LOCAL_POSITION_NED"])
def test_extreme_stamps_never_upset_a_boat(sea: Sea, kind: str) -> None:
    for stamp in (0, 1, 2**32 * 1000 - 1000, 2**63 - 1, 2**63, 2**64 - 1):
        for whose in (sea.own, sea.leader):
            for message in state_messages(kind, whose.course, 0):
                if kind == "ODOMETRY":
                    message.time_usec = stamp
                else:
                    message.time_boot_ms = stamp // 1000 % 2**32
                sea.say(message, sender=whose.station)
        sea.run(0.1)
        assert_finite(sea.snapshot())
    sea.run(3.0)
    assert sea.condition("own_fresh") and sea.condition("leader_fresh")
