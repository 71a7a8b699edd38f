# SPDX-License-Identifier: MIT
"""Impossible positions of the boat or its leader: rejected, reported, accepted if they persist."""

from __future__ import annotations

from dataclasses import replace

import pytest

from tests.target.course import Course
from tests.target.hull import Afloat, Hull, s_curve
from tests.target.sea import Sea, texts
from tests.target.stations import (
    FORMATION,
    LEADER,
    LEADER_COMPONENT,
    LOITER,
    Station,
    odometry,
    state_messages,
)


def sailing() -> Afloat:
    sea = Afloat({"FS_LEADER_ACT": 0}, Hull([-2.0, 1.0, 0.3, 0, 0, 0]), s_curve)
    sea.enter_formation()
    sea.run(8.0)
    assert sea.state == "FORMATION" and sea.counter("mavlink_jump") == 0
    return sea


@pytest.mark.parametrize(
    "off",
    [{"north": 5.0}, {"east": -100.0}, {"psi": 1.5}, {"u": 8.0}, {"r": 10.0}],
    ids=lambda off: next(iter(off)),
)
def test_one_impossible_state_of_the_leader_changes_nothing(off: dict[str, float]) -> None:
    sea = sailing()
    truth = sea.leader.truth(sea.now_us)
    wrong = replace(truth, **{name: getattr(truth, name) + by for name, by in off.items()})
    before = sea.snapshot()["error"]
    sea.say(odometry(wrong, sea.now_us + 1), sender=sea.leader.station)
    sea.step()
    assert sea.counter("mavlink_jump") == 1
    assert not sea.condition("leader_steady") and sea.state == "HOLD"
    assert sea.snapshot()["error"] == pytest.approx(before, abs=0.05)
    assert any("leader's state jumps" in text for text in texts(sea.ticks))
    sea.run(0.9)
    assert not sea.condition("leader_steady")
    sea.run(0.2)
    assert sea.condition("leader_steady")
    sea.mode(FORMATION)
    sea.run(1.0)
    assert sea.state == "FORMATION" and sea.counter("mavlink_jump") == 1


def test_an_impossible_own_position_stops_the_boat_at_once() -> None:
    sea = sailing()
    truth = sea.own.truth(sea.now_us)
    sea.say(odometry(replace(truth, north=truth.north + 8.0), sea.now_us), sender=sea.own.station)
    sea.step()
    assert sea.state == "HOLD" and sea.commands == (0, 0)
    assert not sea.condition("own_steady")
    assert sea.own_course().north == pytest.approx(truth.north, abs=0.3)
    sea.run(1.2)
    assert sea.condition("own_steady")


def test_a_new_own_position_is_accepted_after_a_second() -> None:
    sea = sailing()
    begin_us = sea.now_us
    sea.own.measured = lambda now_us: replace(
        sea.own.truth(now_us), east=sea.own.truth(now_us).east + 40.0
    )
    sea.run(0.9)
    assert not sea.condition("own_fresh") and sea.state == "HOLD"
    while not sea.condition("own_fresh"):
        sea.step()
    assert 1_000_000 <= sea.now_us - begin_us < 1_200_000
    sea.run(1.2)
    assert sea.condition("own_steady") and sea.condition("own_fresh")
    truth = sea.own.truth(sea.now_us)
    assert sea.own_course().east == pytest.approx(truth.east + 40.0, abs=0.3)


@pytest.mark.parametrize("clock_us", [0, 30_000, -700_000, 45_000_000, 7_200_000_000])
@pytest.mark.parametrize("kind", ["ODOMETRY", "LOCAL_POSITION_NED"])
def test_of_two_leaders_with_one_id_the_first_is_followed(clock_us: int, kind: str) -> None:
    """A second vessel 20 m beside the leader has its id, with any clock."""
    sea = Sea(leader=Course(5.0, 5.0, 0.5, 0.4))
    sea.enter_hold()
    sea.leader.on = False
    leader, other = (Station(LEADER, LEADER_COMPONENT) for _ in range(2))
    for k in range(1450):  # the second one is forgotten after ten seconds
        truth = sea.leader.truth(sea.now_us)
        if k % 10 == 0:
            sea.say(*state_messages(kind, truth, sea.now_us), sender=leader)
        if k % 10 == 4 and 100 <= k < 400:
            beside = replace(truth, east=truth.east + 20.0)
            sea.say(*state_messages(kind, beside, sea.now_us + clock_us), sender=other)
        sea.step()
        if k > 20:
            assert sea.condition("leader_fresh"), k
            error = sea.snapshot()["error"]
            assert abs(error["x_m"]) < 12.0 and abs(error["y_m"]) < 12.0, k
        if 120 <= k < 400:
            assert not sea.condition("leader_steady"), k
    assert sea.condition("leader_steady") and sea.condition("leader_fresh")


@pytest.mark.parametrize("clock_us", [-6_000_000, 45_000_000, -7_200_000_000])
def test_two_vessels_with_the_leaders_id_are_distinguished_by_their_clocks_alone(
    clock_us: int,
) -> None:
    """The second one lies alongside, at a position that is possible for the leader."""
    sea = Sea(leader=Course(5.0, 5.0, 0.5, 0.4), start_us=8_000_000_000)
    sea.enter_hold()
    sea.leader.on = False
    leader, other = (Station(LEADER, LEADER_COMPONENT) for _ in range(2))
    for k in range(3000):
        truth = sea.leader.truth(sea.now_us)
        if k % 10 == 0:
            sea.say(*state_messages("POSITION", truth, sea.now_us), sender=leader)
        if k % 100 == 54 and 500 <= k < 1500:
            beside = replace(truth, east=truth.east + 0.3)
            sea.say(*state_messages("POSITION", beside, sea.now_us + clock_us), sender=other)
        sea.step()
        if k == 400:
            sea.mode(FORMATION)
        if 800 <= k < 1500:
            assert not sea.condition("leader_steady") and sea.state != "FORMATION", k
    assert texts(sea.ticks).count(f"two vessels use system id {LEADER}") == 2
    assert sea.condition("leader_steady")


@pytest.mark.parametrize("late_s", [6.0, 20.0])
def test_a_leader_that_reboots_or_whose_message_comes_late_is_one_vessel(late_s: float) -> None:
    sea = Sea(leader=Course(5.0, 5.0, 0.5, 0.4), start_us=8_000_000_000)
    sea.settle()
    sea.leader.on = False
    leader = Station(LEADER, LEADER_COMPONENT)
    for k in range(3000):
        truth = sea.leader.truth(sea.now_us)
        clock_us = sea.now_us if k < 1500 else sea.now_us - 7_000_000_000
        if k % 10 == 0:
            sea.say(*state_messages("POSITION", truth, clock_us), sender=leader)
        if k % 700 == 301:
            then_us = clock_us - round(late_s * 1e6)
            sea.say(*state_messages("POSITION", truth, then_us), sender=leader)
        sea.step()
    assert not [text for text in texts(sea.ticks) if "two vessels" in text]


def test_a_disarmed_boat_may_be_fast_but_may_not_jump() -> None:
    sea = Sea(own=Course(0.0, 0.0, 0.3, 15.0))
    sea.run(5.0)
    assert sea.condition("own_steady")
    sea.own.course = replace(sea.own.course, east=100.0)
    sea.run(0.1)
    assert not sea.condition("own_steady")
    sea.run(2.2)
    assert sea.condition("own_steady")


def teleport(sea: Afloat, north_m: float) -> None:
    truth = sea.leader.truth
    sea.leader.measured = lambda now_us: replace(truth(now_us), north=truth(now_us).north + north_m)


@pytest.mark.parametrize("far_m", [60.0, 2000.0])
def test_a_leader_that_jumps_and_stays_there_is_followed_after_a_new_request(far_m: float) -> None:
    sea = Afloat({"FORM_DIST_MAX": 100.0}, Hull([-2.0, 1.0, 0.3, 0, 0, 0]), s_curve)
    sea.enter_formation()
    sea.run(8.0)
    assert sea.state == "FORMATION"
    begin = sea.own_course()
    teleport(sea, far_m)
    sea.run(0.2)
    assert sea.state == "COAST"
    sea.run_until("HOLD", 6.0)
    sea.run(10.0)
    assert sea.state == "HOLD" and sea.own_course().north < begin.north + 10.0
    assert sea.condition("leader_steady") and sea.condition("leader_near") == (far_m < 100.0)
    sea.mode(FORMATION)
    assert sea.state == ("FORMATION" if far_m < 100.0 else "HOLD")
    if far_m > 100.0:
        assert "Refused: leader is beyond FORM_DIST_MAX" in texts(sea.ticks)
    sea.run(2.0)  # the jump itself no longer counts
    assert sea.state == ("FORMATION" if far_m < 100.0 else "HOLD")


def test_a_boat_in_loiter_follows_a_leader_that_jumped_after_a_new_request() -> None:
    sea = Afloat(None, Hull([-2.0, 1.0, 0.3, 0, 0, 0]), s_curve)
    sea.enter_formation()
    sea.run(8.0)
    sea.mode(LOITER)
    sea.run(1.0)
    teleport(sea, 40.0)
    sea.run(0.2)
    sea.mode(FORMATION)
    assert sea.state == "LOITER"
    sea.run(10.0)
    sea.mode(FORMATION)
    assert sea.state == "FORMATION"


@pytest.mark.parametrize(
    ("limit_m", "slot_m", "north_m", "near"),
    [
        (200.0, 0.0, 190.0, True),
        (200.0, 0.0, 210.0, False),
        (200.0, -900.0, 900.0, True),  # counted beyond the slot
        (200.0, -900.0, 1120.0, False),
        (0.0, 0.0, 4900.0, True),
    ],
)
def test_a_leader_that_is_too_far_away_is_not_followed(
    limit_m: float, slot_m: float, north_m: float, near: bool
) -> None:
    parameters = {"FORM_DIST_MAX": limit_m, "FORM_OFS_N": slot_m}
    sea = Sea(parameters, own=Course(), leader=Course(north_m, 0.0, 0.0))
    sea.enter_hold()
    assert sea.condition("leader_near") == near and sea.condition("leader_fresh")
    sea.mode(FORMATION)
    assert sea.state == ("FORMATION" if near else "HOLD")


def test_a_leader_that_sails_away_is_lost() -> None:
    sea = Sea({"FORM_DIST_MAX": 20.0}, own=Course(), leader=Course(18.0, 0.0, 0.0, 1.0))
    sea.enter_formation()
    sea.run_until("COAST", 4.0)
    assert "leader is beyond FORM_DIST_MAX" in " ".join(texts(sea.ticks))
    sea.run_until("HOLD", 6.0)
