# SPDX-License-Identifier: MIT
"""Frames split, joined, in either version, signed, unknown, or amid garbage."""

from __future__ import annotations

import math
import random
from collections.abc import Callable
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pymavlink.dialects.v20 import common as mavlink

from tests.target.agent import START_US
from tests.target.course import Course
from tests.target.sea import Sea, acks, seeded
from tests.target.stations import (
    ACCEPTED,
    ARM,
    BOAT,
    SET_MODE,
    attitude,
    command_long,
    heartbeat,
    local_position,
    odometry,
    origin,
)

#: The sender, and the message at a given time.
KINDS: dict[str, tuple[str, Callable[[int], Any]]] = {
    "own ODOMETRY": ("own", lambda now_us: odometry(Course(7, 8, 0.9, 1, 0, 0.1), now_us)),
    "own LOCAL_POSITION_NED": ("own", lambda now_us: local_position(Course(7, 8), now_us)),
    "own ATTITUDE": ("own", lambda now_us: attitude(Course(7, 8, 0.9), now_us)),
    "own GPS_GLOBAL_ORIGIN": ("own", lambda now_us: origin(now_us, latitude=123456789)),
    "leader ODOMETRY": ("leader", lambda now_us: odometry(Course(7, 8, 0.9, 1), now_us)),
    "leader LOCAL_POSITION_NED": ("leader", lambda now_us: local_position(Course(7, 8), now_us)),
    "leader ATTITUDE": ("leader", lambda now_us: attitude(Course(7, 8, 0.9), now_us)),
    "leader GPS_GLOBAL_ORIGIN": ("leader", origin),
    "leader HEARTBEAT": ("leader", lambda _: heartbeat()),
    "TIMESYNC request": ("gcs", lambda _: mavlink.MAVLink_timesync_message(0, 0x123456789ABCDEF)),
    "TIMESYNC answer": ("leader", lambda _: mavlink.MAVLink_timesync_message(1, 2)),
    "COMMAND_LONG arm": ("gcs", lambda _: command_long(ARM, 1.0)),
    "COMMAND_LONG mode": ("gcs", lambda _: command_long(SET_MODE, 1.0, 4.0)),
    "COMMAND_LONG other": ("gcs", lambda _: command_long(512, 148.0)),
}


def packed(sea: Sea, kind: str, version1: bool = False) -> bytes:
    who, make = KINDS[kind]
    sender = sea.gcs if who == "gcs" else getattr(sea, who).station
    return bytes(sender.pack(make(sea.now_us), version1=version1))


def outcome(sea: Sea) -> tuple[object, ...]:
    """All output of the boat during 0.3 s, to the byte."""
    ticks = sea.run(0.3)
    return [(t.mavlink, t.can) for t in ticks], str(sea.snapshot())


@pytest.mark.parametrize("kind", KINDS)
def test_a_message_may_be_split_at_every_byte(sea: Sea, kind: str) -> None:
    sea.settle()
    wire = packed(sea, kind)
    sea.boat.on_mavlink(wire, sea.now_us)
    received, expected = sea.counter("mavlink_received"), outcome(sea)
    for cut in range(1, len(wire)):
        other = Sea()
        other.settle()
        assert packed(other, kind) == wire
        other.boat.on_mavlink(wire[:cut], other.now_us)
        assert other.counter("mavlink_received") == received - 1
        other.boat.on_mavlink(wire[cut:], other.now_us)
        assert other.counter("mavlink_received") == received
        if cut % 16 == 1:
            assert outcome(other) == expected


@pytest.mark.parametrize(
    ("kind", "version1"),
    [(kind, False) for kind in KINDS] + [(kind, True) for kind in KINDS if "ODOMETRY" not in kind],
)
def test_every_kind_is_understood_byte_by_byte(kind: str, version1: bool) -> None:
    whole, bytewise = Sea(), Sea()
    for sea, step in ((whole, 1000), (bytewise, 1)):
        sea.settle()
        received = sea.counter("mavlink_received")
        wire = packed(sea, kind, version1)
        for start in range(0, len(wire), step):
            sea.boat.on_mavlink(wire[start : start + step], sea.now_us)
        assert sea.counter("mavlink_received") == received + 1
        assert sea.refused("mavlink") == 0 or kind == "TIMESYNC answer"
    assert outcome(whole) == outcome(bytewise)


def test_several_frames_may_share_a_chunk() -> None:
    apart, together = Sea(), Sea()
    for sea in (apart, together):
        sea.settle()
        chunks = [packed(sea, kind) for kind in KINDS if "own" not in kind]
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
    assert sea.counter("mavlink_received") == 100 and sea.refused("mavlink") == 0


@pytest.mark.parametrize("version1", [False, True], ids=["MAVLink 2", "MAVLink 1"])
def test_a_mavlink_1_and_a_mavlink_2_station_command_alike(sea: Sea, version1: bool) -> None:
    sea.settle()
    sea.boat.on_mavlink(sea.gcs.pack(command_long(ARM, 1.0), version1=version1), sea.now_us)
    assert acks(sea.step()) == [(ARM, ACCEPTED)]
    assert sea.state == "HOLD"


def test_signed_frames_are_understood_on_a_link_without_signing(sea: Sea) -> None:
    for station in (sea.own.station, sea.leader.station, sea.gcs):
        signing = station.encoder.signing
        signing.secret_key, signing.sign_outgoing = b"k" * 32, True
        signing.link_id, signing.timestamp = 3, 1
    sea.enter_formation()
    sea.run(1.0)
    assert sea.state == "FORMATION" and sea.refused("mavlink") == 0


@pytest.mark.parametrize("seed", range(6))
def test_good_frames_are_heard_again_soon_after_garbage(sea: Sea, seed: int) -> None:
    rng = random.Random(seed)
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
    assert sea.refused("mavlink") > 0


@seeded(max_examples=60)
@given(st.binary(max_size=600), st.integers(0, 300))
def test_after_any_garbage_good_frames_are_decoded_again(garbage: bytes, cut: int) -> None:
    sea = Sea()
    sea.boat.on_mavlink(garbage, sea.now_us)
    sea.boat.on_mavlink(sea.own.station.pack(odometry(Course(), sea.now_us))[:cut], sea.now_us)
    sea.run(0.4)
    assert sea.condition("own_fresh")
    assert sea.state == "DISARMED"


def test_frames_of_messages_that_the_boat_does_not_know_are_passed_over(sea: Sea) -> None:
    sea.settle()
    before = sea.refused("mavlink")
    for message in (
        mavlink.MAVLink_vfr_hud_message(1, 2, 3, 4, 5, 6),
        mavlink.MAVLink_sys_status_message(0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0),
        mavlink.MAVLink_mission_count_message(BOAT, 1, 3),
        mavlink.MAVLink_statustext_message(3, b"hello"),
        mavlink.MAVLink_battery_status_message(0, 0, 0, 0, [0] * 10, 0, 0, 0, 0),
    ):
        sea.say(message)
    sea.run(0.1)
    assert sea.refused("mavlink") == before and sea.condition("own_fresh")
