# SPDX-License-Identifier: MIT
"""CURRENT_MODE: the boat's mode and its intended mode."""

from __future__ import annotations

from tests.target.sea import Sea, acks, named
from tests.target.stations import FORMATION, HOLD, SET_INTERVAL, SET_MODE, command_long


def current_mode(sea: Sea) -> tuple[int, int]:
    """custom_mode and intended_custom_mode after the last tick but one."""
    sea.step()
    (told,) = sea.ask(436)
    assert told.standard_mode == 0
    return told.custom_mode, told.intended_custom_mode


def test_a_client_that_requests_the_mode_gets_it_at_each_change_and_every_two_seconds() -> None:
    sea = Sea(links=3)
    for link in (0, 1):
        sea.order(SET_INTERVAL, 436.0, 2e6, link=link)
    sea.run(1.3)
    changes = ((400, [1.0]), (SET_MODE, [1.0, FORMATION]), (SET_MODE, [1.0, HOLD]), (400, [0.0]))
    for (order, how), mode in zip(changes, (HOLD, FORMATION, HOLD, HOLD), strict=True):
        tick = sea.order(order, *how)
        for link in (0, 1):
            (told,) = tick.named("CURRENT_MODE", link)
            assert told.custom_mode == mode
        assert not tick.named("CURRENT_MODE", 2)
        sea.run(0.7)
    assert len(named(sea.run(20.0), "CURRENT_MODE")) == 10
    assert not named(sea.ticks, "CURRENT_MODE", 2)


def test_current_mode_and_heartbeat_agree(sea: Sea) -> None:
    sea.order(SET_INTERVAL, 436.0, 1e5)
    sea.settle()
    sea.arm()
    sea.mode(FORMATION)
    sea.run(1.0)
    sea.leader.on = False
    sea.run_until("HOLD", 8.0)
    sea.run(0.3)
    mode, seen = HOLD, set()
    for tick in sea.ticks:
        for m in tick.messages():
            if m.get_type() == "HEARTBEAT":
                mode = m.custom_mode
            if m.get_type() == "CURRENT_MODE":
                assert m.custom_mode == mode
                seen.add((m.custom_mode, m.intended_custom_mode))
    assert seen == {(HOLD, HOLD), (FORMATION, FORMATION), (HOLD, FORMATION)}


def test_after_a_failsafe_the_intended_mode_is_still_formation(sea: Sea) -> None:
    sea.settle()
    assert current_mode(sea) == (HOLD, HOLD)
    sea.arm()
    sea.mode(FORMATION)
    assert current_mode(sea) == (FORMATION, FORMATION)
    sea.leader.on = False
    sea.run_until("COAST", 2.0)
    assert current_mode(sea) == (FORMATION, FORMATION)
    sea.run_until("HOLD", 6.0)
    assert current_mode(sea) == (HOLD, FORMATION)
    sea.mode(HOLD)
    assert current_mode(sea) == (HOLD, HOLD)


def test_a_refused_mode_is_not_reported_as_intended(sea: Sea) -> None:
    sea.leader.on = False
    sea.enter_hold()
    assert acks(sea.mode(FORMATION)) == [(SET_MODE, 1)]
    assert current_mode(sea) == (HOLD, HOLD)


def test_a_mode_requested_in_the_tick_of_its_change_is_the_new_one(sea: Sea) -> None:
    sea.enter_hold()
    sea.say(command_long(SET_MODE, 1.0, 6.0), command_long(512, 436.0), command_long(512, 0.0))
    tick = sea.step()
    assert {m.custom_mode for m in tick.named("CURRENT_MODE")} == {FORMATION}
    assert {m.custom_mode for m in tick.named("HEARTBEAT")} == {FORMATION}
