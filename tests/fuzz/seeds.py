# SPDX-License-Identifier: MIT
"""The fuzzer's seeds: real messages, frames, files and histories."""

import json
import struct
import zlib
from collections.abc import Iterator
from pathlib import Path

from tests.fuzz.seed_histories import PARAMETERS, histories
from tests.fuzz.seed_mavlink import mavlink

VECTORS = Path(__file__).parents[1] / "reference" / "dronecan_vectors.json"
ESC_STATUS, NODE_STATUS, ALLOCATION = 0, 1, 3  # places in can_ops.hpp's kTypes


def transfer(kind: int, node: int, payload: bytes, fate: int = 0) -> bytes:
    """A CAN transfer as an input of fuzz_can, and a tick."""
    return bytes([1, kind, node, fate << 5, len(payload)]) + payload + b"\x09\x03"


def allocation(number: int, wish: int = 0) -> bytes:
    """An anonymous node sends its unique id in three parts."""
    unique_id = bytes([number, *range(15)])
    parts = ((wish << 1 | 1, unique_id[:6]), (0, unique_id[6:12]), (0, unique_id[12:]))
    return b"".join(transfer(ALLOCATION, 0, bytes([first]) + part) for first, part in parts)


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
    yield "allocation", b"\x00" + allocation(1) + allocation(2, 50) + allocation(1)
    yield "allocations", b"\x00" + b"".join(allocation(n, 100) for n in range(33))


def parameters() -> Iterator[tuple[str, bytes]]:
    lines = [f"{name} = {value}" for name, value in PARAMETERS]
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


PLAN, FENCE, RALLY, CIRCLE, JUMP, SPEED, WAIT = 0, 13, 17, 15, 7, 8, 5  # in fuzz_missions' list
GIVE, TIME, READ, LOOK, CLEAR = 11, 6, 5, 9, 2


def item(command: int, place: tuple[int, int], *params: int) -> bytes:
    """An item as fuzz_missions reads it; its parameters are from -2 on."""
    shifted = [param + 2 for param in (*params, *[0] * 4)][:4]
    return bytes([GIVE, command, *shifted, place[0] % 256, place[1] % 256])


def sent(kind: int, *items: bytes) -> bytes:
    """An upload, whole, a while, what is stored read back, and a look at the way there."""
    after = bytes([TIME, 200, TIME, 9, READ, kind, LOOK, 5, 5])
    return bytes([0, len(items), kind]) + b"".join(items) + after


def missions() -> Iterator[tuple[str, bytes]]:
    """Uploads of fuzz_missions."""
    square = [item(FENCE, place, 4) for place in ((-99, -99), (-99, 99), (99, 99), (99, -99))]
    plan = [
        item(PLAN, (10, 0)),
        item(SPEED, (0, 0), 1, 1),
        item(PLAN, (20, 9)),
        item(WAIT, (0, 0), 3),
    ]
    rally = [item(RALLY, (5, 5)), item(RALLY, (-5, 5))]
    circle = [item(CIRCLE, (0, 0), 25), item(CIRCLE + 1, (60, 60), 5)]
    loop = [*plan, item(JUMP, (0, 0), 0, 2)]
    uploads = {
        "plan": sent(0, *plan),
        "fence": sent(1, *square),
        "circles": sent(1, *circle),
        "rally": sent(2, *rally),
        "loop": sent(0, *loop),
        "all": sent(1, *square) + sent(2, *rally) + sent(0, *loop) + bytes([CLEAR, 3]),
    }
    for name, content in uploads.items():
        for homes in (0, 1):
            yield f"{name}_{homes}", bytes([homes]) + content


def write(directory: Path) -> None:
    """Write the seeds to DIRECTORY/TARGET/…."""
    for name, seeds in (
        ("mavlink", mavlink),
        ("can", can),
        ("parameters", parameters),
        ("history", histories),
        ("missions", missions),
    ):
        folder = directory / name
        folder.mkdir(parents=True, exist_ok=True)
        for seed, content in seeds():
            (folder / seed).write_bytes(content)
