# SPDX-License-Identifier: MIT
"""Irregular clocks: standing still, going back, late, jittery, with any start."""

from __future__ import annotations

import random
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.target.agent import START_US
from tests.target.bus import FULL_SCALE, commands
from tests.target.course import BEHIND, TURN, Course
from tests.target.sea import Sea, assert_finite, at_sea, seeded


def test_clock_that_stands_still_does_no_harm() -> None:
    sea = at_sea()
    before, now_us = sea.commands, sea.ticks[-1].now_us
    for _ in range(50):
        out = sea.boat.tick(now_us)
        slots = commands(list(out.can))
        assert all(abs(a - b) <= FULL_SCALE * 0.02 for a, b in zip(slots, before, strict=True))
        assert_finite(sea.snapshot())
    assert sea.state == "FORMATION"
    sea.run(0.5)
    assert sea.state == "FORMATION"


def test_a_clock_that_stands_still_for_the_maximum_age_of_a_state_stops_the_boat() -> None:
    sea = at_sea()
    now_us = sea.ticks[-1].now_us
    for _ in range(52):
        out = sea.boat.tick(now_us)
    assert sea.state == "FAULT" and commands(list(out.can)) == (0, 0)


def test_time_that_runs_backwards_stops_the_boat() -> None:
    sea = at_sea()
    for k in range(52):
        out = sea.boat.tick(sea.ticks[-1].now_us - 10_000 * k)
    assert sea.state == "FAULT" and commands(list(out.can)) == (0, 0)


@pytest.mark.parametrize("back_us", [1, 1_000, 10_000, 1_000_000, START_US])
def test_time_that_goes_back_is_counted_and_makes_no_jump(back_us: int) -> None:
    sea = at_sea()
    before = sea.commands
    assert sea.counter("clock_went_back") == 0
    out = sea.boat.tick(sea.ticks[-1].now_us - back_us)
    assert sea.counter("clock_went_back") == 1
    slots = commands(list(out.can))
    assert all(abs(a - b) <= FULL_SCALE * 0.1 for a, b in zip(slots, before, strict=True))
    assert_finite(sea.snapshot())
    ticks = sea.run(1.0)
    assert sea.counter("clock_went_back") == 1
    steps = [
        abs(b - a) for s, t in pairwise(ticks) for a, b in zip(s.commands, t.commands, strict=True)
    ]
    assert sea.state == "FORMATION" and max(steps) <= FULL_SCALE * 0.06


def test_a_clock_that_stays_back_does_not_keep_old_data_fresh() -> None:
    """300 ticks without any input: whatever the clock shows, the propellers do not turn."""
    sea = at_sea()
    sea.now_us -= 8_000_000
    sea.own.on = sea.leader.on = False
    sea.run(3.0)
    assert not any(sea.commands), "own state and leader have been silent for 3 s"


@pytest.mark.parametrize("ahead_s", [0.1, 1.0, 3600.0, 1e8])
def test_a_late_tick_makes_no_jump_of_the_propellers(ahead_s: float) -> None:
    sea = at_sea({"THR_SLEW": 1.0})
    before = sea.commands
    out = sea.boat.tick(sea.now_us + round(ahead_s * 1e6))
    assert_finite(sea.snapshot())
    slots = commands(list(out.can))
    if ahead_s > 0.5:
        assert slots == (0, 0)
    else:
        assert all(abs(a - b) <= FULL_SCALE * 0.11 for a, b in zip(slots, before, strict=True))


@pytest.mark.parametrize("start_us", [0, 1, 2**31, 2**32 * 1000 - 5_000_000, 1_700_000_000_000_000])
def test_a_boat_may_start_at_any_time(start_us: int) -> None:
    sea = Sea(leader=Course(1.4, 2.2), own=Course(1.0, 2.0), start_us=start_us)
    sea.enter_formation()
    sea.run(10.0)
    assert sea.state == "FORMATION" and any(sea.commands)


@pytest.mark.parametrize("now_us", [-1, 2**63 - 1])
def test_impossible_times_do_no_harm(sea: Sea, now_us: int) -> None:
    sea.settle()
    sea.boat.on_can(0, b"\xc0", now_us)
    sea.boat.on_mavlink(b"\xfd", now_us)
    out = sea.boat.tick(now_us)
    assert commands(list(out.can)) == (0, 0)
    assert_finite(sea.snapshot())
    assert sea.state == "DISARMED"


@pytest.mark.parametrize("now_us", [2**63, 2**64])
def test_times_of_more_than_64_bits_raise_and_change_nothing(sea: Sea, now_us: int) -> None:
    sea.settle()
    before = sea.snapshot()
    for call in (
        lambda: sea.boat.tick(now_us),
        lambda: sea.boat.on_can(0, b"\xc0", now_us),
        lambda: sea.boat.on_mavlink(b"\xfd", now_us),
    ):
        with pytest.raises(TypeError):
            call()
    assert sea.snapshot() == before


@seeded(max_examples=50)
@given(st.lists(st.integers(-3_000_000, 3_000_000), min_size=1, max_size=60))
def test_no_sequence_of_times_gives_nan(steps: list[int]) -> None:
    sea = Sea(own=BEHIND, leader=TURN)
    sea.enter_formation()
    for step in steps:
        sea.now_us = max(0, sea.now_us + step)
        tick = sea.step()
        assert all(abs(c) <= FULL_SCALE for c in tick.commands)
        assert_finite(sea.snapshot())


@pytest.mark.parametrize("seed", range(3))
def test_a_jittery_tick_sails_like_a_regular_one(seed: int) -> None:
    rng = random.Random(seed)
    regular, jittery = at_sea(), at_sea()
    for _ in range(300):
        regular.step()
        jittery.now_us += (shift := rng.randrange(-3000, 3000))
        jittery.step()
        jittery.now_us -= shift
    assert jittery.state == "FORMATION" and jittery.counter("clock_went_back") == 0
    for a, b in zip(regular.commands, jittery.commands, strict=True):
        # Not smaller: the boat's model includes thrust, which moves no hull in this sea.
        assert abs(a - b) < FULL_SCALE * 0.15
