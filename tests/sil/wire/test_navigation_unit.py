# SPDX-License-Identifier: MIT
"""What a navigation unit says, as pymavlink understands it."""

from collections import Counter
from math import atan2, cos, hypot, isnan, pi, sin
from typing import Any, Literal

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pymavlink.dialects.v20 import common as mavlink  # type: ignore[import-untyped]

from sil.wire.navigation_unit import NavigationUnit

ORIGIN = (541234567, 101234567, 12000)
ETA, NU = (12.5, -3.25, 2.0), (1.5, 0.25, -0.125)
OFFSET_US = 3 * 3600 * 1_000_000 + 7


def unit(message: Literal["local", "odometry"] = "local", rate_hz: float = 10.0) -> NavigationUnit:
    return NavigationUnit(
        2,
        201,
        vehicle_type=mavlink.MAV_TYPE_GPS,
        origin=ORIGIN,
        rate_hz=rate_hz,
        message=message,
    )


def parsed(data: bytes) -> list[Any]:
    return mavlink.MAVLink(None).parse_buffer(data) or []


def by_name(data: bytes) -> dict[str, Any]:
    return {m.get_type(): m for m in parsed(data)}


def test_the_first_tick_says_everything_attitude_before_position() -> None:
    messages = parsed(unit().tick(1000, ETA, NU))
    assert [m.get_type() for m in messages] == [
        "HEARTBEAT",
        "GPS_GLOBAL_ORIGIN",
        "ATTITUDE",
        "LOCAL_POSITION_NED",
    ]
    assert {(m.get_srcSystem(), m.get_srcComponent()) for m in messages} == {(2, 201)}
    assert [m.get_seq() for m in messages] == [0, 1, 2, 3]


def test_a_state_as_local_position_and_attitude_comes_back() -> None:
    m = by_name(unit().tick(7_654_321, ETA, NU))
    position, attitude = m["LOCAL_POSITION_NED"], m["ATTITUDE"]
    assert position.time_boot_ms == attitude.time_boot_ms == 7654
    assert (position.x, position.y, position.z) == (12.5, -3.25, 0.0)
    u = position.vx * cos(2.0) + position.vy * sin(2.0)
    v = -position.vx * sin(2.0) + position.vy * cos(2.0)
    assert (u, v) == pytest.approx((1.5, 0.25), abs=1e-6)
    assert (attitude.yaw, attitude.yawspeed) == (2.0, -0.125)
    assert (attitude.roll, attitude.pitch, position.vz) == (0.0, 0.0, 0.0)


def test_a_state_as_odometry_comes_back() -> None:
    m = by_name(unit("odometry").tick(7_654_321, ETA, NU))
    assert "ATTITUDE" not in m and "LOCAL_POSITION_NED" not in m
    odometry = m["ODOMETRY"]
    assert odometry.time_usec == 7_654_321
    assert (odometry.frame_id, odometry.child_frame_id) == (1, 12)
    assert (odometry.x, odometry.y, odometry.vx, odometry.vy) == (12.5, -3.25, 1.5, 0.25)
    w, x, y, z = odometry.q
    assert 2.0 * atan2(z, w) == pytest.approx(2.0, abs=1e-6)
    assert (x, y) == (0.0, 0.0) and hypot(w, z) == pytest.approx(1.0, abs=1e-6)
    assert odometry.yawspeed == -0.125
    assert isnan(odometry.pose_covariance[0]) and isnan(odometry.velocity_covariance[0])
    assert odometry.estimator_type == mavlink.MAV_ESTIMATOR_TYPE_GPS_INS


def test_origin_and_heartbeat_say_who_and_where() -> None:
    m = by_name(unit().tick(7_000_000, ETA, NU))
    origin, heartbeat = m["GPS_GLOBAL_ORIGIN"], m["HEARTBEAT"]
    assert (origin.latitude, origin.longitude, origin.altitude) == ORIGIN
    assert origin.time_usec == 7_000_000
    assert heartbeat.type == mavlink.MAV_TYPE_GPS
    assert heartbeat.autopilot == mavlink.MAV_AUTOPILOT_INVALID


@given(st.floats(-1000.0, 1000.0))
def test_the_heading_is_wrapped_on_the_wire(psi: float) -> None:
    yaw = by_name(unit().tick(0, (0.0, 0.0, psi), NU))["ATTITUDE"].yaw
    assert abs(yaw) <= pi + 1e-6
    assert cos(yaw - psi) == pytest.approx(1.0, abs=1e-6)


def test_half_a_turn_is_plus_pi() -> None:
    assert by_name(unit().tick(0, (0.0, 0.0, -pi), NU))["ATTITUDE"].yaw > 0.0
    assert by_name(unit().tick(0, (0.0, 0.0, 3.0 * pi), NU))["ATTITUDE"].yaw > 0.0


@pytest.mark.parametrize("rate_hz", [1.0, 5.0, 25.0, 30.0, 100.0])
def test_rates_hold_over_ten_seconds_with_a_clock_offset_of_three_hours(rate_hz: float) -> None:
    sender = unit(rate_hz=rate_hz)
    count: Counter[str] = Counter()
    for t in range(OFFSET_US, OFFSET_US + 10_000_000, 10_000):
        count.update(m.get_type() for m in parsed(sender.tick(t, ETA, NU)))
    assert count == {
        "HEARTBEAT": 10,
        "GPS_GLOBAL_ORIGIN": 10,
        "ATTITUDE": 10 * rate_hz,
        "LOCAL_POSITION_NED": 10 * rate_hz,
    }


@pytest.mark.parametrize("drift", [-20e-6, 20e-6])
def test_a_drifting_clock_loses_one_state_in_500_s_at_most(drift: float) -> None:
    sender = unit(rate_hz=100.0)
    sent = sum(
        sender.tick(OFFSET_US + round(k * 10_000 * (1.0 + drift)), ETA, NU) != b""
        for k in range(20_000)
    )
    assert sent >= 19_999


def test_a_clock_that_jumps_back_does_not_silence_the_unit() -> None:
    sender = unit(rate_hz=100.0)
    sender.tick(OFFSET_US, ETA, NU)
    assert len(parsed(sender.tick(1000, ETA, NU))) == 4


def ask(tc1: int, ts1: int, target: bytes = b"") -> bytes:
    """A TIMESYNC frame; `target` appends upstream's extension (system, component)."""
    mav = mavlink.MAVLink(None, 5, 1)
    message = mavlink.MAVLink_timesync_message(tc1, ts1)
    if not target:
        return bytes(message.pack(mav))
    payload = message.unpacker.pack(tc1, ts1) + target
    return bytes(message._pack(mav, message.crc_extra, payload))


def test_a_timesync_request_is_answered_with_its_own_stamp_at_the_next_tick() -> None:
    sender = unit(rate_hz=1.0)
    sender.tick(OFFSET_US, ETA, NU)
    sender.on_mavlink(b"noise\xfd" + ask(0, 987654321), OFFSET_US + 100)
    (answer,) = parsed(sender.tick(OFFSET_US + 100, ETA, NU))
    assert (answer.ts1, answer.tc1) == (987654321, (OFFSET_US + 100) * 1000)
    assert sender.tick(OFFSET_US + 200, ETA, NU) == b""


def test_an_answer_that_waits_for_a_tick_tells_when_the_request_was_read() -> None:
    sender = unit(rate_hz=1.0)
    sender.tick(0, ETA, NU)
    sender.on_mavlink(ask(0, 1), 2_000)
    (answer,) = parsed(sender.tick(12_000, ETA, NU))
    assert answer.tc1 == 2_000_000


@pytest.mark.parametrize(
    ("target", "answered"),
    [(b"\x02\xc9", True), (b"\x02", True), (b"\x02\x01", False), (b"\x03\xc9", False)],
)
def test_only_a_request_to_this_unit_or_to_all_is_answered(target: bytes, answered: bool) -> None:
    sender = unit()
    sender.tick(0, ETA, NU)
    sender.on_mavlink(ask(0, 1, target), 100)
    assert (sender.tick(100, ETA, NU) != b"") is answered


def test_somebody_elses_answer_is_not_answered() -> None:
    sender = unit()
    sender.tick(0, ETA, NU)
    sender.on_mavlink(ask(5, 1), 100)
    assert sender.tick(100, ETA, NU) == b""


def test_a_request_with_a_wrong_crc_is_counted_and_ignored() -> None:
    sender = unit()
    sender.tick(0, ETA, NU)
    request = bytearray(ask(0, 1))
    request[-1] ^= 1
    sender.on_mavlink(bytes(request), 100)
    assert sender.tick(100, ETA, NU) == b""
    assert sender.counters["bad"] == 1


@given(st.binary(max_size=300), st.binary(max_size=60))
def test_garbage_never_raises(garbage: bytes, payload: bytes) -> None:
    sender = unit()
    sender.on_mavlink(garbage, 0)
    header = b"\xfd" + bytes([len(payload), 0, 0, 0, 1, 1]) + b"\x6f\x00\x00"
    sender.on_mavlink(header + payload + b"\x00\x00", 0)
    sender.tick(0, ETA, NU)
