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
