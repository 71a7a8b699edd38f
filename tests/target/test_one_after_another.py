# SPDX-License-Identifier: MIT
"""Requests in one tick are processed in order, each with the effects of those before it."""

from __future__ import annotations

from typing import Any

import pytest
from pymavlink.dialects.v20 import common as mavlink

from tests.target.bus import FULL_SCALE
from tests.target.course import TURN
from tests.target.operator_words import PORT, enter_manual, param_set, set_mode_message, sticks
from tests.target.sea import Sea, acks, named, texts
from tests.target.stations import (
    ACCEPTED,
    ARM,
    FORMATION,
    HOLD,
    MOTOR_TEST,
    SET_MODE,
    TEMPORARILY_REJECTED,
    TERMINATE,
    Station,
    command_long,
)

TOGETHER = pytest.mark.parametrize("chunks", [1, 2], ids=["in one chunk", "in two chunks"])


def say(sea: Sea, chunks: int, *messages: Any) -> None:
    if chunks == 1:
        sea.say(*messages)
    else:
        for message in messages:
            sea.say(message)


def thrust_in_test(sea: Sea) -> float:
    """The port propeller's command, as a share of full scale, in a motor test of 20 %."""
    sea.run(0.3)
    assert acks(sea.order(MOTOR_TEST, PORT, 0.0, 20.0, 2.0)) == [(MOTOR_TEST, ACCEPTED)]
    sea.run(0.5)
    port = int(sea.boat.parameters()["ESC_PORT"])
    return sea.commands[port] / FULL_SCALE


@TOGETHER
def test_a_greater_thrust_is_in_force_when_the_boat_is_armed_with_it(sea: Sea, chunks: int) -> None:
    sea.settle()
    say(sea, chunks, param_set("THR_FWD_MAX", 100.0), command_long(ARM, 1.0))
    assert acks(sea.step()) == [(ARM, ACCEPTED)]
    assert sea.boat.parameters()["THR_FWD_MAX"] == 100
    assert thrust_in_test(sea) == pytest.approx(0.2, abs=1e-3)
    assert sea.snapshot()["thrust_N"]["port"] == pytest.approx(20.0, abs=0.02)


def test_a_greater_thrust_is_in_force_in_a_motor_test_of_the_next_tick(sea: Sea) -> None:
    sea.settle()
    sea.say(param_set("THR_FWD_MAX", 100.0), command_long(ARM, 1.0))
    sea.step()
    assert acks(sea.order(MOTOR_TEST, PORT, 0.0, 20.0, 2.0)) == [(MOTOR_TEST, ACCEPTED)]
    sea.run(0.7)
    assert list(sea.commands) == pytest.approx([0.2 * FULL_SCALE, 0], abs=2)


@TOGETHER
def test_a_propeller_that_turns_the_other_way_does_so_from_arming_on(sea: Sea, chunks: int) -> None:
    sea.settle()
    say(sea, chunks, param_set("THR_PORT_DIR", -1.0), command_long(ARM, 1.0))
    assert acks(sea.step()) == [(ARM, ACCEPTED)]
    assert thrust_in_test(sea) == pytest.approx(-0.2, abs=1e-3)


@TOGETHER
def test_a_boat_set_to_a_missing_esc_does_not_arm(sea: Sea, chunks: int) -> None:
    sea.settle()
    say(sea, chunks, param_set("ESC_PORT", 5.0), command_long(ARM, 1.0))
    tick = sea.step()
    assert acks(tick) == [(ARM, TEMPORARILY_REJECTED)] and sea.state == "DISARMED"
    assert any(t.startswith("PreArm: ") and "ESC" in t for t in texts([tick]))


@TOGETHER
def test_a_boat_set_to_another_esc_drives_that_one(sea: Sea, chunks: int) -> None:
    sea.escs.append(type(sea.escs[0])(33, 5))
    sea.run(1.5)
    say(sea, chunks, param_set("ESC_PORT", 5.0), command_long(ARM, 1.0))
    assert acks(sea.step()) == [(ARM, ACCEPTED)]
    assert thrust_in_test(sea) == pytest.approx(0.2, abs=1e-3)
    assert sea.commands[:2] == (0, 0)


@TOGETHER
def test_a_changed_fs_nav_s_applies_to_an_arming_in_the_same_tick(sea: Sea, chunks: int) -> None:
    sea.run(1.0)
    sea.silence("own")
    sea.run(0.2)
    assert sea.condition("own_fresh")
    say(sea, chunks, param_set("FS_NAV_S", 0.05), command_long(ARM, 1.0))
    tick = sea.step()
    only = "armed, no FORMATION: no recent navigation data"
    assert acks(tick) == [(ARM, ACCEPTED)] and only in texts([tick])
    sea.disarm()
    say(sea, chunks, param_set("FS_NAV_S", 2.0), command_long(ARM, 1.0))
    tick = sea.step()
    assert acks(tick) == [(ARM, ACCEPTED)] and texts([tick]) == ["HOLD"]


@TOGETHER
@pytest.mark.parametrize("how", ["command", "message"])
def test_a_leader_that_nobody_has_heard_is_not_followed(chunks: int, how: str) -> None:
    sea = Sea(leader=TURN)
    sea.enter_hold()
    sea.run(0.5)
    assert sea.condition("leader_fresh")
    order = {
        "command": command_long(SET_MODE, 1.0, float(FORMATION)),
        "message": set_mode_message(FORMATION),
    }[how]
    say(sea, chunks, param_set("FORM_LEADER", 50.0), order)
    tick = sea.step()
    if how == "command":
        assert acks(tick) == [(SET_MODE, TEMPORARILY_REJECTED)]
    assert any(t.startswith("Refused: ") and "leader" in t for t in texts([tick]))
    assert sea.state == "HOLD"
    assert {t.commands for t in sea.run(1.0)} == {(0, 0)}


@TOGETHER
def test_a_boat_in_manual_does_not_follow_a_leader_that_it_does_not_hear(
    sea: Sea, chunks: int
) -> None:
    enter_manual(sea)
    sea.say(sticks(200))
    order = command_long(SET_MODE, 1.0, float(FORMATION))
    say(sea, chunks, param_set("FORM_LEADER", 50.0), order)
    assert acks(sea.step()) == [(SET_MODE, TEMPORARILY_REJECTED)]
    assert sea.state == "MANUAL"


@TOGETHER
def test_a_parameter_set_after_an_arming_is_refused_as_on_an_armed_boat(
    sea: Sea, chunks: int
) -> None:
    sea.settle()
    say(sea, chunks, command_long(ARM, 1.0), param_set("THR_FWD_MAX", 100.0))
    tick = sea.step()
    assert acks(tick) == [(ARM, ACCEPTED)]
    assert named([tick, *sea.run(0.1)], "PARAM_ERROR")
    assert sea.boat.parameters()["THR_FWD_MAX"] == 20


@TOGETHER
def test_a_parameter_set_after_a_disarm_is_accepted_as_on_a_disarmed_boat(
    sea: Sea, chunks: int
) -> None:
    sea.enter_formation()
    sets = [param_set(name, 30.0) for name in ("THR_FWD_MAX", "THR_REV_MAX")]
    say(sea, chunks, command_long(ARM, 0.0), *sets)
    assert acks(sea.step()) == [(ARM, ACCEPTED)]
    assert sea.boat.parameters()["THR_FWD_MAX"] == sea.boat.parameters()["THR_REV_MAX"] == 30
    assert acks(sea.arm()) == [(ARM, ACCEPTED)]
    assert sea.state == "HOLD" and sea.commands == (0, 0)


def test_many_sets_in_a_tick_are_all_in_force_at_its_end(sea: Sea) -> None:
    sea.settle()
    sets = [param_set("THR_FWD_MAX", 10.0 + k) for k in range(22)]
    sea.say(*sets, command_long(ARM, 1.0))
    assert acks(sea.step()) == [(ARM, ACCEPTED)]
    assert sea.boat.parameters()["THR_FWD_MAX"] == 31
    assert thrust_in_test(sea) == pytest.approx(0.2, abs=1e-3)
    assert sea.snapshot()["thrust_N"]["port"] == pytest.approx(0.2 * 31, abs=0.02)


def test_a_change_of_mav_gcs_sysid_applies_to_the_next_command_of_the_tick(sea: Sea) -> None:
    sea.settle()
    sea.say(param_set("MAV_GCS_SYSID", 7.0), command_long(ARM, 1.0))
    assert acks(sea.step()) == [(ARM, 2)] and sea.state == "DISARMED"


# A command that stops the boat is never lost, however many messages precede it.

QUESTION = command_long(512, 251.0)


def stops(*order: str) -> list[Any]:
    kinds = {"disarm": command_long(ARM, 0.0), "terminate": command_long(TERMINATE, 1.0)}
    return [kinds[kind] for kind in order]


@pytest.mark.parametrize(
    "order",
    [
        ("disarm",),
        ("terminate",),
        ("disarm", "terminate"),
        ("terminate", "disarm"),
        ("disarm",) * 24 + ("terminate",),
        ("terminate",) * 24 + ("disarm",),
        ("terminate", "disarm") * 20,
    ],
    ids=lambda order: f"{len(order)} {'+'.join(order[:2])}",
)
@pytest.mark.parametrize("before", ["nothing", "PINGs", "questions", "arming"])
@pytest.mark.parametrize("state", ["HOLD", "FORMATION", "MANUAL"])
def test_a_stop_acts_whatever_came_before(order: tuple[str, ...], before: str, state: str) -> None:
    sea = Sea(leader=TURN)
    {"HOLD": Sea.enter_hold, "FORMATION": Sea.enter_formation, "MANUAL": enter_manual}[state](sea)
    flood = {
        "nothing": [],
        "PINGs": [ping(k) for k in range(24)],
        "questions": [QUESTION] * 24,
        "arming": [command_long(ARM, 1.0)] * 24,
    }[before]
    sea.say(*flood, *stops(*order))
    ticks = [sea.step()]
    assert ticks[0].commands == (0, 0)
    for _ in range(100):
        sea.say(sticks(500))
        ticks.append(sea.step())
    assert {t.commands for t in ticks} == {(0, 0)}
    assert sea.state in ("DISARMED", "FAULT")
    if order[-1] == "disarm" and len(set(order)) == 1:
        assert sea.state == "DISARMED"


def ping(k: int) -> Any:
    return mavlink.MAVLink_ping_message(1, k, 0, 0)


@pytest.mark.parametrize("flood", ["PINGs", "questions"])
def test_a_disarm_behind_a_waiting_arming_is_obeyed_last(flood: str) -> None:
    """Answers fill the tick; requests that wait for the next one must not undo the disarm."""
    for n in range(23):
        sea = Sea(links=1)
        sea.enter_hold()
        sea.run(0.5)
        asked = [ping(k) for k in range(n)] if flood == "PINGs" else [QUESTION] * n
        sea.say(QUESTION, QUESTION, *asked[:20], command_long(ARM, 1.0), command_long(ARM, 0.0))
        sea.run(0.5)
        assert sea.state == "DISARMED", n


def test_a_disarm_is_obeyed_last_though_answers_and_forwarding_fill_the_tick() -> None:
    """400 forwarded bytes, ten values, twenty PINGs."""
    for n in range(21):
        sea = Sea(links=2)
        sea.enter_hold()
        sea.say(ping(0), sender=sea.gcs, link=0)
        sea.run(0.5)
        sea.say(*[command_long(76, target=(255, 190))] * 9, sender=sea.leader.station, link=1)
        asked = [QUESTION, *[ping(k) for k in range(n)]]
        sea.say(*asked, command_long(ARM, 1.0), command_long(ARM, 0.0))
        sea.run(0.5)
        assert sea.state == "DISARMED", n


def test_a_disarm_and_a_strangers_termination_behind_24_pings_both_stop_the_boat() -> None:
    sea = Sea({"MAV_GCS_SYSID": 255}, leader=TURN)
    sea.enter_formation()
    for order in (("disarm", "terminate"), ("terminate", "disarm")):
        sea.say(*[ping(k) for k in range(24)])
        for stop in order:
            sender = sea.gcs if stop == "disarm" else Station(77, 1)
            sea.say(*stops(stop), sender=sender)
        assert sea.step().commands == (0, 0)
        assert sea.state in ("DISARMED", "FAULT")
        sea.run(1.0)
        assert sea.state in ("DISARMED", "FAULT")
        sea.disarm()
        sea.enter_formation()


STOPS = {
    "disarm": (command_long(ARM, 0.0), "DISARMED"),
    "terminate": (command_long(TERMINATE, 1.0), "FAULT"),
}


@TOGETHER
@pytest.mark.parametrize("stop", STOPS)
def test_disarming_wins_over_the_orders_behind_it_in_the_same_tick(stop: str, chunks: int) -> None:
    sea = Sea(leader=TURN)
    sea.enter_formation()
    sea.run(2.0)
    assert any(sea.step().commands)
    message, state = STOPS[stop]
    hold, form = (command_long(SET_MODE, 1.0, float(mode)) for mode in (HOLD, FORMATION))
    arms = [command_long(ARM, 1.0, confirmation=copy) for copy in (0, 1)]
    say(sea, chunks, message, hold, arms[0], form, arms[1])
    tick = sea.step()
    first, _, *behind = acks(tick)
    rejected = [(ARM, TEMPORARILY_REJECTED), (SET_MODE, TEMPORARILY_REJECTED)]
    assert first == (message.command, ACCEPTED) and behind == [*rejected, rejected[0]]
    assert any("Refused" in text for text in texts([tick]))
    assert sea.state == state
    assert not any(any(tick.commands) for tick in [tick, *sea.run(1.0)])
    assert sea.state == state
    sea.disarm()
    assert acks(sea.arm()) == [(ARM, ACCEPTED)], "the operator has seen the boat stop"
    assert acks(sea.mode(FORMATION)) == [(SET_MODE, ACCEPTED)]
    assert any(any(tick.commands) for tick in sea.run(1.0))


def test_formation_behind_hold_in_the_same_tick_begins_formation_anew() -> None:
    sea = Sea(leader=TURN)
    sea.enter_formation()
    modes = [command_long(SET_MODE, 1.0, float(mode)) for mode in (HOLD, FORMATION)]
    sea.say(*modes)
    assert acks(sea.step()) == [(SET_MODE, ACCEPTED)] * 2
    assert sea.state == "FORMATION"


def test_an_order_behind_a_stop_that_had_to_wait_for_room_is_refused_too() -> None:
    """Answers fill the tick of the stop; the order is answered in the next one."""
    for n in range(21):
        sea = Sea(links=1)
        sea.enter_formation()
        sea.say(
            QUESTION, *[ping(k) for k in range(n)], command_long(ARM, 0.0), command_long(ARM, 1.0)
        )
        sea.run(0.5)
        assert sea.state == "DISARMED", n
