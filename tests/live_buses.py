# SPDX-License-Identifier: MIT
"""A lock on multicast buses 1 to 4 for live simulations: one test per machine at a time."""

import fcntl
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


@contextmanager
def live_buses() -> Iterator[str]:
    """Wait until the buses are free; the address of boat 1's bus."""
    with Path("/tmp/flotilla-mcast-live.lock").open("a") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        yield "mcast:1"
