# SPDX-License-Identifier: MIT
"""Result files appear whole or not at all; errors name them."""

from pathlib import Path

import pytest

from sil.cli.main import sentence
from sil.common import files
from tests.sil.full_disk import full_disk


def half(path: Path) -> None:
    with files.whole(path) as file:
        file.write(b"half")
        raise KeyboardInterrupt


def test_full_disk_is_reported_with_the_path_and_the_earlier_file_stays(tmp_path: Path) -> None:
    path = tmp_path / "summary.json"
    path.write_bytes(b"earlier")
    with full_disk(), pytest.raises(OSError, match=r"summary\.json") as error:
        files.replace(path, bytes(100_000))
    assert sentence(error.value).startswith(f"{path}: ")
    assert path.read_bytes() == b"earlier"
    assert list(tmp_path.iterdir()) == [path]


def test_interrupted_file_leaves_nothing(tmp_path: Path) -> None:
    with pytest.raises(KeyboardInterrupt):
        half(tmp_path / "x")
    assert list(tmp_path.iterdir()) == []


def test_device_is_written_to_and_not_replaced() -> None:
    with pytest.raises(OSError, match="/dev/full"):
        files.replace(Path("/dev/full"), b"x")
    assert Path("/dev/full").is_char_device()
