# SPDX-License-Identifier: MIT
"""The multicast buses of live simulations: 1 to 4, of one test on this machine at a time."""

import fcntl
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


@contextmanager
def live_buses() -> Iterator[str]:
    """The address of boat 1's bus, once no other test sails there."""
    with Path("/tmp/flotilla-mcast-live.lock").open("a") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        yield "mcast:1"
