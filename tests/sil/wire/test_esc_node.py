# SPDX-License-Identifier: MIT
"""An ESC's response to the boat's commands, and its own messages."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sil.wire.dronecan import (
    ARMING_STATUS,
    ESC_STATUS,
    GET_NODE_INFO,
    NODE_STATUS,
    RAW_COMMAND,
    ArmingStatus,
    EscStatus,
    NodeInfo,
    NodeStatus,
    RawCommand,
)
from sil.wire.dronecan_transfer import (
    FrameId,
    Kind,
    Publisher,
    Receiver,
    message_subject,
    service_subject,
)
from sil.wire.esc_node import EscNode

BOAT, ESC = 20, 21
OFFSET_US = 3 * 3600 * 1_000_000 + 7


class Boat:
    """The boat's side of the bus, as needed here."""

    def __init__(self, esc: EscNode) -> None:
        self.esc = esc
        self.raw = Publisher(RAW_COMMAND, 7, BOAT)
        self.arming = Publisher(ARMING_STATUS, 24, BOAT)

    def command(self, now_us: int, *cmd: int) -> None:
        for can_id, data in self.raw.frames(RawCommand(cmd).encode()):
            self.esc.on_can(can_id, data, now_us)

    def arm(self, now_us: int, status: int = 255) -> None:
        for can_id, data in self.arming.frames(ArmingStatus(status).encode()):
            self.esc.on_can(can_id, data, now_us)


def ready(index: int = 0) -> Boat:
    """A boat whose ESC has been armed and has seen zero, at time 0."""
    boat = Boat(EscNode(ESC, index))
    boat.arm(0)
    boat.command(0, 0, 0, 0, 0, 0)
    return boat


def test_an_armed_esc_follows_its_own_slot() -> None:
    port, stbd = ready(0), ready(1)
    for boat in (port, stbd):
        boat.command(10, 8191, -4096)
    assert port.esc.command(10) == 1.0
    assert stbd.esc.command(10) == pytest.approx(-4096 / 8191)


def test_full_reverse_is_minus_one() -> None:
    boat = ready()
    boat.command(10, -8192)
    assert boat.esc.command(10) == -1.0


def test_a_slot_beyond_the_array_is_left_alone() -> None:
    boat = ready(4)
    boat.command(10, 100, 100)
    assert boat.esc.command(10) == 0.0
    boat.command(20, 1, 2, 3, 4, 8191)
    assert boat.esc.command(20) == 1.0


def test_before_arming_status_255_the_motor_gets_zero() -> None:
    boat = Boat(EscNode(ESC, 0))
    boat.command(0, 0)
    boat.command(10, 500)
    assert boat.esc.command(10) == 0.0
    boat.arm(20, 254)
    assert boat.esc.command(20) == 0.0
    boat.arm(30)
    assert boat.esc.command(30) > 0.0


def test_disarming_stops_the_motor_at_once() -> None:
    boat = ready()
    boat.command(10, 500)
    boat.arm(20, 0)
    assert boat.esc.command(20) == 0.0


def test_arming_status_silent_for_more_than_half_a_second_stops_the_motor() -> None:
    boat = ready()
    boat.command(500_000, 500)
    assert boat.esc.command(500_000) > 0.0
    assert boat.esc.command(500_001) == 0.0


def test_raw_command_silent_for_more_than_250_ms_stops_the_motor_though_arming_goes_on() -> None:
    boat = ready()
    boat.command(10, 500)
    boat.arm(240_000)
    assert boat.esc.command(250_010) > 0.0
    assert boat.esc.command(250_011) == 0.0


def test_a_rebooted_esc_does_not_turn_before_it_receives_zero() -> None:
    boat = Boat(EscNode(ESC, 0))
    boat.arm(0)
    boat.command(0, 500)
    assert boat.esc.command(0) == 0.0
    boat.command(10, 0)
    boat.command(20, 500)
    assert boat.esc.command(20) > 0.0


def test_an_esc_that_needs_no_arming_follows_without_it() -> None:
    boat = Boat(EscNode(ESC, 0, require_arming=False))
    boat.command(0, 0)
    boat.command(10, 8191)
    assert boat.esc.command(10) == 1.0


def run(esc: EscNode, seconds: int, rpm: float = 0.0) -> list[tuple[int, int, bytes]]:
    return [
        (t, can_id, data)
        for t in range(OFFSET_US, OFFSET_US + seconds * 1_000_000, 10_000)
        for can_id, data in esc.tick(t, rpm, 24.5, 12.25)
    ]


def test_status_messages_keep_their_rates_with_a_clock_offset_of_three_hours() -> None:
    receiver = Receiver(
        {message_subject(NODE_STATUS): NODE_STATUS, message_subject(ESC_STATUS): ESC_STATUS}
    )
    times: dict[int, list[int]] = {NODE_STATUS.type_id: [], ESC_STATUS.type_id: []}
    for t, can_id, data in run(EscNode(ESC, 1), 10, rpm=-1234.4):
        payload = receiver.on_frame(can_id, data, t)
        if payload is None:
            continue
        frame = FrameId.unpack(can_id)
        times[frame.type_id].append(t - OFFSET_US)
        assert frame.source == ESC
        if frame.type_id == NODE_STATUS.type_id:
            assert NodeStatus.decode(payload) == NodeStatus((t - OFFSET_US) // 1_000_000)
        else:
            status = EscStatus.decode(payload)
            assert (status.voltage_V, status.current_A, status.rpm) == (24.5, 12.25, -1234)
            assert math.isnan(status.temperature_K) and status.esc_index == 1
    assert times[NODE_STATUS.type_id] == list(range(0, 10_000_000, 1_000_000))
    assert times[ESC_STATUS.type_id] == list(range(0, 10_000_000, 40_000))
    assert not receiver.counters


def test_get_node_info_is_answered_to_the_requester_with_his_transfer_id() -> None:
    esc = EscNode(ESC, 0, name="org.example.esc")
    esc.tick(0, 0.0, 0.0, 0.0)
    asked = FrameId(Kind.REQUEST, 24, GET_NODE_INFO.type_id, BOAT, ESC)
    esc.on_can(asked.pack(), b"\xc9", 5)
    other = FrameId(Kind.REQUEST, 24, GET_NODE_INFO.type_id, BOAT, ESC + 1)
    esc.on_can(other.pack(), b"\xc9", 5)
    frames = esc.tick(10_000, 0.0, 0.0, 0.0)
    receiver = Receiver({service_subject(GET_NODE_INFO, BOAT, request=False): GET_NODE_INFO})
    payloads = [p for i, d in frames if (p := receiver.on_frame(i, d, 0)) is not None]
    assert len(payloads) == 1
    assert NodeInfo.decode(payloads[0]).name == b"org.example.esc"
    assert {d[-1] & 0x1F for _, d in frames} == {9}
    assert FrameId.unpack(frames[0][0]) == FrameId(Kind.RESPONSE, 24, 1, ESC, BOAT)
    assert esc.tick(20_000, 0.0, 0.0, 0.0) == []


@given(
    st.lists(
        st.tuples(
            st.sampled_from(
                [0x0704060A, 0x18044C0A, 0x18019594, 0x10040A15, 0x07040600, 0xFF04060A]
            ),
            st.binary(max_size=9),
        )
    )
)
def test_random_frames_never_raise_and_never_exceed_full_power(
    frames: list[tuple[int, bytes]],
) -> None:
    esc = EscNode(ESC, 0)
    for k, (can_id, data) in enumerate(frames):
        esc.on_can(can_id, data, 1000 * k)
        esc.tick(1000 * k, 0.0, 0.0, 0.0)
        assert -1.0 <= esc.command(1000 * k) <= 1.0


def test_a_payload_of_the_wrong_length_is_counted_and_ignored() -> None:
    boat = ready()
    boat.esc.on_can(0x18044C0B, b"\x00\x00\xc0", 10)
    boat.command(10, 500)
    assert boat.esc.counters["malformed"] == 1
    assert boat.esc.command(10) > 0.0
