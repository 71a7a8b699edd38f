# SPDX-License-Identifier: MIT
"""The uncertainty of the leader's position, m, reported as LEAD_UNC."""

from __future__ import annotations

import random
from dataclasses import replace
from itertools import pairwise

import pytest

from tests.target.course import Course
from tests.target.sea import Sea
from tests.target.stations import float32

TURNING = Course(5.0, 5.0, 0.5, 0.6, 0.0, 0.1)


def uncertainty_m(sea: Sea) -> float:
    return float(sea.snapshot()["leader_uncertainty_m"])


def following(period_us: int = 100_000, answered_us: int | None = None) -> Sea:
    """Behind a leader that turns steadily; `answered_us`: latency of its TIMESYNC, None: none."""
    sea = Sea(leader=TURNING)
    sea.leader.period_us = period_us
    if answered_us is not None:
        sea.leader.answers_timesync = True
        sea.leader.delay_us = answered_us
    return sea


def test_no_uncertainty_is_reported_before_the_leader_is_heard(sea: Sea) -> None:
    sea.leader.on = False
    sea.run(2.0)
    assert sea.snapshot()["leader_uncertainty_m"] is None
    told = [m for tick in sea.ticks for m in tick.named("NAMED_VALUE_FLOAT")]
    assert told and "LEAD_UNC" not in {m.name for m in told}


@pytest.mark.parametrize("period_us", [10_000, 100_000])
def test_a_steady_leader_is_known_to_a_millimetre(period_us: int) -> None:
    sea = following(period_us)
    sea.run(3.0)
    for _ in range(100):
        sea.step()
        assert 0.0 <= uncertainty_m(sea) < 1e-3


def test_a_silent_leader_is_known_worse_with_every_tick() -> None:
    sea = following(10_000)
    sea.run(3.0)
    sea.silence("leader")
    told = [uncertainty_m(sea)]
    for _ in range(500):
        sea.step()
        told.append(uncertainty_m(sea))
    assert all(later > before for before, later in pairwise(told))
    assert told[-1] > 0.3  # it may have begun to speed up
    sea.leader.on = True
    sea.run(0.1)
    assert uncertainty_m(sea) < 1e-3


def test_a_leader_whose_velocity_jumps_is_known_worse() -> None:
    def greatest(jump_mps: float) -> float:
        dice = random.Random(5)
        sea, found = following(), []
        for _ in range(50):
            sea.leader.course = replace(TURNING, u=TURNING.u + dice.choice([-1, 1]) * jump_mps)
            sea.run(0.1)
            found.append(uncertainty_m(sea))
        return max(found[10:])

    steady, uneasy, wild = (greatest(jump) for jump in (0.0, 0.2, 1.0))
    assert wild > 3 * uneasy > 9 * steady


def test_the_less_certain_the_leaders_clock_the_less_certain_its_place() -> None:
    """Half the round trip of TIMESYNC is the clock's uncertainty; the leader sails at 0.6 m/s."""
    for way_us in (0, 10_000, 50_000, 200_000):
        sea = following(answered_us=way_us)
        sea.run(5.0)
        assert uncertainty_m(sea) == pytest.approx(0.6 * way_us * 1e-6, abs=3e-3)


def test_the_uncertainty_sent_equals_the_snapshots() -> None:
    sea = following(answered_us=50_000)
    told = 0
    for k in range(600):
        sea.leader.on = not 200 < k < 280
        tick = sea.step()
        known = sea.snapshot()["leader_uncertainty_m"]
        for m in tick.named("NAMED_VALUE_FLOAT"):
            if m.name == "LEAD_UNC":
                told += 1
                assert m.value == float32(known)
    assert told in (5, 6)
