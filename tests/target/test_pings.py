# SPDX-License-Identifier: MIT
"""Requests for services that a boat does not have; PING; TIMESYNC with targets."""

from __future__ import annotations

import struct
from typing import Any

import pytest
from pymavlink.dialects.v20 import common as mavlink

from tests.target.course import Course
from tests.target.sea import Sea, named, texts
from tests.target.stations import BOAT, GCS, GCS_COMPONENT, Station, odometry
from tests.target.test_fuzz_mavlink import frame

TIMESYNC = 111


def the_askers(message: Any) -> bool:
    return (message.target_system, message.target_component) == (GCS, GCS_COMPONENT)


# Unsupported services.


def test_there_are_no_logs_to_download(sea: Sea) -> None:
    sea.settle()
    sea.say(mavlink.MAVLink_log_request_list_message(BOAT, 1, 0, 0xFFFF))
    (entry,) = named(sea.run(0.2), "LOG_ENTRY")
    assert (entry.id, entry.num_logs, entry.last_log_num, entry.size) == (0, 0, 0, 0)


NO_ONE = {
    "Refused: use position or velocity setpoints": [
        mavlink.MAVLink_set_attitude_target_message(0, BOAT, 1, 0, [1.0, 0, 0, 0], 0, 0, 0, 0),
        mavlink.MAVLink_set_actuator_control_target_message(0, 0, BOAT, 1, [0.0] * 8),
    ],
    "Refused: setpoints need GUIDED": [
        mavlink.MAVLink_set_position_target_local_ned_message(0, BOAT, 1, 1, 0, *(0.0,) * 11),
        mavlink.MAVLink_set_position_target_global_int_message(0, BOAT, 1, 5, 0, 0, 0, *(0.0,) * 9),
    ],
    "Refused: RC override: use MANUAL_CONTROL": [
        mavlink.MAVLink_rc_channels_override_message(BOAT, 1, *[1500] * 8)
    ],
    "Refused: origin and home cannot be set": [
        mavlink.MAVLink_set_gps_global_origin_message(BOAT, 1, 2, 3),
        mavlink.MAVLink_set_home_position_message(BOAT, 1, 2, 3, 0, 0, 0, [1.0, 0, 0, 0], 0, 0, 0),
    ],
    "Refused: no logs are kept": [mavlink.MAVLink_log_request_data_message(BOAT, 1, 0, 0, 90)],
    "Refused: logs cannot be erased remotely": [mavlink.MAVLink_log_erase_message(BOAT, 1)],
}


@pytest.mark.parametrize(
    ("words", "message"),
    [(words, message) for words, them in NO_ONE.items() for message in them],
    ids=lambda value: value.get_type() if hasattr(value, "get_type") else "",
)
def test_an_unsupported_request_is_reported_once_every_ten_seconds(
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


# TIMESYNC: the extension that names the system an answer is for.


def timesync(station: Station, tc1: int, ts1: int, *target: int) -> bytes:
    """A TIMESYNC frame with a target, or without as before 2022."""
    payload = struct.pack("<qq", tc1, ts1) + bytes(target)
    return frame(mavlink.MAVLink_timesync_message, payload, station.system, station.component)


@pytest.mark.parametrize("target", [(), (0, 0), (BOAT, 1), (BOAT, 0)], ids=str)
def test_an_answer_names_its_asker(sea: Sea, target: tuple[int, ...]) -> None:
    sea.settle()
    sea.boat.on_mavlink(timesync(sea.gcs, 0, 777, *target), sea.now_us)
    answers = [p for p in sea.step().payloads(TIMESYNC) if p[:8] != bytes(8)]
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
