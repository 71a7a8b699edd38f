# SPDX-License-Identifier: MIT
"""Random MAVLink never moves a disarmed boat nor causes a NaN in one that sails."""

from __future__ import annotations

import random
from typing import Any

import flotilla
from pymavlink.dialects.v20 import common as mavlink

from tests.target.agent import START_US
from tests.target.bus import FULL_SCALE, commands
from tests.target.course import Course
from tests.target.sea import assert_finite, at_sea
from tests.target.stations import BOAT, LEADER, STRANGER, odometry

ODD = [0.0, 1e-38, 1e3, -1e6, 3e38]


def frame(kind: Any, payload: bytes, system: int, component: int) -> bytes:
    """A frame with a valid checksum and arbitrary content."""
    body = (
        bytes([len(payload), 0, 0, 0, system, component]) + kind.id.to_bytes(3, "little") + payload
    )
    checksum = mavlink.x25crc(body + bytes([kind.crc_extra])).crc
    return bytes(b"\xfd" + body + checksum.to_bytes(2, "little"))


def recognisable(rng: random.Random) -> bytes:
    """A message with valid checksum, random content and length, or a truncated frame."""
    kind = mavlink.mavlink_map.get(
        rng.choice([0, 11, 20, 23, 30, 32, 33, 49, 75, 76, 111, 253, 331, -1])
    )
    if kind is None:
        return b"\xfd" + rng.randbytes(rng.randrange(300))
    payload = rng.randbytes(rng.choice([kind.unpacker.size, rng.randrange(1, 256)]))
    return frame(kind, payload, rng.choice([BOAT, LEADER, STRANGER]), rng.randrange(256))


def test_twenty_thousand_random_chunks_of_mavlink_never_move_a_boat() -> None:
    rng = random.Random(2718)
    boat = flotilla.Boat({"MAV_SYSID": BOAT, "FORM_LEADER": LEADER}, 2)
    now_us = START_US
    for k in range(20_000):
        data = rng.randbytes(rng.randrange(80)) if k % 2 else recognisable(rng)
        boat.on_mavlink(data, now_us, k // 2 % 2)
        if k % 10 == 0:
            now_us += 10_000
            out = boat.tick(now_us)
            assert boat.state == "DISARMED" and not any(commands(list(out.can)))
    assert_finite(boat.snapshot())
    counters = boat.snapshot()["counters"]
    assert counters["mavlink_received"] > 1000 and counters["mavlink_bad_value"] > 100


def test_random_payloads_of_own_and_leader_never_give_nan() -> None:
    """An armed boat receives states of random bits: it stops, or stays within limits."""
    rng = random.Random(1618)
    sea = at_sea()
    sea.own.on = sea.leader.on = False
    for _ in range(5000):
        kind = mavlink.mavlink_map[rng.choice([30, 32, 49, 331, 111])]
        whose = rng.choice([sea.own, sea.leader]).station
        if rng.random() < 0.5:
            payload = rng.randbytes(kind.unpacker.size)
        else:  # all well but one field
            kind = mavlink.MAVLink_odometry_message
            message = odometry(Course(), sea.now_us)
            name = rng.choice(["x", "y", "z", "vx", "vy", "vz", "yawspeed"])
            setattr(message, name, rng.choice(ODD))
            payload = bytes(message.pack(whose.encoder))[10:-2]
        sea.boat.on_mavlink(frame(kind, payload, whose.system, whose.component), sea.now_us)
        tick = sea.step()
        assert all(abs(c) <= FULL_SCALE for c in tick.commands)
        assert_finite(sea.snapshot())
