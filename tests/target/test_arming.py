# SPDX-License-Identifier: MIT
"""Arming and disarming: exact numbers, checks that fail, no force."""

from __future__ import annotations

import math

import pytest

from tests.target.sea import Sea, acks
from tests.target.stations import ACCEPTED, ARM, DENIED, FORCE, TEMPORARILY_REJECTED


@pytest.mark.parametrize("value", [2.0, -1.0, 0.5, 1.0000001, math.nan, math.inf, -math.inf, 1e30])
def test_an_arming_value_other_than_zero_or_one_is_denied(sea: Sea, value: float) -> None:
    sea.settle()
    assert acks(sea.order(ARM, value)) == [(ARM, DENIED)]
    assert sea.state == "DISARMED"
    sea.arm()
    assert acks(sea.order(ARM, value)) == [(ARM, DENIED)]
    assert sea.state == "HOLD"


@pytest.mark.parametrize("value", [1.0, 5.0, 21195.0, 21197.0, -21196.0, math.inf])
def test_another_force_number_is_denied(sea: Sea, value: float) -> None:
    sea.settle()
    assert acks(sea.order(ARM, 1.0, value)) == [(ARM, DENIED)]
    assert sea.state == "DISARMED"


def fail(sea: Sea, check: str) -> None:
    if check == "one ESC":
        sea.escs[1].on = False
    elif check == "both ESCs":
        sea.escs[0].on = sea.escs[1].on = False
    else:
        sea.escs[0].health = 2


CHECKS = pytest.mark.parametrize("check", ["one ESC", "both ESCs", "ESC health"])


@CHECKS
@pytest.mark.parametrize("force", [math.nan, 0.0, float(FORCE)], ids=["nan", "checked", "forced"])
def test_while_a_check_fails_no_command_arms_a_boat_and_the_check_is_named(
    sea: Sea, check: str, force: float
) -> None:
    fail(sea, check)
    sea.run(2.0)
    tick = sea.order(ARM, 1.0, force)
    assert acks(tick) == [(ARM, TEMPORARILY_REJECTED)]
    said = [m for m in tick.named("STATUSTEXT") if m.text.startswith("PreArm: ")]
    assert len(said) == 1 and said[0].severity <= 4 and len(said[0].text) <= 50
    assert "ESC" in said[0].text
    sea.run(0.5)
    assert sea.state == "DISARMED" and sea.commands == (0, 0)


@CHECKS
@pytest.mark.parametrize("force", [math.nan, float(FORCE)], ids=["plain", "arm_force of MAVSDK"])
def test_disarming_always_works(check: str, force: float) -> None:
    for enter in (Sea.enter_hold, Sea.enter_formation):
        sea = Sea()
        enter(sea)
        fail(sea, check)
        sea.run(3.0)
        assert acks(sea.order(ARM, 0.0, force)) == [(ARM, ACCEPTED)]
        assert sea.state == "DISARMED" and sea.commands == (0, 0)


def test_the_force_number_does_not_arm_when_it_says_disarm(sea: Sea) -> None:
    sea.settle()
    assert acks(sea.order(ARM, 0.0, FORCE)) == [(ARM, ACCEPTED)]
    assert sea.state == "DISARMED"
