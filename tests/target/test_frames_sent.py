# SPDX-License-Identifier: MIT
"""The bytes that a boat sends, as pymavlink reads them: framing, ids, sequence numbers."""

from __future__ import annotations

from typing import Any

import pytest
from pymavlink.dialects.v20 import common as mavlink

from tests.dialect import dialect
from tests.target.sea import Sea, messages
from tests.target.stations import BOAT, NAVIGATION, Station, decode, heartbeat

KINDS = {
    "HEARTBEAT",
    "SYS_STATUS",
    "SYSTEM_TIME",
    "TIMESYNC",
    "ATTITUDE",
    "LOCAL_POSITION_NED",
    "FORMATION_REFERENCE",
    "GPS_GLOBAL_ORIGIN",
    "GLOBAL_POSITION_INT",
    "HOME_POSITION",
    "VFR_HUD",
    "GPS_RAW_INT",
    "NAV_CONTROLLER_OUTPUT",
    "POSITION_TARGET_LOCAL_NED",
    "BATTERY_STATUS",
    "NAMED_VALUE_FLOAT",
    "COMMAND_ACK",
    "STATUSTEXT",
}


@pytest.fixture(scope="module")
def said(voyage: Sea) -> list[list[Any]]:
    heard = [messages(voyage.ticks, link) for link in (0, 1)]
    assert min(map(len, heard)) > 5000
    return heard


def test_pymavlink_finds_no_bad_byte_in_all_that_a_boat_sends(said: list[list[Any]]) -> None:
    for link in said:
        assert not [
            m for m in link if m.get_type() == "BAD_DATA" or m.get_type().startswith("UNKNOWN")
        ]


def test_a_long_session_shows_every_kind_of_message_and_no_other(said: list[list[Any]]) -> None:
    assert {m.get_type() for m in said[0]} == KINDS
    assert {m.get_type() for m in said[1]} == KINDS - {"COMMAND_ACK"}


def test_a_boat_never_sends_odometry(said: list[list[Any]]) -> None:
    assert all(m.get_type() != "ODOMETRY" for link in said for m in link)


def test_every_frame_is_mavlink_2_unsigned_and_with_the_boats_ids(said: list[list[Any]]) -> None:
    for link in said:
        for m in link:
            assert m.get_msgbuf()[0] == 0xFD and m.get_msgbuf()[2] == 0
            assert (m.get_srcSystem(), m.get_srcComponent()) == (BOAT, 1)


def test_each_link_counts_its_own_frames_without_a_gap(said: list[list[Any]]) -> None:
    for link in said:
        numbers = [m.get_seq() for m in link]
        assert numbers == [(numbers[0] + k) % 256 for k in range(len(numbers))]
    assert len(said[0]) != len(said[1])


def test_pymavlink_packs_the_same_bytes_from_what_it_decoded(said: list[list[Any]]) -> None:
    for m in said[0]:
        if m.get_type() == "TIMESYNC":
            continue  # the wheel's TIMESYNC has no target fields
        again = dialect().MAVLink(None, BOAT, 1)
        again.seq = m.get_seq()
        assert m.pack(again) == bytes(m.get_msgbuf())


def test_a_chunk_holds_whole_frames_for_one_link_and_comes_once_a_tick(voyage: Sea) -> None:
    chunks = 0
    for tick in voyage.ticks:
        links = [link for link, _ in tick.mavlink]
        assert len(links) == len(set(links)) and set(links) <= {0, 1}
        for _, data in tick.mavlink:
            chunks += 1
            start = 0
            while start < len(data):
                assert data[start] == 0xFD
                start += 12 + data[start + 1]
            assert start == len(data)
    assert chunks > 5000


def test_own_ids_are_the_parameters() -> None:
    sea = Sea({"MAV_SYSID": 42, "MAV_COMPID": 7})
    sea.own.station = Station(42, NAVIGATION)
    sea.run(1.0)
    assert {(m.get_srcSystem(), m.get_srcComponent()) for m in messages(sea.ticks)} == {(42, 7)}
    assert sea.condition("own_fresh")


def test_decoding_helpers_do_see_bad_data() -> None:
    """Checks the oracle: it does not silently accept a damaged frame."""
    wire = bytearray(Station(1).pack(heartbeat()))
    wire[12] ^= 1
    assert [m.get_type() for m in decode([bytes(wire)])] == ["BAD_DATA"]


def test_stock_pymavlink_knows_all_unrequested_messages_but_formation_reference(
    said: list[list[Any]],
) -> None:
    """It counts unknown messages as lost."""
    known = mavlink.mavlink_map
    for link in said:
        unknown = {m.get_type() for m in link if m.get_msgId() not in known}
        assert unknown == {"FORMATION_REFERENCE"}
