# SPDX-License-Identifier: MIT
"""Damaged, lost and reordered CAN frames: counted, and never taken for a status."""

from __future__ import annotations

import random
from typing import Any

import pytest

from tests.target.bus import ESC_STATUS, NODE_STATUS, Frames, esc_status, node_status, reference
from tests.target.sea import Sea

GOOD = esc_status(32, 1, 3)


def after(frames: Frames) -> Sea:
    """A sea where these frames are the starboard ESC's only status; otherwise without faults."""
    sea = Sea()
    sea.escs[1].on = False
    sea.on_can(node_status(32, 1))
    sea.on_can(frames)
    sea.step()
    return sea


def test_the_good_status_counts() -> None:
    assert after(GOOD).condition("escs_online")


@pytest.mark.parametrize("byte", range(sum(len(d) for _, d in GOOD)))
def test_a_status_with_one_wrong_bit_does_not_count(byte: int) -> None:
    rng = random.Random(byte)
    frame, at = [(n, k) for n, (_, data) in enumerate(GOOD) for k in range(len(data))][byte]
    damaged = list(GOOD)
    can_id, data = damaged[frame]
    flipped = data[at] ^ 1 << rng.randrange(8)
    damaged[frame] = can_id, data[:at] + bytes([flipped]) + data[at + 1 :]
    sea = after(damaged)
    assert not sea.condition("escs_online")
    sea.on_can(esc_status(32, 1, 4))
    sea.step()
    assert sea.condition("escs_online"), "the next good one counts"


@pytest.mark.parametrize("missing", range(3))
def test_a_status_with_a_lost_frame_does_not_count(missing: int) -> None:
    sea = after([f for k, f in enumerate(GOOD) if k != missing])
    assert not sea.condition("escs_online")
    sea.on_can(esc_status(32, 1, 4))
    sea.step()
    assert sea.condition("escs_online")


@pytest.mark.parametrize("order", [(0, 2, 1), (1, 0, 2), (2, 1, 0)])
def test_a_status_out_of_order_does_not_count(order: tuple[int, ...]) -> None:
    assert not after([GOOD[k] for k in order]).condition("escs_online")


def test_a_damaged_status_is_counted() -> None:
    damaged = list(GOOD)
    damaged[1] = (damaged[1][0], b"\x00" + damaged[1][1][1:])
    assert after(damaged).counter("can_bad_checksum") == 1
    assert after(GOOD[1:]).counter("can_bad_frame") >= 1


@pytest.mark.parametrize("vector", reference("damaged"), ids=lambda v: v["name"])
def test_damaged_reference_sequences_deliver_as_specified(sea: Sea, vector: dict[str, Any]) -> None:
    """Node 21 of the vectors reports index 0; it counts exactly if a transfer is delivered."""
    assert int(vector["can_id"], 16) >> 8 & 0xFFFF == ESC_STATUS
    sea.escs[0].on = False
    sea.on_can(node_status(21, 1))
    sea.on_can([(int(vector["can_id"], 16), bytes.fromhex(data)) for data in vector["frames"]])
    sea.step()
    assert sea.condition("escs_online") == (vector["transfers_delivered"] > 0)


def test_all_frames_of_the_reference_leave_a_boat_disarmed(sea: Sea) -> None:
    for kind in ("captured", "generated", "damaged"):
        for vector in reference(kind):
            for text in vector["frames"]:  # either DATA or ID#DATA
                can_id, _, data = text.rpartition("#")
                sea.on_can([(int(can_id or vector["can_id"], 16), bytes.fromhex(data))])
            sea.step()
    assert sea.state == "DISARMED"
    assert sea.counter("can_received") > 0


def test_a_frame_without_tail_byte_is_counted(sea: Sea) -> None:
    for type_id in (ESC_STATUS, NODE_STATUS):
        sea.boat.on_can(16 << 24 | type_id << 8 | 32, b"", sea.now_us)
    assert sea.counter("can_bad_frame") == 2


@pytest.mark.parametrize("size", [9, 12, 64, 1000])
def test_more_than_eight_bytes_are_refused_or_counted(sea: Sea, size: int) -> None:
    try:
        sea.boat.on_can(16 << 24 | ESC_STATUS << 8 | 32, b"\xc0" * size, sea.now_us)
    except ValueError:
        return
    assert sea.refused("can") == 1
