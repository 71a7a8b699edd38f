# SPDX-License-Identifier: MIT
"""A pilot's switch has priority over every operator, and only one pilot drives."""

from __future__ import annotations

import pytest

from tests.target.operator_words import sticks
from tests.target.sea import Sea, acks, at_sea, texts
from tests.target.stations import (
    ACCEPTED,
    FORMATION,
    GUIDED,
    HOLD,
    LOITER,
    MOTOR_TEST,
    RTL,
    SET_MODE,
    TEMPORARILY_REJECTED,
    Station,
    command_long,
)
from tests.target.test_one_after_another import QUESTION, ping
from tests.target.test_rc import RECEIVER, WITH_RC, hold, override, rc

FULL_THRUST = 8191
FAST_MPS = 3.0  # twice LAW_U_MAX


def driven() -> Sea:
    """A boat that a pilot drives ahead in MANUAL, by the switch of the transmitter."""
    sea = at_sea(WITH_RC)
    hold(sea, rc(on=True), 0.3)
    hold(sea, rc(ahead=0.25, on=True), 0.5)
    assert sea.state == "MANUAL" and sea.commands == pytest.approx((2048, 2048), abs=1)
    return sea


def begin_test_at_once(sea: Sea) -> None:
    sea.say(command_long(SET_MODE, 1.0, float(HOLD)), command_long(MOTOR_TEST, 1.0, 0.0, 20.0, 5.0))


def steering() -> Sea:
    """A boat in MANUAL that its pilot took over by a stick, and then drives astern."""
    sea = at_sea(WITH_RC)
    hold(sea, rc(), 0.5)
    hold(sea, rc(ahead=-0.4), 0.3)
    hold(sea, rc(), 0.3)
    hold(sea, rc(ahead=-0.5), 0.5)
    assert sea.state == "MANUAL" and max(sea.commands) < 0
    return sea


@pytest.mark.parametrize("confirmation", [0, 1])
def test_an_order_does_not_take_the_boat_from_a_pilot_who_steers(confirmation: int) -> None:
    sea = steering()
    tick = sea.order(SET_MODE, 1.0, float(FORMATION), confirmation=confirmation)
    assert acks(tick) == [(SET_MODE, TEMPORARILY_REJECTED)]
    hold(sea, rc(ahead=-0.5), 0.3)
    assert sea.state == "MANUAL" and max(sea.commands) < 0


def test_hold_ends_a_pilots_steering_for_the_next_order() -> None:
    sea = steering()
    tick = sea.order(SET_MODE, 1.0, float(FORMATION))
    assert "Refused: a pilot has the controls, HOLD first" in texts([tick])
    sea.say(command_long(SET_MODE, 1.0, float(HOLD)), command_long(SET_MODE, 1.0, float(FORMATION)))
    hold(sea, rc(ahead=-0.5), 0.1)
    assert sea.state == "FORMATION"


def test_a_throttle_that_rests_at_its_lower_end_is_no_steering() -> None:
    sea = at_sea(WITH_RC)
    hold(sea, rc(ahead=-1.0), 0.5)
    hold(sea, rc(ahead=-1.0, starboard=0.5), 0.3)
    hold(sea, rc(ahead=-1.0), 0.5)
    assert sea.state == "MANUAL" and sea.commands == (0, 0)
    assert acks(sea.order(SET_MODE, 1.0, float(FORMATION))) == [(SET_MODE, ACCEPTED)]


def test_a_retransmission_does_not_undo_a_pilots_takeover_but_a_new_order_ends_it() -> None:
    sea = steering()
    hold(sea, rc(), 0.3)
    tick = sea.order(SET_MODE, 1.0, float(FORMATION), confirmation=1)
    assert acks(tick) == [(SET_MODE, TEMPORARILY_REJECTED)] and sea.state == "MANUAL"
    hold(sea, rc(), 0.3)
    assert acks(sea.order(SET_MODE, 1.0, float(FORMATION))) == [(SET_MODE, ACCEPTED)]
    hold(sea, rc(), 0.3)
    assert sea.state == "FORMATION"


def test_an_operators_motor_test_does_not_take_the_boat_from_a_pilot() -> None:
    sea = driven()
    begin_test_at_once(sea)
    hold(sea, rc(on=True), 0.3)
    assert sea.state == "MANUAL", (sea.state, sea.commands)


def test_a_pilot_who_switches_off_ends_a_motor_test() -> None:
    sea = driven()
    begin_test_at_once(sea)
    hold(sea, rc(on=True), 0.2)
    hold(sea, rc(on=False), 0.3)
    assert sea.state == "HOLD" and sea.commands == (0, 0), (sea.state, sea.commands)


def test_a_pilots_switch_ends_a_motor_test_that_runs() -> None:
    sea = Sea(WITH_RC)
    sea.enter_hold()
    sea.run(0.3)
    sea.order(MOTOR_TEST, 1.0, 0.0, 20.0, 5.0)
    assert sea.state == "TEST"
    hold(sea, rc(on=True), 0.3)
    assert sea.state == "MANUAL" and sea.commands == (0, 0), (sea.state, sea.commands)


@pytest.mark.parametrize("mode", [LOITER, RTL, GUIDED, FORMATION])
def test_a_mode_that_the_pilots_switch_does_not_permit_is_not_accepted(mode: int) -> None:
    sea = driven()
    sea.say(rc(ahead=0.25, on=True), sender=RECEIVER)
    answer = acks(sea.mode(mode))
    assert sea.state == "MANUAL"
    assert answer != [(SET_MODE, ACCEPTED)]


@pytest.mark.parametrize("mode", [LOITER, RTL, GUIDED, FORMATION])
def test_an_operators_mode_does_not_take_the_thrust_from_a_pilot(mode: int) -> None:
    sea = driven()
    sea.say(rc(ahead=0.25, on=True), sender=RECEIVER)
    sea.mode(mode)
    hold(sea, rc(ahead=0.25, on=True), 0.5)
    assert sea.commands == pytest.approx((2048, 2048), abs=1), (sea.state, sea.commands)


def overridden() -> Sea:
    """The same by RC_CHANNELS_OVERRIDE of the ground station."""
    sea = at_sea(WITH_RC)
    hold(sea, override(on=True), 0.3, None)
    hold(sea, override(ahead=0.25, on=True), 0.5, None)
    assert sea.state == "MANUAL" and sea.commands == pytest.approx((2048, 2048), abs=1)
    return sea


def test_manual_control_with_the_ids_of_a_station_that_overrides_does_not_drive() -> None:
    sea = overridden()
    least = 0
    for _ in range(20):
        sea.say(override(ahead=0.25, on=True))
        sea.run(0.02)
        sea.say(sticks(-600, 0))  # never at neutral
        sea.run(0.03)
        least = min(least, *sea.commands)
    assert least >= 0, least


def test_a_second_stations_overrides_do_not_stop_the_pilot_of_the_first() -> None:
    sea = overridden()
    begun, other = len(sea.ticks), Station(254, 190)
    for _ in range(20):
        sea.say(override(ahead=0.25, on=True))
        sea.run(0.03)
        sea.say(override(), sender=other)  # its switch is off
        sea.run(0.03)
    told = texts(sea.ticks[begun:])
    assert sea.commands == pytest.approx((2048, 2048), abs=1) and not told, (len(told), told[:3])


def test_an_order_older_than_the_pilots_switching_off_is_not_carried_out_after_it() -> None:
    sea = at_sea(WITH_RC)
    hold(sea, rc(on=True), 0.5)
    assert sea.state == "MANUAL"
    sea.say(QUESTION, *[ping(k) for k in range(22)], command_long(SET_MODE, 1.0, float(FORMATION)))
    sea.say(rc(on=False), sender=RECEIVER)
    hold(sea, rc(on=False), 0.3)
    assert sea.state == "HOLD", (sea.state, texts(sea.ticks)[-3:])
