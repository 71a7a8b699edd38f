# SPDX-License-Identifier: MIT
"""A simulated sea for each flotillad, on a bus of its own."""

import fcntl
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path

import pytest

from tests.flotillad import needs_flotillad
from tests.linux.process import RealSea

BUSES = (5, 6, 7)  # live simulations have 0 to 4, the tests of firmware/ 8 and 9


@pytest.fixture(scope="module")
def bus() -> Iterator[int]:
    """The number of a multicast bus that no other test run on this machine uses."""
    for number in BUSES:
        with Path(f"/tmp/flotilla-mcast-{number}.lock").open("a") as lock:
            try:
                last = number == BUSES[-1]
                fcntl.flock(lock, fcntl.LOCK_EX | (0 if last else fcntl.LOCK_NB))
            except BlockingIOError:
                continue
            yield number
            return


@pytest.fixture
def sea(bus: int, tmp_path: Path) -> Iterator[RealSea]:
    """A sea whose flotillad has not been started: call start()."""
    needs_flotillad()
    with RealSea(bus, tmp_path) as sea:
        yield sea


@pytest.fixture
def opened() -> Iterator[ExitStack]:
    """Closes what a test opens besides the sea's links."""
    with ExitStack() as stack:
        yield stack
