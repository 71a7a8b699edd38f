# SPDX-License-Identifier: MIT
"""Commands: whose are obeyed, and one answer to each."""

from __future__ import annotations

import math

import pytest

from tests.target.sea import Sea, acks, at_sea, named, texts
from tests.target.stations import (
    ACCEPTED,
    ARM,
    BOAT,
    DENIED,
    FORCE,
    FORMATION,
    GCS,
    GCS_COMPONENT,
    LEADER,
    NAVIGATION,
    SET_MODE,
    UNSUPPORTED,
    Station,
    command_long,
)

INBOX = 24  # commands and requests kept between two ticks


@pytest.mark.parametrize("sender", [(GCS, GCS_COMPONENT), (245, 190), (9, 1), (LEADER, 1)])
def test_a_command_gets_exactly_one_ack_that_names_its_sender(
    sea: Sea, sender: tuple[int, int]
) -> None:
    sea.settle()
    sea.gcs = Station(*sender)
    for order in ((ARM, 1.0), (SET_MODE, 1.0, 4.0), (ARM, 0.0), (512, 1.0), (ARM, 7.0)):
        ticks = [sea.order(*order), *sea.run(0.5)]
        found = named(ticks, "COMMAND_ACK")
        assert len(found) == 1 and found[0].command == order[0]
        assert (found[0].target_system, found[0].target_component) == sender
        assert found[0].progress == 255


@pytest.mark.parametrize(
    "command", [0, 1, 16, 17, 21, 22, 179, 183, 246, 513, 521, 611, 31010, 65535]
)
def test_an_unknown_command_is_answered_as_unsupported(sea: Sea, command: int) -> None:
    sea.settle()
    assert acks(sea.order(command)) == [(command, UNSUPPORTED)]
    assert sea.state == "DISARMED"


@pytest.mark.parametrize("command", [ARM, SET_MODE, 185, 209, 245, 510, 511, 512])
@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf, 1e30, -7.5])
def test_an_order_that_makes_no_sense_is_denied(sea: Sea, command: int, value: float) -> None:
    sea.settle()
    for order in ((value,), (value,) * 7):
        assert acks(sea.order(command, *order)) == [(command, DENIED)]
    assert sea.state == "DISARMED"


@pytest.mark.parametrize(
    "target", [(3, 1), (BOAT, 2), (0, 2), (BOAT, NAVIGATION), (GCS, 1), (LEADER, 1)]
)
def test_a_command_to_another_system_or_component_is_neither_obeyed_nor_answered(
    sea: Sea, target: tuple[int, int]
) -> None:
    sea.settle()
    sea.say(command_long(ARM, 1.0, target=target))
    assert not named(sea.run(0.3), "COMMAND_ACK") and sea.state == "DISARMED"


def test_commands_to_another_boat_never_stop_or_start_this_one() -> None:
    sea = at_sea()
    for order in ((ARM, 0.0), (SET_MODE, 1.0, 4.0), (ARM, 0.0, FORCE)):
        sea.say(command_long(*order, target=(3, 1)))
        sea.run(0.2)
    assert sea.state == "FORMATION" and any(sea.commands)


@pytest.mark.parametrize("target", [(0, 0), (BOAT, 0), (0, 1), (BOAT, 1)])
def test_a_broadcast_command_is_obeyed_like_one_to_the_boat(
    sea: Sea, target: tuple[int, int]
) -> None:
    sea.settle()
    assert acks(sea.order(ARM, 1.0, target=target)) == [(ARM, ACCEPTED)]
    assert sea.state == "HOLD"
    assert acks(sea.order(ARM, 0.0, target=target)) == [(ARM, ACCEPTED)]
    assert sea.state == "DISARMED"


@pytest.mark.parametrize("unused", [math.nan, 0.0])
def test_unused_parameters_may_be_nan_or_zero(sea: Sea, unused: float) -> None:
    sea.settle()
    assert acks(sea.order(ARM, 1.0, *[unused] * 6)) == [(ARM, ACCEPTED)]
    sea.mode(FORMATION)
    assert acks(sea.order(SET_MODE, 1.0, 4.0, *[unused] * 5)) == [(SET_MODE, ACCEPTED)]
    assert sea.state == "HOLD"


def test_a_repeated_order_is_answered_each_time_and_obeyed_once(sea: Sea) -> None:
    sea.settle()
    for confirmation in range(5):
        assert acks(sea.order(ARM, 1.0, confirmation=confirmation)) == [(ARM, ACCEPTED)]
        assert sea.state == "HOLD"
    for confirmation in range(5):
        assert acks(sea.order(SET_MODE, 1.0, 6.0, confirmation=confirmation)) == [
            (SET_MODE, ACCEPTED)
        ]
        assert sea.state == "FORMATION"
    sea.run(0.5)
    moving = sea.commands
    assert acks(sea.order(ARM, 1.0, confirmation=1)) == [(ARM, ACCEPTED)]
    assert sea.state == "FORMATION" and sea.commands != (0, 0) and moving != (0, 0)
    for confirmation in range(5):
        assert acks(sea.order(ARM, 0.0, confirmation=confirmation)) == [(ARM, ACCEPTED)]
        assert sea.state == "DISARMED"
    assert texts(sea.ticks) == ["HOLD", "FORMATION", "DISARMED"]


def test_several_orders_in_one_tick_are_all_answered_in_order(sea: Sea) -> None:
    sea.settle()
    orders = ((ARM, 1.0), (183, 1.0), (512, 1.0), (SET_MODE, 1.0, 6.0))
    sea.say(*[command_long(*order) for order in orders])
    results = (ACCEPTED, UNSUPPORTED, ACCEPTED, ACCEPTED)
    assert acks(sea.step()) == [
        (command, result) for (command, *_), result in zip(orders, results, strict=True)
    ]
    assert sea.state == "FORMATION"


def test_a_flood_of_orders_is_answered_or_counted(sea: Sea) -> None:
    sea.settle()
    sea.say(*[command_long(183, 1.0) for _ in range(500)])
    answered = len(named(sea.run(1.0), "COMMAND_ACK"))
    assert answered + sea.counter("requests_dropped") + sea.counter("mavlink_not_sent") == 500
    assert answered == INBOX
    sea.arm()
    assert sea.state == "HOLD"


def test_only_the_ground_station_of_mav_gcs_sysid_commands() -> None:
    sea = Sea({"MAV_GCS_SYSID": 250})
    sea.settle()
    for sender in (
        Station(GCS, GCS_COMPONENT),
        Station(LEADER, 1),
        Station(BOAT, NAVIGATION),
        Station(0, 1),
    ):
        sea.say(command_long(ARM, 1.0), sender=sender)
        assert not [a for a in acks(sea.step()) if a[1] == ACCEPTED]
        assert sea.state == "DISARMED"
    sea.gcs = Station(250, 1)
    assert acks(sea.arm()) == [(ARM, ACCEPTED)]
    sea.say(command_long(SET_MODE, 1.0, 6.0), sender=Station(GCS, GCS_COMPONENT))
    sea.step()
    assert sea.state == "HOLD"


def test_a_command_acks_before_anything_else_that_it_causes(sea: Sea) -> None:
    sea.settle()
    for order in ((ARM, 1.0), (SET_MODE, 1.0, 6.0), (ARM, 0.0)):
        assert sea.order(*order).messages()[0].get_type() == "COMMAND_ACK"
