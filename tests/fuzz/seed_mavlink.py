# SPDX-License-Identifier: MIT
"""MAVLink frames made by pymavlink as seeds: every message, every request of clients."""

import random
import struct
from collections.abc import Iterator, Sequence
from types import ModuleType
from typing import Any

from pymavlink.dialects.v10 import common as mavlink1

from tests.dialect import dialect
from tests.link.mavlink.test_oracle import FIELDS

# Flags of a chunk, see fuzz_mavlink.cpp; kinds of boats, see setups.hpp.
TICK, DATAGRAM_ENDS, REPAIRED, SECOND_LINK, LATER = 0x08, 0x04, 0x80, 0x01, 0x60
TWO_LINKS, ACCEPT, REQUIRED, COMPANION, DOUBLE = 1, 4, 8, 16, 128
# watched_boat.hpp's
KEY = bytes([7, 1, 2, 3, 250, 251, 252, 253]) + bytes(24)
CLOCK = 40_000_000_000_000
MINUTE = 6_000_000
COMMANDS: dict[int, list[tuple[float, ...]]] = {
    400: [(1, 0), (0, 0), (1, 21196), (1, 5), (2, 0)],
    176: [(1, 0), (1, 4), (1, 6), (0, 6), (1, 5), (1, 10), (1, 11), (1, 15), (1, 4, 4)],
    20: [()],
    207: [(0,), (1,)],
    410: [()],
    193: [(0,), (1,)],
    224: [(0,), (3,)],
    209: [(1, 0, 10, 1), (2, 0, -10, 1, 1), (1, 0, 90, 1), (3, 0, 10, 1)],
    185: [(1,), (0,)],
    245: [(1,), (0,)],
    262: [(1,), (6,)],
    300: [(0, 0), (1, 1)],
    510: [(30,), (9999,), (-1,)],
    511: [(30, 100_000), (30, -1), (30, 0), (0, 5), (32, 2e9), (32, 3e38), (144, 2e5), (245, 1e6)],
    519: [()],
    520: [()],
    7: [()],
}
ASKED = [
    0,
    1,
    2,
    24,
    30,
    32,
    33,
    49,
    62,
    74,
    85,
    144,
    147,
    148,
    242,
    244,
    245,
    251,
    290,
    291,
    300,
    331,
]
ASKED += [396, 397, 435, 436, 9999]


def field_values(message: Any, rng: random.Random) -> list[object]:
    """Small random values; targets are our ids."""
    values: list[object] = []
    types = dict(zip(message.fieldnames, message.fieldtypes, strict=True))
    for name in message.fieldnames:
        count = message.array_lengths[message.ordered_fieldnames.index(name)]
        if types[name] == "char":
            values.append(b"LAW_KX" if name == "param_id" else b"text")
        elif name.startswith("target"):
            values.append(1)
        elif count:
            values.append([rng.randrange(100) for _ in range(count)])
        elif name == "custom_mode":
            values.append(6)
        else:
            values.append(rng.randrange(100))
    return values


def mavlink_frames() -> Iterator[tuple[str, bytes]]:
    """Every message of the decoder in MAVLink 2, unsigned and signed, and in MAVLink 1."""
    rng = random.Random(1)
    for version, library in ((2, dialect()), (1, mavlink1)):
        by_name = {m.msgname: m for m in library.mavlink_map.values()}
        for name in FIELDS:
            if name not in by_name:
                continue
            for system, component in ((255, 190), (1, 2), (100, 1)):
                sender = library.MAVLink(None, system, component)
                if version == 2 and system == 100:
                    sender.signing.secret_key = bytes(32)
                    sender.signing.sign_outgoing = True
                message = by_name[name](*field_values(by_name[name], rng))
                yield f"{name}_{version}_{system}", bytes(message.pack(sender))


class Client:
    """Encodes an operator's messages; MAVLink 2, unsigned by default."""

    def __init__(self, system: int = 255, component: int = 190) -> None:
        self.library: ModuleType = dialect()
        self.link = self.library.MAVLink(None, system, component)

    def sign(self, timestamp: int) -> "Client":
        """Sign from now on, with the common key."""
        self.link.signing.secret_key = KEY
        self.link.signing.timestamp = timestamp
        self.link.signing.sign_outgoing = True
        return self

    def say(self, name: str, *fields: object) -> bytes:
        """Encode one message."""
        message = getattr(self.library, f"MAVLink_{name.lower()}_message")(*fields)
        return bytes(message.pack(self.link))

    def command(self, number: int, *param: float, target: int = 1) -> bytes:
        """COMMAND_LONG"""
        filled = [*param, *([0.0] * (7 - len(param)))]
        return self.say("COMMAND_LONG", target, 1, number, 0, *filled)

    def file(self, opcode: int, data: bytes = b"", size: int = 0, offset: int = 0) -> bytes:
        """FILE_TRANSFER_PROTOCOL, session 0."""
        head = struct.pack("<HBBBBBBI", 1, 0, opcode, size or len(data), 0, 0, 0, offset)
        return self.say("FILE_TRANSFER_PROTOCOL", 0, 1, 1, list((head + data).ljust(251, b"\0")))


def chunk(frame: bytes, flags: int) -> bytes:
    """An input chunk of fuzz_mavlink; a long frame is split in two."""
    if len(frame) > 255:
        return chunk(frame[:200], flags & SECOND_LINK) + chunk(frame[200:], flags)
    return bytes([flags, len(frame)]) + frame


def questions() -> Iterator[tuple[str, bytes]]:
    """A client's requests, as one or several frames."""
    client = Client()
    for number, all_param in COMMANDS.items():
        for i, param in enumerate(all_param):
            yield f"command_{number}_{i}", chunk(client.command(number, *param), TICK)
    yield "command_nan", chunk(client.command(400, 1, float("nan")), TICK)
    yield (
        "command_int",
        chunk(client.say("COMMAND_INT", 1, 1, 0, 176, 0, 0, 1, 4, 0, 0, 0, 0, 0), TICK),
    )
    for number in ASKED:
        yield f"asked_{number}", chunk(client.command(512, number), TICK)
    yield "modes", b"".join(chunk(client.command(512, 435, n), TICK) for n in range(5))
    for name, opcode, data in (
        ("crc", 14, b"parameters.json"),
        ("list", 3, b"/"),
        ("open", 4, b"/general.json\0"),
        ("missing", 4, b"nothing"),
        ("unknown", 99, b""),
        ("reset", 2, b""),
    ):
        yield f"file_{name}", chunk(client.file(opcode, data), TICK)
    opened = chunk(client.file(4, b"parameters.json"), TICK)
    ticks = chunk(b"", TICK) * 9
    for name, then in (
        ("read", client.file(5, size=200)),
        ("read_end", client.file(5, size=200, offset=1 << 20)),
        ("burst", client.file(15, size=239)),
        ("terminate", client.file(1)),
        ("list_more", client.file(3, b"/", offset=1)),
    ):
        yield f"file_{name}", opened + chunk(then, TICK) + ticks
    for name in ("LAW_KX", "MODE", "ESC_STBD", "MAV_SYSID", "NOTHING"):
        for value in (0.5, 4, 6, 0, float("nan")):
            asked = chunk(client.say("PARAM_SET", 1, 1, name.encode(), value, 9), TICK)
            yield f"set_{name}_{value}", asked + ticks
    yield "set_integer", chunk(client.say("PARAM_SET", 1, 1, b"ESC_PORT", 2, 6), TICK)
    yield "plan", b"".join(chunk(frame, TICK) for frame in plan(client)) + ticks
    for kind, name in ((1, "fence"), (2, "rally")):
        yield name, b"".join(chunk(frame, TICK) for frame in zones(client, kind)) + ticks
    for current in (2, 3):
        yield f"go_here_{current}", chunk(item(client, 0, 16, (0, 0, 0, 0), current), TICK) + ticks
    place = client.say("COMMAND_INT", 1, 1, 6, 192, 0, 0, -1, 1, 0, 0, 410000100, 20000100, 0)
    yield "reposition", chunk(place, TICK) + ticks
    for mask in (0xFFF8, 0xFFC7, 0x07C7, 0):
        local = (0, 1, 1, 1, mask, 5, 5, 0, 0.4, 0, 0, 0, 0, 0, 0, 0.1)
        yield f"local_{mask}", chunk(client.say("SET_POSITION_TARGET_LOCAL_NED", *local), TICK)
        globe = (0, 1, 1, 6, mask, 410000100, 20000100, 0, 0.4, 0, 0, 0, 0, 0, 0, 0)
        yield f"global_{mask}", chunk(client.say("SET_POSITION_TARGET_GLOBAL_INT", *globe), TICK)
    yield "logs", chunk(client.say("LOG_REQUEST_LIST", 1, 1, 0, 0xFFFF), TICK) + ticks
    for number, offset, count in ((1, 0, 200), (2, 90, 0xFFFFFFFF), (0, 0, 1), (9, 0, 90)):
        listed = chunk(client.say("LOG_REQUEST_LIST", 1, 1, 0, 0xFFFF), TICK) + ticks
        data = client.say("LOG_REQUEST_DATA", 1, 1, number, offset, count)
        gap = client.say("LOG_REQUEST_DATA", 1, 1, number, 0, 90)
        ended = chunk(client.say("LOG_REQUEST_END", 1, 1), TICK)
        yield f"log_{number}", listed + chunk(data, TICK) + chunk(gap, 0) + ticks + ended
    for index in (-1, 0, 3, 999):
        yield f"read_{index}", chunk(client.say("PARAM_REQUEST_READ", 1, 1, b"MODE", index), TICK)
    yield "list", chunk(client.say("PARAM_REQUEST_LIST", 1, 0), TICK) + ticks * 3


def plan(client: Client) -> Iterator[bytes]:
    """The dialogue of a plan of three items, its download, and its end."""
    yield client.say("MISSION_COUNT", 1, 1, 3, 0)
    for seq, command, params in (
        (0, 16, (5, 2, 0, 0)),
        (1, 178, (1, 0.5, -1, 0)),
        (2, 19, (3, 0, 0, 0)),
    ):
        yield item(client, seq, command, params)
    yield client.say("MISSION_REQUEST_LIST", 1, 1, 0)
    yield client.say("MISSION_REQUEST_INT", 1, 1, 2, 0)
    yield client.say("MISSION_SET_CURRENT", 1, 1, 1)
    yield client.say("MISSION_CLEAR_ALL", 1, 1, 0)


def item(
    client: Client, seq: int, command: int, params: Sequence[float], current: int = 0, kind: int = 0
) -> bytes:
    """An item of a plan, fence or rally points; each lies 10 m from the one before."""
    place = (410000000 + 900 * (seq % 2), 20000000 + 1200 * (seq // 2))
    head = (1, 1, seq, 6, command, current, 1)
    return client.say("MISSION_ITEM_INT", *head, *params, *place, 0, kind)


def zones(client: Client, kind: int) -> Iterator[bytes]:
    """The dialogue of a fence of a triangle and two circles, or of five rally points."""
    fence = [(5001, 3), (5001, 3), (5001, 3), (5003, 50), (5004, 2)]
    items = fence if kind == 1 else [(5100, 0)] * 5
    yield client.say("MISSION_COUNT", 1, 1, len(items), kind)
    for seq, (command, parameter) in enumerate(items):
        yield item(client, seq, command, (parameter, 0, 0, 0), kind=kind)
    yield client.say("MISSION_REQUEST_LIST", 1, 1, kind)
    yield client.say("MISSION_REQUEST_INT", 1, 1, 1, kind)
    yield client.say("MISSION_CLEAR_ALL", 1, 1, 255)


def radio() -> bytes:
    """A radio whose buffer fills, and that then falls silent."""
    client = Client(51, 68)
    said = [chunk(client.say("RADIO_STATUS", 9, 9, free, 1, 1, 0, 0), TICK) for free in (5, 40, 99)]
    return b"".join(said) + chunk(b"", TICK | 0x70) * 2


def handed_on() -> bytes:
    """Messages that the boat forwards to another system's link."""
    other, client = Client(9, 1), Client()
    heard = chunk(other.say("HEARTBEAT", 11, 0, 0, 0, 3, 3), SECOND_LINK | TICK)
    return heard + chunk(client.command(400, 1, target=9), TICK) * 2


def autopilots() -> Iterator[tuple[str, bytes]]:
    """A companion hears one or two autopilots for three seconds."""
    for name, systems in (("one", (5,)), ("two", (5, 6)), ("leader", (100,))):
        beats = [
            chunk(Client(system, 1).say("HEARTBEAT", 11, 3, 0, 0, 3, 3), TICK | LATER)
            for system in systems * 4
        ]
        yield f"companion_{name}", b"".join(beats)


def signatures() -> Iterator[tuple[str, bytes]]:
    """Signatures: valid, replayed, stale, from the future, forged."""
    for name, timestamp in (
        ("good", CLOCK + 5),
        ("stale", CLOCK - 2 * MINUTE),
        ("future", CLOCK + 2 * MINUTE),
    ):
        frame = Client().sign(timestamp).command(400, 0)
        yield f"signed_{name}", chunk(frame, TICK) * 2
        broken = frame[:-1] + bytes([frame[-1] ^ 1])
        yield f"forged_{name}", chunk(broken, TICK)


def mavlink() -> Iterator[tuple[str, bytes]]:
    """All inputs of fuzz_mavlink."""
    for name, frame in mavlink_frames():
        twice = chunk(frame, TICK | REPAIRED | SECOND_LINK) + chunk(frame, TICK)
        yield name, bytes([TWO_LINKS]) + twice
        cut = chunk(frame[:9], TICK | DATAGRAM_ENDS) + chunk(frame, 0)
        yield name + "_cut", bytes([0]) + cut
        if name.endswith("_2_100"):
            yield name + "_signed", bytes([ACCEPT]) + chunk(frame, TICK | REPAIRED) * 2
            yield name + "_required", bytes([REQUIRED | DOUBLE]) + chunk(frame, TICK | REPAIRED)
    for name, asked in questions():
        yield name, bytes([0]) + asked
        yield name + "_companion", bytes([COMPANION]) + asked
    for name, asked in signatures():
        yield name, bytes([ACCEPT]) + asked
        yield name + "_required", bytes([REQUIRED]) + asked
    for name, beats in autopilots():
        yield name, bytes([COMPANION]) + beats
    yield "radio", bytes([0]) + radio()
    yield "handed_on", bytes([TWO_LINKS]) + handed_on()
