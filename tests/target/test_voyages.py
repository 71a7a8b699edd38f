# SPDX-License-Identifier: MIT
"""AUTO: a plan's voyages that measure the hull are sailed whenever the plan leads to them."""

from __future__ import annotations

import math

from tests.target.operator_words import param_set
from tests.target.plans import ITEM_ACCEPTED, JUMP, LOITER_UNLIMITED, Item, Planner, at, bare
from tests.target.sea import Sea, acks, texts
from tests.target.stations import ACCEPTED, AUTO, HOLD
from tests.target.test_auto import COMPLETE, SET_CURRENT, at_sea, place, progress, reached, sailing

VOYAGE = at(0, 0)._replace(command=31010, params=(1.0, 60.0, 0.0, math.nan))
FIRST_STEP, OVER = "Voyage: step 1 of 42, drift", "Voyage: over, 42 of 42 steps complete"


def until(sea: Sea, text: str, most_s: float = 1600.0) -> list[str]:
    """Sails until the boat sends this text; all texts on the way."""
    told: list[str] = []
    while most_s > 0.0 and text not in told:
        told += texts(sea.run(1.0))
        most_s -= 1.0
    assert text in told
    return told


def test_a_voyage_keeps_to_a_speed_limit_that_is_lowered_under_way() -> None:
    sea = sailing([VOYAGE, at(50, 0)])
    while not any("step 2 of" in text for text in texts(sea.run(1.0))):
        pass
    sea.say(param_set("LAW_U_MAX", 0.5))
    sea.run(1.0)
    fastest = 0.0
    for _ in range(60):
        sea.run(1.0)
        fastest = max(fastest, abs(sea.hull.seen.u))
    assert fastest < 0.7


def test_after_a_plans_last_place_no_voyage_begins() -> None:
    sea = at_sea([VOYAGE, Item(LOITER_UNLIMITED, x=0, y=0)])
    assert acks(sea.order(SET_CURRENT, 1.0)) == [(SET_CURRENT, ACCEPTED)]
    sea.mode(AUTO)
    ticks = sea.run(90.0)
    assert sea.state == "AUTO" and progress(sea)[0] == 1
    assert not [text for text in texts(ticks) if "Voyage" in text]
    assert math.hypot(*place(sea)) < 0.5


def test_a_voyage_is_sailed_in_each_round_of_a_jump_and_the_plan_goes_on() -> None:
    """The place that follows the voyage is the voyage's own."""
    sea = sailing([VOYAGE, at(0, 0), at(0, 15), bare(JUMP, 0.0, 1.0), at(0, 30)])
    until(sea, FIRST_STEP)
    until(sea, OVER)
    until(sea, FIRST_STEP)
    until(sea, OVER)
    ticks = sea.run(300.0)
    assert FIRST_STEP not in texts(ticks)
    assert reached(ticks)[-1] == 4
    assert progress(sea)[2] == COMPLETE


def test_a_plan_of_a_voyage_alone_is_sailed_once_and_again_when_it_is_begun_anew() -> None:
    sea = sailing([VOYAGE])
    until(sea, OVER)
    assert FIRST_STEP not in texts(sea.run(120.0))
    assert progress(sea)[2] == COMPLETE
    sea.mode(HOLD)
    sea.run(1.0)
    sea.mode(AUTO)
    until(sea, FIRST_STEP, 300.0)


def test_an_interrupted_voyage_goes_on_and_one_of_a_plan_sent_again_begins_anew() -> None:
    sea = sailing([VOYAGE, at(50, 0)])
    until(sea, "Voyage: step 2 of 42, ahead")
    sea.mode(HOLD)
    sea.run(1.0)
    sea.mode(AUTO)
    assert FIRST_STEP not in until(sea, "Voyage: step 2 of 42, ahead")
    sea.mode(HOLD)
    sea.run(1.0)
    assert Planner(sea).send([VOYAGE, at(50, 0)]) == ITEM_ACCEPTED
    sea.run(2.0)
    sea.mode(AUTO)
    until(sea, FIRST_STEP, 300.0)
