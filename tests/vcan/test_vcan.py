# SPDX-License-Identifier: MIT
"""Properties of vcan on which the other tests here rely."""

import errno
import socket
import struct

import can
import pytest

from tests.vcan.conftest import OpenRaw, Shape

FRAME = struct.Struct("=IB3x8s")
CAN_ERR_BUSOFF = 0x40


def frame(can_id: int, data: bytes = b"") -> bytes:
    return FRAME.pack(can_id, len(data), data)


def test_python_can_carries_a_raw_command_from_boat_to_esc() -> None:
    command = can.Message(arbitration_id=0x0704060A, data=bytes.fromhex("FF7C0200C1"))
    with (
        can.Bus(interface="socketcan", channel="vcan0") as boat,
        can.Bus(interface="socketcan", channel="vcan0") as esc,
    ):
        boat.send(command)
        heard = esc.recv(5.0)
        assert heard is not None
        assert heard.equals(
            command, timestamp_delta=None, check_channel=False, check_direction=False
        )


def test_four_boats_have_four_buses_that_do_not_hear_each_other(raw: OpenRaw) -> None:
    boats = [raw(f"vcan{i}") for i in range(4)]
    escs = [raw(f"vcan{i}") for i in range(4)]
    for i, boat in enumerate(boats):
        boat.send(frame(i))
    assert [FRAME.unpack(esc.recv(16))[0] for esc in escs] == [0, 1, 2, 3]


def test_an_error_frame_reaches_only_who_asked_for_errors(raw: OpenRaw) -> None:
    controller, deaf = raw("vcan0"), raw("vcan0")
    listening = raw("vcan0", error_mask=socket.CAN_ERR_MASK)
    bus_off = frame(socket.CAN_ERR_FLAG | CAN_ERR_BUSOFF, bytes(8))
    controller.send(bus_off)
    controller.send(frame(1))
    assert listening.recv(16) == bus_off
    assert deaf.recv(16) == frame(1)


def test_a_bus_can_lose_frames(raw: OpenRaw, shape: Shape) -> None:
    boat, esc = raw("vcan1"), raw("vcan1")
    shape("vcan1", "netem", "loss", "100%")
    boat.send(frame(1))
    shape("vcan1")
    boat.send(frame(2))
    assert esc.recv(16) == frame(2)


def test_a_bus_can_repeat_frames(raw: OpenRaw, shape: Shape) -> None:
    boat, esc = raw("vcan1"), raw("vcan1")
    shape("vcan1", "netem", "duplicate", "100%")
    boat.send(frame(1))
    assert [esc.recv(16), esc.recv(16)] == [frame(1)] * 2


def test_a_full_queue_of_a_slow_bus_refuses_frames(raw: OpenRaw, shape: Shape) -> None:
    boat = raw("vcan1")
    shape("vcan1", "tbf", "rate", "8kbit", "burst", "64", "limit", "160")
    with pytest.raises(OSError, match="No buffer space") as refused:  # noqa: PT012
        for i in range(100):
            boat.send(frame(i))
    assert refused.value.errno == errno.ENOBUFS
