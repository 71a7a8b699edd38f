# SPDX-License-Identifier: MIT
"""Our codec against captured bytes, damaged sequences and PyPI `dronecan`."""

import json
import math
import struct
from pathlib import Path
from typing import Any

import dronecan
import dronecan.transport
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sil.wire import dronecan as ours
from sil.wire.dronecan_transfer import (
    DataType,
    FrameId,
    Kind,
    Publisher,
    Receiver,
    message_subject,
    service_subject,
    split,
)

VECTORS = json.loads(
    (Path(__file__).parents[2] / "reference" / "dronecan_vectors.json").read_text()
)
TYPES = {
    (t["kind"] == "service", t["dtid"]): DataType(t["dtid"], int(t["signature"], 16))
    for t in VECTORS["types"].values()
}
DNA_LOG = next(c for c in VECTORS["generated"] if c["name"] == "spec DNA log")
TRANSFERS = [c for c in VECTORS["captured"] + VECTORS["generated"] if c is not DNA_LOG]

ACCEPTED = {message_subject(t): t for (service, _), t in TYPES.items() if not service} | {
    service_subject(t, node, request=request): t
    for (service, _), t in TYPES.items()
    if service
    for node in (10, 21)
    for request in (True, False)
}
F16 = st.floats(width=16, allow_nan=False, allow_infinity=False)
U32 = st.integers(0, 0xFFFFFFFF)


def name_of(case: dict[str, Any]) -> str:
    return f"{case['name']}#{case.get('transfer_id', '')}"


def receive(frames: list[tuple[int, bytes]], step_us: int = 100) -> list[bytes]:
    receiver = Receiver(ACCEPTED)
    answers = [receiver.on_frame(i, d, k * step_us) for k, (i, d) in enumerate(frames)]
    return [a for a in answers if a is not None]


def frames_of(case: dict[str, Any]) -> list[tuple[int, bytes]]:
    return [(int(case["can_id"], 16), bytes.fromhex(f)) for f in case["frames"]]


def type_of(can_id: int) -> DataType:
    frame = FrameId.unpack(can_id)
    return TYPES[frame.kind in (Kind.REQUEST, Kind.RESPONSE), frame.type_id]


@pytest.mark.parametrize("data_type", VECTORS["types"].values(), ids=VECTORS["types"])
def test_the_crc_seed_is_the_crc_of_the_signature(data_type: dict[str, Any]) -> None:
    seed = DataType(data_type["dtid"], int(data_type["signature"], 16)).crc_seed
    assert seed == int(data_type["crc_seed"], 16)


def test_our_types_have_the_numbers_and_signatures_of_the_vectors() -> None:
    assert {ours.RAW_COMMAND, ours.ESC_STATUS, ours.ARMING_STATUS, ours.NODE_STATUS} < {
        *TYPES.values()
    }
    assert TYPES[True, 1] == ours.GET_NODE_INFO


@pytest.mark.parametrize("case", TRANSFERS, ids=name_of)
def test_a_recorded_transfer_is_reassembled_and_split_again_byte_for_byte(
    case: dict[str, Any],
) -> None:
    frames, payload = frames_of(case), bytes.fromhex(case["payload"])
    assert receive(frames) == [payload]
    seed = type_of(frames[0][0]).crc_seed
    assert split(payload, case["transfer_id"], seed) == [data for _, data in frames]


@pytest.mark.parametrize("case", [c for c in TRANSFERS if "id" in c], ids=name_of)
def test_a_recorded_identifier_is_read_and_packed_again(case: dict[str, Any]) -> None:
    said = case["id"]
    kind = Kind.MESSAGE
    if said["service"]:
        kind = Kind.REQUEST if said["request"] else Kind.RESPONSE
    frame = FrameId(kind, said["priority"], said["type_id"], said["source"], said.get("dest", 0))
    assert FrameId.unpack(int(case["can_id"], 16)) == frame
    assert frame.pack() == int(case["can_id"], 16)


def number(value: Any) -> float:
    """The vectors write NaN and infinity as strings; float16 saturates infinity."""
    value = float(value)
    return float(struct.unpack("<e", struct.pack("<e", min(value, 65504.0)))[0])


@pytest.mark.parametrize("case", TRANSFERS, ids=name_of)
def test_a_recorded_message_has_its_values_and_encodes_to_the_same_bytes(
    case: dict[str, Any],
) -> None:
    payload = bytes.fromhex(case["payload"])
    values = case.get("values") or case.get("decoded_by_peer") or {}
    frame = FrameId.unpack(int(case["can_id"], 16))
    data_type = type_of(int(case["can_id"], 16))
    message: Any
    if data_type == ours.RAW_COMMAND:
        message = ours.RawCommand.decode(payload)
        assert message == ours.RawCommand(tuple(values["cmd"]))
    elif data_type == ours.ARMING_STATUS:
        message = ours.ArmingStatus.decode(payload)
        assert message.status == values["status"]
    elif data_type == ours.NODE_STATUS:
        message = ours.NodeStatus.decode(payload)
        if "uptime_sec" in values:
            assert message == ours.NodeStatus(*values.values())
        elif values:
            assert (message.uptime_s, message.health) == (values["uptime"], values["health"])
    elif data_type == ours.ESC_STATUS:
        message = ours.EscStatus.decode(payload)
        said = {k: v for k, v in values.items() if k not in ("kind", "src", "tid", "prio")}
        got = (message.voltage_V, message.current_A, message.temperature_K)
        expected = [number(said[k]) for k in ("voltage", "current", "temperature")]
        assert got == pytest.approx(expected, rel=0, abs=0, nan_ok=True)
        power = said.get("power_rating_pct", said.get("power"))
        assert (message.error_count, message.rpm, message.power_pct, message.esc_index) == (
            said["error_count"],
            said["rpm"],
            power,
            said["esc_index"],
        )
        if any(map(math.isnan, got)):
            # A NaN's payload bits are not specified.
            assert ours.EscStatus.decode(message.encode()).error_count == message.error_count
            return
    elif data_type == ours.GET_NODE_INFO and frame.kind is Kind.RESPONSE:
        message = ours.NodeInfo.decode(payload)
        assert message.name == values["name"].encode()
        assert [*message.software, message.vcs_commit] == values["sw"]
        assert [*message.hardware] == values["hw"] and list(message.unique_id) == values["uid"]
    else:
        return
    assert message.encode() == payload


@pytest.mark.parametrize("case", VECTORS["damaged"], ids=name_of)
def test_a_damaged_sequence_delivers_as_many_transfers_as_the_vectors_specify(
    case: dict[str, Any],
) -> None:
    assert len(receive(frames_of(case))) == case["transfers_delivered"]


def test_the_specifications_node_id_allocation_log_yields_the_unique_id() -> None:
    log = [line.split("#") for line in DNA_LOG["frames"]]
    payloads = receive([(int(i, 16), bytes.fromhex(d)) for i, d in log])
    unique_id = bytes.fromhex(DNA_LOG["values"]["unique_id"])
    assert payloads[0][0] == 1  # no preference, first part
    assert [p[1:] for p in payloads] == [
        unique_id[:6],
        unique_id[:6],
        unique_id[6:12],
        unique_id[:12],
        unique_id[12:],
        unique_id,
    ]
    assert payloads[-1][0] >> 1 == DNA_LOG["values"]["allocated"]


def esc_frames(transfer_id: int) -> list[tuple[int, bytes]]:
    payload = bytes(range(14))
    can_id = FrameId(Kind.MESSAGE, 16, 1034, 21).pack()
    return [(can_id, d) for d in split(payload, transfer_id, ours.ESC_STATUS.crc_seed)]


def test_a_repeated_transfer_is_delivered_once_but_again_after_two_seconds() -> None:
    receiver = Receiver(ACCEPTED)
    frames = esc_frames(7)

    def delivered(now_us: int) -> int:
        return sum(receiver.on_frame(i, d, now_us) is not None for i, d in frames)

    assert [delivered(0), delivered(2_000_000), delivered(2_000_001)] == [1, 0, 1]
    assert receiver.counters["unexpected"] == 3


def test_a_sender_that_rebooted_is_heard_at_once() -> None:
    assert len(receive(esc_frames(7) + esc_frames(8) + esc_frames(0) + esc_frames(1))) == 4


def test_a_new_transfer_ends_one_that_was_never_finished() -> None:
    assert len(receive(esc_frames(7)[:2] + esc_frames(8))) == 1


def test_a_transfer_cut_by_more_than_two_seconds_is_lost_and_the_next_one_is_heard() -> None:
    assert len(receive(esc_frames(7) + esc_frames(8), step_us=1_500_000)) == 0
    frames = esc_frames(7)[:2] + [(0, b"")] * 30 + esc_frames(7)[2:] + esc_frames(8)
    assert len(receive(frames, step_us=100_000)) == 1


def test_two_sources_of_one_type_are_kept_separate() -> None:
    other = [(i & ~0x7F | 22, d) for i, d in esc_frames(3)]
    mixed = [f for pair in zip(esc_frames(9), other, strict=True) for f in pair]
    assert len(receive(mixed)) == 2


def test_a_transfer_that_never_ends_is_dropped() -> None:
    receiver = Receiver(ACCEPTED)
    can_id = FrameId(Kind.MESSAGE, 16, 1034, 21).pack()
    receiver.on_frame(can_id, bytes(7) + b"\x80", 0)
    for k in range(100):
        receiver.on_frame(can_id, bytes(7) + bytes([0x20 if k % 2 == 0 else 0]), 0)
    assert receiver.counters["oversize"] == 1


def test_an_identifier_field_that_does_not_fit_is_refused() -> None:
    for bad in (
        FrameId(Kind.MESSAGE, 32, 1030, 10),
        FrameId(Kind.MESSAGE, 7, 1030, 0),
        FrameId(Kind.REQUEST, 7, 256, 10, 21),
        FrameId(Kind.ANONYMOUS, 7, 4, 0),
    ):
        with pytest.raises(ValueError, match="identifier"):
            bad.pack()


@given(
    st.sampled_from(sorted(ACCEPTED)),
    st.lists(st.tuples(U32, st.binary(max_size=9), st.integers(0, 3_000_000)), max_size=20),
)
def test_random_data_on_our_identifiers_deliver_only_whole_single_frames(
    subject: int, frames: list[tuple[int, bytes, int]]
) -> None:
    """Transfers of several frames need a checksum, which random data do not match."""
    receiver = Receiver(ACCEPTED)
    for bits, data, now_us in frames:
        can_id = subject | bits & 0xFF00007F  # any priority, any source, and bits beyond the 29
        payload = receiver.on_frame(can_id, data, now_us)
        if payload is not None:
            assert can_id < 1 << 29 and len(data) <= 8
            assert data[-1] >> 5 == 0b110 and payload == data[:-1]


@given(st.binary(max_size=400))
def test_a_random_payload_is_a_value_error_or_keeps_its_values_when_encoded(payload: bytes) -> None:
    for message in (
        ours.RawCommand,
        ours.ArmingStatus,
        ours.NodeStatus,
        ours.EscStatus,
        ours.NodeInfo,
    ):
        try:
            got = message.decode(payload)
        except ValueError:
            continue
        assert repr(message.decode(got.encode())) == repr(got)  # NaN differs from NaN


@given(
    st.sampled_from(["frame", "swap", "drop", "repeat"]),
    st.integers(0, 8),
    st.integers(8, 63),
    st.binary(min_size=46, max_size=60),
)
def test_a_damaged_node_info_is_never_delivered_changed(
    damage: str, at: int, bit: int, tail: bytes
) -> None:
    payload = ours.NodeInfo(ours.NodeStatus(1), tail[16:], tail[:16]).encode()
    can_id = FrameId(Kind.RESPONSE, 24, 1, 21, 10).pack()
    frames = split(payload, 3, ours.GET_NODE_INFO.crc_seed)
    at = min(at, len(frames) - 2)
    if damage == "frame":
        flipped = int.from_bytes(frames[at], "big") ^ 1 << bit
        frames[at] = flipped.to_bytes(8, "big")
    elif damage == "swap":
        frames[at], frames[at + 1] = frames[at + 1], frames[at]
    elif damage == "drop":
        del frames[at]
    else:
        frames.insert(at, frames[at])
    answers = receive([(can_id, f) for f in frames])
    assert answers == ([payload] if damage == "repeat" else [])


# ---- PyPI dronecan, both ways ----


def peer_frames(message: Any, source: int, transfer_id: int, **service: Any) -> list[Any]:
    frames: list[Any] = dronecan.transport.Transfer(
        transfer_id=transfer_id,
        source_node_id=source,
        payload=message,
        transfer_priority=16,
        **service,
    ).to_frames()
    return frames


def agree(data_type: DataType, payload: bytes, peer: Any, source: int, transfer_id: int) -> Any:
    """Assert that both codecs send equal bytes and receive the other's; the peer's message."""
    publisher = Publisher(data_type, 16, source)
    for _ in range(transfer_id):
        publisher.frames(b"")
    frames = publisher.frames(payload)
    theirs = peer_frames(peer, source, transfer_id)
    assert frames == [(f.message_id, bytes(f.bytes)) for f in theirs]
    assert receive(frames) == [payload]
    return peer_received(frames)


def peer_received(frames: list[tuple[int, bytes]]) -> Any:
    transfer = dronecan.transport.Transfer()
    transfer.from_frames([dronecan.transport.Frame(i, d) for i, d in frames])
    return transfer.payload


SOURCES = st.integers(1, 127)
IDS = st.integers(0, 31)


@given(st.lists(st.integers(-8192, 8191), min_size=1, max_size=20), SOURCES, IDS)
def test_any_raw_command_is_encoded_as_by_pypi_dronecan(
    cmd: list[int], source: int, transfer_id: int
) -> None:
    message = ours.RawCommand(tuple(cmd))
    peer = dronecan.uavcan.equipment.esc.RawCommand(cmd=cmd)
    got = agree(ours.RAW_COMMAND, message.encode(), peer, source, transfer_id)
    assert list(got.cmd) == cmd
    assert ours.RawCommand.decode(message.encode()) == message


@given(U32, F16, F16, F16, st.integers(-131072, 131071), st.integers(0, 127), st.integers(0, 31))
def test_any_esc_status_is_encoded_as_by_pypi_dronecan(
    errors: int, volt: float, amp: float, kelvin: float, rpm: int, power: int, index: int
) -> None:
    message = ours.EscStatus(errors, volt, amp, kelvin, rpm, power, index)
    peer = dronecan.uavcan.equipment.esc.Status(
        error_count=errors,
        voltage=volt,
        current=amp,
        temperature=kelvin,
        rpm=rpm,
        power_rating_pct=power,
        esc_index=index,
    )
    got = agree(ours.ESC_STATUS, message.encode(), peer, 21, 5)
    assert (got.error_count, got.voltage, got.current, got.temperature) == (
        errors,
        volt,
        amp,
        kelvin,
    )
    assert (got.rpm, got.power_rating_pct, got.esc_index) == (rpm, power, index)
    assert ours.EscStatus.decode(message.encode()) == message


@given(U32, st.integers(0, 3), st.integers(0, 7), st.integers(0, 7), st.integers(0, 0xFFFF))
def test_any_node_status_is_encoded_as_by_pypi_dronecan(
    uptime: int, health: int, mode: int, sub_mode: int, code: int
) -> None:
    message = ours.NodeStatus(uptime, health, mode, sub_mode, code)
    peer = dronecan.uavcan.protocol.NodeStatus(
        uptime_sec=uptime,
        health=health,
        mode=mode,
        sub_mode=sub_mode,
        vendor_specific_status_code=code,
    )
    got = agree(ours.NODE_STATUS, message.encode(), peer, 10, 31)
    assert (got.uptime_sec, got.health, got.mode) == (uptime, health, mode)
    assert ours.NodeStatus.decode(message.encode()) == message


@given(st.integers(0, 255))
def test_any_arming_status_is_encoded_as_by_pypi_dronecan(status: int) -> None:
    message = ours.ArmingStatus(status)
    peer = dronecan.uavcan.equipment.safety.ArmingStatus(status=status)
    assert agree(ours.ARMING_STATUS, message.encode(), peer, 10, 0).status == status
    assert ours.ArmingStatus.decode(message.encode()) == message


@given(st.binary(min_size=16, max_size=16), st.binary(min_size=1, max_size=80), st.binary(), U32)
def test_any_node_info_is_encoded_as_by_pypi_dronecan(
    unique_id: bytes, name: bytes, certificate: bytes, commit: int
) -> None:
    message = ours.NodeInfo(
        ours.NodeStatus(9), name, unique_id, (1, 2), 1, commit, commit << 17, (3, 4), certificate
    )
    peer = dronecan.uavcan.protocol.GetNodeInfo.Response()
    peer.status.uptime_sec = 9
    peer.software_version.major, peer.software_version.minor = message.software
    peer.software_version.optional_field_flags = 1
    peer.software_version.vcs_commit = commit
    peer.software_version.image_crc = commit << 17
    peer.hardware_version.major, peer.hardware_version.minor = message.hardware
    for k, byte in enumerate(unique_id):
        peer.hardware_version.unique_id[k] = byte
    for byte in certificate:
        peer.hardware_version.certificate_of_authenticity.append(byte)
    for byte in name:
        peer.name.append(byte)
    theirs = peer_frames(peer, 21, 4, service_not_message=True, dest_node_id=10)
    can_id = FrameId(Kind.RESPONSE, 16, 1, 21, 10).pack()
    frames = [(can_id, d) for d in split(message.encode(), 4, ours.GET_NODE_INFO.crc_seed)]
    assert frames == [(f.message_id, bytes(f.bytes)) for f in theirs]
    assert [ours.NodeInfo.decode(p) for p in receive(frames)] == [message]
    got = peer_received(frames)
    assert bytes(got.name) == name and bytes(got.hardware_version.unique_id) == unique_id


@given(st.floats(), st.integers(), st.integers())
def test_numbers_beyond_their_field_saturate(value: float, integer: int, index: int) -> None:
    got = ours.EscStatus.decode(
        ours.EscStatus(integer, value, value, value, integer, integer, index).encode()
    )
    assert math.isnan(value) == math.isnan(got.voltage_V)
    assert math.isnan(value) or abs(got.voltage_V) <= 65504.0
    assert got.rpm == min(max(integer, -131072), 131071)
    assert got.power_pct == min(max(integer, 0), 127)
    assert ours.RawCommand.decode(ours.RawCommand((integer,)).encode()).cmd[0] == min(
        max(integer, -8192), 8191
    )
