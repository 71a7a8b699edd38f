# SPDX-License-Identifier: MIT
"""Builds of one preset exclude each other."""

import fcntl
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
BUILD = ROOT / "tools" / "build"


def test_a_second_build_of_a_preset_waits_for_the_first() -> None:
    lock = ROOT / "build" / "no-such-preset.lock"
    lock.parent.mkdir(exist_ok=True)
    with lock.open("a") as first:
        fcntl.flock(first, fcntl.LOCK_EX)
        with subprocess.Popen(
            [BUILD, "no-such-preset"], stderr=subprocess.PIPE, text=True
        ) as second:
            with pytest.raises(subprocess.TimeoutExpired):
                second.communicate(timeout=1)
            fcntl.flock(first, fcntl.LOCK_UN)
            _, words = second.communicate(timeout=60)
    assert second.returncode != 0
    assert "waiting for another build" in words and "No such preset" in words
    lock.unlink()


def test_a_build_without_a_preset_prints_its_usage() -> None:
    done = subprocess.run([BUILD], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (2, "usage: tools/build PRESET [TARGET…]\n")
