# SPDX-License-Identifier: MIT
"""States repeated with new time stamps: reported, the boat stops, and may recover."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

from tests.target.course import Course
from tests.target.hull import Afloat, Hull, s_curve
from tests.target.sea import Sea, texts
from tests.target.stations import FORMATION


def sailing(own_period_us: int = 50_000) -> Afloat:
    """A boat that has followed the paper's leader for some seconds."""
    sea = Afloat({"FS_LEADER_ACT": 0}, Hull([-2.0, 1.0, 0.3, 0, 0, 0]), s_curve, own_period_us)
    sea.enter_formation()
    sea.run(8.0)
    assert sea.state == "FORMATION"
    return sea


def freeze(sea: Sea, who: str, **changed: float) -> None:
    """From now on, repeat the sender's last state, `changed`, with new time stamps."""
    agent = getattr(sea, who)
    last = replace(agent.measured(agent.next_us - agent.period_us), **changed)
    agent.measured = lambda _now_us: last


def seconds_until(sea: Sea, condition: str, met: bool, most_s: float) -> float:
    since_us = sea.now_us
    while sea.condition(condition) != met:
        sea.step()
        assert sea.now_us - since_us < most_s * 1e6, sea.snapshot()
    return (sea.now_us - since_us) * 1e-6


@pytest.mark.parametrize("period_us", [10_000, 50_000, 100_000])
def test_an_own_state_that_sticks_stops_a_boat_within_half_a_second(period_us: int) -> None:
    sea = sailing(period_us)
    freeze(sea, "own")
    seconds_until(sea, "own_live", False, 0.55)
    assert sea.state == "HOLD" and sea.commands == (0, 0)
    assert any("own state is frozen" in text for text in texts(sea.ticks))
    assert sea.condition("own_fresh")
    del sea.own.measured
    seconds_until(sea, "own_live", True, 0.5)
    sea.run(1.5)  # the boat moved on meanwhile, which may look like a jump
    sea.mode(FORMATION)
    sea.run(1.0)
    assert sea.state == "FORMATION"


def test_a_leader_that_sticks_is_not_followed_after_a_second() -> None:
    sea = sailing()
    freeze(sea, "leader")
    seconds_until(sea, "leader_live", False, 1.0)
    assert sea.state == "HOLD" and sea.condition("leader_fresh")
    del sea.leader.measured
    seconds_until(sea, "leader_live", True, 0.5)


@pytest.mark.parametrize("leader", [Course(), s_curve], ids=["from the start", "after sailing"])
def test_a_leader_at_rest_is_followed_for_as_long_as_it_rests(leader: Any) -> None:
    """15 s: three times as long as the longest repetition that is ever allowed."""
    sea = Afloat({}, Hull([-2.0, 1.0, 0.3, 0, 0, 0]), leader)
    sea.enter_formation()
    sea.run(4.0)
    freeze(sea, "leader", u=0.0, v=0.0, r=0.0)
    sea.run(15.0)
    assert sea.state == "FORMATION" and sea.condition("leader_live")


@pytest.mark.parametrize("stuck", ["place", "place and velocity", "all"])
def test_a_unit_that_was_stuck_before_it_started_stops_the_boat_within_nine_seconds(
    stuck: str,
) -> None:
    """A boat may be held in place: it gets 5 s to 8 s before it counts as not responding."""
    sea = Afloat({"FS_LEADER_ACT": 0}, Hull(), s_curve)
    measured = sea.own.measured

    def at_rest(now_us: int) -> Course:
        if stuck == "all":
            return Course()
        still = {"u": 0.0, "v": 0.0, "r": 0.0} if stuck != "place" else {}
        return replace(measured(now_us), north=0.0, east=0.0, **still)

    sea.own.measured = at_rest
    sea.enter_formation()
    for _ in range(900):
        sea.step()
        if sea.state != "FORMATION":
            break
    assert sea.state == "HOLD" and sea.commands == (0, 0)
    assert not sea.condition("own_live") or not sea.condition("boat_answers")


def test_a_boat_that_lies_still_with_exact_instruments_may_be_armed() -> None:
    sea = Sea(own=Course(1.0, 2.0, 0.3))
    freeze(sea, "own")
    sea.run(15.0)
    assert sea.condition("own_live")
    sea.enter_hold()


def test_a_position_that_stops_changing_is_frozen_even_if_the_velocity_changes() -> None:
    sea = sailing()
    here = sea.own.truth(sea.now_us)
    sea.own.measured = lambda now_us: replace(
        sea.own.truth(now_us), north=here.north, east=here.east
    )
    seconds_until(sea, "own_live", False, 1.0)
    assert sea.state == "HOLD"
