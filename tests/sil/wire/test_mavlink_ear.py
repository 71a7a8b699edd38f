# SPDX-License-Identifier: MIT
"""Messages parsed from clean and damaged bytes, compared with pymavlink."""

import random
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pymavlink.dialects.v20 import common as mavlink

from sil.wire import mavlink_messages as messages
from sil.wire.mavlink_ear import Ear
from tests.dialect import dialect
from tests.sil.view.feed import BEAT, attitude, local, origin, slot, value
from tests.target.stations import Station

SAID = [
    BEAT,
    attitude(1.0),
    local(1.0, 2.0),
    origin(1, 2, 3),
    slot(0.0, 0.0),
    value("E_X", 1.5),
    mavlink.MAVLink_statustext_message(4, b"no recent navigation data"),
    mavlink.MAVLink_timesync_message(1, 2),
    mavlink.MAVLink_sys_status_message(1, 2, 3, 0, 24000, -1, -1, 0, 0, 0, 0, 0, 0),
]


def numbers(ear: Ear, *chunks: bytes) -> list[int]:
    return [message.number for chunk in chunks for message in ear.hear(chunk)]


@pytest.mark.parametrize("number", messages.LAYOUTS)
def test_every_message_that_is_read_lies_on_the_wire_as_our_dialect_has_it(number: int) -> None:
    kind = dialect().mavlink_map[number]
    ours = messages.LAYOUTS[number]
    assert messages.SEEDS[number] == kind.crc_extra
    assert (ours.format, ours.size) == (kind.unpacker.format, kind.unpacker.size)


@pytest.mark.parametrize("version1", [False, True])
@pytest.mark.parametrize("stream", [False, True])
def test_fields_are_those_that_were_sent(stream: bool, version1: bool) -> None:
    ear = Ear(stream=stream)
    wire = Station(7, 1).pack(attitude(0.5, 1234), BEAT, version1=version1)
    first, second = ear.hear(wire)
    assert first[:3] == (messages.ATTITUDE, 7, 1)
    assert first.fields is not None and first.fields[:4] == (1234, 0.0, 0.0, 0.5)
    assert second.fields == (6, 11, 0, 137, 4, 3)
    assert (ear.heard, ear.damaged) == (len(wire), 0)


@settings(deadline=None)
@given(st.lists(st.sampled_from(SAID), max_size=8), st.data())
def test_a_stream_may_be_cut_anywhere(said: list[Any], data: st.DataObject) -> None:
    wire = Station(1).pack(*said)
    cuts = sorted(data.draw(st.lists(st.integers(0, len(wire)), max_size=6)))
    chunks = [wire[a:b] for a, b in zip([0, *cuts], [*cuts, len(wire)], strict=True)]
    ear = Ear(stream=True)
    assert numbers(ear, *chunks) == [m.get_msgId() for m in said]
    assert ear.damaged == 0


@settings(deadline=None)
@given(st.lists(st.tuples(st.binary(max_size=30), st.sampled_from(SAID)), max_size=6), st.binary())
def test_garbage_hides_no_message_of_a_datagram_behind_it(
    parts: list[tuple[bytes, Any]], last: bytes
) -> None:
    station, wire = Station(1), b""
    for garbage, message in parts:
        wire += garbage.replace(b"\xfd", b"").replace(b"\xfe", b"") + station.pack(message)
    wire += last.replace(b"\xfd", b"").replace(b"\xfe", b"")
    ear = Ear(stream=False)
    assert numbers(ear, wire) == [message.get_msgId() for _, message in parts]
    own = Station(1)
    assert ear.damaged == len(wire) - sum(len(own.pack(message)) for _, message in parts)


def test_every_message_that_pymavlink_finds_in_a_noisy_stream_is_found() -> None:
    rng, station, wire = random.Random(5), Station(3), bytearray()
    for _ in range(400):
        wire += station.pack(rng.choice(SAID))
    for _ in range(60):
        wire[rng.randrange(len(wire))] ^= 1 << rng.randrange(8)
    parser = dialect().MAVLink(None)
    parser.robust_parsing = True
    parsed = parser.parse_buffer(bytes(wire)) or []
    found = [m for m in parsed if m.get_type() in {each.get_type() for each in SAID}]
    ear = Ear(stream=True)
    heard = [m.number for m in ear.hear(bytes(wire)) if m.fields is not None]
    assert len(heard) >= len(found) > 300
    assert 0 < ear.damaged < 60 * 60


def test_random_bytes_are_no_vessels_messages() -> None:
    rng, ear = random.Random(11), Ear(stream=True)
    said = [m for _ in range(200) for m in ear.hear(rng.randbytes(1000))]
    assert not [m for m in said if m.fields]
    assert ear.damaged > 0.99 * ear.heard - 600


def test_a_message_that_was_cut_off_by_a_lost_connection_ends_none_of_the_next() -> None:
    ear, wire = Ear(stream=True), Station(1).pack(attitude(1.0))
    assert numbers(ear, wire[:20]) == []
    ear.forget()
    assert numbers(ear, wire) == [messages.ATTITUDE] and ear.damaged == 20


def test_signed_messages_are_read() -> None:
    station = Station(1)
    station.encoder.signing.secret_key = bytes(32)
    station.encoder.signing.sign_outgoing = True
    station.encoder.signing.timestamp = 1
    wire = station.pack(attitude(1.0), BEAT)
    ear = Ear(stream=False)
    assert numbers(ear, wire) == [messages.ATTITUDE, messages.HEARTBEAT] and ear.damaged == 0


def test_an_unknown_message_is_reported_as_unchecked() -> None:
    wire = dialect().MAVLink_current_mode_message(0, 6, 6).pack(dialect().MAVLink(None, 9, 1))
    assert [m[:4] for m in Ear(stream=False).hear(bytes(wire))] == [(436, 9, 1, None)]
