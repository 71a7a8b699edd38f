# SPDX-License-Identifier: MIT
"""An operator's messages besides COMMAND_LONG, and how to bring a boat into each state."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from pymavlink.dialects.v20 import common as mavlink

from tests.target.plans import Planner, at
from tests.target.sea import Sea, Tick
from tests.target.stations import (
    AUTO,
    BOAT,
    GUIDED,
    LOITER,
    MANUAL,
    MOTOR_TEST,
    RTL,
    TERMINATE,
    Station,
)

STICKS_EVERY_S = 0.05
REAL32 = mavlink.MAV_PARAM_TYPE_REAL32
PORT, STBD = 1.0, 2.0  # as DO_MOTOR_TEST counts


def command_int(
    command: int,
    *params: float,
    x: int = 0,
    y: int = 0,
    target: tuple[int, int] = (BOAT, 1),
    frame: int = 0,
) -> Any:
    """COMMAND_INT; its fifth and sixth parameters are integers."""
    filled = [*params, *[math.nan] * (4 - len(params))]
    return mavlink.MAVLink_command_int_message(*target, frame, command, 0, 0, *filled, x, y, 0.0)


def sticks(x: int = 0, r: int = 0, target: int = BOAT, **others: int) -> Any:
    """MANUAL_CONTROL; unused sticks have the values that a gamepad sends."""
    unused = {"y": 0, "z": 500, "buttons": 0} | others
    return mavlink.MAVLink_manual_control_message(target=target, x=x, r=r, **unused)


def set_mode_message(custom_mode: int, base_mode: int = 1) -> Any:
    """SET_MODE, the old message that is never acknowledged."""
    return mavlink.MAVLink_set_mode_message(BOAT, base_mode, custom_mode)


def param_list(target: tuple[int, int] = (BOAT, 1)) -> Any:
    return mavlink.MAVLink_param_request_list_message(*target)


def param_read(which: int | str, target: tuple[int, int] = (BOAT, 1)) -> Any:
    name, index = (which.encode(), -1) if isinstance(which, str) else (b"", which)
    return mavlink.MAVLink_param_request_read_message(*target, name, index)


def param_set(
    name: str, value: float, kind: int = REAL32, target: tuple[int, int] = (BOAT, 1)
) -> Any:
    return mavlink.MAVLink_param_set_message(*target, name.encode(), value, kind)


def drive(
    sea: Sea,
    x: int,
    r: int = 0,
    seconds: float = 1.0,
    sender: Station | None = None,
    link: int = 0,
) -> list[Tick]:
    """Send these sticks 20 times a second."""
    ticks: list[Tick] = []
    for _ in range(round(seconds / STICKS_EVERY_S)):
        sea.say(sticks(x, r), sender=sender, link=link)
        ticks += sea.run(STICKS_EVERY_S)
    return ticks


def enter_manual(sea: Sea) -> None:
    """Enter MANUAL with centred sticks and wait for the end of the ESCs' zeros after arming."""
    sea.enter_hold()
    drive(sea, 0, 0, 0.3)
    sea.mode(MANUAL)
    assert sea.state == "MANUAL", sea.snapshot()


def enter_test(sea: Sea, *params: float) -> None:
    """Begin a motor test; by default port propeller, 10 % ahead, 5 s."""
    sea.enter_hold()
    sea.run(0.3)
    sea.order(MOTOR_TEST, *(params or (PORT, 0.0, 10.0, 5.0)))
    assert sea.state == "TEST", sea.snapshot()


def enter_fault(sea: Sea) -> None:
    sea.enter_hold()
    sea.order(TERMINATE, 1.0)
    assert sea.state == "FAULT", sea.snapshot()


def enter_auto(sea: Sea) -> None:
    """Enter AUTO with a plan of one waypoint."""
    sea.enter_hold()
    Planner(sea).send([at(20, 0)])
    sea.mode(AUTO)
    sea.step()
    assert sea.state == "AUTO", sea.snapshot()


def enter_alone(mode: int) -> Callable[[Sea], None]:
    """Into GUIDED, LOITER or RTL."""

    def enter(sea: Sea) -> None:
        sea.enter_hold()
        sea.mode(mode)

    return enter


#: How to bring a boat into each state.
ENTER = {
    "DISARMED": Sea.settle,
    "HOLD": Sea.enter_hold,
    "MANUAL": enter_manual,
    "FORMATION": Sea.enter_formation,
    "TEST": enter_test,
    "FAULT": enter_fault,
    "AUTO": enter_auto,
    "GUIDED": enter_alone(GUIDED),
    "LOITER": enter_alone(LOITER),
    "RTL": enter_alone(RTL),
}
