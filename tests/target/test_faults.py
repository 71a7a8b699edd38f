# SPDX-License-Identifier: MIT
"""FAULT is latched, and a boat with unmet conditions never moves."""

from __future__ import annotations

import math
import random
from typing import Any

import pytest

from tests.target.course import TURN
from tests.target.sea import Sea, assert_finite, at_sea
from tests.target.stations import ARM, FORCE, SET_MODE, command_long


def test_fault_is_latched_until_the_operator_disarms() -> None:
    sea = at_sea()
    sea.silence("escs")
    sea.run_until("FAULT", 2.0)
    sea.escs[1].on = True
    sea.ticks.clear()
    sea.run(20.0)
    for order in ((SET_MODE, 1.0, 6.0), (SET_MODE, 1.0, 4.0), (ARM, 1.0), (ARM, 1.0, float(FORCE))):
        tick = sea.order(*order)
        assert [m.result for m in tick.named("COMMAND_ACK")] != [0]
        sea.run(0.2)
        assert sea.state == "FAULT"
    assert not any(any(t.commands) for t in sea.ticks)
    assert {s for t in sea.ticks for s in t.arming} == {0}
    sea.disarm()
    assert sea.state == "DISARMED"
    sea.run(1.0)
    assert sea.state == "DISARMED"
    sea.arm()
    assert sea.state == "HOLD" and not any(sea.commands)


def test_a_fault_while_holding_is_latched_too(sea: Sea) -> None:
    sea.enter_hold()
    sea.silence("escs")
    sea.run_until("FAULT", 2.0)
    sea.escs[1].on = True
    sea.run(5.0)
    assert sea.state == "FAULT"


def test_disarming_stops_in_the_same_tick() -> None:
    sea = at_sea()
    tick = sea.disarm()
    assert sea.state == "DISARMED" and tick.commands == (0, 0)
    assert tick.arming[-1] == 0


def test_a_boat_never_starts_armed_nor_moves_by_itself() -> None:
    sea = Sea(leader=TURN)
    ticks = sea.run(60.0)
    assert sea.state == "DISARMED" and {t.commands for t in ticks} == {(0, 0)}


ORDERS: list[tuple[int, float, float]] = [
    (ARM, 1.0, math.nan),
    (ARM, 1.0, float(FORCE)),
    (ARM, 0.0, math.nan),
    (SET_MODE, 1.0, 6.0),
    (SET_MODE, 1.0, 6.0),
]
NEEDED = {
    "FORMATION": ("own_fresh", "leader_fresh", "escs_online", "bus_up", "sole_controller"),
    "COAST": ("own_fresh", "coast_running", "escs_online", "bus_up", "sole_controller"),
}


@pytest.mark.parametrize("orders", range(8))
def test_no_sequence_of_silences_and_commands_moves_a_boat_with_unmet_conditions(
    orders: int,
) -> None:
    """Random commands and silences: only the law turns propellers, while all conditions are met."""
    rng = random.Random(orders)
    sea = Sea(leader=TURN)
    sea.settle()
    driven = stopped = 0
    for _ in range(300):
        act = rng.randrange(8)
        if act < 3:
            anybody: list[Any] = [sea.own, sea.leader, *sea.escs]
            rng.choice(anybody).on = rng.random() < 0.7
        elif act < 6:
            sea.say(command_long(*rng.choice(ORDERS)))
        for _ in range(rng.randrange(1, 60)):
            tick = sea.step()
            seen = sea.snapshot()
            if any(tick.commands):
                driven += 1
                assert all(seen["conditions"][name] for name in NEEDED[seen["state"]])
            if seen["state"] not in NEEDED:
                stopped += 1
                assert seen["thrust_N"] == {"port": 0.0, "stbd": 0.0}
            assert_finite(seen)
    assert driven > 100 and stopped > 100
