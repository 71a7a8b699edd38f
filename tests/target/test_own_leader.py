# SPDX-License-Identifier: MIT
"""A boat must not follow itself, neither by its present nor by its future system id."""

from __future__ import annotations

import pytest
from pymavlink.dialects.v20 import common as mavlink

from tests.target.course import TURN
from tests.target.operator_words import param_set
from tests.target.sea import Sea, acks, named, texts
from tests.target.stations import ACCEPTED, ARM, BOAT, LEADER, SET_MODE, Station, command_long
from tests.target.test_companion import AUTOPILOT, ME, beat, companion, latched

OUT_OF_RANGE = 2  # MAV_PARAM_ERROR_VALUE_OUT_OF_RANGE
DRIVE = [(ARM, 1.0), (SET_MODE, 1.0, 6.0)]


def refused(sea: Sea, name: str, value: float, target: tuple[int, int] = (BOAT, 1)) -> None:
    before = sea.boat.parameters()[name]
    sea.say(param_set(name, value, target=target))
    ticks = sea.run(0.1)
    (error,) = named(ticks, "PARAM_ERROR")
    assert (error.param_id, error.error) == (name, OUT_OF_RANGE)
    assert [m.param_value for m in named(ticks, "PARAM_VALUE")] == [before]
    assert any(name in text for text in texts(ticks))
    assert sea.boat.parameters()[name] == before
    sea.run(0.5)  # until refusals are told again


def taken(sea: Sea, name: str, value: float, target: tuple[int, int] = (BOAT, 1)) -> None:
    sea.say(param_set(name, value, target=target))
    ticks = sea.run(0.6)
    assert not named(ticks, "PARAM_ERROR") and sea.boat.parameters()[name] == value


@pytest.mark.parametrize("armed", [False, True])
def test_a_boats_own_system_id_is_refused_as_form_leader(sea: Sea, armed: bool) -> None:
    sea.enter_formation() if armed else sea.settle()
    refused(sea, "FORM_LEADER", BOAT)
    assert sea.state == ("FORMATION" if armed else "DISARMED")


def test_the_present_and_the_next_system_id_are_both_refused_as_form_leader(sea: Sea) -> None:
    sea.settle()
    taken(sea, "MAV_SYSID", 9)
    refused(sea, "FORM_LEADER", BOAT)  # in force
    refused(sea, "FORM_LEADER", 9)  # after the restart
    taken(sea, "FORM_LEADER", 50)
    sea.run(1.0)
    assert named(sea.ticks, "HEARTBEAT")[-1].get_srcSystem() == BOAT


def test_a_boat_does_not_take_its_leaders_system_id(sea: Sea) -> None:
    sea.settle()
    refused(sea, "MAV_SYSID", LEADER)


def test_a_companion_does_not_follow_its_autopilot() -> None:
    sea = latched()
    refused(sea, "FORM_LEADER", AUTOPILOT, target=ME)
    refused(sea, "FORM_LEADER", BOAT, target=ME)  # its name after a restart alone
    taken(sea, "FORM_LEADER", 50, target=ME)


def test_a_companion_whose_autopilot_comes_later_does_not_follow_it() -> None:
    """FORM_LEADER was set to the boat's future system id before the autopilot was heard."""
    sea = companion(FORM_LEADER=float(AUTOPILOT))
    sea.leader.on = False
    sea.own.on = False
    vessel = Station(AUTOPILOT, 1)
    sea.own.station = vessel
    sea.own.on = True
    for _ in range(6):
        sea.say(beat(), sender=vessel)
        sea.run(1.0)
        same = sea.condition("own_fresh") and sea.condition("leader_fresh")
        assert not same or named(sea.ticks, "HEARTBEAT")[-1].get_srcSystem() != AUTOPILOT


def test_a_form_leader_set_to_a_companions_next_system_id_is_never_followed() -> None:
    """In the three seconds between hearing its autopilot and taking its system id."""
    sea = companion()
    vessel = Station(AUTOPILOT, 1)
    sea.say(beat(), sender=vessel)
    sea.run(1.0)
    sea.say(param_set("FORM_LEADER", AUTOPILOT, target=(BOAT, 191)))
    sea.own.station = vessel
    sea.run(3.0)
    for target in (ME, (BOAT, 191)):
        for order, *how in DRIVE:
            sea.say(command_long(int(order), *how, target=target))
            sea.step()
    sea.run(1.0)
    assert sea.state != "FORMATION" and not any(sea.commands)
    assert not sea.condition("leader_fresh") or not sea.condition("own_fresh")


def test_a_boat_never_follows_itself_even_by_its_own_units_state() -> None:
    sea = Sea(own=TURN)
    sea.enter_hold()
    for value in (BOAT, float(BOAT)):
        sea.say(param_set("FORM_LEADER", value))
        sea.step()
    sea.say(mavlink.MAVLink_param_set_message(BOAT, 1, b"FORM_LEADER", 2.0, 9))
    sea.leader.on = False
    sea.run(2.0)
    assert acks(sea.mode(6)) != [(SET_MODE, ACCEPTED)]
    assert sea.state == "HOLD" and sea.commands == (0, 0)
