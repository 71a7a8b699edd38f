# SPDX-License-Identifier: MIT
"""MAVLink's mission protocol: plans are taken whole or not at all, kept, and given back."""

from __future__ import annotations

import math
import random
from collections.abc import Callable

import pytest
from pymavlink.dialects.v20 import common as mavlink

from tests.target.plans import (
    CANCELLED,
    DELAY,
    INVALID,
    INVALID_PARAM1,
    INVALID_PARAM2,
    INVALID_X,
    INVALID_Y,
    ITEM_ACCEPTED,
    LOITER_TIME,
    LOITER_UNLIMITED,
    NO_SPACE,
    REFUSED,
    SPEED,
    UNSUPPORTED_FRAME,
    UNSUPPORTED_ITEM,
    Item,
    Planner,
    as_sent,
    at,
    ids,
    opaque_id,
    plan_of,
    speed,
)
from tests.target.sea import Sea, acks, named, texts
from tests.target.stations import (
    BOAT,
    GCS,
    GCS_COMPONENT,
    SET_MODE,
    TEMPORARILY_REJECTED,
    Station,
    command_long,
)

SQUARE = [at(20, 0), speed(0.8), at(20, 20, radius_m=1.5), at(0, 20, hold_s=5), at(0, 0)]
OTHER = [at(5, 5), at(-5, 5)]
NAN = math.nan


@pytest.fixture
def planner(sea: Sea) -> Planner:
    sea.settle()
    return Planner(sea)


def many(count: int) -> list[Item]:
    dice = random.Random(3)
    return [at(dice.uniform(-900, 900), dice.uniform(-900, 900)) for _ in range(count)]


def test_a_plan_that_was_sent_comes_back_bit_for_bit(planner: Planner, sea: Sea) -> None:
    assert planner.send(SQUARE) == ITEM_ACCEPTED
    assert plan_of(sea) == as_sent(SQUARE)
    assert texts(sea.ticks)[-1] == "Plan of 5 items stored"


def test_a_boat_has_no_plan_at_first(planner: Planner, sea: Sea) -> None:
    assert planner.fetch() == [] and ids(sea) == (0, 0)


@pytest.mark.parametrize("count", [500, 1000])
def test_a_long_plan_arrives_though_a_quarter_of_the_messages_are_lost(count: int) -> None:
    sea = Sea()
    sea.settle()
    items = many(count)
    loss = 0.25 if count == 500 else 0.0
    assert Planner(sea, loss=loss).send(items) == ITEM_ACCEPTED
    assert plan_of(sea) == as_sent(items)
    lossy = Planner(sea, station=Station(253, 190), loss=loss)
    if count == 500:
        assert len(lossy.fetch()) == count


def test_a_plan_that_is_too_long_is_refused_and_the_old_one_stays(
    planner: Planner, sea: Sea
) -> None:
    planner.send(SQUARE)
    assert planner.send([], count=1001) == NO_SPACE
    assert plan_of(sea) == as_sent(SQUARE)
    assert texts(sea.ticks)[-1] == "Plan refused at item 0: too many items"


def test_the_old_plan_stays_until_the_last_item(planner: Planner, sea: Sea) -> None:
    planner.send(SQUARE)
    sea.say(mavlink.MAVLink_mission_count_message(BOAT, 1, 2, 0))
    sea.step()
    sea.say(OTHER[0].message(0))
    sea.step()
    assert plan_of(sea) == as_sent(SQUARE)
    sea.say(OTHER[1].message(1))
    sea.step()
    assert plan_of(sea) == as_sent(OTHER)


def test_a_silent_sender_is_asked_again_for_five_seconds_and_then_forgotten(
    planner: Planner, sea: Sea
) -> None:
    planner.send(SQUARE)
    sea.say(mavlink.MAVLink_mission_count_message(BOAT, 1, 2, 0))
    ticks = sea.run(6.0)
    asked = named(ticks, "MISSION_REQUEST_INT")
    assert len(asked) == 21 and {m.seq for m in asked} == {0}
    (ack,) = named(ticks, "MISSION_ACK")
    assert ack.type == CANCELLED
    assert "Plan refused at item 0: upload timed out" in texts(ticks)
    assert plan_of(sea) == as_sent(SQUARE) and planner.send(OTHER) == ITEM_ACCEPTED


def test_the_plans_id_is_the_same_everywhere_and_new_with_each_plan(
    planner: Planner, sea: Sea
) -> None:
    seen = set()
    for items in (SQUARE, OTHER, SQUARE[:1]):
        assert planner.send(items) == ITEM_ACCEPTED
        payload = sea.ticks[-1].payloads(mavlink.MAVLINK_MSG_ID_MISSION_ACK)[0]
        told = {opaque_id(payload, 4), *ids(sea)}
        assert len(told) == 1 and 0 not in told
        seen |= told
    assert len(seen) == 3
    planner.send(SQUARE)
    assert ids(sea)[0] in seen  # the same plan, the same id: a station need not fetch it again


@pytest.mark.parametrize("way", ["count", "clear", "clear all"])
def test_a_plan_is_cleared(planner: Planner, sea: Sea, way: str) -> None:
    planner.send(SQUARE)
    if way == "count":
        assert planner.send([]) == ITEM_ACCEPTED
    else:
        sea.say(mavlink.MAVLink_mission_clear_all_message(BOAT, 1, 0 if way == "clear" else 255))
        (ack,) = named(sea.run(0.1), "MISSION_ACK")
        assert ack.type == ITEM_ACCEPTED
    assert plan_of(sea) == [] and ids(sea) == (0, 0)


GOOD = [
    at(1, 2),
    at(1, 2, hold_s=30000, radius_m=100),
    Item(LOITER_UNLIMITED),
    Item(LOITER_TIME, (30.0, 0.0, 0.0, NAN)),
    *[Item(frame=frame) for frame in (0, 3, 5, 6, 11)],
    Item(params=(NAN, NAN, NAN, NAN)),
    Item(z=NAN),
]
BAD = [
    (Item(22), UNSUPPORTED_ITEM),  # take-off
    (Item(21), UNSUPPORTED_ITEM),  # land
    (Item(183), UNSUPPORTED_ITEM),  # a servo
    (Item(frame=1), UNSUPPORTED_FRAME),  # local
    (Item(frame=2), UNSUPPORTED_FRAME),  # of no place
    (Item(params=(-1.0, 0.0, 0.0, NAN)), INVALID_PARAM1),
    (Item(params=(30001.0, 0.0, 0.0, NAN)), INVALID_PARAM1),
    (Item(params=(math.inf, 0.0, 0.0, NAN)), INVALID_PARAM1),
    (Item(params=(0.0, -1.0, 0.0, NAN)), INVALID_PARAM2),
    (Item(params=(0.0, 101.0, 0.0, NAN)), INVALID_PARAM2),
    (Item(x=900000001), INVALID_X),
    (Item(x=2**31 - 1), INVALID_X),
    (Item(y=1800000001), INVALID_Y),
    (Item(x=0, y=0), INVALID_Y),  # the Gulf of Guinea, and no place at all
    (Item(SPEED, (2.0, 1.0, -1.0, 0.0)), INVALID_PARAM1),
    (Item(SPEED, (1.0, 0.01, -1.0, 0.0)), INVALID_PARAM2),
    (Item(SPEED, (1.0, 5.1, -1.0, 0.0)), INVALID_PARAM2),
    (Item(SPEED, (1.0, math.inf, -1.0, 0.0)), INVALID_PARAM2),
    (Item(DELAY, (-1.0, 0.0, 0.0, 0.0)), INVALID_PARAM1),
    (at(2001, 0), INVALID_X),  # from the first
]


@pytest.mark.parametrize("item", GOOD, ids=str)
def test_every_supported_item_is_accepted_and_returned(
    planner: Planner, sea: Sea, item: Item
) -> None:
    plan = [at(0, 0), item]
    assert planner.send(plan) == ITEM_ACCEPTED and plan_of(sea) == as_sent(plan)


@pytest.mark.parametrize(("item", "result"), BAD, ids=str)
def test_items_that_a_boat_cannot_sail_end_the_upload_with_their_number(
    planner: Planner, sea: Sea, item: Item, result: int
) -> None:
    planner.send(SQUARE)
    assert planner.send([at(0, 0), item, at(1, 1)]) == result
    assert plan_of(sea) == as_sent(SQUARE)
    (told,) = [text for text in texts(sea.ticks) if text.startswith("Plan refused at item 1: ")]
    assert len(told) <= 50


@pytest.mark.parametrize(
    "items", [[speed(1.0)], [Item(DELAY, (3.0, 0.0, 0.0, 0.0)), at(0, 0)], [Item(201)]], ids=str
)
def test_plans_without_a_first_place_are_refused(
    planner: Planner, sea: Sea, items: list[Item]
) -> None:
    assert planner.send(items) == INVALID and plan_of(sea) == []


def test_a_speed_beyond_the_laws_is_refused() -> None:
    sea = Sea({"LAW_U_MAX": 1.0})
    sea.settle()
    assert Planner(sea).send([at(0, 0), speed(1.01)]) == INVALID_PARAM2
    assert Planner(sea).send([at(0, 0), speed(1.0)]) == ITEM_ACCEPTED


def test_a_second_station_is_refused_while_the_first_sends(planner: Planner, sea: Sea) -> None:
    sea.say(mavlink.MAVLink_mission_count_message(BOAT, 1, 2, 0))
    sea.step()
    other = Planner(sea, station=Station(254, 190))
    assert other.send(SQUARE) == REFUSED
    sea.say(OTHER[0].message(0))
    sea.step()
    sea.say(OTHER[1].message(1))
    (ack,) = sea.step().named("MISSION_ACK")
    assert ack.type == ITEM_ACCEPTED and plan_of(sea) == as_sent(OTHER)
    assert other.send(SQUARE) == ITEM_ACCEPTED and plan_of(sea) == as_sent(SQUARE)


def test_repeated_refusals_are_explained_twice_a_second(planner: Planner, sea: Sea) -> None:
    told = []
    for _ in range(100):
        sea.say(mavlink.MAVLink_mission_count_message(BOAT, 1, 2000, 0))
        tick = sea.step()
        assert [m.type for m in tick.named("MISSION_ACK")] == [NO_SPACE]
        told += texts([tick])
    assert told == ["Plan refused at item 0: too many items"] * 2


def test_two_stations_fetch_at_once(planner: Planner, sea: Sea) -> None:
    planner.send(SQUARE)
    stations = [Station(system, 190) for system in (253, 254)]
    for seq in range(len(SQUARE)):
        for station in stations:
            sea.say(mavlink.MAVLink_mission_request_int_message(BOAT, 1, seq, 0), sender=station)
        given = sea.step().named("MISSION_ITEM_INT")
        assert [(m.seq, m.target_system) for m in given] == [(seq, 253), (seq, 254)]


STRANGER = Station(77, 1)
DURING_AN_UPLOAD: dict[str, Callable[[Sea], object]] = {
    "another's item": lambda sea: sea.say(at(9, 9).message(1), sender=STRANGER),
    "another component's": lambda sea: sea.say(at(9, 9).message(1), sender=Station(GCS, 1)),
    "an item again": lambda sea: sea.say(at(9, 9).message(0)),
    "an item too early": lambda sea: sea.say(at(9, 9).message(2)),
    "of a fence": lambda sea: sea.say(at(9, 9).message(1, kind=1)),
    "to another boat": lambda sea: sea.say(at(9, 9).message(1, target=(3, 1))),
    "another's end": lambda sea: sea.say(
        mavlink.MAVLink_mission_ack_message(BOAT, 1, 15, 0), sender=STRANGER
    ),
    "end of a fence": lambda sea: sea.say(mavlink.MAVLink_mission_ack_message(BOAT, 1, 15, 1)),
    "another's clear of a fence": lambda sea: sea.say(
        mavlink.MAVLink_mission_clear_all_message(BOAT, 1, 1), sender=STRANGER
    ),
}


@pytest.mark.parametrize("trouble", DURING_AN_UPLOAD)
def test_messages_outside_an_upload_change_nothing_in_it(
    planner: Planner, sea: Sea, trouble: str
) -> None:
    plan = [*OTHER, at(7, 7)]
    sea.say(mavlink.MAVLink_mission_count_message(BOAT, 1, 3, 0))
    for seq, item in enumerate(plan):
        sea.step()
        if seq == 1:
            DURING_AN_UPLOAD[trouble](sea)
            sea.step()
        sea.say(item.message(seq))
    sea.step()
    assert plan_of(sea) == as_sent(plan)


@pytest.mark.parametrize("seq", [0, 1, 4, 5, 65535])
def test_late_copies_of_items_change_no_plan(planner: Planner, sea: Sea, seq: int) -> None:
    planner.send(SQUARE)
    sea.say(at(9, 9).message(seq))
    sea.say(at(9, 9).message(seq), sender=STRANGER)
    sea.run(1.0)
    assert plan_of(sea) == as_sent(SQUARE)


def test_a_client_that_missed_the_final_ack_gets_it_again(planner: Planner, sea: Sea) -> None:
    planner.send(SQUARE)
    sea.say(SQUARE[-1].message(len(SQUARE) - 1))
    (ack,) = sea.step().named("MISSION_ACK")
    assert ack.type == ITEM_ACCEPTED


def test_a_sender_that_begins_anew_is_asked_from_the_first_item(planner: Planner, sea: Sea) -> None:
    sea.say(mavlink.MAVLink_mission_count_message(BOAT, 1, 5, 0))
    sea.step()
    sea.say(SQUARE[0].message(0))
    sea.step()
    assert planner.send(OTHER) == ITEM_ACCEPTED and plan_of(sea) == as_sent(OTHER)


def test_damaged_bytes_change_no_plan(planner: Planner, sea: Sea) -> None:
    planner.send(SQUARE)
    dice = random.Random(1)
    opening = sea.gcs.pack(mavlink.MAVLink_mission_count_message(BOAT, 1, 2, 0))
    item = sea.gcs.pack(OTHER[0].message(0))
    for _ in range(300):
        wire = bytearray(opening + item + item)
        for _ in range(dice.randrange(1, 4)):
            wire[dice.randrange(len(opening))] ^= 1 << dice.randrange(8)
        sea.boat.on_mavlink(bytes(wire), sea.now_us)
        sea.step()
    sea.run(10.0)
    assert plan_of(sea) == as_sent(SQUARE)


def test_an_item_that_is_asked_for_in_the_old_form_is_given_in_the_new(
    planner: Planner, sea: Sea
) -> None:
    planner.send(SQUARE)
    sea.say(mavlink.MAVLink_mission_request_message(BOAT, 1, 2, 0))
    (item,) = sea.step().named("MISSION_ITEM_INT")
    assert item.seq == 2


def test_a_request_without_mission_type_means_the_plan(planner: Planner, sea: Sea) -> None:
    """MAVLink 1 has no such field."""
    planner.send(SQUARE)
    payload = bytes([BOAT, 1])
    body = bytes([len(payload), 0, GCS, GCS_COMPONENT, 43]) + payload
    kind = mavlink.MAVLink_mission_request_list_message
    crc = mavlink.x25crc(body + bytes([kind.crc_extra])).crc
    sea.boat.on_mavlink(b"\xfe" + body + crc.to_bytes(2, "little"), sea.now_us)
    (count,) = named(sea.run(0.2), "MISSION_COUNT")
    assert (count.count, count.mission_type) == (5, 0)


@pytest.mark.parametrize("target", [(3, 1), (BOAT, 7), (GCS, 1)])
def test_plan_messages_for_other_systems_or_components_are_ignored(
    planner: Planner, sea: Sea, target: tuple[int, int]
) -> None:
    planner.send(SQUARE)
    sea.say(
        mavlink.MAVLink_mission_request_list_message(*target, 0),
        mavlink.MAVLink_mission_count_message(*target, 3, 0),
        mavlink.MAVLink_mission_clear_all_message(*target, 0),
    )
    ticks = sea.run(0.2)
    assert not named(ticks, "MISSION_COUNT") and not named(ticks, "MISSION_ACK")
    assert plan_of(sea) == as_sent(SQUARE)


@pytest.mark.parametrize(("current", "answer"), [(2, REFUSED), (3, UNSUPPORTED_ITEM)])
def test_go_here_of_ardupilots_clients_changes_no_plan(
    planner: Planner, sea: Sea, current: int, answer: int
) -> None:
    planner.send(SQUARE)
    message = at(9, 9).message(0)
    message.current = current
    sea.say(message)
    (ack,) = sea.step().named("MISSION_ACK")
    assert ack.type == answer and plan_of(sea) == as_sent(SQUARE)


def test_an_acknowledgement_is_not_acknowledged(planner: Planner, sea: Sea) -> None:
    sea.say(mavlink.MAVLink_mission_ack_message(BOAT, 1, 0, 0))
    assert not named(sea.run(0.5), "MISSION_ACK")


def test_only_the_askers_link_gets_the_answer() -> None:
    sea = Sea(links=2)
    sea.settle()
    sea.say(mavlink.MAVLink_mission_request_list_message(BOAT, 1, 0), link=1)
    ticks = sea.run(0.2)
    assert [len(named(ticks, "MISSION_COUNT", link)) for link in (0, 1)] == [0, 1]


def test_a_station_that_may_not_command_reads_the_plan_and_changes_nothing() -> None:
    sea = Sea({"MAV_GCS_SYSID": float(GCS)})
    sea.settle()
    assert Planner(sea).send(SQUARE) == ITEM_ACCEPTED
    stranger = Planner(sea, station=STRANGER)
    assert len(stranger.fetch()) == 5 and stranger.send(OTHER) == REFUSED
    sea.say(mavlink.MAVLink_mission_clear_all_message(BOAT, 1, 0), sender=STRANGER)
    (ack,) = sea.step().named("MISSION_ACK")
    assert ack.type == REFUSED and plan_of(sea) == as_sent(SQUARE)


def test_an_empty_upload_in_the_same_tick_as_auto_begins_nothing() -> None:
    sea = Sea()
    sea.leader.on = False
    assert Planner(sea).send([at(20, 0)]) == ITEM_ACCEPTED
    sea.enter_hold()
    sea.run(0.5)
    empty = mavlink.MAVLink_mission_count_message(BOAT, 1, 0, 0)
    sea.say(empty, command_long(SET_MODE, 1.0, 10.0))
    assert acks(sea.step()) == [(SET_MODE, TEMPORARILY_REJECTED)]
    assert sea.state == "HOLD" and "AUTO" not in texts(sea.ticks)
