# SPDX-License-Identifier: MIT
"""Arming: every failing check is named, nothing overrides it, disarming always works."""

from __future__ import annotations

import math
from itertools import combinations
from typing import Any

import pytest

from tests.target.operator_words import ENTER, command_int, param_set
from tests.target.sea import Sea, acks, named, texts
from tests.target.stations import (
    ACCEPTED,
    ARM,
    BOAT,
    DENIED,
    FORCE,
    MOTOR_TEST,
    SET_MODE,
    STRANGER,
    TEMPORARILY_REJECTED,
    Station,
    command_long,
)
from tests.target.test_other_nodes import FOREIGN

PREARM_CHECK = 0x10000000

#: A word of each check's complaint.
CHECKS = {
    "escs": "ESC",
    "bus": "CAN bus is down",
    "sole": "another controller",
    "saved": "parameters",
}
SUBSETS = [s for n in range(1, len(CHECKS) + 1) for s in combinations(CHECKS, n)]


def failing(checks: tuple[str, ...]) -> Sea:
    sea = Sea()
    sea.own.on = "own" not in checks
    sea.escs[1].on = "escs" not in checks
    sea.boat.on_host(bus_up="bus" not in checks, parameters_saved="saved" not in checks)
    sea.settle()
    if "sole" in checks:
        sea.on_can(FOREIGN["RawCommand"])
    return sea


def prearm(said: list[str]) -> list[str]:
    return [text for text in said if text.startswith("PreArm: ")]


@pytest.mark.parametrize("checks", SUBSETS, ids="+".join)
@pytest.mark.parametrize("force", [math.nan, 0.0, float(FORCE)], ids=["nan", "checked", "forced"])
def test_every_check_that_fails_is_named_and_no_other(
    checks: tuple[str, ...], force: float
) -> None:
    sea = failing(checks)
    tick = sea.order(ARM, 1.0, force)
    assert acks(tick) == [(ARM, TEMPORARILY_REJECTED)] and sea.state == "DISARMED"
    said = texts([tick])
    assert prearm(said) == said and len(said) == len(set(said)) == len(checks)
    for check in checks:
        assert len([t for t in said if CHECKS[check] in t]) == 1, check
    assert all(m.severity <= 4 and m.id == 0 for m in tick.named("STATUSTEXT"))
    sea.run(1.0)
    assert sea.state == "DISARMED" and sea.commands == (0, 0)


@pytest.mark.parametrize("check", ["own", *CHECKS])
def test_the_prearm_bit_of_sys_status_is_set_exactly_while_no_check_fails(check: str) -> None:
    for checks in ((), (check,)):
        ticks = failing(checks).run(1.2)
        status = named(ticks, "SYS_STATUS")[-1]
        assert status.onboard_control_sensors_present & PREARM_CHECK
        assert status.onboard_control_sensors_enabled & PREARM_CHECK
        healthy = bool(status.onboard_control_sensors_health & PREARM_CHECK)
        assert healthy == (not checks)


def test_refusals_are_reported_at_most_twice_a_second(sea: Sea) -> None:
    sea.boat.on_host(bus_up=False)
    sea.settle()
    ticks = []
    for _ in range(200):  # 2 s
        tick = sea.arm()
        assert acks(tick) == [(ARM, TEMPORARILY_REJECTED)]
        ticks.append(tick)
    assert 3 <= len(prearm(texts(ticks))) <= 5


@pytest.mark.parametrize("apart", [False, True], ids=["same tick", "next tick"])
@pytest.mark.parametrize(
    "before",
    [
        param_set("THR_FWD_MAX", -5.0),
        command_long(SET_MODE, 1.0, 6.0),
        command_long(MOTOR_TEST, 1.0, 0.0, 10.0, 1.0),
    ],
    ids=["parameter", "mode", "test"],
)
def test_another_refusal_does_not_swallow_why_the_boat_does_not_arm(
    sea: Sea, before: Any, apart: bool
) -> None:
    sea.boat.on_host(bus_up=False)
    sea.settle()
    sea.say(before)
    ticks = [sea.step()] if apart else []
    ticks.append(sea.arm())
    said = texts(ticks)
    assert len(prearm(said)) == 1 and CHECKS["bus"] in prearm(said)[0]
    assert [t for t in said if "efused: " in t]
    sea.say(before)  # and within half a second neither is told again
    assert not texts([sea.arm()])


def test_a_prearm_reason_does_not_swallow_another_refusal(sea: Sea) -> None:
    sea.boat.on_host(bus_up=False)
    sea.settle()
    assert prearm(texts([sea.arm()]))
    sea.say(param_set("THR_FWD_MAX", -5.0))
    assert any("THR_FWD_MAX" in text for text in texts([sea.step()]))
    assert any(text.startswith("Refused: ") for text in texts([sea.mode(6)]))


def test_a_check_that_no_longer_fails_lets_the_boat_arm() -> None:
    sea = failing(("escs", "bus", "saved"))
    assert acks(sea.arm()) == [(ARM, TEMPORARILY_REJECTED)]
    sea.escs[1].on = True
    sea.boat.on_host(bus_up=True, parameters_saved=True)
    sea.run(1.0)
    assert acks(sea.arm()) == [(ARM, ACCEPTED)] and sea.state == "HOLD"


@pytest.mark.parametrize("param2", [math.nan, 0.0, float(FORCE)])
def test_a_ready_boat_arms_with_and_without_force(sea: Sea, param2: float) -> None:
    sea.settle()
    assert acks(sea.order(ARM, 1.0, param2)) == [(ARM, ACCEPTED)] and sea.state == "HOLD"


@pytest.mark.parametrize("state", ["HOLD", "MANUAL", "FORMATION", "TEST"])
def test_arm_force_of_mavsdk_disarms(sea: Sea, state: str) -> None:
    ENTER[state](sea)
    assert acks(sea.order(ARM, 0.0, float(FORCE))) == [(ARM, ACCEPTED)]
    assert sea.state == "DISARMED" and sea.commands == (0, 0)


@pytest.mark.parametrize("as_int", [False, True], ids=["LONG", "INT"])
@pytest.mark.parametrize("number", [1.0, -1.0, 2989.0, 21195.0, 21197.0, 21196.5, math.inf])
def test_no_other_force_number_is_accepted(sea: Sea, number: float, as_int: bool) -> None:
    sea.settle()
    sea.say((command_int if as_int else command_long)(ARM, 1.0, number))
    assert acks(sea.step()) == [(ARM, DENIED)] and sea.state == "DISARMED"


@pytest.mark.parametrize("value", [0.5, 2.0, -1.0, 1e-30, math.nan, math.inf, float(FORCE)])
@pytest.mark.parametrize("param2", [math.nan, float(FORCE)])
@pytest.mark.parametrize("state", ["DISARMED", "HOLD", "FORMATION"])
def test_a_value_that_is_neither_arm_nor_disarm_is_denied(
    sea: Sea, state: str, value: float, param2: float
) -> None:
    ENTER[state](sea)
    assert acks(sea.order(ARM, value, param2)) == [(ARM, DENIED)] and sea.state == state


@pytest.mark.parametrize("state", ["HOLD", "MANUAL", "FORMATION", "TEST"])
@pytest.mark.parametrize("param2", [math.nan, float(FORCE)])
def test_arming_an_armed_boat_is_accepted_and_changes_nothing(state: str, param2: float) -> None:
    sea = Sea()
    ENTER[state](sea)
    said = len(texts(sea.ticks))
    for confirmation in range(3):
        tick = sea.order(ARM, 1.0, param2, confirmation=confirmation)
        assert acks(tick) == [(ARM, ACCEPTED)] and sea.state == state
    assert len(texts(sea.ticks)) == said


def test_arming_an_armed_boat_is_accepted_also_where_it_could_not_arm_now(sea: Sea) -> None:
    sea.enter_hold()
    sea.silence("own")
    sea.run(2.0)
    assert acks(sea.arm()) == [(ARM, ACCEPTED)] and sea.state == "HOLD"


HOWEVER = {
    "LONG": lambda to: command_long(ARM, 0.0, target=to),
    "INT": lambda to: command_int(ARM, 0.0, target=to),
    "forced": lambda to: command_long(ARM, 0.0, float(FORCE), target=to),
    "INT forced": lambda to: command_int(ARM, 0.0, float(FORCE), target=to, frame=6),
    "with other numbers": lambda to: command_long(ARM, 0.0, 7.0, 1e30, -1.0, target=to),
}


@pytest.mark.parametrize("state", ENTER)
@pytest.mark.parametrize("how", HOWEVER)
def test_disarming_works_in_every_state_and_form(state: str, how: str) -> None:
    sea = Sea()
    ENTER[state](sea)
    sea.say(HOWEVER[how]((BOAT, 1)))
    tick = sea.step()
    assert acks(tick) == [(ARM, ACCEPTED)]
    assert sea.state == "DISARMED" and tick.commands == (0, 0)
    assert set(tick.arming) <= {0}
    assert {t.commands for t in sea.run(0.5)} == {(0, 0)}


@pytest.mark.parametrize("target", [(BOAT, 1), (BOAT, 0), (0, 1), (0, 0)])
@pytest.mark.parametrize("how", ["LONG", "INT"])
@pytest.mark.parametrize("sender", [(STRANGER, 1), (0, 0), (BOAT, 197), (250, 190)], ids=str)
def test_other_stations_may_disarm_but_not_arm(
    target: tuple[int, int], how: str, sender: tuple[int, int]
) -> None:
    sea = Sea({"MAV_GCS_SYSID": 250})
    sea.gcs = Station(250, 190)
    sea.enter_formation()
    anybody = Station(*sender)
    if sender[0] != 250:
        sea.say(command_long(SET_MODE, 1.0, 4.0, target=target), sender=anybody)
        assert acks(sea.step()) == [(SET_MODE, DENIED)] and sea.state == "FORMATION"
    sea.say(HOWEVER[how](target), sender=anybody)
    assert acks(sea.step()) == [(ARM, ACCEPTED)] and sea.state == "DISARMED"
    if sender[0] != 250:
        sea.say(command_long(ARM, 1.0, target=target), sender=anybody)
        assert acks(sea.step()) == [(ARM, DENIED)] and sea.state == "DISARMED"


def test_a_disarm_is_not_lost_in_a_flood(sea: Sea) -> None:
    sea.enter_formation()
    sea.say(*[command_long(512, 1.0) for _ in range(200)], command_long(ARM, 0.0))
    tick = sea.step()
    assert sea.state == "DISARMED" and tick.commands == (0, 0)


def test_command_int_arms_whatever_frame_it_names(sea: Sea) -> None:
    sea.settle()
    sea.say(command_int(ARM, 1.0, frame=3, x=123456789, y=-5))
    assert acks(sea.step()) == [(ARM, ACCEPTED)] and sea.state == "HOLD"


def test_a_gain_too_fast_for_the_propellers_is_named_with_its_time_constant() -> None:
    sea = Sea({"THR_LAG": 0.1, "LAW_KDR": 8.0})
    sea.settle()
    tick = sea.arm()
    assert acks(tick) == [(ARM, TEMPORARILY_REJECTED)] and sea.state == "DISARMED"
    said = prearm(texts([tick]))
    assert said == ["PreArm: a gain does not fit the hull"]
    why = [text for text in texts([tick]) if text.startswith("LAW_KDR 8 gives")]
    assert why == ["LAW_KDR 8 gives a yaw loop of 0.04 s, THR_LAG allo"]  # its first 50 characters
    sea.say(param_set("LAW_KDR", -1.0))
    sea.run(0.1)
    assert acks(sea.arm()) == [(ARM, 0)]
