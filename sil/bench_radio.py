# SPDX-License-Identifier: MIT
"""How much of a slow radio one boat of `diamond` needs, message by message."""

from collections import Counter
from pathlib import Path
from typing import TypedDict

from pymavlink.dialects.v20 import common as mavlink  # type: ignore[import-untyped]
from rich.table import Table

from sil import scenario
from sil.recording import MAVLINK_OUT, Recording
from sil.wire.mavlink_frames import frames
from sil.world import World

BAUD = 57_600
BITS_PER_BYTE = 10  # 8N1
TARGET_SHARE = 0.4
STATE_HZ = 10.0
SAILED_S = 60.0
BOAT = 2
RADIO = 1  # the link

# Ours, which the wheel's dialect lacks.
_NAMES = {290: "ESC_INFO", 291: "ESC_STATUS", 436: "CURRENT_MODE", 53100: "FORMATION_REFERENCE"}


class Radio(TypedDict):
    """Bytes per second that a boat sends over its radio, by message; share of a 57,600 Bd link."""

    bytes_per_s: dict[str, float]
    share: float


def measure(folder: Path) -> Radio:
    """Sails `diamond` with a state at 10 Hz and counts what boat 2 says over its radio."""
    sailed = scenario.load("diamond", [f"duration_s={SAILED_S}"])
    path = folder / "radio.bin"
    World(sailed, {"SR_STATE": STATE_HZ}).run(path, lambda _: None)
    port = (BOAT << 8) + MAVLINK_OUT + RADIO
    recording = list(Recording(path))
    released_us = recording[-1][0] - round(1e6 * SAILED_S)
    heard: Counter[str] = Counter()
    for t_us, where, data in recording:
        if where == port and t_us > released_us:
            for message_id, _, _, frame in frames(data):
                known = mavlink.mavlink_map.get(message_id)
                name = known.msgname if known else _NAMES.get(message_id, str(message_id))
                heard[name] += len(frame)
    rates = {name: count / SAILED_S for name, count in heard.most_common()}
    return {"bytes_per_s": rates, "share": sum(rates.values()) * BITS_PER_BYTE / BAUD}


def table(radio: Radio) -> Table:
    """The same for people."""
    out = Table(
        "message",
        title=f"one boat on a {BAUD:,} Bd radio, state at {STATE_HZ:g} Hz",
        title_justify="left",
    )
    out.add_column("bytes/s", justify="right")
    for name, rate in radio["bytes_per_s"].items():
        out.add_row(name, f"{rate:.0f}")
    total = sum(radio["bytes_per_s"].values())
    share = f"{100 * radio['share']:.1f} % (target {100 * TARGET_SHARE:.0f})"
    out.add_section()
    out.add_row(f"all: {share} of the link", f"{total:.0f}")
    return out
