# SPDX-License-Identifier: MIT
"""The rights that flotillad's unit requests; in user-mode Linux root can grant them."""

import os
import subprocess

import pytest

from tests.linux.conftest import bus, sea
from tests.linux.process import RealSea

__all__ = ["bus", "sea"]


def test_the_units_limits_grant_real_time_and_locked_memory(sea: RealSea) -> None:
    limits = ["prlimit", "--rtprio=50", "--memlock=unlimited"]
    if subprocess.run([*limits, "true"], check=False, capture_output=True).returncode != 0:
        pytest.skip("these limits are not ours to give: run as root")
    sea.start("--priority=50", "--lock-memory", prefix=limits)
    sea.enter_formation()
    assert os.sched_getscheduler(sea.process.pid) == os.SCHED_FIFO
    assert sea.process.words.splitlines() == [f"flotillad: ready: boat 2 on mcast:{sea.bus}"]
