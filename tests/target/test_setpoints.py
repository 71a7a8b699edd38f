# SPDX-License-Identifier: MIT
"""SET_POSITION_TARGET_*: a script moves a boat in GUIDED, by places or velocities."""

from __future__ import annotations

import math

import pytest
from pymavlink.dialects.v20 import common as mavlink

from tests.target.hull import Afloat
from tests.target.plans import at
from tests.target.sea import acks, texts
from tests.target.stations import (
    ACCEPTED,
    AUTO,
    BOAT,
    GCS,
    GUIDED,
    HOLD,
    PAUSE,
    REPOSITION,
    Station,
)
from tests.target.test_auto import at_sea, place
from tests.target.test_going_and_waiting import reposition

IGNORED = 64 | 128 | 256 | 1024  # accelerations, yaw
PLACE, VELOCITY, YAW_RATE = 1 | 2 | 4, 8 | 16 | 32, 2048
NED, OFFSET_NED, BODY_NED, BODY_OFFSET_NED, BODY_FRD = 1, 7, 8, 9, 12


def local(
    frame: int,
    *,
    place_m: tuple[float, float] | None = None,
    velocity_mps: tuple[float, float] | None = None,
    yaw_rate_radps: float | None = None,
    mask: int = IGNORED,
) -> mavlink.MAVLink_message:
    """SET_POSITION_TARGET_LOCAL_NED of what is given."""
    mask |= (place_m is None) * PLACE | (velocity_mps is None) * VELOCITY
    mask |= (yaw_rate_radps is None) * YAW_RATE
    x, y = place_m or (0.0, 0.0)
    vx, vy = velocity_mps or (0.0, 0.0)
    return mavlink.MAVLink_set_position_target_local_ned_message(
        *(0, BOAT, 1, frame, mask, x, y, 0.0, vx, vy, 0.0, 0.0, 0.0, 0.0, 0.0),
        yaw_rate_radps or 0.0,
    )


def waiting() -> Afloat:
    sea = at_sea([])
    sea.mode(GUIDED)
    sea.run(1.0)
    assert sea.state == "GUIDED"
    return sea


def test_a_script_moves_the_place_in_each_frame() -> None:
    sea = waiting()
    sea.say(local(NED, place_m=(5.0, 3.0)))
    sea.run(50.0)
    assert place(sea) == pytest.approx((5, 3), abs=0.05)
    sea.say(local(OFFSET_NED, place_m=(0.0, 4.0), velocity_mps=(0.0, 0.3)))
    sea.run(60.0)
    assert place(sea) == pytest.approx((5, 7), abs=0.1)
    to = at(0, 0)
    sea.say(
        mavlink.MAVLink_set_position_target_global_int_message(
            *(0, BOAT, 1, 6, IGNORED | VELOCITY | YAW_RATE, to.x, to.y), *(0.0,) * 9
        )
    )
    sea.run(60.0)
    assert place(sea) == pytest.approx((0, 0), abs=0.05) and sea.state == "GUIDED"


def test_a_place_that_a_script_repeats_is_sailed_to_as_one_sent_once() -> None:
    sea = waiting()
    for _ in range(500):
        sea.say(local(NED, place_m=(5.0, 3.0)))
        sea.run(0.1)
    assert place(sea) == pytest.approx((5, 3), abs=0.05)
    sea.say(local(NED, place_m=(0.0, 3.0)))
    sea.run(50.0)
    assert place(sea) == pytest.approx((0, 3), abs=0.05)


def test_a_paused_boat_does_not_turn_to_a_scripts_course() -> None:
    sea = waiting()
    for k in range(150):
        if k == 50:
            sea.order(PAUSE, 0.0)
        sea.say(local(NED, velocity_mps=(0.5 if k < 50 else -0.5, 0.0)))
        sea.run(0.2)
    assert abs(sea.hull.q[2]) < 0.05 and abs(sea.hull.seen.u) < 0.01


def test_an_operators_earlier_target_ends_a_pause_after_a_scripts_target() -> None:
    sea = waiting()
    reposition(sea, at(10, 0))
    sea.run(5.0)
    sea.say(local(NED, place_m=(0.0, 10.0)))
    sea.run(5.0)
    sea.order(PAUSE, 0.0)
    sea.run(5.0)
    assert acks(reposition(sea, at(10, 0))) == [(REPOSITION, ACCEPTED)]
    sea.run(60.0)
    assert place(sea) == pytest.approx((10, 0), abs=0.05)


def test_the_same_place_with_another_speed_changes_the_speed_alone() -> None:
    sea = waiting()
    for k in range(500):
        sea.say(local(NED, place_m=(5.0, 3.0), velocity_mps=(0.5 + 0.01 * (k % 2), 0.0)))
        sea.run(0.1)
    assert place(sea) == pytest.approx((5, 3), abs=0.05)
    for speed_mps in (0.6, 0.3):
        sea.say(local(NED, place_m=(5.0, 33.0), velocity_mps=(speed_mps, 0.0)))
        sea.run(20.0)
        assert sea.hull.seen.u == pytest.approx(speed_mps, abs=0.01)


@pytest.mark.parametrize("scalar", ["float", "q16"])
def test_an_impossible_yaw_rate_is_limited_to_that_of_the_boat(scalar: str) -> None:
    sea = at_sea([], scalar=scalar)
    sea.mode(GUIDED)
    sea.run(1.0)
    for _ in range(30):
        sea.say(local(BODY_NED, velocity_mps=(0.2, 0.0), yaw_rate_radps=1e5))
        sea.run(0.2)
    assert sea.state == "GUIDED" and 0.1 < sea.hull.seen.r < 0.9


def test_a_boat_sails_to_a_new_target_after_another_mode_ended_a_drive() -> None:
    sea = waiting()
    for _ in range(10):
        sea.say(local(NED, velocity_mps=(0.0, 0.5)))
        sea.run(0.2)
    sea.mode(HOLD)
    sea.run(10.0)
    assert acks(reposition(sea, at(8, 0))) == [(REPOSITION, ACCEPTED)]
    sea.run(60.0)
    assert place(sea) == pytest.approx((8, 0), abs=0.1)


def test_a_place_that_came_just_before_auto_is_forgotten() -> None:
    sea = at_sea([at(4, 0)])
    sea.mode(GUIDED)
    sea.run(1.0)
    sea.say(local(NED, place_m=(0.0, 30.0)))
    sea.mode(AUTO)
    sea.run(20.0)
    assert sea.state == "AUTO"
    sea.mode(GUIDED)
    sea.run(30.0)
    assert sea.state == "GUIDED" and place(sea)[1] == pytest.approx(0, abs=0.5)


@pytest.mark.parametrize("frame", [BODY_NED, BODY_OFFSET_NED, BODY_FRD])
def test_a_script_drives_the_boat_ahead_and_in_a_turn(frame: int) -> None:
    sea = waiting()
    for _ in range(100):
        sea.say(local(frame, velocity_mps=(0.6, 0.0), yaw_rate_radps=0.2))
        sea.run(0.2)
    assert sea.hull.seen.u == pytest.approx(0.6, abs=0.03)
    assert sea.hull.seen.r == pytest.approx(0.2, abs=0.02)


@pytest.mark.parametrize(
    ("frame", "velocity_mps"),
    [(NED, (0.04, 0.0)), (NED, (1e-6, 0.0)), (BODY_NED, (-1e-6, 0.0)), (BODY_NED, (0.02, 0.04))],
)
def test_a_velocity_that_is_nearly_zero_stops_the_boat_on_its_way(
    frame: int, velocity_mps: tuple[float, float]
) -> None:
    sea = waiting()
    sea.say(local(NED, place_m=(60.0, 0.0)))
    sea.run(20.0)
    for _ in range(60):
        sea.say(local(frame, velocity_mps=velocity_mps))
        sea.run(0.2)
    before = place(sea)
    for _ in range(20):
        sea.say(local(frame, velocity_mps=velocity_mps))
        sea.run(0.2)
    assert math.dist(place(sea), before) < 0.1


def test_a_script_drives_the_boat_on_a_course_until_it_is_silent() -> None:
    sea = waiting()
    for _ in range(200):
        sea.say(local(NED, velocity_mps=(0.0, 0.5)))
        sea.run(0.2)
    north, east = place(sea)
    assert sea.hull.seen.psi == pytest.approx(math.pi / 2, abs=0.03) and east > 10
    assert sea.hull.seen.u == pytest.approx(0.5, abs=0.02)
    sea.run(30.0)
    assert sea.state == "GUIDED" and math.hypot(*sea.hull.q[3:5]) < 0.01
    assert 1.0 < place(sea)[1] - east < 6.0
    assert place(sea)[0] == pytest.approx(north, abs=0.3)


@pytest.mark.parametrize(
    ("message", "why"),
    [
        (local(3, place_m=(5.0, 0.0)), "unsupported setpoint frame"),
        (local(BODY_NED, place_m=(5.0, 0.0)), "position invalid in this frame"),
        (local(NED, place_m=(5.0, 0.0), mask=IGNORED | 2), "position needs x and y"),
        (local(NED, velocity_mps=(0.5, 0.0), mask=IGNORED | 16), "velocity needs vx and vy"),
        (local(NED, place_m=(math.nan, 0.0)), "position needs x and y"),
        (local(NED, velocity_mps=(math.inf, 0.0)), "velocity needs vx and vy"),
        (local(NED), "no position or velocity"),
        (local(NED, place_m=(5.0, 0.0), mask=1024), "acceleration not supported"),
        (local(NED, place_m=(3000.0, 0.0)), "target is over 2.9 km away"),
        (local(NED, velocity_mps=(3.0, 0.0)), "speed must be 0.05 m/s to LAW_U_MAX"),
        (
            local(NED, velocity_mps=(0.5, 0.0), yaw_rate_radps=0.1),
            "yaw rate only in body frames",
        ),
        (local(BODY_NED, velocity_mps=(-0.5, 0.0)), "body velocity must be ahead"),
        (local(BODY_NED, velocity_mps=(0.5, 0.1)), "body velocity must be ahead"),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_an_impossible_setpoint_is_refused_with_a_reason(
    message: mavlink.MAVLink_message, why: str
) -> None:
    sea = waiting()
    sea.say(message)
    ticks = sea.run(10.0)
    assert [text for text in texts(ticks) if text.startswith("Refused")] == [f"Refused: {why}"]
    assert place(sea) == pytest.approx((0, 0), abs=0.05) and sea.state == "GUIDED"


def test_setpoints_of_a_station_that_may_not_command_move_no_boat() -> None:
    sea = at_sea([], {"MAV_GCS_SYSID": float(GCS)})
    sea.mode(GUIDED)
    sea.run(1.0)
    assert sea.state == "GUIDED"
    sea.say(local(NED, place_m=(5.0, 0.0)), sender=Station(7, 190))
    assert "Refused: not from MAV_GCS_SYSID" in texts(sea.run(10.0))
    assert place(sea) == pytest.approx((0, 0), abs=0.05)


def test_a_boat_that_turned_on_the_spot_rests_when_the_script_falls_silent() -> None:
    sea = at_sea([])
    sea.mode(GUIDED)
    for _ in range(60):
        sea.say(local(BODY_NED, velocity_mps=(0.0, 0.0), yaw_rate_radps=0.3))
        sea.run(0.1)
    assert sea.hull.seen.r > 0.2
    sea.run(6.0)
    rests_at = sea.hull.q[2]
    sea.run(5.0)
    assert abs(sea.hull.seen.r) < 0.01 and abs(sea.hull.q[2] - rests_at) < 0.02
