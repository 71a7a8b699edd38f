# SPDX-License-Identifier: MIT
"""flotillad's notifications to systemd, and its behaviour without the requested rights."""

import select
import signal
import socket
import tempfile
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

import pytest

from tests.linux.process import RealSea

WATCHDOG_US = 300_000


class Manager:
    """A service manager's socket, by path or, with @, in the abstract namespace."""

    def __init__(self, name: str) -> None:
        self.environment = {"NOTIFY_SOCKET": name, "WATCHDOG_USEC": str(WATCHDOG_US)}
        self.socket = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        self.socket.bind("\0" + name[1:] if name.startswith("@") else name)
        self.socket.setblocking(False)
        self._heard: list[str] = []

    @property
    def heard(self) -> list[str]:
        with suppress(BlockingIOError):
            while True:
                self._heard += self.socket.recv(4096).decode().split("\n")
        return self._heard

    def beats(self) -> int:
        return self.heard.count("WATCHDOG=1")


@pytest.fixture(params=["path", "abstract"])
def manager(request: pytest.FixtureRequest) -> Iterator[Manager]:
    with tempfile.TemporaryDirectory() as folder:  # pytest's own may be too long for a socket
        name = f"{folder}/notify" if request.param == "path" else f"@{folder}/notify"
        manager = Manager(name)
        yield manager
        manager.socket.close()


def test_systemd_hears_of_start_life_and_end_from_the_control_loop(
    sea: RealSea, manager: Manager
) -> None:
    sea.start(environment=manager.environment)
    sea.until(lambda: manager.beats() > 3)
    assert manager.heard[0] == "READY=1"

    sea.process.signal(signal.SIGSTOP)
    sea.until(lambda: "T" in state(sea.process.pid))
    before = manager.beats()
    sea.run(2e-6 * WATCHDOG_US)
    assert manager.beats() == before  # here systemd would start it anew

    sea.process.signal(signal.SIGCONT)
    sea.until(lambda: manager.beats() > before + 2)
    assert "STOPPING=1" not in manager.heard
    assert sea.end() == 0
    assert manager.heard[-1] == "STOPPING=1"
    assert set(manager.heard) == {"READY=1", "WATCHDOG=1", "STOPPING=1"}


def test_a_service_manager_that_does_not_read_delays_nothing(sea: RealSea) -> None:
    with tempfile.TemporaryDirectory() as folder:
        deaf = Manager(f"{folder}/notify")
        sea.start(environment=deaf.environment | {"WATCHDOG_USEC": "1000"})
        sea.enter_formation()
        sea.until(lambda: len(sea.raw_commands()) > 150)  # its queue holds about a dozen
        assert select.select([deaf.socket], [], [], 0)[0]
        assert sea.end() == 0
        deaf.socket.close()


def state(pid: int) -> str:
    lines = Path(f"/proc/{pid}/status").read_text().splitlines()
    return next(line for line in lines if line.startswith("State:"))


def test_a_boat_without_real_time_and_locked_memory_reports_it_and_sails(
    sea: RealSea,
) -> None:
    prefix = ["prlimit", "--rtprio=0", "--memlock=0"]
    sea.start("--priority=50", "--lock-memory", prefix=prefix)
    sea.enter_formation()
    words = sea.process.words
    assert "SCHED_FIFO refused (Operation not permitted): running at normal priority" in words
    assert "locked memory refused" in words
    assert sea.end() == 0
    assert (sea.state_dir / "parameters.txt").exists()
