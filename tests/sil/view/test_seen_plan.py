# SPDX-License-Identifier: MIT
"""Plans, fences and rally points as they pass by, told by pymavlink's messages."""

import math
from collections.abc import Iterable
from pathlib import Path
from typing import TypeAlias

import pytest
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from sil.scenario.wiring import ORIGIN, WORLD
from sil.view.page import page_with
from sil.view.seen_fleet import Fleet
from sil.view.seen_plan import FENCE, MISSION, RALLY, Plans
from sil.view.tlog_history import history_of_tlog
from sil.wire.mavlink_ear import Ear

BOAT, STATION = 1, 255
Said: TypeAlias = mavlink.MAVLink_message


def packed(message: Said, system: int) -> bytes:
    data: bytes = message.pack(mavlink.MAVLink(None, system, 1 if system == BOAT else 190))
    return data


def item(
    seq: int, at: tuple[float, float], command: int = 16, first: float = 0.0, kind: int = MISSION,
    target: int = BOAT,
) -> Said:  # fmt: skip
    place = WORLD.geodetic(*at, 0.0)
    return mavlink.MAVLink_mission_item_int_message(
        target, 1, seq, 6, command, 0, 1, first, 0, 0, math.nan, place.latitude, place.longitude,
        0, kind,
    )  # fmt: skip


def count(number: int, kind: int = MISSION, target: int = BOAT) -> Said:
    return mavlink.MAVLink_mission_count_message(target, 1, number, kind)


def ack(result: int = 0, kind: int = MISSION) -> Said:
    return mavlink.MAVLink_mission_ack_message(STATION, 190, result, kind)


HEARTBEAT = mavlink.MAVLink_heartbeat_message(11, 0, 1, 0, 3, 3)
ORIGIN_TOLD = mavlink.MAVLink_gps_global_origin_message(*ORIGIN, 0)
WAY = [(10.0, 0.0), (10.0, 20.0), (-5.0, 20.0)]


def sent(plan: Iterable[Said], kind: int = MISSION) -> list[tuple[Said, int]]:
    """A station sends a boat its plan."""
    items = list(plan)
    said = [(count(len(items), kind), STATION), *((one, STATION) for one in items)]
    return [*said, (ack(kind=kind), BOAT)]


def heard(said: Iterable[tuple[Said, int]]) -> Fleet:
    fleet, ear = Fleet(1.2), Ear(stream=False)
    for message, system in [(HEARTBEAT, BOAT), (ORIGIN_TOLD, BOAT), *said]:
        fleet.hear(ear.hear(packed(message, system)), 1.0)
    return fleet


def plan_of(fleet: Fleet) -> list[list[float]]:
    way: list[list[float]] = fleet.drawn_plans().get(BOAT, {}).get("way", [])
    return way


def way(numbers: Iterable[int] = (0, 1, 2)) -> list[object]:
    return [
        pytest.approx([*place, number], abs=0.02)
        for place, number in zip(WAY, numbers, strict=False)
    ]


UPLOAD = sent(item(seq, place) for seq, place in enumerate(WAY))


def test_an_accepted_plan_is_drawn_where_it_leads() -> None:
    assert plan_of(heard(UPLOAD)) == way()


def test_a_change_of_speed_is_not_drawn_as_a_waypoint() -> None:
    speed = item(0, (0.0, 0.0), mavlink.MAV_CMD_DO_CHANGE_SPEED)
    plan = [speed, *(item(seq, place) for seq, place in enumerate(WAY, start=1))]
    assert plan_of(heard(sent(plan))) == way((1, 2, 3))


@pytest.mark.parametrize(
    "said",
    [
        UPLOAD[:-1],  # no answer
        [*UPLOAD[:-1], (ack(mavlink.MAV_MISSION_INVALID), BOAT)],
        [*UPLOAD[:2], *UPLOAD[3:]],  # an item is missing
        [*UPLOAD[:-1], (ack(kind=FENCE), BOAT)],
    ],
)
def test_a_plan_that_is_not_accepted_changes_nothing(said: list[tuple[Said, int]]) -> None:
    assert plan_of(heard(said)) == []
    assert plan_of(heard([*UPLOAD, *said])) == way()


def test_a_plan_downloaded_from_the_boat_is_drawn() -> None:
    told = [item(seq, place, target=STATION) for seq, place in enumerate(WAY)]
    said = [(count(3, target=STATION), BOAT), *((one, BOAT) for one in told)]
    assert plan_of(heard(said)) == way() and plan_of(heard(said[:-1])) == []
    assert plan_of(heard([*said, (count(0, target=STATION), BOAT)])) == []


@pytest.mark.parametrize("kind", [MISSION, 255])
def test_a_cleared_plan_is_gone(kind: int) -> None:
    clear = mavlink.MAVLink_mission_clear_all_message(BOAT, 1, kind)
    fleet = heard([*UPLOAD, (clear, STATION)])
    assert plan_of(fleet) == way()
    assert plan_of(heard([*UPLOAD, (clear, STATION), (ack(), BOAT)])) == []


def test_fences_and_rally_points_are_drawn() -> None:
    corners = [(0.0, 0.0), (30.0, 0.0), (30.0, 30.0)]
    fence = [item(k, at, 5001, 3.0, FENCE) for k, at in enumerate(corners)]
    fence += [item(3, (5.0, 5.0), 5004, 2.5, FENCE), item(4, (9.0, 9.0), 5003, 40.0, FENCE)]
    fence += [item(5 + k, at, 5002, 3.0, FENCE) for k, at in enumerate(corners)]
    rally = [item(0, (1.0, 2.0), 5100, 0.0, RALLY)]
    told = heard([*sent(fence, FENCE), *sent(rally, RALLY)]).drawn_plans()[BOAT]
    places = [pytest.approx(list(at), abs=0.02) for at in corners]
    assert told["fence"] == [
        {"inside": True, "points": places},
        {"inside": False, "centre": pytest.approx([5.0, 5.0], abs=0.02), "radius_m": 2.5},
        {"inside": True, "centre": pytest.approx([9.0, 9.0], abs=0.02), "radius_m": 40.0},
        {"inside": False, "points": places},
    ]
    assert told["rally"] == [pytest.approx([1.0, 2.0], abs=0.02)] and told["way"] == []


@pytest.mark.parametrize("radius_m", [math.nan, math.inf, -math.inf, 0.0, -3.0])
def test_a_circle_without_a_radius_is_left_out(radius_m: float, tmp_path: Path) -> None:
    fence = [item(0, (5.0, 5.0), 5004, radius_m, FENCE), item(1, (9.0, 9.0), 5003, 40.0, FENCE)]
    (circle,) = heard(sent(fence, FENCE)).drawn_plans()[BOAT]["fence"]
    assert circle["radius_m"] == 40.0
    data = b"".join(
        (1_700_000_000_000_000 + 1_000_000 * t_s).to_bytes(8, "big") + packed(message, system)
        for t_s, (message, system) in enumerate(
            [(HEARTBEAT, BOAT), (ORIGIN_TOLD, BOAT), *sent(fence, FENCE)]
        )
    )
    path = tmp_path / "boat.tlog"
    path.write_bytes(data)
    assert page_with(history_of_tlog(path), "a boat")


def test_the_item_ahead_is_reported() -> None:
    current = mavlink.MAVLink_mission_current_message(2)
    (vessel,) = heard([*UPLOAD, (current, BOAT)]).vessels(1.0)
    assert vessel["item"] == 2


def test_a_silent_boat_keeps_its_plan_and_a_vessel_that_is_forgotten_does_not() -> None:
    fleet = heard(UPLOAD)
    assert len(fleet.vessels(62.0)) == 1 and plan_of(fleet) == way()
    px4 = mavlink.MAVLink_heartbeat_message(11, mavlink.MAV_AUTOPILOT_PX4, 1, 0, 3, 3)
    fleet = heard([(px4, BOAT), *UPLOAD])
    assert fleet.vessels(62.0) == [] and fleet.drawn_plans() == {}


def test_impossible_counts_and_items_start_no_transfer() -> None:
    plans = Plans(lambda system: system == BOAT)
    ear = Ear(stream=False)
    for message in (count(65535), item(65000, (0.0, 0.0))):
        for one in ear.hear(packed(message, STATION)):
            plans.hear(one)
    assert not plans._drafts


def test_a_tlogs_history_has_plans_over_time(tmp_path: Path) -> None:
    data, t_us = b"", 1_700_000_000_000_000
    current = mavlink.MAVLink_mission_current_message(1)
    for message, system in [(HEARTBEAT, BOAT), (ORIGIN_TOLD, BOAT), *UPLOAD, (current, BOAT)]:
        t_us += 1_000_000
        data += t_us.to_bytes(8, "big") + packed(message, system)
    path = tmp_path / "boat.tlog"
    path.write_bytes(data)
    told = history_of_tlog(path)
    (boat,) = [vessel for vessel in told["vessels"] if vessel["id"] == BOAT]
    ((at_s, plan),) = boat["plans"]
    assert at_s == 6.0 and plan["way"] == way()
    assert boat["items"] == [[7.0, 1]]
