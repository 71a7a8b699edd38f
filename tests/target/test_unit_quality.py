# SPDX-License-Identifier: MIT
"""The unit's report on its own estimate: the law gives no thrust with a poor one."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import pytest
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from tests.target.hull import Afloat
from tests.target.operator_words import param_set
from tests.target.sea import Sea, at_sea, named, texts
from tests.target.stations import (
    BOAT,
    FORMATION,
    LEADER,
    LEADER_COMPONENT,
    ORIGIN,
    Station,
    gps,
    odometry,
)

WELL = (
    mavlink.ESTIMATOR_ATTITUDE
    | mavlink.ESTIMATOR_VELOCITY_HORIZ
    | mavlink.ESTIMATOR_POS_HORIZ_REL
    | mavlink.ESTIMATOR_POS_HORIZ_ABS
)


def estimator(accuracy_m: float = 0.5, ratio: float = 0.1, flags: int = WELL) -> Any:
    return mavlink.MAVLink_estimator_status_message(
        0, flags, ratio, ratio, 0.1, 0.1, 0.1, math.nan, accuracy_m, 1.0
    )


def ekf(variance: float = 0.1, flags: int = WELL) -> Any:
    return mavlink.MAVLink_ekf_status_report_message(flags, variance, variance, 0.1, 0.1, 0.1)


POOR = {
    "no fix": (gps(), gps(fix_type=1), "GPS fix type"),
    "few satellites": (gps(), gps(hdop=4.0), "GPS HDOP"),
    "500 m": (estimator(), estimator(accuracy_m=500.0), "position accuracy"),
    "refused fixes": (estimator(), estimator(ratio=1.2), "estimator test ratios"),
    "no place": (estimator(), estimator(flags=3), "estimator flags"),
    "no absolute place": (
        estimator(),
        estimator(flags=WELL & ~mavlink.ESTIMATOR_POS_HORIZ_ABS),
        "estimator flags",
    ),
    "ArduPilot's variance": (ekf(), ekf(variance=0.9), "estimator test ratios"),
    "ArduPilot's glitch": (ekf(), ekf(flags=WELL | 32768), "estimator flags"),
}


@pytest.mark.parametrize("case", POOR)
def test_a_poor_estimate_stops_the_law_and_is_reported(case: str) -> None:
    good, poor, why = POOR[case]
    sea = at_sea()
    unit = sea.own.station
    sea.say(good, sender=unit)
    sea.run(1.0)
    assert sea.state == "FORMATION"
    sea.own.tells_fix = False
    sea.say(poor, sender=unit)
    ticks = sea.run(0.02)
    assert sea.state == "HOLD" and sea.commands == (0, 0) and not sea.condition("own_good")
    assert f"poor navigation: {why}" in texts(ticks)
    sea.run(5.0)
    assert not sea.condition("own_good"), "silence is no better fix"
    sea.mode(FORMATION)
    sea.run(0.1)
    assert sea.state == "HOLD"
    sea.say(good, sender=unit)
    sea.run(0.9)
    assert not sea.condition("own_good")
    sea.run(0.2)
    assert sea.condition("own_good")
    sea.mode(FORMATION)
    sea.run(0.1)
    assert sea.state == "FORMATION"


def test_a_poor_fix_is_reported_before_arming() -> None:
    sea = Sea()
    sea.run(1.0)
    sea.own.tells_fix = False
    sea.say(gps(fix_type=0), sender=sea.own.station)
    ticks = sea.run(0.1)
    assert not sea.condition("own_good")
    assert "poor navigation: GPS fix type" in texts(ticks)


def test_odometrys_covariance_counts() -> None:
    sea = at_sea()
    sea.own.on = False
    for variance, good in [(0.01, True), (25.0, False)]:
        for _ in range(4):
            covariance = [variance] + [0.0] * 5 + [variance] + [0.0] * 14
            truth = sea.own.course
            message = odometry(truth, sea.now_us, pose_covariance=covariance)
            sea.say(message, sender=sea.own.station)
            sea.run(0.05)
        assert sea.condition("own_good") == good


@pytest.mark.parametrize(
    "sender", [Station(BOAT, 77), Station(LEADER, LEADER_COMPONENT), Station(255, 190)]
)
def test_only_the_unit_in_use_reports_the_quality(sender: Station) -> None:
    sea = at_sea()
    for poor in (gps(fix_type=0), estimator(accuracy_m=500.0), ekf(variance=9.0)):
        sea.say(poor, sender=sender)
        sea.run(0.1)
    assert sea.state == "FORMATION" and sea.condition("own_good")


def test_with_a_limit_of_0_no_estimate_is_poor() -> None:
    sea = Sea()
    for name in ("NAV_FIX", "NAV_HDOP", "NAV_ACC_M"):
        sea.say(param_set(name, 0.0))
        sea.run(0.05)
    sea.enter_formation()
    sea.say(gps(fix_type=0, hdop=99.0), estimator(accuracy_m=500.0), sender=sea.own.station)
    sea.run(0.5)
    assert sea.state == "FORMATION"


def test_a_unit_without_a_quality_report_is_mentioned_at_arming() -> None:
    said = "navigation quality not reported: not checked"
    sea = Sea()
    sea.own.tells_fix = False
    sea.enter_hold()
    sea.run(0.2)
    assert said in texts(sea.ticks)
    other = Sea()
    other.enter_hold()
    other.run(0.2)
    assert said not in texts(other.ticks)


def test_home_is_the_first_place_that_the_unit_calls_good() -> None:
    sea = Afloat({"FS_SEP_M": 0.0})
    true, off_m = sea.own.truth, 60.0
    sea.own.truth = lambda now_us: replace(true(now_us), north=true(now_us).north + off_m)
    sea.own.tells_fix = False
    for _ in range(2):
        sea.say(gps(1, 20.0), sender=sea.own.station)
        sea.run(1.0)
    assert not sea.condition("own_good")
    sea.arm()
    sea.run(2.0)
    off_m = 0.0
    sea.own.tells_fix = True
    sea.run(8.0)
    home = named(sea.ticks, "HOME_POSITION")[-1]
    assert "home set here: no good position at arming" in texts(sea.ticks)
    assert home.latitude == pytest.approx(ORIGIN[0], abs=2)
