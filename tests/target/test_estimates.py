# SPDX-License-Identifier: MIT
"""Estimates of unmodelled forces and of the current."""

from __future__ import annotations

import math
import random

import pytest

from tests.target.course import Course
from tests.target.hull import ARM_M, GREATEST_N, Afloat, Hull, s_curve
from tests.target.operator_words import param_set
from tests.target.sea import Sea, Tick, named
from tests.target.stations import FORMATION, odometry, origin
from tests.turns import some

AHEAD = Course(0.0, 0.0, 0.2, 0.5)
UNKNOWN, CURRENT = ("UNK_X", "UNK_N"), ("CUR_N", "CUR_E")


def told(ticks: list[Tick], names: tuple[str, str]) -> tuple[float, float]:
    """The last value of each name."""
    values = {m.name: m.value for tick in ticks for m in tick.named("NAMED_VALUE_FLOAT")}
    return values[names[0]], values[names[1]]


def pushed(sign: float = 1.0, own_period_us: int = 50_000, **parameters: float) -> Afloat:
    """A boat pushed by 1 N ahead and 0.05 N m to starboard, or the opposite."""
    hull = Hull([-2.0, 1.0, 0.3, 0.0, 0.0, 0.0], push=(sign * 1.0, sign * 0.05))
    return Afloat({"SR_SLOW": 5.0} | parameters, hull, AHEAD, own_period_us)


@pytest.mark.parametrize("own_period_us", [10_000, 50_000, 200_000])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_constant_push_is_found_and_forgotten_when_disarmed(
    sign: float, own_period_us: int
) -> None:
    sea = pushed(sign, own_period_us)
    sea.run(2.0)
    assert told(sea.ticks, UNKNOWN) == (0.0, 0.0)
    sea.enter_formation()
    assert told(sea.run(10.0), UNKNOWN) == pytest.approx((sign * 1.0, sign * 0.05), rel=0.03)
    first = sea.disarm()
    assert sea.state == "DISARMED"
    said = named([first, *sea.run(3.0)], "NAMED_VALUE_FLOAT")
    assert not any(m.value for m in some(m for m in said if m.name in UNKNOWN))
    assert told(sea.ticks[-30:], UNKNOWN) == (0.0, 0.0)
    assert set(sea.snapshot()["unknown"].values()) == {0.0}


def test_a_push_that_is_known_does_not_keep_the_boat_off_its_slot() -> None:
    off = []
    for bandwidth in (2.0, 0.0):
        sea = pushed(LAW_OBS_BW=bandwidth)
        sea.enter_formation()
        sea.run(40.0)
        off.append(math.hypot(*sea.off_slot()[:2]))
    assert off[0] < 0.005 and off[1] > 0.4


@pytest.mark.parametrize("own_period_us", [50_000, 200_000])
@pytest.mark.parametrize("heading", [0.0, 1.3, -2.5])
@pytest.mark.parametrize("drift_mps", [0.1, -0.1])
def test_a_current_across_a_straight_leg_is_found(
    drift_mps: float, heading: float, own_period_us: int
) -> None:
    """The component of the current along the bow is not observable."""
    c, s = math.cos(heading), math.sin(heading)
    hull = Hull([-2 * c, -2 * s, heading, 0.0, 0.0, 0.0], current=(-drift_mps * s, drift_mps * c))
    sea = Afloat({}, hull, Course(0.0, 0.0, heading, 0.5), own_period_us)
    sea.enter_formation()
    north, east = told(sea.run(60.0), CURRENT)
    psi = hull.q[2]
    off_n, off_e = north - hull.current[0], east - hull.current[1]
    assert abs(math.cos(psi) * off_e - math.sin(psi) * off_n) < 0.002
    assert math.hypot(off_n, off_e) < 0.02
    assert math.hypot(*sea.off_slot()[:2]) < 0.01
    sea.disarm()
    assert told(sea.run(1.1), CURRENT) == (0.0, 0.0)


def test_a_boat_that_turns_to_and_fro_finds_the_whole_current() -> None:
    sea = Afloat({}, Hull([1.0, 0.5, 0.3, 0.0, 0.0, 0.0], current=(0.08, -0.06)), s_curve)
    sea.enter_formation()
    assert told(sea.run(120.0), CURRENT) == pytest.approx((0.08, -0.06), abs=0.005)


def test_an_estimate_that_is_switched_off_under_way_is_forgotten() -> None:
    hull = Hull([-2.0, 1.0, 0.3, 0.0, 0.0, 0.0], current=(0.0, 0.1), push=(1.0, 0.05))
    sea = Afloat({}, hull, AHEAD)
    sea.enter_formation()
    sea.run(20.0)
    for name, key, other in (
        ("LAW_OBS_BW", "unknown", "current_mps"),
        ("LAW_CUR_BW", "current_mps", "unknown"),
    ):
        known = sea.snapshot()
        assert all(some(known[key].values()))
        sea.say(param_set(name, 0.0))
        sea.run(0.06)  # with the next fix
        assert set(sea.snapshot()[key].values()) == {0.0}
        assert any(sea.snapshot()[other].values()) == any(known[other].values())
    assert sea.state == "FORMATION"


QUICKEST = {"LAW_OBS_BW": 5.0, "LAW_CUR_BW": 1.0}


def bears(sea: Sea) -> bool:
    """Whether the estimates are bounded: half of both propellers' thrust, a current of 2 m/s."""
    seen = sea.snapshot()
    most_N = GREATEST_N * (1 + 1e-6)
    return (
        abs(seen["unknown"]["X_N"]) <= most_N
        and abs(seen["unknown"]["N_Nm"]) <= ARM_M * most_N
        and all(abs(c) <= 2.0 for c in seen["current_mps"].values())
    )


@pytest.mark.parametrize("quick", [False, True])
@pytest.mark.parametrize("steady", [False, True])
def test_absurd_fixes_for_minutes_leave_both_estimates_bounded(steady: bool, quick: bool) -> None:
    """Fixes at any position and speed, or always of the same impossible one; at any time."""
    dice = random.Random(11)
    sea = Sea(QUICKEST if quick else {}, leader=AHEAD)
    sea.enter_formation()
    sea.own.on = False
    limit = Course(5000.0, 5000.0, 3.1, 50.0, 50.0, 20.0)
    greatest_N = 0.0
    for _ in range(1500):
        fields = [x if steady else dice.uniform(-x, x) for x in vars(limit).values()]
        sea.say(origin(), odometry(Course(*fields), sea.now_us), sender=sea.own.station)
        for _ in range(dice.choice([1, 2, 5, 40])):
            sea.step()
            assert bears(sea)
            greatest_N = max(greatest_N, abs(sea.snapshot()["unknown"]["X_N"]))
    assert sea.now_us > sea.ticks[0].now_us + 120_000_000
    assert sea.refused("mavlink") == 0
    assert sea.state == "HOLD"  # armed all the time
    assert steady or greatest_N > 0.95 * GREATEST_N


def test_a_boat_finds_its_slot_again_after_false_states() -> None:
    dice = random.Random(12)
    sea = Afloat({}, Hull([-2.0, 1.0, 0.3, 0.0, 0.0, 0.0]), s_curve)
    sea.enter_formation()
    sea.own.on = False
    for _ in range(200):
        course = Course(*(dice.uniform(-x, x) for x in (3000.0, 3000.0, 3.1, 50.0, 50.0, 20.0)))
        sea.say(odometry(course, sea.now_us), sender=sea.own.station)
        sea.run(0.05)
    sea.own.on = True
    sea.run(2.5)  # a second until it is believed, and one until it is steady
    sea.mode(FORMATION)
    sea.run(60.0)
    assert sea.state == "FORMATION" and math.hypot(*sea.off_slot()[:2]) < 0.1
