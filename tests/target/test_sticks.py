# SPDX-License-Identifier: MIT
"""Ownership of the sticks: they belong to the operator who took them first and still sends."""

from __future__ import annotations

import pytest

from tests.target.operator_words import drive, enter_manual, sticks
from tests.target.sea import Sea, acks
from tests.target.stations import (
    ACCEPTED,
    ARM,
    BOAT,
    GCS,
    MANUAL,
    SET_MODE,
    TEMPORARILY_REJECTED,
    Station,
    command_long,
)
from tests.target.test_companion import AUTOPILOT, ME, latched

SECOND = [(GCS, 191), (245, 190), (77, 1)]


def test_broadcast_sticks_are_ignored(sea: Sea) -> None:
    """One gamepad must not drive a fleet."""
    sea.enter_hold()
    for _ in range(5):
        sea.say(sticks(500, target=0))
        sea.run(0.05)
    assert acks(sea.mode(MANUAL)) == [(SET_MODE, TEMPORARILY_REJECTED)]
    assert sea.state == "HOLD"


def test_sticks_for_all_neither_drive_nor_keep_manual(sea: Sea) -> None:
    enter_manual(sea)
    drive(sea, 300)
    driven = sea.commands
    for _ in range(8):
        sea.say(sticks(-1000, 1000, target=0))
        sea.run(0.05)
        assert sea.commands == driven
    for _ in range(8):
        sea.say(sticks(-1000, 1000, target=0))
        sea.run(0.05)
    assert sea.state == "HOLD" and sea.commands == (0, 0)


@pytest.mark.parametrize("second", SECOND, ids=str)
@pytest.mark.parametrize("link", [0, 1])
def test_a_second_operators_sticks_are_ignored_while_the_first_holds_his(
    second: tuple[int, int], link: int
) -> None:
    sea = Sea(links=2)
    enter_manual(sea)
    drive(sea, 300)
    driven, bad = sea.commands, sea.counter("mavlink_bad_value")
    for _ in range(40):
        sea.say(sticks(300))
        sea.say(sticks(-1000, 1000), sender=Station(*second), link=link)
        for tick in sea.run(0.05):
            assert tick.commands == driven
    assert sea.state == "MANUAL" and sea.counter("mavlink_bad_value") == bad


@pytest.mark.parametrize("second", SECOND, ids=str)
def test_a_second_operators_sticks_do_not_replace_those_of_a_silent_first_one(
    second: tuple[int, int],
) -> None:
    """The first falls silent: HOLD after half a second, whatever the second sends."""
    sea = Sea()
    enter_manual(sea)
    drive(sea, 300)
    driven = sea.commands
    sea.say(sticks(300))
    said_us = sea.now_us
    while sea.now_us - said_us < 480_000:
        sea.say(sticks(-1000, 1000), sender=Station(*second))
        assert sea.step().commands == driven
    ticks = sea.run(0.1)
    assert sea.state == "HOLD" and ticks[-1].commands == (0, 0)


def test_a_second_operator_may_take_sticks_that_were_let_go(sea: Sea) -> None:
    enter_manual(sea)
    drive(sea, 300)
    second = Station(245, 190)
    drive(sea, -200, 0, 0.7, sender=second)
    drive(sea, 0, 0, 0.1, sender=second)
    assert acks(sea.mode(MANUAL)) == [(SET_MODE, ACCEPTED)]
    drive(sea, -200, 0, 1.0, sender=second)
    assert sea.state == "MANUAL" and all(c < 0 for c in sea.commands)
    before = sea.commands
    for _ in range(10):
        sea.say(sticks(-200), sender=second)
        sea.say(sticks(1000))
        assert sea.step().commands == before


def test_the_first_operator_may_go_on_by_another_link_after_five_seconds_of_silence() -> None:
    sea = Sea(links=2)
    enter_manual(sea)
    drive(sea, 300)
    drive(sea, 0, 0, 5.1, link=1)  # until then these may be late copies
    assert sea.state == "HOLD"
    sea.mode(MANUAL)
    drive(sea, 0, 0, 0.1, link=1)
    drive(sea, -300, 0, 1.0, link=1)
    assert sea.state == "MANUAL" and all(c < 0 for c in sea.commands)


def test_invalid_sticks_do_not_take_control(sea: Sea) -> None:
    sea.enter_hold()
    sea.say(sticks(32767), sender=Station(77, 1))
    sea.say(sticks(0))
    assert acks(sea.mode(MANUAL)) == [(SET_MODE, ACCEPTED)]


def test_a_station_that_may_not_command_cannot_take_the_sticks() -> None:
    sea = Sea({"MAV_GCS_SYSID": GCS})
    sea.enter_hold()
    for _ in range(5):
        sea.say(sticks(500), sender=Station(77, 1))
        sea.step()
    sea.say(sticks(0))
    assert acks(sea.mode(MANUAL)) == [(SET_MODE, ACCEPTED)]
    drive(sea, 100)
    assert all(c > 0 for c in sea.commands)


@pytest.mark.parametrize("target", [AUTOPILOT, BOAT, 0])
def test_a_companion_leaves_the_sticks_to_its_autopilot(target: int) -> None:
    sea = latched()
    sea.say(command_long(ARM, 1.0, target=ME))
    sea.step()
    for _ in range(5):
        sea.say(sticks(500, target=target))
        sea.run(0.05)
    sea.say(command_long(SET_MODE, 1.0, 0.0, target=ME))
    assert acks(sea.step()) == [(SET_MODE, TEMPORARILY_REJECTED)]
    assert sea.state == "HOLD" and not any(sea.commands)
