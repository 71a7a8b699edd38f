# SPDX-License-Identifier: MIT
"""Forwarding of messages for others, and what a slow link carries."""

from __future__ import annotations

from typing import Any

import pytest
from pymavlink.dialects.v20 import common as mavlink

from tests.target.course import TURN
from tests.target.operator_words import param_list, param_read, param_set, sticks
from tests.target.sea import Sea, Tick, acks, messages, named
from tests.target.stations import (
    ACCEPTED,
    ARM,
    BOAT,
    GCS,
    GCS_COMPONENT,
    LEADER,
    NAVIGATION,
    Station,
    command_long,
    heartbeat,
    odometry,
    origin,
)
from tests.target.two_links import OTHER, TO_OTHER, known, sent, two_links


def signed(station: Station, *messages: Any) -> bytes:
    """Messages signed by that station with a key unknown to the boat."""
    station.encoder.signing.secret_key = bytes(range(32))
    station.encoder.signing.sign_outgoing = True
    station.encoder.signing.link_id = 3
    station.encoder.signing.timestamp = 1_000_000
    return station.pack(*messages)


def with_extensions() -> bytes:
    """A command with extension fields unknown to the boat: longer, with a valid checksum."""
    kind = mavlink.MAVLink_command_long_message
    plain = bytearray(Station(GCS, GCS_COMPONENT).pack(command_long(ARM, 1.0, target=TO_OTHER)))
    payload = bytes(plain[10 : 10 + plain[1]]).ljust(33, b"\0") + b"future"
    body = bytes([len(payload)]) + bytes(plain[2:10]) + payload
    crc = mavlink.x25crc(body + bytes([kind.crc_extra])).crc
    return b"\xfd" + body + crc.to_bytes(2, "little")


FRAMES = {
    "command": lambda gcs: gcs.pack(command_long(ARM, 1.0, target=TO_OTHER)),
    "command to any component": lambda gcs: gcs.pack(command_long(ARM, 1.0, target=(7, 0))),
    "parameters": lambda gcs: gcs.pack(param_list(TO_OTHER)),
    "set": lambda gcs: gcs.pack(param_set("LAW_KX", 1.0, target=TO_OTHER)),
    "version 1": lambda gcs: gcs.pack(command_long(ARM, 1.0, target=TO_OTHER), version1=True),
    "sticks": lambda gcs: gcs.pack(sticks(100, target=7)),
    "signed": lambda gcs: signed(gcs, command_long(ARM, 1.0, target=TO_OTHER)),
    "longer than we know": lambda gcs: with_extensions(),
    "mission": lambda gcs: gcs.pack(
        mavlink.MAVLink_mission_item_int_message(7, 1, 3, 0, 16, 0, 1, 0, 0, 0, 0, 1, 2, 3.0)
    ),
    "file": lambda gcs: gcs.pack(
        mavlink.MAVLink_file_transfer_protocol_message(0, 7, 1, list(range(251)))
    ),
    "ping": lambda gcs: gcs.pack(mavlink.MAVLink_ping_message(123, 4, 7, 1)),
}


@pytest.mark.parametrize("what", FRAMES)
def test_a_message_for_another_is_handed_on_byte_for_byte_with_the_next_tick(what: str) -> None:
    sea = two_links()
    frame = FRAMES[what](Station(GCS, GCS_COMPONENT))
    sea.boat.on_mavlink(frame, sea.now_us, 0)
    tick = sea.step()
    assert frame in sent(tick, 1)
    assert frame not in sent(tick, 0)
    later = sea.run(1.0)
    assert not [t for t in later if frame in sent(t, 0) or frame in sent(t, 1)]
    assert sea.state == "DISARMED" and not named(sea.ticks, "COMMAND_ACK")
    assert not named(sea.ticks, "PARAM_VALUE")


@pytest.mark.parametrize("beyond", ["off", "accept", "required"])
def test_forwarded_messages_keep_their_signatures(beyond: str) -> None:
    """Signed by its original sender, not by the boat that forwards it."""
    key, unix_s, other = bytes(range(32)), 1_800_000_000, Station(7, 1)
    sea = Sea(links=2)
    sea.boat.secure(key, unix_s * 1_000_000)
    sea.boat.set_signing(0, "required")
    sea.boat.set_signing(1, beyond)
    sea.own.on = sea.leader.on = False
    for station in (sea.gcs, other):
        station.encoder.signing.secret_key = key
        station.encoder.signing.sign_outgoing = True
        station.encoder.signing.timestamp = (unix_s - 1_420_070_400) * 100_000
    sea.say(heartbeat(), link=0)
    sea.say(heartbeat(), sender=other, link=1)
    sea.run(0.2)
    frame = sea.gcs.pack(command_long(ARM, 1.0, target=TO_OTHER))
    assert frame[2] & 1
    sea.boat.on_mavlink(frame, sea.now_us, 0)
    assert frame in sent(sea.step(), 1)
    forged = bytearray(sea.gcs.pack(command_long(ARM, 1.0, target=TO_OTHER)))
    forged[-1] ^= 1
    unsigned = Station(GCS, GCS_COMPONENT).pack(command_long(ARM, 1.0, target=TO_OTHER))
    for refused in (bytes(forged), unsigned):
        sea.boat.on_mavlink(refused, sea.now_us, 0)
        assert refused not in sent(sea.step(), 1)


@pytest.mark.parametrize("heard_on", ["off", "accept"])
def test_nothing_unsigned_leaves_by_a_link_that_requires_signatures(heard_on: str) -> None:
    """A camera's 40 kB/s by cable, for the operator beyond the radio."""
    key, unix_s = bytes(range(32)), 1_800_000_000
    sea = Sea(links=2)
    sea.boat.secure(key, unix_s * 1_000_000)
    sea.boat.set_signing(0, heard_on)
    sea.boat.set_signing(1, "required")
    station = Station(GCS, GCS_COMPONENT)
    station.encoder.signing.secret_key = key
    station.encoder.signing.sign_outgoing = True
    station.encoder.signing.timestamp = (unix_s - 1_420_070_400) * 100_000
    sea.say(heartbeat(), sender=station, link=1)
    sea.step()
    camera = Station(BOAT, 100)
    handed_on = 0
    for _ in range(100):
        sea.say(
            mavlink.MAVLink_file_transfer_protocol_message(0, GCS, 190, [1] * 251), sender=camera
        )
        handed_on += sum(m.get_srcComponent() == 100 for m in sea.step().messages(1))
    assert handed_on == 0
    assert sea.counter("mavlink_unsigned_refused") == 100
    assert all(m.get_msgbuf()[2] & 1 for m in messages(sea.ticks, 1))


def test_the_answer_finds_its_way_back() -> None:
    sea = two_links()
    answer = OTHER.pack(
        mavlink.MAVLink_command_ack_message(ARM, 0, 255, 0, GCS, GCS_COMPONENT),
    )
    sea.boat.on_mavlink(answer, sea.now_us, 1)
    tick = sea.step()
    assert answer in sent(tick, 0) and answer not in sent(tick, 1)


def test_setup_signing_is_never_handed_on() -> None:
    """It contains the key."""
    sea = two_links()
    frame = sea.gcs.pack(mavlink.MAVLink_setup_signing_message(7, 1, list(range(32)), 99))
    sea.boat.on_mavlink(frame, sea.now_us, 0)
    assert not [t for t in sea.run(0.5) if bytes(range(32)) in sent(t, 1)]


@pytest.mark.parametrize("cuts", [1, 7, 40])
def test_a_frame_that_comes_in_pieces_is_handed_on_whole(cuts: int) -> None:
    sea = two_links()
    frame = FRAMES["file"](Station(GCS, GCS_COMPONENT))
    for at in range(0, len(frame), cuts):
        sea.boat.on_mavlink(frame[at : at + cuts], sea.now_us, 0)
    assert frame in sent(sea.step(), 1)


def test_several_in_one_tick_keep_their_order() -> None:
    sea = two_links()
    frames = [FRAMES[what](sea.gcs) for what in ("command", "set", "parameters", "sticks")]
    sea.boat.on_mavlink(b"".join(frames), sea.now_us, 0)
    assert b"".join(frames) in sent(sea.step(), 1)


def test_a_damaged_frame_is_not_handed_on() -> None:
    sea = two_links()
    frame = bytearray(FRAMES["set"](Station(GCS, GCS_COMPONENT)))
    frame[14] ^= 1
    sea.boat.on_mavlink(bytes(frame), sea.now_us, 0)
    assert not [t for t in sea.run(0.5) if bytes(frame[10:20]) in sent(t, 1)]


def test_a_message_for_an_unknown_system_is_not_forwarded() -> None:
    sea = two_links()
    for target in ((9, 1), (7, 2)):
        frame = sea.gcs.pack(command_long(ARM, 1.0, target=target))
        sea.boat.on_mavlink(frame, sea.now_us, 0)
        assert not [t for t in sea.run(0.3) if frame in sent(t, 0) + sent(t, 1)]


@pytest.mark.parametrize("target", [(0, 0), (0, 1)])
def test_broadcasts_are_not_forwarded(target: tuple[int, int]) -> None:
    sea = two_links()
    for message in (
        heartbeat(),
        origin(),
        odometry(sea.own.course, sea.now_us),
        command_long(512, 0.0, target=target),
        param_read("LAW_KX", target),
        mavlink.MAVLink_statustext_message(6, b"hello everybody"),
        mavlink.MAVLink_timesync_message(0, 5),
    ):
        frame = OTHER.pack(message)
        sea.boat.on_mavlink(frame, sea.now_us, 1)
        tick = sea.step()
        assert frame not in sent(tick, 0) + sent(tick, 1)


def test_messages_for_this_boat_are_not_forwarded() -> None:
    sea = two_links()
    frame = sea.gcs.pack(command_long(ARM, 1.0))
    sea.boat.on_mavlink(frame, sea.now_us, 0)
    tick = sea.step()
    assert acks(tick) == [(ARM, ACCEPTED)] and frame not in sent(tick, 1)


def test_another_component_of_this_boat_gets_its_messages() -> None:
    """Its navigation unit on link 1: messages for it are forwarded, broadcasts reach both."""
    unit = Station(BOAT, NAVIGATION)
    sea = Sea(links=2)
    sea.own.on = False  # it would be on link 0 too
    sea.say(heartbeat(), sender=unit, link=1)
    sea.run(0.5)
    to_unit = sea.gcs.pack(param_list((BOAT, NAVIGATION)))
    sea.boat.on_mavlink(to_unit, sea.now_us, 0)
    tick = sea.step()
    assert to_unit in sent(tick, 1)
    assert not named([tick, *sea.run(0.5)], "PARAM_VALUE")
    to_all = sea.gcs.pack(param_read("LAW_KX", (BOAT, 0)))
    sea.boat.on_mavlink(to_all, sea.now_us, 0)
    tick = sea.step()
    assert to_all in sent(tick, 1)
    assert len(named([tick, *sea.run(0.5)], "PARAM_VALUE")) == 1


def test_nothing_goes_back_where_it_came_from() -> None:
    sea = known(2, {0: [Station(GCS, GCS_COMPONENT), OTHER]})
    frame = FRAMES["command"](Station(GCS, GCS_COMPONENT))
    sea.boat.on_mavlink(frame, sea.now_us, 0)
    assert not [t for t in sea.run(0.5) if frame in sent(t, 0) + sent(t, 1)]


def test_nothing_circles_where_two_links_reach_the_same_boats() -> None:
    sea = known(3, {0: [OTHER, Station(GCS, GCS_COMPONENT)], 1: [OTHER], 2: []})
    frame = FRAMES["command"](Station(GCS, GCS_COMPONENT))
    for link in (0, 1):  # the addressee hears it on that link itself
        sea.boat.on_mavlink(frame, sea.now_us, link)
        assert not [t for t in sea.run(0.5) if any(frame in sent(t, k) for k in range(3))]
    sea.boat.on_mavlink(frame, sea.now_us, 2)
    tick = sea.step()
    assert frame in sent(tick, 0) and frame in sent(tick, 1) and frame not in sent(tick, 2)


def test_of_three_links_only_the_addressees_link_gets_a_message() -> None:
    sea = known(3, {0: [Station(GCS, GCS_COMPONENT)], 1: [OTHER], 2: [Station(9, 1)]})
    frame = FRAMES["set"](Station(GCS, GCS_COMPONENT))
    sea.boat.on_mavlink(frame, sea.now_us, 0)
    tick = sea.step()
    assert [frame in sent(tick, k) for k in range(3)] == [False, True, False]


def test_two_boats_between_two_links_do_not_make_a_message_circle() -> None:
    """Both are on both links, a ground station on the first, the addressee on the second."""
    one = known(2, {0: [Station(GCS, GCS_COMPONENT)], 1: [OTHER]})
    two = Sea({"MAV_SYSID": 3, "FORM_LEADER": LEADER}, links=2)
    two.say(heartbeat(), sender=Station(GCS, GCS_COMPONENT), link=0)
    two.say(heartbeat(), sender=OTHER, link=1)
    two.step()
    frame = Station(GCS, GCS_COMPONENT).pack(command_long(512, 0.0, target=TO_OTHER))
    copies = 0
    wire = {0: frame, 1: b""}
    for _ in range(200):
        for sea in (one, two):
            for link in (0, 1):
                sea.boat.on_mavlink(wire[link], sea.now_us, link)
        out = [sea.step() for sea in (one, two)]
        wire = {link: b"".join(sent(tick, link) for tick in out) for link in (0, 1)}
        copies += wire[1].count(frame)
        assert not wire[0].count(frame)
    assert copies <= 2


def test_forwarding_does_not_spoil_the_boats_own_frames() -> None:
    sea = two_links()
    for k in range(300):
        gcs = Station(GCS, GCS_COMPONENT)
        sea.say(command_long(ARM, 1.0, target=TO_OTHER, confirmation=k % 256), sender=gcs)
        sea.step()
    heard = messages(sea.ticks, 1)
    own = [m for m in heard if m.get_srcSystem() == BOAT]
    assert len([m for m in heard if m.get_srcSystem() == GCS]) == 300
    assert all(m.get_type() != "BAD_DATA" for m in heard)
    first = own[0].get_seq()
    assert [m.get_seq() for m in own] == [(first + k) % 256 for k in range(len(own))]


def test_a_flood_for_another_does_not_silence_the_boat() -> None:
    sea = two_links()
    frame = FRAMES["file"](Station(GCS, GCS_COMPONENT))
    ticks = []
    for _ in range(300):
        sea.boat.on_mavlink(frame * 20, sea.now_us, 0)
        ticks.append(sea.step())
    assert len(named(ticks, "HEARTBEAT", 1)) == 3
    assert len(named(ticks, "ATTITUDE", 1)) in range(29, 32)
    assert sea.counter("mavlink_not_sent") > 0
    assert not [m for m in messages(ticks, 1) if m.get_type() == "BAD_DATA"]


# Stations that change links.


@pytest.mark.parametrize("silent_s", [8.0, 10.5, 30.0])
def test_messages_follow_a_system_to_another_link(silent_s: float) -> None:
    """A ground station connects first by radio, then by cable."""
    gcs = Station(GCS, GCS_COMPONENT)
    sea = known(3, {0: [gcs], 2: [OTHER]})
    for _ in range(round(silent_s / 0.5)):
        sea.say(heartbeat(), sender=gcs, link=1)
        sea.say(heartbeat(), sender=OTHER, link=2)
        sea.run(0.5)
    answer = OTHER.pack(mavlink.MAVLink_command_ack_message(ARM, 0, 255, 0, GCS, GCS_COMPONENT))
    sea.boat.on_mavlink(answer, sea.now_us, 2)
    tick = sea.step()
    assert answer in sent(tick, 1)
    assert (answer in sent(tick, 0)) == (silent_s < 10)


def test_a_message_on_a_stations_old_link_is_forwarded_to_its_new_link() -> None:
    """A message is not forwarded while its addressee counts as being on the link it came by."""
    gcs = Station(GCS, GCS_COMPONENT)
    sea = known(2, {0: [gcs, OTHER]})
    sea.say(heartbeat(), sender=OTHER, link=1)
    sea.run(10.2)
    sea.say(heartbeat(), sender=OTHER, link=1)
    frame = FRAMES["command"](gcs)
    sea.boat.on_mavlink(frame, sea.now_us, 0)
    tick = sea.step()
    assert frame in sent(tick, 1) and frame not in sent(tick, 0)


def test_a_system_silent_for_ten_seconds_is_forgotten() -> None:
    sea = two_links()
    sea.run(9.0)
    frame = FRAMES["command"](Station(GCS, GCS_COMPONENT))
    sea.boat.on_mavlink(frame, sea.now_us, 0)
    assert frame in sent(sea.step(), 1)
    sea.run(1.0)
    sea.boat.on_mavlink(frame, sea.now_us, 0)
    assert frame not in sent(sea.step(), 1)


def radio_status(txbuf: int = 40) -> Any:
    return mavlink.MAVLink_radio_status_message(200, 200, txbuf, 40, 40, 0, 0)


@pytest.mark.parametrize("policy", ["off", "required"])
def test_radio_status_adds_no_route(policy: str) -> None:
    """A radio's own messages are unsigned, whatever system id they have."""
    sea = Sea(links=3)
    sea.boat.secure(bytes(range(32)), 1_800_000_000_000_000)
    sea.boat.set_signing(1, policy)
    sea.say(heartbeat(), link=0)
    sea.step()
    sea.say(radio_status(), sender=OTHER, link=1)
    sea.run(0.1)
    frame = FRAMES["command"](Station(GCS, GCS_COMPONENT))
    sea.boat.on_mavlink(frame, sea.now_us, 0)
    assert not [t for t in sea.run(0.5) if frame in sent(t, 1) or frame in sent(t, 2)]


def test_radio_status_does_not_keep_a_route_alive() -> None:
    sea = two_links()
    for _ in range(24):
        sea.say(radio_status(), sender=OTHER, link=1)
        sea.run(0.5)
    frame = FRAMES["command"](Station(GCS, GCS_COMPONENT))
    sea.boat.on_mavlink(frame, sea.now_us, 0)
    assert not [t for t in sea.run(0.5) if frame in sent(t, 1)]


@pytest.mark.parametrize("station", [(BOAT, 197), (LEADER, 1), (BOAT, 1)], ids=str)
def test_radio_status_with_our_or_our_leaders_id_changes_nothing(
    station: tuple[int, int],
) -> None:
    plain, beset = Sea(leader=TURN), Sea(leader=TURN)
    for sea in (plain, beset):
        sea.enter_formation()
        for k in range(300):
            if sea is beset and k % 5 == 0:
                sea.say(radio_status(), sender=Station(*station))
            sea.step()
    assert [t.commands for t in plain.ticks] == [t.commands for t in beset.ticks]
    assert beset.state == "FORMATION" and not named(beset.ticks, "STATUSTEXT")[2:]


# Limits of forwarding.


def forwarded(tick: Tick, frame: bytes, link: int) -> int:
    return sent(tick, link).count(frame) * len(frame)


@pytest.mark.parametrize("what", ["file", "command", "ping"])
def test_in_a_tick_400_bytes_at_most_are_handed_on_to_a_link(what: str) -> None:
    sea = two_links()
    frame = FRAMES[what](Station(GCS, GCS_COMPONENT))
    most = 0
    for _ in range(100):
        sea.boat.on_mavlink(frame * 40, sea.now_us, 0)
        most = max(most, forwarded(sea.step(), frame, 1))
    assert 400 - len(frame) < most <= 400


def states_per_s(ticks: list[Tick], link: int) -> float:
    return len(named(ticks, "ATTITUDE", link)) * 100 / len(ticks)


@pytest.mark.parametrize("bytes_per_s", [400, 1200, 5760])
@pytest.mark.parametrize("flood", ["forwards", "pings", "questions", "parameters", "all"])
def test_nothing_slows_the_state_below_its_share_of_a_slow_link(
    bytes_per_s: int, flood: str
) -> None:
    """State and reference share three fifths, 40 + 40 bytes and, every second time, 106."""
    sea = known(2, {0: [Station(GCS, GCS_COMPONENT)], 1: [OTHER]})
    sea.boat.limit_link(1, bytes_per_s)
    here, there = Station(GCS, GCS_COMPONENT), Station(88, 190)
    wire = {
        "forwards": (FRAMES["file"](here) * 2, b""),
        "pings": (b"", there.pack(mavlink.MAVLink_ping_message(1, 2, 0, 0)) * 24),
        "questions": (b"", there.pack(command_long(512, 251.0)) * 24),
        "parameters": (b"", there.pack(param_list((BOAT, 1)))),
    }
    wire["all"] = (wire["forwards"][0], b"".join(b for _, b in wire.values()))
    ticks = []
    for k in range(1000):
        for link, data in enumerate(wire[flood]):
            sea.boat.on_mavlink(data, sea.now_us, link)
        if k % 100 == 0:
            sea.say(heartbeat(), sender=OTHER, link=1)
        ticks.append(sea.step())
    carried = min(10.0, 0.6 * bytes_per_s / (80 + 106 / 2))
    assert states_per_s(ticks, 1) >= 0.95 * carried - 0.1
    assert len(named(ticks, "HEARTBEAT", 1)) == 10
    assert states_per_s(ticks, 0) == pytest.approx(10, abs=0.2)


@pytest.mark.parametrize("bytes_per_s", [400, 800])
def test_a_slow_link_carries_a_reference_for_every_two_states(bytes_per_s: int) -> None:
    sea = two_links()
    sea.boat.limit_link(1, bytes_per_s)
    ticks = sea.run(20.0)
    told = {name: len(named(ticks, name, 1)) / 20 for name in ("ATTITUDE", "FORMATION_REFERENCE")}
    assert told["FORMATION_REFERENCE"] == pytest.approx(told["ATTITUDE"] / 2, rel=0.1)
    assert told["ATTITUDE"] > 2.5 * bytes_per_s / 400


@pytest.mark.parametrize("bytes_per_s", [400, 1200, 5760])
def test_a_slow_link_is_handed_no_more_than_it_carries(bytes_per_s: int) -> None:
    sea = two_links()
    sea.boat.limit_link(1, bytes_per_s)
    frame = FRAMES["file"](Station(GCS, GCS_COMPONENT))
    ticks = []
    for k in range(3000):
        sea.boat.on_mavlink(frame, sea.now_us, 0)
        if k % 100 == 0:
            sea.say(heartbeat(), sender=OTHER, link=1)
        ticks.append(sea.step())
    assert sea.counter("mavlink_not_sent") > 0
    handed = sum(forwarded(t, frame, 1) for t in ticks)
    assert handed >= max(len(frame), 30 * bytes_per_s * 0.4 * 0.2)
    assert named(ticks, "NAMED_VALUE_FLOAT", 1)
    assert sum(len(sent(t, 1)) for t in ticks) < 30 * bytes_per_s * 1.15
