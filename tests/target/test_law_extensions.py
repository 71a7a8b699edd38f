# SPDX-License-Identifier: MIT
"""Extensions of the published law: without any effect when off, effective at once when on."""

from __future__ import annotations

import math
from typing import Any

import pytest

from tests.each_push import few
from tests.target.bus import FULL_SCALE, Frames
from tests.target.course import Course
from tests.target.hull import GREATEST_N, Afloat, Hull, s_curve
from tests.target.operator_words import param_set
from tests.target.sea import PAPER, texts
from tests.target.stations import FORMATION

#: For each extension, a value with an effect.
FELT = {
    "LAW_OBS_BW": 2.0,
    "LAW_XT_DIST": 1.0,
    "LAW_CUR_BW": 0.5,
    "LAW_U_MAX": 0.25,
    "LAW_R_MAX": 0.0625,
    "LAW_REF": 1.0,
    "FORM_FRAME": 1.0,
}
EACH = pytest.mark.parametrize("name", FELT)
BASES = pytest.mark.parametrize("base", [PAPER, {}], ids=["paper", "product"])
SLOT = {"FORM_OFS_N": -1.0, "FORM_OFS_E": 1.0}


def afloat(parameters: dict[str, float]) -> Afloat:
    """A boat under a force and in a current, off its slot beside a leader that turns to and fro."""
    hull = Hull([-4.0, 9.0, -1.33, 0.0, 0.0, 0.0], current=(0.05, -0.1), push=(0.5, 0.05))
    return Afloat(parameters | SLOT, hull, s_curve, own_period_us=10_000)


def sail(parameters: dict[str, float], **told: float) -> list[Frames]:
    """All frames of ten seconds; parameters in `told` are set before arming."""
    sea = afloat(parameters)
    sea.settle()
    if told:
        sea.say(*[param_set(name, value) for name, value in told.items()])
    sea.run(0.1)
    assert sea.boat.parameters().items() >= told.items()
    sea.enter_formation()
    sea.run(10.0)
    assert sea.state == "FORMATION"
    return [tick.can for tick in sea.ticks]


@EACH
@BASES
def test_an_extension_that_is_switched_off_leaves_no_trace(
    name: str, base: dict[str, float]
) -> None:
    """Frames are equal bit for bit whether it was never on or has been switched off."""
    off = sail(base | {name: 0.0})
    felt = sail(base | {name: FELT[name]})
    assert felt != off
    assert sail(base | {name: FELT[name]}, **{name: 0.0}) == off
    assert sail(base | {name: 0.0}, **{name: FELT[name]}) == felt


def wanted(sea: Afloat) -> dict[str, Any]:
    seen = sea.snapshot()
    return {key: seen[key] for key in ("error", "virtual_velocity", "wrench_asked", "unknown")}


@EACH
@BASES
@pytest.mark.parametrize("on", [True, False])
def test_an_extension_switched_under_way_acts_at_once_within_the_propellers_limits(
    name: str, base: dict[str, float], on: bool
) -> None:
    sea, other = (afloat(base | {name: 0.0 if on else FELT[name]}) for _ in range(2))
    for boat in (sea, other):
        boat.enter_formation()
        boat.run(1.0)
    assert wanted(sea) == wanted(other)
    sea.say(param_set(name, FELT[name] if on else 0.0))
    before = sea.commands
    ticks = [sea.step()]
    other.step()
    assert wanted(sea) != wanted(other)
    slew = sea.boat.parameters()["THR_SLEW"] * FULL_SCALE * 0.01 + 1
    for tick in ticks + sea.run(3.0):
        assert all(abs(c) <= FULL_SCALE for c in tick.commands)
        assert all(abs(b - a) <= slew for a, b in zip(before, tick.commands, strict=True))
        before = tick.commands
    assert all(abs(thrust) <= GREATEST_N for thrust in sea.snapshot()["thrust_N"].values())
    assert sea.state == "FORMATION"


LIMITS = {"LAW_U_MAX": 1.5, "LAW_R_MAX": 0.8, "LAW_KPSI": 2.0}
MOST_RADPS, TO_LIMIT = 0.97 * 0.8, 25  # r*; ticks in which it grows from a quarter to that


@pytest.mark.parametrize("bearing", few([0.0, 1.0, 2.5, -1.6, -3.0], [1.0, -3.0]))
def test_a_boat_far_away_asks_for_no_more_than_its_greatest_speed(bearing: float) -> None:
    def greatest(parameters: dict[str, float]) -> tuple[float, float]:
        start = [20.0 * math.cos(bearing), 20.0 * math.sin(bearing), 2.0, 0.0, 0.0, 0.0]
        sea = Afloat(parameters, Hull(start), Course(0.0, 0.0, 0.5, 0.5))
        sea.enter_hold()
        sea.run(0.3)
        sea.mode(FORMATION)
        asked, growing = [], 0
        for _ in range(2000):
            sea.step()
            seen = sea.snapshot()
            asked.append(seen["virtual_velocity"])
            limits = parameters == LIMITS
            fast = abs(asked[-1]["u_mps"]) == pytest.approx(1.5, rel=1e-6)
            assert seen["limited"]["speed"] == (fast and limits)
            turns = abs(asked[-1]["r_radps"]) == pytest.approx(MOST_RADPS, rel=1e-5)
            growing += seen["limited"]["yaw_rate"] and not turns
            assert seen["limited"]["yaw_rate"] or not (turns and limits)
        assert growing <= 2 * TO_LIMIT
        assert sea.state == "FORMATION"
        return max(abs(a["u_mps"]) for a in asked), max(abs(a["r_radps"]) for a in asked)

    u_max, r_max = greatest(LIMITS)
    assert u_max <= 1.5 and r_max <= MOST_RADPS * (1 + 1e-5)
    u_any, r_any = greatest(LIMITS | {"LAW_U_MAX": 0.0, "LAW_R_MAX": 0.0})
    assert u_any > 2.0 and r_any > 1.0


#: A leader at 0.5 m/s that turns by 0.5 rad/s: a slot 10 m to port of it moves at 5.5 m/s.
TURNING, WIDE = Course(0.0, 0.0, 0.5, 0.5, 0.0, 0.5), {"FORM_FRAME": 1.0, "FORM_OFS_E": -10.0}


@pytest.mark.parametrize("scalar", ["float", "q16"])
def test_slot_that_is_too_fast_is_reported_with_the_needed_speed_every_ten_seconds(
    scalar: str,
) -> None:
    sea = Afloat(WIDE | {"LAW_R_MAX": 0.4}, leader=TURNING, scalar=scalar)
    sea.enter_formation()
    sea.run(15.0)
    speed = [text for text in texts(sea.ticks) if "LAW_U_MAX" in text]
    rate = [text for text in texts(sea.ticks) if "LAW_R_MAX" in text]
    assert len(speed) == len(rate) == 2
    needs = [float(text.removeprefix("slot needs ").split(" m/s, ")[0]) for text in speed]
    assert needs == pytest.approx([5.5] * 2, abs=0.1)
    assert all(text.endswith(" m/s, LAW_U_MAX is 1.5") for text in speed)
    assert all(text.endswith(" rad/s, LAW_R_MAX is 0.4") for text in rate)
    seen = sea.snapshot()["slot_needs"]
    assert (seen["u_mps"], seen["r_radps"]) == pytest.approx((5.5, 0.5), abs=0.1)


def test_slot_within_the_limits_or_too_fast_for_a_moment_only_is_no_complaint() -> None:
    sea = Afloat(WIDE | {"LAW_U_MAX": 6.0}, leader=TURNING)
    sea.enter_formation()
    sea.run(5.0)
    assert sea.snapshot()["slot_needs"] == {"u_mps": 0.0, "r_radps": 0.0}
    sea.say(param_set("LAW_U_MAX", 1.5))
    sea.run(1.0)
    assert sea.snapshot()["slot_needs"]["u_mps"] > 5.0
    sea.say(param_set("LAW_U_MAX", 0.0))
    sea.run(5.0)
    assert not [text for text in texts(sea.ticks) if "slot needs" in text]
