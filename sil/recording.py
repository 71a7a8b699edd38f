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
from types import TracebackType
from typing import Any, Self

MAGIC = b"FLOTILLA"
_HEAD = struct.Struct("<QHH")
_LENGTH = struct.Struct("<I")
_FLUSH_RECORDS = 4096


# Channels: which of an agent's wires, and which way.
MAVLINK_IN = 0  # + link, to the boat
CAN_IN = 8
MAVLINK_OUT = 16  # + link, from the boat
CAN_OUT = 24


class Recorder:
    """Writes records to a file, whole or not at all, and keeps their digest. A context manager."""

    def __init__(self, path: Path, header: dict[str, Any]) -> None:
        self._path = path
        self._part = path.with_name(f".{path.name}.part")
        self._file = self._part.open("wb")
        self._sha256 = hashlib.sha256()
        self._parts: list[bytes] = []
        text = json.dumps(header).encode()
        self._file.write(MAGIC + _LENGTH.pack(len(text)) + text)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._flush()
        self._file.close()
        if kind is None:
            self._part.replace(self._path)
        else:
            self._part.unlink()

    def record(self, t_us: int, port: int, data: bytes) -> None:
        """Adds a record; `data` at most 65535 bytes."""
        parts = self._parts
        parts.append(_HEAD.pack(t_us, port, len(data)))
        parts.append(data)
        if len(parts) > _FLUSH_RECORDS:
            self._flush()

    def digest(self) -> str:
        """SHA-256, in hexadecimal, of the records so far."""
        self._flush()
        return self._sha256.hexdigest()

    def _flush(self) -> None:
        chunk = b"".join(self._parts)
        self._parts.clear()
        self._sha256.update(chunk)
        self._file.write(chunk)


class Recording:
    """A recording.bin that was read. ValueError where the file is none, or cut off."""

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
        self._records = memoryview(content)[start + length :]

    def digest(self) -> str:
        """SHA-256, in hexadecimal, of the records."""
        return hashlib.sha256(self._records).hexdigest()

    def __iter__(self) -> Iterator[tuple[int, int, bytes]]:
        """Time in us, port and bytes of each record, in order."""
        at, end = 0, len(self._records)
        while at < end:
            if at + _HEAD.size > end:
                raise ValueError(f"{self._path}: cut off after {at} bytes of records")
            t_us, where, length = _HEAD.unpack_from(self._records, at)
            at += _HEAD.size
            if at + length > end:
                raise ValueError(f"{self._path}: cut off after {at} bytes of records")
            yield t_us, where, bytes(self._records[at : at + length])
            at += length
