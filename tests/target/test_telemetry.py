# SPDX-License-Identifier: MIT
"""Telemetry of the boat's own state: rates and time stamps."""

from __future__ import annotations

import math

import pytest

from tests.target.course import Course, wrap
from tests.target.sea import Sea, messages, named
from tests.target.stations import ORIGIN, odometry
from tests.turns import some


@pytest.mark.parametrize("rate", [1, 5, 10, 30, 50])
def test_state_goes_out_at_sr_state(rate: int) -> None:
    sea = Sea({"SR_STATE": rate})
    sea.run(10.0)
    for name in ("LOCAL_POSITION_NED", "ATTITUDE"):
        assert len(named(sea.ticks, name)) == pytest.approx(10 * rate, rel=0.02, abs=1)


def test_no_state_goes_out_when_sr_state_is_zero() -> None:
    sea = Sea({"SR_STATE": 0})
    sea.run(5.0)
    assert not named(sea.ticks, "LOCAL_POSITION_NED") and not named(sea.ticks, "ATTITUDE")
    assert len(named(sea.ticks, "HEARTBEAT")) == 5


def test_origin_and_timesync_requests_go_out_once_a_second(sea: Sea) -> None:
    sea.run(10.0)
    sent = named(sea.ticks, "GPS_GLOBAL_ORIGIN")
    assert len(sent) == 10
    assert all((m.latitude, m.longitude, m.altitude) == ORIGIN for m in sent)
    requests = [m for m in named(sea.ticks, "TIMESYNC") if m.tc1 == 0]
    assert len(requests) == 10
    assert len({m.ts1 for m in requests}) == 10


def test_a_state_is_stamped_with_the_time_of_that_state(voyage: Sea) -> None:
    stamps = []
    pushed_us = compared = 0
    for tick in voyage.ticks:
        # On the other link somebody has asked for ATTITUDE at a rate of its own.
        turns = {m.time_boot_ms: m for m in tick.named("ATTITUDE", link=1)}
        if any(tick.commands):
            pushed_us = tick.now_us
        for m in tick.named("LOCAL_POSITION_NED", link=1):
            stamps.append(m.time_boot_ms)
            assert abs(m.time_boot_ms - tick.now_us / 1000) < 500
            # The true motion ignores thrust, but the boat's model includes it.
            if tick.now_us - pushed_us < 6_000_000:
                continue
            compared += 1
            truth = voyage.own.truth(m.time_boot_ms * 1000)
            assert math.hypot(m.x - truth.north, m.y - truth.east) < 0.05
            assert abs(wrap(turns[m.time_boot_ms].yaw - truth.psi)) < 0.02
    assert compared > 1000
    assert stamps == sorted(set(stamps))


def test_a_drifting_boat_reports_its_velocity_and_yaw_rate(sea: Sea) -> None:
    sea.own.course = Course(1.0, 2.0, 0.3, 0.6, 0.1, 0.05)
    sea.run(5.0)
    sea.ticks.clear()
    sea.run(1.0)
    for m in some(named(sea.ticks, "LOCAL_POSITION_NED")):
        velocity_n = sea.own.truth(m.time_boot_ms * 1000).velocity_n
        assert (m.vx, m.vy) == pytest.approx(tuple(velocity_n), abs=0.01)
    for turn in some(named(sea.ticks, "ATTITUDE")):
        assert turn.yawspeed == pytest.approx(0.05, abs=0.01)


@pytest.mark.parametrize("rate_hz", [5.0, 20.0])
def test_a_turning_boat_sends_the_position_that_belongs_to_the_stamp(rate_hz: float) -> None:
    sea = Sea({"SR_STATE": 50}, own=Course(1.0, 2.0, 0.3, 1.0, 0.1, 0.2))
    sea.own.period_us = round(1e6 / rate_hz)
    sea.run(5.0)
    for m in some(named(sea.ticks, "LOCAL_POSITION_NED")):
        truth = sea.own.truth(m.time_boot_ms * 1000)
        # Until the observer finds the towing force, the boat expects to lose speed.
        assert math.hypot(m.x - truth.north, m.y - truth.east) < 0.05
    assert math.hypot(m.x - truth.north, m.y - truth.east) < 0.001


def test_nothing_about_the_own_state_goes_out_when_it_is_stale(sea: Sea) -> None:
    about_own_state = {
        "LOCAL_POSITION_NED",
        "ATTITUDE",
        "GPS_GLOBAL_ORIGIN",
        "GLOBAL_POSITION_INT",
        "NAV_CONTROLLER_OUTPUT",
        "POSITION_TARGET_LOCAL_NED",
    }
    about_the_rest = {
        "HEARTBEAT",
        "TIMESYNC",
        "SYSTEM_TIME",
        "SYS_STATUS",
        "HOME_POSITION",  # where it was armed, not where it is
        "BATTERY_STATUS",
        "NAMED_VALUE_FLOAT",
        "FORMATION_REFERENCE",  # of the leader
    }
    assert not about_own_state & {m.get_type() for m in messages([sea.tick_only()])}
    sea.run(1.0)
    sea.own.on = False
    sea.run(0.6)
    sea.ticks.clear()
    sea.run(5.0)
    kinds = [m.get_type() for m in messages(sea.ticks)]
    assert set(kinds) == about_the_rest and kinds.count("HEARTBEAT") == 5
    names = {m.name for m in named(sea.ticks, "NAMED_VALUE_FLOAT")}
    always = {"LEADER", "COND", "COND2", "T_PORT", "T_STBD", "T_MAX", "T_MIN", "OVERRUNS", "DEPTH"}
    assert names == {"NAV_AGE", "LEAD_AGE", "LEAD_UNC"} | always
    sea.own.on = True
    sea.ticks.clear()
    sea.run(1.2)
    assert about_own_state <= {m.get_type() for m in messages(sea.ticks)}


def test_without_own_origin_no_origin_is_sent(sea: Sea) -> None:
    sea.own.origin_on = False
    sea.run(3.0)
    assert not named(sea.ticks, "GPS_GLOBAL_ORIGIN")


def test_position_and_velocity_are_corrected_for_the_antennas_offset() -> None:
    # v of the antenna = v of the boat + r × place: u − r·y_ofs, v + r·x_ofs.
    sea = Sea({"NAV_OFS_X": 2.0, "NAV_OFS_Y": -1.0})
    sea.own.on = False
    antenna = Course(10.0, 20.0, math.pi / 2, 1.0, 0.0, 0.5)
    sea.say(odometry(antenna, sea.now_us), sender=sea.own.station)
    sea.step()
    # Heading east: ahead is east, starboard is south.
    expected = Course(10.0 - 1.0, 20.0 - 2.0, math.pi / 2, 1.0 + 0.5 * -1.0, 0.0 - 0.5 * 2.0, 0.5)
    assert sea.own_course().close_to(expected)
