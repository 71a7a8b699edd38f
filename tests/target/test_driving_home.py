# SPDX-License-Identifier: MIT
"""A boat without navigation or with a low battery arms for MANUAL only, to be driven home."""

from __future__ import annotations

import math
from collections.abc import Callable

import pytest

from tests.target.course import TURN, Course
from tests.target.hull import Afloat, Hull, s_curve
from tests.target.operator_words import drive, enter_manual, sticks
from tests.target.sea import Sea, acks, at_sea, texts
from tests.target.stations import (
    ACCEPTED,
    ARM,
    FORMATION,
    MANUAL,
    SET_MODE,
    TEMPORARILY_REJECTED,
    Station,
)
from tests.target.test_long_texts import words

CENTRE = "MANUAL: centre the sticks first"
ONLY = "armed, no FORMATION: "


def no_own_state(sea: Sea) -> None:
    sea.own.on = False


def an_own_state_that_comes_late(sea: Sea) -> None:
    sea.own.delay_us, sea.own.answers_timesync = 900_000, True


def an_own_state_that_jumps(sea: Sea) -> None:
    sea.own.course = Course(400.0, 2.0, 0.3)


def no_leader(sea: Sea) -> None:
    sea.leader.on = False


def a_low_battery(sea: Sea) -> None:
    sea.escs[0].voltage = 20.0


LACKS: dict[Callable[[Sea], None], str] = {
    no_own_state: "no recent navigation data",
    an_own_state_that_comes_late: "no recent navigation data",
    an_own_state_that_jumps: "jump in navigation data",
    no_leader: "leader lost or origin unknown",
    a_low_battery: "battery is below FS_BATT_V, or unknown",
}


@pytest.mark.parametrize("lack", LACKS, ids=lambda lack: lack.__name__)
def test_a_boat_without_a_condition_that_manual_does_not_need_is_armed_for_manual_only(
    lack: Callable[[Sea], None],
) -> None:
    sea = Sea({"FS_BATT_V": 22.0})
    sea.run(3.0)
    lack(sea)
    sea.run(0.5 if lack is an_own_state_that_jumps else 3.0)
    tick = sea.arm()
    assert acks(tick) == [(ARM, ACCEPTED)] and sea.state == "HOLD"
    said = words([tick])
    assert said[0] == "HOLD" and ONLY + LACKS[lack] in said
    assert all(text.startswith(ONLY) for text in said[1:])
    tick = sea.mode(FORMATION)
    assert acks(tick) == [(SET_MODE, TEMPORARILY_REJECTED)] and sea.state == "HOLD"
    assert f"Refused: {LACKS[lack]}" in texts([tick])
    assert {t.commands for t in sea.run(0.3)} == {(0, 0)}
    drive(sea, 0, 0, 0.1)
    assert acks(sea.mode(MANUAL)) == [(SET_MODE, ACCEPTED)]
    drive(sea, 300)
    assert sea.state == "MANUAL" and all(c > 0 for c in sea.commands)
    assert acks(sea.mode(FORMATION)) == [(SET_MODE, TEMPORARILY_REJECTED)]


def test_a_boat_with_all_conditions_met_is_armed_without_a_message() -> None:
    sea = Sea()
    sea.run(3.0)
    assert texts([sea.arm(), *sea.run(1.0)]) == ["HOLD"]


@pytest.mark.parametrize("lost", ["nothing", "battery", "own", "battery and own"])
def test_after_a_brief_esc_failure_a_boat_can_be_driven_home(lost: str) -> None:
    sea = Sea({"FS_BATT_V": 22.0}, leader=TURN)
    sea.run(3.0)
    sea.enter_formation()
    sea.run(1.0)
    if "battery" in lost:
        sea.escs[1].voltage = 20.0
    sea.own.on = "own" not in lost
    sea.run(3.0)
    assert sea.state == ("FORMATION" if lost == "nothing" else "HOLD")
    sea.escs[0].on = False
    sea.run_until("FAULT", 2.0)
    sea.escs[0].on = True
    sea.run(1.0)
    assert acks(sea.mode(MANUAL)) == [(SET_MODE, TEMPORARILY_REJECTED)] and sea.state == "FAULT"
    sea.disarm()
    assert sea.state == "DISARMED"
    assert acks(sea.arm()) == [(ARM, ACCEPTED)]
    drive(sea, 0, 0, 0.3)
    assert acks(sea.mode(MANUAL)) == [(SET_MODE, ACCEPTED)]
    drive(sea, 300)
    assert sea.state == "MANUAL" and all(c > 0 for c in sea.commands)


def test_from_outside_the_fence_a_boat_is_armed_again_and_driven() -> None:
    leader = Course(math.cos(0.3), math.sin(0.3), 0.3, 0.5)
    fence = {"FS_FENCE_M": 3.0, "FS_FENCE_ACT": 0}
    sea = Afloat(fence, hull=Hull([0.0, 0.0, 0.3, 0, 0, 0]), leader=leader)
    sea.enter_formation()
    sea.run_until("HOLD", 15.0)
    sea.own.on = False
    sea.run(1.0)
    sea.disarm()
    tick = sea.arm()
    assert acks(tick) == [(ARM, ACCEPTED)]
    said = words([tick])
    assert ONLY + "fence: outside, ahead, or no position" in said
    drive(sea, 0, 0, 0.3)
    sea.mode(MANUAL)
    drive(sea, -500)
    assert sea.state == "MANUAL" and all(c < 0 for c in sea.commands)


@pytest.mark.parametrize("named", [True, False])
def test_a_unit_that_is_first_heard_after_arming_counts_where_its_link_is_named(
    named: bool,
) -> None:
    """Otherwise anybody on any link could pose as the unit; the operator disarms once."""
    sea = Afloat({"NAV_LINK": 0.0} if named else {}, Hull([-2.0, 1.0, 0.3, 0, 0, 0]), s_curve)
    sea.own.on = False
    sea.run(1.0)
    sea.arm()
    assert sea.state == "HOLD"
    sea.run(1.0)
    sea.own.on = True
    sea.run(3.0)
    if not named:
        assert not sea.condition("own_fresh")
        assert "navigation data ignored: disarm, or set NAV_LINK" in texts(sea.ticks)
        sea.disarm()
        sea.run(1.0)
        sea.enter_hold()
    assert acks(sea.mode(FORMATION)) == [(SET_MODE, ACCEPTED)]
    sea.run(20.0)
    error = sea.snapshot()["error"]
    assert sea.state == "FORMATION" and math.hypot(error["x_m"], error["y_m"]) < 0.2


# Sticks at neutral.


@pytest.mark.parametrize(("x", "r"), [(1000, 0), (-200, 0), (0, 1000), (120, 0), (1000, -1000)])
def test_manual_requested_with_sticks_off_neutral_gives_no_thrust_until_they_are_neutral(
    sea: Sea, x: int, r: int
) -> None:
    """It is not refused, because the law, if it is active, must stop."""
    sea.enter_formation()
    drive(sea, x, r, 0.3)
    assert acks(sea.mode(MANUAL)) == [(SET_MODE, ACCEPTED)] and sea.commands == (0, 0)
    ticks = drive(sea, x, r, 2.0)
    assert sea.state == "MANUAL" and {t.commands for t in ticks} == {(0, 0)}
    assert texts(sea.ticks)[-2:] == ["MANUAL", CENTRE] and CENTRE not in texts(ticks)
    drive(sea, 100, -100, 0.1)
    drive(sea, x, r)
    assert any(sea.commands)


def test_sticks_at_neutral_drive_at_once_without_a_message(sea: Sea) -> None:
    enter_manual(sea)
    drive(sea, 500, 0, 0.3)
    assert all(sea.commands) and CENTRE not in texts(sea.ticks)


def test_a_failsafe_that_leads_to_manual_waits_for_a_pilot_who_holds_full_ahead() -> None:
    sea = at_sea({"FS_LEADER_ACT": 2.0})
    drive(sea, 1000, 0, 0.5)
    assert sea.state == "FORMATION"
    sea.leader.on = False
    ticks = drive(sea, 1000, 0, 3.0)
    at = next(k for k, t in enumerate(ticks) if CENTRE in texts([t]))
    assert sea.state == "MANUAL" and {t.commands for t in ticks[at:]} == {(0, 0)}
    assert texts(ticks)[-2:] == ["MANUAL: leader lost or origin unknown", CENTRE]
    drive(sea, 0, 0, 0.1)
    drive(sea, 1000)
    assert all(c > 0 for c in sea.commands)


def test_sticks_that_fell_silent_and_come_back_full_move_nothing(sea: Sea) -> None:
    enter_manual(sea)
    drive(sea, 300)
    sea.run(0.6)
    assert sea.state == "HOLD"
    assert {t.commands for t in drive(sea, 1000, 0, 1.0)} == {(0, 0)} and sea.state == "HOLD"
    assert acks(sea.mode(MANUAL)) == [(SET_MODE, ACCEPTED)]
    assert {t.commands for t in drive(sea, 1000, 0, 1.0)} == {(0, 0)} and sea.state == "MANUAL"


@pytest.mark.parametrize("before_us", [1, 3_000, 9_000])
def test_another_pilot_who_takes_up_silent_sticks_at_full_moves_nothing(before_us: int) -> None:
    """Also if he begins before the tick that would have detected the silence."""
    sea = Sea()
    enter_manual(sea)
    drive(sea, 0, 0, 0.05)
    last_us = sea.now_us - 50_000
    while sea.now_us < last_us + 500_000:
        sea.step()
    assert sea.state == "MANUAL"
    pilot = Station(245, 190)
    sea.boat.on_mavlink(pilot.pack(sticks(1000)), sea.now_us - before_us + 9_000)
    sea.now_us += 9_001
    ticks = [sea.step(), *drive(sea, 1000, 0, 1.0, sender=pilot)]
    assert sea.state == "HOLD" and {t.commands for t in ticks} == {(0, 0)}
