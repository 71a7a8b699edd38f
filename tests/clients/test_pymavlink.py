# SPDX-License-Identifier: MIT
"""A script with pymavlink's mavutil finds where a boat is, and changes its mode."""

from __future__ import annotations

import math
import threading
from collections.abc import Callable, Iterator
from contextlib import closing
from typing import Any

import pytest
from pymavlink import mavutil

from tests.clients.boat import BOTH_IDENTITIES, Sea
from tests.linux.process import LOOPBACK
from tests.target.stations import BOAT, ORIGIN

pytestmark = BOTH_IDENTITIES


class Script:
    """A connection of mavutil, whose calls block in a thread while the sea runs on."""

    def __init__(self, sea: Sea) -> None:
        self.sea = sea
        self.link = mavutil.mavlink_connection(
            f"udpin:{LOOPBACK}:{sea.port}", source_system=250, dialect="common"
        )

    def close(self) -> None:
        self.link.close()

    def call(self, function: Callable[..., Any], *arguments: Any) -> Any:
        results: list[Any] = []
        thread = threading.Thread(target=lambda: results.append(function(*arguments)), daemon=True)
        thread.start()
        self.sea.until(lambda: results)
        return results[0]


@pytest.fixture
def script(sea: Sea) -> Iterator[Script]:
    with closing(Script(sea)) as script:
        script.call(script.link.wait_heartbeat)
        yield script


def test_location_comes_back_with_the_units_fix_and_the_boats_heading(
    sea: Sea, script: Script
) -> None:
    sea.own.tells_fix = True
    here = script.call(script.link.location)
    assert here.lat == pytest.approx(1e-7 * ORIGIN[0])  # the unit's raw fix
    assert here.lng == pytest.approx(1e-7 * ORIGIN[1])
    assert here.alt == pytest.approx(1e-3 * ORIGIN[2], abs=0.01)
    assert here.heading == pytest.approx(math.degrees(sea.own.course.psi), abs=1.0)


def test_modes_are_rovers_by_name(sea: Sea, script: Script) -> None:
    assert script.link.target_system == BOAT
    names = script.link.mode_mapping()
    assert {names["HOLD"], names["FOLLOW"], names["AUTO"], names["GUIDED"]} == {4, 6, 10, 15}
    sea.until(lambda: sea.armable)
    script.link.arducopter_arm()
    sea.until(lambda: sea.armed)
    for mode in ("GUIDED", "LOITER", "HOLD"):
        script.link.set_mode(mode)
        sea.until(lambda mode=mode: sea.state == mode)


def plan_with_home_and_jump(jump_to: int) -> list[Any]:
    """As ArduPilot's clients send it: the home over sea level, two places, and twice back."""
    item = mavutil.mavlink.MAVLink_mission_item_int_message
    x, y = ORIGIN[0], ORIGIN[1]
    rows = [
        (0, 16, (0.0, 0.0), x, y),
        (3, 16, (0.0, 0.0), x + 1000, y),
        (3, 16, (0.0, 0.0), x + 1000, y + 1000),
        (2, 177, (float(jump_to), 2.0), 0, 0),
    ]
    return [
        item(BOAT, 1, seq, frame, command, 0, 1, *params, 0.0, 0.0, place_x, place_y, 0.0, 0)
        for seq, (frame, command, params, place_x, place_y) in enumerate(rows)
    ]


def upload(link: Any, items: list[Any]) -> int:
    """The MISSION_ACK's type, as a script of mavutil gets it."""
    link.mav.mission_count_send(BOAT, 1, len(items), 0)
    while True:
        asked = link.recv_match(
            type=["MISSION_REQUEST", "MISSION_REQUEST_INT", "MISSION_ACK"], blocking=True
        )
        if asked.get_type() == "MISSION_ACK":
            return int(asked.type)
        link.mav.send(items[asked.seq])


def download(link: Any, count: int) -> list[tuple[Any, ...]]:
    """The plan that the boat returns, item by item."""
    got = []
    for seq in range(count):
        link.mav.mission_request_int_send(BOAT, 1, seq, 0)
        told = link.recv_match(type="MISSION_ITEM_INT", blocking=True)
        got.append((told.seq, told.frame, told.command, told.param1, told.param2, told.x, told.y))
    return got


def test_a_plan_with_a_home_and_a_jump_is_taken_and_given_back(script: Script) -> None:
    items = plan_with_home_and_jump(1)
    assert script.call(upload, script.link, items) == mavutil.mavlink.MAV_MISSION_ACCEPTED
    sent = [(m.seq, m.frame, m.command, m.param1, m.param2, m.x, m.y) for m in items]
    assert script.call(download, script.link, len(items)) == sent


def test_a_jump_beyond_the_plan_or_to_a_home_is_refused(script: Script, autopilot: float) -> None:
    """To a GENERIC autopilot the home is a waypoint like any other."""
    invalid = mavutil.mavlink.MAV_MISSION_INVALID_PARAM1
    assert script.call(upload, script.link, plan_with_home_and_jump(7)) == invalid
    answer = script.call(upload, script.link, plan_with_home_and_jump(0))
    assert answer == (invalid if autopilot else mavutil.mavlink.MAV_MISSION_ACCEPTED)
