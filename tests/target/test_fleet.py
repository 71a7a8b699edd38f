# SPDX-License-Identifier: MIT
"""Many boats in one call per tick behave as boats one by one, byte for byte."""

from __future__ import annotations

from typing import Any

import flotilla
import pytest

from tests.target.reference_fleet import STATES
from tests.target.twin_fleets import EXACT, LOCAL, Twins

LAKE = (-332_000_000, 1_799_999_000, 1_897_000)


def all_in_formation(twins: Twins) -> bool:
    return all(twins.state(boat) == "FORMATION" for boat in twins.boats)


def test_states_are_named_by_their_numbers() -> None:
    assert flotilla.STATES == STATES


@pytest.mark.parametrize("scalar", ["float", "double"])
def test_a_diamond_sails_as_its_boats_do_one_by_one(scalar: str) -> None:
    twins = Twins(scalar)
    twins.diamond()
    twins.enter_formation()
    twins.tick(1700)
    assert all_in_formation(twins)
    assert len(twins.compare()) > 1_000_000


@pytest.mark.parametrize("clock", [(7_000_000_123, 0.0), (0, 40.0), (3_600_000_000, -333.3)])
def test_boats_whose_clocks_drift_hours_apart_sail_as_they_do_one_by_one(
    clock: tuple[int, float],
) -> None:
    twins = Twins()
    twins.diamond(clock=clock)
    twins.enter_formation()
    twins.tick(500)
    assert all_in_formation(twins)
    twins.compare()


@pytest.mark.parametrize("message", ["local", "odometry", "global", "follow_target"])
@pytest.mark.parametrize("attitude_rate_hz", [0.0, 33.0])
@pytest.mark.parametrize("origin", [None, LAKE])
def test_every_kind_of_state_message_is_sent_as_by_a_single_unit(
    message: str, attitude_rate_hz: float, origin: Any
) -> None:
    twins = Twins()
    unit = (20.0, message, attitude_rate_hz)
    twins.diamond(unit=unit if origin is None else (*unit, origin))
    twins.tick(300)
    twins.eta[:, 2] += [3.0, -3.0, 3.141592653589793, 40.0, -1e4]
    twins.tick(100)
    assert len(twins.compare()) > 100_000


@pytest.mark.parametrize("message", ["local", "global"])
@pytest.mark.parametrize("clock", [(0, 0.0), (3_600_000_000, -333.3)])
def test_late_deaf_and_dropping_units_act_in_a_fleet_as_one_by_one(
    message: str, clock: tuple[int, float]
) -> None:
    twins = Twins()
    for run, faults in enumerate([(0.2, False, 0.0, 0.0), (0.013, True, 1.0, 0.3)]):
        twins.diamond(run, unit=(20.0, message, 33.0, LAKE, faults), clock=clock)
    twins.tick(350)
    late, dropping = (twins.compare(run) for run in range(2))
    assert len(dropping) > 100_000 and late != dropping


@pytest.mark.parametrize("rate_hz", [0.9, 7.0, 33.3, 100.0, 400.0])
def test_a_unit_keeps_its_rate_whatever_the_tick(rate_hz: float) -> None:
    twins = Twins()
    leader = twins.leader(unit=(rate_hz, "local", 0.0), clock=(12_345, 60.0))
    boat = twins.boat({"MAV_SYSID": 4, "FORM_LEADER": 100}, unit=(rate_hz, "odometry", 0.0))
    twins.tie(leader, boat)
    twins.tick(300)
    twins.t_us += 5_000_000
    twins.tick(100)
    twins.t_us -= 1_000_000
    twins.tick(100)
    twins.compare()


def test_fleets_that_do_not_hear_each_other_may_use_the_same_ids() -> None:
    twins = Twins()
    for run in range(3):
        twins.diamond(run, east=3.0 * run)
    twins.enter_formation()
    twins.tick(200)
    assert all_in_formation(twins)
    assert len({twins.compare(run) for run in range(3)}) == 3


def test_a_run_is_the_same_alone_and_among_others() -> None:
    alone, among = Twins(), Twins()
    among.leader(run=5, system=9)
    among.diamond(run=7)
    mine = slice(6, 11)
    alone.diamond(run=1, loss=0.2, delay_s=0.03)
    among.diamond(run=1, loss=0.2, delay_s=0.03)
    for twins in (alone, among):
        twins.enter_formation()
        twins.tick(300)
    assert (among.eta[mine] == alone.eta).all()
    assert among.compare(1) == alone.compare(1)


def test_messages_of_a_ground_station_are_heard_and_recorded() -> None:
    twins = Twins()
    boat = twins.boat({"MAV_SYSID": 3}, unit=LOCAL, clock=EXACT)
    twins.tick(50)
    for junk in (b"", b"\xfd", bytes(range(256)) * 20):
        twins.both("hear", boat, junk, twins.t_us)
        twins.both("hear", boat, junk, twins.t_us + 5, 0)
        twins.tick(30)
    assert twins.both("snapshot", boat)["counters"]["mavlink_skipped_bytes"] > 1000
    twins.compare()
