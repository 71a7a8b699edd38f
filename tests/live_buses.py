# SPDX-License-Identifier: MIT
"""Live simulations on multicast buses 1 to 4: one test per machine at a time; how a run ends."""

import fcntl
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import psutil


@contextmanager
def live_buses() -> Iterator[str]:
    """Wait until the buses are free; the address of boat 1's bus."""
    with Path("/tmp/flotilla-mcast-live.lock").open("a") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        yield "mcast:1"


def end_with_its_boats(run: "subprocess.Popen[bytes]") -> None:
    """Terminate a live run; none of its boats runs on."""
    boats = psutil.Process(run.pid).children()
    run.terminate()
    assert run.wait(20.0) == 130
    assert boats and not any(boat.is_running() for boat in boats)
