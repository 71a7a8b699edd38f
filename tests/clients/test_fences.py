# SPDX-License-Identifier: MIT
"""MAVSDK and MAVProxy send a boat its fence and its rally points."""

from __future__ import annotations

import math
from contextlib import closing
from pathlib import Path

import pytest
from mavsdk.plugins.geofence import Geofence
from mavsdk.plugins.geofence.geofence import (
    Circle,
    FenceType,
    GeofenceData,
    GeofenceError,
    GeofenceResult,
    Point,
    Polygon,
)

from tests.clients.boat import BOTH_IDENTITIES, Sea
from tests.clients.mavproxy_client import MavProxy
from tests.clients.mavsdk_client import MavsdkClient

pytestmark = BOTH_IDENTITIES

LATITUDE, LONGITUDE = 47.3977420, 8.5455940
DEGREES = 180 / math.pi / 6_371_000


def point(north_m: float, east_m: float) -> Point:
    east = DEGREES / math.cos(math.radians(LATITUDE))
    return Point(LATITUDE + DEGREES * north_m, LONGITUDE + east * east_m)


def square(half_m: float, kind: FenceType) -> Polygon:
    signs = [(-1, -1), (-1, 1), (1, 1), (1, -1)]
    return Polygon([point(n * half_m, e * half_m) for n, e in signs], kind)


def test_mavsdk_sends_a_geofence_and_clears_it(sea: Sea, home: Path) -> None:
    with closing(MavsdkClient(sea)) as sdk, ClosingFence(sdk) as fence:
        data = GeofenceData(
            [square(80, FenceType.INCLUSION), square(5, FenceType.EXCLUSION)],
            [Circle(point(0, 0), 120.0, FenceType.INCLUSION)],
        )
        sdk.call(fence.upload_geofence, data)
        sea.until(lambda: any("Fence of 9 items stored" in text for text in sdk.texts))
        sea.until(lambda: sea.named("FENCE_STATUS"))
        bow_tie = Polygon([point(0, 0), point(9, 9), point(0, 9), point(9, 0)], FenceType.INCLUSION)
        with pytest.raises(GeofenceError) as refusal:
            sdk.call(fence.upload_geofence, GeofenceData([bow_tie], []))
        assert refusal.value.result == GeofenceResult.INVALID_ARGUMENT
        sdk.call(fence.clear_geofence)
        told = len(sea.named("FENCE_STATUS"))
        sea.until(lambda: True)
        assert len(sea.named("FENCE_STATUS")) <= told + 1


class ClosingFence:
    """MAVSDK's plugin, destroyed at the end."""

    def __init__(self, sdk: MavsdkClient) -> None:
        self.plugin = Geofence(sdk.system)

    def __enter__(self) -> Geofence:
        return self.plugin

    def __exit__(self, *_: object) -> None:
        self.plugin.destroy()


def lines(items: list[tuple[int, float, float, float]]) -> str:
    """Items in the format of mission files: command, parameter 1, metres north and east."""
    rows = ["QGC WPL 110"]
    for seq, (command, param, north_m, east_m) in enumerate(items):
        at = point(north_m, east_m)
        rows.append(
            f"{seq}\t0\t3\t{command}\t{param}\t0\t0\t0"
            f"\t{at.latitude_deg:.7f}\t{at.longitude_deg:.7f}\t0\t1"
        )
    return "\n".join(rows) + "\n"


def test_mavproxy_loads_lists_switches_and_clears_a_fence(ready: MavProxy, tmp_path: Path) -> None:
    file = tmp_path / "fence.txt"
    file.write_text(
        lines([(5001, 3, -50, -50), (5001, 3, -50, 50), (5001, 3, 90, 0), (5003, 99, 0, 0)])
    )
    ready.tell(f"fence load {file}", "Fence of 4 items stored")
    ready.tell("fence list", "5003 3 47.3977420000 8.5455940000")
    ready.tell("fence disable", "DO_FENCE_ENABLE: ACCEPTED")
    ready.tell("fence enable", "DO_FENCE_ENABLE: ACCEPTED")
    ready.tell("fence clear", "ACCEPTED")
    ready.tell("fence enable", "no fence is stored")


def test_mavproxy_loads_and_clears_rally_points(ready: MavProxy, tmp_path: Path) -> None:
    file = tmp_path / "rally.txt"
    file.write_text(lines([(5100, 0, 10, 0), (5100, 0, 0, 20)]))
    ready.tell(f"rally load {file}", "Rally of 2 items stored")
    ready.tell("rally clear", "ACCEPTED")
