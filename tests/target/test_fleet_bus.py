# SPDX-License-Identifier: MIT
"""A boat's CAN bus in a fleet: its ESCs' response to others' frames, whole and damaged."""

from __future__ import annotations

import random
from typing import Any

import pytest

from sil.wire.dronecan import ARMING_STATUS, GET_NODE_INFO, RAW_COMMAND, ArmingStatus, RawCommand
from sil.wire.dronecan_transfer import DataType, FrameId, Kind, Publisher, split
from tests.target.troubled_fleet import frames, parsed, reports
from tests.target.twin_fleets import H_US, alone

OTHER = 99


def request(node: int, transfer_id: int, payload: bytes = b"", priority: int = 24) -> Any:
    can_id = FrameId(Kind.REQUEST, priority, GET_NODE_INFO.type_id, OTHER, node).pack()
    return [(can_id, data) for data in split(payload, transfer_id, GET_NODE_INFO.crc_seed)]


@pytest.mark.parametrize("node", [20, 21, 22, 23])
def test_a_request_for_an_escs_name_is_answered(node: int) -> None:
    twins = alone()
    twins.tick(250)
    twins.compare()
    twins.on_bus(request(node, 5))
    twins.on_bus(request(node, 6, bytes(range(100)), priority=3))
    twins.on_bus(request(node, 7, bytes(600)))
    twins.tick()
    on_bus = frames(parsed(twins.compare()), 0, to_boat=True)
    kinds = [FrameId.unpack(can_id).kind for can_id, _ in on_bus]
    # Two requests are whole; each answer has 61 bytes and a checksum, nine frames.
    assert kinds.count(Kind.RESPONSE) == (18 if node in (21, 22) else 0)


def test_another_controller_has_the_same_effect_in_a_fleet_as_on_one_boat() -> None:
    twins = alone()
    rng = random.Random(3)
    raw, arming = (Publisher(kind, 7, OTHER) for kind in (RAW_COMMAND, ARMING_STATUS))
    for k in range(600):
        if k % 40 < 30:
            armed = ArmingStatus(255 if k < 500 else rng.choice((0, 254, 255)))
            twins.on_bus(arming.frames(armed.encode()))
            count = rng.choice((1, 2, 4, 5, 20))
            cmd = tuple(rng.choice((0, -8192, 8191, 77)) for _ in range(count))
            twins.on_bus(raw.frames(RawCommand(cmd).encode()))
        twins.tick()
    assert {esc.power_pct for esc in reports(twins)} == {0, 1, 100}


def flipped(rng: random.Random, data: bytes) -> bytes:
    bits = int.from_bytes(data, "little") ^ 1 << rng.randrange(8 * len(data))
    return bits.to_bytes(len(data), "little")


def damaged(rng: random.Random, frames: list[tuple[int, bytes]]) -> list[tuple[int, bytes]]:
    """Frames lost, repeated, swapped, truncated, too long, with a flipped bit, or anonymous."""
    out: list[tuple[int, bytes]] = []
    for can_id, data in frames:
        fates = [
            [],
            [(can_id, data)] * 2,
            [(can_id, data[: rng.randrange(len(data))])],
            [(can_id, flipped(rng, data))],
            [(can_id ^ 1 << rng.randrange(32), data)],
            [(can_id & ~0x7F, data)],
            [(can_id, data + b"\xc0")],
        ]
        happened = rng.choice(fates) if rng.random() < 0.6 else [(can_id, data)]
        swapped = rng.random() < 0.1
        out = happened + out if swapped else out + happened
    return out


@pytest.mark.parametrize("seed", range(4))
def test_damaged_frames_have_the_same_effect_in_a_fleet_as_on_one_boat(seed: int) -> None:
    twins = alone()
    rng = random.Random(seed)
    kinds: list[DataType] = [RAW_COMMAND, ARMING_STATUS]
    publishers = [Publisher(kind, 7, source) for kind in kinds for source in (20, OTHER, 3)]
    for _ in range(700):
        frames = rng.choice(publishers).frames(rng.randbytes(rng.choice((0, 1, 4, 7, 8, 35, 36))))
        if rng.random() < 0.2:
            frames = request(21, rng.randrange(32), rng.randbytes(rng.choice((0, 9, 520))))
        twins.on_bus(damaged(rng, frames))
        twins.tick()
        if rng.random() < 0.02:
            twins.t_us += rng.choice((50, 300, 3000)) * H_US
    counters = twins.both("snapshot", twins.boats[0])["counters"]
    assert min(counters["can_received"], counters["can_bad_frame"]) > 300
    twins.compare()
