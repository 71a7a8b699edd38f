# SPDX-License-Identifier: MIT
"""RTL round the fence: the way sailed against the shortest one that scipy finds by the corners."""

from __future__ import annotations

import math

import numpy as np
import pytest
from pymavlink.dialects.v20 import common as mavlink
from scipy.sparse.csgraph import shortest_path

from tests.target.hull import Afloat
from tests.target.operator_words import param_set
from tests.target.plans import (
    CIRCLE_OUT,
    DEGREES_E7_M,
    FENCE,
    ITEM_ACCEPTED,
    KEEP_IN,
    KEEP_OUT,
    RALLY,
    Item,
    at,
    box,
    circle,
    corners,
    rally,
    send,
)
from tests.target.stations import BOAT, FENCE_ENABLE, HOLD, LOITER, ORIGIN, REPOSITION, RTL, origin
from tests.target.test_auto import at_sea, place
from tests.target.test_fence_kept import HULL
from tests.target.test_long_texts import words

NO_WAY = "no path inside the fence: boat waits"
ROUND = "straight path crosses the fence: detour"
Points = list[tuple[float, float]]

WALL: Points = [(8, -12), (8, 9), (12, 9), (12, -12)]
HOOK: Points = [(6, -8), (6, 14), (16, 14), (16, -8), (14, -8), (14, 10), (8, 10), (8, -8)]
BAY: Points = [(-4, -6), (-4, 6), (26, 6), (26, 16), (-4, 16), (-4, 26), (34, 26), (34, -6)]
ROUND_ISLE: Points = [
    (10 + 4 * math.cos(a), 1 + 4 * math.sin(a)) for a in np.linspace(0, 2 * math.pi, 48, False)
]
#: Forbidden zones, permitted zones, and the boat's position; its home is at 0, 0.
CASES: dict[str, tuple[list[Points], list[Points], tuple[float, float]]] = {
    "wall": ([WALL], [], (20, 0)),
    "hook, from inside": ([HOOK], [], (11, 2)),
    "bay": ([], [BAY], (0, 21)),
    "circle": ([ROUND_ISLE], [], (20, 0)),
    "walls and a circle": ([WALL, [(16, 2), (20, 2), (20, 30), (16, 30)]], [], (26, 14)),
}

#: A wall from one side of the permitted water to the other.
BARRIER = [
    *corners(KEEP_OUT, [(8, -30), (8, 30), (12, 30), (12, -30)]),
    *corners(KEEP_IN, [(-5, -28), (-5, 28), (30, 28), (30, -28)]),
]


def items(outs: list[Points], ins: list[Points]) -> list[Item]:
    """The fence of a case; the isle as a true circle."""
    out: list[Item] = []
    for zone in outs:
        is_round = zone is ROUND_ISLE
        out += [circle(10, 1, 4, CIRCLE_OUT)] if is_round else corners(KEEP_OUT, zone)
    for zone in ins:
        out += corners(KEEP_IN, zone)
    return out


def inside(points: np.ndarray, zone: Points) -> np.ndarray:
    """Whether each point is in the polygon: the angles to its corners add up to a full turn."""
    to = np.asarray(zone)[None] - points[:, None]
    angle = np.arctan2(to[..., 1], to[..., 0])
    turn = np.diff(np.concatenate([angle, angle[:, :1]], axis=1), axis=1)
    return np.abs(((turn + np.pi) % (2 * np.pi) - np.pi).sum(axis=1)) > np.pi


def clearance(points: np.ndarray, outs: list[Points], ins: list[Points]) -> np.ndarray:
    """Distance of each point from the nearest boundary, negative in forbidden water."""
    least = np.full(len(points), np.inf)
    for zone, sign in [(z, -1) for z in outs] + [(z, 1) for z in ins]:
        a = np.asarray(zone)
        edge = np.roll(a, -1, axis=0) - a
        to = points[:, None] - a[None]
        along = np.clip((to * edge).sum(-1) / (edge**2).sum(-1), 0, 1)
        d = np.linalg.norm(to - along[..., None] * edge, axis=-1).min(axis=1)
        least = np.minimum(least, np.where(inside(points, zone), sign, -sign) * d)
    return least


def shortest_m(outs: list[Points], ins: list[Points], start: tuple[float, float]) -> float:
    """The shortest way home that touches corners but keeps no distance from them."""
    nodes = np.array([start, (0.0, 0.0), *[p for zone in outs + ins for p in zone]])
    lengths = np.zeros((len(nodes), len(nodes)))
    for i, a in enumerate(nodes):
        for j, b in enumerate(nodes[:i]):
            share = np.linspace(0, 1, 201)[:, None]
            if clearance(a + share * (b - a), outs, ins).min() > -0.01:
                lengths[i, j] = lengths[j, i] = np.linalg.norm(a - b)
    return float(shortest_path(lengths, indices=0)[1])


def go_to(sea: Afloat, north: float, east: float) -> None:
    there = at(north, east)
    go = (BOAT, 1, 6, REPOSITION, 0, 0, 1.0, 1.0, 0, 0, there.x, there.y, 0)
    sea.say(mavlink.MAVLink_command_int_message(*go))
    sea.step()


def set_out(sea: Afloat) -> None:
    """Until the boat has begun to sail south."""
    while place(sea)[0] > 19.0:
        sea.run(0.2)


def close_the_way_home(sea: Afloat, state: str, fence: list[Item]) -> None:
    """Store the fence, and switch it on once the boat is under way to 0, 0 in RTL or GUIDED."""
    assert send(sea, FENCE, fence) == ITEM_ACCEPTED
    sea.order(FENCE_ENABLE, 0.0)
    if state == "RTL":
        sea.mode(RTL)
    else:
        go_to(sea, 0, 0)
    set_out(sea)
    sea.order(FENCE_ENABLE, 1.0)


def away(goal: tuple[float, float]) -> Afloat:
    """A boat that was armed at 0, 0 and lies at `goal`."""
    sea = at_sea([])
    go_to(sea, *goal)
    sea.run(25.0 + 1.5 * math.hypot(*goal))
    assert place(sea) == pytest.approx(goal, abs=0.3)
    sea.mode(HOLD)
    sea.step()
    return sea


@pytest.mark.parametrize("name", CASES)
def test_rtl_sails_the_shortest_way_that_keeps_the_margin(name: str) -> None:
    outs, ins, start = CASES[name]
    least = shortest_m(outs, ins, start)
    sea = away(start)
    assert send(sea, FENCE, items(outs, ins)) == ITEM_ACCEPTED
    sea.mode(RTL)
    track = [place(sea)]
    while math.hypot(*track[-1]) > 0.3 and len(track) < 2000:
        sea.run(0.2)
        track.append(place(sea))
    assert sea.state == "RTL" and ROUND in words(sea.ticks)
    assert len(track) < 2000, track[-1]
    sailed = np.asarray(track)
    assert clearance(sailed, outs, ins).min() > 0.8 * HULL
    length = float(np.linalg.norm(np.diff(sailed, axis=0), axis=1).sum())
    assert 0.95 * least < length < 1.15 * least + 4.0, (length, least)


def test_rtl_keeps_the_margin_from_a_rock_beside_the_straight_way() -> None:
    """In a current, a boat that grazed the rock would drift on to it."""
    rock: Points = [(8, 0.05), (22, 0.05), (22, 8), (8, 8)]
    sea = away((30, 0))
    assert send(sea, FENCE, corners(KEEP_OUT, rock)) == ITEM_ACCEPTED
    sea.mode(RTL)
    track = []
    for _ in range(500):
        sea.hull.current = (0.0, 0.3 * (place(sea)[0] < 21))
        sea.run(0.2)
        track.append(place(sea))
    assert "straight path too near the fence: detour" in words(sea.ticks)
    assert clearance(np.asarray(track), [rock], []).min() > 0.4
    assert sea.state == "RTL" and track[-1] == pytest.approx((0, 0), abs=0.3)


def test_rtl_sails_straight_through_a_gap_narrower_than_the_margin() -> None:
    zones: list[Points] = [[(10, 1), (14, 1), (14, 30), (10, 30)]]
    zones.append([(n, -e) for n, e in zones[0]])
    sea = away((24, 0))
    shore: Points = [(-9, -28), (-9, 28), (33, 28), (33, -28)]
    assert send(sea, FENCE, items(zones, [shore])) == ITEM_ACCEPTED
    sea.mode(RTL)
    sea.run(90.0)
    assert (
        "no detour found: sailing straight, near the fence" in words(sea.ticks)
        and sea.state == "RTL"
    )
    assert place(sea) == pytest.approx((0, 0), abs=0.3)


def test_without_a_way_back_the_boat_waits_and_reports_it() -> None:
    sea = away((20, 0))
    assert send(sea, FENCE, BARRIER) == ITEM_ACCEPTED
    sea.mode(RTL)
    sea.run(10.0)
    assert NO_WAY in words(sea.ticks) and sea.state == "RTL"
    assert place(sea) == pytest.approx((20, 0), abs=0.1)


def test_rtl_without_a_way_sets_out_once_the_fence_is_switched_off() -> None:
    sea = away((20, 0))
    assert send(sea, FENCE, BARRIER) == ITEM_ACCEPTED
    sea.mode(RTL)
    sea.run(35.0)
    assert words(sea.ticks).count(NO_WAY) == 1 and place(sea) == pytest.approx((20, 0), abs=0.1)
    sea.order(FENCE_ENABLE, 0.0)
    sea.run(60.0)
    assert sea.state == "RTL" and place(sea) == pytest.approx((0, 0), abs=0.1)


def test_rtl_finds_its_way_though_the_origin_moves_while_it_searches() -> None:
    north_m = 1000 * DEGREES_E7_M
    sea = away((20, 0))
    assert send(sea, FENCE, corners(KEEP_OUT, WALL)) == ITEM_ACCEPTED
    sea.own.origin_on = False
    sea.mode(RTL)
    for _ in range(4):
        sea.step()
    moved = origin(sea.now_us, ORIGIN[0] - 1000, ORIGIN[1], ORIGIN[2])
    sea.say(moved, sender=sea.own.station)
    sea.hull.q[0] += north_m
    sea.run(90.0)
    assert sea.state == "RTL" and ROUND in words(sea.ticks)
    assert place(sea) == pytest.approx((north_m, 0), abs=0.3)


def test_rtl_is_straight_beyond_the_fences_map() -> None:
    """The fence is a small zone over 4 km away."""
    sea = at_sea([])
    assert send(sea, FENCE, box(1990, 0, 5, KEEP_OUT)) == ITEM_ACCEPTED
    while place(sea)[0] > -2050:
        sea.hull.q[3] = -12.0
        sea.step()
    sea.run(5.0)
    before = place(sea)[0]
    sea.mode(RTL)
    sea.run(30.0)
    assert sea.state == "RTL" and place(sea)[0] > before + 8 and NO_WAY not in words(sea.ticks)


def test_rtl_from_outside_the_fence_sails_home() -> None:
    sea = away((20, 0))
    ring = corners(KEEP_IN, [(-5, -9), (-5, 9), (15, 9), (15, -9)])
    assert send(sea, FENCE, ring) == ITEM_ACCEPTED
    sea.mode(RTL)
    sea.run(70.0)
    assert sea.state == "RTL" and NO_WAY not in words(sea.ticks), words(sea.ticks)
    assert place(sea) == pytest.approx((0, 0), abs=0.3)


def test_a_boat_returns_home_if_no_way_to_a_rally_point_is_straight_but_that_one() -> None:
    sea = away((12, 0))
    fence = corners(KEEP_IN, [(-10, -20), (-10, 20), (40, 20), (40, -20)])
    fence += corners(KEEP_OUT, [(20, -25), (20, 25), (22, 25), (22, -25)])
    assert send(sea, FENCE, fence) == ITEM_ACCEPTED
    assert send(sea, RALLY, [rally(30, 0)]) == ITEM_ACCEPTED
    sea.mode(RTL)
    sea.run(60.0)
    assert sea.state == "RTL" and NO_WAY not in words(sea.ticks)
    assert place(sea) == pytest.approx((0, 0), abs=0.1)


def test_a_boat_in_rtl_finds_a_way_round_a_fence_enabled_later() -> None:
    """The fence is on only when the boat is under way: its straight leg leads through a wall."""
    sea = away((20, 0))
    assert send(sea, FENCE, corners(KEEP_OUT, WALL)) == ITEM_ACCEPTED
    sea.order(FENCE_ENABLE, 0.0)
    sea.mode(RTL)
    set_out(sea)
    assert ROUND not in words(sea.ticks)
    sea.order(FENCE_ENABLE, 1.0)
    track = [place(sea)]
    while math.hypot(*track[-1]) > 0.3 and len(track) < 1000:
        sea.run(0.2)
        track.append(place(sea))
    assert sea.state == "RTL" and words(sea.ticks).count(ROUND) == 1
    assert len(track) < 1000, track[-1]
    assert clearance(np.asarray(track), [WALL], []).min() > 0.8 * HULL


@pytest.mark.parametrize("state", ["RTL", "GUIDED"])
def test_a_boat_in_rtl_waits_if_a_fence_closes_its_way(state: str) -> None:
    sea = away((20, 0))
    close_the_way_home(sea, state, BARRIER)
    sea.run(30.0)
    assert sea.state == state and words(sea.ticks).count(NO_WAY) == 1
    assert place(sea)[0] > 12.5
    waits = place(sea)
    sea.run(5.0)
    assert place(sea) == pytest.approx(waits, abs=0.1)


@pytest.mark.parametrize("repeated", [False, True])
def test_a_boat_that_waits_sets_out_again_when_the_fence_is_switched_off(repeated: bool) -> None:
    sea = away((20, 0))
    close_the_way_home(sea, "GUIDED", BARRIER)
    sea.run(30.0)
    assert NO_WAY in words(sea.ticks) and place(sea)[0] > 12.5
    sea.order(FENCE_ENABLE, 0.0)
    if repeated:
        go_to(sea, 0, 0)
    sea.run(50.0)
    assert place(sea) == pytest.approx((0, 0), abs=0.3)


@pytest.mark.parametrize("state", ["RTL", "GUIDED"])
def test_a_boat_that_waits_finds_a_way_that_opens_though_the_fence_stays(state: str) -> None:
    """The gap beside the wall, 6 m wide, is too narrow for the margin until that is smaller."""
    sea = away((20, 0))
    sea.say(param_set("WP_WIDTH", 4.0))
    wall: Points = [(8, -30), (8, 22), (12, 22), (12, -30)]
    ring: Points = [(-6, -28), (-6, 28), (30, 28), (30, -28)]
    close_the_way_home(sea, state, corners(KEEP_OUT, wall) + corners(KEEP_IN, ring))
    sea.run(25.0)
    assert NO_WAY in words(sea.ticks) and place(sea)[0] > 12.5
    sea.say(param_set("WP_WIDTH", 0.0))
    sea.run(12.0)
    assert sea.state == state and ROUND in words(sea.ticks) and words(sea.ticks).count(NO_WAY) == 1
    sea.run(150.0)
    assert place(sea) == pytest.approx((0, 0), abs=0.3)


def test_a_boat_that_is_on_its_way_to_a_target_sails_round_as_well() -> None:
    sea = away((20, 0))
    assert send(sea, FENCE, corners(KEEP_OUT, WALL)) == ITEM_ACCEPTED
    sea.order(FENCE_ENABLE, 0.0)
    go_to(sea, 2, 1)
    set_out(sea)
    sea.order(FENCE_ENABLE, 1.0)
    track = []
    for _ in range(400):
        sea.run(0.2)
        track.append(place(sea))
    assert sea.state == "GUIDED" and track[-1] == pytest.approx((2, 1), abs=0.3)
    assert clearance(np.asarray(track), [WALL], []).min() > 0.8 * HULL


def test_a_boat_that_leaves_rtl_gives_up_the_search() -> None:
    sea = away((20, 0))
    assert send(sea, FENCE, corners(KEEP_OUT, WALL)) == ITEM_ACCEPTED
    sea.mode(RTL)
    sea.mode(LOITER)
    sea.run(10.0)
    assert sea.state == "LOITER" and ROUND not in words(sea.ticks)
    assert place(sea) == pytest.approx((20, 0), abs=0.1)
