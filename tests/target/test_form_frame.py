# SPDX-License-Identifier: MIT
"""A slot with a fixed bearing from the leader, or turning with it."""

from __future__ import annotations

import math

import pytest

from tests.target.course import Course, wrap
from tests.target.hull import D22, M11, Afloat, Hull
from tests.target.operator_words import param_set
from tests.target.sea import PAPER, named

ABEAM = {"FORM_OFS_N": -2.0, "FORM_OFS_E": 3.0, "SR_SLOW": 10.0}
CIRCLE = Course(4.0, -3.0, 0.4, 1.0, 0.0, 0.1)
POSITION_TARGET = 85


def slot_of(leader: Course, turns: bool) -> Course:
    """The slot's position, and the heading of the paper's hull there."""
    ahead, starboard = ABEAM["FORM_OFS_N"], ABEAM["FORM_OFS_E"]
    if not turns:
        return Course(leader.north + ahead, leader.east + starboard, leader.psi)
    c, s = math.cos(leader.psi), math.sin(leader.psi)
    north, east = c * ahead - s * starboard, s * ahead + c * starboard
    course = math.atan2(leader.v + leader.r * ahead, leader.u - leader.r * starboard)
    sway = math.atan(-M11 / D22 * leader.r)  # v/u where m11 u r + d22 v = 0
    return Course(leader.north + north, leader.east + east, wrap(leader.psi + course - sway))


@pytest.mark.parametrize("turns", [False, True])
@pytest.mark.parametrize("sailing", [False, True])
@pytest.mark.parametrize("r", [0.1, -0.1])
def test_the_reported_slot_turns_with_the_leader_only_with_form_frame_1(
    turns: bool, sailing: bool, r: float
) -> None:
    leader = Course(4.0, -3.0, 0.4, 1.0, 0.0, r)
    sea = Afloat(PAPER | ABEAM | {"FORM_FRAME": float(turns)}, Hull(), leader)
    sea.leader.period_us = 10_000
    if sailing:
        sea.enter_formation()
    sea.run(5.0)
    told = named(sea.run(20.0), "POSITION_TARGET_LOCAL_NED")
    assert len(told) == 200
    for m in told:
        truth = sea.leader.truth(m.time_boot_ms * 1000)
        slot = slot_of(truth, turns)
        assert math.hypot(m.x - slot.north, m.y - slot.east) < 0.01
        # Before it sails, a boat has no sway of its own.
        assert abs(wrap(m.yaw - slot.psi)) < (0.003 if sailing or not turns else 0.01)


@pytest.mark.parametrize("state", ["HOLD", "FORMATION"])
def test_another_frame_under_way_moves_the_slot_at_once(state: str) -> None:
    sea = Afloat(PAPER | ABEAM, Hull([1.0, 1.0, 0.3, 0.0, 0.0, 0.0]), CIRCLE)
    sea.leader.period_us = 10_000
    sea.enter_hold() if state == "HOLD" else sea.enter_formation()
    sea.run(10.0)
    for turns in (True, False, True):
        sea.say(param_set("FORM_FRAME", float(turns)))
        now_us = sea.step().now_us
        slot = slot_of(sea.leader.truth(now_us), turns)
        (told,) = sea.ask(POSITION_TARGET)
        assert math.hypot(told.x - slot.north, told.y - slot.east) < 0.02
        assert sea.state == state
        sea.run(1.0)


def test_a_boat_sails_beside_a_leader_that_goes_round_and_round() -> None:
    sea = Afloat(ABEAM | {"FORM_FRAME": 1.0}, Hull([0.0, 3.0, 0.4, 0.0, 0.0, 0.0]), CIRCLE)
    sea.enter_formation()
    sea.run(60.0)
    for _ in range(2000):
        sea.step()
        slot = slot_of(sea.leader.truth(sea.now_us), True)
        off = sea.hull.seen.minus(slot)
        assert math.hypot(*off[:2]) < 0.03 and abs(off[2]) < 0.02
