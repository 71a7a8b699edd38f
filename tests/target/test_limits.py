# SPDX-License-Identifier: MIT
"""FS_BATT_V and FS_FENCE_M: limits on the ESCs' voltage and the boat's position."""

from __future__ import annotations

import math

import pytest

from tests.target.agent import START_US
from tests.target.course import Course
from tests.target.hull import Afloat, Hull
from tests.target.operator_words import sticks
from tests.target.sea import PAPER, Sea, at_sea, texts
from tests.target.stations import FORMATION, MANUAL
from tests.target.test_long_texts import words

LOW, FAR = "battery is below FS_BATT_V, or unknown", "fence: outside, ahead, or no position"
GEOFENCE, BATTERY, PREARM = 1 << 20, 1 << 25, 1 << 28


def charged(parameters: dict[str, float]) -> Sea:
    """A boat in FORMATION whose battery has been good for long enough."""
    sea = Sea(parameters)
    sea.run(2.5)
    sea.enter_formation()
    sea.run(0.5)
    return sea


def fence_and_battery(sea: Sea) -> dict[int, tuple[bool, bool]]:
    (status,) = sea.ask(1)
    present, health = status.onboard_control_sensors_present, status.onboard_control_sensors_health
    assert present == status.onboard_control_sensors_enabled
    return {bit: (bool(present & bit), bool(health & bit)) for bit in (GEOFENCE, BATTERY, PREARM)}


@pytest.mark.parametrize("esc", [0, 1])
@pytest.mark.parametrize("voltage", [21.9, 0.0, math.nan])
def test_a_low_battery_stops_the_law_after_two_seconds(esc: int, voltage: float) -> None:
    sea = charged({"FS_BATT_V": 22.0})
    sea.escs[esc].voltage = voltage
    ticks = sea.run(1.9)
    assert sea.state == "FORMATION" and not texts(ticks)
    sea.run_until("HOLD", 0.4)
    assert texts([sea.ticks[-1]]) == [f"HOLD: {LOW}"] and sea.commands == (0, 0)
    assert fence_and_battery(sea)[BATTERY] == (True, False)
    sea.say(sticks(100, 0))
    sea.mode(MANUAL)
    sea.step()
    assert sea.state == "MANUAL", "it can be driven home"


def test_a_battery_that_dips_for_a_moment_is_good() -> None:
    sea = charged({"FS_BATT_V": 22.0})
    for _ in range(5):
        sea.escs[0].voltage = 20.0
        sea.run(1.5)
        sea.escs[0].voltage = 24.5
        sea.run(0.5)
    assert sea.state == "FORMATION"


def test_a_boat_with_a_low_battery_is_armed_for_manual_only_with_the_reason() -> None:
    sea = Sea({"FS_BATT_V": 25.0})
    sea.run(5.0)
    assert words([sea.arm()]) == ["HOLD", f"armed, no FORMATION: {LOW}"]
    assert fence_and_battery(sea)[PREARM] == (True, False)
    assert texts([sea.mode(FORMATION)]) == [f"Refused: {LOW}"] and sea.state == "HOLD"
    sea.escs[0].voltage = sea.escs[1].voltage = 25.5
    sea.run(1.8)
    assert sea.mode(FORMATION) and sea.state == "HOLD"
    sea.run(0.5)
    assert sea.mode(FORMATION) and sea.state == "FORMATION"


def sail_on(sea: Sea, speed_mps: float) -> None:
    """Sail on from here at that speed ahead; the true motion ignores thrust."""
    here, t = sea.own.truth(sea.now_us), (sea.now_us - START_US) * 1e-6
    ahead = speed_mps * t
    sea.own.course = Course(
        here.north - ahead * math.cos(here.psi),
        here.east - ahead * math.sin(here.psi),
        here.psi,
        speed_mps,
    )


@pytest.mark.parametrize("bearing", [0.3, 2.0, -2.5])
def test_beyond_the_fence_the_law_stops_and_within_it_the_operator_may_go_on(
    bearing: float,
) -> None:
    leader = Course(math.cos(bearing), math.sin(bearing), bearing, 0.5)
    fence = {"FS_FENCE_M": 3.0, "FS_FENCE_ACT": 0}
    sea = Afloat(fence, hull=Hull([0.0, 0.0, bearing] + [0.0] * 3), leader=leader)
    sea.enter_formation()
    sea.run_until("HOLD", 15.0)
    assert math.hypot(*sea.hull.q[:2]) == pytest.approx(3.0, abs=0.1)
    assert texts(sea.ticks)[-1] == f"HOLD: {FAR}"
    assert fence_and_battery(sea)[GEOFENCE] == (True, False)
    sea.mode(FORMATION)
    assert sea.state == "HOLD"
    sea.hull.push = (-2.0, 0.0)  # somebody tows it astern
    sea.run(2.0)
    sea.hull.push = (0.0, 0.0)
    sea.run(1.5)
    assert sea.state == "HOLD" and fence_and_battery(sea)[GEOFENCE] == (True, True)
    sea.mode(FORMATION)
    assert sea.state == "FORMATION"


def test_a_boat_may_be_armed_anywhere_as_its_fence_is_centred_there() -> None:
    sea = Sea(PAPER | {"FS_FENCE_M": 3.0}, own=Course(1.0, 2.0, 0.3, 0.5))
    sea.run(10.0)
    sail_on(sea, 0.0)
    sea.enter_formation()
    sea.run(1.0)
    assert sea.state == "FORMATION"


def test_a_boat_that_does_not_know_its_place_is_armed_for_manual_only() -> None:
    for fence_m in (0.0, 50.0):
        sea = Sea({"FS_FENCE_M": fence_m})
        sea.own.origin_on = False
        sea.settle()
        tick = sea.arm()
        assert sea.state == "HOLD"
        assert (f"armed, no FORMATION: {FAR}" in words([tick])) == bool(fence_m)


def test_without_limits_there_is_no_fence_and_no_low_battery() -> None:
    sea = at_sea()
    sea.escs[0].voltage = sea.escs[1].voltage = 0.5
    sea.run(5.0)
    assert sea.state == "FORMATION"
    assert fence_and_battery(sea) == {
        GEOFENCE: (False, True),
        BATTERY: (True, True),
        PREARM: (True, True),
    }
