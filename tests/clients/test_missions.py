# SPDX-License-Identifier: MIT
"""MAVSDK and MAVProxy send a boat its plan, start it, and follow how far it is."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest
from mavsdk.plugins.mission import Mission
from mavsdk.plugins.mission.mission import MissionError, MissionItem, MissionPlan, MissionResult

from tests.clients.boat import BOTH_IDENTITIES, Sea, Waters
from tests.clients.fleet_sea import FleetSea
from tests.clients.mavproxy_client import MavProxy
from tests.clients.mavsdk_client import MavsdkClient

METRES_TO_DEGREES = 180 / math.pi / 6_371_000
CameraAction, VehicleAction = MissionItem.CameraAction, MissionItem.VehicleAction


pytestmark = BOTH_IDENTITIES


@pytest.fixture
def fleet(autopilot: float) -> Iterator[FleetSea]:
    """Two boats in FORMATION, the second behind the first."""
    with closing(FleetSea(autopilot)) as sea:
        yield sea
        print(sea.words)


class Planner:
    """MAVSDK with its mission plugin."""

    def __init__(self, sea: Waters) -> None:
        self.sdk = MavsdkClient(sea)
        self.mission = Mission(self.sdk.system)
        self._places = self.sdk.watch("position")
        self.progress: list[Any] = []
        self.mission.subscribe_mission_progress(lambda told, _: self.progress.append(told))
        sea.until(lambda: self._places)

    def close(self) -> None:
        self.mission.destroy()
        self.sdk.close()

    def at(self, north_m: float, east_m: float, speed_mps: float = 0.6) -> MissionItem:
        """A waypoint so far from where the boat was heard first."""
        here = self._places[0]
        east = METRES_TO_DEGREES / math.cos(math.radians(here.latitude_deg))
        return MissionItem(
            here.latitude_deg + METRES_TO_DEGREES * north_m,
            here.longitude_deg + east * east_m,
            0.0,
            speed_mps,
            is_fly_through=True,
            gimbal_pitch_deg=math.nan,
            gimbal_yaw_deg=math.nan,
            camera_action=CameraAction.NONE,
            loiter_time_s=math.nan,
            camera_photo_interval_s=math.nan,
            acceptance_radius_m=1.0,
            yaw_deg=math.nan,
            camera_photo_distance_m=math.nan,
            vehicle_action=VehicleAction.NONE,
        )

    def upload(self, *items: MissionItem) -> None:
        self.sdk.call(self.mission.upload_mission, MissionPlan(list(items)))

    def refusal_of(self, function: Any, *arguments: Any) -> MissionResult:
        with pytest.raises(MissionError) as refusal:
            self.sdk.call(function, *arguments)
        result: MissionResult = refusal.value.result
        return result


@pytest.fixture
def planner(fleet: FleetSea, home: Path) -> Iterator[Planner]:
    with closing(Planner(fleet)) as planner:
        yield planner


def test_mavsdk_sends_a_plan_and_reads_the_same(planner: Planner) -> None:
    items = [planner.at(12, 0), planner.at(12, 6, 0.8), planner.at(0, 6)]
    planner.upload(*items)
    read = planner.sdk.call(planner.mission.download_mission).mission_items
    for sent, got in zip(items, read, strict=True):
        assert got.latitude_deg == pytest.approx(sent.latitude_deg, abs=1e-7)
        assert got.longitude_deg == pytest.approx(sent.longitude_deg, abs=1e-7)
        assert got.speed_m_s == pytest.approx(sent.speed_m_s)
        assert got.acceptance_radius_m == sent.acceptance_radius_m
    planner.sdk.call(planner.mission.clear_mission)
    assert planner.sdk.call(planner.mission.download_mission).mission_items == []


def test_mavsdk_starts_a_plan_and_the_second_boat_follows_the_first(
    fleet: FleetSea, planner: Planner
) -> None:
    planner.upload(planner.at(6, 0), planner.at(8, 3), planner.at(10, 3))
    planner.sdk.call(planner.mission.start_mission)
    fleet.until(lambda: fleet.state() == "AUTO")
    assert planner.refusal_of(planner.mission.clear_mission) == MissionResult.DENIED
    fleet.until(lambda: planner.progress and planner.progress[-1].current == 3)
    assert planner.progress[-1].total == 3
    assert planner.sdk.call(planner.mission.is_mission_finished)
    assert [fleet.state(boat) for boat in (1, 2)] == ["AUTO", "FORMATION"]
    before = len(planner.progress)
    planner.sdk.call(planner.mission.start_mission)  # begins the plan again
    fleet.until(lambda: any(told.current < 3 for told in planner.progress[before:]))


def test_mavsdks_pause_stops_the_boat_and_start_goes_on(fleet: FleetSea, planner: Planner) -> None:
    planner.upload(planner.at(20, 0))
    planner.sdk.call(planner.mission.start_mission)
    fleet.until(lambda: fleet.state() == "AUTO")
    planner.sdk.call(planner.mission.pause_mission)
    fleet.until(lambda: fleet.state() == "HOLD")
    planner.sdk.call(planner.mission.start_mission)
    fleet.until(lambda: fleet.state() == "AUTO")


def test_a_boat_without_a_plan_does_not_start(fleet: FleetSea, planner: Planner) -> None:
    assert planner.refusal_of(planner.mission.start_mission) == MissionResult.DENIED
    fleet.until(lambda: any("no plan" in text for text in planner.sdk.texts))
    assert fleet.state() == "FORMATION"


WPL = """QGC WPL 110
0\t0\t0\t16\t0\t0\t0\t0\t47.3977420\t8.5455940\t0\t1
1\t0\t3\t178\t1\t0.8\t-1\t0\t0\t0\t0\t1
2\t0\t3\t16\t0\t0\t0\t0\t47.3979420\t8.5455940\t0\t1
3\t0\t3\t16\t5\t0\t0\t0\t47.3979420\t8.5457940\t0\t1
"""


def test_mavproxy_loads_lists_sets_sails_and_clears_a_plan(
    sea: Sea, ready: MavProxy, tmp_path: Path
) -> None:
    file = tmp_path / "plan.txt"
    file.write_text(WPL)
    ready.tell(f"wp load {file}", "Plan of 4 items stored")
    listed = ready.tell("wp list", "47.3979420000 8.5457940000")
    assert len(re.findall(r"^\d+ \d 47\.39\d+ 8\.54", listed, re.M)) == 3, listed
    ready.tell("wp set 2")
    sea.until(lambda: sea.named("MISSION_CURRENT") and sea.named("MISSION_CURRENT")[-1].seq == 2)
    ready.tell("arm throttle", "ARMED")
    ready.tell("mode AUTO", "Mode AUTO")
    sea.until(lambda: sea.state == "AUTO" and sea.driven())
    ready.tell("mode HOLD", "Mode HOLD")
    sea.until(lambda: sea.state == "HOLD")
    ready.tell("wp clear", "MISSION_ACK: TYPE_MISSION: ACCEPTED")
    ready.tell("mode AUTO", "no plan")


def loop_to(item: int) -> str:
    """The plan with a jump back at its end, twice."""
    return WPL + f"4\t0\t3\t177\t{item}\t2\t0\t0\t0\t0\t0\t1\n"


def test_mavproxy_loads_a_plan_with_a_home_and_a_jump_and_sails_it(
    sea: Sea, ready: MavProxy, tmp_path: Path, autopilot: float
) -> None:
    file = tmp_path / "plan.txt"
    file.write_text(loop_to(2))
    ready.tell(f"wp load {file}", "Plan of 5 items stored")
    listed = ready.tell("wp list", "47.3979420000 8.5457940000")
    assert re.search(r"177 \d 0\.0+ 0\.0+ 0\.0+ p1=2\.0 p2=2\.0", listed), listed
    ready.tell("arm throttle", "ARMED")
    ready.tell("mode AUTO", "Mode AUTO")
    sea.until(lambda: sea.state == "AUTO" and sea.driven())
    # The home is item 0: a place to sail to for a GENERIC autopilot only.
    assert sea.named("MISSION_CURRENT")[-1].total == 5
    first = 2 if autopilot else 0
    sea.until(lambda: sea.named("MISSION_CURRENT")[-1].seq == first)


def test_a_jump_to_the_home_is_a_loop_for_a_generic_autopilot_only(
    sea: Sea, ready: MavProxy, tmp_path: Path, autopilot: float
) -> None:
    file = tmp_path / "plan.txt"
    file.write_text(loop_to(0))
    answer = "Plan refused at item 4" if autopilot else "Plan of 5 items stored"
    ready.tell(f"wp load {file}", answer)
