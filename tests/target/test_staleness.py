# SPDX-License-Identifier: MIT
"""Silence of navigation unit, leader or ESCs stops the propellers in time, with the reason."""

from __future__ import annotations

import pytest

from tests.target.sea import at_sea, texts
from tests.target.stations import FORMATION, HOLD

LIMITS = {
    "own": ("FS_NAV_S", "navigation data"),
    "leader": ("FS_LEADER_S", "leader"),
    "escs": ("FS_ESC_S", "ESC"),
}


@pytest.mark.parametrize("who", LIMITS)
@pytest.mark.parametrize("rate", [50, 100, 333])
@pytest.mark.parametrize("limit_s", [0.3, 1.0, 2.0])
def test_propellers_stop_within_one_tick_of_the_time_limit(
    who: str, rate: int, limit_s: float
) -> None:
    sea = at_sea({LIMITS[who][0]: limit_s, "FS_LEADER_ACT": 0.0, "CTL_RATE": rate})
    last_us = sea.silence(who)
    for _ in range(round((limit_s + 0.5) * rate)):
        tick = sea.step()
        age_us = tick.now_us - last_us
        if age_us < limit_s * 1e6 - sea.period_us:
            assert any(tick.commands), f"stopped early, after {age_us} us"
        if age_us >= limit_s * 1e6 + sea.period_us:
            assert not any(tick.commands), f"still turning after {age_us} us"


@pytest.mark.parametrize("who", LIMITS)
def test_a_boat_that_stops_says_state_and_reason(who: str) -> None:
    sea = at_sea({"FS_LEADER_ACT": 0.0})
    sea.silence(who)
    sea.ticks.clear()
    sea.run(1.5)
    expected = "FAULT" if who == "escs" else "HOLD"
    assert sea.state == expected
    (said,) = texts(sea.ticks)
    assert said.startswith(expected + ": ") and LIMITS[who][1] in said and len(said) <= 50
    (tick,) = [t for t in sea.ticks if t.named("STATUSTEXT")]
    assert not any(tick.commands), "said in the very tick that stops"
    beat = tick.named("HEARTBEAT")[-1]
    assert beat.custom_mode == HOLD
    assert beat.system_status == (6 if who == "escs" else 4)
    assert tick.named("STATUSTEXT")[0].severity <= 4


@pytest.mark.parametrize("who", ["own", "leader"])
def test_a_boat_in_hold_stays_there_when_the_silent_sender_returns(who: str) -> None:
    sea = at_sea({"FS_LEADER_ACT": 0.0})
    sea.silence(who)
    sea.run(1.5)
    getattr(sea, who).on = True
    ticks = sea.run(10.0)
    assert sea.state == "HOLD" and not any(any(t.commands) for t in ticks)
    sea.mode(FORMATION)
    sea.run(1.0)
    assert sea.state == "FORMATION" and any(sea.commands)


@pytest.mark.parametrize("who", ["own", "leader"])
def test_a_gap_shorter_than_the_limit_changes_nothing(who: str) -> None:
    sea = at_sea()
    for _ in range(10):
        getattr(sea, who).on = False
        sea.run(0.4)
        getattr(sea, who).on = True
        ticks = sea.run(0.3)
        assert sea.state == "FORMATION" and all(any(t.commands) for t in ticks)


def test_a_boat_stops_when_all_senders_fall_silent_at_once() -> None:
    sea = at_sea()
    sea.own.on = sea.leader.on = sea.escs[0].on = sea.escs[1].on = False
    sea.run(1.3)
    assert sea.state in ("HOLD", "FAULT") and not any(sea.commands)
    ticks = sea.run(600.0)
    assert not any(any(t.commands) for t in ticks)
    assert sea.state == "FAULT"
