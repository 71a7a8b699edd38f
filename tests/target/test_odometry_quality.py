# SPDX-License-Identifier: MIT
"""ODOMETRY's report on itself: a failed estimate, a reset with a jump."""

from __future__ import annotations

import math

import pytest

from tests.target.bus import FULL_SCALE
from tests.target.course import TURN, Course, wrap
from tests.target.sea import Sea, named
from tests.target.stations import odometry, origin

AGENTS = pytest.mark.parametrize("agent", ["own", "leader"])


@AGENTS
@pytest.mark.parametrize("quality", [-1, -100, -128])
def test_odometry_that_says_it_failed_is_a_bad_value(sea: Sea, agent: str, quality: int) -> None:
    sea.run(1.0)
    whose = getattr(sea, agent)
    whose.on = False
    for k in range(30):
        message = odometry(Course(500.0, 500.0), sea.now_us, quality=quality)
        sea.say(origin(), message, sender=whose.station)
        sea.run(0.05)
        assert sea.counter("mavlink_bad_value") == k + 1
    assert not sea.condition(f"{agent}_fresh")


@AGENTS
@pytest.mark.parametrize("quality", [0, 1, 50, 100, 127])
def test_any_other_quality_counts(sea: Sea, agent: str, quality: int) -> None:
    whose = getattr(sea, agent)
    whose.on = False
    for _ in range(10):
        sea.say(origin(), odometry(whose.course, sea.now_us, quality=quality), sender=whose.station)
        sea.run(0.05)
    assert sea.condition(f"{agent}_fresh") and sea.refused("mavlink") == 0


def say_own(sea: Sea, resets: int, north: float = 0.0, late_us: int = 0) -> None:
    truth = sea.own.truth(sea.now_us - late_us)
    moved = Course(truth.north + north, truth.east, truth.psi, truth.u, truth.v, truth.r)
    message = odometry(moved, sea.now_us - late_us, reset_counter=resets)
    sea.say(message, sender=sea.own.station)


OWN = Course(1.0, 2.0, 0.3, 0.6, 0.1, 0.05)


def sailing(leader: Course = TURN, **parameters: float) -> Sea:
    sea = Sea(parameters, own=OWN, leader=leader)
    sea.enter_formation()
    sea.run(1.0)
    sea.own.on = False
    sea.own.origin_on = False
    return sea


class Driven:
    """A boat driven by its propellers with default parameters; its state is measured exactly."""

    def __init__(self) -> None:
        self.sea = Sea(leader=TURN)
        self.sea.enter_formation()
        self.sea.own.on = self.sea.own.origin_on = False
        self.north, self.east, self.psi, self.u, self.v, self.r = 1.0, 2.0, 0.3, 0.0, 0.0, 0.0

    def say(self, resets: int) -> None:
        now = Course(self.north, self.east, wrap(self.psi), self.u, self.v, self.r)
        message = odometry(now, self.sea.now_us, reset_counter=resets % 256)
        self.sea.say(message, sender=self.sea.own.station)

    def step(self) -> None:
        self.sea.step()
        thrust, h = self.sea.snapshot()["thrust_N"], 0.001
        surge, yaw = thrust["port"] + thrust["stbd"], 0.25 * (thrust["port"] - thrust["stbd"])
        for _ in range(self.sea.period_us // 1000):
            u, v, r, c, s = self.u, self.v, self.r, math.cos(self.psi), math.sin(self.psi)
            self.north += h * (c * u - s * v)
            self.east += h * (s * u + c * v)
            self.psi += h * r
            self.u += h * (surge - 3.436 * u + 1.982 * v * r) / 1.012
            self.v += h * (-18.99 * v - 1.012 * u * r) / 1.982
            self.r += h * (yaw - 0.864 * r + (1.012 - 1.982) * u * v) / 0.354


@pytest.mark.parametrize("first", [0, 7, 255])
def test_a_reset_without_a_jump_neither_breaks_nor_jolts(first: int) -> None:
    """From one reset count to the next, also across 255."""
    plain, reset = Driven(), Driven()
    for k in range(1500):
        for boat in (plain, reset):
            if k % 5 == 0:
                boat.say(first + (k // 40 if boat is reset else 0))
            boat.step()
        assert reset.sea.condition("own_fresh") and reset.sea.state == "FORMATION"
        for a, b in zip(plain.sea.commands, reset.sea.commands, strict=True):
            assert abs(a - b) < 0.02 * FULL_SCALE, k
    assert any(plain.sea.commands)
    assert reset.sea.refused("mavlink") == 0


def test_after_a_reset_the_boat_is_where_the_new_estimate_says() -> None:
    """Ten metres in a tick must not appear as a velocity, but they count as a jump."""
    sea = sailing(OWN, LAW_OBS_BW=0.0)  # the true motion ignores thrust
    for _ in range(8):
        say_own(sea, 3)
        sea.run(0.05)
    ticks = []
    for _ in range(8):
        say_own(sea, 4, north=10.0)
        ticks += sea.run(0.05)
        assert sea.condition("own_fresh") and not sea.condition("own_steady")
        assert sea.state == "HOLD" and sea.commands == (0, 0)
    assert max(math.hypot(m.vx, m.vy) for m in named(ticks, "LOCAL_POSITION_NED")) < 0.7
    truth = sea.own.truth(sea.now_us)
    told = named(sea.ticks, "LOCAL_POSITION_NED")[-1]
    assert told.x == pytest.approx(truth.north + 10.0, abs=0.1)


def test_an_older_copy_from_before_a_reset_does_not_bring_the_boat_back() -> None:
    """The same odometry by a second, slower path: it is old, whatever its reset count."""
    sea = sailing()
    for _ in range(20):
        say_own(sea, 3)
        sea.run(0.05)
    say_own(sea, 4, north=10.0)
    sea.run(0.05)
    heard = 0
    for _ in range(4):
        say_own(sea, 4, north=10.0)
        sea.step()
        say_own(sea, 3, late_us=90_000)
        for tick in sea.run(0.04):
            for m in tick.named("LOCAL_POSITION_NED"):
                heard += 1
                assert m.x == pytest.approx(sea.own.truth(tick.now_us).north + 10.0, abs=0.2)
        assert sea.condition("own_fresh") and sea.snapshot()["own_age_s"] < 0.2
    assert heard


def test_a_leaders_reset_neither_breaks_nor_jolts() -> None:
    plain, reset = Sea(leader=TURN), Sea(leader=TURN)
    for sea in (plain, reset):
        sea.enter_formation()
        sea.run(2.0)
        sea.leader.on = False
    for k in range(200):
        for sea in (plain, reset):
            if k % 5 == 0:
                count = k // 40 if sea is reset else 0
                truth = sea.leader.truth(sea.now_us)
                message = odometry(truth, sea.now_us, reset_counter=count)
                sea.say(message, sender=sea.leader.station)
            sea.step()
        assert reset.condition("leader_fresh") and reset.state == "FORMATION"
        for a, b in zip(plain.commands, reset.commands, strict=True):
            assert abs(a - b) < 0.05 * FULL_SCALE, k
