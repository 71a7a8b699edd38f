# SPDX-License-Identifier: MIT
"""An incomplete frame delays the bytes after it only briefly."""

from __future__ import annotations

import pytest

from tests.target.course import TURN
from tests.target.sea import Sea
from tests.target.stations import ARM, BOAT, LEADER, Station, command_long, heartbeat

PATIENCE_S = 0.3
BEGINNINGS = {
    "long one": bytes.fromhex("fdff0000000000000000"),
    "marker alone": b"\xfd",
    "marker and length": b"\xfd\xff",
    "version 1": b"\xfe\xff",
    "signed": bytes.fromhex("fdff0100000000000000"),
    "most of a message": Station(7, 1).pack(heartbeat())[:-1],
    "two": bytes.fromhex("fdff0000000000000000") * 2,
    "many": bytes.fromhex("fdff0000000000000000") * 20,
    "markers": b"\xfd\xfe" * 150,
    "version 1 in a row": b"\xfe\xff" * 100,
}
EACH = pytest.mark.parametrize("beginning", BEGINNINGS)


def seconds_until_disarmed(sea: Sea) -> float:
    since_us = sea.now_us
    while sea.state != "DISARMED":
        sea.tick_only()
        assert sea.now_us - since_us < 5e6, "never"
    return (sea.now_us - since_us) * 1e-6


@EACH
def test_a_disarm_waits_no_longer_than_0_3_s_behind_an_incomplete_frame(beginning: str) -> None:
    sea = Sea(leader=TURN)
    sea.enter_formation()
    sea.boat.on_mavlink(BEGINNINGS[beginning], sea.now_us)
    sea.say(command_long(ARM, 0.0))
    assert seconds_until_disarmed(sea) <= PATIENCE_S + 0.05


@EACH
def test_a_disarm_that_comes_after_an_incomplete_frame_waits_only_for_what_is_left_of_it(
    beginning: str,
) -> None:
    sea = Sea(leader=TURN)
    sea.enter_formation()
    sea.boat.on_mavlink(BEGINNINGS[beginning], sea.now_us)
    for _ in range(20):
        sea.tick_only()
    sea.say(command_long(ARM, 0.0))
    assert seconds_until_disarmed(sea) <= PATIENCE_S - 0.2 + 0.05


@EACH
def test_a_disarm_waits_no_longer_behind_many_incomplete_frames(beginning: str) -> None:
    """The timeout does not restart with each."""
    sea = Sea(leader=TURN)
    sea.enter_formation()
    for _ in range(12):
        sea.boat.on_mavlink(BEGINNINGS[beginning], sea.now_us)
    sea.say(command_long(ARM, 0.0))
    assert seconds_until_disarmed(sea) <= PATIENCE_S + 0.05


@pytest.mark.parametrize("every", [1, 3, 10, 29, 31])
@EACH
def test_a_stream_of_incomplete_frames_does_not_hold_back_a_disarm(
    beginning: str, every: int
) -> None:
    """A radio that loses the end of every message, or an attacker who sends only beginnings."""
    sea = Sea(leader=TURN)
    sea.enter_formation()
    for k in range(60):
        if k % every == 0:
            sea.boat.on_mavlink(BEGINNINGS[beginning], sea.now_us)
        sea.tick_only()
    sea.say(command_long(ARM, 0.0))
    since_us = sea.now_us
    for k in range(100):
        sea.tick_only()
        if sea.state == "DISARMED":
            break
        if (60 + k) % every == 0:
            sea.boat.on_mavlink(BEGINNINGS[beginning], sea.now_us)
    assert (sea.now_us - since_us) * 1e-6 <= PATIENCE_S + 0.05


@pytest.mark.parametrize("chunk_s", [0.05, 0.1, 0.29])
def test_the_timeout_of_each_incomplete_frame_starts_when_the_frame_arrives(chunk_s: float) -> None:
    """26 of them fill one long message; each new one ends another and starts no new timeout."""
    sea = Sea(leader=TURN)
    sea.enter_formation()
    beginning = BEGINNINGS["long one"]
    sea.boat.on_mavlink(beginning * 26, sea.now_us)
    sea.say(command_long(ARM, 0.0))
    since_us = sea.now_us
    every = round(chunk_s * 100)
    for k in range(1, 1000):
        sea.tick_only()
        if sea.state == "DISARMED":
            break
        if k % every == 0:
            sea.boat.on_mavlink(beginning, sea.now_us)
    assert (sea.now_us - since_us) * 1e-6 <= PATIENCE_S + 0.05


@EACH
def test_other_links_do_not_wait_for_an_incomplete_frame(beginning: str) -> None:
    sea = Sea(links=2)
    sea.enter_hold()
    sea.boat.on_mavlink(BEGINNINGS[beginning], sea.now_us, 1)
    sea.disarm()
    assert sea.state == "DISARMED"


def test_a_slow_radios_message_is_waited_for_as_long_as_it_comes() -> None:
    """9600 Bd: a byte a millisecond, in pieces."""
    sea = Sea()
    sea.enter_hold()
    wire = Station(BOAT, 190).pack(command_long(ARM, 0.0))
    assert len(wire) > 40
    for at in range(0, len(wire), 2):
        sea.boat.on_mavlink(wire[at : at + 2], sea.now_us)
        sea.tick_only()
    assert sea.state == "DISARMED"


@EACH
def test_states_are_heard_again_and_the_boat_stays_in_formation(beginning: str) -> None:
    sea = Sea(leader=TURN)
    sea.enter_formation()
    for _ in range(5):
        sea.boat.on_mavlink(BEGINNINGS[beginning], sea.now_us)
        sea.run(1.0)
    assert sea.state == "FORMATION" and sea.boat.parameters()["FORM_LEADER"] == LEADER
