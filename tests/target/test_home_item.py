# SPDX-License-Identifier: MIT
"""A boat with ArduPilot's identity keeps the home that its clients send, and never goes there."""

from __future__ import annotations

import pytest
from pymavlink.dialects.v20 import common as mavlink

from tests.target.plans import (
    CIRCLE_OUT,
    FENCE,
    INVALID,
    ITEM_ACCEPTED,
    JUMP,
    Item,
    Planner,
    as_sent,
    at,
    bare,
    circle,
    plan_of,
)
from tests.target.stations import AUTO, BOAT
from tests.target.test_auto import at_sea, place, progress, reached

PARAM1 = 6
ARDUPILOT = {"MAV_AUTOPILOT": 1.0}
OVER_SEA_LEVEL = 0  # MAV_FRAME_GLOBAL
HOME = at(-30, -30)._replace(frame=OVER_SEA_LEVEL, z=490.0)
WAY = [at(6, 0), at(6, 6)]


def test_the_home_is_given_back_and_never_sailed_to() -> None:
    sea = at_sea([HOME, *WAY], ARDUPILOT)
    assert plan_of(sea) == as_sent([HOME, *WAY])
    assert progress(sea)[:2] == (1, 3)
    sea.mode(AUTO)
    ticks = []
    for _ in range(60):
        ticks += sea.run(1.0)
        assert min(place(sea)) > -2.0
    assert reached(ticks) == [1, 2]
    assert place(sea) == pytest.approx((6, 6), abs=0.05)


def test_set_current_to_item_0_begins_at_the_first_waypoint() -> None:
    sea = at_sea([HOME, *WAY], ARDUPILOT)
    for item in (2, 0):
        sea.say(mavlink.MAVLink_mission_set_current_message(BOAT, 1, item))
        sea.step()
        assert progress(sea)[0] == max(item, 1)


def test_a_jump_counts_the_home_among_the_items() -> None:
    """To item 1, which is the first waypoint, once; item 0, the home, is no place to jump to."""
    back = bare(JUMP, 1.0, 1.0)
    sea = at_sea([HOME, *WAY, back], ARDUPILOT)
    assert plan_of(sea) == as_sent([HOME, *WAY, back])
    sea.mode(AUTO)
    assert reached(sea.run(150.0)) == [1, 2, 1, 2]
    assert place(sea) == pytest.approx((6, 6), abs=0.05)
    home = bare(JUMP, 0.0, 1.0)
    other = at_sea([], ARDUPILOT)
    assert Planner(other).send([HOME, *WAY, home]) == PARAM1


@pytest.mark.parametrize(
    ("parameters", "plan"),
    [({}, [HOME, *WAY]), (ARDUPILOT, WAY), (ARDUPILOT, [HOME._replace(frame=3), *WAY])],
    ids=["generic", "without a home", "other frame"],
)
def test_all_other_plans_are_sailed_from_their_first_item(
    parameters: dict[str, float], plan: list[Item]
) -> None:
    assert progress(at_sea(plan, parameters))[0] == 0


def test_a_home_may_be_anywhere_and_alone_it_is_no_plan() -> None:
    sea = at_sea([], ARDUPILOT)
    sea.disarm()
    fence = [circle(-30, -30, 5, CIRCLE_OUT)]
    assert Planner(sea, kind=FENCE).send(fence) == ITEM_ACCEPTED
    nowhere = HOME._replace(x=0, y=0)
    for home in (HOME, nowhere):
        assert Planner(sea).send([home, *WAY]) == ITEM_ACCEPTED
        assert plan_of(sea) == as_sent([home, *WAY])
    assert Planner(sea).send([*WAY, HOME]) == INVALID  # as the last item it is a waypoint
    assert plan_of(sea) == as_sent([nowhere, *WAY])
    assert Planner(sea).send([HOME]) == ITEM_ACCEPTED and plan_of(sea) == []
