# SPDX-License-Identifier: MIT
"""A navigation unit's messages, decoded by pymavlink."""

from collections import Counter
from math import atan2, cos, hypot, isnan, pi, sin
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pymavlink.dialects.v20 import common as mavlink

from sil.wire.geodesy import LocalFrame
from sil.wire.navigation_unit import Message, NavigationUnit, Settings

ORIGIN = (541234567, 101234567, 12000)
ETA, NU = (12.5, -3.25, 2.0), (1.5, 0.25, -0.125)
OFFSET_US = 3 * 3600 * 1_000_000 + 7


def unit(
    message: Message = "local",
    rate_hz: float = 10.0,
    attitude_rate_hz: float = 0.0,
    origin_m: tuple[float, float] = (0.0, 0.0),
) -> NavigationUnit:
    return NavigationUnit(
        2,
        201,
        vehicle_type=mavlink.MAV_TYPE_GPS,
        origin=ORIGIN,
        settings=Settings(rate_hz, message, attitude_rate_hz, origin_m),
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


def test_a_state_as_global_position_and_attitude_comes_back() -> None:
    m = by_name(unit("global").tick(7_654_321, ETA, NU))
    position, attitude = m["GLOBAL_POSITION_INT"], m["ATTITUDE"]
    assert "LOCAL_POSITION_NED" not in m
    assert position.time_boot_ms == attitude.time_boot_ms == 7654
    here = LocalFrame(position.lat, position.lon).seen_from(LocalFrame(*ORIGIN[:2]), 0.0, 0.0, 0.0)
    assert here[:2] == pytest.approx(ETA[:2], abs=0.006)
    assert (position.alt, position.hdg, position.vz) == (12000, 65535, 0)
    u = position.vx * cos(2.0) + position.vy * sin(2.0)
    v = -position.vx * sin(2.0) + position.vy * cos(2.0)
    assert (u, v) == pytest.approx((150.0, 25.0), abs=0.8)
    assert attitude.yaw == pytest.approx(2.0)


def test_a_state_as_follow_target_comes_back() -> None:
    m = by_name(unit("follow_target").tick(7_654_321, ETA, NU))
    assert "ATTITUDE" not in m
    target = m["FOLLOW_TARGET"]
    assert (target.timestamp, target.est_capabilities) == (7654, 11)
    here = LocalFrame(target.lat, target.lon).seen_from(LocalFrame(*ORIGIN[:2]), 0.0, 0.0, 0.0)
    assert here[:2] == pytest.approx(ETA[:2], abs=0.006)
    assert target.alt == 12.0
    u = target.vel[0] * cos(2.0) + target.vel[1] * sin(2.0)
    v = -target.vel[0] * sin(2.0) + target.vel[1] * cos(2.0)
    assert (u, v) == pytest.approx((1.5, 0.25), abs=1e-5)
    w, x, y, z = target.attitude_q
    assert 2.0 * atan2(z, w) == pytest.approx(2.0, abs=1e-5)
    assert (x, y, target.rates[2]) == (0.0, 0.0, -0.125)


def test_a_unit_whose_frame_begins_elsewhere_is_at_the_same_place() -> None:
    m = by_name(unit(origin_m=(1400.0, -900.0)).tick(7_654_321, ETA, NU))
    origin, position = m["GPS_GLOBAL_ORIGIN"], m["LOCAL_POSITION_NED"]
    height_m = 0.001 * ORIGIN[2]
    own = LocalFrame(origin.latitude, origin.longitude, height_m)
    world = LocalFrame(*ORIGIN[:2], height_m)
    assert own.seen_from(world, 0.0, 0.0, 0.0)[:2] == pytest.approx((1400.0, -900.0), abs=0.01)
    yaw = m["ATTITUDE"].yaw
    assert own.seen_from(world, position.x, position.y, yaw) == pytest.approx(ETA, abs=2e-4)
    # Another north: a tenth of a milliradian.
    assert 1e-4 < abs(yaw - ETA[2]) < 3e-4
    assert atan2(position.vy, position.vx) - yaw == pytest.approx(atan2(0.25, 1.5), abs=1e-6)


@pytest.mark.parametrize("message", ["local", "global"])
def test_attitude_may_come_at_its_own_rate(message: Message) -> None:
    sender = unit(message, rate_hz=5.0, attitude_rate_hz=10.0)
    count: Counter[str] = Counter()
    for t in range(OFFSET_US, OFFSET_US + 10_000_000, 10_000):
        names = [m.get_type() for m in parsed(sender.tick(t, ETA, NU))]
        assert names[-2:] != ["GLOBAL_POSITION_INT", "ATTITUDE"], "attitude first"
        count.update(names)
    position = "LOCAL_POSITION_NED" if message == "local" else "GLOBAL_POSITION_INT"
    assert (count[position], count["ATTITUDE"]) == (50, 100)


def test_origin_and_heartbeat_have_the_units_position_and_type() -> None:
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


def test_an_answer_has_the_time_at_which_the_request_was_read() -> None:
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


def test_an_answer_to_another_system_is_not_answered() -> None:
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


def test_a_late_unit_sends_each_state_later_with_the_stamp_of_that_state() -> None:
    settings = Settings(10.0, delay_s=0.2)
    late = NavigationUnit(2, 201, vehicle_type=0, origin=ORIGIN, settings=settings)
    told = {}
    for now_us in range(1_000_000, 2_000_000, 10_000):
        for message in parsed(late.tick(now_us, (1e-6 * now_us, 0.0, 0.0), NU)):
            if message.get_type() == "LOCAL_POSITION_NED":
                told[now_us // 1000] = (message.time_boot_ms, round(message.x, 3))
    assert told == {ms: (ms - 200, (ms - 200) / 1000) for ms in range(1200, 2000, 100)}


def test_a_late_unit_answers_timesync_at_once_and_one_that_is_deaf_to_it_never() -> None:
    request = mavlink.MAVLink(None, 7, 1).timesync_encode(0, 5).pack(mavlink.MAVLink(None, 7, 1))
    for settings, answers in (
        (Settings(10.0, delay_s=0.2), 1),
        (Settings(10.0, timesync=False), 0),
    ):
        asked = NavigationUnit(2, 201, vehicle_type=0, origin=ORIGIN, settings=settings)
        asked.on_mavlink(request, 1_000_000)
        messages = parsed(asked.tick(1_000_000, ETA, NU))
        assert [m.get_type() for m in messages].count("TIMESYNC") == answers


def test_a_unit_drops_out_with_the_given_period_and_duration() -> None:
    settings = Settings(20.0, dropout_every_s=2.0, dropout_s=0.5)
    dropping = NavigationUnit(2, 201, vehicle_type=0, origin=ORIGIN, settings=settings)
    told = []
    for now_us in range(10_000_000, 14_000_000, 50_000):
        if "LOCAL_POSITION_NED" in by_name(dropping.tick(now_us, ETA, NU)):
            told.append(now_us)
    assert told == [
        us for us in range(10_000_000, 14_000_000, 50_000) if us % 2_000_000 < 1_500_000
    ]
