# SPDX-License-Identifier: MIT
"""A pilot with a transmitter takes over, by its switch or by moving a stick."""

from __future__ import annotations

from typing import Any

import pytest
from pymavlink.dialects.v20 import common as mavlink

from tests.target.operator_words import sticks
from tests.target.sea import Sea, at_sea, texts
from tests.target.stations import BOAT, FORMATION, LEADER, MANUAL, Station

SWITCH = 7
RECEIVER = Station(BOAT, 140)
WITH_RC = {"RC_MODE_CH": float(SWITCH)}
EVERY_S = 0.05


def pulses(ahead: float, starboard: float, switch: int, count: int) -> list[int]:
    channels = [1500] * count
    channels[0] = round(1500 + 400 * starboard)
    channels[2] = round(1500 + 400 * ahead)
    channels[SWITCH - 1] = switch
    return channels


def rc(ahead: float = 0.0, starboard: float = 0.0, on: bool = False) -> Any:
    channels = pulses(ahead, starboard, 1900 if on else 1100, 18)
    return mavlink.MAVLink_rc_channels_message(0, 16, *channels, 200)


def override(ahead: float = 0.0, starboard: float = 0.0, on: bool = False) -> Any:
    channels = pulses(ahead, starboard, 1900 if on else 1100, 8)
    return mavlink.MAVLink_rc_channels_override_message(BOAT, 1, *channels)


def hold(sea: Sea, message: Any, seconds: float, sender: Station | None = RECEIVER) -> None:
    for _ in range(round(seconds / EVERY_S)):
        sea.say(message, sender=sender)
        sea.run(EVERY_S)


@pytest.mark.parametrize("message", [rc, override])
def test_the_switch_takes_over_and_the_sticks_drive(message: Any) -> None:
    sender = RECEIVER if message is rc else None
    sea = at_sea(WITH_RC)
    hold(sea, message(), 0.5, sender)
    assert sea.state == "FORMATION"
    hold(sea, message(on=True), 0.1, sender)
    assert sea.state == "MANUAL" and sea.commands == (0, 0)
    hold(sea, message(ahead=0.25, on=True), 0.5, sender)
    assert sea.state == "MANUAL" and sea.commands == pytest.approx((2048, 2048), abs=1)
    hold(sea, message(starboard=0.2, on=True), 0.5, sender)
    assert sea.commands[0] > 0 > sea.commands[1]
    hold(sea, message(ahead=0.25), 0.1, sender)
    assert sea.state == "HOLD" and sea.commands == (0, 0)
    hold(sea, message(ahead=0.9), 0.5, sender)
    assert sea.state == "HOLD", "only the law is overruled by a stick"


def test_a_stick_that_is_moved_wins_within_a_fifth_of_a_second_at_ten_messages_a_second() -> None:
    sea = at_sea(WITH_RC)
    sea.say(rc(), sender=RECEIVER)
    sea.run(0.1)
    for _ in range(2):
        sea.say(rc(starboard=-0.5), sender=RECEIVER)
        sea.run(0.1)
    assert sea.state == "MANUAL" and sea.commands == (0, 0)
    assert "MANUAL: centre the sticks first" in texts(sea.ticks)
    hold(sea, rc(), 0.1)
    hold(sea, rc(ahead=0.3), 0.3)
    assert all(command > 0 for command in sea.commands)
    sea.mode(FORMATION)
    hold(sea, rc(), 0.3)
    assert sea.state == "FORMATION"


@pytest.mark.parametrize("station", [override(), override(ahead=-0.5), override(on=True)])
def test_a_stations_overrides_do_not_disturb_a_pilot_with_a_transmitter(station: Any) -> None:
    sea = at_sea(WITH_RC)
    hold(sea, station, 0.2, None)
    states = set()
    for k in range(40):
        sea.say(rc(ahead=0.25 if k > 10 else 0.0, on=True), sender=RECEIVER)
        sea.run(EVERY_S / 2)
        sea.say(station)
        sea.run(EVERY_S / 2)
        states.add(sea.state)
    assert states == {"MANUAL"}
    assert sea.commands == pytest.approx((2048, 2048), abs=1)


def test_a_pilot_who_switches_off_leaves_the_boat_to_a_station_that_is_switched_on() -> None:
    sea = at_sea(WITH_RC)
    for on in (True, False):
        for _ in range(10):
            sea.say(rc(on=on), sender=RECEIVER)
            sea.say(override(ahead=0.0, on=True))
            sea.run(EVERY_S)
    assert sea.state == "MANUAL"
    for _ in range(10):
        sea.say(rc(), sender=RECEIVER)
        sea.say(override(ahead=0.25, on=True))
        sea.run(EVERY_S)
    assert sea.commands == pytest.approx((2048, 2048), abs=1)
    hold(sea, override(ahead=0.25), 0.1, None)
    assert sea.state == "HOLD" and sea.commands == (0, 0)


def test_sticks_on_another_link_than_the_units_are_those_of_another_boat_with_our_system_id() -> (
    None
):
    sea = Sea(WITH_RC, links=2)
    sea.enter_formation()
    for message in (rc(), rc(starboard=0.5), rc(on=True)):
        for _ in range(6):
            sea.say(message, sender=RECEIVER, link=1)
            sea.run(EVERY_S)
    assert sea.state == "FORMATION"


def test_the_switch_wins_over_an_operator() -> None:
    sea = at_sea(WITH_RC)
    for _ in range(20):
        sea.say(sticks(x=800))
        sea.say(rc(on=True), sender=RECEIVER)
        sea.mode(FORMATION)
        sea.run(EVERY_S)
    assert sea.state == "MANUAL" and sea.commands == (0, 0)


def test_a_transmitter_that_falls_silent_leads_to_hold() -> None:
    sea = at_sea(WITH_RC)
    hold(sea, rc(on=True), 0.2)
    hold(sea, rc(ahead=0.5, on=True), 0.2)
    assert any(sea.commands)
    sea.run(0.55)
    assert sea.state == "HOLD" and sea.commands == (0, 0)
    hold(sea, rc(ahead=0.5, on=True), 0.5)
    assert sea.commands == (0, 0), "the sticks are not at neutral"


def lost_receiver(throttle: int, on: bool, count: int = 16) -> Any:
    """RC_CHANNELS of a receiver without its transmitter."""
    channels = pulses(0.0, 0.0, 1900 if on else 1100, 18)
    channels[2] = throttle
    return mavlink.MAVLink_rc_channels_message(0, count, *channels, 0)


LOST = pytest.mark.parametrize(
    ("throttle", "count"), [(900, 16), (950, 16), (974, 16), (0, 16), (65535, 16), (1000, 0)]
)


@LOST
@pytest.mark.parametrize("on", [False, True])
def test_a_receiver_that_loses_its_transmitter_takes_nothing_over(
    throttle: int, count: int, on: bool
) -> None:
    sea = at_sea(WITH_RC)
    hold(sea, rc(), 0.3)
    hold(sea, lost_receiver(throttle, on, count), 1.0)
    assert sea.state == "FORMATION"
    hold(sea, rc(on=True), 0.2)
    assert sea.state == "MANUAL", "the pilot is back"


@LOST
def test_a_receiver_that_loses_its_transmitter_drives_nothing(throttle: int, count: int) -> None:
    sea = at_sea(WITH_RC)
    hold(sea, rc(on=True), 0.2)
    hold(sea, rc(ahead=0.5, on=True), 0.5)
    assert sea.state == "MANUAL" and all(command > 0 for command in sea.commands)
    begun = len(sea.ticks)
    hold(sea, lost_receiver(throttle, True, count), 1.0)
    assert sea.state == "HOLD" and sea.commands == (0, 0)
    assert all(min(tick.commands) >= 0 for tick in sea.ticks[begun:]), "never astern"
    for _ in range(20):
        sea.say(lost_receiver(throttle, True, count), sender=RECEIVER)
        sea.say(rc(on=True), sender=Station(BOAT, 151))
        sea.run(EVERY_S)
    assert sea.state == "MANUAL", "by another receiver"


def status(healthy: bool, present: bool = True) -> Any:
    bit = mavlink.MAV_SYS_STATUS_SENSOR_RC_RECEIVER if present else 0
    health = bit if healthy else 0
    return mavlink.MAVLink_sys_status_message(bit, bit, health, 0, 12000, -1, -1, *[0] * 6)


def test_a_receiver_that_repeats_its_last_pulses_leads_to_hold() -> None:
    sea = at_sea(WITH_RC)
    sea.say(status(healthy=True), sender=RECEIVER)
    hold(sea, rc(on=True), 0.2)
    hold(sea, rc(ahead=0.5, on=True), 0.2)
    assert sea.state == "MANUAL" and any(sea.commands)
    sea.say(status(healthy=False), sender=RECEIVER)
    sea.say(status(healthy=True, present=False), sender=Station(BOAT, 191))
    hold(sea, rc(ahead=0.5, on=True), 1.0)
    assert sea.state == "HOLD" and sea.commands == (0, 0)
    hold(sea, rc(on=True), 1.0)
    assert sea.state == "HOLD", "the switch is not heard either"
    sea.say(status(healthy=True), sender=RECEIVER)
    hold(sea, rc(on=True), 0.2)
    assert sea.state == "MANUAL"


def test_another_component_can_neither_lose_nor_find_the_pilots_receiver() -> None:
    other = Station(BOAT, 151)
    sea = at_sea(WITH_RC)
    sea.say(status(healthy=False), sender=other)
    for k in range(40):
        sea.say(rc(ahead=0.5 if k > 4 else 0.0, on=True), sender=RECEIVER)
        if k % 10 == 0:
            sea.say(status(healthy=False), sender=other)
        sea.say(rc(), sender=other)
        sea.run(EVERY_S)
    assert sea.state == "MANUAL" and any(sea.commands)
    for k in range(20):
        sea.say(rc(ahead=0.5, on=True), sender=RECEIVER)
        if k % 10 == 0:
            sea.say(status(healthy=False), sender=RECEIVER)
            sea.say(status(healthy=True), sender=other)
        sea.run(EVERY_S)
    assert sea.state == "HOLD" and sea.commands == (0, 0)


def test_when_one_receiver_is_lost_the_pilot_may_take_another() -> None:
    sea = at_sea(WITH_RC)
    sea.say(status(healthy=False), sender=RECEIVER)
    for _ in range(20):
        sea.say(rc(ahead=1.0, on=True), sender=RECEIVER)
        sea.say(rc(on=True), sender=Station(BOAT, 151))
        sea.run(EVERY_S)
    assert sea.state == "MANUAL" and sea.commands == (0, 0)


def test_a_lost_receiver_of_another_boat_changes_nothing() -> None:
    sea = at_sea(WITH_RC)
    sea.say(status(healthy=False), sender=Station(LEADER, 1))
    hold(sea, rc(on=True), 0.2)
    assert sea.state == "MANUAL"


@pytest.mark.parametrize("sender", [Station(LEADER, 1), Station(77, 140), Station(255, 190)])
def test_rc_of_another_sender_is_ignored(sender: Station) -> None:
    sea = at_sea(WITH_RC)
    hold(sea, rc(ahead=1.0, on=True), 0.5, sender)
    assert sea.state == "FORMATION"


def test_an_rc_override_of_a_station_that_may_not_command_is_ignored() -> None:
    sea = at_sea(WITH_RC | {"MAV_GCS_SYSID": 255.0})
    hold(sea, override(on=True), 0.5, Station(254, 190))
    assert sea.state == "FORMATION"


def test_without_a_switch_rc_is_ignored() -> None:
    sea = at_sea()
    hold(sea, rc(ahead=1.0, on=True), 0.5)
    assert sea.state == "FORMATION"
    sea.mode(MANUAL)
    assert sea.state == "FORMATION", "its sticks are nobody's"
