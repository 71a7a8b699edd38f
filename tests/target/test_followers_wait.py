# SPDX-License-Identifier: MIT
"""A boat that leads by its plan, and a follower that falls out of its slot again and again."""

from __future__ import annotations

from typing import Any

import pytest
from pymavlink.dialects.v20 import common as mavlink

from sil.wire.fleet_table import Member, table_message
from tests.dialect import dialect
from tests.target.hull import Afloat
from tests.target.plans import at
from tests.target.stations import BOAT, ORIGIN, PAUSE, STRANGER, Station
from tests.target.test_auto import place, sailing

WAIT_S = 5.0
FOLLOWED = 1


def reference(now_us: int, flags: int, maker: int = STRANGER) -> Any:
    """FORMATION_REFERENCE of a boat that follows."""
    kind = dialect().MAVLink_formation_reference_message
    fields = dict.fromkeys(kind.fieldnames, 0)
    fields |= {"time_boot_ms": now_us // 1000, "sequence": now_us // 200_000 % 2**16}
    fields |= {"latitude": ORIGIN[0], "longitude": ORIGIN[1], "offset_ahead": -4096}
    path = [BOAT] + [0] * 23
    return kind(**(fields | {"root": BOAT, "maker": maker, "flags": flags, "path": path}))


def sailed_m(period_s: int | None, leaves: bool = False, seconds: int = 60) -> float:
    """How far the boat sails while its follower is in its slot for a second of each period."""
    sea = sailing([at(0, 0), at(100, 0)], {"WP_WAIT_S": WAIT_S})
    follower = Station(STRANGER)
    begun_m = place(sea)[0]
    for second in range(seconds):
        for tenth in range(0, 10, 2):
            left = leaves and period_s and second % period_s == 0 and tenth == 0
            flags = 0 if left else FOLLOWED
            sea.say(reference(sea.now_us, flags), sender=follower)
            if tenth == 4 and period_s:
                value = float(second % period_s == 0)
                told = mavlink.MAVLink_named_value_float_message(0, b"IN_SLOT", value)
                sea.say(told, sender=follower)
            sea.run(0.2)
    return place(sea)[0] - begun_m


@pytest.mark.parametrize("leaves", [False, True])
def test_a_follower_that_falls_out_of_its_slot_again_and_again_does_not_stop_the_plan(
    leaves: bool,
) -> None:
    assert sailed_m(4, leaves) > 0.5 * sailed_m(None)


def test_two_followers_that_are_late_in_turn_do_not_stop_the_plan() -> None:
    sea = sailing([at(0, 0), at(100, 0)], {"WP_WAIT_S": 10.0, "FS_SEP_M": 0.0})
    followers = [Station(STRANGER), Station(STRANGER + 1)]
    for second in range(80):
        for _ in range(5):
            for follower in followers:
                said = reference(sea.now_us, FOLLOWED, follower.system)
                sea.say(said, sender=follower)
            sea.run(0.2)
        for turn, follower in enumerate(followers):
            value = float(second < 5 or second // 5 % 2 != turn)
            told = mavlink.MAVLink_named_value_float_message(0, b"IN_SLOT", value)
            sea.say(told, sender=follower)
    assert place(sea)[0] > 25


def told(sea: Afloat, seconds: int, *, in_slot: bool) -> None:
    """The follower reports for that long whether it is in its slot."""
    follower = Station(STRANGER)
    for _ in range(seconds):
        for _ in range(5):
            sea.say(reference(sea.now_us, FOLLOWED), sender=follower)
            sea.run(0.2)
        value = mavlink.MAVLink_named_value_float_message(0, b"IN_SLOT", float(in_slot))
        sea.say(value, sender=follower)


@pytest.mark.parametrize("reason", ["pause", "move"])
def test_the_leader_does_not_use_up_its_wait_while_it_waits_for_another_reason(reason: str) -> None:
    sea = sailing([at(0, 0), at(200, 0)], {"WP_WAIT_S": WAIT_S, "FS_SEP_M": 0.0})
    leader = Member(BOAT, 0, (0.0, 0.0), 1.3)
    shapes = [[leader, Member(STRANGER, BOAT, (-4.0, east_m), 1.3)] for east_m in (0.0, 4.0)]
    sea.boat.on_mavlink(table_message(1, shapes[0]), sea.now_us)
    told(sea, 5, in_slot=True)
    if reason == "pause":
        sea.order(PAUSE, 0.0)
        told(sea, 20, in_slot=False)
        sea.order(PAUSE, 1.0)
    else:  # boats settle for 15 s after a move
        sea.boat.on_mavlink(table_message(2, shapes[1], move_s=14.0), sea.now_us)
        told(sea, 30, in_slot=False)
    told(sea, 2, in_slot=False)
    begun_m = place(sea)[0]
    told(sea, 2, in_slot=False)
    assert place(sea)[0] - begun_m < 0.3
    told(sea, 10, in_slot=False)
    begun_m = place(sea)[0]
    told(sea, 4, in_slot=False)
    assert place(sea)[0] - begun_m > 1.0
