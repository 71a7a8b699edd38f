# SPDX-License-Identifier: MIT
"""A boat stays in its fence: plans that leave it are refused, and the law stops before it."""

from __future__ import annotations

import math

import pytest
from pymavlink.dialects.v20 import common as mavlink

from tests.target.course import Course
from tests.target.hull import Afloat, Hull
from tests.target.operator_words import param_set, sticks
from tests.target.plans import (
    CIRCLE_OUT,
    FENCE,
    INVALID,
    INVALID_PARAM1,
    ITEM_ACCEPTED,
    JUMP,
    KEEP_IN,
    KEEP_OUT,
    PLAN,
    Item,
    Planner,
    as_sent,
    at,
    bare,
    box,
    circle,
    corners,
    plan_of,
    send,
    turns,
)
from tests.target.sea import Sea, acks, named, texts
from tests.target.stations import (
    ACCEPTED,
    AUTO,
    BOAT,
    DENIED,
    FENCE_ENABLE,
    FORMATION,
    GUIDED,
    HOLD,
    LOITER,
    MANUAL,
    RTL,
    SET_MODE,
    TEMPORARILY_REJECTED,
    Station,
    heartbeat,
    local_position,
    origin,
)
from tests.target.test_auto import SET_CURRENT, at_sea, place, sailing
from tests.target.test_long_texts import words

GEOFENCE = 1 << 20
HULL = 1.3  # BOAT_LEN's default: the margin


def fenced(
    plan: list[Item], fence: list[Item], parameters: dict[str, float] | None = None
) -> Afloat:
    """A boat at the origin whose fence was stored after its plan."""
    sea = at_sea(plan, parameters)
    assert send(sea, FENCE, fence) == ITEM_ACCEPTED
    sea.run(0.5)
    return sea


#: A plan's last item, and its refusal (or None) by a fence of ±20 m with a hole at (10, 10).
LEGS = [
    (at(20 - HULL - 0.1, 0), None),
    (at(20 - HULL + 0.1, 0), "too near the fence"),
    (at(23, 0), "outside the fence"),
    (at(10, 10), "outside the fence"),
    (at(10, 10 + 3 + HULL - 0.1), "too near the fence"),
    (at(16, 16), "path crosses the fence"),
    (at(16, 0), None),
    (at(0, 2001), "over 2 km from the first"),
]


@pytest.mark.parametrize(("item", "why"), LEGS, ids=range(len(LEGS)))
@pytest.mark.parametrize("width", [0.0, 1.0])
def test_a_plan_that_leaves_the_fence_is_refused_with_its_items_number(
    item: Item, why: str | None, width: float
) -> None:
    sea = Sea({"WP_WIDTH": width})
    sea.settle()
    grown = 20 + width  # the same margin is left, and so is the answer
    fence = [*box(0, 0, grown), circle(10, 10, 3 - width, CIRCLE_OUT)]
    assert send(sea, FENCE, fence) == ITEM_ACCEPTED
    old = [at(1, 1)]
    assert send(sea, PLAN, old) == ITEM_ACCEPTED
    plan = [at(0, 0), at(2, 2), item]
    result = send(sea, PLAN, plan)
    if why is None:
        assert result == ITEM_ACCEPTED and plan_of(sea) == as_sent(plan)
    else:
        assert result != ITEM_ACCEPTED and plan_of(sea) == as_sent(old)
        assert words(sea.ticks)[-1] == f"Plan refused at item 2: {why}"


def test_a_leg_past_a_spit_of_land_is_refused_and_one_round_it_taken() -> None:
    sea = Sea()
    sea.settle()
    spit = corners(KEEP_OUT, [(-0.2, -30), (0.2, -30), (0.2, 30), (-0.2, 30)])
    assert send(sea, FENCE, spit) == ITEM_ACCEPTED
    assert send(sea, PLAN, [at(-20, 0), at(20, 0)]) == INVALID
    assert words(sea.ticks)[-1] == "Plan refused at item 1: path crosses the fence"
    assert send(sea, PLAN, [at(-20, 0), at(-20, 40), at(20, 40), at(20, 0)]) == ITEM_ACCEPTED


@pytest.mark.parametrize("turn_deg", [60, 90, 135])
def test_a_corner_round_a_spit_of_land_is_rounded_less(turn_deg: int) -> None:
    """Land inside the corner, its tip at the margin from both legs; without it, the curve cuts."""
    turn = math.radians(turn_deg)
    north, east = math.cos(turn), math.sin(turn)
    plan = [at(5, 0), at(30, 0, radius_m=4), at(30 + 25 * north, 25 * east)]
    inwards = math.pi / 2 + turn / 2
    away = (HULL + 0.02) / math.cos(turn / 2)
    tip = 30 + away * math.cos(inwards), away * math.sin(inwards)
    back, out = (tip[0] - 30, tip[1]), (tip[0] + 30 * north, tip[1] + 30 * east)
    land = corners(KEEP_OUT, [back, tip, out, (back[0] + 30 * north, back[1] + 30 * east)])
    nearest = []
    for fence in (land, box(0, 0, 300)):
        sea = fenced(plan, fence, {"LAW_U_MAX": 1.5, "WP_SPEED": 1.5})
        sea.mode(AUTO)
        near = math.inf
        for _ in range(8000):
            sea.step()
            near = min(near, math.dist(place(sea), tip))
            assert sea.state == "AUTO"
        assert math.dist(place(sea), (30 + 25 * north, 25 * east)) < 0.5
        nearest.append(near)
    assert nearest[0] > 0.7 * HULL
    assert nearest[1] < 0.6 * HULL


@pytest.mark.parametrize("radius_m", [8, 20])
def test_a_curve_keeps_from_a_rock_inside_the_corner(radius_m: float) -> None:
    """Both legs pass the rock at the margin, and a wide curve would pass it on its other side."""
    plan = [at(5, 0), at(40, 0, radius_m=radius_m), at(40, 35)]
    off = HULL + 1.05
    nearest = []
    for fence in ([circle(40 - off, off, 1, CIRCLE_OUT)], box(0, 0, 300)):
        sea = fenced(plan, fence, {"LAW_U_MAX": 2, "WP_SPEED": 2})
        sea.mode(AUTO)
        near = math.inf
        for _ in range(8000):
            sea.step()
            near = min(near, math.dist(place(sea), (40 - off, off)))
            assert sea.state == "AUTO"
        assert math.dist(place(sea), (40, 35)) < 0.5
        nearest.append(near)
    assert nearest[1] < 1 + 0.5 * HULL
    assert nearest[0] > 1 + 0.7 * HULL


@pytest.mark.parametrize("fence_first", [True, False])
@pytest.mark.parametrize(
    "ends", [(at(-300, 0), at(400, 0)), (at(400, 0), at(-300, 0))], ids=["out", "in"]
)
def test_legs_from_and_to_a_circle_are_judged_from_where_the_boat_leaves_it(
    ends: tuple[Item, Item], fence_first: bool
) -> None:
    # It leaves the circle in the south or west: straight through the zone, which a leg from the
    # centre passes.
    zone = [circle(200, -54, 30, CIRCLE_OUT)]
    plan = [ends[0], turns(0, 0, 0.25, 100), ends[1]]
    if fence_first:
        sea = fenced([], zone)
        assert send(sea, PLAN, plan) == INVALID
    else:
        sea = fenced(plan, zone)
        assert acks(sea.mode(AUTO)) == [(SET_MODE, TEMPORARILY_REJECTED)]
    assert any("crosses the fence" in text for text in words(sea.ticks)[-3:])


def test_a_jump_to_a_jump_is_refused_because_its_leg_is_not_judged() -> None:
    sea = Sea()
    sea.settle()
    plan = [at(0, 0), at(9, 0), bare(JUMP, 0.0, 1.0), at(9, 9), at(0, 9), bare(JUMP, 2.0, 1.0)]
    assert send(sea, PLAN, plan) == INVALID_PARAM1
    assert words(sea.ticks)[-1] == "Plan refused at item 5: jump to a jump"


@pytest.mark.parametrize(
    ("plan", "item"), [([at(5, 0), at(25, 0)], 1), ([at(5, 0)] * 40 + [at(25, 0)], 40)]
)
def test_a_fence_that_the_stored_plan_leaves_is_taken_and_auto_refused(
    plan: list[Item], item: int
) -> None:
    sea = fenced(plan, box(0, 0, 20))
    sea.run(0.5)
    assert f"Plan invalid at item {item}: outside the fence" in words(sea.ticks)
    assert acks(sea.mode(AUTO)) == [(SET_MODE, TEMPORARILY_REJECTED)] and sea.state == "HOLD"
    assert words(sea.ticks)[-1] == "Plan: outside the fence"
    assert send(sea, FENCE, box(0, 0, 30)) == ITEM_ACCEPTED
    sea.run(0.5)
    assert acks(sea.mode(AUTO)) == [(SET_MODE, ACCEPTED)]


def test_a_plan_that_leaves_a_new_fence_is_reported_beside_another_refusal() -> None:
    sea = at_sea([at(30, 0)])
    assert send(sea, FENCE, box(0, 0, 15)) == ITEM_ACCEPTED
    sea.mode(FORMATION)  # refused: there is no leader
    sea.run(2.0)
    assert "Plan invalid at item 0: outside the fence" in words(sea.ticks)


def test_a_plan_is_judged_again_when_wp_radius_changes() -> None:
    sea = fenced([at(0, 0), turns(5, 0, 1.0, 0.0)], box(0, 0, 20), {"WP_RADIUS": 3.0})
    sea.say(param_set("WP_RADIUS", 18.0))
    sea.run(0.5)
    assert any(text.startswith("Plan invalid at item 1: ") for text in words(sea.ticks))
    assert acks(sea.mode(AUTO)) == [(SET_MODE, TEMPORARILY_REJECTED)]
    sea.say(param_set("WP_RADIUS", 3.0))
    sea.run(0.5)
    assert acks(sea.mode(AUTO)) == [(SET_MODE, ACCEPTED)]


def test_a_fence_that_goes_permits_the_plan_again() -> None:
    sea = fenced([at(25, 0)], box(0, 0, 20))
    assert acks(sea.mode(AUTO)) == [(SET_MODE, TEMPORARILY_REJECTED)]
    send(sea, FENCE, [])
    sea.run(0.1)
    assert acks(sea.mode(AUTO)) == [(SET_MODE, ACCEPTED)]


def test_auto_does_not_begin_where_the_way_to_the_plan_leaves_the_fence() -> None:
    wall = corners(KEEP_OUT, [(8, -20), (8, 20), (9, 20), (9, -20)])
    sea = fenced([at(20, 0), at(20, 10)], wall)
    assert acks(sea.mode(AUTO)) == [(SET_MODE, TEMPORARILY_REJECTED)]
    assert words(sea.ticks)[-1] == "Plan: path crosses the fence"


@pytest.mark.parametrize("via", [None, LOITER, GUIDED], ids=["HOLD", "LOITER", "GUIDED"])
def test_auto_is_judged_by_the_way_to_the_item_that_was_chosen_just_now(via: int | None) -> None:
    """The plan leads round a wall; the way to its third place goes through it."""
    wall = corners(KEEP_OUT, [(8, -20), (8, 20), (9, 20), (9, -20)])
    sea = fenced([at(0, 5), at(0, 28), at(17, 28), at(17, 0)], wall)
    if via is not None:
        assert acks(sea.mode(via)) == [(SET_MODE, ACCEPTED)]
        sea.run(1.0)
    state = sea.state
    assert acks(sea.order(SET_CURRENT, 3.0)) == [(SET_CURRENT, ACCEPTED)]
    assert acks(sea.mode(AUTO)) == [(SET_MODE, TEMPORARILY_REJECTED)]
    assert sea.state == state and words(sea.ticks)[-1] == "Plan: path crosses the fence"
    assert acks(sea.order(SET_CURRENT, 1.0)) == [(SET_CURRENT, ACCEPTED)]
    assert acks(sea.mode(AUTO)) == [(SET_MODE, ACCEPTED)] and sea.state == "AUTO"


def test_auto_is_judged_from_where_the_boat_has_sailed_meanwhile() -> None:
    """In GUIDED the boat sails to a place from where an isle blocks the way to the plan."""
    sea = fenced([at(0, -10)], corners(KEEP_OUT, [(2, -3), (2, 3), (8, 3), (8, -3)]))
    for north, east, result in [(0, 10, ACCEPTED), (10, 5, TEMPORARILY_REJECTED)]:
        there = at(north, east)
        go = (BOAT, 1, 6, 192, 0, 0, 1.0, 1.0, 0, 0, there.x, there.y, 0)
        sea.say(mavlink.MAVLink_command_int_message(*go))
        sea.run(30.0)
        assert sea.state == "GUIDED" and place(sea) == pytest.approx((north, east), abs=0.5)
        assert acks(sea.mode(AUTO)) == [(SET_MODE, result)]
        assert sea.state == ("AUTO" if result == ACCEPTED else "GUIDED")


def test_a_boat_outside_its_fence_is_driven_by_the_sticks_only() -> None:
    sea = fenced([at(50, 0)], box(50, 0, 20))
    assert acks(sea.mode(AUTO)) == [(SET_MODE, TEMPORARILY_REJECTED)]
    assert "Refused: fence: outside, ahead, or no position" in words(sea.ticks)
    before = len(sea.ticks)
    sea.say(sticks(0, 0))
    sea.mode(MANUAL)
    for _ in range(40):
        sea.say(sticks(400, 0))
        sea.run(0.1)
    assert sea.state == "MANUAL" and all(c > 0 for c in sea.commands)
    warned = words(sea.ticks[before:])
    assert 1 <= warned.count("outside fence, or position unknown") <= 2


FENCES = {
    "square": (box(0, 0, 8), lambda n, e: max(abs(n), abs(e)) - 8),
    "circle": ([circle(0, 0, 8)], lambda n, e: math.hypot(n, e) - 8),
}


@pytest.mark.parametrize("scalar", ["float", "q16"])
@pytest.mark.parametrize("speed", [0.4, 1.0])
@pytest.mark.parametrize("bearing", [0.3, 2.0])
@pytest.mark.parametrize("shape", FENCES)
def test_a_boat_whose_leader_leaves_the_fence_stops_inside_it(
    shape: str, bearing: float, speed: float, scalar: str
) -> None:
    fence, beyond = FENCES[shape]
    leader = Course(math.cos(bearing), math.sin(bearing), bearing, speed)
    hull = Hull([0.0, 0.0, bearing] + [0.0] * 3)
    sea = Afloat({"FS_FENCE_ACT": 0}, hull=hull, leader=leader, scalar=scalar)
    sea.run(0.5)
    assert send(sea, FENCE, fence) == ITEM_ACCEPTED
    sea.enter_formation()
    sea.run_until("HOLD", 30.0)
    assert texts([sea.ticks[-1]]) == ["HOLD: fence: outside, ahead, or no position"]
    assert beyond(*place(sea)) > -1.0 - 2.5 * speed, "not sooner than it must"
    sea.run(5.0)
    assert beyond(*place(sea)) < 0 and not any(sea.commands)
    assert named(sea.run(1.1), "FENCE_STATUS")[-1].breach_count == 0
    assert acks(sea.mode(FORMATION)) == [(SET_MODE, TEMPORARILY_REJECTED)] or sea.state != "HOLD"


@pytest.mark.parametrize(("action", "into"), [(1, "LOITER"), (2, "RTL")])
@pytest.mark.parametrize("speed", [0.4, 1.0])
@pytest.mark.parametrize("shape", FENCES)
def test_at_the_fence_the_boat_waits_or_turns_back_and_never_leaves_it(
    shape: str, speed: float, action: int, into: str
) -> None:
    fence, beyond = FENCES[shape]
    leader = Course(math.cos(0.3), math.sin(0.3), 0.3, speed)
    sea = Afloat({"FS_FENCE_ACT": action}, hull=Hull([0.0, 0.0, 0.3, 0, 0, 0]), leader=leader)
    sea.run(0.5)
    assert send(sea, FENCE, fence) == ITEM_ACCEPTED
    sea.enter_formation()
    sea.run_until(into, 30.0)
    for _ in range(60):
        sea.run(1.0)
        assert beyond(*place(sea)) < 0 and sea.state == into
    home = place(sea) if into == "LOITER" else (0.0, 0.0)
    sea.run(20.0)
    assert place(sea) == pytest.approx(home, abs=0.1)


def test_a_target_behind_a_fence_is_refused_and_rtl_goes_round_it() -> None:
    """A wall between the boat and its home: it sails round rather than through it."""
    sea = at_sea([])
    away = at(20, 0)
    sea.say(
        mavlink.MAVLink_command_int_message(
            *(BOAT, 1, 6, 192, 0, 0, -1.0, 1.0, 0, 0, away.x, away.y, 0)
        )
    )
    sea.run(60.0)
    sea.mode(HOLD)
    sea.step()
    wall = corners(KEEP_OUT, [(8, -30), (8, 30), (12, 30), (12, -30)])
    assert send(sea, FENCE, wall) == ITEM_ACCEPTED
    beyond = at(0, 0)
    sea.say(
        mavlink.MAVLink_command_int_message(
            *(BOAT, 1, 6, 192, 0, 0, -1.0, 1.0, 0, 0, beyond.x, beyond.y, 0)
        )
    )
    assert acks(sea.step()) == [(192, DENIED)] and sea.state == "HOLD"
    sea.mode(RTL)
    sea.run(20.0)
    assert "straight path crosses the fence: detour" in words(sea.ticks)
    assert sea.state == "RTL" and abs(place(sea)[1]) > 2


@pytest.mark.parametrize("gap_m", [7.0, 9.0])
def test_guided_without_a_target_stops_before_a_wall_and_does_not_go_round_it(gap_m: float) -> None:
    """Braking straight ahead, the boat would come to rest behind the thin wall."""
    sea = fenced([], corners(KEEP_OUT, [(40, -30), (40, 30), (41, 30), (41, -30)]))
    sea.say(sticks(0, 0))
    sea.mode(MANUAL)
    while place(sea)[0] < 40 - gap_m:
        sea.say(sticks(130, 0))
        sea.run(0.1)
    assert acks(sea.mode(GUIDED)) == [(SET_MODE, ACCEPTED)]
    sea.run(30.0)
    assert sea.state == "GUIDED" and not any("detour" in text for text in words(sea.ticks))
    assert place(sea) == pytest.approx((40 - gap_m, 0), abs=0.5)


def test_a_boat_under_way_refuses_an_item_if_the_way_to_it_leaves_the_fence() -> None:
    plan = [at(10, 0), at(10, 20), at(-10, 20)]
    sea = fenced(plan, corners(KEEP_OUT, [(-5, 5), (-5, 15), (5, 15), (5, 5)]))
    assert acks(sea.mode(AUTO)) == [(SET_MODE, ACCEPTED)]
    sea.run(2.0)
    assert acks(sea.order(SET_CURRENT, 2.0)) == [(SET_CURRENT, DENIED)]
    assert "Refused: path crosses the fence" in words(sea.ticks)
    assert sea.state == "AUTO"
    (told,) = sea.ask(mavlink.MAVLINK_MSG_ID_MISSION_CURRENT)
    assert told.seq == 0
    assert acks(sea.order(SET_CURRENT, 0.0)) == [(SET_CURRENT, ACCEPTED)]


def test_along_the_fence_the_law_drives_on() -> None:
    """The fence is 2 m abeam; at its speed the boat needs a longer distance to stop."""
    leader = Course(1.0, 0.0, 0.0, 1.0)
    sea = Afloat(hull=Hull([0.0] * 6), leader=leader)
    sea.run(0.5)
    strip = corners(KEEP_IN, [(-9, -2), (-9, 2), (60, 2), (60, -2)])
    assert send(sea, FENCE, strip) == ITEM_ACCEPTED
    sea.enter_formation()
    sea.run(30.0)
    assert sea.state == "FORMATION" and place(sea)[0] > 20


def status(sea: Sea) -> tuple[bool, bool, bool]:
    (told,) = sea.ask(mavlink.MAVLINK_MSG_ID_SYS_STATUS)
    return (
        bool(told.onboard_control_sensors_present & GEOFENCE),
        bool(told.onboard_control_sensors_enabled & GEOFENCE),
        bool(told.onboard_control_sensors_health & GEOFENCE),
    )


def test_fence_status_and_sys_status_tell_of_the_fence() -> None:
    sea = at_sea([])
    assert not named(sea.run(3.0), "FENCE_STATUS") and status(sea) == (False, False, True)
    send(sea, FENCE, box(0, 0, 20))
    told = named(sea.run(3.0), "FENCE_STATUS")
    assert 3 <= len(told) <= 4 and status(sea) == (True, True, True)
    assert (told[-1].breach_status, told[-1].breach_count, told[-1].breach_type) == (0, 0, 0)
    send(sea, FENCE, box(50, 0, 20))
    told = named(sea.run(3.0), "FENCE_STATUS")
    assert (told[-1].breach_status, told[-1].breach_count, told[-1].breach_type) == (1, 1, 3)
    assert told[-1].breach_time > 0 and status(sea) == (True, True, False)
    sea.order(FENCE_ENABLE, 0.0)
    sea.run(0.1)
    assert status(sea) == (True, False, True)
    send(sea, FENCE, [])
    sea.run(0.1)
    assert not named(sea.run(3.0), "FENCE_STATUS") and status(sea) == (False, False, True)


def test_the_capabilities_tell_of_fences_and_rally_points() -> None:
    sea = at_sea([])
    (told,) = sea.ask(mavlink.MAVLINK_MSG_ID_AUTOPILOT_VERSION)
    assert told.capabilities & 16384 and told.capabilities & 32768


@pytest.mark.parametrize(
    ("params", "result"),
    [
        ((1.0,), ACCEPTED),
        ((0.0, 4.0), ACCEPTED),
        ((0.0, 15.0), ACCEPTED),
        ((1.0, math.nan), ACCEPTED),
        ((2.0,), DENIED),  # the floor
        ((math.nan,), DENIED),
        ((0.0, 2.0), DENIED),  # the circle of FS_FENCE_M
        ((-1.0,), DENIED),
    ],
)
def test_the_fence_is_switched_on_and_off(params: tuple[float, ...], result: int) -> None:
    sea = at_sea([])
    assert acks(sea.order(FENCE_ENABLE, *params)) == [(FENCE_ENABLE, DENIED)], "there is none"
    send(sea, FENCE, box(50, 0, 20))
    sea.run(0.1)
    assert acks(sea.order(FENCE_ENABLE, *params)) == [(FENCE_ENABLE, result)]
    sea.run(0.1)
    on = result != ACCEPTED or params[0] == 1.0
    assert status(sea) == (True, on, not on)


def test_a_late_copy_does_not_switch_the_fence_off_again() -> None:
    sea = at_sea([])
    send(sea, FENCE, box(50, 0, 20))
    sea.run(0.1)
    for confirmation, asked, result in [
        (1, 1.0, ACCEPTED),
        (1, 0.0, mavlink.MAV_RESULT_TEMPORARILY_REJECTED),
        (0, 0.0, ACCEPTED),
        (1, 0.0, ACCEPTED),  # it is off already
    ]:
        answered = acks(sea.order(FENCE_ENABLE, asked, confirmation=confirmation))
        assert answered == [(FENCE_ENABLE, result)]
        sea.run(0.1)
        on = asked == 1.0 or result != ACCEPTED
        assert status(sea) == (True, on, not on)


def test_a_boat_that_loses_its_position_counts_as_outside_the_fence() -> None:
    sea = sailing([at(15, 0)])
    sea.mode(4)
    send(sea, FENCE, [*box(0, 0, 60), *box(0, 0, 70, KEEP_IN)])
    sea.own.on = False
    sea.run(1.0)
    sea.own.on = True
    sea.run(3.0)
    assert acks(sea.mode(AUTO)) == [(SET_MODE, ACCEPTED)]
    sea.own.on = False
    sea.run(1.0)
    assert sea.state == "HOLD" and not any(sea.commands)


def test_a_boat_gives_way_inside_its_fence() -> None:
    """The rules of the road ask for starboard, where the fence is: the boat goes to port."""
    fence = corners(KEEP_IN, [(-20, -20), (60, -20), (60, 3), (-20, 3)])
    sea = fenced([at(1, 0), at(40, 0)], fence, {"FS_SEP_M": 2.0})
    assert acks(sea.mode(AUTO)) == [(SET_MODE, ACCEPTED)]
    stranger, ship = Station(BOAT + 1), Course(30.0, 0.0, math.pi, 0.5)
    sea.say(heartbeat(mavlink.MAV_TYPE_SURFACE_BOAT), origin(sea.now_us), sender=stranger)
    least, farthest = math.inf, 0.0
    for tenth in range(1300):
        there = ship.at(0.1 * tenth)
        sea.say(local_position(there, sea.now_us), sender=stranger)
        sea.run(0.1)
        north, east = place(sea)
        farthest = max(farthest, east)
        least = min(least, math.hypot(north - there.north, east - there.east))
    assert least > 2.0 and farthest < 3.0
    assert sea.state == "AUTO" and place(sea) == pytest.approx((40.0, 0.0), abs=0.1)


def test_a_fence_enabled_during_an_upload_applies_to_earlier_items_too() -> None:
    sea = fenced([at(1, 0)], box(0, 0, 20))
    sea.order(FENCE_ENABLE, 0.0)
    planner = Planner(sea)
    items = [at(5, 0), at(50, 0), at(5, 5), at(6, 6)]
    planner.say(mavlink.MAVLink_mission_count_message(BOAT, 1, 4, 0))
    sea.step()
    for seq, item in enumerate(items):
        if seq == 3:
            sea.order(FENCE_ENABLE, 1.0)
        planner.say(item.message(seq))
        sea.run(0.1)
    sea.run(1.0)
    assert any("item 1: outside the fence" in text for text in words(sea.ticks)), words(sea.ticks)
    sea.mode(AUTO)
    assert sea.state != "AUTO"
