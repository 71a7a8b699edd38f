# SPDX-License-Identifier: MIT
"""ArmingStatus: 255 exactly while armed, ten times a second."""

from __future__ import annotations

from itertools import pairwise

import pytest

from tests.target.sea import Sea, at_sea


def test_arming_status_comes_ten_times_a_second(outing: Sea) -> None:
    times = [tick.now_us for tick in outing.ticks if tick.arming]
    gaps = [b - a for a, b in pairwise(times)]
    assert max(gaps) <= 100_000
    assert len(times) == pytest.approx((times[-1] - times[0]) / 1e5, rel=0.05)
    assert {s for tick in outing.ticks for s in tick.arming} == {0, 255}


def test_arming_status_changes_in_the_tick_of_the_order(sea: Sea) -> None:
    sea.settle()
    for k in range(10):
        sea.run(0.01 * k)
        assert sea.arm().arming[-1] == 255
        sea.run(0.01 * k)
        assert sea.disarm().arming[-1] == 0


def test_arming_status_is_255_exactly_while_armed(outing: Sea) -> None:
    state, seen = 0, set()
    for tick in outing.ticks:
        for m in tick.named("HEARTBEAT"):
            state = 255 if m.base_mode & 128 else 0
        for status in tick.arming:
            assert status == state
            seen.add(status)
        if any(tick.commands):
            assert state == 255
    assert seen == {0, 255}


def test_a_refused_arming_never_says_255(sea: Sea) -> None:
    sea.escs[0].on = False
    sea.run(2.0)
    for _ in range(20):
        sea.arm()
        sea.run(0.07)
    assert {s for tick in sea.ticks for s in tick.arming} == {0}


def test_arming_status_is_zero_in_the_tick_of_a_fault() -> None:
    sea = at_sea()
    sea.silence("escs")
    while sea.state != "FAULT":
        tick = sea.step()
    assert tick.arming == [0] and not any(tick.commands)
    assert {s for t in sea.run(1.0) for s in t.arming} == {0}
