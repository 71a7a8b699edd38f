# SPDX-License-Identifier: MIT
"""COAST, seen on the wires: a silent leader is extrapolated, slower and slower."""

from __future__ import annotations

import pytest

from tests.target.course import BEHIND, TURN
from tests.target.operator_words import drive, param_set, sticks
from tests.target.sea import Sea, at_sea, named, texts
from tests.target.stations import FORMATION, HOLD, MANUAL

CRITICAL, ERROR = 5, 3


def greatest(commands: tuple[int, ...]) -> int:
    return max(abs(c) for c in commands)


@pytest.mark.parametrize("coast_s", [0.5, 2.0, 5.0])
@pytest.mark.parametrize("rate", [50, 333])
def test_a_silent_leader_is_followed_for_fs_coast_s_with_thrust_that_never_grows(
    coast_s: float, rate: int
) -> None:
    sea = at_sea({"FS_LEADER_S": 0.5, "FS_COAST_S": coast_s, "CTL_RATE": rate})
    last_us = sea.silence("leader")
    sea.run_until("COAST", 0.6)
    assert abs(sea.ticks[-1].now_us - last_us - 500_000) <= sea.period_us
    begun_us = sea.ticks[-1].now_us
    most = greatest(sea.ticks[-2].commands)
    while sea.state == "COAST":
        now = greatest(sea.commands)
        assert now <= most, sea.ticks[-1].now_us
        most = now
        sea.step()
    assert abs(sea.ticks[-1].now_us - begun_us - coast_s * 1e6) <= sea.period_us
    assert sea.state == "HOLD" and sea.commands == (0, 0)
    assert texts(sea.ticks)[-2:] == [
        "COAST: leader lost or origin unknown",
        "HOLD: FS_COAST_S elapsed, or position lost",
    ]


@pytest.mark.parametrize(("before", "now"), [("COAST", "HOLD"), ("HOLD", "COAST")])
def test_a_failsafe_choice_changed_before_arming_is_in_force(before: str, now: str) -> None:
    choices = {"HOLD": 0.0, "COAST": 1.0}
    sea = Sea({"FS_LEADER_ACT": choices[before]})
    sea.settle()
    sea.say(param_set("FS_LEADER_ACT", choices[now]))
    sea.enter_formation()
    sea.silence("leader")
    while sea.state == "FORMATION":
        sea.step()
    assert sea.state == now


def test_clients_see_coast_as_follow_with_status_critical() -> None:
    sea = at_sea()
    sea.silence("leader")
    sea.run_until("COAST", 1.1)
    (beat,) = sea.ticks[-1].named("HEARTBEAT")
    assert (beat.custom_mode, beat.system_status) == (FORMATION, CRITICAL)
    (said,) = sea.ticks[-1].named("STATUSTEXT")
    assert said.severity == ERROR
    told = sea.run(3.0)
    assert {m.system_status for m in named(told, "HEARTBEAT")} == {CRITICAL}
    assert named(told, "LOCAL_POSITION_NED"), "its followers still hear where it is"


@pytest.mark.parametrize("silence_s", [1.5, 4.0])
def test_a_leader_heard_again_is_followed_again_without_a_command(silence_s: float) -> None:
    sea = at_sea()
    sea.silence("leader")
    sea.run(silence_s)
    assert sea.state == "COAST"
    sea.leader.on = True
    ticks = sea.run(0.3)
    assert sea.state == "FORMATION" and texts(ticks) == ["FORMATION"]
    before = ticks[0].commands
    for tick in ticks:  # full scale takes 0.2 s: no step at the seam
        assert all(
            abs(a - b) <= 8191 * 0.05 + 1 for a, b in zip(tick.commands, before, strict=True)
        )
        before = tick.commands


def test_in_coast_the_operators_commands_are_obeyed() -> None:
    for wanted, state in ((HOLD, "HOLD"), (MANUAL, "MANUAL"), (FORMATION, "COAST")):
        sea = at_sea()
        sea.silence("leader")
        sea.run_until("COAST", 1.1)
        sea.say(sticks(0, 0))
        sea.mode(wanted)
        assert sea.state == state
        sea.leader.on = True
        sea.run(0.3)
        assert sea.state == ("FORMATION" if state == "COAST" else state)
        sea.disarm()
        assert sea.state == "DISARMED" and sea.commands == (0, 0)


@pytest.mark.parametrize(
    ("lost", "state"), [("own", "HOLD"), ("escs", "FAULT")], ids=["own state", "ESCs"]
)
def test_coast_ends_at_once_when_a_condition_is_lost(lost: str, state: str) -> None:
    sea = at_sea({"FS_COAST_S": 60.0})
    sea.silence("leader")
    sea.run_until("COAST", 1.1)
    sea.silence(lost)
    sea.run_until(state, 1.3)
    assert sea.commands == (0, 0)


@pytest.mark.parametrize("held", [True, False])
def test_after_a_lost_leader_manual_is_entered_only_if_the_operator_holds_the_sticks(
    held: bool,
) -> None:
    sea = at_sea({"FS_LEADER_ACT": 2.0})
    sea.leader.on = False
    for _ in range(150):
        if held:
            sea.say(sticks(200, 0))
        sea.step()
    assert sea.state == ("MANUAL" if held else "HOLD")
    assert not any(sea.commands)
    assert f"{sea.state}: leader lost or origin unknown" in texts(sea.ticks)
    assert texts(sea.ticks).count("MANUAL: centre the sticks first") == held
    if held:
        drive(sea, 0, 0, 0.1)
        drive(sea, 200)
        assert sea.state == "MANUAL" and all(sea.commands)


def test_a_boat_whose_leader_was_lost_before_it_ever_pushed_does_not_push() -> None:
    sea = Sea(own=BEHIND, leader=TURN)
    sea.settle()
    sea.leader.on = False
    sea.run(0.85)
    sea.arm()
    sea.mode(FORMATION)
    assert sea.state == "FORMATION"
    ticks = sea.run(6.0)
    assert "COAST: leader lost or origin unknown" in texts(ticks)
    assert not any(any(tick.commands) for tick in ticks) and sea.state == "HOLD"
