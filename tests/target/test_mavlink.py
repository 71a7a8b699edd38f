# SPDX-License-Identifier: MIT
"""The boat's MAVLink against pymavlink: what it sends, what it understands, what it refuses."""

from __future__ import annotations

import math
import random
from collections import defaultdict
from collections.abc import Callable
from typing import Any

import flotilla
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pymavlink.dialects.v20 import common as mavlink

from tests.target.harness import (
    ARM,
    ARMED_BIT,
    BOAT,
    FORCE,
    FORMATION,
    GCS,
    GCS_COMPONENT,
    HOLD,
    LEADER,
    NAVIGATION,
    ORIGIN,
    SET_MODE,
    START_US,
    STRANGER,
    Course,
    Sea,
    Station,
    Tick,
    attitude,
    command_long,
    decode,
    heartbeat,
    local_position,
    messages,
    named,
    odometry,
    origin,
    quaternion,
    seeded,
    signed,
    texts,
    wrap,
)

ACCEPTED, TEMPORARILY_REJECTED, DENIED, UNSUPPORTED = 0, 1, 2, 3
STANDBY, ACTIVE, CRITICAL, EMERGENCY = 3, 4, 5, 6
BAD = ("NaN", math.nan), ("inf", math.inf), ("-inf", -math.inf)
SENT = {
    "HEARTBEAT",
    "TIMESYNC",
    "ATTITUDE",
    "LOCAL_POSITION_NED",
    "GPS_GLOBAL_ORIGIN",
    "COMMAND_ACK",
    "STATUSTEXT",
}


def refused(sea: Sea) -> int:
    """How many messages or bytes the boat has counted as bad, whatever the reason."""
    return sum(
        sea.counter(name)
        for name in (
            "mavlink_bad_checksum",
            "mavlink_skipped_bytes",
            "mavlink_bad_value",
            "mavlink_bad_frame",
            "mavlink_old_stamp",
        )
    )


def own_course(sea: Sea) -> Course:
    """The boat's own state, as it tells others in the last message pair."""
    position = named(sea.ticks[-30:], "LOCAL_POSITION_NED")[-1]
    turn = named(sea.ticks[-30:], "ATTITUDE")[-1]
    c, s = math.cos(turn.yaw), math.sin(turn.yaw)
    u, v = c * position.vx + s * position.vy, -s * position.vx + c * position.vy
    return Course(position.x, position.y, turn.yaw, u, v, turn.yawspeed)


def close(one: Course, other: Course, tolerance: float = 1e-4) -> bool:
    return (
        math.hypot(one.north - other.north, one.east - other.east) < tolerance
        and abs(wrap(one.psi - other.psi)) < tolerance
        and math.hypot(one.u - other.u, one.v - other.v) < tolerance
        and abs(one.r - other.r) < tolerance
    )


def acks(tick: Tick, link: int = 0) -> list[tuple[int, int]]:
    return [(m.command, m.result) for m in tick.named("COMMAND_ACK", link)]


# --- what the boat sends -------------------------------------------------------------------------


@pytest.fixture(scope="module")
def session() -> Sea:
    """Ten minutes that show everything a boat ever says, on two links."""
    sea = Sea({"CTL_RATE": 50}, links=2, own=Course(3.0, -4.0, 2.5, 0.6, 0.1, 0.05))
    sea.leader.answers_timesync = True
    sea.run(1.0)
    sea.own.on = False
    sea.run(1.0)
    sea.arm()  # refused
    sea.own.on = True
    sea.run(1.0)
    for k in range(20):
        sea.arm()
        sea.run(1.0 + k % 3)
        sea.mode(FORMATION)
        sea.run(5.0)
        silent = (sea.leader, sea.own, sea.escs[k % 2])[k % 3]
        silent.on = False  # HOLD, HOLD, FAULT
        sea.run(2.0)
        silent.on = True
        sea.order(511, 30.0, 1e5)
        sea.run(1.0)
        sea.say(mavlink.MAVLink_timesync_message(0, 10**15 + k), link=1)
        sea.say(odometry(Course(), sea.now_us, frame_id=20), sender=sea.own.station)
        sea.order(ARM, 0.0)
        sea.run(20.0)
    return sea


@pytest.fixture(scope="module")
def session_messages(session: Sea) -> list[list[Any]]:
    return [messages(session.ticks, link) for link in (0, 1)]


def test_pymavlink_finds_no_bad_byte_in_all_that_a_boat_sends(
    session_messages: list[list[Any]],
) -> None:
    for link in session_messages:
        assert len(link) > 5000
        assert not [
            m for m in link if m.get_type() == "BAD_DATA" or m.get_type().startswith("UNKNOWN")
        ]


def test_a_long_session_shows_every_kind_of_message_and_no_other(
    session_messages: list[list[Any]],
) -> None:
    assert {m.get_type() for m in session_messages[0]} == SENT
    assert {m.get_type() for m in session_messages[1]} == SENT - {"COMMAND_ACK"}


def test_a_boat_never_sends_odometry(session_messages: list[list[Any]]) -> None:
    assert all(m.get_type() != "ODOMETRY" for link in session_messages for m in link)


def test_every_frame_is_mavlink_2_unsigned_and_with_the_boats_ids(
    session_messages: list[list[Any]],
) -> None:
    for link in session_messages:
        for m in link:
            assert m.get_msgbuf()[0] == 0xFD and m.get_msgbuf()[2] == 0
            assert (m.get_srcSystem(), m.get_srcComponent()) == (BOAT, 1)


def test_each_link_counts_its_own_frames_without_a_gap(session_messages: list[list[Any]]) -> None:
    for link in session_messages:
        numbers = [m.get_seq() for m in link]
        assert numbers == [(numbers[0] + k) % 256 for k in range(len(numbers))]
    assert len(session_messages[0]) != len(session_messages[1])


def test_pymavlink_packs_the_same_bytes_from_what_it_decoded(
    session_messages: list[list[Any]],
) -> None:
    for m in session_messages[0]:
        if m.get_type() == "TIMESYNC":
            continue  # the wheel's TIMESYNC has no target fields
        again = mavlink.MAVLink(None, BOAT, 1)
        again.seq = m.get_seq()
        assert m.pack(again) == bytes(m.get_msgbuf())


def test_a_chunk_holds_whole_frames_for_one_link_and_comes_once_a_tick(session: Sea) -> None:
    for tick in session.ticks:
        links = [link for link, _ in tick.mavlink]
        assert len(links) == len(set(links)) and set(links) <= {0, 1}
        for _, data in tick.mavlink:
            start = 0
            while start < len(data):
                assert data[start] == 0xFD
                start += 12 + data[start + 1]
            assert start == len(data)


def test_the_heartbeat_tells_vehicle_mode_and_status(session: Sea) -> None:
    expected = {
        "DISARMED": (1, HOLD, STANDBY),
        "HOLD": (1 | ARMED_BIT, HOLD, ACTIVE),
        "FORMATION": (1 | ARMED_BIT, FORMATION, ACTIVE),
        "FAULT": (1, HOLD, EMERGENCY),
    }
    seen, state = set(), "DISARMED"
    for tick in session.ticks:
        for said in tick.named("STATUSTEXT"):
            if said.text.split(":")[0] in expected:
                state = said.text.split(":")[0]
        for m in tick.named("HEARTBEAT"):
            assert (m.type, m.autopilot, m.mavlink_version) == (11, 0, 3)
            assert (m.base_mode, m.custom_mode, m.system_status) == expected[state]
            seen.add(state)
    assert seen == set(expected)


def test_the_heartbeat_comes_every_second_whatever_happens(session: Sea) -> None:
    times = [tick.now_us for tick in session.ticks if tick.named("HEARTBEAT")]
    assert max(np.diff(times)) <= 1_000_000
    assert len(times) < (times[-1] - times[0]) / 1e6 + 100  # and not at each tick


def test_a_heartbeat_follows_every_change_of_state_at_once(sea: Sea) -> None:
    sea.settle()
    assert sea.arm().named("HEARTBEAT")[-1].base_mode & ARMED_BIT
    assert sea.mode(FORMATION).named("HEARTBEAT")[-1].custom_mode == FORMATION
    assert sea.mode(HOLD).named("HEARTBEAT")[-1].custom_mode == HOLD
    assert not sea.disarm().named("HEARTBEAT")[-1].base_mode & ARMED_BIT


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


def test_a_state_is_stamped_with_the_time_of_that_state(session: Sea) -> None:
    stamps = []
    for tick in session.ticks:
        turns = {m.time_boot_ms: m for m in tick.named("ATTITUDE")}
        for m in tick.named("LOCAL_POSITION_NED"):
            truth = session.own.truth(m.time_boot_ms * 1000)
            assert abs(m.time_boot_ms - tick.now_us / 1000) < 500
            assert math.hypot(m.x - truth.north, m.y - truth.east) < 0.02
            assert math.hypot(m.vx - truth.velocity_n[0], m.vy - truth.velocity_n[1]) < 0.02
            turn = turns[m.time_boot_ms]
            assert abs(wrap(turn.yaw - truth.psi)) < 0.02
            assert turn.yawspeed == pytest.approx(truth.r, abs=1e-3)
            stamps.append(m.time_boot_ms)
    assert stamps == sorted(set(stamps))


@pytest.mark.parametrize("rate_hz", [5.0, 20.0])
def test_a_turning_boat_sends_the_position_that_belongs_to_the_stamp(rate_hz: float) -> None:
    sea = Sea({"SR_STATE": 50}, own=Course(1.0, 2.0, 0.3, 1.0, 0.1, 0.2))
    sea.own.period_us = round(1e6 / rate_hz)
    sea.run(5.0)
    for m in named(sea.ticks, "LOCAL_POSITION_NED"):
        truth = sea.own.truth(m.time_boot_ms * 1000)
        assert math.hypot(m.x - truth.north, m.y - truth.east) < 0.001


def test_nothing_about_the_own_state_goes_out_when_it_is_stale(sea: Sea) -> None:
    about_own_state = {"LOCAL_POSITION_NED", "ATTITUDE", "GPS_GLOBAL_ORIGIN"}
    assert not about_own_state & {m.get_type() for m in messages([sea.tick_only()])}
    sea.run(1.0)
    sea.own.on = False
    sea.run(0.6)
    sea.ticks.clear()
    sea.run(5.0)
    kinds = [m.get_type() for m in messages(sea.ticks)]
    assert set(kinds) == {"HEARTBEAT", "TIMESYNC"} and kinds.count("HEARTBEAT") == 5
    sea.own.on = True
    sea.run(1.2)
    assert about_own_state <= {m.get_type() for m in messages(sea.ticks)}


def test_without_own_origin_no_origin_is_sent(sea: Sea) -> None:
    sea.own.origin_on = False
    sea.run(3.0)
    assert not named(sea.ticks, "GPS_GLOBAL_ORIGIN")


def test_the_antennas_place_is_taken_off_position_and_velocity() -> None:
    # v of the antenna = v of the boat + r × place: u − r·y_ofs, v + r·x_ofs.
    sea = Sea({"NAV_OFS_X": 2.0, "NAV_OFS_Y": -1.0})
    sea.own.on = False
    antenna = Course(10.0, 20.0, math.pi / 2, 1.0, 0.0, 0.5)
    sea.say(odometry(antenna, sea.now_us), sender=sea.own.station)
    sea.step()
    # Heading east: ahead is east, starboard is south.
    expected = Course(10.0 - 1.0, 20.0 - 2.0, math.pi / 2, 1.0 + 0.5 * -1.0, 0.0 - 0.5 * 2.0, 0.5)
    assert close(own_course(sea), expected)


def test_own_ids_are_the_parameters() -> None:
    sea = Sea({"MAV_SYSID": 42, "MAV_COMPID": 7})
    sea.own.station = Station(42, NAVIGATION)
    sea.run(1.0)
    assert {(m.get_srcSystem(), m.get_srcComponent()) for m in messages(sea.ticks)} == {(42, 7)}
    assert sea.condition("own_fresh")


def test_four_links_hear_the_same_and_each_has_its_own_sequence() -> None:
    sea = Sea(links=4)
    sea.settle()
    for link in (2, 2, 2, 0):
        tick = sea.order(ARM, 1.0, link=link)
        assert [acks(tick, at) != [] for at in range(4)] == [at == link for at in range(4)]
    sea.run(1.0)
    heard = [messages(sea.ticks, link) for link in range(4)]
    for said in heard:
        assert [m.get_seq() for m in said] == [k % 256 for k in range(len(said))]
        broadcast = [str(m) for m in said if m.get_type() != "COMMAND_ACK"]
        assert broadcast == [str(m) for m in heard[3]]
    assert [len(said) - len(heard[3]) for said in heard] == [1, 0, 3, 0]


def test_bytes_of_one_link_do_not_disturb_a_frame_half_received_on_another() -> None:
    sea = Sea(links=2)
    nav, other = sea.own.station, Station(BOAT, NAVIGATION)
    first = nav.pack(odometry(Course(1, 1), sea.now_us))
    second = other.pack(origin())
    sea.boat.on_mavlink(first[:50], sea.now_us, 0)
    sea.boat.on_mavlink(second[:9], sea.now_us, 1)
    sea.boat.on_mavlink(first[50:], sea.now_us, 0)
    sea.boat.on_mavlink(second[9:], sea.now_us, 1)
    assert sea.counter("mavlink_received") == 2 and refused(sea) == 0


# --- what the boat understands -------------------------------------------------------------------

KINDS: dict[str, Callable[[Sea], tuple[Station, Any]]] = {
    "own ODOMETRY": lambda sea: (
        sea.own.station,
        odometry(Course(7, 8, 0.9, 1, 0, 0.1), sea.now_us),
    ),
    "own LOCAL_POSITION_NED": lambda sea: (
        sea.own.station,
        local_position(Course(7, 8), sea.now_us),
    ),
    "own ATTITUDE": lambda sea: (sea.own.station, attitude(Course(7, 8, 0.9), sea.now_us)),
    "own GPS_GLOBAL_ORIGIN": lambda sea: (sea.own.station, origin(sea.now_us, latitude=123456789)),
    "leader ODOMETRY": lambda sea: (sea.leader.station, odometry(Course(7, 8, 0.9, 1), sea.now_us)),
    "leader LOCAL_POSITION_NED": lambda sea: (
        sea.leader.station,
        local_position(Course(7, 8), sea.now_us),
    ),
    "leader ATTITUDE": lambda sea: (sea.leader.station, attitude(Course(7, 8, 0.9), sea.now_us)),
    "leader GPS_GLOBAL_ORIGIN": lambda sea: (sea.leader.station, origin(sea.now_us)),
    "leader HEARTBEAT": lambda sea: (sea.leader.station, heartbeat()),
    "TIMESYNC request": lambda sea: (
        sea.gcs,
        mavlink.MAVLink_timesync_message(0, 0x123456789ABCDEF),
    ),
    "TIMESYNC answer": lambda sea: (sea.leader.station, mavlink.MAVLink_timesync_message(1, 2)),
    "COMMAND_LONG arm": lambda sea: (sea.gcs, command_long(ARM, 1.0)),
    "COMMAND_LONG mode": lambda sea: (sea.gcs, command_long(SET_MODE, 1.0, 4.0)),
    "COMMAND_LONG other": lambda sea: (sea.gcs, command_long(512, 148.0)),
}


def prepared() -> Sea:
    sea = Sea()
    sea.settle()
    return sea


def outcome(sea: Sea) -> tuple[object, ...]:
    """What a second of the boat's life shows, to the byte."""
    ticks = sea.run(0.3)
    return [(t.mavlink, t.can) for t in ticks], str(sea.snapshot())


@pytest.mark.parametrize("kind", KINDS)
def test_a_message_may_be_split_at_every_byte(kind: str) -> None:
    whole = prepared()
    sender, message = KINDS[kind](whole)
    wire = sender.pack(message)
    whole.boat.on_mavlink(wire, whole.now_us)
    before = whole.counter("mavlink_received")
    expected = outcome(whole)
    for cut in range(1, len(wire)):
        sea = prepared()
        sender, message = KINDS[kind](sea)
        sender.encoder.seq = (sender.encoder.seq + 1) % 256
        sea.boat.on_mavlink(wire[:cut], sea.now_us)
        assert sea.counter("mavlink_received") == before - 1
        sea.boat.on_mavlink(wire[cut:], sea.now_us)
        assert sea.counter("mavlink_received") == before
        if cut % 16 == 1:
            assert outcome(sea) == expected


@pytest.mark.parametrize(
    ("kind", "version1"),
    [(kind, False) for kind in KINDS] + [(kind, True) for kind in KINDS if "ODOMETRY" not in kind],
)
def test_every_kind_is_understood_byte_by_byte(kind: str, version1: bool) -> None:
    whole, bytewise = prepared(), prepared()
    for sea, step in ((whole, 1000), (bytewise, 1)):
        sender, message = KINDS[kind](sea)
        received = sea.counter("mavlink_received")
        wire = sender.pack(message, version1=version1)
        for start in range(0, len(wire), step):
            sea.boat.on_mavlink(wire[start : start + step], sea.now_us)
        assert sea.counter("mavlink_received") == received + 1
        assert refused(sea) == 0 or kind == "TIMESYNC answer"
    assert outcome(whole) == outcome(bytewise)


def test_several_frames_may_share_a_chunk() -> None:
    apart, together = prepared(), prepared()
    chunks = []
    for sea in (apart, together):
        pairs = [make(sea) for name, make in KINDS.items() if "own" not in name]
        chunks = [sender.pack(message) for sender, message in pairs]
        for chunk in chunks if sea is apart else [b"".join(chunks)]:
            sea.boat.on_mavlink(chunk, sea.now_us)
    assert together.counter("mavlink_received") == apart.counter("mavlink_received")
    assert outcome(together) == outcome(apart)
    assert together.state == "HOLD"


def test_a_hundred_frames_in_one_chunk_are_all_heard(sea: Sea) -> None:
    wire = b"".join(
        sea.own.station.pack(odometry(Course(k, 0), START_US - (100 - k) * 1000))
        for k in range(100)
    )
    sea.boat.on_mavlink(wire, sea.now_us)
    assert sea.counter("mavlink_received") == 100 and refused(sea) == 0


@pytest.mark.parametrize("version1", [False, True], ids=["MAVLink 2", "MAVLink 1"])
def test_a_mavlink_1_and_a_mavlink_2_station_command_alike(version1: bool) -> None:
    sea = prepared()
    sea.boat.on_mavlink(sea.gcs.pack(command_long(ARM, 1.0), version1=version1), sea.now_us)
    assert acks(sea.step()) == [(ARM, ACCEPTED)]
    assert sea.state == "HOLD"


def test_signed_frames_are_understood_on_a_link_without_signing() -> None:
    sea = Sea()
    sea.own.station, sea.gcs = signed(sea.own.station), signed(sea.gcs)
    sea.leader.station = signed(sea.leader.station)
    sea.enter_formation()
    sea.run(1.0)
    assert sea.state == "FORMATION" and refused(sea) == 0


@pytest.mark.parametrize("seed", range(6))
def test_good_frames_are_heard_again_soon_after_garbage(seed: int) -> None:
    rng = random.Random(seed)
    sea = Sea()
    whole = sea.own.station.pack(odometry(Course(), sea.now_us))
    garbage = [
        rng.randbytes(rng.randrange(1, 2000)),
        b"\xfd" * rng.randrange(1, 2000),
        b"\xfe" * rng.randrange(1, 2000),
        whole[: rng.randrange(1, len(whole))],
        b"\x00" * rng.randrange(1, 2000),
        b"\xfd\xff" * 300,
    ]
    for piece in garbage:
        good = [sea.own.station.pack(odometry(Course(k), sea.now_us + 1000 * k)) for k in range(12)]
        received = sea.counter("mavlink_received")
        sea.boat.on_mavlink(piece + b"".join(good), sea.now_us)
        # A truncated frame may swallow one frame's length (280 bytes), no more.
        assert sea.counter("mavlink_received") - received >= 12 - 1 - math.ceil(280 / len(good[0]))
        sea.now_us += 12_000
    assert refused(sea) > 0


@seeded(max_examples=60)
@given(st.binary(max_size=600), st.integers(0, 300))
def test_no_garbage_keeps_a_boat_deaf(garbage: bytes, cut: int) -> None:
    sea = Sea()
    sea.boat.on_mavlink(garbage, sea.now_us)
    sea.boat.on_mavlink(sea.own.station.pack(odometry(Course(), sea.now_us))[:cut], sea.now_us)
    sea.run(0.4)
    assert sea.condition("own_fresh")
    assert sea.state == "DISARMED"


def test_frames_of_messages_that_the_boat_does_not_know_are_passed_over(sea: Sea) -> None:
    sea.settle()
    before = refused(sea)
    for message in (
        mavlink.MAVLink_vfr_hud_message(1, 2, 3, 4, 5, 6),
        mavlink.MAVLink_sys_status_message(0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0),
        mavlink.MAVLink_mission_count_message(BOAT, 1, 3),
        mavlink.MAVLink_statustext_message(3, b"hello"),
        mavlink.MAVLink_battery_status_message(0, 0, 0, 0, [0] * 10, 0, 0, 0, 0),
    ):
        sea.say(message)
    sea.run(0.1)
    assert refused(sea) == before and sea.condition("own_fresh")


# The frames of ODOMETRY. P maps north-east-down to east-north-up.
P = np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]])


def rotation(roll: float, pitch: float, yaw: float) -> np.ndarray:
    cr, sr, cp, sp = math.cos(roll), math.sin(roll), math.cos(pitch), math.sin(pitch)
    cy, sy = math.cos(yaw), math.sin(yaw)
    about_x = np.array([[1, 0, 0], [0, cr, -sr], [0, sr, cr]])
    about_y = np.array([[cp, 0, sp], [0, 1, 0], [-sp, 0, cp]])
    about_z = np.array([[cy, -sy, 0], [sy, cy, 0], [0, 0, 1]])
    return np.asarray(about_z @ about_y @ about_x)


def product(a: list[float], b: list[float]) -> list[float]:
    aw, (ax, ay, az) = a[0], a[1:]
    bw, (bx, by, bz) = b[0], b[1:]
    return [
        aw * bw - ax * bx - ay * by - az * bz,
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
    ]


@pytest.mark.parametrize("frame", [1, 4], ids=["LOCAL_NED", "LOCAL_ENU"])
@pytest.mark.parametrize(
    "child", [12, 8, 1, 4], ids=["BODY_FRD", "BODY_NED", "LOCAL_NED", "LOCAL_ENU"]
)
@pytest.mark.parametrize("tilt", [0.0, 0.2], ids=["level", "tilted"])
def test_odometry_is_rotated_by_its_frames(frame: int, child: int, tilt: float) -> None:
    rng = random.Random(frame * 100 + child)
    for _ in range(10):
        sea = Sea(own=Course())
        truth = Course(rng.uniform(-50, 50), rng.uniform(-50, 50), rng.uniform(-3.1, 3.1))
        roll, pitch = rng.uniform(-tilt, tilt), rng.uniform(-tilt, tilt)
        velocity_n = np.array([rng.uniform(-2, 2), rng.uniform(-2, 2), 0.0])
        q, position = quaternion(roll, pitch, truth.psi), np.array([truth.north, truth.east, 0.0])
        if frame == 4:
            half = math.sqrt(0.5)
            q, position = product([0.0, half, half, 0.0], q), P @ position
        velocity = {
            12: rotation(roll, pitch, truth.psi).T @ velocity_n,
            8: rotation(roll, pitch, truth.psi).T @ velocity_n,
            1: velocity_n,
            4: P @ velocity_n,
        }[child]
        x, y, z = position
        vx, vy, vz = velocity
        wire = {"x": x, "y": y, "z": z, "vx": vx, "vy": vy, "vz": vz, "q": q}
        sea.own.on = False
        sea.say(
            odometry(truth, sea.now_us, frame_id=frame, child_frame_id=child, **wire),
            sender=sea.own.station,
        )
        sea.step()
        told = named(sea.ticks, "LOCAL_POSITION_NED")[-1]
        assert (told.x, told.y) == pytest.approx((truth.north, truth.east), abs=1e-4)
        assert (told.vx, told.vy) == pytest.approx(tuple(velocity_n[:2]), abs=1e-4)
        assert wrap(named(sea.ticks, "ATTITUDE")[-1].yaw - truth.psi) == pytest.approx(
            0.0, abs=1e-4
        )


@pytest.mark.parametrize("child", [12, 1])
def test_the_yaw_rate_of_odometry_is_kept(child: int) -> None:
    for frame, psi, rate in ((1, 0.4, 0.3), (4, -2.0, -0.2)):
        sea = Sea()
        sea.own.on = False
        q = quaternion(0, 0, psi)
        q = q if frame == 1 else product([0.0, math.sqrt(0.5), math.sqrt(0.5), 0.0], q)
        sea.say(
            odometry(
                Course(0, 0, psi, r=rate), sea.now_us, frame_id=frame, child_frame_id=child, q=q
            ),
            sender=sea.own.station,
        )
        sea.step()
        assert named(sea.ticks, "ATTITUDE")[-1].yawspeed == pytest.approx(rate)


@pytest.mark.parametrize("frame", [20, 21], ids=["LOCAL_FRD", "LOCAL_FLU"])
def test_a_frame_that_is_not_north_aligned_is_refused_and_said(frame: int) -> None:
    sea = Sea()
    sea.own.on = False
    sea.say(origin(sea.now_us), sender=sea.own.station)
    for _ in range(20):
        sea.say(odometry(Course(), sea.now_us, frame_id=frame), sender=sea.own.station)
        sea.run(0.05)
    assert not sea.condition("own_fresh")
    assert sea.counter("mavlink_bad_frame") == 20
    said = texts(sea.ticks)
    assert any("ODOMETRY" in text and "frame" in text for text in said)
    assert len(said) <= 3, "said once in a while, not at every message"


@pytest.mark.parametrize(
    ("frame", "child"), [(0, 12), (13, 12), (16, 12), (255, 12), (1, 0), (1, 13), (1, 255)]
)
def test_a_frame_that_is_not_legal_is_refused(frame: int, child: int) -> None:
    sea = Sea()
    sea.own.on = False
    message = odometry(Course(), sea.now_us, frame_id=frame, child_frame_id=child)
    sea.say(message, sender=sea.own.station)
    sea.step()
    assert not sea.condition("own_fresh") and refused(sea) == 1


def test_the_own_state_may_come_as_local_position_and_attitude(sea: Sea) -> None:
    sea.own.on = False
    truth = Course(4.0, -3.0, 1.2, 0.8, -0.1, 0.15)
    for _ in range(10):
        here = truth.at((sea.now_us - START_US) * 1e-6)
        sea.say(
            local_position(here, sea.now_us), attitude(here, sea.now_us), sender=sea.own.station
        )
        sea.run(0.1)
    assert sea.condition("own_fresh")
    last = named(sea.ticks, "LOCAL_POSITION_NED")[-1].time_boot_ms
    assert close(own_course(sea), truth.at((last * 1000 - START_US) * 1e-6), 5e-3)


@pytest.mark.parametrize("missing", ["LOCAL_POSITION_NED", "ATTITUDE"])
def test_half_a_state_is_no_state(missing: str) -> None:
    sea = Sea()
    sea.own.on = False
    for _ in range(20):
        half = attitude if missing == "LOCAL_POSITION_NED" else local_position
        sea.say(half(Course(), sea.now_us), sender=sea.own.station)
        sea.run(0.05)
    assert not sea.condition("own_fresh")


def test_a_leader_may_send_local_position_and_attitude(sea: Sea) -> None:
    sea.leader.on = False
    truth = Course(4.0, -3.0, 1.2)
    for _ in range(10):
        sea.say(
            origin(sea.now_us),
            local_position(truth, sea.now_us),
            attitude(truth, sea.now_us),
            sender=sea.leader.station,
        )
        sea.run(0.1)
    assert sea.condition("leader_fresh")
    error = sea.snapshot()["error"]
    own = sea.own.course
    north, east = own.north - truth.north, own.east - truth.east
    c, s = math.cos(own.psi), math.sin(own.psi)
    assert error["x_m"] == pytest.approx(c * north + s * east, abs=1e-3)
    assert error["y_m"] == pytest.approx(-s * north + c * east, abs=1e-3)
    assert error["psi_rad"] == pytest.approx(wrap(own.psi - truth.psi), abs=1e-4)


def test_a_quaternion_a_little_off_its_length_is_normalised(sea: Sea) -> None:
    sea.own.on = False
    q = [0.98 * x for x in quaternion(0, 0, 0.7)]
    sea.say(odometry(Course(), sea.now_us, q=q), sender=sea.own.station)
    sea.step()
    assert own_course(sea).psi == pytest.approx(0.7, abs=1e-4)


@pytest.mark.parametrize("offset_s", [0.0, -9.0, 1.7e9], ids=["the boat's", "another boot", "Unix"])
def test_the_navigation_units_clock_may_be_any(offset_s: float) -> None:
    sea = Sea(own=Course(0, 0, 0, 1.0))
    sea.own.clock_offset_us = round(offset_s * 1e6)
    sea.run(3.0)
    assert sea.condition("own_fresh")
    m = named(sea.ticks, "LOCAL_POSITION_NED")[-1]
    assert abs(m.time_boot_ms - sea.now_us / 1000) < 200, "own stamps are in the boat's own clock"
    assert m.x == pytest.approx(sea.own.truth(m.time_boot_ms * 1000).north, abs=0.01)


# --- who counts ----------------------------------------------------------------------------------


def test_the_boats_own_echo_is_not_its_navigation_unit(sea: Sea) -> None:
    sea.own.on = False
    echo = Station(BOAT, 1)
    for _ in range(20):
        sea.say(
            odometry(Course(), sea.now_us),
            origin(),
            local_position(Course(), sea.now_us),
            sender=echo,
        )
        sea.say(attitude(Course(), sea.now_us), sender=echo)
        sea.run(0.05)
    assert not sea.condition("own_fresh")


def test_all_that_the_boat_says_may_come_back_to_it() -> None:
    quiet, echoing = Sea(), Sea()
    for sea in (quiet, echoing):
        sea.enter_formation()
        for _ in range(300):
            tick = sea.step()
            if sea is echoing:
                for _, data in tick.mavlink:
                    sea.boat.on_mavlink(data, sea.now_us)
    assert quiet.commands == echoing.commands and echoing.state == "FORMATION"


@pytest.mark.parametrize("system", [3, STRANGER, GCS, 0])
def test_a_foreign_system_is_neither_own_state_nor_leader(system: int) -> None:
    sea = Sea()
    sea.own.on = sea.leader.on = False
    foreign = Station(system, NAVIGATION)
    for _ in range(20):
        sea.say(
            odometry(Course(), sea.now_us),
            origin(sea.now_us),
            local_position(Course(), sea.now_us),
            attitude(Course(), sea.now_us),
            sender=foreign,
        )
        sea.run(0.05)
    assert not sea.condition("own_fresh") and not sea.condition("leader_fresh")
    assert sea.snapshot()["own_age_s"] is None and sea.snapshot()["leader_age_s"] is None


def leader_north(sea: Sea) -> float:
    """Where the boat, heading north at the origin, takes its leader to be."""
    return float(-sea.snapshot()["error"]["x_m"])


def test_of_a_leaders_components_the_first_one_counts_where_it_is_heard() -> None:
    sea = Sea(own=Course())
    sea.leader.on = False
    nine, five, one = Station(LEADER, 9), Station(LEADER, 5), Station(LEADER, 1)
    for speakers, expected in (([nine], 90.0), ([nine, five], 50.0), ([nine, five, one], 10.0)):
        for _ in range(40):
            for speaker in speakers:
                here = Course(10.0 * speaker.component)
                sea.say(origin(sea.now_us), odometry(here, sea.now_us), sender=speaker)
            sea.run(0.05)
        assert leader_north(sea) == pytest.approx(expected, abs=0.01)


@pytest.mark.parametrize("whose", [LEADER, BOAT], ids=["leader", "own"])
def test_the_origin_of_another_component_does_not_count(whose: int) -> None:
    sea = Sea()
    sea.run(1.5)
    error = sea.snapshot()["error"]
    sea.say(origin(0, ORIGIN[0] + 5000, ORIGIN[1]), sender=Station(whose, 250))
    sea.run(0.2)
    assert sea.snapshot()["error"] == pytest.approx(error, abs=1e-3)


@pytest.mark.parametrize("whose", ["own", "leader"])
def test_without_both_origins_a_leaders_local_position_does_not_count(whose: str) -> None:
    sea = Sea()
    getattr(sea, whose).origin_on = False
    sea.run(3.0)
    assert sea.condition("own_fresh") and not sea.condition("leader_fresh")
    getattr(sea, whose).origin_on = True
    sea.run(1.2)
    assert sea.condition("leader_fresh")


def test_origins_of_boat_and_leader_may_differ() -> None:
    sea = Sea(own=Course(), leader=Course())
    sea.leader.origin_on = False
    shift_north, shift_east = 250, -400  # 1e-7 degrees
    sea.say(origin(0, ORIGIN[0] + shift_north, ORIGIN[1] + shift_east), sender=sea.leader.station)
    sea.run(0.3)
    error = sea.snapshot()["error"]
    radius = 6_371_000.0  # 1 % suffices: the ellipsoid's two radii differ by less
    latitude = math.radians(ORIGIN[0] * 1e-7)
    assert -error["x_m"] == pytest.approx(math.radians(shift_north * 1e-7) * radius, rel=0.01)
    assert -error["y_m"] == pytest.approx(
        math.radians(shift_east * 1e-7) * radius * math.cos(latitude), rel=0.01
    )


@pytest.mark.parametrize(
    ("latitude", "longitude"), [(900000001, 0), (-900000001, 0), (0, 1800000001), (0, -(2**31))]
)
def test_an_origin_off_the_globe_is_refused(latitude: int, longitude: int) -> None:
    sea = Sea()
    sea.own.origin_on = False
    sea.say(origin(0, latitude, longitude), sender=sea.own.station)
    sea.run(1.0)
    assert sea.counter("mavlink_bad_value") == 1
    assert not named(sea.ticks, "GPS_GLOBAL_ORIGIN") and not sea.condition("leader_fresh")


# --- what the boat refuses -----------------------------------------------------------------------

ODOMETRY_FIELDS = [
    "x",
    "y",
    "z",
    "vx",
    "vy",
    "vz",
    "rollspeed",
    "pitchspeed",
    "yawspeed",
    "q0",
    "q1",
    "q2",
    "q3",
]
POSITION_FIELDS = ["x", "y", "z", "vx", "vy", "vz"]
ATTITUDE_FIELDS = ["roll", "pitch", "yaw", "rollspeed", "pitchspeed", "yawspeed"]
STATE_FIELDS = [
    *(("ODOMETRY", name) for name in ODOMETRY_FIELDS),
    *(("LOCAL_POSITION_NED", name) for name in POSITION_FIELDS),
    *(("ATTITUDE", name) for name in ATTITUDE_FIELDS),
]


def state_messages(kind: str, truth: Course, now_us: int, **changes: Any) -> list[Any]:
    """A state of that kind, whole; the changes are made to the kind's own message."""
    if kind == "ODOMETRY":
        q = quaternion(0.0, 0.0, truth.psi)
        for k in range(4):
            q[k] = changes.pop(f"q{k}", q[k])
        return [odometry(truth, now_us, **({"q": q} | changes))]
    changed = {"LOCAL_POSITION_NED": {}, "ATTITUDE": {}, kind: changes}
    return [
        local_position(truth, now_us, **changed["LOCAL_POSITION_NED"]),
        attitude(truth, now_us, **changed["ATTITUDE"]),
    ]


def spoil(sea: Sea, agent: str, kind: str, **changes: Any) -> None:
    """Good states, then only bad ones: counted, ignored; the last good one is kept until stale."""
    whose = getattr(sea, agent)
    whose.on = False
    for _ in range(10):
        sea.say(
            origin(sea.now_us),
            *state_messages(kind, whose.course, sea.now_us),
            sender=whose.station,
        )
        sea.run(0.05)
    assert sea.condition(f"{agent}_fresh") and refused(sea) == 0
    good, error = own_course(sea), sea.snapshot()["error"]
    limit_s = {"own": 0.5, "leader": 1.0}[agent]
    sent, elapsed_s = 0, 0.0
    while elapsed_s < limit_s - 0.12:
        sea.say(*state_messages(kind, whose.course, sea.now_us, **changes), sender=whose.station)
        sent += 1
        sea.run(0.05)
        elapsed_s += 0.05
        assert refused(sea) == sent
        assert sea.condition(f"{agent}_fresh")
        assert close(own_course(sea), good, 1e-3)
        assert sea.snapshot()["error"] == pytest.approx(error, abs=1e-3)
    for _ in range(12):  # how soon a lost half makes the whole stale is another test's question
        sea.say(*state_messages(kind, whose.course, sea.now_us, **changes), sender=whose.station)
        sea.run(0.05)
    assert not sea.condition(f"{agent}_fresh")


@pytest.mark.parametrize(("kind", "name"), STATE_FIELDS, ids=lambda v: v)
@pytest.mark.parametrize("value", [v for _, v in BAD], ids=[n for n, _ in BAD])
def test_a_state_with_a_field_that_is_no_number_is_ignored(
    kind: str, name: str, value: float
) -> None:
    spoil(Sea(), "own", kind, **{name: value})


@pytest.mark.parametrize(("kind", "name"), STATE_FIELDS[::3], ids=lambda v: v)
def test_a_leaders_state_with_a_field_that_is_no_number_is_ignored(kind: str, name: str) -> None:
    spoil(Sea(), "leader", kind, **{name: math.nan})


@pytest.mark.parametrize("agent", ["own", "leader"])
@pytest.mark.parametrize(
    ("kind", "changes"),
    [
        ("ODOMETRY", {"q0": 0.0, "q1": 0.0, "q2": 0.0, "q3": 0.0}),
        ("ODOMETRY", {"q0": 1e-30, "q1": 0.0, "q2": 0.0, "q3": 0.0}),
        ("ODOMETRY", {"q0": 1e30, "q1": 0.0, "q2": 0.0, "q3": 0.0}),
        ("ODOMETRY", {"x": 1e30}),
        ("ODOMETRY", {"vx": -1e30}),
        ("ODOMETRY", {"yawspeed": 1e20}),
        ("LOCAL_POSITION_NED", {"y": 1e30}),
        ("LOCAL_POSITION_NED", {"vy": 1e30}),
        ("ATTITUDE", {"yaw": 1e30}),
        ("ATTITUDE", {"yawspeed": -1e30}),
    ],
    ids=str,
)
def test_a_state_out_of_all_range_is_ignored(
    agent: str, kind: str, changes: dict[str, float]
) -> None:
    spoil(Sea(), agent, kind, **changes)


@pytest.mark.parametrize("agent", ["own", "leader"])
@pytest.mark.parametrize("kind", ["ODOMETRY", "LOCAL_POSITION_NED"])
def test_a_duplicate_and_an_older_state_are_counted_and_ignored(agent: str, kind: str) -> None:
    sea = Sea()
    whose = getattr(sea, agent)
    whose.on = False
    for _ in range(10):
        sea.say(
            origin(sea.now_us),
            *state_messages(kind, whose.course, sea.now_us),
            sender=whose.station,
        )
        sea.run(0.05)
    stamp_us, good = sea.now_us - 50_000, own_course(sea)
    error = sea.snapshot()["error"]
    elsewhere = Course(500.0, 500.0, 2.0, 1.0, 1.0, 1.0)
    for late_us in (0, 50_000, 100_000, 300_000):
        before = sea.counter("mavlink_old_stamp")
        sent = state_messages(kind, elsewhere, stamp_us - late_us)
        sea.say(*sent[:1], sender=whose.station)  # the heading alone has a test of its own
        sea.run(0.05)
        assert sea.counter("mavlink_old_stamp") == before + 1
        assert close(own_course(sea), good, 1e-3)
        assert sea.snapshot()["error"] == pytest.approx(error, abs=1e-3)


@pytest.mark.parametrize("agent", ["own", "leader"])
@pytest.mark.parametrize("silent", ["LOCAL_POSITION_NED", "ATTITUDE"])
def test_a_state_in_two_messages_is_as_old_as_the_older_of_them(agent: str, silent: str) -> None:
    sea = Sea()
    whose = getattr(sea, agent)
    whose.on = False
    halves = {"LOCAL_POSITION_NED": local_position, "ATTITUDE": attitude}
    for k in range(60):
        both = [
            half(whose.course, sea.now_us)
            for name, half in halves.items()
            if name != silent or k < 20
        ]
        sea.say(origin(), *both, sender=whose.station)
        sea.run(0.05)
        if k == 19:
            assert sea.condition(f"{agent}_fresh")
            heard_us = sea.now_us - 50_000
        if (
            k > 19
            and (sea.ticks[-1].now_us - heard_us) * 1e-6 > {"own": 0.5, "leader": 1.0}[agent] + 0.05
        ):
            assert not sea.condition(f"{agent}_fresh"), (sea.now_us - heard_us) * 1e-6


@pytest.mark.parametrize("late_us", [0, 10_000, 100_000])
def test_an_older_heading_does_not_replace_a_newer_one(late_us: int) -> None:
    sea = Sea()
    sea.own.on = False
    for _ in range(10):
        sea.say(
            local_position(Course(), sea.now_us),
            attitude(Course(), sea.now_us),
            sender=sea.own.station,
        )
        sea.run(0.05)
    stamp_us = sea.now_us - 50_000
    sea.say(attitude(Course(psi=2.0), stamp_us - late_us), sender=sea.own.station)
    sea.say(local_position(Course(), sea.now_us), sender=sea.own.station)
    sea.run(0.11)
    assert own_course(sea).psi == pytest.approx(0.0, abs=1e-3)
    assert sea.counter("mavlink_old_stamp") == 1


@pytest.mark.parametrize("agent", ["own", "leader"])
@pytest.mark.parametrize("kind", ["ATTITUDE", "HEARTBEAT", "GPS_GLOBAL_ORIGIN"])
def test_a_second_component_without_a_whole_state_displaces_nobody(agent: str, kind: str) -> None:
    sea = Sea()
    whose = getattr(sea, agent)
    whose.station = Station(whose.station.system, NAVIGATION)
    sea.run(1.0)
    gimbal = Station(whose.station.system, 154)
    for _ in range(100):
        other = {
            "ATTITUDE": attitude(Course(psi=-1.0), sea.now_us),
            "HEARTBEAT": heartbeat(26),
            "GPS_GLOBAL_ORIGIN": origin(),
        }[kind]
        sea.say(other, sender=gimbal)
        sea.run(0.05)
        assert sea.condition(f"{agent}_fresh")


@pytest.mark.parametrize("agent", ["own", "leader"])
def test_an_old_state_does_not_keep_a_state_fresh(agent: str) -> None:
    sea = Sea()
    sea.run(1.0)
    whose = getattr(sea, agent)
    whose.on = False
    frozen_us = sea.now_us
    for _ in range(20):
        sea.say(origin(), odometry(whose.course, frozen_us), sender=whose.station)
        sea.run(0.1)
        if sea.now_us - frozen_us > 1_150_000:
            assert not sea.condition(f"{agent}_fresh")


@pytest.mark.parametrize("agent", ["own", "leader"])
def test_a_clock_that_starts_anew_is_believed_after_a_while(agent: str) -> None:
    sea = Sea()
    sea.run(2.0)
    getattr(sea, agent).clock_offset_us = -sea.now_us
    sea.run(3.0)
    assert sea.condition(f"{agent}_fresh")
    assert sea.counter("mavlink_old_stamp") > 0
    assert sea.snapshot()[f"{agent}_age_s"] < 0.15


@pytest.mark.parametrize("agent", ["own", "leader"])
def test_one_stamp_from_the_future_does_not_poison_the_track(agent: str) -> None:
    sea = Sea()
    sea.run(2.0)
    whose = getattr(sea, agent)
    sea.say(odometry(whose.course, sea.now_us + 3_600_000_000), sender=whose.station)
    sea.run(3.0)
    assert sea.condition(f"{agent}_fresh")
    assert 0.0 <= sea.snapshot()[f"{agent}_age_s"] < 0.15


@pytest.mark.parametrize("kind", ["ODOMETRY", "LOCAL_POSITION_NED"])
def test_extreme_stamps_never_upset_a_boat(kind: str) -> None:
    sea = Sea()
    for stamp in (0, 1, 2**32 * 1000 - 1000, 2**63 - 1, 2**63, 2**64 - 1):
        for whose in (sea.own, sea.leader):
            for message in state_messages(kind, whose.course, 0):
                if kind == "ODOMETRY":
                    message.time_usec = stamp
                else:
                    message.time_boot_ms = stamp // 1000 % 2**32
                sea.say(message, sender=whose.station)
        sea.run(0.1)
        assert_finite(sea.snapshot())
    sea.run(3.0)
    assert sea.condition("own_fresh") and sea.condition("leader_fresh")


def assert_finite(value: Any) -> None:
    if isinstance(value, dict):
        for each in value.values():
            assert_finite(each)
    elif isinstance(value, float):
        assert math.isfinite(value)


# --- noise ---------------------------------------------------------------------------------------


def damage(wire: bytes, rate: float, rng: np.random.Generator) -> bytes:
    spoiled = np.frombuffer(wire, np.uint8).copy()
    hit = rng.random(len(spoiled)) < rate
    spoiled[hit] ^= rng.integers(1, 256, int(hit.sum()), np.uint8)
    return spoiled.tobytes()


def chatter(sea: Sea, neighbour: Station, k: int) -> bytes:
    """What flies about in a harbour, orders to another boat among it."""
    wire = b""
    if k % 5 == 0:
        wire += sea.own.station.pack(
            local_position(sea.own.course, sea.now_us), attitude(sea.own.course, sea.now_us)
        )
        wire += sea.leader.station.pack(odometry(sea.leader.course, sea.now_us))
    if k % 50 == 0:
        wire += sea.own.station.pack(origin()) + sea.leader.station.pack(origin(), heartbeat())
    if k % 10 == 0:
        order = (ARM, 1.0), (SET_MODE, 1.0, 6.0), (SET_MODE, 1.0, 4.0), (ARM, 0.0)
        wire += neighbour.pack(command_long(*order[k // 10 % 4], target=(3, 1)))
    return wire


def test_ten_minutes_of_bad_radio_never_arm_a_boat() -> None:
    rng = np.random.default_rng(20_240_501)
    sea, neighbour = Sea({"CTL_RATE": 50}), Station(GCS, GCS_COMPONENT)
    sea.own.on = sea.leader.on = False
    for k in range(30_000):
        sea.boat.on_mavlink(damage(chatter(sea, neighbour, k), 0.05, rng), sea.now_us)
        sea.step()
        assert sea.state == "DISARMED"
    assert {tick.commands for tick in sea.ticks} == {(0, 0)}
    assert "COMMAND_ACK" not in {m.get_type() for m in messages(sea.ticks)}
    assert refused(sea) > 10_000


def test_ten_minutes_of_bad_radio_never_change_the_mode_of_a_sailing_boat() -> None:
    rng = np.random.default_rng(7)
    sea, neighbour = Sea({"CTL_RATE": 50}, links=2), Station(GCS, GCS_COMPONENT)
    sea.enter_formation()
    for k in range(30_000):
        if k % 2 == 0:
            sea.boat.on_mavlink(damage(chatter(sea, neighbour, k), 0.05, rng), sea.now_us, 1)
        sea.step()
        assert sea.state == "FORMATION"
    assert refused(sea) > 5_000


# --- commands ------------------------------------------------------------------------------------


@pytest.mark.parametrize("sender", [(GCS, GCS_COMPONENT), (245, 190), (9, 1), (LEADER, 1)])
def test_an_order_gets_exactly_one_ack_and_its_asker_is_named(sender: tuple[int, int]) -> None:
    sea = prepared()
    sea.gcs = Station(*sender)
    for order in ((ARM, 1.0), (SET_MODE, 1.0, 4.0), (ARM, 0.0), (512, 1.0), (ARM, 7.0)):
        ticks = [sea.order(*order), *sea.run(0.5)]
        found = named(ticks, "COMMAND_ACK")
        assert len(found) == 1 and found[0].command == order[0]
        assert (found[0].target_system, found[0].target_component) == sender
        assert found[0].progress == 255


@pytest.mark.parametrize("command", [0, 1, 16, 20, 21, 183, 246, 511, 512, 519, 520, 31010, 65535])
def test_an_order_that_a_boat_does_not_know_is_unsupported(command: int) -> None:
    sea = prepared()
    assert acks(sea.order(command)) == [(command, UNSUPPORTED)]
    assert sea.state == "DISARMED"


@pytest.mark.parametrize(
    "target", [(3, 1), (BOAT, 2), (0, 2), (BOAT, NAVIGATION), (GCS, 1), (LEADER, 1)]
)
def test_an_order_to_somebody_else_is_neither_obeyed_nor_answered(target: tuple[int, int]) -> None:
    sea = prepared()
    sea.say(command_long(ARM, 1.0, target=target))
    assert not named(sea.run(0.3), "COMMAND_ACK") and sea.state == "DISARMED"


@pytest.mark.parametrize("target", [(0, 0), (BOAT, 0), (0, 1), (BOAT, 1)])
def test_an_order_to_all_is_an_order_to_the_boat(target: tuple[int, int]) -> None:
    sea = prepared()
    assert acks(sea.order(ARM, 1.0, target=target)) == [(ARM, ACCEPTED)]
    assert sea.state == "HOLD"
    assert acks(sea.order(ARM, 0.0, target=target)) == [(ARM, ACCEPTED)]
    assert sea.state == "DISARMED"


@pytest.mark.parametrize("unused", [math.nan, 0.0])
def test_unused_parameters_may_be_nan_or_zero(unused: float) -> None:
    sea = prepared()
    assert acks(sea.order(ARM, 1.0, *[unused] * 6)) == [(ARM, ACCEPTED)]
    assert acks(sea.order(SET_MODE, 1.0, 6.0, *[unused] * 5)) == [(SET_MODE, ACCEPTED)]
    assert sea.state == "FORMATION"


def test_a_repeated_order_is_answered_each_time_and_obeyed_once() -> None:
    sea = prepared()
    for confirmation in range(5):
        assert acks(sea.order(ARM, 1.0, confirmation=confirmation)) == [(ARM, ACCEPTED)]
        assert sea.state == "HOLD"
    for confirmation in range(5):
        assert acks(sea.order(SET_MODE, 1.0, 6.0, confirmation=confirmation)) == [
            (SET_MODE, ACCEPTED)
        ]
        assert sea.state == "FORMATION"
    sea.run(0.5)
    moving = sea.commands
    assert acks(sea.order(ARM, 1.0, confirmation=1)) == [(ARM, ACCEPTED)]
    assert sea.state == "FORMATION" and sea.commands != (0, 0) and moving != (0, 0)
    for confirmation in range(5):
        assert acks(sea.order(ARM, 0.0, confirmation=confirmation)) == [(ARM, ACCEPTED)]
        assert sea.state == "DISARMED"
    assert texts(sea.ticks) == ["HOLD", "FORMATION", "DISARMED"]


def test_several_orders_in_one_tick_are_all_answered_in_order() -> None:
    sea = prepared()
    sea.say(command_long(ARM, 1.0), command_long(512, 1.0), command_long(SET_MODE, 1.0, 6.0))
    tick = sea.step()
    assert acks(tick) == [(ARM, ACCEPTED), (512, UNSUPPORTED), (SET_MODE, ACCEPTED)]
    assert sea.state == "FORMATION"


def test_a_flood_of_orders_is_answered_or_counted() -> None:
    sea = prepared()
    sea.say(*[command_long(512, 1.0) for _ in range(500)])
    answered = len(named(sea.run(1.0), "COMMAND_ACK"))
    assert answered + sea.counter("commands_dropped") + sea.counter("mavlink_not_sent") == 500
    assert answered > 0
    sea.arm()
    assert sea.state == "HOLD"


@pytest.mark.parametrize("value", [2.0, -1.0, 0.5, 1.0000001, math.nan, math.inf, -math.inf, 1e30])
def test_arming_wants_exactly_zero_or_one(value: float) -> None:
    sea = prepared()
    assert acks(sea.order(ARM, value)) == [(ARM, DENIED)]
    assert sea.state == "DISARMED"
    sea.arm()
    assert acks(sea.order(ARM, value)) == [(ARM, DENIED)]
    assert sea.state == "HOLD"


@pytest.mark.parametrize("value", [1.0, 5.0, 21195.0, 21197.0, -21196.0, math.inf])
def test_another_force_number_is_denied(value: float) -> None:
    sea = prepared()
    assert acks(sea.order(ARM, 1.0, value)) == [(ARM, DENIED)]
    assert sea.state == "DISARMED"


def fail(sea: Sea, check: str) -> None:
    if check == "own state":
        sea.own.on = False
    elif check == "one ESC":
        sea.escs[1].on = False
    elif check == "both ESCs":
        sea.escs[0].on = sea.escs[1].on = False
    else:
        sea.escs[0].health = 2


CHECKS = pytest.mark.parametrize("check", ["own state", "one ESC", "both ESCs", "ESC health"])


@CHECKS
@pytest.mark.parametrize("force", [math.nan, 0.0, float(FORCE)], ids=["nan", "checked", "forced"])
def test_nothing_arms_a_boat_while_a_check_fails_and_it_says_which(
    check: str, force: float
) -> None:
    sea = Sea()
    fail(sea, check)
    sea.run(2.0)
    tick = sea.order(ARM, 1.0, force)
    assert acks(tick) == [(ARM, TEMPORARILY_REJECTED)]
    said = [m for m in tick.named("STATUSTEXT") if m.text.startswith("PreArm: ")]
    assert len(said) == 1 and said[0].severity <= 4 and len(said[0].text) <= 50
    assert ("own state" if check == "own state" else "ESC") in said[0].text
    sea.run(0.5)
    assert sea.state == "DISARMED" and sea.commands == (0, 0)


@CHECKS
@pytest.mark.parametrize("force", [math.nan, float(FORCE)], ids=["plain", "arm_force of MAVSDK"])
def test_disarming_always_works(check: str, force: float) -> None:
    for enter in (Sea.enter_hold, Sea.enter_formation):
        sea = Sea()
        enter(sea)
        fail(sea, check)
        sea.run(3.0)
        assert acks(sea.order(ARM, 0.0, force)) == [(ARM, ACCEPTED)]
        assert sea.state == "DISARMED" and sea.commands == (0, 0)


def test_the_force_number_does_not_arm_when_it_says_disarm() -> None:
    sea = prepared()
    assert acks(sea.order(ARM, 0.0, FORCE)) == [(ARM, ACCEPTED)]
    assert sea.state == "DISARMED"


@pytest.mark.parametrize(
    "params",
    [
        (1.0, 0.0),
        (1.0, 5.0),
        (1.0, 99.0),
        (1.0, -1.0),
        (1.0, 6.5),
        (1.0, math.nan),
        (1.0, math.inf),
        (1.0, 1e30),
        (1.0, 4294967302.0),
        (1.0,),
        (0.0, 6.0),
        (math.nan, 6.0),
        (math.inf, 6.0),
        (-1e30, 6.0),
        (),
    ],
    ids=str,
)
def test_a_mode_that_does_not_exist_is_denied(params: tuple[float, ...]) -> None:
    sea = prepared()
    sea.arm()
    assert acks(sea.order(SET_MODE, *params)) == [(SET_MODE, DENIED)]
    assert sea.state == "HOLD"


@pytest.mark.parametrize("base_mode", [1.0, 129.0, 217.0])
def test_a_mode_is_set_whatever_else_the_base_mode_says(base_mode: float) -> None:
    sea = prepared()
    sea.arm()
    assert acks(sea.order(SET_MODE, base_mode, 6.0)) == [(SET_MODE, ACCEPTED)]
    assert sea.state == "FORMATION"


def test_formation_is_refused_to_a_disarmed_boat() -> None:
    sea = prepared()
    assert acks(sea.mode(FORMATION)) == [(SET_MODE, TEMPORARILY_REJECTED)]
    assert sea.state == "DISARMED"
    sea.arm()
    assert sea.state == "HOLD"


def test_formation_is_refused_without_a_leader_and_says_so() -> None:
    sea = Sea()
    sea.leader.on = False
    sea.settle()
    sea.arm()
    tick = sea.mode(FORMATION)
    assert acks(tick) == [(SET_MODE, TEMPORARILY_REJECTED)]
    assert any("leader" in m.text for m in tick.named("STATUSTEXT"))
    assert sea.state == "HOLD"


def test_only_the_ground_station_of_mav_gcs_sysid_commands() -> None:
    sea = Sea({"MAV_GCS_SYSID": 250})
    sea.settle()
    for sender in (
        Station(GCS, GCS_COMPONENT),
        Station(LEADER, 1),
        Station(BOAT, NAVIGATION),
        Station(0, 1),
    ):
        sea.say(command_long(ARM, 1.0), sender=sender)
        assert not [a for a in acks(sea.step()) if a[1] == ACCEPTED]
        assert sea.state == "DISARMED"
    sea.gcs = Station(250, 1)
    assert acks(sea.arm()) == [(ARM, ACCEPTED)]
    sea.say(command_long(SET_MODE, 1.0, 6.0), sender=Station(GCS, GCS_COMPONENT))
    sea.step()
    assert sea.state == "HOLD"


def test_every_change_of_state_is_said_on_every_link() -> None:
    sea = Sea(links=2)
    sea.enter_formation()
    sea.mode(HOLD)
    sea.disarm()
    for link in (0, 1):
        assert texts(sea.ticks, link) == ["HOLD", "FORMATION", "HOLD", "DISARMED"]


def test_a_command_acks_before_anything_else_that_it_causes() -> None:
    sea = prepared()
    for order in ((ARM, 1.0), (SET_MODE, 1.0, 6.0), (ARM, 0.0)):
        assert sea.order(*order).messages()[0].get_type() == "COMMAND_ACK"


# --- time ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("link", [0, 1])
@pytest.mark.parametrize("ts1", [1, 123_456_789, 2**62 + 12345, 2**63 - 1, -1, -(2**63)])
def test_a_timesync_request_is_answered_with_its_own_stamp(ts1: int, link: int) -> None:
    sea = Sea(links=2)
    sea.settle()
    sea.say(mavlink.MAVLink_timesync_message(0, ts1), link=link)
    tick = sea.step()
    (answer,) = [m for m in tick.named("TIMESYNC", link) if m.tc1 != 0]
    assert answer.ts1 == ts1
    assert answer.tc1 == tick.now_us * 1000
    assert not [m for m in tick.named("TIMESYNC", 1 - link) if m.tc1 != 0]


@pytest.mark.parametrize("answer", [(1, 0), (-1, 5), (2**63 - 1, 2**63 - 1), (10**18, -1)])
def test_a_timesync_answer_is_not_answered(answer: tuple[int, int]) -> None:
    sea = prepared()
    sea.say(mavlink.MAVLink_timesync_message(*answer))
    assert not [m for m in named(sea.run(0.1), "TIMESYNC") if m.tc1 != 0]


@pytest.mark.parametrize(
    "offset_s", [0.0, 5 * 3600.0, -9.5, 1.7e9], ids=["none", "hours", "earlier", "Unix"]
)
@pytest.mark.parametrize("delay_s", [0.0, 0.02, 0.1])
def test_timesync_tells_how_old_the_leaders_state_is(offset_s: float, delay_s: float) -> None:
    sea = Sea(leader=Course(5, 5, 0.5, 0.5))
    sea.leader.answers_timesync = True
    sea.leader.clock_offset_us = round(offset_s * 1e6)
    sea.leader.delay_us = round(delay_s * 1e6)
    sea.run(2.0)
    for _ in range(500):
        tick = sea.step()
        arrived = (tick.now_us - START_US - sea.leader.delay_us) // 100_000 * 100_000 + START_US
        assert sea.snapshot()["leader_age_s"] == pytest.approx(
            (tick.now_us - arrived) * 1e-6, abs=0.005
        )


def test_without_timesync_a_leaders_state_is_as_old_as_its_fastest_way() -> None:
    sea = Sea()
    sea.leader.clock_offset_us = 7 * 3600 * 1_000_000
    sea.run(2.0)
    assert 0.0 <= sea.snapshot()["leader_age_s"] <= 0.105


def test_a_leader_whose_messages_are_too_long_on_the_way_is_stale() -> None:
    sea = Sea({"FS_LEADER_S": 0.5})
    sea.leader.answers_timesync = True
    sea.leader.clock_offset_us = 3600 * 1_000_000
    sea.leader.delay_us = 700_000
    sea.run(5.0)
    assert not sea.condition("leader_fresh")
    assert sea.snapshot()["leader_age_s"] == pytest.approx(0.75, abs=0.06)


@pytest.mark.parametrize(
    "liar",
    [Station(STRANGER, 1), Station(GCS, 190), Station(BOAT, NAVIGATION)],
    ids=["77", "255", "own"],
)
def test_answers_of_others_do_not_shift_the_leaders_clock(liar: Station) -> None:
    sea = Sea()
    sea.leader.answers_timesync = True
    sea.run(2.0)
    for _ in range(300):
        tick = sea.step()
        for m in tick.named("TIMESYNC"):
            if m.tc1 == 0:
                sea.say(mavlink.MAVLink_timesync_message(m.ts1 + 10**12, m.ts1), sender=liar)
        assert sea.snapshot()["leader_age_s"] < 0.105
        assert sea.condition("leader_fresh")


def test_answers_to_questions_never_asked_do_not_shift_the_leaders_clock() -> None:
    rng = random.Random(5)
    sea = Sea()
    sea.leader.answers_timesync = True
    sea.run(2.0)
    for _ in range(300):
        sea.say(
            mavlink.MAVLink_timesync_message(
                rng.randrange(1, 2**62), rng.randrange(-(2**62), 2**62)
            ),
            sender=sea.leader.station,
        )
        sea.step()
        assert 0.0 <= sea.snapshot()["leader_age_s"] < 0.105


def test_a_boat_and_its_follower_agree_about_time() -> None:
    """Two boats alone: the follower's leader is a flotilla.Boat hours ahead, 50 ms away."""
    sea = Sea({"CTL_RATE": 100})
    sea.leader.on = False
    ahead_us, delay = 4 * 3600 * 1_000_000, 5
    first = flotilla.Boat({"MAV_SYSID": LEADER, "FORM_LEADER": 100})
    unit = Station(LEADER, NAVIGATION)
    to_first: dict[int, bytes] = defaultdict(bytes)
    to_second: dict[int, bytes] = defaultdict(bytes)
    course = Course(5.0, 5.0, 0.5, 0.5, 0.0, 0.1)
    for k in range(600):
        there_us = sea.now_us + ahead_us
        if k % 5 == 0:
            here = course.at((sea.now_us - START_US) * 1e-6)
            first.on_mavlink(unit.pack(origin(), odometry(here, there_us)), there_us)
        first.on_mavlink(to_first.pop(k, b""), there_us)
        for _, data in first.tick(there_us).mavlink:
            to_second[k + delay] += data
        sea.boat.on_mavlink(to_second.pop(k, b""), sea.now_us)
        for _, data in sea.step().mavlink:
            to_first[k + delay] += data
    truth = course.at((sea.ticks[-1].now_us - START_US) * 1e-6)
    own, error = sea.own.course, sea.snapshot()["error"]
    c, s = math.cos(own.psi), math.sin(own.psi)
    north, east = own.north - truth.north, own.east - truth.east
    assert sea.condition("leader_fresh")
    assert error["x_m"] == pytest.approx(c * north + s * east, abs=0.02)
    assert error["y_m"] == pytest.approx(-s * north + c * east, abs=0.02)
    assert error["psi_rad"] == pytest.approx(wrap(own.psi - truth.psi), abs=0.005)


def test_decoding_helpers_do_see_bad_data() -> None:
    """The oracle's own check: a damaged frame is not silently passed."""
    wire = bytearray(Station(1).pack(heartbeat()))
    wire[12] ^= 1
    assert [m.get_type() for m in decode([bytes(wire)])] == ["BAD_DATA"]
