# SPDX-License-Identifier: MIT
"""Other senders with our system id: the boat detects and reports them, and does not arm."""

from __future__ import annotations

from typing import Any

import pytest
from pymavlink.dialects.v20 import common as mavlink

from tests.target.course import TURN
from tests.target.operator_words import sticks
from tests.target.sea import Sea, Tick, acks, named, texts
from tests.target.stations import ARM, BOAT, MANUAL, Station, command_long, heartbeat, odometry
from tests.target.two_links import OTHER, TO_OTHER, known, sent

DOUBLE = "another sender uses this boat's system"


def doubles(ticks: list[Tick], link: int = 0) -> list[Any]:
    return [m for m in named(ticks, "STATUSTEXT", link) if DOUBLE in m.text]


def test_another_sender_with_our_id_is_reported_at_most_every_ten_seconds() -> None:
    sea = Sea(links=2)
    double = Station(BOAT, 1)
    double.encoder.seq = 100
    sea.run(0.5)
    ticks = []
    for _ in range(25):
        sea.say(heartbeat(), sender=double)
        ticks += sea.run(1.0)
    for link in (0, 1):
        found = doubles(ticks, link)
        assert 2 <= len(found) <= 3 * (1 + (len(found[0].text) > 50))
        assert all(m.severity == mavlink.MAV_SEVERITY_CRITICAL for m in found)


@pytest.mark.parametrize("links", [1, 2])
def test_our_own_broadcast_heard_again_is_not_taken_for_another_sender(links: int) -> None:
    """On a link that receives its own messages, or a second link into the same network."""
    sea = Sea(links=links)
    for _ in range(2000):
        tick = sea.step()
        for link in range(links):
            sea.boat.on_mavlink(sent(tick, link), sea.now_us, links - 1 - link)
    assert not doubles(sea.ticks)
    assert sea.state == "DISARMED" and sea.condition("own_fresh")


@pytest.mark.parametrize("late_s", [0.02, 0.8, 3.3, 6.9])
def test_a_late_echo_is_not_taken_for_another_sender(late_s: float) -> None:
    """Through a slow radio, modem or bridge: within the link's last eight HEARTBEATs."""
    sea = Sea(links=2)
    late = round(late_s * 100)
    for k in range(2000):
        sea.step()
        if k >= late:
            for link in (0, 1):
                sea.boat.on_mavlink(sent(sea.ticks[k - late], link), sea.now_us, 1 - link)
    assert not doubles(sea.ticks) and not doubles(sea.ticks, 1)


def test_an_echo_across_a_change_of_state_is_not_taken_for_another_sender(sea: Sea) -> None:
    """Every change of state sends an additional HEARTBEAT."""
    sea.settle()
    late = 150
    for k in range(1500):
        if k % 100 == 50:
            sea.arm() if sea.state == "DISARMED" else sea.disarm()
        else:
            sea.step()
        if len(sea.ticks) > late:
            sea.boat.on_mavlink(sent(sea.ticks[-late], 0), sea.now_us, 0)
    assert not doubles(sea.ticks)


def test_an_echo_older_than_eight_heartbeats_counts_as_another_sender(sea: Sea) -> None:
    """Another boat with that id, or a replayed recording."""
    recorded = [sent(sea.step(), 0) for _ in range(250)]
    sea.run(12.0)
    assert not doubles(sea.ticks)
    for data in recorded:
        sea.boat.on_mavlink(data, sea.now_us)
        sea.step()
    assert doubles(sea.ticks)


def test_our_own_messages_heard_again_are_neither_obeyed_nor_forwarded() -> None:
    sea = known(2, {1: [OTHER]})
    for message in (command_long(ARM, 1.0), command_long(ARM, 1.0, target=TO_OTHER)):
        frame = Station(BOAT, 1).pack(message)
        sea.boat.on_mavlink(frame, sea.now_us, 0)
        tick = sea.step()
        assert not acks(tick) and frame not in sent(tick, 1)
    assert sea.state == "DISARMED"


def test_two_boats_with_the_same_system_id_notice_each_other() -> None:
    """Two copies of one memory card, switched on half a second apart."""
    one, two = Sea(), Sea()
    ticks: dict[str, list[Tick]] = {"one": [], "two": []}
    for k in range(1500):
        a = one.step()
        ticks["one"].append(a)
        two.boat.on_mavlink(sent(a, 0), two.now_us)
        if k >= 50:
            b = two.step()
            ticks["two"].append(b)
            one.boat.on_mavlink(sent(b, 0), one.now_us)
    assert doubles(ticks["one"]) and doubles(ticks["two"])


def test_a_boat_does_not_arm_while_another_uses_its_system_id() -> None:
    sea = Sea()
    double = Station(BOAT, 1)
    double.encoder.seq = 100
    sea.settle()
    sea.say(heartbeat(), sender=double)
    ticks = [sea.arm()]
    assert sea.state == "DISARMED"
    assert "PreArm: another sender uses this boat's ids" in texts(ticks)
    sea.run(10.1)
    sea.enter_hold()


def test_a_boat_under_the_law_holds_if_another_uses_its_id_and_may_be_driven_home() -> None:
    sea = Sea(leader=TURN)
    sea.enter_formation()
    sea.run(1.0)
    double = Station(BOAT, 1)
    double.encoder.seq = 100
    sea.say(heartbeat(), sender=double)
    sea.run(0.02)
    assert sea.state == "HOLD"
    for _ in range(50):
        sea.say(sticks(0, 0))
        sea.step()
    sea.mode(MANUAL)
    for _ in range(50):
        sea.say(sticks(500, 0))
        sea.step()
    assert sea.state == "MANUAL" and all(sea.commands)


def test_own_states_on_a_second_link_are_ignored_and_reported() -> None:
    """The first link with states may be a radio, and the states those of another boat."""
    sea = Sea(links=2)
    sea.run(1.0)
    sea.say(odometry(sea.own.truth(sea.now_us), sea.now_us), sender=sea.own.station, link=1)
    assert "navigation data ignored: disarm, or set NAV_LINK" in texts(sea.run(0.5))
