# SPDX-License-Identifier: MIT
"""Several losses in one tick: the most careful reaction applies, and a sentence tells why."""

from __future__ import annotations

import pytest
from pymavlink.dialects.v20 import common as mavlink

from tests.target.course import BEHIND, TURN
from tests.target.plans import FENCE, ITEM_ACCEPTED, circle, send
from tests.target.sea import Sea, named, texts
from tests.target.stations import (
    FENCE_ENABLE,
    FORMATION,
    heartbeat,
)

FULL_THRUST = 8191
FAST_MPS = 3.0  # twice LAW_U_MAX


def coasting(**parameters: float) -> Sea:
    """The leader and the ground station fall silent; FORMATION still."""
    sea = Sea({"FS_LEADER_S": 1.0, "FS_COAST_S": 5.0} | parameters, own=BEHIND, leader=TURN)
    gcs = heartbeat(mavlink.MAV_TYPE_GCS)
    sea.say(gcs)
    sea.settle()
    assert send(sea, FENCE, [circle(200, 200, 50)]) == ITEM_ACCEPTED  # the boat is outside
    sea.order(FENCE_ENABLE, 0.0)
    sea.say(gcs)
    sea.arm()
    sea.mode(FORMATION)
    for _ in range(10):
        sea.say(gcs)
        sea.run(0.1)
    assert sea.state == "FORMATION"
    sea.silence("leader")
    sea.say(gcs)
    return sea


def ticks_to_end_of_coast() -> int:
    sea = coasting()
    begun = len(sea.ticks)
    sea.run_until("HOLD", 7.0)
    return len(sea.ticks) - begun


def test_the_loss_of_the_ground_station_at_the_end_of_coast_is_explained() -> None:
    for hundredths in range(595, 603):
        sea = coasting(FS_GCS_S=hundredths / 100)
        sea.run_until("HOLD", 7.0)
        told = named(sea.ticks[-1:], "STATUSTEXT")
        assert [m.text for m in told] != ["HOLD"], (hundredths, told[0].severity)


@pytest.mark.parametrize("act", [0.0, 1.0, 2.0])
def test_the_fence_at_the_end_of_coast_is_explained(act: float) -> None:
    end = ticks_to_end_of_coast()
    sea = coasting(FS_FENCE_ACT=act)
    for _ in range(end - 2):
        sea.step()
    assert sea.state == "COAST"
    sea.order(FENCE_ENABLE, 1.0)
    sea.step()
    (told,) = texts(sea.ticks[-1:])
    assert told.startswith(f"{sea.state}: "), told


@pytest.mark.parametrize("act", [1.0, 2.0])
def test_the_most_careful_reaction_applies_at_the_end_of_coast(act: float) -> None:
    """FS_COAST_ACT is HOLD, which is more careful than LOITER and RTL."""
    end = ticks_to_end_of_coast()
    sea = coasting(FS_FENCE_ACT=act)
    for _ in range(end - 2):
        sea.step()
    sea.order(FENCE_ENABLE, 1.0)
    sea.step()
    assert sea.state == "HOLD"


def test_ground_stations_lost_in_coast_lead_to_hold_without_sticks() -> None:
    """The leader returns; the boat coasts on only because no ground station is heard."""
    sea = coasting(FS_GCS_S=1.5, FS_GCS_ACT=2.0, FS_COAST_ACT=1.0)
    sea.run(3.0)
    sea.leader.on = True
    seen = set()
    for _ in range(400):
        sea.step()
        seen.add(sea.state)
    assert "LOITER" not in seen, seen


def test_a_leader_lost_in_coast_leads_to_hold_without_sticks() -> None:
    """FS_LEADER_ACT 2 leads to HOLD in FORMATION; here FORMATION became COAST before."""
    sea = Sea(
        {"FS_LEADER_ACT": 2.0, "FS_GCS_S": 1.0, "FS_GCS_ACT": 1.0, "FS_COAST_ACT": 1.0},
        own=BEHIND,
        leader=TURN,
    )
    sea.say(heartbeat(mavlink.MAV_TYPE_GCS))
    sea.settle()
    sea.say(heartbeat(mavlink.MAV_TYPE_GCS))
    sea.arm()
    sea.mode(FORMATION)
    sea.run_until("COAST", 1.5)
    sea.silence("leader")
    sea.run(1.5)
    assert not sea.condition("leader_fresh")
    assert sea.state == "HOLD"
