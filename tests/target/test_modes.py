# SPDX-License-Identifier: MIT
"""HOLD and FORMATION by the operator's command, and refusals."""

from __future__ import annotations

import math

import pytest
from pymavlink.dialects.v20 import common as mavlink

from tests.target.sea import Sea, acks, texts
from tests.target.stations import (
    BOAT,
    DENIED,
    FORMATION,
    ORIGIN,
    SET_MODE,
    TEMPORARILY_REJECTED,
    Station,
    command_long,
)


@pytest.mark.parametrize(
    "params",
    [
        (1.0, 0.5),
        (1.0, 1.0),
        (1.0, 12.0),
        (1.0, 99.0),
        (1.0, -1.0),
        (1.0, 6.5),
        (1.0, math.nan),
        (1.0, math.inf),
        (1.0, 1e30),
        (1.0, 4294967302.0),
        (0.0, 6.0),
        (math.nan, 6.0),
        (math.inf, 6.0),
        (-1e30, 6.0),
        (),
    ],
    ids=str,
)
def test_a_mode_that_does_not_exist_is_denied(sea: Sea, params: tuple[float, ...]) -> None:
    sea.settle()
    sea.arm()
    assert acks(sea.order(SET_MODE, *params)) == [(SET_MODE, DENIED)]
    assert sea.state == "HOLD"


REST_NAN = (math.nan,) * 4  # MAVSDK's unused parameters
OFFBOARD = "Refused: mode 6 of a PX4 client is OFFBOARD"
SUB_MODE = "Refused: use mode 0, 4, 5, 6, 10, 11 or 15"


@pytest.mark.parametrize(
    ("params", "words"),
    [
        (
            (129.0, 6.0, 0.0, *REST_NAN),
            OFFBOARD,
        ),  # offboard.start(); goto, takeoff of MAVSDK 2 and 3
        ((1.0, 6.0, 0.0, *REST_NAN), OFFBOARD),  # the same before MAVSDK knows that it is armed
        ((29.0, 6.0, 0.0), OFFBOARD),  # pymavlink's set_mode_px4("OFFBOARD")
        ((129.0, 4.0, 8.0, *REST_NAN), SUB_MODE),  # follow_me.start()
    ],
    ids=str,
)
def test_requests_of_a_px4_client_neither_start_nor_stop_a_boat(
    params: tuple[float, ...], words: str
) -> None:
    for state, start in (("HOLD", 4), ("FORMATION", FORMATION)):
        sea = Sea()
        sea.settle()
        sea.arm()
        sea.mode(start)
        sea.run(1.0)
        tick = sea.order(SET_MODE, *params)
        assert acks(tick) == [(SET_MODE, DENIED)]
        assert [m.text for m in tick.named("STATUSTEXT")] == [words]
        sea.run(1.0)
        assert sea.state == state


SETPOINTS = {
    "local": mavlink.MAVLink_set_position_target_local_ned_message(
        0, BOAT, 1, 1, 0xFC7, *(0.0,) * 3, 1.0, *(0.0,) * 7
    ),
    "global": mavlink.MAVLink_set_position_target_global_int_message(
        0, BOAT, 1, 5, 0xFF8, *ORIGIN[:2], *(0.0,) * 9
    ),
    "attitude": mavlink.MAVLink_set_attitude_target_message(
        0, BOAT, 1, 7, [1.0, 0.0, 0.0, 0.0], 0.0, 0.0, 0.0, 0.5
    ),
    "actuators": mavlink.MAVLink_set_actuator_control_target_message(0, 0, BOAT, 1, [0.0] * 8),
}


@pytest.mark.parametrize("kind", SETPOINTS)
@pytest.mark.parametrize("by_message", [False, True])
def test_after_setpoints_mode_6_means_px4_offboard(sea: Sea, kind: str, by_message: bool) -> None:
    sea.settle()
    sea.arm()
    sea.say(SETPOINTS[kind])
    sea.run(4.5)
    ask = mavlink.MAVLink_set_mode_message(BOAT, 1, FORMATION)
    ask = ask if by_message else command_long(SET_MODE, 1.0, float(FORMATION))
    sea.say(ask)
    tick = sea.step()
    assert acks(tick) == ([] if by_message else [(SET_MODE, DENIED)])
    assert "Refused: mode 6 after setpoints is OFFBOARD" in texts([tick])
    assert sea.state == "HOLD"
    sea.say(ask, sender=Station(250, 190))  # another operator, who has sent no setpoint
    sea.step()
    assert sea.state == "FORMATION"
    sea.mode(4)
    sea.run(0.6)  # five seconds after the setpoint
    sea.say(ask)
    sea.step()
    assert sea.state == "FORMATION"


def test_formation_is_refused_to_a_disarmed_boat(sea: Sea) -> None:
    sea.settle()
    assert acks(sea.mode(FORMATION)) == [(SET_MODE, TEMPORARILY_REJECTED)]
    assert sea.state == "DISARMED"
    sea.arm()
    assert sea.state == "HOLD"


def test_formation_is_refused_without_a_leader_with_a_reason(sea: Sea) -> None:
    sea.leader.on = False
    sea.settle()
    sea.arm()
    tick = sea.mode(FORMATION)
    assert acks(tick) == [(SET_MODE, TEMPORARILY_REJECTED)]
    assert any("leader" in m.text for m in tick.named("STATUSTEXT"))
    assert sea.state == "HOLD"
