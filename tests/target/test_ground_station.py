# SPDX-License-Identifier: MIT
"""FS_GCS_S: a boat that requires a ground station, and which ones count."""

from __future__ import annotations

import pytest
from pymavlink.dialects.v20 import common as mavlink

from tests.target.course import BEHIND, TURN
from tests.target.operator_words import sticks
from tests.target.sea import Sea, Tick, texts
from tests.target.stations import ARM, BOAT, FORMATION, GCS, Station, heartbeat

TYPE_GCS = mavlink.MAV_TYPE_GCS
LOST = "no ground station is heard"


class Watched(Sea):
    """A sea whose ground station sends a HEARTBEAT every second while `on`."""

    def __init__(self, parameters: dict[str, float], links: int = 1) -> None:
        super().__init__({"FS_GCS_S": 3.0} | parameters, links, own=BEHIND, leader=TURN)
        self.on, self.beats_as, self.kind, self.link = True, Station(GCS, 190), TYPE_GCS, 0
        self.next_beat_us = self.now_us

    def step(self) -> Tick:
        if self.on and self.now_us >= self.next_beat_us:
            self.next_beat_us = self.now_us + 1_000_000
            self.say(heartbeat(self.kind), sender=self.beats_as, link=self.link)
        return super().step()


def sailing(parameters: dict[str, float] | None = None) -> Watched:
    sea = Watched(parameters or {})
    sea.enter_formation()
    sea.run(1.0)
    assert sea.state == "FORMATION" and any(sea.commands)
    return sea


@pytest.mark.parametrize(
    ("action", "state"), [(0.0, "HOLD"), (1.0, "COAST"), (2.0, "HOLD")], ids=["0", "1", "2"]
)
def test_a_boat_that_hears_no_ground_station_takes_the_chosen_action(
    action: float, state: str
) -> None:
    sea = sailing({"FS_GCS_ACT": action})
    sea.on = False
    last_us = sea.next_beat_us - 1_000_000
    sea.run_until(state, 3.1)
    assert abs(sea.ticks[-1].now_us - last_us - 3_000_000) <= sea.period_us
    assert texts([sea.ticks[-1]]) == [f"{state}: {LOST}"]


def test_an_operator_with_sticks_keeps_driving_without_a_ground_station() -> None:
    sea = sailing({"FS_GCS_ACT": 2.0})
    sea.on = False
    for _ in range(320):
        sea.say(sticks(100, 0))
        sea.step()
    assert sea.state == "MANUAL" and any(sea.commands)


def test_coast_ends_when_the_ground_station_is_heard_or_its_time_is_over() -> None:
    for heard in (True, False):
        sea = sailing({"FS_GCS_ACT": 1.0})
        sea.on = False
        sea.run_until("COAST", 3.1)
        sea.run(2.0)
        sea.on = heard
        sea.run(0.1 if heard else 3.1)
        assert sea.state == ("FORMATION" if heard else "HOLD")


def test_of_two_losses_the_more_careful_choice_counts() -> None:
    sea = sailing({"FS_LEADER_ACT": 1.0, "FS_GCS_ACT": 0.0})
    sea.on = False
    sea.run(1.5)
    sea.leader.on = False
    sea.run_until("COAST", 1.2)
    sea.run_until("HOLD", 1.0)
    assert texts([sea.ticks[-1]]) == [f"HOLD: {LOST}"]


def test_a_boat_that_requires_a_ground_station_does_not_arm_without_one() -> None:
    sea = Watched({})
    sea.on = False
    sea.settle()
    tick = sea.arm()
    assert sea.state == "DISARMED" and texts([tick]) == [f"PreArm: {LOST}"]
    sea.on = True
    sea.run(0.1)
    sea.arm()
    assert sea.state == "HOLD"


def test_with_fs_gcs_s_0_no_ground_station_is_required() -> None:
    sea = Watched({"FS_GCS_S": 0.0})
    sea.on = False
    sea.enter_formation()
    sea.run(10.0)
    assert sea.state == "FORMATION" and sea.condition("gcs_heard")


@pytest.mark.parametrize("kind", [mavlink.MAV_TYPE_SURFACE_BOAT, mavlink.MAV_TYPE_GENERIC])
def test_heartbeats_of_other_types_are_no_ground_station(kind: int) -> None:
    sea = Watched({})
    sea.kind = kind
    sea.run(2.0)
    assert not sea.condition("gcs_heard")


def test_with_mav_gcs_sysid_only_that_ground_station_counts() -> None:
    sea = Watched({"MAV_GCS_SYSID": 250.0})
    sea.run(2.0)
    assert not sea.condition("gcs_heard")
    sea.beats_as = Station(250, 190)
    sea.run(2.0)
    assert sea.condition("gcs_heard")
    sea.order(ARM, 1.0)
    assert sea.state == "DISARMED"


def test_a_ground_station_on_board_does_not_count() -> None:
    sea = sailing()
    sea.beats_as = Station(BOAT, 190)
    sea.run(3.0)
    assert sea.state == "HOLD"


def test_a_ground_station_on_any_link_counts() -> None:
    sea = Watched({}, links=2)
    sea.link = 1
    sea.run(2.0)
    assert sea.condition("gcs_heard")


def test_where_signatures_are_required_an_unsigned_heartbeat_does_not_count() -> None:
    sea = Watched({}, links=2)
    sea.boat.secure(bytes(range(32)), 1_790_000_000 * 1_000_000)
    sea.boat.set_signing(1, "required")
    sea.link = 1
    sea.run(2.0)
    assert not sea.condition("gcs_heard")
    assert sea.mode(FORMATION) and sea.state == "DISARMED"
