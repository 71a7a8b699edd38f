# SPDX-License-Identifier: MIT
"""The identity of a companion computer beside an autopilot, which is the vehicle."""

from __future__ import annotations

from typing import Any

import pytest
from pymavlink.dialects.v20 import common as mavlink

from tests.target.course import BEHIND, TURN
from tests.target.operator_words import command_int, param_list, param_read, param_set, sticks
from tests.target.sea import Sea, acks, messages, named, texts
from tests.target.stations import (
    ACCEPTED,
    ARM,
    BOAT,
    FORMATION,
    LEADER,
    MOTOR_TEST,
    REQUEST_MESSAGE,
    SET_INTERVAL,
    SET_MODE,
    TERMINATE,
    UNSUPPORTED,
    Station,
    command_long,
)

COMPANION = 191
AUTOPILOT = 42  # its system id, which is not the one that is configured
LISTEN_S = 3.0
ME = (AUTOPILOT, COMPANION)
SPOKEN = {
    "HEARTBEAT",
    "TIMESYNC",
    "NAMED_VALUE_FLOAT",
    "FORMATION_REFERENCE",  # of its leader
    "STATUSTEXT",
}


def beat(autopilot: int = 3, kind: int = mavlink.MAV_TYPE_SURFACE_BOAT) -> Any:
    return mavlink.MAVLink_heartbeat_message(kind, autopilot, 1, 0, 4, 3)


def companion(links: int = 1, **parameters: float) -> Sea:
    sea = Sea(
        {"MAV_IDENTITY": 1, "MAV_COMPID": COMPANION} | parameters, links, own=BEHIND, leader=TURN
    )
    sea.leader.beats = False  # as an autopilot that it would be taken for
    return sea


def latched(links: int = 1, **parameters: float) -> Sea:
    """A companion beside its autopilot, with a fresh own state from the autopilot's system."""
    sea = companion(links, **parameters)
    sea.say(beat(), sender=Station(AUTOPILOT, 1))
    sea.run(LISTEN_S + 0.1)
    sea.own.station = Station(AUTOPILOT, 1)
    sea.run(1.5)
    sea.ticks.clear()
    return sea


def address(sea: Sea) -> tuple[int, int]:
    """The ids of the boat's last heartbeat."""
    header = named(sea.ticks[-120:], "HEARTBEAT")[-1].get_header()
    return header.srcSystem, header.srcComponent


def test_a_companions_heartbeat_has_the_type_of_a_companion() -> None:
    sea = companion()
    heard = named(sea.run(5.0), "HEARTBEAT")
    assert len(heard) in (5, 6)
    for m in heard:
        assert (m.type, m.autopilot, m.base_mode, m.custom_mode) == (18, 8, 1, 4)
        assert (m.get_srcSystem(), m.get_srcComponent()) == (BOAT, COMPANION)


def test_a_companion_takes_its_autopilots_system_id_three_seconds_after_hearing_it() -> None:
    sea = companion()
    sea.run(10.0)
    assert address(sea) == (BOAT, COMPANION)
    heard_us = sea.now_us
    for _ in range(5):
        sea.say(beat(), sender=Station(AUTOPILOT, 1))
        sea.run(1.0)
    assert address(sea) == ME
    seen = set()
    for tick in sea.ticks:
        for m in tick.messages():
            before = tick.now_us < heard_us + LISTEN_S * 1e6
            seen.add(before)
            assert m.get_srcSystem() == (BOAT if before else AUTOPILOT)
            assert m.get_srcComponent() == COMPANION
    assert seen == {True, False}


def test_a_companion_takes_the_id_of_neither_of_two_autopilots() -> None:
    sea = companion()
    sea.say(beat(), sender=Station(AUTOPILOT, 1))
    sea.run(2.0)
    sea.say(beat(12), sender=Station(AUTOPILOT + 1, 1))
    sea.run(10.0)
    assert address(sea) == (BOAT, COMPANION)


def test_a_companion_that_heard_two_autopilots_keeps_its_id_when_it_hears_one_again() -> None:
    sea = companion()
    for system in (AUTOPILOT, AUTOPILOT + 1, AUTOPILOT, AUTOPILOT):
        sea.say(beat(), sender=Station(system, 1))
        sea.run(0.9)
    sea.run(5.0)
    assert address(sea) == (BOAT, COMPANION)


def test_an_autopilot_that_comes_after_the_three_seconds_changes_nothing() -> None:
    sea = latched()
    for _ in range(5):
        sea.say(beat(), sender=Station(AUTOPILOT + 1, 1))
        sea.run(1.0)
    assert address(sea) == ME


def test_other_components_are_not_taken_for_an_autopilot() -> None:
    sea = companion()
    sea.say(beat(8, mavlink.MAV_TYPE_GCS), sender=Station(255, 190))
    sea.say(beat(8, mavlink.MAV_TYPE_ONBOARD_CONTROLLER), sender=Station(77, 191))
    sea.run(4.0)
    assert address(sea) == (BOAT, COMPANION)
    sea.say(beat(8, mavlink.MAV_TYPE_GIMBAL), sender=Station(78, 154))
    sea.say(beat(), sender=Station(AUTOPILOT, 1))
    sea.run(5.0)
    assert address(sea) == ME


@pytest.mark.parametrize(
    ("component", "kind"),
    [(2, mavlink.MAV_TYPE_SURFACE_BOAT), (191, 18), (190, mavlink.MAV_TYPE_GCS), (1, 6)],
    ids=["another component", "companion", "station", "station as component 1"],
)
def test_only_a_vehicles_component_1_is_an_autopilot(component: int, kind: int) -> None:
    """Whatever autopilot type its heartbeat names."""
    sea = companion()
    for _ in range(6):
        sea.say(beat(3, kind), sender=Station(AUTOPILOT, component))
        sea.run(1.0)
    assert address(sea) == (BOAT, COMPANION)
    sea.say(beat(), sender=Station(AUTOPILOT, 1))
    sea.run(LISTEN_S + 1.2)
    assert address(sea) == ME


@pytest.mark.parametrize("armed_first", [True, False])
def test_an_armed_companion_keeps_its_id(armed_first: bool) -> None:
    """Another id would make it lose its own state under way."""
    sea = companion()
    sea.settle()
    if not armed_first:
        sea.say(beat(), sender=Station(AUTOPILOT, 1))
        sea.run(1.0)
    for order in ((ARM, 1.0), (SET_MODE, 1.0, 6.0)):
        sea.say(command_long(*order, target=(BOAT, COMPANION)))
        sea.step()
    assert sea.state == "FORMATION"
    for _ in range(6):
        sea.say(beat(), sender=Station(AUTOPILOT, 1))
        sea.run(1.0)
    assert address(sea) == (BOAT, COMPANION)
    assert sea.state == "FORMATION" and any(sea.commands)


def test_a_companions_leader_is_not_its_autopilot() -> None:
    """The leader is heard before the own autopilot has started: the boat must not take its id.

    It would also take the leader's state for its own, and sail by it.
    """
    sea = companion()
    sea.own.on = False
    sea.leader.beats = True
    sea.run(5.0)
    assert address(sea) == (BOAT, COMPANION)
    assert not sea.condition("own_fresh")


def test_a_vehicle_never_takes_anothers_id(sea: Sea) -> None:
    sea.say(beat(), sender=Station(AUTOPILOT, 1))
    sea.run(6.0)
    assert address(sea) == (BOAT, 1)


def test_a_companion_with_its_new_id_has_the_autopilots_state() -> None:
    sea = companion()
    sea.say(beat(), sender=Station(AUTOPILOT, 1))
    sea.run(2.0)
    assert sea.condition("own_fresh")
    sea.run(2.0)
    assert not sea.condition("own_fresh")  # the configured system is somebody else now
    sea.own.station = Station(AUTOPILOT, 1)
    sea.run(0.5)
    assert sea.condition("own_fresh")


def test_a_companion_sends_none_of_its_autopilots_messages() -> None:
    sea = latched()
    sea.say(command_long(ARM, 1.0, target=ME))
    sea.step()
    sea.say(command_long(SET_MODE, 1.0, 6.0, target=ME))
    sea.run(15.0)
    assert sea.state == "FORMATION" and any(sea.commands)
    said = {m.get_type() for m in messages(sea.ticks)}
    assert said == SPOKEN | {"COMMAND_ACK"}


@pytest.mark.parametrize("message", [1, 30, 32, 33, 144, 242, 331, 245])
def test_a_companion_does_not_send_its_autopilots_messages_on_request(message: int) -> None:
    sea = latched()
    for command in (
        command_long(REQUEST_MESSAGE, float(message), target=ME),
        command_long(SET_INTERVAL, float(message), 1e5, target=ME),
    ):
        sea.say(command)
        ((_, result),) = acks(sea.step())
        assert result == UNSUPPORTED
    sea.run(1.0)
    assert {m.get_type() for m in messages(sea.ticks)} <= SPOKEN | {"COMMAND_ACK"}


@pytest.mark.parametrize("message", [0, 148, 300, 291, 290, 436, 435, 397, 251])
def test_a_companion_sends_its_own_messages_on_request(message: int) -> None:
    sea = latched()
    sea.say(command_long(REQUEST_MESSAGE, float(message), target=ME))
    tick = sea.step()
    assert acks(tick) == [(REQUEST_MESSAGE, ACCEPTED)]
    assert message in [m.get_msgId() for m in tick.messages()]


def test_a_companions_parameters_are_read_as_any_components() -> None:
    sea = latched()
    sea.say(param_read("FORM_LEADER", target=ME))
    (value,) = named(sea.run(0.1), "PARAM_VALUE")
    assert (value.param_id, value.param_value) == ("FORM_LEADER", LEADER)
    sea.say(param_list(target=(AUTOPILOT, 0)))
    assert len(named(sea.run(2.0), "PARAM_VALUE")) == value.param_count


def of_the_system(kind: str, target: tuple[int, int]) -> Any:
    return {
        "arm": command_long(ARM, 1.0, target=target),
        "arm by force": command_long(ARM, 1.0, 21196.0, target=target),
        "arm by COMMAND_INT": command_int(ARM, 1.0, target=target),
        "FORMATION": command_long(SET_MODE, 1.0, 6.0, target=target),
        "MANUAL": command_long(SET_MODE, 1.0, 0.0, target=target),
        "AUTO": command_long(SET_MODE, 1.0, 10.0, target=target),
        "start of the mission": command_long(300, target=target),
        "pause": command_long(193, 0.0, target=target),
        "next item": command_long(224, 0.0, target=target),
        "next item, old": mavlink.MAVLink_mission_set_current_message(*target, 0),
        "test": command_long(MOTOR_TEST, 1.0, 0.0, 10.0, 1.0, target=target),
        "SET_MODE": mavlink.MAVLink_set_mode_message(target[0], 1, FORMATION),
        "unknown command": command_long(31010, 1.0, target=target),
        "take off": command_int(22, 1.0, target=target),
        "unknown parameter": param_set("ARMING_CHECK", 1.0, target=target),
    }[kind]


LEFT_TO_THE_AUTOPILOT = [
    "arm",
    "arm by force",
    "arm by COMMAND_INT",
    "FORMATION",
    "MANUAL",
    "AUTO",
    "start of the mission",
    "pause",
    "next item",
    "next item, old",
    "test",
    "SET_MODE",
    "unknown command",
    "take off",
    "unknown parameter",
]


@pytest.mark.parametrize("kind", LEFT_TO_THE_AUTOPILOT)
@pytest.mark.parametrize("armed", [False, True], ids=["disarmed", "armed"])
@pytest.mark.parametrize("system", [AUTOPILOT, 0], ids=["system", "all"])
def test_a_companion_ignores_drive_commands_to_the_whole_system(
    kind: str, armed: bool, system: int
) -> None:
    """No state changes, and no answer can be mistaken for the autopilot's."""
    sea = latched()
    sea.say(sticks(100, target=AUTOPILOT))
    if armed:
        sea.say(command_long(ARM, 1.0, target=ME))
        sea.step()
    state = sea.state
    sea.run(0.3)
    sea.say(of_the_system(kind, (system, 0)))
    ticks = sea.run(0.3)
    said = {m.get_type() for m in messages(ticks)}
    assert not said & {"COMMAND_ACK", "STATUSTEXT", "PARAM_VALUE", "PARAM_ERROR"}
    assert sea.state == state == ("HOLD" if armed else "DISARMED")


@pytest.mark.parametrize("target", [ME, (AUTOPILOT, 0), (0, 0), (0, COMPANION)])
@pytest.mark.parametrize("make", [command_long, command_int])
@pytest.mark.parametrize(
    ("order", "state"), [((SET_MODE, 1.0, 4.0), "HOLD"), ((TERMINATE, 1.0), "FAULT")]
)
def test_stop_commands_are_obeyed_however_they_are_addressed(
    target: tuple[int, int], make: Any, order: tuple[float, ...], state: str
) -> None:
    sea = latched()
    for first in ((ARM, 1.0), (SET_MODE, 1.0, 6.0)):
        sea.say(command_long(*first, target=ME))
        sea.run(1.0)
    assert sea.state == "FORMATION" and any(sea.commands)
    sea.say(make(*order, target=target))
    tick = sea.step()
    assert acks(tick) == [(order[0], ACCEPTED)]
    assert sea.state == state and tick.commands == (0, 0)


def test_the_old_message_for_hold_stops_a_companion() -> None:
    sea = latched()
    for first in ((ARM, 1.0), (SET_MODE, 1.0, 6.0)):
        sea.say(command_long(*first, target=ME))
        sea.run(1.0)
    sea.say(mavlink.MAVLink_set_mode_message(AUTOPILOT, 1, 4))
    assert sea.step().commands == (0, 0) and sea.state == "HOLD"


@pytest.mark.parametrize("target", [(AUTOPILOT, 0), (0, 0)])
def test_a_companion_leaves_missions_for_the_whole_system_to_the_autopilot(
    target: tuple[int, int],
) -> None:
    """A companion's "none" or "cleared" would be taken for the autopilot's answer."""
    sea = latched()
    sea.say(
        mavlink.MAVLink_mission_request_list_message(*target, 0),
        mavlink.MAVLink_mission_clear_all_message(*target, 0),
        mavlink.MAVLink_mission_count_message(*target, 5, 0),
    )
    ticks = sea.run(0.2)
    assert not named(ticks, "MISSION_COUNT") and not named(ticks, "MISSION_ACK")


@pytest.mark.parametrize("target", [ME, (AUTOPILOT, 0), (0, 0), (0, COMPANION)])
@pytest.mark.parametrize("make", [command_long, command_int])
def test_a_disarm_is_obeyed_however_it_is_addressed(target: tuple[int, int], make: Any) -> None:
    sea = latched()
    for order in ((ARM, 1.0), (SET_MODE, 1.0, 6.0)):
        sea.say(command_long(*order, target=ME))
        sea.run(1.0)
    assert sea.state == "FORMATION" and any(sea.commands)
    sea.say(make(ARM, 0.0, target=target))
    tick = sea.step()
    assert acks(tick) == [(ARM, ACCEPTED)]
    assert sea.state == "DISARMED" and tick.commands == (0, 0)


@pytest.mark.parametrize("target", [(AUTOPILOT, 1), (BOAT, COMPANION), (BOAT, 0), (AUTOPILOT, 190)])
def test_messages_to_the_autopilot_or_the_old_id_are_not_for_a_companion(
    target: tuple[int, int],
) -> None:
    sea = latched()
    sea.say(command_long(ARM, 1.0, target=target), command_long(REQUEST_MESSAGE, 0, target=target))
    assert not named(sea.run(0.2), "COMMAND_ACK") and sea.state == "DISARMED"


def test_a_companion_addressed_alone_does_all_that_a_vehicle_does() -> None:
    sea = latched()
    for order, state in (
        ((ARM, 1.0), "HOLD"),
        ((MOTOR_TEST, 1.0, 0.0, 10.0, 1.0), "TEST"),
        ((SET_MODE, 1.0, 4.0), "HOLD"),
        ((SET_MODE, 1.0, 6.0), "FORMATION"),
        ((TERMINATE, 1.0), "FAULT"),
        ((ARM, 0.0), "DISARMED"),
    ):
        sea.say(command_long(*order, target=ME))
        assert acks(sea.step()) == [(order[0], ACCEPTED)] and sea.state == state
    for unknown in (16, 31010):
        sea.say(command_long(unknown, target=ME))
        assert acks(sea.step()) == [(unknown, UNSUPPORTED)]


def test_the_autopilot_beside_a_companion_is_not_taken_for_another_sender() -> None:
    sea = latched()
    for _ in range(5):
        sea.say(beat(), sender=Station(AUTOPILOT, 1))
        sea.run(1.0)
    assert not texts(sea.ticks)
