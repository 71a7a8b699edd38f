# SPDX-License-Identifier: MIT
"""The generator of MAVLink messages; test_oracle.py checks every byte of every message."""

import pytest

from firmware.link.mavlink.generate import dialect, listed, messages_hpp


def test_a_new_message_is_one_line() -> None:
    (message,) = listed("RADIO_STATUS read\n", dialect())
    assert [(m.type, m.name, m.places) for m in message.members] == [
        ("std::uint8_t", "rssi", [(4, "rssi")]),
        ("std::uint8_t", "remrssi", [(5, "remrssi")]),
        ("std::uint8_t", "txbuf", [(6, "txbuf")]),
        ("std::uint8_t", "noise", [(7, "noise")]),
        ("std::uint8_t", "remnoise", [(8, "remnoise")]),
        ("std::uint16_t", "rxerrors", [(0, "rxerrors")]),
        ("std::uint16_t", "fixed", [(2, "fixed")]),
    ]
    assert "struct RadioStatus {" in messages_hpp([message])


def test_neighbours_make_an_array_and_a_target_an_address() -> None:
    (message,) = listed("COMMAND_INT read param=param1,param2 target\n", dialect())
    assert [(m.type, m.places) for m in message.members] == [
        ("std::array<float, 2>", [(0, "param")]),
        ("Address", [(30, "target.system"), (31, "target.component")]),
    ]


def test_extensions_are_zero_unless_they_are_given() -> None:
    (message,) = listed("STATUSTEXT send\n", dialect())
    assert [m.name for m in message.members if m.extension] == ["id", "chunk_seq"]
    assert "  std::uint16_t id{};\n" in messages_hpp([message])


@pytest.mark.parametrize(
    "line",
    [
        "HEARTBEET read",
        "HEARTBEAT heard",
        "HEARTBEAT read mode",
        "HEARTBEAT read mode=3",
        "COMMAND_INT read param=param1,param3",
        "SYS_STATUS send both=load,current_battery",
    ],
)
def test_a_wrong_line_stops_the_build(line: str) -> None:
    with pytest.raises(ValueError, match=line.split(maxsplit=1)[0]):
        listed(line, dialect())
