# SPDX-License-Identifier: MIT
"""Every MAVLink message of the firmware against pymavlink, which shares no code with it."""

import math
import os
import random
import re
import struct
import subprocess
from pathlib import Path
from typing import Any

import pytest
from pymavlink.dialects.v10 import common as mavlink1

from tests.dialect import dialect

ROOT = Path(__file__).parents[3]
TARGET = "target_system target_component"
SEEDS = range(1, 21)
# Extensions at a message's end that the wheel's XML lacks; but for the target they are uint32_t.
NEWER = {
    "TIMESYNC": TARGET,
    "MISSION_COUNT": "opaque_id",
    "MISSION_ACK": "opaque_id",
    "MISSION_CURRENT": "mission_id fence_id rally_points_id",
}

LIST = (ROOT / "firmware" / "link" / "mavlink" / "messages.txt").read_text(encoding="utf-8")
LINES = [
    line.split() for line in LIST.replace("\n ", " ").splitlines() if line[:1] not in {"", "#"}
]


def fields_of(name: str, items: list[str]) -> list[str]:
    """The pymavlink fields that our struct has, in its order."""
    if not items:
        theirs = getattr(dialect(), f"MAVLink_{name.lower()}_message").fieldnames
        return [*theirs, *NEWER.get(name, "").split()]
    wide = "" if name == "MANUAL_CONTROL" else f"target={TARGET.replace(' ', ',')}"
    items = [wide if item == "target" and wide else item for item in items]
    names = [item.partition("=")[2] or item for item in items]
    return [n for each in names for n in each.split(",") if not re.fullmatch(r"-?\d+|nan", n)]


# The members of link::Message in their order: message, its fields in the order of our struct.
FIELDS = {
    head.partition(":")[0]: fields_of(head.partition(":")[0], items) for head, _, *items in LINES
}
NUMBERS = {name: number for number, name in enumerate(FIELDS, 1)}

# Values that a boat sends in fields that its struct lacks; all others are zero.
CONSTANT: dict[tuple[str, str], Any] = {
    ("HEARTBEAT", "mavlink_version"): 3,
    ("ODOMETRY", "velocity_covariance"): [math.nan] + [0.0] * 20,
    ("ODOMETRY", "estimator_type"): 8,  # AUTOPILOT
    ("COMMAND_ACK", "progress"): 255,
    ("RADIO_STATUS", "rssi"): 255,
    ("RADIO_STATUS", "remrssi"): 255,
    ("RADIO_STATUS", "noise"): 255,
    ("RADIO_STATUS", "remnoise"): 255,
    ("BATTERY_STATUS", "temperature"): 32767,
    ("BATTERY_STATUS", "current_consumed"): -1,
    ("BATTERY_STATUS", "energy_consumed"): -1,
    ("BATTERY_STATUS", "battery_remaining"): -1,
}

READ = {head for head, direction, *_ in LINES if direction == "read"}

# Messages that version 1 does not have.
NEW = {
    "ODOMETRY",
    "FORMATION_REFERENCE",
    "FORMATION_FUTURE",
    "FLEET_BEACON",
    "FLEET_TABLE",
    "EKF_STATUS_REPORT",
    "AIS_VESSEL",
}

# Our fields that the sender's protocol version does not have.
ABSENT = {
    1: {
        "GPS_GLOBAL_ORIGIN": "time_usec",
        "TIMESYNC": TARGET,
        "COMMAND_ACK": TARGET,
        "MISSION_REQUEST_LIST": "mission_type",
        "MISSION_COUNT": "mission_type opaque_id",
        "MISSION_ACK": "mission_type opaque_id",
        "MISSION_CLEAR_ALL": "mission_type",
        "MISSION_REQUEST": "mission_type",
        "MISSION_REQUEST_INT": "mission_type",
        "MISSION_ITEM": "mission_type",
        "MISSION_ITEM_INT": "mission_type",
        "STATUSTEXT": "id chunk_seq",
        "GPS_RAW_INT": "alt_ellipsoid h_acc v_acc vel_acc hdg_acc yaw",
    },
    2: {name: NEWER[name] for name in READ & NEWER.keys()},
}

# mavlink/mavlink, common.xml: of the messages that the wheel's common.xml lacks
CRC_EXTRA = {
    80: 14,
    193: 71,
    290: 251,
    291: 10,
    300: 217,
    396: 50,
    397: 182,
    410: 160,
    411: 106,
    412: 33,
    413: 77,
    435: 134,
    436: 193,
    437: 30,
}

Value = int | float | bytes
Message = Any


@pytest.fixture(scope="module")
def frames() -> Path:
    """The firmware's encoder and decoder as a program."""
    build = Path(os.environ.get("FLOTILLA_BUILD", ROOT / "build" / "dev"))
    program = build / "tests" / "mavlink_frames"
    if not program.exists():
        pytest.skip(f"{program} is not built: tools/build dev")
    return program


def bits(value: Value) -> Value:
    """The value, a float as its bits on the wire, so that NaN equals itself and 0 is not −0."""
    return struct.pack("<f", value) if isinstance(value, float) else value


def parsed(token: str) -> Value:
    """A value as mavlink_frames prints it."""
    if token.startswith("x"):
        return bytes.fromhex(token[1:])
    return bits(int(token) if re.fullmatch(r"-?\d+", token) else float.fromhex(token))


def values(message: Message, field: str) -> list[Value]:
    """A pymavlink field as a list: a text is one value, an array has as many as its elements."""
    raw = getattr(message, f"_{field}_raw", None)
    if raw is not None:
        return [bytes(raw).ljust(length_of(message, field), b"\0")]
    value = getattr(message, field)
    return [bits(x) for x in value] if isinstance(value, (list, tuple)) else [bits(value)]


def length_of(message: Message, field: str) -> int:
    return message.array_lengths[message.ordered_fieldnames.index(field)]


def packed_timesync(
    payload: bytes, sequence: int = 0, system: int = 7, component: int = 191
) -> bytes:
    """A MAVLink 2 TIMESYNC by hand, as its target is unknown to the wheel's XML."""
    payload = payload.rstrip(b"\0") or b"\0"
    id_ = dialect().MAVLINK_MSG_ID_TIMESYNC
    head = bytes([len(payload), 0, 0, sequence, system, component]) + id_.to_bytes(3, "little")
    crc = dialect().x25crc(head + payload)
    crc.accumulate(bytes([dialect().mavlink_map[id_].crc_extra]))
    return b"\xfd" + head + payload + crc.crc.to_bytes(2, "little")


def said(frames: Path, seed: int) -> list[tuple[str, bytes, list[Value]]]:
    """Name, frame and our fields of one random message of each type."""
    out = subprocess.run([frames, str(seed)], check=True, capture_output=True, text=True).stdout
    lines = [line.split() for line in out.splitlines()]
    assert [int(line[0]) for line in lines] == list(NUMBERS.values())
    return [
        (name, bytes.fromhex(line[1]), [parsed(token) for token in line[2:]])
        for name, line in zip(FIELDS, lines, strict=True)
    ]


@pytest.mark.parametrize("seed", SEEDS)
def test_pymavlink_reads_every_field_of_a_boats_messages(frames: Path, seed: int) -> None:
    parser = dialect().MAVLink(None)
    for sequence, (name, frame, ours) in enumerate(said(frames, seed)):
        if name == "TIMESYNC":
            assert frame == packed_timesync(struct.pack("<qqBB", *ours), sequence)
            continue
        (message,) = parser.parse_buffer(frame)
        assert message.get_type() == name
        assert (message.get_srcSystem(), message.get_srcComponent()) == (7, 191)
        assert message.get_seq() == sequence
        known = [field for field in FIELDS[name] if field in message.fieldnames]
        theirs = [value for field in known for value in values(message, field)]
        end, payload = message.unpacker.size, frame[10 : 10 + frame[1]].ljust(255, b"\0")
        newer = struct.unpack_from(f"<{len(FIELDS[name]) - len(known)}I", payload, end)
        assert [*theirs, *newer] == ours, name
        for field in set(message.fieldnames) - set(FIELDS[name]):
            expected = CONSTANT.get((name, field))
            if expected is None:
                assert not any(map(any_bit, values(message, field))), (name, field)
            else:
                every = expected if isinstance(expected, list) else [expected]
                assert values(message, field) == [bits(x) for x in every], (name, field)


def any_bit(value: Value) -> bool:
    return any(value) if isinstance(value, bytes) else value != 0


def test_a_timesync_without_a_target_is_that_of_the_old_definition(frames: Path) -> None:
    # The generator's own message: 16 bytes. (One with a target is compared above.)
    message = dialect().MAVLink_timesync_message(0x1122334455667788, -2)
    frame = message.pack(dialect().MAVLink(None, 7, 191))
    assert frame == packed_timesync(struct.pack("<qq", message.tc1, message.ts1))
    ((_, _, fields),) = heard(frames, [frame])
    assert fields == [message.tc1, message.ts1, 0, 0]


def heard(frames: Path, sent: list[bytes]) -> list[tuple[list[int], int, list[Value]]]:
    """Sender, target and sequence; number; and fields of each frame that the firmware reads."""
    lines = "\n".join(frame.hex() for frame in sent)
    out = subprocess.run([frames], check=True, input=lines, capture_output=True, text=True).stdout
    tokens = [line.split() for line in out.splitlines()]
    assert len(tokens) == len(sent)
    return [
        ([int(x) for x in line[:5]], int(line[5]), [parsed(x) for x in line[6:]]) for line in tokens
    ]


def random_value(rng: random.Random, type_: str) -> int | float:
    if type_ in {"float", "double"}:
        special = [math.nan, math.inf, -math.inf, 0.0, -0.0, 3.0e38]
        x = rng.choice(special) if rng.random() < 0.2 else rng.uniform(-1e6, 1e6)
        return x if type_ == "double" else struct.unpack("<f", struct.pack("<f", x))[0]
    size = int(re.findall(r"\d+", type_)[0])
    low = 0 if type_.startswith("u") else -(2 ** (size - 1))
    return rng.choice([low, low + 2**size - 1, rng.randrange(low, low + 2**size)])


def random_message(rng: random.Random, kind: Any) -> Message:
    """A pymavlink message with random fields, and texts of all lengths."""
    fields: dict[str, bytes | Value | list[int | float]] = {}
    for name, type_ in zip(kind.fieldnames, kind.fieldtypes, strict=True):
        length = kind.array_lengths[kind.ordered_fieldnames.index(name)]
        if type_ == "char":
            letters = bytes(rng.randrange(33, 127) for _ in range(rng.randrange(length + 1)))
            fields[name] = letters.ljust(length, b"\0")
        elif length > 0:
            fields[name] = [random_value(rng, type_) for _ in range(length)]
        else:
            fields[name] = random_value(rng, type_)
    return kind(**fields)


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("version", [1, 2])
def test_a_boat_reads_every_field_of_pymavlinks_messages(
    frames: Path, seed: int, version: int
) -> None:
    rng = random.Random(seed)
    library = dialect() if version == 2 else mavlink1
    kinds = library.mavlink_map.values()
    assert {k.msgname for k in kinds} >= READ - (NEW if version == 1 else set())
    packer = library.MAVLink(None, 200, 77)
    messages, sent = [random_message(rng, kind) for kind in kinds], []
    for message in messages:
        packer.seq = rng.randrange(256)
        sent.append(bytes(message.pack(packer)))
        assert sent[-1][0] == (0xFD if version == 2 else 0xFE)
    for message, (whence, number, fields) in zip(messages, heard(frames, sent), strict=True):
        name = message.msgname
        system = getattr(message, "target" if name == "MANUAL_CONTROL" else "target_system", 0)
        component = getattr(message, "target_component", 0)
        assert whence == [200, 77, system, component, message.get_seq()], name
        assert number == (NUMBERS[name] if name in READ else 0)
        if name in READ:
            absent = set(FIELDS[name]) - set(message.fieldnames)
            assert absent == set(ABSENT[version].get(name, "").split())
            expected = [[0] if f in absent else values(message, f) for f in FIELDS[name]]
            assert fields == [value for part in expected for value in part], name


@pytest.mark.parametrize(
    ("tail", "target"),
    [(b"", [0, 0]), (b"\x03", [3, 0]), (b"\x03\x04", [3, 4]), (b"\x00\x04", [0, 4])],
)
def test_a_timesync_says_whom_it_answers_if_its_sender_knows_how(
    frames: Path, tail: bytes, target: list[int]
) -> None:
    # The bytes of an earlier message remain if a parser does not clear them.
    before = dialect().MAVLink_file_transfer_protocol_message(0, 9, 9, [0xAA] * 251)
    frame = packed_timesync(struct.pack("<qq", 5, 2**62) + tail, 33, 200, 77)
    _, (whence, _, fields) = heard(frames, [before.pack(dialect().MAVLink(None)), frame])
    assert whence == [200, 77, *target, 33]
    assert fields == [5, 2**62, *target]


def test_the_messages_that_the_wheel_lacks_have_their_upstream_checksum() -> None:
    assert {id_: dialect().mavlink_map[id_].crc_extra for id_ in CRC_EXTRA} == CRC_EXTRA
