# SPDX-License-Identifier: MIT
"""Random CAN frames never move a disarmed boat nor stop one that sails."""

from __future__ import annotations

import random

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.target.bus import (
    ARMING_STATUS,
    ESC_STATUS,
    GET_NODE_INFO,
    NODE,
    NODE_STATUS,
    RAW_COMMAND,
    TOOL,
    transfers,
    type_of,
)
from tests.target.sea import Sea, seeded

RELATED = st.sampled_from(
    [
        t << 8 | n
        for t in (ESC_STATUS, NODE_STATUS, RAW_COMMAND, ARMING_STATUS, 1)
        for n in (0, 31, 32, NODE, 127)
    ]
    + [
        GET_NODE_INFO << 16 | 1 << 15 | NODE << 8 | 0x80 | TOOL,
        GET_NODE_INFO << 16 | NODE << 8 | 0x80 | TOOL,
    ]
)


@seeded(max_examples=300)
@given(st.lists(st.tuples(RELATED, st.binary(max_size=7), st.integers(0, 255)), max_size=40))
def test_random_frames_of_the_types_it_reads_never_upset_a_boat(
    raw: list[tuple[int, bytes, int]],
) -> None:
    sea = Sea()
    sea.on_can([(16 << 24 | can_id, data + bytes([tail])) for can_id, data, tail in raw])
    tick = sea.step()
    assert sea.state == "DISARMED" and tick.commands == (0, 0)
    transfers(tick.can)


@pytest.mark.parametrize("seed", range(3))
def test_a_sailing_boat_keeps_its_escs_among_random_frames(sea: Sea, seed: int) -> None:
    rng = random.Random(seed)
    sea.enter_formation()
    for _ in range(500):
        for _ in range(5):
            can_id = rng.randrange(2**29)
            kind = type_of(can_id)
            theirs = kind[2] in (31, 32)
            if theirs or kind[:2] in ((False, RAW_COMMAND), (False, ARMING_STATUS)):
                continue
            sea.boat.on_can(can_id, rng.randbytes(rng.randrange(9)), sea.now_us)
        sea.step()
    assert sea.state == "FORMATION"


def test_thirty_thousand_random_frames_never_move_a_boat(sea: Sea) -> None:
    rng = random.Random(3141)
    sea.escs[0].on = sea.escs[1].on = False
    known = [ESC_STATUS << 8, NODE_STATUS << 8, 0x180, 1 << 16 | 1 << 15 | 20 << 8 | 0x80]
    for k in range(30_000):
        can_id = (
            rng.randrange(2**29) if k % 2 else rng.choice(known) | rng.randrange(128) | 16 << 24
        )
        sea.boat.on_can(can_id, rng.randbytes(rng.randrange(9)), sea.now_us)
        if k % 15 == 0:
            tick = sea.step()
            assert sea.state == "DISARMED" and tick.commands == (0, 0)
    assert sea.counter("can_bad_frame") + sea.counter("can_bad_checksum") > 1000
