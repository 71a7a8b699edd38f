# SPDX-License-Identifier: MIT
"""Ten minutes of damaged frames: noise is never taken for a command."""

from __future__ import annotations

import numpy as np

from tests.target.course import TURN
from tests.target.hull import Afloat
from tests.target.sea import Sea, messages
from tests.target.stations import (
    ARM,
    GCS,
    GCS_COMPONENT,
    SET_MODE,
    Station,
    attitude,
    command_long,
    heartbeat,
    local_position,
    odometry,
    origin,
)


def damage(wire: bytes, rate: float, rng: np.random.Generator) -> bytes:
    spoiled = np.frombuffer(wire, np.uint8).copy()
    hit = rng.random(len(spoiled)) < rate
    spoiled[hit] ^= rng.integers(1, 256, int(hit.sum()), np.uint8)
    return spoiled.tobytes()


def chatter(sea: Sea, neighbour: Station, k: int) -> bytes:
    """Radio traffic of a harbour, with commands to another boat."""
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
    assert sea.refused("mavlink") > 10_000


def test_ten_minutes_of_bad_radio_never_change_the_mode_of_a_sailing_boat() -> None:
    rng = np.random.default_rng(7)
    sea = Afloat({"CTL_RATE": 50, "FORM_OFS_N": -3.0}, leader=TURN, links=2)
    neighbour = Station(GCS, GCS_COMPONENT)
    sea.enter_formation()
    for k in range(30_000):
        if k % 2 == 0:
            sea.boat.on_mavlink(damage(chatter(sea, neighbour, k), 0.05, rng), sea.now_us, 1)
        sea.step()
        assert sea.state == "FORMATION"
    assert sea.refused("mavlink") > 5_000
