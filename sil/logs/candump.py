# SPDX-License-Identifier: MIT
"""Reads logs of `candump -L`, with lines as (1700000000.123456) can0 0704060A#FF7C0200C1."""

import re
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

_LINE = re.compile(
    rb"\(([0-3]?\d{1,9})\.(\d{6})\) (\S+) ([0-9A-Fa-f]{3}|[0-9A-Fa-f]{8})#((?:[0-9A-Fa-f]{2}){0,8})"
    rb"(?: [RT])?\n"
)


class Frame(NamedTuple):
    """One frame: time (UNIX us), name of the bus, length of its line in bytes."""

    t_us: int
    bus: str
    can_id: int
    data: bytes
    size: int


def frames(path: Path, damaged: list[int]) -> Iterator[Frame]:
    """The frames of a log; appends the lengths of invalid or truncated lines to `damaged`."""
    with path.open("rb") as file:
        for line in file:
            found = _LINE.fullmatch(line)
            if found is None:
                damaged.append(len(line))
                continue
            seconds, micros, bus, can_id, data = found.groups()
            yield Frame(
                int(seconds) * 1_000_000 + int(micros),
                bus.decode("ascii", "replace"),
                int(can_id, 16),
                bytes.fromhex(data.decode()),
                len(line),
            )


def bus_of(path: Path) -> str:
    """The bus of the first frame; ValueError if the file contains none."""
    for frame in frames(path, []):
        return frame.bus
    raise ValueError(f"{path}: contains no CAN frame; expected a log of `candump -L`")
