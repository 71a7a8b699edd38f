# SPDX-License-Identifier: MIT
"""What the fuzzer begins with: DIRECTORY/TARGET/…, made of real messages, frames and histories.

python -m tests.fuzz.seeds DIRECTORY
"""

import json
import random
import re
import struct
import zlib
from collections.abc import Iterator
from pathlib import Path

from pymavlink.dialects.v10 import common as mavlink1

from tests.dialect import dialect
from tests.link.test_mavlink_oracle import ENTRIES

HERE = Path(__file__).parent
VECTORS = HERE.parent / "reference" / "dronecan_vectors.json"
OPS = re.findall(r"^  k(\w+),", (HERE / "history.hpp").read_text(), re.MULTILINE)
ASKS = (
    *("arm", "formation", "manual", "hold", "disarm"),
    *("test_port", "test_stbd", "terminate", "leave"),
)
PARAMETERS = re.findall(
    r"^FLOTILLA_PARAMETER\(\"\w+\", (\w+), \"[^\"]*\", (\S+),",
    (HERE.parents[1] / "firmware/app/parameters.def").read_text(),
    re.MULTILINE,
)
NAVIGATION, LEADER, PORT, STBD, OPERATOR, STICKS, OTHER, IMPOSTOR = (1 << bit for bit in range(8))
ALL = NAVIGATION | LEADER | PORT | STBD | OPERATOR

# Chunks of fuzz_mavlink and fuzz_history's kBytes.
TICK, DATAGRAM_ENDS, REPAIRED = 0x08, 0x04, 0x80
ACCEPT, COMPANION, DOUBLE = 4, 16, 128  # kinds of boats, see setups.hpp


def field_values(message: type, rng: random.Random) -> list[object]:
    """Small numbers, for us where a target is named."""
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
    """Every message of the decoder in MAVLink 2, plain and signed, and in MAVLink 1."""
    rng = random.Random(1)
    names = re.findall(r"^([A-Z]\w+) ", ENTRIES, re.MULTILINE)
    for version, library in ((2, dialect()), (1, mavlink1)):
        by_name = {m.msgname: m for m in library.mavlink_map.values()}
        for name in names:
            if name not in by_name:
                continue
            for system, component in ((255, 190), (1, 2), (100, 1)):
                sender = library.MAVLink(None, system, component)
                if version == 2 and system == 100:
                    sender.signing.secret_key = bytes(32)
                    sender.signing.sign_outgoing = True
                message = by_name[name](*field_values(by_name[name], rng))
                yield f"{name}_{version}_{system}", bytes(message.pack(sender))


def chunk(frame: bytes, flags: int) -> bytes:
    return bytes([flags, len(frame)]) + frame


def mavlink() -> Iterator[tuple[str, bytes]]:
    for name, frame in mavlink_frames():
        if len(frame) > 255:
            yield name, bytes([0]) + chunk(frame[:200], 0) + chunk(frame[200:], TICK)
            continue
        yield name, bytes([1]) + chunk(frame, TICK | REPAIRED | 1) + chunk(frame, TICK)
        if name.endswith("_2_100"):
            signed = chunk(frame, TICK | REPAIRED)
            yield name + "_signed", bytes([ACCEPT]) + signed + signed
            yield name + "_required", bytes([2 * ACCEPT + DOUBLE]) + signed
        yield name + "_cut", bytes([0]) + chunk(frame[:9], TICK | DATAGRAM_ENDS) + chunk(frame, 0)


def can() -> Iterator[tuple[str, bytes]]:
    vectors = json.loads(VECTORS.read_text())
    for group in ("captured", "generated", "damaged"):
        for i, vector in enumerate(v for v in vectors[group] if "can_id" in v):
            can_id = struct.pack("<I", int(vector["can_id"], 16))
            out = b"\x00"
            for text in vector["frames"]:
                frame = bytes.fromhex(text)
                out += b"\x00" + can_id + bytes([len(frame)]) + frame
            yield f"{group}_{i}", out + b"\x03" * 3
    for kind in range(8):
        for fate in range(4):
            transfer = bytes([1, kind, 30, fate << 5 | kind, 14]) + bytes(range(14)) + b"\x09"
            yield f"transfer_{kind}_{fate}", b"\x00" + (transfer + b"\x03") * 3


def parameters() -> Iterator[tuple[str, bytes]]:
    lines = [f"{name} = {value}" for name, value in PARAMETERS if name != "MODE"]
    whole = "\n".join(lines) + "\n"
    texts = {
        "whole": whole,
        "short": "\n".join(lines[:5]) + "\n",
        "unknown": whole + "NEW_ONE = 7\nnonsense\n",
        "range": whole.replace("LAW_KX = 0.2", "LAW_KX = 1e9"),
        "text": whole.replace("LAW_KX = 0.2", "LAW_KX = 0.2x"),
        "contradiction": whole.replace("ESC_STBD = 1", "ESC_STBD = 0"),
        "mode": "MODE = 0\n",
    }
    for name, text in texts.items():
        for kind in (0, 1, 3, 7, 11):
            yield f"{name}_{kind}", bytes([kind]) + text.encode()
    title = "flotilla-parameters 1\n" + whole
    crc = f"crc32 = {zlib.crc32(title.encode()):08X}\n"
    yield "file", b"\x00" + (title + crc).encode()
    options = (
        "udpin:0.0.0.0:14550,rate=1000,signing=required udpout:h:1,rate=x serial:/dev/tty:57600"
    )
    for i, option in enumerate([*options.split(), "mcast:1", "socketcan:can0", "THR_DEAD=1.5"]):
        yield f"option_{i}", b"\x40" + option.encode()
    yield "nodes", b"\x60" + (f"{'0123456789abcdef' * 2} 30\n{'ff' * 16} 31\n").encode()
    yield "time", b"\x71" + b"123456789\n"


class History:
    """Ops of history.hpp, one behind the other."""

    def __init__(self, kind: int = 0) -> None:
        self.bytes = bytes([kind])

    def op(self, name: str, *operands: int | bytes) -> "History":
        self.bytes += bytes([OPS.index(name)])
        for operand in operands:
            self.bytes += bytes([operand]) if isinstance(operand, int) else operand
        return self

    def sail(self, ticks: int) -> "History":
        while ticks > 0:
            self.op("Sail", min(ticks, 256) - 1)
            ticks -= 256
        return self

    def ask(self, what: str) -> "History":
        return self.op("Ask", ASKS.index(what))

    def talk(self, who: int) -> "History":
        return self.op("Talk", who)

    def set(self, name: str, value: float) -> "History":
        number = [n for n, _ in PARAMETERS].index(name)
        return self.op("Parameter", number, 7, struct.pack("<f", value))

    def cast_off(self, talk: int = ALL) -> "History":
        """In FORMATION, the leader ahead."""
        place = struct.pack("<hhbbb", 60, 0, 0, 10, 0)
        self.talk(talk).op("Vessel", 1, place).op("Step", 2).sail(30)
        return self.op("Step", 0).ask("arm").sail(30).ask("formation").sail(40)


def histories() -> Iterator[tuple[str, bytes]]:
    for kind in (0, 1, 2, ACCEPT, 2 * ACCEPT, COMPANION, DOUBLE):
        sign = (lambda h: h.op("Link", 1, 0, b"\0\0")) if kind == 2 * ACCEPT else (lambda h: h)
        yield f"formation_{kind}", sign(History(kind)).cast_off().sail(60).bytes
        manual = sign(History(kind)).cast_off(ALL | STICKS).op("Sticks", 100, 20)
        yield f"manual_{kind}", manual.ask("manual").sail(50).ask("hold").ask("disarm").bytes
    for surge, yaw in (
        (127, 0),
        (0, 127),
        (129, 0),
    ):  # of int8: full ahead, full to starboard, full astern
        full = History().cast_off(ALL | STICKS).op("Sticks", surge, yaw).ask("manual")
        yield f"full_{surge}_{yaw}", full.sail(60).bytes
    for source in range(4):
        told = History().op("Vessel", 4, source, bytes(4)).op("Vessel", 5, source, bytes(4))
        yield f"source_{source}", told.cast_off().bytes
    lost = ALL & ~LEADER
    for act in range(3):
        coast = History().talk(ALL).op("Step", 2).sail(20).set("FS_LEADER_ACT", act).sail(2)
        coast.cast_off(ALL | STICKS).op("Step", 2).talk(lost | STICKS).sail(25)
        yield f"leader_lost_{act}", coast.bytes + History().talk(ALL).sail(30).bytes[1:]
        gcs = History().talk(ALL).op("Step", 2).sail(20).set("FS_GCS_S", 1)
        gcs.set("FS_GCS_ACT", act).cast_off().op("Step", 2).talk(ALL & ~OPERATOR).sail(40)
        yield f"operator_lost_{act}", gcs.sail(90).bytes
        yield f"coast_{act}", coast.sail(110).bytes
    for test in ("test_port", "test_stbd"):
        yield (
            test,
            History().talk(ALL).op("Step", 2).sail(30).ask("arm").sail(2).ask(test).sail(30).bytes,
        )
    silent = History().cast_off().op("Step", 2)
    for name, who in (("own", NAVIGATION), ("port", PORT), ("all", ALL)):
        yield f"silent_{name}", silent.bytes + History().talk(ALL & ~who).sail(60).bytes[1:]
    yield "terminated", History().cast_off().ask("terminate").sail(3).ask("disarm").sail(3).bytes
    yield (
        "bus",
        History().cast_off().op("Host", 1).sail(3).op("Host", 0).ask("disarm").sail(9).bytes,
    )
    yield "restart", History().cast_off().op("Restart").sail(99).ask("arm").sail(9).bytes
    yield "impostor", History().cast_off().talk(ALL | IMPOSTOR | OTHER).sail(99).bytes
    yield (
        "clock",
        History()
        .cast_off()
        .op("Clock", struct.pack("<i", 3_600_000))
        .sail(99)
        .op("Clock", struct.pack("<i", -7_200_000))
        .sail(250)
        .bytes,
    )
    yield (
        "jump",
        History().cast_off().op("Vessel", 0, struct.pack("<hhbbb", 999, 0, 0, 0, 0)).sail(99).bytes,
    )
    for name, value in (("FS_BATT_V", 11), ("FS_FENCE_M", 5), ("FS_SEP_M", 4), ("ESC_STBD", 9)):
        limited = History().talk(ALL | OTHER).op("Step", 2).sail(9).set(name, value).sail(2)
        limited.op("Esc", 0, 100, b"\0\0").op("Esc", 1, 100, b"\0\0")
        limited.cast_off(ALL | OTHER).sail(80).op("Esc", 0, 60, b"\x40\0").sail(60)
        yield f"limit_{name}", limited.bytes
    for name, frame in mavlink_frames():
        if "_2_" in name and len(frame) < 255:
            said = History().cast_off().op("Bytes", bytes([REPAIRED, len(frame)]) + frame)
            yield f"said_{name}", said.sail(10).bytes


def write(directory: Path) -> None:
    """DIRECTORY/TARGET/…"""
    for name, seeds in (
        ("mavlink", mavlink),
        ("can", can),
        ("parameters", parameters),
        ("history", histories),
    ):
        folder = directory / name
        folder.mkdir(parents=True, exist_ok=True)
        for seed, content in seeds():
            (folder / seed).write_bytes(content)
