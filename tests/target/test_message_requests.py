# SPDX-License-Identifier: MIT
"""A request for a message: the ACK first, then the message, on the requester's link only."""

from __future__ import annotations

import math
import re
import zlib
from typing import Any

import flotilla
import pytest

from tests.target.course import Course
from tests.target.operator_words import command_int
from tests.target.sea import Sea, Tick, acks, named
from tests.target.stations import (
    ACCEPTED,
    BOAT,
    DENIED,
    GCS,
    GCS_COMPONENT,
    GET_INTERVAL,
    ORIGIN,
    TEMPORARILY_REJECTED,
    UNSUPPORTED,
    Station,
    command_long,
    kind_of,
)
from tests.target.stations import REQUEST_MESSAGE as REQUEST

VERSION, CAPABILITIES = 519, 520
INTERVAL, MODES, ODOMETRY = 244, 435, 331
# those that clients need, and all others that a boat can send
ASKED_FOR = [148, 242, 49, MODES, 436, 397, 1, 0, INTERVAL, 33, 32, 30, ODOMETRY, 300, 396]
ALSO_TOLD = [2, 62, 85, 144, 147, 245, 251, 290, 291]
NEEDS_OWN_STATE = [49, 33, 32, 30, ODOMETRY, 62, 85, 144]
QUIET = {"SR_STATE": 0.0, "SR_SLOW": 0.0}
MAVLINK2, MISSION_INT, COMMAND_INT, PARAM_BYTEWISE, FTP = 8192, 4, 8, 16, 32  # as capabilities


@pytest.fixture
def quiet() -> Sea:
    """A boat without faults, between two ticks with regular messages."""
    sea = Sea(QUIET)
    sea.run(1.15)
    return sea


def answered(tick: Tick, command: int, result: int, link: int = 0) -> list[Any]:
    """The messages after the only ACK, which comes first and names the requester."""
    first, *others = tick.messages(link)
    assert first.get_type() == "COMMAND_ACK"
    assert (first.command, first.result, first.progress) == (command, result, 255)
    assert (first.target_system, first.target_component) == (GCS, GCS_COMPONENT)
    assert "COMMAND_ACK" not in [m.get_type() for m in others]
    return others


@pytest.mark.parametrize("unused", [math.nan, 0.0], ids=["NaN", "0"])
@pytest.mark.parametrize("message_id", ASKED_FOR + ALSO_TOLD)
def test_a_requested_message_follows_its_ack(quiet: Sea, message_id: int, unused: float) -> None:
    others = answered(quiet.order(REQUEST, message_id, *[unused] * 6), REQUEST, ACCEPTED)
    assert others and {m.get_type() for m in others} == {kind_of(message_id)}
    assert len(others) == {MODES: 7, 251: 22}.get(message_id, 1)
    assert not named(quiet.run(0.5), "COMMAND_ACK")


@pytest.mark.parametrize("message_id", ASKED_FOR + ALSO_TOLD)
def test_a_command_int_asks_for_the_same(quiet: Sea, message_id: int) -> None:
    quiet.say(command_int(REQUEST, float(message_id)))
    others = answered(quiet.step(), REQUEST, ACCEPTED)
    assert others and {m.get_type() for m in others} == {kind_of(message_id)}


# Messages that a boat lacks, an operator's own messages, numbers beyond all messages.
@pytest.mark.parametrize(
    "message_id", [4, 11, 20, 22, 25, 47, 66, 73, 76, 77, 111, 253, 410, 437, 9999, 65535, 12900]
)
def test_a_message_that_a_boat_lacks_is_refused_at_once(quiet: Sea, message_id: int) -> None:
    assert answered(quiet.order(REQUEST, message_id), REQUEST, UNSUPPORTED) == []
    assert not named(quiet.run(0.5), "COMMAND_ACK")


@pytest.mark.parametrize("message_id", [math.nan, math.inf, -math.inf, -1.0, 0.5, 65536.0, 1e30])
def test_an_impossible_message_id_is_denied(quiet: Sea, message_id: float) -> None:
    for command in (REQUEST, GET_INTERVAL):
        assert answered(quiet.order(command, message_id), command, DENIED) == []


@pytest.mark.parametrize("message_id", NEEDS_OWN_STATE)
def test_a_state_requested_before_a_position_is_known_is_rejected_at_once(message_id: int) -> None:
    sea = Sea(QUIET)
    sea.own.on = False
    sea.run(1.15)
    assert answered(sea.order(REQUEST, message_id), REQUEST, TEMPORARILY_REJECTED) == []
    sea.own.on = True
    sea.run(0.55)
    (told,) = answered(sea.order(REQUEST, message_id), REQUEST, ACCEPTED)
    assert told.get_type() == kind_of(message_id)


@pytest.mark.parametrize("message_id", [49, 33, 144, 242])
def test_a_boat_without_an_origin_has_no_place_on_the_globe(message_id: int) -> None:
    sea = Sea(QUIET)
    sea.own.origin_on = False
    sea.run(1.15)
    assert answered(sea.order(REQUEST, message_id), REQUEST, TEMPORARILY_REJECTED) == []
    assert answered(sea.order(REQUEST, 32.0), REQUEST, ACCEPTED)


def test_a_request_for_the_slot_is_temporarily_rejected_without_a_leader() -> None:
    sea = Sea(QUIET)
    sea.leader.on = False
    sea.run(1.15)
    for message_id in (62, 85):
        assert answered(sea.order(REQUEST, message_id), REQUEST, TEMPORARILY_REJECTED) == []
    sea.leader.on = True
    sea.run(1.5)
    for message_id in (62, 85):
        assert len(answered(sea.order(REQUEST, message_id), REQUEST, ACCEPTED)) == 1


def test_the_answer_goes_only_where_the_question_came_from() -> None:
    sea = Sea(QUIET, links=3)
    sea.run(1.15)
    tick = sea.order(REQUEST, 148.0, link=1)
    assert len(answered(tick, REQUEST, ACCEPTED, link=1)) == 1
    assert not tick.messages(0) and not tick.messages(2)


def test_several_questions_at_once_are_answered_one_by_one(quiet: Sea) -> None:
    asked = [148, 9999, 436, 32]
    quiet.say(*[command_long(REQUEST, float(k)) for k in asked])
    tick = quiet.step()
    kinds = [m.get_type() for m in tick.messages()]
    assert kinds == ["COMMAND_ACK", kind_of(148), "COMMAND_ACK"] + [
        kind for k in (436, 32) for kind in ("COMMAND_ACK", kind_of(k))
    ]
    assert [result for _, result in acks(tick)] == [ACCEPTED, UNSUPPORTED, ACCEPTED, ACCEPTED]


def test_a_station_that_may_not_command_may_still_request_messages() -> None:
    sea = Sea({"MAV_GCS_SYSID": 250} | QUIET)
    sea.run(1.15)
    for order in (
        (REQUEST, 148.0),
        (GET_INTERVAL, 30.0),
        (VERSION, 1.0),
        (CAPABILITIES, 1.0),
    ):
        assert len(answered(sea.order(*order), order[0], ACCEPTED)) == 1
    assert acks(sea.order(511, 30.0, 1e5)) == [(511, DENIED)]


@pytest.mark.parametrize(
    ("command", "message_id"), [(VERSION, 300), (CAPABILITIES, 148)], ids=["519", "520"]
)
@pytest.mark.parametrize("unused", [math.nan, 0.0], ids=["NaN", "0"])
def test_the_old_questions_are_answered_too(
    quiet: Sea, command: int, message_id: int, unused: float
) -> None:
    (told,) = answered(quiet.order(command, 1.0, *[unused] * 6), command, ACCEPTED)
    assert told.get_type() == kind_of(message_id)


def test_each_mode_is_described_once(quiet: Sea) -> None:
    told = answered(quiet.order(REQUEST, MODES, 0.0), REQUEST, ACCEPTED)
    assert [(m.mode_index, m.custom_mode, m.mode_name) for m in told] == [
        (1, 0, "MANUAL"),
        (2, 4, "HOLD"),
        (3, 5, "LOITER"),
        (4, 6, "FOLLOW"),
        (5, 10, "AUTO"),
        (6, 11, "RTL"),
        (7, 15, "GUIDED"),
    ]
    for m in told:
        assert m.number_modes == 7
        assert m.standard_mode == {10: 6, 11: 5}.get(m.custom_mode, 0)  # MISSION, SAFE_RECOVERY
        assert m.properties == (4 if m.custom_mode > 4 else 0)  # AUTO_MODE


@pytest.mark.parametrize("index", [1, 2, 3, 4, 5, 6, 7])
def test_a_mode_is_described_by_its_index(quiet: Sea, index: int) -> None:
    (mode,) = answered(quiet.order(REQUEST, MODES, float(index)), REQUEST, ACCEPTED)
    assert (mode.mode_index, mode.custom_mode) == (index, (0, 4, 5, 6, 10, 11, 15)[index - 1])


@pytest.mark.parametrize("index", [8.0, 255.0, 257.0, 65535.0])
def test_an_unknown_mode_index_is_refused_at_once(quiet: Sea, index: float) -> None:
    assert answered(quiet.order(REQUEST, MODES, index), REQUEST, UNSUPPORTED) == []


@pytest.mark.parametrize("index", [-1.0, 1.5, math.inf, 1e30])
def test_an_index_that_makes_no_sense_is_denied(quiet: Sea, index: float) -> None:
    for message_id in (MODES, INTERVAL):
        assert answered(quiet.order(REQUEST, message_id, index), REQUEST, DENIED) == []


DEFAULTS_US = {
    0: 1_000_000,
    1: 1_000_000,
    2: 1_000_000,
    30: 100_000,
    32: 100_000,
    33: 500_000,
    42: 1_000_000,
    49: 1_000_000,
    62: 1_000_000,
    85: 1_000_000,
    144: -1,
    147: 5_000_000,
    242: 2_000_000,
    245: -1,
    251: 1_000_000,
    290: -1,
    291: -1,
    436: -1,
}


@pytest.mark.parametrize(("message_id", "interval_us"), list(DEFAULTS_US.items()))
def test_a_boat_reports_each_messages_interval(sea: Sea, message_id: int, interval_us: int) -> None:
    sea.run(1.15)
    for order in ((GET_INTERVAL, message_id), (REQUEST, INTERVAL, message_id)):
        (told,) = answered(sea.order(*order), order[0], ACCEPTED)
        assert told.get_type() == "MESSAGE_INTERVAL"
        assert (told.message_id, told.interval_us) == (message_id, interval_us)


@pytest.mark.parametrize("message_id", [25, 73, 148, ODOMETRY, 435, 9999])
def test_a_message_that_is_never_sent_unasked_has_no_interval(sea: Sea, message_id: int) -> None:
    sea.run(1.15)
    (told,) = answered(sea.order(GET_INTERVAL, message_id), GET_INTERVAL, ACCEPTED)
    assert (told.message_id, told.interval_us) == (message_id, 0)


def test_odometry_comes_once_and_never_by_itself(sea: Sea) -> None:
    """An autopilot would take it for its own external vision."""
    sea.run(1.15)
    (told,) = answered(sea.order(REQUEST, ODOMETRY), REQUEST, ACCEPTED)
    now = sea.own.truth(sea.ticks[-1].now_us)
    assert (told.frame_id, told.child_frame_id) == (1, 12)
    assert told.estimator_type in (5, 8)
    assert (told.x, told.y, told.z) == pytest.approx((now.north, now.east, 0.0), abs=0.01)
    assert math.isnan(told.pose_covariance[0]) and math.isnan(told.velocity_covariance[0])
    assert 2 * math.atan2(told.q[3], told.q[0]) == pytest.approx(now.psi, abs=0.001)
    assert acks(sea.order(511, ODOMETRY, 1e5)) == [(511, UNSUPPORTED)]
    assert not named(sea.run(3.0), "ODOMETRY")


def test_odometry_tells_the_velocity_along_the_boats_own_axes() -> None:
    sea = Sea(own=Course(3.0, -4.0, 2.5, 0.6, 0.1, 0.05))
    sea.run(5.05)
    (told,) = answered(sea.order(REQUEST, ODOMETRY), REQUEST, ACCEPTED)
    truth = sea.own.truth(told.time_usec)
    assert (told.vx, told.vy, told.yawspeed) == pytest.approx((0.6, 0.1, 0.05), abs=0.02)
    assert math.hypot(told.x - truth.north, told.y - truth.east) < 0.01
    assert 2 * math.atan2(told.q[3], told.q[0]) == pytest.approx(truth.psi, abs=0.01)


def test_autopilot_version_lists_exactly_the_boats_capabilities(quiet: Sea) -> None:
    (told,) = answered(quiet.order(REQUEST, 148.0), REQUEST, ACCEPTED)
    assert (
        told.capabilities
        == MAVLINK2 | MISSION_INT | COMMAND_INT | PARAM_BYTEWISE | FTP | 16384 | 32768
    )
    major, minor = (int(part) for part in flotilla.__version__.split(".")[:2])
    assert told.flight_sw_version >> 16 == major << 8 | minor
    revision = bytes(told.flight_custom_version).rstrip(b"\0").decode("ascii")
    assert re.fullmatch(r"[0-9a-f]{8}|unknown", revision)


def unique_id(system: int, asked_after_s: float) -> int:
    sea = Sea({"MAV_SYSID": system} | QUIET)
    sea.run(asked_after_s)
    sea.say(command_long(CAPABILITIES, 1.0, target=(system, 1)))
    (told,) = sea.step().named("AUTOPILOT_VERSION")
    return int(told.uid)


def test_every_boat_has_a_unique_id_of_its_own() -> None:
    assert len({0, *(unique_id(system, 1.1) for system in (2, 3, 4, 254))}) == 5


@pytest.mark.parametrize("asked_after_s", [0.0, 0.01, 3.0])
def test_a_boats_unique_id_is_the_same_whenever_it_is_asked_for(asked_after_s: float) -> None:
    assert unique_id(BOAT, asked_after_s) == unique_id(BOAT, 1.1)


def test_the_basic_component_information_names_the_boat(quiet: Sea) -> None:
    (told,) = answered(quiet.order(REQUEST, 396.0), REQUEST, ACCEPTED)
    (version,) = answered(quiet.order(REQUEST, 148.0), REQUEST, ACCEPTED)
    assert told.capabilities == version.capabilities
    assert told.vendor_name and told.model_name
    revision = bytes(version.flight_custom_version).rstrip(b"\0").decode("ascii")
    assert revision in told.software_version
    assert told.time_boot_ms == pytest.approx(quiet.now_us / 1000, abs=50)


def test_the_protocol_is_version_two(quiet: Sea) -> None:
    (told,) = answered(quiet.order(VERSION, 1.0), VERSION, ACCEPTED)
    assert (told.version, told.min_version, told.max_version) == (200, 100, 200)


def test_the_metadata_is_where_its_checksum_says(quiet: Sea) -> None:
    (told,) = answered(quiet.order(REQUEST, 397.0), REQUEST, ACCEPTED)
    assert told.uri == "mftp:///general.json"
    content = flotilla.metadata()["general.json"]
    assert told.file_crc == zlib.crc32(content, 0xFFFFFFFF) ^ 0xFFFFFFFF


def test_the_origin_asked_for_is_the_navigation_units(quiet: Sea) -> None:
    (told,) = answered(quiet.order(REQUEST, 49.0), REQUEST, ACCEPTED)
    assert (told.latitude, told.longitude, told.altitude) == ORIGIN


def test_a_heartbeat_asked_for_is_the_boats_heartbeat(quiet: Sea) -> None:
    (told,) = answered(quiet.order(REQUEST, 0.0), REQUEST, ACCEPTED)
    (regular,) = named(quiet.run(1.0), "HEARTBEAT")
    assert told.to_dict() == regular.to_dict()


def test_a_question_to_another_is_not_answered(quiet: Sea) -> None:
    for target in ((3, 1), (BOAT, 2)):
        quiet.say(command_long(REQUEST, 148.0, target=target))
        assert not quiet.step().messages()


def test_each_ack_names_its_requester(quiet: Sea) -> None:
    """Two systems ask in the same tick."""
    for sender in ((GCS, GCS_COMPONENT), (245, 191)):
        quiet.say(command_long(REQUEST, 148.0), sender=Station(*sender))
    found = quiet.step().named("COMMAND_ACK")
    assert [(m.target_system, m.target_component) for m in found] == [
        (GCS, GCS_COMPONENT),
        (245, 191),
    ]
