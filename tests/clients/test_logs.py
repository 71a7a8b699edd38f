# SPDX-License-Identifier: MIT
"""MAVSDK and MAVProxy list a boat's logs and fetch them, also over a link that loses messages."""

from __future__ import annotations

import random
import re
import select
import socket
import threading
from collections.abc import Iterator
from contextlib import closing, suppress
from pathlib import Path
from typing import Any

import pytest
from mavsdk.plugins.log_files import LogFiles
from mavsdk.plugins.log_files.log_files import LogFilesError, LogFilesResult

from tests.clients.boat import BOTH_IDENTITIES, Sea
from tests.clients.mavproxy_client import MavProxy
from tests.clients.mavsdk_client import MavsdkClient
from tests.flotillad import needs_flotillad
from tests.linux.conftest import bus
from tests.linux.process import LOOPBACK

__all__ = ["bus"]

pytestmark = BOTH_IDENTITIES
_PATIENCE_S = 90.0
KEPT = {"mavlink0-00001.tlog": 20_007, "can-00001.log": 90 * 300}


class Losses:
    """Passes datagrams on between a boat and its client, but for one in four."""

    def __init__(self, to: int, share: float) -> None:
        self.boat, self.client = (socket.socket(socket.AF_INET, socket.SOCK_DGRAM) for _ in "ab")
        self.boat.bind((LOOPBACK, 0))
        self.client.connect((LOOPBACK, to))
        self.port: int = self.boat.getsockname()[1]
        self._dice = random.Random(6)
        self._share = share
        self._stop, self._stopped = socket.socketpair()
        self._thread = threading.Thread(target=self._run)
        self._thread.start()

    def close(self) -> None:
        self._stop.close()
        self._thread.join()
        for end in (self.boat, self.client, self._stopped):
            end.close()

    def _run(self) -> None:
        peer = None
        while True:
            ready = select.select([self.boat, self.client, self._stopped], [], [])[0]
            if self._stopped in ready:
                return
            try:
                if self.boat in ready:
                    data, peer = self.boat.recvfrom(4096)
                    if self._dice.random() >= self._share:
                        self.client.send(data)
                if self.client in ready:
                    data = self.client.recv(4096)
                    if peer is not None and self._dice.random() >= self._share:
                        self.boat.sendto(data, peer)
            except ConnectionRefusedError:
                continue  # the client has not begun to listen


class LogSea(Sea):
    """A boat with logs of earlier voyages, and a link that loses a share of the datagrams."""

    def __init__(self, bus: int, folder: Path, autopilot: float, share: float) -> None:
        self.logs = folder / "logs"
        self.logs.mkdir()
        for name, size in KEPT.items():
            (self.logs / name).write_bytes(random.Random(size).randbytes(size))
        for path in (self.logs, *self.logs.iterdir()):
            path.chmod(0o777)
        self._share = share
        super().__init__(bus, folder, autopilot)

    def start(self, *_: str, **how: Any) -> None:
        self.losses = Losses(self.port, self._share)
        super().start(
            f"--mavlink=udpout:{LOOPBACK}:{self.losses.port}", f"--log={self.logs}", **how
        )


@pytest.fixture(params=[0.0, 0.25], ids=["whole", "lossy"])
def share(request: pytest.FixtureRequest) -> float:
    """Of the datagrams that are lost."""
    share: float = request.param
    return share


@pytest.fixture
def sea(bus: int, tmp_path: Path, autopilot: float, share: float) -> Iterator[LogSea]:
    needs_flotillad()
    with LogSea(bus, tmp_path, autopilot, share) as sea, closing(sea.losses):
        yield sea
        print(sea.words)


def test_mavsdk_lists_the_logs_and_fetches_them(sea: LogSea, home: Path) -> None:
    with closing(MavsdkClient(sea)) as sdk:
        logs = LogFiles(sdk.system)
        entries: list[Any] = []
        while not entries:
            with suppress(LogFilesError):  # MAVSDK does not ask again for entries that were lost
                entries = sdk.call(logs.get_entries)
        for name, size in KEPT.items():
            (entry,) = [entry for entry in entries if entry.size_bytes == size]
            results: list[LogFilesResult] = []
            logs.download_log_file_async(
                entry, str(home / name), lambda result, *_, got=results: got.append(result)
            )
            sea.until(
                lambda got=results: got and got[-1] != LogFilesResult.NEXT, seconds=_PATIENCE_S
            )
            assert results[-1] == LogFilesResult.SUCCESS
            assert (home / name).read_bytes() == (sea.logs / name).read_bytes()
        logs.destroy()


def test_mavproxy_lists_the_logs_and_downloads_them(sea: LogSea, home: Path) -> None:
    with closing(MavProxy(sea, home)) as proxy:
        proxy.until_it_says("online system 2")
        for name, size in KEPT.items():
            pattern = re.compile(rf"Log (\d+)  numLogs \d+ lastLog \d+ size {size} ")
            sea.repeat(lambda: proxy.send("log list"), lambda p=pattern: p.search(proxy.words))
            number = pattern.search(proxy.words)
            assert number is not None
            done = f"Finished downloading {name}"
            while not proxy.says(done):
                # MAVProxy does not repeat a request of which it heard nothing.
                proxy.send(f"log download {number[1]} {name}")
                heard = len(sea.named("HEARTBEAT"))
                file = home / name
                sea.until(
                    lambda file=file, heard=heard: (
                        (file.exists() and file.stat().st_size)
                        or len(sea.named("HEARTBEAT")) > heard + 3
                    )
                )
                if file.exists() and file.stat().st_size:
                    sea.until(lambda done=done: proxy.says(done), seconds=_PATIENCE_S)
            assert (home / name).read_bytes() == (sea.logs / name).read_bytes()
