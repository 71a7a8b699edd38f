# SPDX-License-Identifier: MIT
"""Recordings: written atomically, and recognised reliably."""

import struct
from contextlib import suppress
from pathlib import Path

import pytest

from sil.lockstep.recording import Recorder, Recording
from tests.sil.full_disk import full_disk

RECORDS = [(0, 256, b""), (10_000, 280, b"\x01\x02"), (2**40, 65535, bytes(range(256)))]


def packed(t_us: int, port: int, data: bytes) -> bytes:
    return struct.pack("<QHH", t_us, port, len(data)) + data


def record(path: Path | None) -> str:
    with Recorder(path, {"boats": []}) as recorder:
        recorder.write(packed(*RECORDS[0]))
        recorder.write(b"".join(packed(*one) for one in RECORDS[1:]))
        return recorder.finish()


def break_off(path: Path) -> None:
    with Recorder(path, {}) as recorder:
        recorder.write(packed(0, 0, b"half"))
        raise RuntimeError


def record_much(path: Path) -> None:
    with Recorder(path, {}) as recorder:
        for _ in range(1000):
            recorder.write(bytes(100))


def test_a_recording_is_read_back_with_its_digest(tmp_path: Path) -> None:
    digest = record(tmp_path / "recording.bin")
    recording = Recording(tmp_path / "recording.bin")
    assert list(recording) == RECORDS
    assert recording.header == {"boats": []}
    assert recording.digest() == digest == record(None)


def test_an_aborted_run_keeps_the_earlier_recording(tmp_path: Path) -> None:
    digest = record(tmp_path / "recording.bin")
    with pytest.raises(RuntimeError):
        break_off(tmp_path / "recording.bin")
    assert Recording(tmp_path / "recording.bin").digest() == digest
    assert [path.name for path in tmp_path.iterdir()] == ["recording.bin"]


def test_a_full_disk_is_reported_with_the_files_name_and_leaves_nothing(tmp_path: Path) -> None:
    path = tmp_path / "recording.bin"
    with full_disk(), pytest.raises(OSError, match=r"recording\.bin'") as error:
        record_much(path)
    assert error.value.filename == str(path)
    assert list(tmp_path.iterdir()) == []


def test_a_file_cut_off_anywhere_is_an_error_and_never_a_crash(tmp_path: Path) -> None:
    record(tmp_path / "recording.bin")
    whole = (tmp_path / "recording.bin").read_bytes()
    boundaries = 0
    for length in range(len(whole)):
        (tmp_path / "cut.bin").write_bytes(whole[:length])
        with suppress(ValueError):
            boundaries += list(Recording(tmp_path / "cut.bin")) != RECORDS
    # Between two records nothing shows that there were more.
    assert boundaries == len(RECORDS)


def test_a_file_of_another_kind_is_refused(tmp_path: Path) -> None:
    (tmp_path / "x").write_bytes(b"PK\x03\x04 something else")
    with pytest.raises(ValueError, match="not a recording"):
        Recording(tmp_path / "x")
