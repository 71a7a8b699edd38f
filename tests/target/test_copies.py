# SPDX-License-Identifier: MIT
"""Copies of a ground station's messages that other vessels hand on, by another link and late."""

from __future__ import annotations

from typing import Any

import pytest
from pymavlink.dialects.v20 import common as mavlink

from tests.target.plans import as_sent, at, plan_of
from tests.target.sea import Sea, acks, named
from tests.target.stations import ACCEPTED, BOAT, FORMATION, HOLD, SET_MODE, command_long

RADIO = 1


@pytest.fixture
def sea() -> Sea:
    """A boat with a link to the ground station and a radio."""
    sea = Sea(links=2)
    sea.enter_formation()
    return sea


def say(sea: Sea, message: Any) -> bytes:
    """Say it to the boat directly; the frame."""
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


def test_a_stop_is_obeyed_however_often_it_comes(sea: Sea) -> None:
    wire = say(sea, command_long(400, 0.0))
    sea.step()
    sea.arm()
    sea.boat.on_mavlink(wire, sea.now_us, RADIO)
    sea.step()
    assert sea.state == "DISARMED"


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
