# SPDX-License-Identifier: MIT
"""States repeated with new time stamps: reported, the boat stops, and may recover."""

from __future__ import annotations

import random
from dataclasses import replace
from typing import Any

import pytest
from pymavlink.dialects.v20 import common as mavlink

from tests.target.course import Course
from tests.target.hull import Afloat, Hull, s_curve
from tests.target.operator_words import command_int
from tests.target.plans import at
from tests.target.sea import Sea, texts
from tests.target.stations import (
    BOAT,
    FORMATION,
    NAVIGATION,
    Station,
    attitude,
    gps,
    odometry,
    origin,
)


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
    assert any("navigation data frozen" in text for text in texts(sea.ticks))
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


def test_a_boat_that_may_be_held_in_place_gets_its_long_try_once() -> None:
    sea = Afloat({"FS_LEADER_ACT": 0}, Hull(), s_curve)
    measured = sea.own.measured
    still = {"north": 0.0, "east": 0.0, "u": 0.0, "v": 0.0, "r": 0.0}
    sea.own.measured = lambda now_us: replace(measured(now_us), **still)
    sea.enter_formation()
    sea.run(4.5)
    assert sea.state == "FORMATION"
    for _ in range(3):
        sea.run(5.0)
        assert sea.state == "HOLD"
        sea.mode(FORMATION)
        sea.run(0.2)
        assert sea.state == "FORMATION"
        sea.run(1.0)
        assert sea.state == "HOLD" and not sea.condition("boat_answers")


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


def guided(own_period_us: int = 50_000) -> Afloat:
    """A boat without a leader that sails by itself to a place 60 m north."""
    sea = Afloat({"LAW_U_MAX": 1.5}, own_period_us=own_period_us)
    sea.leader.on = False
    sea.enter_hold()
    place = at(60.0, 0.0)
    sea.say(command_int(192, -1.0, 1.0, x=place.x, y=place.y, frame=5))
    sea.run(10.0)
    assert sea.state == "GUIDED" and sea.hull.q[3] > 0.4
    return sea


@pytest.mark.parametrize("noise_m", [1e-5, 0.005, 0.02])
@pytest.mark.parametrize("sailing", [sailing, guided], ids=["FORMATION", "GUIDED"])
def test_a_place_that_is_frozen_but_for_noise_stops_the_boat_within_ten_seconds(
    sailing: Any, noise_m: float
) -> None:
    sea = sailing()
    here, rng = sea.own.truth(sea.now_us), random.Random(3)
    sea.own.measured = lambda now_us: replace(
        sea.own.truth(now_us),
        north=here.north + rng.gauss(0.0, noise_m),
        east=here.east + rng.gauss(0.0, noise_m),
    )
    seconds_until(sea, "own_live", False, 10.0)
    assert sea.state == "HOLD" and sea.commands == (0, 0)
    sea.run(60.0)  # the boat rests, and only another place shows that the unit is live
    assert not sea.condition("own_live")
    del sea.own.measured
    seconds_until(sea, "own_live", True, 1.5)


@pytest.mark.parametrize("sailing", [sailing, guided], ids=["FORMATION", "GUIDED"])
@pytest.mark.parametrize("speed", [0.0, None], ids=["no velocity", "the last velocity"])
def test_a_unit_that_hangs_while_its_heading_lives_stops_the_boat_within_ten_seconds(
    sailing: Any, speed: float | None
) -> None:
    """Its place varies by micrometres; its velocity is 0, or the last one."""
    sea = sailing()
    here = sea.own.truth(sea.now_us)
    u, v = (here.u, here.v) if speed is None else (speed, speed)
    sea.own.measured = lambda now_us: replace(
        sea.own.truth(now_us),
        north=here.north + 1e-6 * (now_us // 50_000 % 3),
        east=here.east,
        u=u,
        v=v,
    )
    sea.run(10.0)
    assert sea.state == "HOLD" and sea.commands == (0, 0)


def test_a_unit_that_hangs_and_sends_two_kinds_of_messages_in_turn_stops_the_boat() -> None:
    """Each comes 0.35 s after the other, when the boat has given that one up."""
    sea = guided()
    sea.own.on = False
    here, unit = sea.own.truth(sea.now_us), Station(BOAT, NAVIGATION)
    place, (north, east) = at(here.north, here.east), here.velocity_n
    for k in range(29):
        sea.say(origin(sea.now_us), gps(), sender=unit)
        if k % 2:
            sea.say(odometry(here, sea.now_us), sender=unit)
        else:
            boot_ms, velocity = sea.now_us // 1000, (round(100 * north), round(100 * east), 0)
            position = mavlink.MAVLink_global_position_int_message(
                boot_ms, place.x, place.y, 0, 0, *velocity, 65535
            )
            sea.say(attitude(here, sea.now_us), position, sender=unit)
        sea.run(0.35)
    assert sea.state == "HOLD" and sea.commands == (0, 0)
