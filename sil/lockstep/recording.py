# SPDX-License-Identifier: MIT
"""Everything that went over a wire in a run: its digest, and the file from which it is replayed.

A record is time (u64 us of the world), port (u16), length (u16), bytes, little endian. A port is
256 × agent + channel (below); a CAN frame's bytes are its identifier (u32) and data.
`recording.bin` is b"FLOTILLA", the length (u32) of a JSON header, the header, the records; the
digest is the SHA-256 of the records. The header has what each boat is built from: {"boats":
[{"parameters", "links", "scalar", "clock": {"offset_us", "drift_ppm"}}]}.
"""

import hashlib
import json
import struct
from collections.abc import Iterator
from pathlib import Path
from typing import Any, BinaryIO, Self

MAGIC = b"FLOTILLA"
_HEAD = struct.Struct("<QHH")
_LENGTH = struct.Struct("<I")
MOST_BOATS = 255  # an agent is eight bits of a port

# Channels: which of an agent's wires, and which way.
MAVLINK_IN = 0  # + link, to the boat
CAN_IN = 8
MAVLINK_OUT = 16  # + link, from the boat
CAN_OUT = 24
HOST = 32  # what its host told the boat or did to it: event (u8), value (i64)

# Events of a host: the bus is up (1) or down (0); the boat's clock is so many us ahead of the
# world's from now on; the boat's process was killed, and a new one has its parameters.
BUS, CLOCK, RESTART = range(3)


class Recorder:
    """Digests records and writes them to a file, which appears whole or not at all.

    A context manager; `path` None writes no file.
    """

    def __init__(self, path: Path | None, header: dict[str, Any]) -> None:
        self._sha256 = hashlib.sha256()
        self._path = path
        self._file: BinaryIO | None = None
        if path is not None:
            self._file = _part(path).open("wb")
            text = json.dumps(header).encode()
            self._file.write(MAGIC + _LENGTH.pack(len(text)) + text)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        """Throws the file away where it is not finished."""
        if self._path is not None and self._file is not None:
            self._file.close()
            _part(self._path).unlink(missing_ok=True)

    def write(self, records: bytes) -> None:
        """Adds whole records."""
        self._sha256.update(records)
        if self._file is not None:
            self._file.write(records)

    def finish(self) -> str:
        """Puts the file into its place; SHA-256, in hexadecimal, of the records."""
        if self._path is not None and self._file is not None:
            self._file.close()
            _part(self._path).replace(self._path)
        return self._sha256.hexdigest()


def _part(path: Path) -> Path:
    return path.with_name(f".{path.name}.part")


class Recording:
    """A recording.bin that was read. ValueError where the file is none, or cut off.

    `records`: the bytes of all of them.
    """

    def __init__(self, path: Path) -> None:
        content = path.read_bytes()
        start = len(MAGIC) + _LENGTH.size
        if content[: len(MAGIC)] != MAGIC or len(content) < start:
            raise ValueError(f"{path}: not a recording")
        (length,) = _LENGTH.unpack_from(content, len(MAGIC))
        try:
            self.header: dict[str, Any] = json.loads(content[start : start + length])
        except ValueError:
            raise ValueError(f"{path}: the header is damaged") from None
        self._path = path
        self.records = memoryview(content)[start + length :]

    def digest(self) -> str:
        """SHA-256, in hexadecimal, of the records."""
        return hashlib.sha256(self.records).hexdigest()

    def __iter__(self) -> Iterator[tuple[int, int, bytes]]:
        """Time in us, port and bytes of each record, in order."""
        at, end = 0, len(self.records)
        while at < end:
            if at + _HEAD.size > end:
                raise ValueError(f"{self._path}: cut off after {at} bytes of records")
            t_us, where, length = _HEAD.unpack_from(self.records, at)
            at += _HEAD.size
            if at + length > end:
                raise ValueError(f"{self._path}: cut off after {at} bytes of records")
            yield t_us, where, bytes(self.records[at : at + length])
            at += length


def of_run(folder: Path, digest: str | None) -> Path | None:
    """The recording in the folder of a run whose summary.json tells `digest`; None where none is.

    A live run has no digest and leaves none: one that is there is of an earlier run. ValueError for
    one that is not that of the summary.
    """
    path = folder / "recording.bin"
    if digest is None or not path.is_file():
        return None
    if Recording(path).digest() != digest:
        raise ValueError(f"{path}: damaged, or not of the run that summary.json tells of")
    return path
