# SPDX-License-Identifier: MIT
"""Items of plans beyond waypoints and waits: circles, home, jumps; legs without progress."""

from __future__ import annotations

import math

import numpy as np
import pytest
from pymavlink.dialects.v20 import common as mavlink

from tests.target.hull import Afloat, Helmsman, Hull
from tests.target.plans import (
    DELAY,
    FENCE,
    ITEM_ACCEPTED,
    JUMP,
    LOITER_TIME,
    LOITER_UNLIMITED,
    RETURN,
    Item,
    Planner,
    as_sent,
    at,
    bare,
    box,
    plan_of,
    send,
    speed,
    turns,
)
from tests.target.sea import Tick, acks, named
from tests.target.stations import ACCEPTED, AUTO, DENIED, HOLD
from tests.target.test_auto import ACTIVE, SET_CURRENT, at_sea, place, progress, reached, sailing
from tests.target.test_fence_kept import fenced
from tests.target.test_long_texts import words

CONDITION_DELAY, SET_HOME = 112, 179
PARAM1, PARAM2, PARAM3, COMPLETE = 6, 7, 8, 5
BEATEN = "no headway: "


class Weak(Hull):
    """A hull with a tenth of the thrust."""

    def advance(self, X: float, N: float, h: float) -> None:
        super().advance(0.1 * X, 0.1 * N, h)


#: A plan, the number of its item that is refused, and MAV_MISSION_RESULT.
BAD = {
    "no turn": ([at(5, 0), turns(10, 0, 0.0, 4.0)], 1, PARAM1),
    "turns without end": ([at(5, 0), turns(10, 0, math.inf, 4.0)], 1, PARAM1),
    "a circle too wide": ([turns(10, 0, 1.0, 101.0)], 0, PARAM3),
    "a jump ahead": ([at(5, 0), bare(JUMP, 2.0, 1.0), at(9, 0)], 1, PARAM1),
    "a jump to itself": ([at(5, 0), bare(JUMP, 1.0, -1.0)], 1, PARAM1),
    "half an item": ([at(5, 0), at(9, 0), bare(JUMP, 0.5, 1.0)], 2, PARAM1),
    "a loop without a place": (
        [at(5, 0), bare(CONDITION_DELAY, 1.0), bare(JUMP, 1.0, -1.0)],
        2,
        PARAM1,
    ),
    "a loop at one place": ([at(9, 0), at(5, 0), at(5, 0), bare(JUMP, 1.0, -1.0)], 3, PARAM1),
    "a jump less than never": ([at(5, 0), bare(JUMP, 0.0, -2.0)], 1, PARAM2),
    "five jumps": ([at(5, 0), at(9, 0), *[bare(JUMP, 0.0, 1.0)] * 5], 6, 4),
    "a delay without end": ([at(5, 0), bare(CONDITION_DELAY, 1e9)], 1, PARAM1),
    "home nowhere": ([at(5, 0), bare(SET_HOME)._replace(x=10**9, frame=6)], 1, 10),
    "home too far": ([at(5, 0), at(2100, 0)._replace(command=SET_HOME)], 1, 10),
    "home before a waypoint": ([bare(SET_HOME, 1.0), at(5, 0)], 0, 5),
    "the way home alone": ([bare(RETURN)], 0, 5),
}


@pytest.mark.parametrize("name", BAD)
def test_a_plan_with_an_item_that_cannot_be_sailed_is_refused_by_its_number(name: str) -> None:
    plan, item, result = BAD[name]
    sea = at_sea([])
    assert Planner(sea).send(plan) == result
    sea.run(0.5)
    said = words(sea.ticks)
    assert any(f"Plan refused at item {item}:" in text for text in said), said
    assert plan_of(sea) == []


def test_a_boat_sails_whole_turns_round_a_place() -> None:
    for sign in (1.0, -1.0):
        plan = [at(4, 0), turns(20, 0, 2.0, sign * 6.0), at(4, 0)]
        sea = sailing(plan)
        assert plan_of(sea) == as_sent(plan)
        track = []
        for _ in range(1200):
            sea.run(0.2)
            track.append(place(sea))
        assert progress(sea)[2] == COMPLETE
        off = np.asarray(track) - (20, 0)
        angle = np.unwrap(np.arctan2(off[:, 1], off[:, 0]))
        near = np.hypot(*off.T) < 7.5
        assert sign * np.diff(angle)[near[1:]].sum() == pytest.approx(4 * math.pi, abs=1.0)
        assert np.hypot(*off.T).min() > 5.0


def test_a_plan_that_ends_with_return_ends_at_home() -> None:
    sea = sailing([at(8, 0), bare(RETURN)])
    ticks = sea.run(60.0)
    assert reached(ticks) == [0, 1] and progress(sea)[2] == COMPLETE
    assert place(sea) == pytest.approx((0, 0), abs=0.1)


@pytest.mark.parametrize(("given", "home"), [((1.0,), (8, 0)), ((0.0,), (8, 6))])
def test_a_plan_may_move_home(given: tuple[float, ...], home: tuple[float, float]) -> None:
    there = at(*home)
    moved = bare(SET_HOME, *given)._replace(x=there.x, y=there.y, frame=6)
    sea = sailing([at(8, 0, hold_s=1.0), moved, at(16, 0), bare(RETURN)])
    ticks = sea.run(90.0)
    assert progress(sea)[2] == COMPLETE and place(sea) == pytest.approx(home, abs=0.1)
    told = named(ticks, "HOME_POSITION")[-1]
    assert (told.latitude, told.longitude) == pytest.approx((there.x, there.y), abs=10)


def test_a_jump_is_taken_as_often_as_it_says() -> None:
    sea = sailing([at(4, 0), at(0, 0), bare(JUMP, 0.0, 2.0), at(0, 3)])
    ticks = sea.run(150.0)
    assert reached(ticks) == [0, 1, 0, 1, 0, 1, 3] and progress(sea)[2] == COMPLETE


@pytest.mark.parametrize("under_way", [False, True])
@pytest.mark.parametrize("command", [DELAY, CONDITION_DELAY, LOITER_TIME])
def test_a_boat_that_is_sent_to_a_delay_waits_where_it_is(command: int, under_way: bool) -> None:
    sea = at_sea([at(30, 0), bare(command, 20.0)._replace(frame=6), at(0, 10)])
    if under_way:
        sea.mode(AUTO)
        sea.run(10.0)
    here = place(sea)
    assert acks(sea.order(SET_CURRENT, 1.0)) == [(SET_CURRENT, ACCEPTED)]
    sea.mode(AUTO)
    for _ in range(18):
        sea.run(0.97)
        assert progress(sea) == (1, 3, ACTIVE) and math.dist(place(sea), here) < 1.0
    sea.run(60.0)
    assert progress(sea)[2] == COMPLETE and place(sea) == pytest.approx((0, 10), abs=0.1)


def home_after(sea: Afloat, seconds: float) -> tuple[int, int]:
    sea.run(seconds)
    told = sea.ask(mavlink.MAVLINK_MSG_ID_HOME_POSITION)[0]
    return told.latitude, told.longitude


NEW = at(3, -3)
NEW_HOME = bare(SET_HOME)._replace(x=NEW.x, y=NEW.y, frame=6)
#: A plan with a new home, and whether the boat sets it.
HOMES = {
    "between two equal places": ([at(4, 0), NEW_HOME, at(4, 0), at(0, 0)], True),
    "between two equal places at the end": ([at(0, 0), at(4, 0), NEW_HOME, at(4, 0)], True),
    "at the end": ([at(4, 0), NEW_HOME], True),
    "behind the way home": ([at(4, 0), bare(RETURN), NEW_HOME], False),
    "behind a loiter": ([at(4, 0), at(0, 0)._replace(command=LOITER_UNLIMITED), NEW_HOME], False),
}


@pytest.mark.parametrize("name", HOMES)
def test_home_moves_where_the_plan_comes_by(name: str) -> None:
    plan, moves = HOMES[name]
    sea = sailing(plan)
    home = home_after(sea, 60.0)
    assert progress(sea)[2] == COMPLETE
    first = at(0, 0)
    want = NEW if moves else first
    assert home == pytest.approx((want.x, want.y), abs=10)


def test_a_home_at_the_head_of_a_loop_is_set_in_each_round() -> None:
    """In the first round at item 0, in the second at item 2, each time at the boat's place."""
    sea = sailing(
        [at(4, 0), bare(SET_HOME, 1.0), at(8, 0), at(8, 8), bare(JUMP, 1.0, 1.0), at(0, 8)]
    )
    homes: list[tuple[int, int]] = []
    for _ in range(120):
        home = home_after(sea, 1.0)
        if not homes or math.dist(home, homes[-1]) > 100:
            homes.append(home)
    assert progress(sea)[2] == COMPLETE
    sailed_to = [at(0, 0), at(4, 0), at(8, 8)]
    assert len(homes) == 3
    for home, item in zip(homes, sailed_to, strict=True):
        assert home == pytest.approx((item.x, item.y), abs=150)


def test_a_home_behind_a_jump_is_set_after_the_last_round_only() -> None:
    sea = sailing([at(8, 0), at(0, 0), bare(JUMP, 0.0, 1.0), NEW_HOME, at(0, 8), bare(RETURN)])
    told: list[int] = []
    while told != [0, 1, 0]:
        told += reached(sea.run(0.5))
        assert len(told) < 4
    home = home_after(sea, 2.0)
    assert home == pytest.approx((at(0, 0).x, at(0, 0).y), abs=10)
    assert home_after(sea, 120.0) == pytest.approx((NEW.x, NEW.y), abs=10)
    assert progress(sea)[2] == COMPLETE and place(sea) == pytest.approx((3, -3), abs=0.1)


def test_a_plan_that_goes_on_returns_to_the_home_that_the_boat_has() -> None:
    """The boat is sent past the item that would move its home."""
    sea = at_sea([at(8, 0), NEW_HOME, at(8, 8), bare(RETURN)])
    assert acks(sea.order(SET_CURRENT, 2.0)) == [(SET_CURRENT, ACCEPTED)]
    sea.mode(AUTO)
    sea.run(90.0)
    assert progress(sea)[2] == COMPLETE and place(sea) == pytest.approx((0, 0), abs=0.1)


ROUNDS = [at(4, 0), at(0, 0), speed(0.3), bare(JUMP, 0.0, 2.0), at(0, 3)]


def in_second_round() -> Afloat:
    """A boat in HOLD, which has sailed ROUNDS to item 1 and once again to item 0."""
    sea = sailing(ROUNDS)
    told: list[int] = []
    while told != [0, 1, 0]:
        told += reached(sea.run(0.5))
        assert len(told) < 4
    sea.mode(HOLD)
    sea.run(2.0)
    return sea


def test_a_plan_that_goes_on_has_taken_its_jumps_and_keeps_its_speed() -> None:
    sea = in_second_round()
    sea.mode(AUTO)
    ticks: list[Tick] = []
    for _ in range(120):
        ticks += sea.run(1.0)
        assert sea.hull.seen.u < 0.35
    assert reached(ticks) == [1, 0, 1, 4] and progress(sea)[2] == COMPLETE
    sea.mode(HOLD)
    sea.mode(AUTO)
    assert reached(sea.run(180.0)) == [0, 1, 0, 1, 0, 1, 4]


@pytest.mark.parametrize(
    ("params", "rest"),
    [
        ((1.0, 0.0), [1, 0, 1, 4]),
        ((1.0, math.nan), [1, 0, 1, 4]),
        ((1.0, 1.0), [1, 0, 1, 0, 1, 4]),
        ((0.0, 0.0), [0, 1, 0, 1, 0, 1, 4]),
    ],
    ids=["an item", "NaN", "reset", "the first item"],
)
def test_jumps_count_anew_with_a_reset_or_at_the_first_item(
    params: tuple[float, float], rest: list[int]
) -> None:
    sea = in_second_round()
    assert acks(sea.order(SET_CURRENT, *params)) == [(SET_CURRENT, ACCEPTED)]
    assert reached([sea.mode(AUTO), *sea.run(180.0)]) == rest


def test_a_reset_that_is_neither_0_nor_1_is_denied() -> None:
    sea = at_sea(ROUNDS)
    assert acks(sea.order(SET_CURRENT, 1.0, 2.0)) == [(SET_CURRENT, DENIED)]


def test_a_jump_for_ever_goes_on_for_ever() -> None:
    sea = sailing([at(4, 0), at(0, 0), bare(JUMP, 0.0, -1.0), at(0, 3)])
    ticks = sea.run(300.0)
    told = reached(ticks)
    assert len(told) > 10 and set(told) == {0, 1} and progress(sea)[2] != COMPLETE


@pytest.mark.parametrize("near_m", [0.03, 0.06])
def test_a_jump_between_places_too_near_to_tell_apart_ends_the_plan(near_m: float) -> None:
    sea = sailing([at(4, 0), at(8, 0), at(8 + near_m, 0), bare(JUMP, 1.0, -1.0)])
    sea.run(40.0)
    assert place(sea) == pytest.approx((8, 0), abs=0.3)


def test_condition_delay_waits() -> None:
    sea = sailing([at(4, 0), bare(CONDITION_DELAY, 20.0), at(8, 0)])
    sea.run(30.0)
    assert place(sea) == pytest.approx((4, 0), abs=0.1)
    sea.run(25.0)
    assert place(sea) == pytest.approx((8, 0), abs=0.1)


ROUND = [at(8, 0), at(8, 8), at(0, 8), bare(JUMP, 1.0, 1.0), at(-9, 8)]


@pytest.mark.parametrize(
    ("plan", "waits_at"),
    [
        ([turns(9, 0, 1.0, 5.0), bare(CONDITION_DELAY, 25.0), at(-9, 0)], None),
        ([at(4, 0), bare(CONDITION_DELAY, 25.0), *ROUND], (0, 8)),
    ],
    ids=["behind a circle", "where a jump leads"],
)
def test_a_boat_waits_where_a_delay_follows_a_circle_or_a_jump(
    plan: list[Item], waits_at: tuple[float, float] | None
) -> None:
    sea = sailing(plan)
    rests: list[tuple[float, float]] = []
    for _ in range(1000):
        sea.run(0.2)
        if math.hypot(*sea.hull.q[3:5]) < 0.05:
            rests.append(place(sea))
    assert progress(sea)[2] == COMPLETE
    if waits_at is None:
        near = [p for p in rests if 4.0 < math.dist(p, (9, 0)) < 6.0]
    else:
        near = [p for p in rests if math.dist(p, waits_at) < 0.3]
    assert len(near) > 100


def test_the_leg_back_of_a_jump_and_a_whole_circle_keep_the_fence() -> None:
    sea = fenced([at(4, 0)], box(0, 0, 20))
    assert Planner(sea).send([at(4, 0), turns(4, 0, 1.0, 12.0)]) == ITEM_ACCEPTED
    assert Planner(sea).send([at(4, 0), turns(4, 0, 1.0, 14.5)]) == 5
    assert send(sea, FENCE, [*box(0, 0, 20), *box(10, 10, 2, 5002)]) == ITEM_ACCEPTED
    route = [at(16, 10), at(16, -5), at(4, -5), at(4, 10)]
    assert Planner(sea).send([*route, bare(JUMP, 1.0, 1.0)]) == ITEM_ACCEPTED
    assert Planner(sea).send([*route, bare(JUMP, 0.0, 1.0)]) == 5


@pytest.mark.parametrize(("current_mps", "beaten"), [(1.5, True), (1.0, True), (0.4, False)])
def test_a_current_too_strong_for_the_propellers_is_reported_within_30_s(
    current_mps: float, beaten: bool
) -> None:
    """1.16 m/s through the water at full thrust, 0.5 over ground in the plan."""
    slow = {"THR_FWD_MAX": 2.0, "THR_REV_MAX": 2.0, "WP_SPEED": 0.5}
    sea = at_sea([], slow)
    sea.hull = Weak()
    assert isinstance(sea.own, Helmsman)
    sea.own.hull = sea.hull
    assert Planner(sea).send([at(40, 0)]) == ITEM_ACCEPTED
    sea.hull.current = (-current_mps, 0.0)
    sea.mode(AUTO)
    sea.run(30.0)
    assert any(text.startswith(BEATEN) for text in words(sea.ticks)) == beaten, words(sea.ticks)
    if not beaten:
        assert sea.state == "AUTO" and place(sea)[0] > 2
