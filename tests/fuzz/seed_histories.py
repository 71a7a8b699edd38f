# SPDX-License-Identifier: MIT
"""Histories of a boat as seeds: each state, each loss of others, each request under way."""

import re
import struct
from collections.abc import Iterator
from pathlib import Path

from tests.fuzz.seed_mavlink import (
    ACCEPT,
    COMPANION,
    DOUBLE,
    REPAIRED,
    REQUIRED,
    TICK,
    mavlink_frames,
    questions,
)

ROOT = Path(__file__).parents[2]
OPS = re.findall(r"^  k(\w+),", (Path(__file__).parent / "history.hpp").read_text(), re.MULTILINE)
ASKS = (
    *("arm", "formation", "manual", "hold", "disarm"),
    *("test_port", "test_stbd", "terminate", "auto"),
    *("guided", "loiter", "return", "goto", "leave"),
)
PARAMETERS = re.findall(
    r"^FLOTILLA_PARAMETER\(\"\w+\", (\w+), \"[^\"]*\", (\S+),",
    (ROOT / "firmware/app/parameters.def").read_text(),
    re.MULTILINE,
)
NAVIGATION, LEADER, PORT, STBD, OPERATOR, STICKS, OTHER, IMPOSTOR = (1 << bit for bit in range(8))
ALL = NAVIGATION | LEADER | PORT | STBD | OPERATOR


# Three waypoints, a speed and a delay: command, two parameters + 20, place.
WAYPOINT, CIRCLE_IN, CIRCLE_OUT, CORNER_IN, CORNER_OUT, RALLY = 0, 8, 9, 6, 7, 11
PLAN = [5, 0, 20, 20, 5, 0, 4, 21, 21, 0, 0, 0, 22, 20, 8, 8, 3, 21, 20, 0, 0, 0, 20, 22, 0, 9]


def stored(kind: int, *items: tuple[int, int, int, int]) -> bytes:
    """A plan (0), fence (1) or rally points (2): command, its parameter, metres north and east."""
    out = [kind << 4 | len(items)]
    for command, parameter, north, east in items:
        out += [command, parameter + 20, 20, north & 255, east & 255]
    return bytes(out)


def corners(command: int, half: int) -> list[tuple[int, int, int, int]]:
    """A square round the origin."""
    return [(command, 4, n * half, e * half) for n, e in ((1, 1), (1, -1), (-1, -1), (-1, 1))]


FENCES = {
    "circle": stored(1, (CIRCLE_IN, 50, 0, 0)),
    "square": stored(1, *corners(CORNER_IN, 40), (CIRCLE_OUT, 3, 20, 20)),
    "small": stored(1, (CIRCLE_IN, 8, 0, 0)),
    "outside": stored(1, *corners(CORNER_OUT, 3), (CIRCLE_IN, 90, 0, 0)),
}
ROUTE = stored(0, (WAYPOINT, 0, 8, 0), (WAYPOINT, 2, 8, 8), (WAYPOINT, 0, 0, 8))


class History:
    """A sequence of operations of history.hpp."""

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
        """Bring the boat into FORMATION behind its leader."""
        place = struct.pack("<hhbbb", 60, 0, 0, 10, 0)
        self.talk(talk).op("Vessel", 1, place).op("Step", 2).sail(30)
        return self.op("Step", 0).ask("arm").sail(30).ask("formation").sail(40)


def histories() -> Iterator[tuple[str, bytes]]:
    for kind in (0, 1, 2, ACCEPT, REQUIRED, COMPANION, DOUBLE):
        sign = (lambda h: h.op("Link", 1, 0, b"\0\0")) if kind == REQUIRED else (lambda h: h)
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
    yield "left", History().cast_off().ask("terminate").sail(60).ask("leave").sail(3).bytes
    for kind in (0, 1, 2, COMPANION):
        led = History(kind).talk(ALL).op("Step", 2).sail(20).op("Plan", *PLAN)
        led.sail(2).ask("arm").sail(20).ask("auto").sail(200)
        yield f"plan_{kind}", led.ask("hold").sail(3).ask("auto").sail(200).bytes
    yield from fenced()
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
    for name, asked in questions():
        # Chunks as in fuzz_mavlink's inputs, each after the operation's number.
        said, at = History().cast_off(), 0
        while at < len(asked):
            end = at + 2 + asked[at + 1]
            said.op("Bytes", asked[at:end]).sail(1 if asked[at] & TICK else 0)
            at = end
        yield f"asked_{name}", said.sail(5).bytes
    for name, frame in mavlink_frames():
        if "_2_" in name and len(frame) < 255:
            said = History().cast_off().op("Bytes", bytes([REPAIRED, len(frame)]) + frame)
            yield f"said_{name}", said.sail(10).bytes


def fenced() -> Iterator[tuple[str, bytes]]:
    """Boats inside a fence, and at it: AUTO, GUIDED, LOITER, RTL, and back to a rally point."""
    rally = stored(2, (RALLY, 0, 5, 5), (RALLY, 0, -20, 3))
    for name, fence in FENCES.items():
        for kind in (0, 3, COMPANION, 64):  # 3: four links, ArduPilot's identity; 64: Q16
            boat = History(kind).talk(ALL).op("Step", 2).sail(20)
            boat.op("Plan", fence).op("Plan", rally).op("Plan", ROUTE).sail(2)
            boat.ask("arm").sail(10)
            yield f"fenced_auto_{name}_{kind}", boat.bytes + more("auto", 250)
            went = more("goto", 60) + more("loiter", 40) + more("return", 150)
            yield f"fenced_guided_{name}_{kind}", boat.bytes + went
    for act in range(3):
        boat = History().talk(ALL).op("Step", 2).sail(9).set("FS_FENCE_ACT", act).sail(2)
        boat.op("Plan", FENCES["small"]).op("Plan", rally).cast_off()
        leader = struct.pack("<hhbbb", 200, 0, 0, 20, 0)
        yield f"at_the_fence_{act}", boat.op("Step", 2).op("Vessel", 1, leader).sail(250).bytes
    for asked in ("guided", "loiter", "return", "goto"):
        boat = History().talk(ALL).op("Step", 2).sail(20).ask("arm").sail(10)
        lost = boat.bytes + more(asked, 60) + History().talk(ALL & ~NAVIGATION).sail(60).bytes[1:]
        yield f"{asked}_lost", lost


def more(what: str, ticks: int) -> bytes:
    """A request, and the ticks after it."""
    return History().ask(what).sail(ticks).bytes[1:]
