# SPDX-License-Identifier: MIT
"""Pauses of a plan and of an errand: what ends one, and what must not."""

import pytest
from pymavlink.dialects.v20 import common as mavlink

from tests.target.plans import at
from tests.target.sea import acks, texts
from tests.target.stations import (
    ACCEPTED,
    AUTO,
    LOITER,
    PAUSE,
    REPOSITION,
    RTL,
    SET_MODE,
    TEMPORARILY_REJECTED,
)
from tests.target.test_auto import SET_CURRENT, place, sailing
from tests.target.test_going_and_waiting import guided, reposition


def test_a_boat_on_its_way_home_can_be_paused() -> None:
    sea = guided(15.0)
    sea.run(40.0)
    sea.mode(RTL)
    sea.run(8.0)
    assert acks(sea.order(PAUSE, 0.0)) == [(PAUSE, ACCEPTED)]
    sea.run(10.0)
    stopped = place(sea)
    sea.run(10.0)
    assert place(sea) == pytest.approx(stopped, abs=0.02)
    sea.order(PAUSE, 1.0)
    sea.run(50.0)
    assert place(sea) == pytest.approx((0, 0), abs=0.05)


def test_a_late_copy_of_a_command_does_not_end_a_newer_pause() -> None:
    sea = guided(30.0)
    sea.run(10.0)
    sea.order(PAUSE, 1.0)  # its answer is lost
    sea.order(PAUSE, 0.0)
    tick = sea.order(PAUSE, 1.0, confirmation=1)
    assert acks(tick) == [(PAUSE, mavlink.MAV_RESULT_TEMPORARILY_REJECTED)]
    assert "Refused: boat was just paused: ask again in 5 s" in texts([tick])
    sea.run(4.9)
    stopped = place(sea)
    sea.run(3.0)
    assert place(sea) == pytest.approx(stopped, abs=0.02)
    assert acks(sea.order(PAUSE, 1.0, confirmation=2)) == [(PAUSE, ACCEPTED)]
    sea.run(5.0)
    assert place(sea)[0] > stopped[0] + 0.5


def test_a_repeated_order_whose_first_copy_was_lost_ends_an_older_pause() -> None:
    sea = sailing([at(30, 0)])
    sea.order(PAUSE, 0.0)
    tick = sea.order(SET_MODE, 1.0, float(AUTO), confirmation=1)
    assert acks(tick) == [(SET_MODE, TEMPORARILY_REJECTED)]
    assert "Refused: boat was just paused: ask again in 5 s" in texts([tick])
    sea.run(10.0)
    stopped = place(sea)
    assert acks(sea.order(SET_MODE, 1.0, float(AUTO), confirmation=2)) == [(SET_MODE, ACCEPTED)]
    sea.run(10.0)
    assert place(sea)[0] > stopped[0] + 2.0


@pytest.mark.parametrize("mode", [RTL, LOITER])
def test_a_repeated_order_to_another_mode_is_accepted_right_after_a_pause(mode: int) -> None:
    sea = guided(30.0)
    sea.run(5.0)
    sea.order(PAUSE, 0.0)
    tick = sea.order(SET_MODE, 1.0, float(mode), confirmation=1)
    assert acks(tick) == [(SET_MODE, ACCEPTED)] and not any("Refused" in t for t in texts([tick]))
    assert sea.state == {RTL: "RTL", LOITER: "LOITER"}[mode]


def test_the_same_target_again_ends_a_pause_but_not_one_that_has_just_begun() -> None:
    sea = guided(30.0)
    sea.run(5.0)
    sea.order(PAUSE, 0.0)
    tick = reposition(sea, at(30, 0))
    assert acks(tick) == [(REPOSITION, TEMPORARILY_REJECTED)]
    assert "Refused: boat was just paused: ask again in 5 s" in texts([tick])
    sea.run(10.0)
    stopped = place(sea)
    sea.run(3.0)
    assert place(sea) == pytest.approx(stopped, abs=0.02)
    assert acks(reposition(sea, at(30, 0))) == [(REPOSITION, ACCEPTED)]
    sea.run(10.0)
    assert place(sea)[0] > stopped[0] + 2.0


@pytest.mark.parametrize("how", [(PAUSE, 1.0), (SET_CURRENT, 1.0)])
def test_a_late_copy_of_a_command_does_not_end_a_pause_of_the_plan(how: tuple[int, float]) -> None:
    sea = sailing([at(3, 0)._replace(autocontinue=0), at(20, 0)])
    while not any(text.startswith("Plan paused") for text in texts([sea.step()])):
        pass
    assert acks(sea.order(*how, confirmation=1)) == [(how[0], TEMPORARILY_REJECTED)]


@pytest.mark.parametrize("order", ["home", "there"])
def test_a_new_order_ends_a_pause(order: str) -> None:
    sea = guided(10.0)
    sea.run(5.0)
    sea.order(PAUSE, 0.0)
    sea.run(10.0)
    if order == "home":
        sea.mode(RTL)
        sea.run(8.0)
        sea.order(PAUSE, 0.0)
        sea.run(3.0)
        sea.mode(RTL)
    else:
        reposition(sea, at(0, 10))
    sea.run(50.0)
    assert place(sea) == pytest.approx((0, 0) if order == "home" else (0, 10), abs=0.1)
