# SPDX-License-Identifier: MIT
"""AUTO: a boat sails its plan, tells how far it is, and stops where it must not go on."""

from __future__ import annotations

import math
from collections.abc import Sequence

import pytest
from pymavlink.dialects.v20 import common as mavlink

from tests.target.hull import Afloat, Hull
from tests.target.operator_words import param_set
from tests.target.plans import (
    DELAY,
    INVALID_X,
    ITEM_ACCEPTED,
    JUMP,
    LOITER_UNLIMITED,
    REFUSED,
    Item,
    Planner,
    as_sent,
    at,
    bare,
    plan_of,
    speed,
)
from tests.target.sea import Sea, Tick, acks, assert_finite, named, texts
from tests.target.stations import (
    ACCEPTED,
    AUTO,
    BOAT,
    DENIED,
    FORMATION,
    HOLD,
    PAUSE,
    SET_MODE,
    STANDARD_MODE,
    TEMPORARILY_REJECTED,
)

MISSION_START, SET_CURRENT = 300, 224
NOT_STARTED, ACTIVE, PAUSED, COMPLETE = 2, 3, 4, 5
CORNER = [at(10, 0), at(10, 10)]


def at_sea(
    plan: Sequence[Item],
    parameters: dict[str, float] | None = None,
    *,
    kind: type[Afloat] = Afloat,
    scalar: str = "float",
) -> Afloat:
    """An armed boat with a plan, without a leader."""
    sea = kind(parameters, hull=Hull(), scalar=scalar)
    sea.leader.on = False
    sea.run(2.0)
    if plan:
        assert Planner(sea).send(plan) == ITEM_ACCEPTED
    sea.arm()
    sea.step()
    assert sea.state == "HOLD"
    return sea


def sailing(
    plan: Sequence[Item],
    parameters: dict[str, float] | None = None,
    *,
    kind: type[Afloat] = Afloat,
    scalar: str = "float",
) -> Afloat:
    sea = at_sea(plan, parameters, kind=kind, scalar=scalar)
    assert acks(sea.mode(AUTO)) == [(SET_MODE, ACCEPTED)]
    sea.step()
    assert sea.state == "AUTO"
    return sea


def place(sea: Afloat) -> tuple[float, float]:
    seen = sea.hull.seen
    return seen.north, seen.east


def reached(ticks: Sequence[Tick]) -> list[int]:
    return [m.seq for m in named(ticks, "MISSION_ITEM_REACHED")]


def progress(sea: Sea) -> tuple[int, int, int]:
    (told,) = sea.ask(mavlink.MAVLINK_MSG_ID_MISSION_CURRENT)
    return told.seq, told.total, told.mission_state


def test_a_boat_sails_its_plan_to_the_end_and_reports_it() -> None:
    sea = at_sea(CORNER)
    assert progress(sea) == (0, 2, NOT_STARTED)
    assert not [text for text in texts(sea.ticks) if "MANUAL only" in text]
    sea.mode(AUTO)
    ticks = sea.run(20.0)
    assert progress(sea) == (0, 2, ACTIVE) and sea.snapshot()["error"]["x_m"] < 0.01
    ticks += sea.run(40.0)
    assert reached(ticks) == [0, 1] and progress(sea) == (1, 2, COMPLETE)
    assert place(sea) == pytest.approx((10, 10), abs=0.05)
    assert sea.state == "AUTO" and math.hypot(*sea.hull.q[3:5]) < 0.01


def test_the_corner_is_rounded_within_its_radius() -> None:
    sea = sailing([at(10, 0, radius_m=0.5), at(10, 10)])
    nearest = math.inf
    for _ in range(40):
        sea.run(1.0)
        nearest = min(nearest, math.dist(place(sea), (10, 0)))
    assert 0.2 < nearest < 0.55


@pytest.mark.parametrize("mode", [AUTO, 5, 11, 15])
def test_a_tick_in_which_the_clock_stands_still_leaves_every_number_finite(mode: int) -> None:
    sea = at_sea(CORNER)
    sea.mode(mode)
    sea.run(3.0)
    for _ in range(3):
        sea.boat.tick(sea.now_us)
        assert_finite(sea.snapshot())
    assert sea.state not in ("HOLD", "FAULT")


FORMS: dict[str, tuple[float, ...]] = {
    "mode": (SET_MODE, 1.0, 10.0),
    "command": (MISSION_START,),
    "standard mode": (STANDARD_MODE, 6.0),
    "PX4's": (SET_MODE, 129.0, 4.0, 4.0, *[math.nan] * 4),  # MAVSDK's start_mission()
}


@pytest.mark.parametrize("form", FORMS)
def test_each_form_of_request_starts_auto(form: str) -> None:
    sea = at_sea(CORNER)
    command, *params = FORMS[form]
    assert acks(sea.order(int(command), *params)) == [(command, ACCEPTED)]
    sea.step()
    assert sea.state == "AUTO"


@pytest.mark.parametrize("form", FORMS)
def test_a_request_for_auto_at_the_end_of_a_plan_begins_it_again(form: str) -> None:
    sea = sailing([at(5, 0), at(0, 0)])
    sea.run(60.0)
    assert progress(sea)[2] == COMPLETE
    command, *params = FORMS[form]
    assert acks(sea.order(int(command), *params)) == [(command, ACCEPTED)]
    sea.step()
    assert progress(sea) == (0, 2, ACTIVE)
    assert reached(sea.run(60.0)) == [0, 1] and progress(sea)[2] == COMPLETE


def test_a_repeated_mission_start_that_comes_after_the_end_begins_nothing() -> None:
    sea = sailing([at(5, 0), at(0, 0)])
    sea.run(60.0)
    again = mavlink.MAVLink_command_long_message(BOAT, 1, MISSION_START, 1, *[0.0] * 7)
    sea.say(again)
    assert acks(sea.step()) == [(MISSION_START, ACCEPTED)]
    sea.run(5.0)
    assert progress(sea) == (1, 2, COMPLETE)


def test_mission_start_with_a_part_of_a_plan_is_denied() -> None:
    sea = at_sea(CORNER)
    assert acks(sea.order(MISSION_START, 1.0, 1.0)) == [(MISSION_START, DENIED)]
    assert sea.state == "HOLD"


def test_without_a_plan_auto_is_refused_with_the_reason() -> None:
    sea = at_sea([])
    tick = sea.mode(AUTO)
    assert acks(tick) == [(SET_MODE, TEMPORARILY_REJECTED)]
    assert any("no plan" in text for text in texts([tick, sea.step()]))
    assert sea.state == "HOLD"


def test_a_plan_that_begins_over_a_kilometre_away_is_refused() -> None:
    sea = at_sea([at(1001, 0)])
    tick = sea.mode(AUTO)
    assert acks(tick) == [(SET_MODE, TEMPORARILY_REJECTED)]
    ticks = [tick, *sea.run(0.2)]
    assert sea.state == "HOLD" and not any(any(tick.commands) for tick in ticks)
    assert "Plan: too far away" in texts(ticks)
    assert Planner(sea).send([at(999, 0)]) == ITEM_ACCEPTED
    sea.run(1.1)
    assert acks(sea.mode(AUTO)) == [(SET_MODE, ACCEPTED)]


def test_a_jump_to_an_item_out_of_reach_is_refused_and_the_plan_goes_on() -> None:
    sea = sailing([at(950, 0), at(2930, 0)])
    assert acks(sea.order(SET_CURRENT, 1.0)) == [(SET_CURRENT, DENIED)]
    sea.run(1.0)
    assert sea.state == "AUTO" and progress(sea) == (0, 2, ACTIVE)


@pytest.mark.parametrize("under_way", [False, True])
def test_a_plan_whose_speed_is_above_a_lowered_limit_is_sailed_at_the_limit(
    under_way: bool,
) -> None:
    sea = at_sea([speed(1.2), at(100, 0)])
    if under_way:
        sea.mode(AUTO)
        sea.run(10.0)
    sea.say(param_set("LAW_U_MAX", 0.5))
    sea.step()
    sea.mode(AUTO)
    sea.run(50.0)
    assert sea.state == "AUTO" and sea.hull.seen.u == pytest.approx(0.5, abs=0.02)


def test_a_plan_goes_on_at_an_item_over_a_kilometre_away() -> None:
    sea = at_sea([at(0, 0), at(1500, 0)])
    assert acks(sea.order(SET_CURRENT, 1.0)) == [(SET_CURRENT, ACCEPTED)]
    assert acks(sea.mode(AUTO)) == [(SET_MODE, ACCEPTED)]
    sea.run(5.0)
    assert sea.state == "AUTO" and progress(sea) == (1, 2, ACTIVE)


def test_the_plan_under_way_is_not_changed_and_afterwards_it_is() -> None:
    sea = sailing(CORNER)
    assert Planner(sea).send([at(0, 5)]) == REFUSED
    sea.say(mavlink.MAVLink_mission_clear_all_message(BOAT, 1, 0))
    (ack,) = sea.step().named("MISSION_ACK")
    assert ack.type == REFUSED
    assert plan_of(sea) == as_sent(CORNER) and sea.state == "AUTO"
    sea.mode(HOLD)
    assert Planner(sea).send([at(0, 5)]) == ITEM_ACCEPTED


def test_an_upload_that_began_before_auto_does_not_end_in_it() -> None:
    sea = at_sea(CORNER)
    sea.say(mavlink.MAVLink_mission_count_message(BOAT, 1, 1, 0))
    sea.step()
    sea.mode(AUTO)
    sea.step()
    sea.say(at(0, 5).message(0))
    (ack,) = sea.step().named("MISSION_ACK")
    assert ack.type == REFUSED and plan_of(sea) == as_sent(CORNER) and sea.state == "AUTO"


def test_pause_stops_the_boat_and_continue_sails_on() -> None:
    sea = sailing(CORNER)
    sea.run(10.0)
    assert acks(sea.order(PAUSE, 0.0)) == [(PAUSE, ACCEPTED)]
    sea.run(10.0)
    stopped = place(sea)
    sea.run(10.0)
    assert math.dist(place(sea), stopped) < 0.02 and progress(sea)[2] == PAUSED
    assert sea.state == "AUTO"
    sea.order(PAUSE, 1.0)
    sea.run(40.0)
    assert place(sea) == pytest.approx((10, 10), abs=0.05)


@pytest.mark.parametrize("order", [(PAUSE, 1.0), (MISSION_START, 0.0), (HOLD, 0.0)])
def test_a_plan_pauses_after_an_item_without_autocontinue(order: tuple[int, float]) -> None:
    """The first time after a corner, the second time after a wait."""
    stops = [item._replace(autocontinue=0) for item in (at(6, 0), at(6, 6, hold_s=8.0))]
    sea = sailing([*stops, at(0, 6)])
    for item, (north, east) in enumerate([(6, 0), (6, 6)]):
        sea.run(40.0)
        assert place(sea) == pytest.approx((north, east), abs=0.1)
        assert progress(sea) == (item + 1, 3, PAUSED) and sea.state == "AUTO"
        assert texts(sea.ticks)[-1] == f"Plan paused after item {item}: autocontinue is 0"
        if order[0] == HOLD:
            sea.mode(HOLD)
            sea.mode(AUTO)
        else:
            assert acks(sea.order(*order)) == [(order[0], ACCEPTED)]
    ticks = sea.run(40.0)
    assert progress(sea)[2] == COMPLETE and reached(ticks) == [2]


def test_ardupilots_identity_ignores_autocontinue() -> None:
    plan = [item._replace(autocontinue=0) for item in CORNER]
    sea = sailing(plan, {"MAV_AUTOPILOT": 1.0})
    sea.run(60.0)
    assert progress(sea) == (1, 2, COMPLETE) and place(sea) == pytest.approx((10, 10), abs=0.05)


def test_a_pause_stops_a_wait_and_the_turn_after_it() -> None:
    sea = sailing([at(5, 0, hold_s=20.0), at(5, -10)])
    sea.run(25.0)
    assert place(sea) == pytest.approx((5, 0), abs=0.05)
    for turned in (False, True):  # in the wait, and in the turn
        sea.order(PAUSE, 0.0)
        sea.run(5.0)
        heading = sea.hull.q[2]
        sea.run(30.0)
        assert progress(sea) == (0, 2, PAUSED)
        assert sea.hull.q[2] == pytest.approx(heading, abs=0.02)
        sea.order(PAUSE, 1.0)
        while not turned and sea.hull.q[2] > -0.5:
            sea.run(0.5)
    sea.run(50.0)
    assert place(sea) == pytest.approx((5, -10), abs=0.1)


@pytest.mark.parametrize("order", [(MISSION_START, 0.0), (SET_CURRENT, 0.0)])
def test_an_order_to_go_on_ends_a_pause(order: tuple[int, float]) -> None:
    sea = sailing([at(20, 0)])
    sea.run(5.0)
    sea.order(PAUSE, 0.0)
    sea.run(8.0)
    sea.arm()  # no order to sail
    sea.run(2.0)
    assert progress(sea)[2] == PAUSED
    assert acks(sea.order(*order)) == [(order[0], ACCEPTED)]
    sea.run(50.0)
    assert place(sea) == pytest.approx((20, 0), abs=0.2)


@pytest.mark.nightly
def test_a_plan_begun_far_from_its_first_waypoint_is_read_ahead_as_the_boat_sails() -> None:
    near = [at(6.0 * k, 1400.0 + 4.0 * (k % 2)) for k in range(1, 15)]
    plan = [at(0, 0), *near, at(-1390, -400), at(-1390, -1400)]
    sea = Afloat({"FS_SEP_M": 0.0}, hull=Hull([0.0, 1400.0, 0.0, 0.0, 0.0, 0.0]))
    sea.run(3.0)
    assert Planner(sea).send(plan) == ITEM_ACCEPTED
    sea.arm()
    sea.step()
    sea.order(SET_CURRENT, 1.0)
    sea.mode(AUTO)
    sea.run(250.0)
    assert sea.state == "AUTO"
    assert sea.hull.q[1] < 1395.0  # on the leg to the first place that is far away


def test_a_leg_over_2_9_km_is_refused() -> None:
    sea = at_sea([])
    assert Planner(sea).send([at(0, 0), at(1450, 0), at(-1460, 0)]) == INVALID_X
    assert "Plan refused at item 2: leg over 2.9 km" in texts(sea.ticks)
    assert Planner(sea).send([at(0, 0), at(1450, 0), at(-1440, 0)]) == ITEM_ACCEPTED
    back = bare(JUMP, 1.0, 1.0)
    assert Planner(sea).send([at(0, 0), at(1990, 0), at(0, 1990), at(-1990, 0), back]) == INVALID_X


def test_pause_is_for_auto_only_and_a_new_auto_is_not_paused() -> None:
    sea = at_sea(CORNER)
    assert acks(sea.order(PAUSE, 0.0)) == [(PAUSE, TEMPORARILY_REJECTED)]
    assert acks(sea.order(PAUSE, 2.0)) == [(PAUSE, DENIED)]
    sea.mode(AUTO)
    sea.step()
    sea.order(PAUSE, 0.0)
    sea.mode(HOLD)
    sea.mode(AUTO)
    sea.run(10.0)
    assert place(sea)[0] > 2.0


@pytest.mark.parametrize("old", [False, True])
def test_the_operator_chooses_the_next_item(old: bool) -> None:
    sea = sailing([at(0, 10), at(10, 0), at(10, 5)])
    sea.run(3.0)
    if old:
        sea.say(mavlink.MAVLink_mission_set_current_message(BOAT, 1, 1))
    else:
        assert acks(sea.order(SET_CURRENT, 1.0)) == [(SET_CURRENT, ACCEPTED)]
    ticks = sea.run(50.0)
    assert reached(ticks) == [1, 2] and place(sea) == pytest.approx((10, 5), abs=0.05)
    assert acks(sea.order(SET_CURRENT, 3.0)) == [(SET_CURRENT, DENIED)]
    sea.order(SET_CURRENT, 0.0)
    ticks = sea.run(90.0)
    assert reached(ticks) == [0, 1, 2]


def test_auto_goes_on_where_it_was_left() -> None:
    sea = sailing([at(10, 0), at(10, 10), at(0, 10)])
    sea.run(30.0)
    assert progress(sea)[0] == 1
    sea.mode(HOLD)
    sea.run(3.0)
    assert progress(sea) == (1, 3, PAUSED)
    sea.mode(AUTO)
    ticks = sea.run(60.0)
    assert reached(ticks) == [1, 2] and place(sea) == pytest.approx((0, 10), abs=0.05)


def test_a_plan_that_was_sailed_is_sailed_again_from_its_beginning() -> None:
    sea = sailing([at(5, 0), at(0, 0)])
    sea.run(60.0)
    assert progress(sea)[2] == COMPLETE
    sea.mode(HOLD)
    sea.mode(AUTO)
    assert reached(sea.run(80.0)) == [0, 1]


def test_speeds_and_waits_of_the_plan_are_kept() -> None:
    plan = [speed(0.3), at(6, 0, hold_s=6.0), speed(0.8), at(20, 0), Item(DELAY, (5.0, 0, 0, 0))]
    sea = sailing(plan)
    sea.run(12.0)
    assert sea.hull.seen.u == pytest.approx(0.3, abs=0.01)
    ticks = sea.run(14.0)
    assert reached(ticks) == [1] and place(sea)[0] == pytest.approx(6.0, abs=0.05)
    ticks = sea.run(16.0)
    assert sea.hull.seen.u == pytest.approx(0.8, abs=0.02)
    ticks += sea.run(20.0)
    assert reached(ticks) == [3] and progress(sea)[2] == COMPLETE


def test_a_plan_ends_at_a_loiter_without_end() -> None:
    sea = sailing([at(5, 0), Item(LOITER_UNLIMITED, x=0, y=0), at(10, 10)])
    sea.run(60.0)
    assert place(sea) == pytest.approx((5, 0), abs=0.05) and sea.state == "AUTO"


def test_the_propellers_stop_where_the_own_state_is_lost_and_do_not_start_by_themselves() -> None:
    sea = sailing(CORNER)
    sea.run(5.0)
    sea.own.on = False
    sea.run(1.0)
    assert sea.state == "HOLD" and not any(sea.commands)
    sea.own.on = True
    sea.run(5.0)
    assert sea.state == "HOLD" and not any(sea.commands)
    sea.mode(AUTO)
    sea.run(50.0)
    assert place(sea) == pytest.approx((10, 10), abs=0.05)


def test_a_plan_beyond_the_fence_ends_there() -> None:
    sea = sailing([at(30, 0)], {"FS_FENCE_M": 10.0, "FS_FENCE_ACT": 0})
    sea.run(60.0)
    assert sea.state == "HOLD" and 9 < place(sea)[0] < 13


def test_a_boat_that_a_current_carries_away_is_not_driven_on_for_ever() -> None:
    sea = sailing([at(60, 0)])
    sea.hull.push = (-80.0, 0.0)  # more than both propellers
    sea.run(60.0)
    assert sea.state == "HOLD" and not any(sea.commands)


class Weak(Afloat):
    """A boat whose propellers have a tenth of the thrust that its parameters tell."""

    def obeyed(self, commands: tuple[int, ...]) -> tuple[int, ...]:
        return tuple(command // 10 for command in commands)


def test_the_plan_waits_for_a_boat_that_the_wind_slows_down() -> None:
    sea = sailing([at(15, 0)], {"THR_FWD_MAX": 2.0, "THR_REV_MAX": 2.0}, kind=Weak)
    sea.run(5.0)
    sea.hull.push = (-2.5, 0.0)  # of 4 N
    sea.run(20.0)
    error = sea.snapshot()["error"]
    assert 1.0 < math.hypot(error["x_m"], error["y_m"]) < 1.5 and sea.hull.seen.u < 0.45
    sea.run(40.0)
    assert sea.state == "AUTO" and place(sea)[0] == pytest.approx(15, abs=0.7)


def test_a_boat_with_a_long_look_ahead_comes_back_to_its_plan_from_abeam() -> None:
    known = {"LAW_CUR_BW": 0.0, "LAW_OBS_BW": 0.0}  # otherwise it would learn the push
    sea = sailing([at(40, 0)], {"LAW_XT_DIST": 4.0, **known})
    sea.run(5.0)
    sea.hull.current = (0.0, 1.5)
    sea.run(3.5)
    sea.hull.current = (0.0, 0.0)
    assert place(sea)[1] > 4.0
    sea.run(60.0)
    assert place(sea)[0] > 20.0 and abs(place(sea)[1]) < 0.1


@pytest.mark.parametrize("current", [(-0.3, 0.0), (0.0, 0.3), (0.4, -0.2)])
def test_a_boat_sails_its_plan_in_a_current_and_stays_at_its_end(
    current: tuple[float, float],
) -> None:
    sea = at_sea(CORNER)
    sea.hull.current = current
    sea.run(3.0)
    sea.mode(AUTO)
    sea.run(120.0)
    assert sea.state == "AUTO" and place(sea) == pytest.approx((10, 10), abs=0.05)
    sea.run(60.0)
    assert sea.state == "AUTO" and place(sea) == pytest.approx((10, 10), abs=0.05)


@pytest.mark.parametrize("plan_first", [True, False])
def test_a_boat_changes_between_auto_and_formation(plan_first: bool) -> None:
    sea = Afloat(leader=None)
    sea.run(2.0)
    Planner(sea).send([at(20, 0)])
    sea.arm()
    sea.step()
    for mode in (AUTO, FORMATION) if plan_first else (FORMATION, AUTO):
        assert acks(sea.mode(mode)) == [(SET_MODE, ACCEPTED)]
        sea.run(2.0)
        assert sea.state == ("AUTO" if mode == AUTO else "FORMATION")


def test_sticks_alone_do_not_end_auto() -> None:
    sea = sailing(CORNER)
    for _ in range(20):
        sea.say(mavlink.MAVLink_manual_control_message(BOAT, 500, 0, 500, 0, 0))
        sea.run(0.1)
    assert sea.state == "AUTO"


def test_an_order_for_auto_that_comes_again_changes_nothing() -> None:
    sea = sailing(CORNER)
    sea.run(10.0)
    before = progress(sea)
    assert acks(sea.mode(AUTO)) == [(SET_MODE, ACCEPTED)]
    sea.run(1.0)
    assert progress(sea) == before and sea.state == "AUTO" and place(sea)[0] > 3.5


def test_a_boat_in_auto_tells_its_formation_the_motion_of_its_plan() -> None:
    sea = sailing([at(30, 0)])
    told = named(sea.run(10.0), "FORMATION_REFERENCE")
    assert 95 <= len(told) <= 101
    assert {(m.root, m.maker, m.flags & 1) for m in told[10:]} == {(BOAT, BOAT, 1)}
    last = told[-1]
    assert not any(last.path) and (last.offset_north, last.offset_east) == (0, 0)
    assert last.north / 1024 == pytest.approx(place(sea)[0], abs=0.1)
    assert last.u / 1024 == pytest.approx(0.5, abs=0.001)


@pytest.mark.parametrize("scalar", ["double", "q16"])
def test_the_plan_is_sailed_in_every_scalar(scalar: str) -> None:
    sea = sailing(CORNER, scalar=scalar)
    assert reached(sea.run(60.0)) == [0, 1]
    assert sea.state == "AUTO" and place(sea) == pytest.approx((10, 10), abs=0.06)


@pytest.mark.parametrize("scalar", ["float", "q16"])
def test_consecutive_longest_waits_do_not_overflow(scalar: str) -> None:
    wait = Item(DELAY, (30000.0, 0, 0, 0))
    sea = sailing([at(3, 0, hold_s=30000.0), wait, wait, at(3, 0, hold_s=30000.0)], scalar=scalar)
    sea.run(60.0)
    assert sea.state == "AUTO" and place(sea) == pytest.approx((3, 0), abs=0.05)


def test_a_plan_of_many_items_is_sailed_item_by_item() -> None:
    plan = [at(2.0 * k, 2.0 * (k % 2)) for k in range(1, 41)]
    sea = sailing(plan)
    assert reached(sea.run(320.0)) == list(range(40)) and progress(sea) == (39, 40, COMPLETE)
