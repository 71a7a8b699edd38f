# SPDX-License-Identifier: MIT
"""DO_FLIGHTTERMINATION: the end of all driving, until the operator disarms."""

from __future__ import annotations

import math
from typing import Any

import pytest

from tests.target.course import TURN
from tests.target.operator_words import ENTER, command_int, drive, enter_fault
from tests.target.sea import Sea, acks, named
from tests.target.stations import (
    ACCEPTED,
    ARM,
    BOAT,
    DENIED,
    FORCE,
    FORMATION,
    GCS,
    HOLD,
    LEADER,
    MANUAL,
    MOTOR_TEST,
    SET_MODE,
    TEMPORARILY_REJECTED,
    TERMINATE,
    Station,
    command_long,
)

EACH_STATE = pytest.mark.parametrize("state", ENTER)


def enter(state: str) -> Sea:
    sea = Sea(leader=TURN)
    ENTER[state](sea)
    if state == "MANUAL":
        drive(sea, 500)
    elif state in ("FORMATION", "TEST"):
        sea.run(0.5)
    assert any(sea.commands) == (state in ("MANUAL", "FORMATION", "TEST"))
    return sea


@EACH_STATE
@pytest.mark.parametrize("as_int", [False, True], ids=["LONG", "INT"])
def test_a_termination_is_a_fault_in_the_same_tick_from_every_state(
    state: str, as_int: bool
) -> None:
    sea = enter(state)
    sea.say((command_int if as_int else command_long)(TERMINATE, 1.0))
    tick = sea.step()
    assert acks(tick) == [(TERMINATE, ACCEPTED)]
    assert sea.state == "FAULT"
    assert tick.commands == (0, 0) and set(tick.arming) <= {0}
    ticks = sea.run(5.0)
    assert {t.commands for t in ticks} == {(0, 0)}
    assert {s for t in ticks for s in t.arming} == {0}
    beat = named(ticks, "HEARTBEAT")[-1]
    assert (beat.custom_mode, beat.base_mode, beat.system_status) == (HOLD, 1, 6)


@pytest.mark.parametrize("state", [s for s in ENTER if s != "FAULT"])
def test_a_termination_is_reported_at_once_by_a_critical_text_and_a_heartbeat(state: str) -> None:
    tick = enter(state).order(TERMINATE, 1.0)
    (text,) = tick.named("STATUSTEXT")
    assert text.severity <= 2 and text.text.startswith("FAULT: terminated")
    (beat,) = tick.named("HEARTBEAT")
    assert beat.system_status == 6


@pytest.mark.parametrize("value", [0.0, 2.0, -1.0, 0.5, math.nan, math.inf])
def test_a_termination_with_another_value_than_one_is_denied(value: float) -> None:
    sea = enter("FORMATION")
    assert acks(sea.order(TERMINATE, value)) == [(TERMINATE, DENIED)]
    assert sea.state == "FORMATION" and any(sea.commands)


@pytest.mark.parametrize("value", [0.0, math.nan])
def test_a_terminated_boat_comes_back_only_by_disarming(sea: Sea, value: float) -> None:
    enter_fault(sea)
    for order in (
        (TERMINATE, value),
        (ARM, 1.0),
        (ARM, 1.0, float(FORCE)),
        (SET_MODE, 1.0, float(HOLD)),
        (SET_MODE, 1.0, float(MANUAL)),
        (SET_MODE, 1.0, float(FORMATION)),
        (MOTOR_TEST, 1.0, 0.0, 10.0, 1.0),
    ):
        tick = sea.order(*order)
        expected = DENIED if order[0] == TERMINATE else TEMPORARILY_REJECTED
        assert acks(tick) == [(order[0], expected)]
        sea.run(0.6)
        assert sea.state == "FAULT" and sea.commands == (0, 0)
    assert acks(sea.disarm()) == [(ARM, ACCEPTED)] and sea.state == "DISARMED"
    sea.enter_hold()


def test_a_refusal_says_how_to_leave_a_termination(sea: Sea) -> None:
    enter_fault(sea)
    tick = sea.arm()
    (text,) = tick.named("STATUSTEXT")
    assert text.text.startswith("PreArm: ") and "disarm" in text.text


def test_a_termination_may_be_repeated(sea: Sea) -> None:
    enter_fault(sea)
    for confirmation in range(4):
        tick = sea.order(TERMINATE, 1.0, confirmation=confirmation)
        assert acks(tick) == [(TERMINATE, ACCEPTED)] and sea.state == "FAULT"
        assert not tick.named("STATUSTEXT")


@EACH_STATE
@pytest.mark.parametrize("sender", [(GCS, 190), (77, 1), (LEADER, 1), (BOAT, 197)], ids=str)
@pytest.mark.parametrize("make", [command_long, command_int])
def test_anybody_terminates_as_anybody_disarms(
    state: str, sender: tuple[int, int], make: Any
) -> None:
    sea = Sea({"MAV_GCS_SYSID": 250})
    sea.gcs = Station(250, 190)
    ENTER[state](sea)
    stranger = Station(*sender)
    sea.say(make(TERMINATE, 1.0), sender=stranger)
    tick = sea.step()
    assert acks(tick) == [(TERMINATE, ACCEPTED)]
    assert sea.state == "FAULT" and tick.commands == (0, 0)
    sea.say(make(ARM, 0.0), sender=stranger)
    assert acks(sea.step()) == [(ARM, ACCEPTED)] and sea.state == "DISARMED"


@pytest.mark.parametrize("value", [0.0, 2.0, math.nan])
def test_a_strangers_termination_with_another_value_is_denied(value: float) -> None:
    sea = Sea({"MAV_GCS_SYSID": 250})
    sea.gcs = Station(250, 190)
    sea.enter_formation()
    sea.gcs = Station(GCS, 190)
    assert acks(sea.order(TERMINATE, value)) == [(TERMINATE, DENIED)]
    assert sea.state == "FORMATION"
