# SPDX-License-Identifier: MIT
"""A law whose result is not a number gives no thrust."""

from __future__ import annotations

import math

import pytest

from tests.target.operator_words import command_int, param_set
from tests.target.plans import at
from tests.target.sea import texts
from tests.target.stations import (
    GUIDED,
    LOITER,
    REPOSITION,
)
from tests.target.test_auto import at_sea as alone

FULL_THRUST = 8191
FAST_MPS = 3.0  # twice LAW_U_MAX


@pytest.mark.parametrize("how", ["LOITER after arming", "GUIDED, changed under way"])
def test_a_tiny_look_ahead_does_not_give_full_thrust(how: str) -> None:
    tiny = 1e-30  # within the range of LAW_XT_DIST, -1 to 100
    if how == "LOITER after arming":
        sea = alone([], {"LAW_XT_DIST": tiny})
        sea.mode(LOITER)
    else:
        sea = alone([])
        sea.mode(GUIDED)
        to = at(30, 10)
        sea.say(command_int(REPOSITION, -1.0, 1.0, 0.0, math.nan, x=to.x, y=to.y, frame=6))
        sea.run(3.0)
        sea.say(param_set("LAW_XT_DIST", tiny))
    fastest = 0.0
    for _ in range(250):
        sea.step()
        fastest = max(fastest, abs(sea.hull.q[3]))
    assert fastest < FAST_MPS, (fastest, sea.state, sea.commands, texts(sea.ticks)[-2:])
