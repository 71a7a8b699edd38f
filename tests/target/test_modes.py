# SPDX-License-Identifier: MIT
"""HOLD and FORMATION by order of the operator, and the refusals."""

from __future__ import annotations

import math

import pytest

from tests.target.sea import Sea, acks
from tests.target.stations import ACCEPTED, DENIED, FORMATION, SET_MODE, TEMPORARILY_REJECTED

MANUAL = 0


@pytest.mark.parametrize(
    "params",
    [
        (1.0, 0.5),
        (1.0, 1.0),
        (1.0, 5.0),
        (1.0, 99.0),
        (1.0, -1.0),
        (1.0, 6.5),
        (1.0, math.nan),
        (1.0, math.inf),
        (1.0, 1e30),
        (1.0, 4294967302.0),
        (1.0,),
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


def test_manual_is_refused_without_sticks_and_says_so(sea: Sea) -> None:
    sea.settle()
    sea.arm()
    sea.run(1.0)
    tick = sea.mode(MANUAL)
    assert acks(tick) == [(SET_MODE, TEMPORARILY_REJECTED)]
    assert [m.text for m in tick.named("STATUSTEXT") if m.text.startswith("Refused: ")]
    assert sea.state == "HOLD"


@pytest.mark.parametrize("base_mode", [1.0, 129.0, 217.0])
def test_a_mode_is_set_whatever_else_the_base_mode_says(sea: Sea, base_mode: float) -> None:
    sea.settle()
    sea.arm()
    assert acks(sea.order(SET_MODE, base_mode, 6.0)) == [(SET_MODE, ACCEPTED)]
    assert sea.state == "FORMATION"


def test_formation_is_refused_to_a_disarmed_boat(sea: Sea) -> None:
    sea.settle()
    assert acks(sea.mode(FORMATION)) == [(SET_MODE, TEMPORARILY_REJECTED)]
    assert sea.state == "DISARMED"
    sea.arm()
    assert sea.state == "HOLD"


def test_formation_is_refused_without_a_leader_and_says_so(sea: Sea) -> None:
    sea.leader.on = False
    sea.settle()
    sea.arm()
    tick = sea.mode(FORMATION)
    assert acks(tick) == [(SET_MODE, TEMPORARILY_REJECTED)]
    assert any("leader" in m.text for m in tick.named("STATUSTEXT"))
    assert sea.state == "HOLD"
