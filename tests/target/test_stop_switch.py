# SPDX-License-Identifier: MIT
"""A physical stop: a Button or SafetyState node on the bus, or a switch at the host."""

from __future__ import annotations

from collections.abc import Callable

import dronecan
import pytest
from dronecan.transport import Transfer

from tests.target.bus import Frames, to_wire
from tests.target.sea import Sea, at_sea, texts

NODE = 60
SAID = "stop switch is pressed, or its wire is cut"
Act = Callable[[Sea], None]


def button(number: int = 1) -> Frames:
    payload = dronecan.ardupilot.indication.Button(button=number, press_time=1)
    return to_wire(Transfer(0, NODE, payload=payload, transfer_priority=16))


def safety(status: int) -> Frames:
    payload = dronecan.ardupilot.indication.SafetyState(status=status)
    return to_wire(Transfer(0, NODE, payload=payload, transfer_priority=16))


def press_button(sea: Sea) -> None:
    for _ in range(5):
        sea.on_can(button())
        sea.run(0.1)


def safety_on(sea: Sea) -> None:
    sea.on_can(safety(0))


def host(sea: Sea) -> None:
    sea.boat.on_host(stop_pressed=True)


def release(sea: Sea) -> None:
    sea.boat.on_host()
    for _ in range(6):
        sea.on_can(safety(255))
        sea.run(0.4)


PRESSED = pytest.mark.parametrize("press", [press_button, safety_on, host])


@PRESSED
def test_a_pressed_stop_ends_all_thrust_until_it_is_released_and_the_boat_is_armed_anew(
    press: Act,
) -> None:
    sea = at_sea()
    assert any(sea.commands)
    press(sea)
    sea.step()
    assert sea.state == "FAULT" and sea.commands == (0, 0)
    assert SAID in texts(sea.ticks)
    release(sea)
    sea.step()
    assert sea.state == "FAULT", "nobody said that it may go on"
    sea.disarm()
    sea.enter_formation()


@PRESSED
def test_a_boat_does_not_arm_while_a_stop_is_pressed(press: Act) -> None:
    sea = Sea()
    sea.settle()
    press(sea)
    sea.step()
    for _ in range(20):
        sea.disarm()
        sea.arm()
        for _ in range(5):
            assert sea.step().commands == (0, 0)
            assert sea.state == "FAULT"
        if press is press_button:
            sea.on_can(button())


def test_a_safety_switch_that_falls_silent_counts_as_pressed() -> None:
    sea = Sea()
    sea.on_can(safety(255))
    sea.enter_formation()
    sea.run(1.6)
    assert sea.state == "FORMATION"
    sea.run(0.5)
    assert sea.state == "FAULT" and sea.commands == (0, 0)


def test_another_switch_that_is_off_does_not_hide_one_that_is_on() -> None:
    sea = at_sea()
    sea.on_can(safety(0) + safety(255))
    sea.step()
    assert sea.state == "FAULT"
    sea.disarm()
    for _ in range(5):
        sea.on_can(safety(255))
        sea.arm()
        sea.run(0.3)
        assert sea.state == "FAULT"


@pytest.mark.parametrize("frames", [button(2), safety(255), [(0x104E213C, b"")]])
def test_other_buttons_and_empty_frames_stop_nothing(frames: Frames) -> None:
    sea = at_sea()
    sea.on_can(frames)
    sea.run(0.5)
    assert sea.state == "FORMATION"
