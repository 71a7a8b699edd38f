# SPDX-License-Identifier: MIT
"""Fences and rally points by MAVLink's mission protocol: taken whole or not at all, and kept.

They use the protocol of plans: this file tests for them what test_plans.py tests for a plan."""

from __future__ import annotations

import math
import random
from collections.abc import Callable
from typing import Any

import pytest
from pymavlink.dialects.v20 import common as mavlink

from tests.target.hull import Afloat
from tests.target.plans import (
    ALL,
    BAD_SEQUENCE,
    CIRCLE_OUT,
    FENCE,
    INVALID,
    INVALID_PARAM1,
    INVALID_PARAM2,
    INVALID_X,
    INVALID_Y,
    ITEM_ACCEPTED,
    KEEP_IN,
    KEEP_OUT,
    NO_SPACE,
    PLAN,
    RALLY,
    REFUSED,
    RETURN_POINT,
    UNSUPPORTED_FRAME,
    UNSUPPORTED_ITEM,
    Item,
    Planner,
    as_sent,
    at,
    box,
    circle,
    corners,
    opaque_id,
    plan_of,
    rally,
    send,
)
from tests.target.sea import Sea, named, texts
from tests.target.stations import AUTO, BOAT, Station
from tests.target.test_auto import at_sea
from tests.target.test_long_texts import words

FENCED = [*box(0, 0, 100), circle(40, 40, 5, CIRCLE_OUT), circle(0, 0, 150)]
POINTS = [rally(10, 0), rally(0, 20), rally(-5, -5)]
KEPT = {FENCE: FENCED, RALLY: POINTS}
OTHER = {FENCE: [circle(0, 0, 77)], RALLY: [rally(3, 3)]}
MOST = {FENCE: 200, RALLY: 50}
NAME = {FENCE: "Fence", RALLY: "Rally"}
KINDS = pytest.mark.parametrize("kind", [FENCE, RALLY], ids=["fence", "rally"])


@pytest.fixture
def still() -> Sea:
    sea = Sea()
    sea.settle()
    return sea


def ring(count: int) -> list[Item]:
    """A polygon of so many corners."""
    turns = [2 * math.pi * k / count for k in range(count)]
    return corners(KEEP_IN, [(500 * math.cos(a), 500 * math.sin(a)) for a in turns])


@KINDS
def test_an_uploaded_list_comes_back_bit_for_bit_and_the_plan_stays(still: Sea, kind: int) -> None:
    plan = [at(5, 5), at(8, 8)]
    assert send(still, PLAN, plan) == ITEM_ACCEPTED
    assert send(still, kind, KEPT[kind]) == ITEM_ACCEPTED
    assert plan_of(still, kind) == as_sent(KEPT[kind]) and plan_of(still) == as_sent(plan)
    assert f"{NAME[kind]} of {len(KEPT[kind])} items stored" in texts(still.ticks)


@KINDS
@pytest.mark.parametrize("loss", [0.0, 0.25])
def test_the_longest_lists_arrive_though_a_quarter_of_the_messages_are_lost(
    still: Sea, kind: int, loss: float
) -> None:
    dice = random.Random(3)
    points = [rally(dice.uniform(-400, 400), dice.uniform(-400, 400)) for _ in range(50)]
    items = ring(200) if kind == FENCE else points
    assert Planner(still, kind=kind, loss=loss).send(items) == ITEM_ACCEPTED
    assert plan_of(still, kind) == as_sent(items)
    lossy = Planner(still, station=Station(253, 190), kind=kind, loss=loss)
    assert len(lossy.fetch()) == len(items)


@KINDS
def test_a_list_with_too_many_items_is_refused_and_the_old_one_stays(still: Sea, kind: int) -> None:
    send(still, kind, KEPT[kind])
    assert Planner(still, kind=kind).send([], count=MOST[kind] + 1) == NO_SPACE
    assert plan_of(still, kind) == as_sent(KEPT[kind])
    assert texts(still.ticks)[-1] == f"{NAME[kind]} refused at item 0: too many items"


@KINDS
def test_the_old_list_stays_until_the_last_item_of_the_new_one(still: Sea, kind: int) -> None:
    send(still, kind, OTHER[kind])
    items = KEPT[kind]
    still.say(mavlink.MAVLink_mission_count_message(BOAT, 1, len(items), kind))
    for seq, item in enumerate(items):
        still.step()
        assert plan_of(still, kind) == as_sent(OTHER[kind])
        still.say(item.message(seq, kind=kind))
    still.step()
    assert plan_of(still, kind) == as_sent(items)


@KINDS
def test_the_opaque_id_is_the_same_everywhere_and_new_with_the_content(
    still: Sea, kind: int
) -> None:
    seen = set()
    send(still, PLAN, [at(5, 5)])
    for items in (KEPT[kind], OTHER[kind]):
        assert send(still, kind, items) == ITEM_ACCEPTED
        (acked,) = still.ticks[-1].payloads(mavlink.MAVLINK_MSG_ID_MISSION_ACK)
        still.say(mavlink.MAVLink_mission_request_list_message(BOAT, 1, kind))
        (counted,) = still.run(0.1)[0].payloads(mavlink.MAVLINK_MSG_ID_MISSION_COUNT)
        told = still.run(1.2)
        current = [p for t in told for p in t.payloads(mavlink.MAVLINK_MSG_ID_MISSION_CURRENT)][-1]
        in_current = opaque_id(current, 10 if kind == FENCE else 14)
        assert {opaque_id(acked, 4), opaque_id(counted, 5), in_current} == {opaque_id(acked, 4)}
        seen.add(in_current)
    assert len(seen) == 2 and 0 not in seen


@KINDS
@pytest.mark.parametrize("way", ["count", "clear", "all"])
def test_fences_and_rally_points_are_cleared(still: Sea, kind: int, way: str) -> None:
    for one in (PLAN, FENCE, RALLY):
        send(still, one, KEPT.get(one, [at(5, 5)]))
    if way == "count":
        assert send(still, kind, []) == ITEM_ACCEPTED
    else:
        what = kind if way == "clear" else ALL
        still.say(mavlink.MAVLink_mission_clear_all_message(BOAT, 1, what))
        (ack,) = named(still.run(0.1), "MISSION_ACK")
        assert (ack.type, ack.mission_type) == (ITEM_ACCEPTED, what)
    left = [one for one in (PLAN, FENCE, RALLY) if plan_of(still, one)]
    assert left == ([] if way == "all" else [k for k in (PLAN, FENCE, RALLY) if k != kind])


def test_a_second_station_is_refused_while_another_kind_is_being_sent(still: Sea) -> None:
    still.say(mavlink.MAVLink_mission_count_message(BOAT, 1, 1, FENCE))
    still.step()
    other = Planner(still, station=Station(254, 190), kind=RALLY)
    assert other.send(POINTS) == REFUSED
    for kind in (FENCE, RALLY, ALL):
        clear = mavlink.MAVLink_mission_clear_all_message(BOAT, 1, kind)
        still.say(clear, sender=other.station)
        assert [ack.type for ack in still.step().named("MISSION_ACK")] == [REFUSED]
    still.say(OTHER[FENCE][0].message(0, kind=FENCE))
    (ack,) = still.step().named("MISSION_ACK")
    assert (ack.type, ack.mission_type) == (ITEM_ACCEPTED, FENCE)
    assert other.send(POINTS) == ITEM_ACCEPTED
    assert plan_of(still, RALLY) == as_sent(POINTS)


def test_two_stations_fetch_different_kinds_at_once(still: Sea) -> None:
    send(still, FENCE, FENCED)
    send(still, RALLY, POINTS)
    a, b = Station(253, 190), Station(254, 190)
    for seq in range(3):
        still.say(mavlink.MAVLink_mission_request_message(BOAT, 1, seq, FENCE), sender=a)
        still.say(mavlink.MAVLink_mission_request_int_message(BOAT, 1, seq, RALLY), sender=b)
        given = still.step().named("MISSION_ITEM_INT")
        assert [(m.seq, m.target_system, m.mission_type) for m in given] == [
            (seq, 253, FENCE),
            (seq, 254, RALLY),
        ]


STRANGER = Station(77, 1)
TROUBLE: dict[str, Callable[[Sea, int], object]] = {
    "another's item": lambda sea, kind: sea.say(at(9, 9).message(1, kind=kind), sender=STRANGER),
    "an item again": lambda sea, kind: sea.say(at(9, 9).message(0, kind=kind)),
    "an item too early": lambda sea, kind: sea.say(at(9, 9).message(2, kind=kind)),
    "of a plan": lambda sea, _: sea.say(at(9, 9).message(1)),
    "of the third kind": lambda sea, kind: sea.say(at(9, 9).message(1, kind=3 - kind)),
    "end of a plan": lambda sea, _: sea.say(mavlink.MAVLink_mission_ack_message(BOAT, 1, 15, PLAN)),
    "another's end": lambda sea, kind: sea.say(
        mavlink.MAVLink_mission_ack_message(BOAT, 1, 15, kind), sender=STRANGER
    ),
    "a plan cleared": lambda sea, _: sea.say(
        mavlink.MAVLink_mission_clear_all_message(BOAT, 1, PLAN)
    ),
}


@KINDS
@pytest.mark.parametrize("trouble", TROUBLE)
def test_messages_outside_an_upload_change_nothing_in_it(
    still: Sea, kind: int, trouble: str
) -> None:
    items = KEPT[kind]
    still.say(mavlink.MAVLink_mission_count_message(BOAT, 1, len(items), kind))
    for seq, item in enumerate(items):
        still.step()
        if seq == 1:
            TROUBLE[trouble](still, kind)
            still.step()
        still.say(item.message(seq, kind=kind))
    still.step()
    assert plan_of(still, kind) == as_sent(items)


@KINDS
@pytest.mark.parametrize("seq", [0, 1, 2, 65535])
def test_late_copies_of_items_change_nothing(still: Sea, kind: int, seq: int) -> None:
    send(still, kind, KEPT[kind])
    still.say(OTHER[kind][0].message(seq, kind=kind))
    still.say(OTHER[kind][0].message(seq, kind=kind), sender=STRANGER)
    still.run(1.0)
    assert plan_of(still, kind) == as_sent(KEPT[kind])


@KINDS
def test_a_client_that_missed_the_final_ack_gets_it_again(still: Sea, kind: int) -> None:
    send(still, kind, KEPT[kind])
    still.say(KEPT[kind][-1].message(len(KEPT[kind]) - 1, kind=kind))
    (ack,) = still.step().named("MISSION_ACK")
    assert (ack.type, ack.mission_type) == (ITEM_ACCEPTED, kind)


@KINDS
def test_a_client_that_may_not_command_reads_and_changes_nothing(kind: int) -> None:
    sea = Sea({"MAV_GCS_SYSID": 255.0})
    sea.settle()
    send(sea, kind, KEPT[kind])
    stranger = Planner(sea, station=STRANGER, kind=kind)
    assert len(stranger.fetch()) == len(KEPT[kind]) and stranger.send(OTHER[kind]) == REFUSED
    for what in (kind, ALL):
        sea.say(mavlink.MAVLink_mission_clear_all_message(BOAT, 1, what), sender=STRANGER)
        (ack,) = sea.step().named("MISSION_ACK")
        assert (ack.type, ack.mission_type) == (REFUSED, what)
    assert plan_of(sea, kind) == as_sent(KEPT[kind])


@pytest.mark.parametrize("kind", [3, 4, 254])
@pytest.mark.parametrize(
    ("message", "result"),
    [
        (lambda kind: mavlink.MAVLink_mission_count_message(BOAT, 1, 1, kind), UNSUPPORTED_ITEM),
        (lambda kind: at(1, 2).message(0, kind=kind), UNSUPPORTED_ITEM),
        (lambda kind: mavlink.MAVLink_mission_request_message(BOAT, 1, 7, kind), BAD_SEQUENCE),
        (lambda kind: mavlink.MAVLink_mission_clear_all_message(BOAT, 1, kind), ITEM_ACCEPTED),
    ],
)
def test_unknown_mission_types_are_refused(
    still: Sea, kind: int, message: Callable[[int], Any], result: int
) -> None:
    send(still, FENCE, FENCED)
    still.say(message(kind))
    (ack,) = named(still.run(0.2), "MISSION_ACK")
    assert (ack.type, ack.mission_type) == (result, kind)
    assert plan_of(still, FENCE) == as_sent(FENCED)


TRIANGLE = [(0.0, 0.0), (0.0, 30.0), (30.0, 0.0)]
GOOD = [
    corners(KEEP_IN, TRIANGLE),
    corners(KEEP_IN, TRIANGLE[::-1]),
    *[corners(KEEP_OUT, TRIANGLE, frame=frame) for frame in (0, 3, 5, 6, 11)],
    [circle(0, 0, 1), circle(0, 0, 2000)],
    [*corners(KEEP_IN, TRIANGLE), *corners(KEEP_IN, TRIANGLE)],
    corners(KEEP_IN, [(0, 0), (0, 30), (10, 10), (30, 0)]),  # concave
    [circle(0, 0, 5), *corners(KEEP_IN, [(-1500, 9), (1500, 9), (1500, -9), (-1500, -9)])],
    [circle(0, 0, 5)._replace(params=(5.0, math.nan, math.nan, math.nan))],
]
BAD: list[tuple[list[Item], int, int]] = [
    ([circle(0, 0, 0.9)], INVALID_PARAM1, 0),
    ([circle(0, 0, 2001, CIRCLE_OUT)], INVALID_PARAM1, 0),
    ([circle(0, 0, math.nan)], INVALID_PARAM1, 0),
    ([circle(0, 0, -5)], INVALID_PARAM1, 0),
    ([circle(0, 0, 5), circle(0, 0, 5)._replace(params=(5.0, 1.0, 0.0, 0.0))], INVALID_PARAM2, 1),
    ([circle(0, 0, 5), circle(2001, 0, 5)], INVALID_X, 1),
    ([circle(0, 0, 5), circle(0, 0, 5)._replace(x=0, y=0)], INVALID_Y, 1),
    ([circle(0, 0, 5), circle(0, 0, 5)._replace(x=900000001)], INVALID_X, 1),
    ([circle(0, 0, 5)._replace(frame=1)], UNSUPPORTED_FRAME, 0),
    ([circle(0, 0, 5)._replace(frame=2)], UNSUPPORTED_FRAME, 0),
    ([at(0, 0)], UNSUPPORTED_ITEM, 0),
    ([circle(0, 0, 5), rally(1, 1)], UNSUPPORTED_ITEM, 1),
    ([circle(0, 0, 5, RETURN_POINT)], UNSUPPORTED_ITEM, 0),
    (corners(KEEP_IN, TRIANGLE[:2]), INVALID_PARAM1, 0),
    (corners(KEEP_IN, TRIANGLE)[:2], INVALID, 1),
    ([*corners(KEEP_IN, TRIANGLE)[:2], circle(0, 0, 5)], INVALID, 2),
    ([*corners(KEEP_IN, TRIANGLE)[:2], *corners(KEEP_OUT, TRIANGLE)], INVALID, 2),
    ([*corners(KEEP_IN, TRIANGLE)[:2], *box(0, 0, 9)], INVALID_PARAM1, 2),
    ([i._replace(params=(2.5, 0.0, 0.0, 0.0)) for i in box(0, 0, 9)], INVALID_PARAM1, 0),
    ([i._replace(params=(math.inf, 0.0, 0.0, 0.0)) for i in box(0, 0, 9)], INVALID_PARAM1, 0),
    (corners(KEEP_IN, [(0, 0), (0, 30), (0, 30.05)]), INVALID_X, 2),
    (corners(KEEP_IN, [(0, 0), (0, 30), (30, 0), (0, 0)]), INVALID_X, 3),
    (corners(KEEP_IN, [(0, 0), (0, 30), (0, 15)]), INVALID, 2),  # back along its edge
    (corners(KEEP_IN, [(0, 0), (0, 15), (0, 30)]), INVALID, 2),  # of no area
    (corners(KEEP_IN, [(0, 0), (30, 30), (0, 30), (30, 0)]), INVALID, 3),  # a bow tie
    (corners(KEEP_IN, [(0, 0), (0, 30), (30, 30), (30, 10), (-5, 10)]), INVALID, 4),
    (corners(KEEP_IN, [(0, 0), (0, 30), (30, 30), (-9, 20), (-9, 40)]), INVALID, 3),
]


@pytest.mark.parametrize("items", GOOD, ids=range(len(GOOD)))
def test_every_supported_fence_item_is_accepted_and_returned(still: Sea, items: list[Item]) -> None:
    assert send(still, FENCE, items) == ITEM_ACCEPTED
    assert plan_of(still, FENCE) == as_sent(items)


@pytest.mark.parametrize(("items", "result", "item"), BAD, ids=range(len(BAD)))
def test_a_fence_that_is_not_sound_is_refused_with_its_items_number(
    still: Sea, items: list[Item], result: int, item: int
) -> None:
    send(still, FENCE, FENCED)
    assert send(still, FENCE, items) == result
    assert plan_of(still, FENCE) == as_sent(FENCED)
    (told,) = [t for t in "".join(texts(still.ticks)).split("Fence") if " refused" in t]
    assert told.startswith(f" refused at item {item}: ")


@pytest.mark.parametrize(
    ("items", "result"),
    [
        ([rally(0, 0), at(0, 0)], UNSUPPORTED_ITEM),
        ([rally(0, 0), circle(0, 0, 5)], UNSUPPORTED_ITEM),
        ([rally(0, 0), rally(0, 0)._replace(frame=1)], UNSUPPORTED_FRAME),
        ([rally(0, 0), rally(2001, 0)], INVALID_X),
        ([rally(0, 0), rally(0, 0)._replace(x=0, y=0)], INVALID_Y),
        ([rally(0, 0), rally(-101, 0)], INVALID),  # outside the fence
        ([rally(0, 0), rally(39, 39)], INVALID),
        ([rally(0, 0), rally(99, 0)], INVALID),  # too near to it
    ],
    ids=range(8),
)
def test_a_rally_point_where_no_boat_may_be_is_refused(
    still: Sea, items: list[Item], result: int
) -> None:
    send(still, FENCE, FENCED)
    send(still, RALLY, POINTS)
    assert send(still, RALLY, items) == result
    assert plan_of(still, RALLY) == as_sent(POINTS)


def test_a_plan_that_makes_a_place_outside_the_fence_home_is_refused(still: Sea) -> None:
    assert send(still, FENCE, box(0, 0, 60)) == ITEM_ACCEPTED
    outside = at(100, 0)._replace(command=mavlink.MAV_CMD_DO_SET_HOME, params=(0.0, 0, 0, 0))
    assert send(still, PLAN, [at(8, 0), outside, at(12, 0)]) == mavlink.MAV_MISSION_INVALID
    assert send(still, PLAN, [at(8, 0), outside._replace(params=(1.0, 0, 0, 0))]) == ITEM_ACCEPTED


def test_a_fence_that_leaves_the_plans_home_outside_bars_auto() -> None:
    home = at(100, 0)._replace(command=mavlink.MAV_CMD_DO_SET_HOME, params=(0.0, 0, 0, 0))
    sea = at_sea([at(8, 0), home, at(12, 0)])
    sea.disarm()
    assert send(sea, FENCE, box(0, 0, 60)) == ITEM_ACCEPTED
    sea.arm()
    sea.run(1.0)
    sea.mode(AUTO)
    assert sea.state == "HOLD"


@pytest.mark.parametrize("frame", [0, 3, 5, 6, 11])
def test_rally_points_come_in_every_global_frame(still: Sea, frame: int) -> None:
    items = [point._replace(frame=frame) for point in POINTS]
    assert send(still, RALLY, items) == ITEM_ACCEPTED and plan_of(still, RALLY) == as_sent(items)


@KINDS
def test_fences_and_rally_points_are_not_changed_while_the_law_drives(kind: int) -> None:
    sea = Afloat()
    sea.settle()
    send(sea, kind, KEPT[kind])
    sea.enter_formation()
    assert send(sea, kind, OTHER[kind]) == REFUSED
    for what in (kind, ALL):
        sea.say(mavlink.MAVLink_mission_clear_all_message(BOAT, 1, what))
        (ack,) = sea.step().named("MISSION_ACK")
        assert ack.type == REFUSED
    assert f"{NAME[kind]} refused at item 0: needs HOLD and MAV_GCS_SYSID" in words(sea.ticks)
    assert sea.state == "FORMATION" and plan_of(sea, kind) == as_sent(KEPT[kind])
    assert send(sea, PLAN, [at(5, 5)]) == ITEM_ACCEPTED, "a plan is, as it is not sailed"
