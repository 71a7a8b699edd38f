# SPDX-License-Identifier: MIT
"""Links: delay, jitter, loss, bandwidth."""

import random

import numpy as np
import pytest

from sil.wire.link import Link, Rng

CHUNKS = [bytes([k]) * 10 for k in range(200)]


def run(link: Link, step_us: int = 1000) -> list[tuple[int, bytes]]:
    """Sends a chunk each millisecond and notes when each arrives (us)."""
    arrivals = []
    for k in range(3 * len(CHUNKS)):
        now_us = k * step_us
        if k < len(CHUNKS):
            link.send(CHUNKS[k], now_us)
        arrivals += [(now_us, data) for data in link.receive(now_us)]
    return arrivals


def test_an_ideal_link_delivers_at_the_same_instant_and_in_order() -> None:
    assert run(Link(random.Random(1))) == [(k * 1000, c) for k, c in enumerate(CHUNKS)]


def test_a_chunk_is_received_once() -> None:
    link = Link(random.Random(1))
    link.send(b"a", 5)
    link.send(b"b", 5)
    assert link.receive(5) == [b"a", b"b"]
    assert link.receive(5) == []


def test_a_delay_shifts_every_chunk() -> None:
    link = Link(random.Random(1), delay_s=0.005)
    assert run(link) == [((k + 5) * 1000, c) for k, c in enumerate(CHUNKS)]


def test_jitter_stays_within_its_bound_and_may_reorder() -> None:
    arrivals = run(Link(random.Random(1), delay_s=0.002, jitter_s=0.01))
    late_us = [t - 1000 * CHUNKS.index(c) for t, c in arrivals]
    assert len(arrivals) == len(CHUNKS)
    assert min(late_us) >= 2000 and max(late_us) <= 12000
    assert [c for _, c in arrivals] != CHUNKS


def test_loss_takes_whole_chunks_at_its_rate() -> None:
    arrived = [c for _, c in run(Link(random.Random(2), loss=0.3))]
    assert set(arrived) <= set(CHUNKS)
    assert 0.6 < len(arrived) / len(CHUNKS) < 0.8
    assert run(Link(random.Random(2), loss=1.0)) == []


def test_bandwidth_makes_chunks_wait_for_each_other() -> None:
    link = Link(random.Random(1), rate_Bps=1000.0)
    link.send(bytes(10), 0)
    link.send(bytes(20), 0)
    assert link.receive(9_999) == []
    assert link.receive(10_000) == [bytes(10)]
    assert link.receive(29_999) == []
    assert link.receive(30_000) == [bytes(20)]
    link.send(bytes(10), 100_000)
    assert link.receive(110_000) == [bytes(10)]


@pytest.mark.parametrize("make", [random.Random, np.random.default_rng])
def test_the_same_seed_gives_the_same_arrivals(make: type[Rng]) -> None:
    def arrivals(seed: int) -> list[tuple[int, bytes]]:
        rng: Rng = make(seed)  # type: ignore[call-arg]
        return run(Link(rng, delay_s=0.01, jitter_s=0.02, loss=0.2, rate_Bps=2e4))

    assert arrivals(7) == arrivals(7)
    assert arrivals(7) != arrivals(8)


def test_a_fault_that_ends_in_mid_flight_keeps_the_order_of_arrival() -> None:
    link = Link(random.Random(1), delay_s=0.01)
    link.send(b"late", 0)
    link.delay_s = 0.0
    link.send(b"early", 1000)
    assert link.receive(1000) == [b"early"]
    assert link.receive(10_000) == [b"late"]
