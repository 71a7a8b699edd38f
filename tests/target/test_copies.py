# SPDX-License-Identifier: MIT
"""Copies of a ground station's messages that other vessels hand on, by another link and late."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import pytest
from pymavlink.dialects.v20 import common as mavlink

from tests.target.hull import Afloat, Hull
from tests.target.operator_words import drive, enter_manual, param_set, sticks
from tests.target.plans import ITEM_ACCEPTED, Planner, as_sent, at, plan_of
from tests.target.sea import Sea, Tick, acks, named, texts
from tests.target.stations import (
    ACCEPTED,
    ARM,
    AUTO,
    BOAT,
    FORMATION,
    GCS,
    GCS_COMPONENT,
    GUIDED,
    HOLD,
    LOITER,
    PAUSE,
    REQUEST_MESSAGE,
    SET_MODE,
    TEMPORARILY_REJECTED,
    Station,
    command_long,
)
from tests.target.test_auto import SET_CURRENT, sailing
from tests.target.test_setpoints import NED, local

RADIO = 1
SECOND = Station(GCS - 1, GCS_COMPONENT)


@pytest.fixture
def sea() -> Sea:
    """A boat with a link to the ground station and a radio."""
    sea = Sea(links=2)
    sea.enter_formation()
    return sea


def say(sea: Sea, message: Any) -> bytes:
    """Send a message to the boat directly; returns its frame."""
    wire = sea.gcs.pack(message)
    sea.boat.on_mavlink(wire, sea.now_us, 0)
    return wire


@pytest.mark.parametrize("late_s", [0.01, 1.0, 4.0])
def test_a_late_copy_of_a_request_does_not_undo_a_newer_one(sea: Sea, late_s: float) -> None:
    sea.mode(HOLD)
    wire = say(sea, command_long(SET_MODE, 1.0, float(FORMATION)))
    sea.step()
    assert sea.state == "FORMATION"
    sea.mode(HOLD)
    sea.run(late_s)
    assert sea.state == "HOLD"
    sea.boat.on_mavlink(wire, sea.now_us, RADIO)
    ticks = sea.run(0.5)
    assert sea.state == "HOLD" and not named(ticks, "COMMAND_ACK", RADIO)


@pytest.mark.parametrize(
    "between",
    [
        mavlink.MAVLink_timesync_message(0, 5),
        mavlink.MAVLink_ping_message(0, 1, 0, 0),
        mavlink.MAVLink_param_request_read_message(BOAT, 1, b"", 1),
        command_long(REQUEST_MESSAGE, 148.0),
    ],
    ids=lambda message: message.get_type(),
)
def test_requests_that_change_nothing_do_not_make_room_for_a_late_copy(
    sea: Sea, between: Any
) -> None:
    wire = say(sea, command_long(SET_MODE, 1.0, float(FORMATION)))
    sea.step()
    sea.mode(LOITER)
    for _ in range(40):
        say(sea, between)
        sea.step()
    assert sea.state == "LOITER"
    sea.boat.on_mavlink(wire, sea.now_us, RADIO)
    sea.step()
    assert sea.state == "LOITER"


def test_a_stop_that_is_repeated_on_both_links_makes_no_room_for_a_late_copy(sea: Sea) -> None:
    wire = say(sea, command_long(SET_MODE, 1.0, float(FORMATION)))
    sea.step()
    for _ in range(16):
        again = say(sea, command_long(SET_MODE, 1.0, float(HOLD)))
        sea.boat.on_mavlink(again, sea.now_us, RADIO)
        sea.run(0.2)
    assert sea.state == "HOLD"
    sea.boat.on_mavlink(wire, sea.now_us, RADIO)
    sea.run(0.2)
    assert sea.state == "HOLD"


@pytest.mark.parametrize(
    ("sender", "count", "every_s"),
    [(None, 31, 0.1), (None, 32, 0.1), (None, 45, 0.1), (SECOND, 32, 0.06)],
)
def test_too_many_requests_to_remember_make_no_room_for_a_late_copy(
    sea: Sea, sender: Station | None, count: int, every_s: float
) -> None:
    wire = say(sea, command_long(SET_MODE, 1.0, float(FORMATION)))
    sea.step()
    sea.say(command_long(SET_MODE, 1.0, float(LOITER)), sender=sender)
    for k in range(count):
        sea.say(param_set("SR_SLOW", 0.5 + 0.01 * k), sender=sender)
        sea.run(every_s)
    assert sea.state == "LOITER"
    sea.boat.on_mavlink(wire, sea.now_us, RADIO)
    sea.run(0.1)
    assert sea.state == "LOITER"


def test_after_too_many_requests_another_link_is_believed_five_seconds_later(sea: Sea) -> None:
    for k in range(40):
        say(sea, param_set("SR_SLOW", 0.5 + 0.01 * k))
        sea.run(0.1)
    tick = sea.order(SET_MODE, 1.0, float(LOITER), link=RADIO)
    assert not acks(tick, RADIO) and sea.state == "FORMATION"
    assert "Refused: too many requests: ask again in 5 s" in texts([tick])
    sea.run(5.0)
    tick = sea.order(SET_MODE, 1.0, float(LOITER), link=RADIO)
    assert acks(tick, RADIO) == [(SET_MODE, ACCEPTED)] and sea.state == "LOITER"


@pytest.mark.parametrize("newer", [HOLD, LOITER])
def test_a_second_copy_on_the_same_link_does_not_undo_a_newer_request(sea: Sea, newer: int) -> None:
    sea.mode(HOLD)
    wire = say(sea, command_long(SET_MODE, 1.0, float(FORMATION)))
    sea.step()
    sea.run(1.0)
    sea.mode(newer)
    sea.run(1.0)
    sea.boat.on_mavlink(wire, sea.now_us, 0)
    ticks = sea.run(1.0)
    assert sea.state == ("HOLD" if newer == HOLD else "LOITER")
    assert "Refused: sent before a newer request: ask again" in texts(ticks)


def test_a_second_copy_on_the_same_link_does_not_arm_again() -> None:
    sea = Sea()
    sea.settle()
    wire = say(sea, command_long(ARM, 1.0))
    sea.step()
    assert sea.state == "HOLD"
    sea.disarm()
    sea.boat.on_mavlink(wire, sea.now_us, 0)
    sea.step()
    assert sea.state == "DISARMED"


def test_a_script_that_starts_again_may_send_what_it_sent_last(sea: Sea) -> None:
    sea.run(5.0)
    for _ in range(3):
        script = Station(GCS, GCS_COMPONENT)
        sea.boat.on_mavlink(script.pack(command_long(ARM, 1.0)), sea.now_us, 0)
        assert acks(sea.step()) == [(ARM, ACCEPTED)]


@pytest.mark.parametrize("newer", [LOITER, PAUSE])
def test_a_late_first_copy_on_another_link_does_not_undo_the_same_operators_order(
    newer: int,
) -> None:
    sea = Afloat(hull=Hull(), links=2)
    sea.leader.on = False
    sea.run(2.0)
    assert Planner(sea).send([at(40, 0)]) == ITEM_ACCEPTED
    sea.arm()
    sea.mode(AUTO)
    sea.run(6.0)
    lost = sea.gcs.pack(
        command_long(PAUSE, 1.0) if newer == PAUSE else command_long(SET_MODE, 1.0, float(AUTO))
    )
    sea.order(PAUSE, 0.0) if newer == PAUSE else sea.mode(LOITER)
    sea.run(2.0)
    sea.boat.on_mavlink(lost, sea.now_us, RADIO)
    tick = sea.step()
    assert [result for _, result in acks(tick, RADIO)] == [TEMPORARILY_REJECTED]
    assert "Refused: a newer order came: ask again in 5 s" in texts([tick])


@pytest.mark.parametrize("link", [0, RADIO])
def test_a_retransmission_does_not_undo_another_operators_newer_order(sea: Sea, link: int) -> None:
    sea.mode(LOITER)
    sea.run(0.2)
    sea.say(command_long(SET_MODE, 1.0, float(FORMATION)), sender=SECOND, link=link)
    assert acks(sea.step(), link) == [(SET_MODE, ACCEPTED)] and sea.state == "FORMATION"
    tick = sea.order(SET_MODE, 1.0, float(LOITER), confirmation=1)
    assert acks(tick) == [(SET_MODE, TEMPORARILY_REJECTED)] and sea.state == "FORMATION"
    assert "Refused: a newer order came: ask again in 5 s" in texts([tick])
    sea.run(5.0)
    assert acks(sea.order(SET_MODE, 1.0, float(LOITER), confirmation=2)) == [(SET_MODE, ACCEPTED)]


def test_a_retransmission_does_not_undo_another_operators_newer_item() -> None:
    sea = sailing([at(30, 0), at(60, 0), at(90, 0)])
    sea.order(SET_CURRENT, 1.0)  # its answer is lost
    sea.say(command_long(SET_CURRENT, 2.0), sender=SECOND)
    assert acks(sea.step()) == [(SET_CURRENT, ACCEPTED)]
    tick = sea.order(SET_CURRENT, 1.0, confirmation=1)
    assert acks(tick) == [(SET_CURRENT, TEMPORARILY_REJECTED)]
    assert "Refused: a newer order came: ask again in 5 s" in texts([tick])
    (current,) = sea.ask(mavlink.MAVLINK_MSG_ID_MISSION_CURRENT)
    assert current.seq == 2


def test_a_retransmission_does_not_take_the_boat_from_another_operators_setpoints() -> None:
    sea = Afloat(hull=Hull())
    sea.leader.on = False
    sea.run(2.0)
    sea.arm()
    sea.mode(LOITER)  # its answer is lost
    sea.say(command_long(SET_MODE, 1.0, float(GUIDED)), sender=SECOND)
    for _ in range(60):
        sea.say(local(NED, velocity_mps=(0.0, 0.5)), sender=SECOND)
        sea.run(0.1)
    tick = sea.order(SET_MODE, 1.0, float(LOITER), confirmation=1)
    assert acks(tick) == [(SET_MODE, TEMPORARILY_REJECTED)] and sea.state == "GUIDED"
    sea.run(5.0)
    assert acks(sea.order(SET_MODE, 1.0, float(LOITER), confirmation=2)) == [(SET_MODE, ACCEPTED)]


def test_a_late_copy_of_a_clear_does_not_clear_a_plan_that_was_sent_since(sea: Sea) -> None:
    sea.mode(HOLD)
    wire = say(sea, mavlink.MAVLink_mission_clear_all_message(BOAT, 1, 255))
    sea.step()
    plan = [at(north, 0) for north in range(1, 42)]
    assert Planner(sea).send(plan) == ITEM_ACCEPTED
    sea.boat.on_mavlink(wire, sea.now_us, RADIO)
    sea.run(0.1)
    assert plan_of(sea) == as_sent(plan)


def pushed(ticks: Sequence[Tick]) -> bool:
    return any(any(tick.commands) for tick in ticks)


@pytest.mark.parametrize("second", [False, True], ids=["one operator", "two"])
def test_late_copies_of_the_sticks_drive_nothing(second: bool) -> None:
    sea = Sea(links=2)
    enter_manual(sea)
    late = []
    for _ in range(20):
        late.append(say(sea, sticks(600, 0)))
        sea.run(0.05)
    assert pushed(sea.ticks[-5:])
    drive(sea, 0, seconds=0.5)
    for wire in late:
        say(sea, sticks(0, 0))
        if second:
            sea.say(sticks(0, 0), sender=SECOND)
        sea.step()
        sea.boat.on_mavlink(wire, sea.now_us, RADIO)
        assert not pushed(sea.run(0.04))
    assert sea.state == "MANUAL"
    for wire in late:  # the operator is silent
        sea.boat.on_mavlink(wire, sea.now_us, RADIO)
        assert not pushed(sea.run(0.05))
    assert sea.state == "HOLD"


def test_late_copies_of_an_rc_override_do_not_bring_manual_back() -> None:
    sea = Sea({"RC_MODE_CH": 5}, links=2)
    sea.enter_formation()

    def override(switch_us: int) -> Any:
        channels = [1500, 1500, 1500, 1500, switch_us, 0, 0, 0]
        return mavlink.MAVLink_rc_channels_override_message(BOAT, 1, *channels)

    late = []
    for _ in range(10):
        late.append(say(sea, override(1900)))
        sea.run(0.05)
    assert sea.state == "MANUAL"
    for wire in late:
        say(sea, override(1100))
        sea.step()
        sea.boat.on_mavlink(wire, sea.now_us, RADIO)
        sea.run(0.04)
    assert sea.state == "HOLD"


def test_late_copies_of_setpoints_do_not_alternate_with_newer_ones() -> None:
    sea = Afloat(links=2, hull=Hull())
    sea.leader.on = False
    sea.run(2.0)
    sea.arm()
    sea.mode(GUIDED)
    late = []
    for _ in range(100):
        late.append(say(sea, local(NED, velocity_mps=(0.0, 0.5))))
        sea.run(0.1)
    assert sea.hull.seen.u > 0.4
    for wire in late:
        say(sea, local(NED, velocity_mps=(0.0, 0.0)))
        sea.step()
        sea.boat.on_mavlink(wire, sea.now_us, RADIO)
        sea.run(0.09)
    assert sea.state == "GUIDED" and abs(sea.hull.seen.u) < 0.05


def test_a_stop_is_obeyed_however_often_it_comes(sea: Sea) -> None:
    wire = say(sea, command_long(ARM, 0.0))
    sea.step()
    sea.arm()
    sea.boat.on_mavlink(wire, sea.now_us, RADIO)
    sea.step()
    assert sea.state == "DISARMED"


def test_equal_numbers_on_two_links_make_no_copies_of_different_requests(sea: Sea) -> None:
    """A ground station that numbers the messages of each link apart."""
    stations = [Station(GCS, GCS_COMPONENT) for _ in range(2)]
    sea.run(5.0)  # since the last order on the other link
    sea.say(command_long(REQUEST_MESSAGE, 148.0), sender=stations[0], link=0)
    sea.run(1.0)
    sea.say(command_long(SET_MODE, 1.0, float(LOITER)), sender=stations[1], link=RADIO)
    assert acks(sea.step(), RADIO) == [(SET_MODE, ACCEPTED)] and sea.state == "LOITER"


def stopping() -> list[Any]:
    return [
        command_long(SET_MODE, 1.0, float(HOLD)),
        command_long(SET_MODE, 1.0, 4.0, 3.0),
        mavlink.MAVLink_set_mode_message(BOAT, 1, HOLD),
        mavlink.MAVLink_command_int_message(BOAT, 1, 0, SET_MODE, 0, 0, 1, HOLD, 0, 0, 0, 0, 0),
    ]


@pytest.mark.parametrize("message", stopping(), ids=range(4))
def test_hold_is_obeyed_even_as_a_copy(sea: Sea, message: Any) -> None:
    wire = say(sea, message)
    sea.step()
    assert sea.state == "HOLD"
    sea.mode(FORMATION)
    assert sea.state == "FORMATION"
    sea.boat.on_mavlink(wire, sea.now_us, RADIO)
    sea.step()
    assert sea.state == "HOLD"


@pytest.mark.parametrize("message", stopping(), ids=range(4))
def test_hold_is_obeyed_however_many_requests_a_stranger_sends(sea: Sea, message: Any) -> None:
    stranger = Station(77, 1)
    pings = [mavlink.MAVLink_ping_message(0, n, 0, 0) for n in range(40)]
    sea.say(*pings, sender=stranger)
    sea.say(message)
    sea.say(*pings, sender=stranger)
    sea.step()
    assert sea.state == "HOLD"


def test_a_stranger_who_may_not_command_takes_no_place_from_a_hold_or_a_disarm() -> None:
    sea = Sea({"MAV_GCS_SYSID": float(GCS)})
    hold = command_long(SET_MODE, 1.0, float(HOLD))
    sea.enter_formation()
    for message, state in [(hold, "HOLD"), (command_long(ARM, 0.0), "DISARMED")]:
        sea.say(*[hold] * 40, sender=Station(77, 1))
        sea.say(message)
        sea.say(*[hold] * 40, sender=Station(77, 1))
        sea.step()
        assert sea.state == state


def test_the_same_request_said_anew_by_another_link_is_answered(sea: Sea) -> None:
    for link in (0, RADIO):
        sea.say(command_long(SET_MODE, 1.0, float(HOLD)), link=link)
        assert acks(sea.step(), link) == [(SET_MODE, ACCEPTED)]


def test_a_plan_whose_messages_all_come_twice_is_taken_once(sea: Sea) -> None:
    sea.mode(HOLD)
    plan = [at(10, 0), at(10, 10), at(0, 10)]
    messages = [mavlink.MAVLink_mission_count_message(BOAT, 1, len(plan), 0)]
    messages += [item.message(seq) for seq, item in enumerate(plan)]
    ticks, late = [], []
    for message in messages:
        late.append(say(sea, message))
        ticks.append(sea.step())
        if len(late) > 1:
            sea.boat.on_mavlink(late.pop(0), sea.now_us, RADIO)
            ticks.append(sea.step())
    sea.boat.on_mavlink(late.pop(), sea.now_us, RADIO)
    ticks += sea.run(6.0)
    assert [m.type for m in named(ticks, "MISSION_ACK")] == [0]
    assert not named(ticks, "MISSION_ACK", RADIO)
    assert plan_of(sea) == as_sent(plan)
