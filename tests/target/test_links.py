# SPDX-License-Identifier: MIT
"""One to four MAVLink links: each with its own sequence, parser and answers."""

from __future__ import annotations

from tests.target.course import Course
from tests.target.sea import Sea, acks, messages, texts
from tests.target.stations import ARM, BOAT, HOLD, NAVIGATION, Station, odometry, origin


def test_four_links_hear_the_same_and_each_has_its_own_sequence() -> None:
    sea = Sea(links=4)
    sea.settle()
    for link in (2, 2, 2, 0):
        tick = sea.order(ARM, 1.0, link=link)
        assert [acks(tick, at) != [] for at in range(4)] == [at == link for at in range(4)]
    sea.run(1.0)
    heard = [messages(sea.ticks, link) for link in range(4)]
    for said in heard:
        assert len(said) > 30
        assert [m.get_seq() for m in said] == [k % 256 for k in range(len(said))]
        broadcast = [str(m) for m in said if m.get_type() != "COMMAND_ACK"]
        assert broadcast == [str(m) for m in heard[3]]
    assert [len(said) - len(heard[3]) for said in heard] == [1, 0, 3, 0]


def test_bytes_of_one_link_do_not_disturb_a_frame_half_received_on_another() -> None:
    sea = Sea(links=2)
    nav, other = sea.own.station, Station(BOAT, NAVIGATION)
    first = nav.pack(odometry(Course(1, 1), sea.now_us))
    second = other.pack(origin())
    sea.boat.on_mavlink(first[:50], sea.now_us, 0)
    sea.boat.on_mavlink(second[:9], sea.now_us, 1)
    sea.boat.on_mavlink(first[50:], sea.now_us, 0)
    sea.boat.on_mavlink(second[9:], sea.now_us, 1)
    assert sea.counter("mavlink_received") == 2 and sea.refused("mavlink") == 0


def test_every_change_of_state_is_reported_on_every_link() -> None:
    sea = Sea(links=2)
    sea.enter_formation()
    sea.mode(HOLD)
    sea.disarm()
    for link in (0, 1):
        assert texts(sea.ticks, link) == ["HOLD", "FORMATION", "HOLD", "DISARMED"]
