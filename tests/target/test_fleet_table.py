# SPDX-License-Identifier: MIT
"""Fleet tables that stop a boat, and senders that it does not trust."""

import pytest

from sil.wire.fleet_table import Member, digest_of, table_message
from tests.target.course import TURN
from tests.target.sea import Sea, at_sea, texts
from tests.target.stations import FORMATION, HOLD, MOTOR_TEST, SET_MODE, command_long
from tests.target.test_rc import WITH_RC, hold, rc

LENGTH_M = 1.3
FLEET = [Member(1, 0, (0.0, 0.0), LENGTH_M), Member(2, 1, (-4.0, -4.0), LENGTH_M)]


def member() -> Sea:
    """A boat in FORMATION behind boat 1, by table 3."""
    sea = Sea(leader=TURN)
    sea.enter_formation()
    sea.boat.on_mavlink(table_message(3, FLEET), sea.now_us)
    sea.run(1.5)
    assert "fleet table 3 active" in texts(sea.ticks)
    return sea


def assert_stopped(sea: Sea) -> None:
    sea.run(1.0)
    assert sea.state == "HOLD"
    assert sea.commands == (0, 0)


def test_a_stop_counts_though_a_newer_table_comes_in_the_same_tick() -> None:
    sea = member()
    for frame in (table_message(4, FLEET, stop=True), table_message(5, FLEET)):
        sea.boat.on_mavlink(frame, sea.now_us)
    assert_stopped(sea)


def test_a_stop_wins_over_every_other_table_of_its_epoch() -> None:
    shapes = [[FLEET[0], Member(2, 1, (-4.0, -4.0 - 0.1 * n), LENGTH_M)] for n in range(40)]
    stop = digest_of(table_message(4, FLEET, stop=True))
    assert all(digest_of(table_message(4, shape)) < stop for shape in shapes)
    sea = member()
    for frame in (table_message(4, shapes[1], in_s=3.0), table_message(4, FLEET, stop=True)):
        sea.boat.on_mavlink(frame, sea.now_us)
        sea.run(0.2)
    assert_stopped(sea)


def test_a_stop_counts_for_a_member_that_it_forgets() -> None:
    sea = member()
    others = [FLEET[0], Member(3, 1, (-4.0, 4.0), LENGTH_M)]
    sea.boat.on_mavlink(table_message(4, others, stop=True), sea.now_us)
    assert_stopped(sea)


def test_a_follower_that_a_new_table_leaves_out_stops() -> None:
    sea = member()
    sea.boat.on_mavlink(
        table_message(4, [FLEET[0], Member(3, 1, (-4.0, 4.0), LENGTH_M)]), sea.now_us
    )
    assert_stopped(sea)
    assert "fleet table 4 active; this boat is not in it" in texts(sea.ticks)


def test_a_stop_counts_though_its_places_overlap() -> None:
    sea = member()
    near = [FLEET[0], Member(2, 1, (-0.1, 0.0), LENGTH_M)]
    sea.boat.on_mavlink(table_message(4, near, stop=True), sea.now_us)
    assert_stopped(sea)


def test_a_stop_ends_a_motor_test() -> None:
    sea = Sea(leader=TURN)
    sea.enter_hold()
    sea.boat.on_mavlink(table_message(3, FLEET), sea.now_us)
    sea.run(0.5)
    sea.order(MOTOR_TEST, 1.0, 0.0, 15.0, 4.0, 0.0, 0.0, 0.0)
    assert sea.state == "TEST"
    sea.boat.on_mavlink(table_message(4, FLEET, stop=True), sea.now_us)
    assert_stopped(sea)


def test_a_stop_ends_a_pilots_thrust_until_the_sticks_are_centred() -> None:
    sea = at_sea(WITH_RC)
    sea.boat.on_mavlink(table_message(3, FLEET), sea.now_us)
    hold(sea, rc(on=True), 0.3)
    hold(sea, rc(ahead=0.25, on=True), 0.3)
    assert sea.state == "MANUAL" and any(sea.commands)
    begun = len(sea.ticks)
    sea.boat.on_mavlink(table_message(4, FLEET, stop=True), sea.now_us)
    hold(sea, rc(ahead=0.25, on=True), 0.3)
    assert sea.commands == (0, 0)
    hold(sea, rc(on=True), 0.3)
    hold(sea, rc(ahead=0.25, on=True), 0.3)
    assert sea.state == "MANUAL" and any(sea.commands)
    assert len(texts(sea.ticks[begun:])) < 8


def test_a_stop_drops_a_request_that_came_before_it_in_the_same_tick() -> None:
    sea = member()
    sea.mode(HOLD)
    sea.run(0.2)
    sea.say(command_long(SET_MODE, 1.0, float(FORMATION)))
    sea.boat.on_mavlink(table_message(4, FLEET, stop=True), sea.now_us)
    assert_stopped(sea)
    sea.mode(FORMATION)
    sea.run(0.2)
    assert sea.state == "FORMATION"


def test_an_earlier_stop_that_is_repeated_does_not_stop_the_boat_again() -> None:
    sea = member()
    stop = table_message(4, FLEET, stop=True)
    sea.boat.on_mavlink(stop, sea.now_us)
    assert_stopped(sea)
    sea.enter_formation()
    for _ in range(3):
        sea.boat.on_mavlink(stop, sea.now_us)
        sea.run(0.5)
    assert sea.state == "FORMATION"


@pytest.mark.parametrize("stop", [False, True])
def test_with_an_operators_system_id_a_stranger_gives_no_first_table(stop: bool) -> None:
    sea = Sea({"MAV_GCS_SYSID": 255}, leader=TURN)
    sea.enter_formation()
    theirs = [Member(77, 0, (0.0, 0.0), LENGTH_M), Member(2, 77, (-40.0, -40.0), LENGTH_M)]
    sea.boat.on_mavlink(table_message(1, theirs, stop=stop, sender=(77, 1)), sea.now_us)
    sea.run(2.0)
    assert sea.state == "FORMATION"
    assert "fleet table 1 active" not in texts(sea.ticks)


def test_with_an_operators_system_id_the_leader_may_give_the_first_table() -> None:
    sea = Sea({"MAV_GCS_SYSID": 255}, leader=TURN)
    sea.enter_formation()
    sea.boat.on_mavlink(table_message(1, FLEET, sender=(1, 1)), sea.now_us)
    sea.run(2.0)
    assert "fleet table 1 active" in texts(sea.ticks)
