# SPDX-License-Identifier: MIT
"""Leaders and boats that report their positions in other messages than `diamond`'s."""

from collections.abc import Sequence

import numpy as np
import pytest
from pymavlink.dialects.v20 import common as mavlink

from sil.lockstep import metrics
from sil.results.results_readme import WANTED
from sil.scenario import scenario
from sil.scenario.wiring import VIRTUAL_LEADER_SYSTEM
from sil.wire.navigation_unit import NavigationUnit
from tests.each_push import few
from tests.loop.conftest import Sail
from tests.loop.objects import ObjectWorld


@pytest.mark.parametrize("name", ["leader_global", "leader_follow_target", "leader_far_origin"])
def test_the_formation_closes_up_behind_a_leader_that_sends_other_messages(
    sail: Sail, name: str
) -> None:
    run = sail(name)
    late_m = metrics.distances(run.trace["error"])[12_000:].max(axis=0)
    # Measured: half of that; the resolution of degE7 and cm/s is about a centimetre.
    assert (late_m <= WANTED[name]).all(), late_m
    assert [seconds.keys() for seconds in run.states] == [{"FORMATION"}] * 4


@pytest.mark.parametrize(
    "unit",
    [
        ["message='global'", "rate_hz=5", "attitude_rate_hz=10"],
        ["message='follow_target'", "rate_hz=10"],
    ],
)
def test_boats_with_units_that_send_global_positions_keep_the_formation(
    sail: Sail, unit: Sequence[str]
) -> None:
    run = sail("diamond", "duration_s=80", *(f"navigation.{key}" for key in unit))
    assert (metrics.distances(run.trace["error"])[-1] < 0.017).all()
    assert [seconds.keys() for seconds in run.states] == [{"FORMATION"}] * 4


def test_boats_whose_origins_are_kilometres_apart_keep_the_formation(sail: Sail) -> None:
    apart = [
        "boat.1.navigation.origin_m=[2000, 0]",
        "boat.2.navigation.origin_m=[-1000, 2000]",
        "boat.4.navigation.origin_m=[0, -2500]",
    ]
    together = sail("diamond", "duration_s=60").trace["error"]
    distance = np.abs(sail("diamond", "duration_s=60", *apart).trace["error"] - together)
    assert distance[..., :2].max() < 0.0025
    assert metrics.wrap(distance[..., 2]).max() < 5e-5


class TwoUnits(NavigationUnit):
    """A unit that also sends FOLLOW_TARGET, and stops one of the two messages for a while."""

    def __init__(self, local: NavigationUnit, target: NavigationUnit, silent: range) -> None:
        self._units, self._silent = (local, target), silent
        self.ticks = 0

    def on_mavlink(self, data: bytes, now_us: int) -> None:
        self._units[0].on_mavlink(data, now_us)

    def tick(self, now_us: int, eta: Sequence[float], nu: Sequence[float]) -> bytes:
        self.ticks += 1
        local, target = (unit.tick(now_us, eta, nu) for unit in self._units)
        return target if self.ticks in self._silent else local + target


def test_a_leader_whose_local_position_stops_and_comes_back_is_followed_without_a_jolt() -> None:
    both = ["duration_s=45", "link.delay_s=0.1", "clocks.offset_s=1000"]
    worlds = [ObjectWorld(scenario.load("diamond", both)) for _ in range(2)]
    leader = worlds[1].leader
    settings = scenario.load("leader_follow_target").leader_unit()
    target = NavigationUnit(
        VIRTUAL_LEADER_SYSTEM, 1, vehicle_type=0, origin=leader._unit._origin, settings=settings
    )
    leader._unit = TwoUnits(leader._unit, target, range(3500, 4000))
    plain, changed = (world.run() for world in worlds)
    assert worlds[0].records != worlds[1].records
    assert changed.states[0].keys() == {"FORMATION"}
    # The two differ by 5 mm; a restarted track would be off by 60 mm or 0.1 s.
    difference = (changed.trace["error"] - plain.trace["error"])[3000:, 0]
    assert np.abs(difference[:, :2]).max() < 0.011
    step_N = np.abs(np.diff(changed.trace["thrust"][3000:, 0], axis=0)).max()
    assert step_N < 0.11, step_N


def odometry(frame: int, now_us: int, x: float) -> bytes:
    unknown = [float("nan")] + [0.0] * 20
    message = mavlink.MAVLink_odometry_message(
        *(now_us, frame, mavlink.MAV_FRAME_BODY_FRD),
        *(x, 0.0, 0.0, (1.0, 0.0, 0.0, 0.0), 1.0, 0.0, 0.0, 0.0, 0.0, 0.0),
        *(unknown, unknown),
    )
    return bytes(message.pack(mavlink.MAVLink(None, VIRTUAL_LEADER_SYSTEM, 1)))


@pytest.mark.parametrize(
    "frame",
    few([mavlink.MAV_FRAME_LOCAL_FRD, mavlink.MAV_FRAME_LOCAL_FLU], [mavlink.MAV_FRAME_LOCAL_FRD]),
)
def test_odometry_without_north_is_refused_as_a_pose_and_reported(frame: int) -> None:
    world = ObjectWorld(scenario.load("diamond", ["duration_s=12"]))
    leader, boat = world.leader, world.boats[0]
    unit, said = leader._unit, b""
    tell = unit.tick

    def with_odometry(now_us: int, eta: Sequence[float], nu: Sequence[float]) -> bytes:
        nonlocal said
        said += boat.sent
        return tell(now_us, eta, nu) + odometry(frame, now_us, 500.0)

    unit.tick = with_odometry
    run = world.run()
    texts = {
        m.text for m in mavlink.MAVLink(None).parse_buffer(said) if m.get_type() == "STATUSTEXT"
    }
    assert "ODOMETRY refused: frame is not north-aligned" in texts
    counters = boat.boat.snapshot()["counters"]
    assert counters["mavlink_bad_frame"] > 1200
    undisturbed = ObjectWorld(scenario.load("diamond", ["duration_s=12"])).run()
    assert np.array_equal(run.trace["eta"], undisturbed.trace["eta"])
