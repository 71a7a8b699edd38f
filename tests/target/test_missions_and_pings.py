# SPDX-License-Identifier: MIT
"""Ground stations' mission requests to a boat without missions; PING; TIMESYNC with targets."""

from __future__ import annotations

import struct
from typing import Any

import pytest
from pymavlink.dialects.v20 import common as mavlink

from tests.target.course import Course
from tests.target.sea import Sea, Tick, named, texts
from tests.target.stations import BOAT, GCS, GCS_COMPONENT, Station, odometry
from tests.target.test_fuzz_mavlink import frame

UNSUPPORTED, MISSION_ACCEPTED, INVALID_SEQUENCE = 3, 0, 13
EACH_TYPE = pytest.mark.parametrize("kind", [0, 1, 2])
TARGETS = pytest.mark.parametrize("target", [(BOAT, 1), (BOAT, 0)])
TIMESYNC = 111


def the_askers(message: Any) -> bool:
    return (message.target_system, message.target_component) == (GCS, GCS_COMPONENT)


# Missions: there are none.


@EACH_TYPE
@TARGETS
def test_a_download_finds_an_empty_mission(sea: Sea, kind: int, target: tuple[int, int]) -> None:
    sea.settle()
    sea.say(mavlink.MAVLink_mission_request_list_message(*target, kind))
    (count,) = named(sea.run(0.2), "MISSION_COUNT")
    assert (count.count, count.mission_type) == (0, kind) and the_askers(count)


@EACH_TYPE
@pytest.mark.parametrize("items", [0, 1, 65535])
def test_an_upload_is_unsupported(sea: Sea, kind: int, items: int) -> None:
    sea.settle()
    sea.say(mavlink.MAVLink_mission_count_message(BOAT, 1, items, kind))
    ticks = sea.run(0.2)
    (ack,) = named(ticks, "MISSION_ACK")
    assert (ack.type, ack.mission_type) == (UNSUPPORTED, kind) and the_askers(ack)
    assert not named(ticks, "MISSION_REQUEST_INT") and not named(ticks, "MISSION_REQUEST")


@EACH_TYPE
def test_clearing_nothing_is_done_at_once(sea: Sea, kind: int) -> None:
    sea.settle()
    sea.say(mavlink.MAVLink_mission_clear_all_message(BOAT, 1, kind))
    (ack,) = named(sea.run(0.2), "MISSION_ACK")
    assert (ack.type, ack.mission_type) == (MISSION_ACCEPTED, kind) and the_askers(ack)


def test_a_request_without_mission_type_means_the_plain_mission(sea: Sea) -> None:
    """MAVLink 1 has no such field."""
    sea.settle()
    payload = bytes([BOAT, 1])
    body = bytes([len(payload), 0, GCS, GCS_COMPONENT, 43]) + payload
    kind = mavlink.MAVLink_mission_request_list_message
    crc = mavlink.x25crc(body + bytes([kind.crc_extra])).crc
    sea.boat.on_mavlink(b"\xfe" + body + crc.to_bytes(2, "little"), sea.now_us)
    (count,) = named(sea.run(0.2), "MISSION_COUNT")
    assert (count.count, count.mission_type) == (0, 0)


@pytest.mark.parametrize("target", [(3, 1), (BOAT, 7), (GCS, 1)])
def test_missions_of_others_are_not_ours(sea: Sea, target: tuple[int, int]) -> None:
    sea.settle()
    sea.say(
        mavlink.MAVLink_mission_request_list_message(*target, 0),
        mavlink.MAVLink_mission_count_message(*target, 3, 0),
        mavlink.MAVLink_mission_clear_all_message(*target, 0),
    )
    ticks = sea.run(0.2)
    assert not named(ticks, "MISSION_COUNT") and not named(ticks, "MISSION_ACK")


ITEM = (0, 6, 16, 2, 1, 0.0, 0.0, 0.0, 0.0)  # current 2: MAVProxy's `guided`


@pytest.mark.parametrize(
    ("message", "result"),
    [
        (mavlink.MAVLink_mission_item_int_message(BOAT, 1, *ITEM, 1, 2, 3.0, 1), UNSUPPORTED),
        (mavlink.MAVLink_mission_item_message(BOAT, 1, *ITEM, 1.0, 2.0, 3.0, 1), UNSUPPORTED),
        (mavlink.MAVLink_mission_request_int_message(BOAT, 1, 0, 1), INVALID_SEQUENCE),
        (mavlink.MAVLink_mission_request_message(BOAT, 1, 7, 1), INVALID_SEQUENCE),
    ],
    ids=lambda value: value.get_type() if hasattr(value, "get_type") else value,
)
def test_items_of_a_mission_are_neither_taken_nor_there(
    sea: Sea, message: Any, result: int
) -> None:
    sea.enter_formation()
    sea.say(message)
    ticks = sea.run(0.5)
    assert sea.state == "FORMATION"
    (ack,) = named(ticks, "MISSION_ACK")
    assert (ack.type, ack.mission_type) == (result, 1) and the_askers(ack)


def test_an_acknowledgement_is_not_acknowledged(sea: Sea) -> None:
    sea.enter_formation()
    sea.say(mavlink.MAVLink_mission_ack_message(BOAT, 1, 0, 0))
    assert not named(sea.run(0.5), "MISSION_ACK") and sea.state == "FORMATION"


# Unsupported services.


def test_there_are_no_logs_to_download(sea: Sea) -> None:
    sea.settle()
    sea.say(mavlink.MAVLink_log_request_list_message(BOAT, 1, 0, 0xFFFF))
    (entry,) = named(sea.run(0.2), "LOG_ENTRY")
    assert (entry.id, entry.num_logs, entry.last_log_num, entry.size) == (0, 0, 0, 0)


NO_ONE = {
    "Refused: boats follow no setpoints": [
        mavlink.MAVLink_set_attitude_target_message(0, BOAT, 1, 0, [1.0, 0, 0, 0], 0, 0, 0, 0),
        mavlink.MAVLink_set_position_target_local_ned_message(0, BOAT, 1, 1, 0, *(0.0,) * 11),
        mavlink.MAVLink_set_position_target_global_int_message(0, BOAT, 1, 5, 0, 0, 0, *(0.0,) * 9),
        mavlink.MAVLink_set_actuator_control_target_message(0, 0, BOAT, 1, [0.0] * 8),
    ],
    "Refused: boats have no missions": [mavlink.MAVLink_mission_set_current_message(BOAT, 1, 0)],
    "Refused: RC override, send MANUAL_CONTROL": [
        mavlink.MAVLink_rc_channels_override_message(BOAT, 1, *[1500] * 8)
    ],
    "Refused: origin and home are the boat's own": [
        mavlink.MAVLink_set_gps_global_origin_message(BOAT, 1, 2, 3),
        mavlink.MAVLink_set_home_position_message(BOAT, 1, 2, 3, 0, 0, 0, [1.0, 0, 0, 0], 0, 0, 0),
    ],
    "Refused: logs are on the boat's disk": [
        mavlink.MAVLink_log_request_data_message(BOAT, 1, 0, 0, 90),
        mavlink.MAVLink_log_erase_message(BOAT, 1),
    ],
}


@pytest.mark.parametrize(
    ("words", "message"),
    [(words, message) for words, them in NO_ONE.items() for message in them],
    ids=lambda value: value.get_type() if hasattr(value, "get_type") else "",
)
def test_what_a_boat_does_not_do_is_told_in_one_sentence_and_not_again_for_ten_seconds(
    sea: Sea, words: str, message: Any
) -> None:
    sea.enter_formation()
    said = []
    for _ in range(109):  # of a client that asks ten times a second
        sea.say(message)
        said += texts(sea.run(0.1))
    assert said == [words] * 2 and len(words) <= 50
    assert sea.state == "FORMATION"
    message.target_system = 3
    sea.say(message)
    assert not texts(sea.run(0.1))


def test_only_the_askers_link_gets_the_answer() -> None:
    sea = Sea(links=2)
    sea.settle()
    sea.say(mavlink.MAVLink_mission_request_list_message(BOAT, 1, 0), link=1)
    ticks = sea.run(0.2)
    assert [len(named(ticks, "MISSION_COUNT", link)) for link in (0, 1)] == [0, 1]


# PING.


@pytest.mark.parametrize("seq", [0, 1, 2**32 - 1])
@pytest.mark.parametrize("time_usec", [0, 123456, 2**64 - 1])
def test_a_ping_to_all_is_answered_with_its_own_numbers(sea: Sea, seq: int, time_usec: int) -> None:
    sea.settle()
    sea.say(mavlink.MAVLink_ping_message(time_usec, seq, 0, 0))
    (pong,) = named(sea.run(0.2), "PING")
    assert (pong.time_usec, pong.seq) == (time_usec, seq) and the_askers(pong)


@pytest.mark.parametrize("target", [(BOAT, 1), (3, 1), (GCS, GCS_COMPONENT)])
def test_an_answer_to_a_ping_is_not_answered(sea: Sea, target: tuple[int, int]) -> None:
    sea.settle()
    sea.say(mavlink.MAVLink_ping_message(5, 6, *target))
    assert not named(sea.run(0.2), "PING")


# TIMESYNC: the extension that tells whom an answer is for.


def timesync(station: Station, tc1: int, ts1: int, *target: int) -> bytes:
    """A TIMESYNC frame with a target, or without as before 2022."""
    payload = struct.pack("<qq", tc1, ts1) + bytes(target)
    return frame(mavlink.MAVLink_timesync_message, payload, station.system, station.component)


def raw(tick: Tick, message_id: int, link: int = 0) -> list[bytes]:
    """The payloads of that message on the wire."""
    found = []
    data = b"".join(each for at, each in tick.mavlink if at == link)
    while data:
        assert data[0] == 0xFD and not data[2] & 1
        if int.from_bytes(data[7:10], "little") == message_id:
            found.append(data[10 : 10 + data[1]])
        data = data[12 + data[1] :]
    return found


@pytest.mark.parametrize("target", [(), (0, 0), (BOAT, 1), (BOAT, 0)], ids=str)
def test_an_answer_names_its_asker(sea: Sea, target: tuple[int, ...]) -> None:
    sea.settle()
    sea.boat.on_mavlink(timesync(sea.gcs, 0, 777, *target), sea.now_us)
    answers = [p for p in raw(sea.step(), TIMESYNC) if p[:8] != bytes(8)]
    assert len(answers) == 1 and len(answers[0]) == 18
    tc1, ts1, system, component = struct.unpack("<qqBB", answers[0])
    assert tc1 > 0 and ts1 == 777 and (system, component) == (GCS, GCS_COMPONENT)


@pytest.mark.parametrize("target", [(3, 1), (BOAT, 197), (GCS, 1)], ids=str)
def test_a_request_to_another_is_not_answered(sea: Sea, target: tuple[int, int]) -> None:
    sea.settle()
    sea.boat.on_mavlink(timesync(sea.gcs, 0, 777, *target), sea.now_us)
    assert not [m for m in named(sea.run(0.1), "TIMESYNC") if m.tc1 != 0]


def test_a_short_request_after_a_long_message_is_for_all(sea: Sea) -> None:
    """A short payload is not completed with bytes of the message before it."""
    sea.settle()
    filled = odometry(Course(), sea.now_us, pose_covariance=[9.5] * 21)
    sea.say(filled, sender=Station(77, 1))
    sea.boat.on_mavlink(timesync(sea.gcs, 0, 777), sea.now_us)
    assert len([m for m in named(sea.run(0.1), "TIMESYNC") if m.tc1 != 0]) == 1


def leader_age(form: str) -> float:
    """The estimated age of a leader hours ahead, 0.1 s late; `form` of its TIMESYNC answers."""
    sea = Sea()
    sea.leader.clock_offset_us = 5 * 3600 * 1_000_000
    sea.leader.delay_us = 100_000
    station = Station(sea.leader.station.system, sea.leader.station.component)
    pending: list[tuple[int, bytes]] = []
    for _ in range(400):
        tick = sea.step()
        for m in tick.named("TIMESYNC"):
            if m.tc1 == 0:
                tc1 = (sea.leader.clock(tick.now_us) + sea.leader.delay_us) * 1000
                message = mavlink.MAVLink_timesync_message(tc1, m.ts1)
                answer = {
                    "version 1": lambda t=message: station.pack(t, version1=True),
                    "no target": lambda a=tc1, b=m.ts1: timesync(station, a, b),
                    "target": lambda a=tc1, b=m.ts1: timesync(station, a, b, BOAT, 1),
                    "another's": lambda a=tc1, b=m.ts1: timesync(station, a, b, 3, 1),
                }[form]()
                pending.append((tick.now_us + 2 * sea.leader.delay_us, answer))
        for at, answer in pending:
            if at == sea.now_us:
                sea.boat.on_mavlink(answer, sea.now_us)
    arrived = (sea.ticks[-1].now_us - 10_000_000) % 100_000
    return float(sea.snapshot()["leader_age_s"]) - arrived * 1e-6


@pytest.mark.parametrize("form", ["version 1", "no target", "target"])
def test_answers_of_old_and_new_implementations_tell_the_leaders_clock(form: str) -> None:
    assert leader_age(form) == pytest.approx(0.1, abs=0.02)


def test_an_answer_for_another_boat_tells_nothing() -> None:
    assert leader_age("another's") == pytest.approx(0.0, abs=0.02)
