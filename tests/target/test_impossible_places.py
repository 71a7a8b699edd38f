# SPDX-License-Identifier: MIT
"""Impossible trees and slots: FORMATION is refused with the reason; under way, HOLD."""

from __future__ import annotations

from typing import Any

import pytest
from pymavlink.dialects.v20 import common as mavlink

from tests.dialect import dialect
from tests.target.hull import Afloat, Hull
from tests.target.operator_words import param_set
from tests.target.sea import Sea, acks, texts
from tests.target.stations import (
    BOAT,
    FORMATION,
    LEADER,
    LEADER_COMPONENT,
    LOITER,
    SET_MODE,
    Station,
    heartbeat,
)

OTHER = 9
REJECTED = 1  # MAV_RESULT_TEMPORARILY_REJECTED


def reference(
    sea: Sea,
    path: list[int],
    offset_n: tuple[float, float] = (0.0, 0.0),
    offset_b: tuple[float, float] = (0.0, 0.0),
    root: int = LEADER,
    sails: bool = True,
) -> Any:
    """A FORMATION_REFERENCE from a boat with that path and slot."""
    fields = [sea.now_us // 1000, 0, 1, root, OTHER, int(sails), 0, 0, *[0] * 10]
    offsets = [round(1024 * x) for x in (*offset_n, *offset_b)]
    path = path + [0] * (24 - len(path))
    message = dialect().MAVLink_formation_reference_message
    return message(*fields, *offsets[:2], path, *offsets[2:])


def hold(parameters: dict[str, float] | None = None) -> Sea:
    sea = Sea({"FORM_OFS_N": -4.0} | (parameters or {}))
    sea.own.answers_timesync = True  # it does not move as it is driven, but it is not late
    sea.enter_hold()
    return sea


def told(sea: Sea, message: Any, system: int, seconds: float = 1.0) -> None:
    """Send a message ten times a second."""
    station = Station(system, LEADER_COMPONENT)
    for _ in range(round(10 * seconds)):
        message.time_boot_ms = sea.now_us // 1000
        sea.say(message, sender=station)
        sea.run(0.1)


def assert_refused(sea: Sea, why: str) -> None:
    tick = sea.mode(FORMATION)
    assert acks(tick) == [(SET_MODE, REJECTED)]
    assert f"Refused: {why}" in [*texts([tick]), *texts([sea.step()])]
    assert sea.state == "HOLD"


RING = "leaders form a cycle"
TAKEN = "slot is taken, or astern while turning"


def test_leader_that_follows_this_boat_is_not_followed() -> None:
    sea = hold()
    # In the first second these may be messages from before the leader was chosen.
    told(sea, reference(sea, [OTHER, BOAT]), LEADER, 0.9)
    assert sea.condition("leaders_end")
    told(sea, reference(sea, [OTHER, BOAT]), LEADER, 0.3)
    assert not sea.condition("leaders_end")
    assert_refused(sea, RING)


def test_leader_is_heard_among_many_boats_that_sail_alone() -> None:
    sea = hold()
    for number in range(60):
        for system in range(201, 206):
            alone = reference(sea, [], root=system)
            alone.maker, alone.sequence = system, number
            sea.say(alone, sender=Station(system, LEADER_COMPONENT))
        ring = reference(sea, [OTHER, BOAT])
        sea.say(ring, sender=Station(LEADER, LEADER_COMPONENT))
        sea.run(0.1)
    assert_refused(sea, RING)


def test_ring_that_closes_under_way_ends_in_hold() -> None:
    sea = hold()
    sea.mode(FORMATION)
    told(sea, reference(sea, [OTHER, 8]), LEADER)
    assert sea.state == "FORMATION"
    told(sea, reference(sea, [OTHER, 8, BOAT]), LEADER, 0.1)
    assert sea.state == "HOLD" and not any(sea.commands)
    assert f"HOLD: {RING}" in texts(sea.ticks)


def test_ring_that_was_opened_no_longer_prevents_formation() -> None:
    sea = hold()
    told(sea, reference(sea, [OTHER, BOAT]), LEADER, 1.2)
    assert not sea.condition("leaders_end")
    told(sea, reference(sea, [OTHER]), LEADER, 0.2)
    sea.mode(FORMATION)
    assert sea.state == "FORMATION"


def test_a_ring_of_other_boats_does_not_stop_this_one() -> None:
    sea = hold()
    told(sea, reference(sea, [OTHER, BOAT]), OTHER)
    sea.mode(FORMATION)
    assert sea.state == "FORMATION"


@pytest.mark.parametrize("kind", [mavlink.MAV_TYPE_SURFACE_BOAT, mavlink.MAV_TYPE_GENERIC])
@pytest.mark.parametrize("north", [0.0, -0.3, -4.0])
def test_slot_of_zero_is_for_a_virtual_leader_only(kind: int, north: float) -> None:
    sea = hold({"FORM_OFS_N": north})
    sea.leader.beats = False
    sea.say(heartbeat(kind), sender=sea.leader.station)
    sea.run(0.1)
    if kind == mavlink.MAV_TYPE_GENERIC or north < -0.5:
        sea.mode(FORMATION)
        assert sea.state == "FORMATION"
    else:
        assert_refused(sea, TAKEN)
        sea.run(0.1)
        assert any("slot is at the leader" in t for t in texts(sea.ticks))


def test_leader_with_a_place_in_a_formation_is_not_taken_for_a_virtual_one() -> None:
    sea = hold({"FORM_OFS_N": 0.0})
    told(sea, reference(sea, [OTHER]), LEADER)
    assert_refused(sea, TAKEN)


@pytest.mark.parametrize("frame", [0, 1])
def test_two_boats_with_one_slot_are_both_refused(frame: int) -> None:
    sea = hold({"FORM_FRAME": float(frame)})
    slot: dict[str, Any] = {"offset_b" if frame else "offset_n": (-4.0, 0.2)}
    told(sea, reference(sea, [LEADER], **slot, sails=False), OTHER)
    assert_refused(sea, TAKEN)
    assert f"boat {OTHER} has the same slot" in texts(sea.ticks)
    sea.run(3.1)  # it is gone
    sea.mode(FORMATION)
    assert sea.state == "FORMATION"


def test_slot_that_is_taken_under_way_ends_in_hold() -> None:
    sea = hold()
    sea.mode(FORMATION)
    told(sea, reference(sea, [LEADER], (-4.0, 0.6)), OTHER)
    assert sea.state == "FORMATION"
    told(sea, reference(sea, [LEADER], (-4.0, 0.0)), OTHER, 1.8)
    assert sea.state == "FORMATION"  # boats may exchange their slots
    told(sea, reference(sea, [LEADER], (-4.0, 0.0)), OTHER, 2.5)
    assert sea.state == "HOLD"
    told(sea, reference(sea, [LEADER], (-8.0, 0.0)), OTHER, 0.1)
    sea.mode(FORMATION)
    assert sea.state == "FORMATION"


def test_boat_does_not_yield_its_slot_to_a_boat_that_does_not_sail() -> None:
    sea = hold()
    sea.mode(FORMATION)
    told(sea, reference(sea, [LEADER], (-4.0, 0.0), sails=False), OTHER)
    assert sea.state == "FORMATION"


def test_a_followers_slot_does_not_stop_this_boat() -> None:
    """The other boat is refused: its slot is this boat's."""
    sea = hold()
    told(sea, reference(sea, [BOAT, LEADER], (-4.0, 0.0)), OTHER)
    sea.mode(FORMATION)
    assert sea.state == "FORMATION"


def test_same_slot_of_another_root_is_another_slot() -> None:
    sea = hold()
    told(sea, reference(sea, [7], (-4.0, 0.0), root=7), OTHER)
    sea.mode(FORMATION)
    assert sea.state == "FORMATION"


def test_another_slot_may_be_free() -> None:
    sea = hold()
    told(sea, reference(sea, [LEADER], (-4.0, 0.0)), OTHER, 0.2)
    sea.say(param_set("FORM_OFS_E", 2.0))
    told(sea, reference(sea, [LEADER], (-4.0, 0.0)), OTHER, 0.2)
    sea.mode(FORMATION)
    assert sea.state == "FORMATION"


@pytest.mark.parametrize("side_m", [2.0, 1.0, -2.0])
def test_slot_inside_a_turn_that_would_go_astern_ends_in_hold(side_m: float) -> None:
    """The leader turns to starboard on a circle of 1.6 m."""
    sea = Afloat(
        {"FORM_OFS_E": side_m, "FORM_FRAME": 1.0},
        Hull([0.0, side_m, 0.0, 0.0, 0.0, 0.0]),
        leader=lambda t_s: (2.0, 0.3 if t_s > 15.0 else 0.0),
    )
    sea.enter_formation()
    sea.run(14.0)
    assert sea.state == "FORMATION" and sea.snapshot()["in_slot"]
    sea.run(10.0)
    assert (sea.state == "HOLD") == (side_m == 2.0)
    if side_m == 2.0:
        assert any("slot moves astern inside the turn" in t for t in texts(sea.ticks))
        assert_refused(sea, TAKEN)


@pytest.mark.parametrize(
    ("most", "path", "says"), [(3, [9, 8, 7], True), (4, [9, 8, 7], False), (0, [9] * 9, False)]
)
def test_boat_deeper_than_form_depth_reports_it_when_armed(
    most: int, path: list[int], says: bool
) -> None:
    sea = Sea({"FORM_OFS_N": -4.0, "FORM_DEPTH": most})
    told(sea, reference(sea, path), LEADER)
    assert not any("FORM_DEPTH" in text for text in texts(sea.ticks))
    sea.enter_hold()
    told(sea, reference(sea, path), LEADER, 2.0)
    said = [text for text in texts(sea.ticks) if "FORM_DEPTH" in text]
    assert said == ["formation depth 4 exceeds FORM_DEPTH 3"] * says


@pytest.mark.parametrize("north", [0.0, -4.0])
def test_slot_behind_a_vessel_is_judged_while_the_boat_sails_alone(north: float) -> None:
    sea = hold({"FORM_OFS_N": north})
    sea.mode(LOITER)
    sea.leader.beats = False
    sea.say(heartbeat(mavlink.MAV_TYPE_SURFACE_BOAT), sender=sea.leader.station)
    sea.run(0.5)
    assert sea.state == "LOITER"
    told_so = any("slot is at the leader" in t for t in texts(sea.ticks))
    assert told_so == (north == 0.0)
    sea.mode(FORMATION)
    assert sea.state == ("LOITER" if north == 0.0 else "FORMATION")
