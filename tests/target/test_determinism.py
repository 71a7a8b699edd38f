# SPDX-License-Identifier: MIT
"""Equal input gives equal bytes; float sails like double."""

from __future__ import annotations

import random
from typing import Any

import pytest

from tests.target.course import BEHIND, TURN, Course
from tests.target.sea import Sea, Tick, messages
from tests.target.stations import LEADER

OF_THE_LAW = {
    "ATTITUDE",
    "LOCAL_POSITION_NED",
    "NAMED_VALUE_FLOAT",
    "NAV_CONTROLLER_OUTPUT",
    "POSITION_TARGET_LOCAL_NED",
}


def assert_alike(these: list[Any], those: list[Any]) -> None:
    """Equal bytes, except for values in the law's scalar, which may differ by rounding."""
    assert [m.get_type() for m in these] == [m.get_type() for m in those]
    for a, b in zip(these, those, strict=True):
        if a.get_type() in OF_THE_LAW:
            for name in a.fieldnames:
                here, there = getattr(a, name), getattr(b, name)
                same = there if name == "name" else pytest.approx(there, rel=1e-5, abs=1e-6)
                assert here == same, (a.get_type(), name)
        else:
            assert bytes(a.get_msgbuf()) == bytes(b.get_msgbuf())


@pytest.mark.parametrize(
    "parameters", [{}, {"THR_EXPO": 0.7, "THR_DEAD": 0.2}, {"LAW_KX": 1.0}], ids=str
)
def test_double_and_float_sail_alike(parameters: dict[str, float]) -> None:
    one = Sea(parameters, own=BEHIND, leader=TURN, scalar="float")
    two = Sea(parameters, own=BEHIND, leader=TURN, scalar="double")
    for sea in (one, two):
        sea.enter_formation()
        sea.run(20.0)
    begin = messages(one.ticks[:5])
    assert {m.get_type() for m in begin} & OF_THE_LAW
    assert_alike(begin, messages(two.ticks[:5]))
    for a, b in zip(one.ticks, two.ticks, strict=True):
        assert all(abs(x - y) <= 4 for x, y in zip(a.commands, b.commands, strict=True))
    shown, expected = one.snapshot(), two.snapshot()
    for key in ("error", "virtual_velocity", "wrench_asked", "thrust_N"):
        assert shown[key] == pytest.approx(expected[key], rel=1e-3, abs=1e-3)


@pytest.mark.parametrize("scalar", ["float", "double"])
def test_far_from_the_origin_float_is_as_good_as_double(scalar: str) -> None:
    """Positions are subtracted before conversion to a small scalar."""
    near = Sea(leader=Course(5.0, 5.0, 0.5), own=Course(1.0, 2.0, 0.3))
    far = Sea(
        leader=Course(65541.0, 32773.0, 0.5), own=Course(65537.0, 32770.0, 0.3), scalar=scalar
    )
    for sea in (near, far):
        sea.enter_formation()
        sea.run(1.0)
    assert far.snapshot()["error"] == pytest.approx(near.snapshot()["error"], abs=1e-3)


def story(scalar: str) -> list[Tick]:
    sea = Sea(links=3, own=BEHIND, leader=TURN, scalar=scalar)
    sea.leader.answers_timesync = True
    rng = random.Random(11)
    sea.enter_formation()
    for k in range(1000):
        if k % 10 == 0:
            sea.boat.on_mavlink(rng.randbytes(50), sea.now_us, 1)
            sea.boat.on_can(rng.randrange(2**29), rng.randbytes(8), sea.now_us)
        if k == 500:
            sea.leader.on = False
        if k == 800:
            sea.disarm()
        sea.step()
    return sea.ticks


@pytest.mark.parametrize("scalar", ["float", "double"])
def test_the_same_input_gives_the_same_bytes(scalar: str) -> None:
    assert story(scalar) == story(scalar)


def test_boats_in_one_process_share_nothing() -> None:
    expected = story("float")
    others = [Sea({"MAV_SYSID": k, "FORM_LEADER": LEADER}) for k in (5, 6, 7)]
    for other in others:
        other.run(0.5)
    assert story("float") == expected


def test_the_output_of_a_tick_is_not_changed_later() -> None:
    sea = Sea()  # no fixture: pytest would keep it alive
    out = sea.boat.tick(sea.now_us)
    kept = list(out.mavlink), list(out.can)
    for _ in range(50):
        sea.step()
    assert (list(out.mavlink), list(out.can)) == kept
    del sea
    assert (list(out.mavlink), list(out.can)) == kept
