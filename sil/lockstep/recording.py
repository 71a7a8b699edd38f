# SPDX-License-Identifier: MIT
"""The recording of everything on a run's wires: its digest, and the file for a replay.

A record is time (u64, us of the world), port (u16), length (u16), bytes, little endian. A port is
256 × agent + channel (below); a CAN frame's bytes are its identifier (u32) and data.
`recording.bin` is b"FLOTILLA", the length (u32) of a JSON header, the header, the records; the
digest is the SHA-256 of the records. The header describes the construction of each boat:
{"boats": [{"parameters", "links", "scalar", "clock": {"offset_us", "drift_ppm"}}]}.
"""

import hashlib
import json
import struct
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any, BinaryIO, Self

from sil.common.files import naming

MAGIC = b"FLOTILLA"
_HEAD = struct.Struct("<QHH")
_LENGTH = struct.Struct("<I")
MOST_BOATS = 255  # an agent's number has eight bits in a port

# Channels: an agent's wire and the direction.
MAVLINK_IN = 0  # + link, to the boat
CAN_IN = 8
MAVLINK_OUT = 16  # + link, from the boat
CAN_OUT = 24
HOST = 32  # an event of the boat's host: event (u8), value (i64)

# Events of a host: the bus is up (1) or down (0); the boat's clock is now that many us ahead of the
# world's; the boat's process was killed and restarted with its parameters.
BUS, CLOCK, RESTART = range(3)


class Recorder:
    """Computes the digest of records and writes them to a file, atomically.

    A context manager; with `path` None it writes no file.
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
        """Delete an unfinished file."""
        if self._path is not None and self._file is not None:
            with suppress(OSError):  # of a full disk
                self._file.close()
            _part(self._path).unlink(missing_ok=True)

    def write(self, records: bytes) -> None:
        """Append whole records."""
        self._sha256.update(records)
        if self._path is not None and self._file is not None:
            with naming(self._path):
                self._file.write(records)

    def finish(self) -> str:
        """Finish the file; SHA-256, in hexadecimal, of the records."""
        if self._path is not None and self._file is not None:
            with naming(self._path):
                self._file.close()
                _part(self._path).replace(self._path)
        return self._sha256.hexdigest()


def _part(path: Path) -> Path:
    return path.with_name(f".{path.name}.part")


class Recording:
    """The content of a recording.bin; ValueError if it is invalid or truncated.

    `records`: the bytes of all records.
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
    """The recording in a run's folder, whose summary.json has `digest`; None if there is none.

    A live run has no digest: a recording in its folder is of an earlier run and not returned.
    ValueError if the recording does not match the digest.
    """
    path = folder / "recording.bin"
    if digest is None or not path.is_file():
        return None
    if Recording(path).digest() != digest:
        raise ValueError(f"{path}: damaged, or not the recording of the run in summary.json")
    return path
