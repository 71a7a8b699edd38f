# SPDX-License-Identifier: MIT
"""Periodic messages stay on their grid."""

from random import Random

import pytest

from sil.wire.rate import Rate


@pytest.mark.parametrize("hz", [0.5, 3.0, 25.0, 30.0, 100.0])
def test_a_rate_does_not_drift_over_an_hour_of_odd_ticks(hz: float) -> None:
    rate = Rate(hz)
    start_us = 10_800_000_007
    sent = [t for t in range(start_us, start_us + 3_600_000_000, 9_973) if rate.due(t)]
    assert abs(len(sent) - 3600 * hz) <= 1
    grid_us = [start_us + int(k * 1e6 / hz) for k in range(len(sent))]
    assert all(0 <= t - g < 9_973 for t, g in zip(sent, grid_us, strict=True))


def test_a_clock_that_jitters_around_the_grid_loses_no_slot() -> None:
    rate, random = Rate(100.0), Random(1)
    sent = [rate.due(k * 10_000 + random.choice([-1, 0, 1])) for k in range(10_000)]
    assert sum(sent) >= 9_999


def test_every_tick_slower_than_the_rate_is_due() -> None:
    rate = Rate(100.0)
    assert all(rate.due(k * 15_000) for k in range(100))


def test_a_clock_that_jumps_either_way_anchors_the_grid_anew() -> None:
    rate = Rate(10.0)
    asked = (0, 50_000, 9_000_000, 9_050_000, 9_100_000, 1_000, 51_000, 101_000)
    assert [rate.due(t) for t in asked] == [True, False, True, False, True, True, False, True]
