# SPDX-License-Identifier: MIT
"""`flotilla live`: MAVSDK commands a simulated boat as it would a real one, by UDP or TCP."""

from __future__ import annotations

import re
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import closing, suppress
from pathlib import Path

import pytest
from mavsdk.plugins.mission.mission import MissionError

from sil.live.free_port import free_port
from tests.clients.boat import Client
from tests.clients.test_missions import Planner
from tests.flotillad import needs_flotillad
from tests.linux.conftest import bus
from tests.linux.process import LOOPBACK
from tests.live_buses import end_with_its_boats

__all__ = ["bus"]

_PATIENCE_S = 90.0
SCENARIO = """
duration_s = 150.0
law = "product"

[leader]

[navigation]
rate_hz = 20.0

[[boat]]
follows = 0
offset_m = [0.0, 0.0]
eta = [0.0, 0.0, 0.0]
"""


class LiveFleet:
    """A live run in a process of its own; a client commands its boat: at `--gcs`, or by TCP."""

    def __init__(self, bus: int, folder: Path, *, tcp: bool) -> None:
        self._udp = None if tcp else free_port()
        self.client: Client | None = None
        self._words = folder / "words"
        scenario = folder / "alone.toml"
        scenario.write_text(SCENARIO)
        gcs = [] if tcp else [f"--gcs=udpout:{LOOPBACK}:{self._udp}"]
        command = [sys.executable, "-m", "sil", "live", str(scenario), f"--bus=mcast:{bus}"]
        with self._words.open("wb") as words:
            self._process = subprocess.Popen(
                [*command, *gcs, f"--out={folder / 'out'}"],
                stdin=subprocess.DEVNULL,
                stdout=words,
                stderr=subprocess.STDOUT,
            )

    def tcp_port(self) -> int:
        """The port that the run has told."""
        told: list[str] = []
        self.until(
            lambda: told.extend(re.findall(r"boat 1 is at tcp:127.0.0.1:(\d+)", self.words)) or told
        )
        return int(told[0])

    @property
    def address(self) -> str:
        if self._udp is None:
            return f"tcpout://{LOOPBACK}:{self.tcp_port()}"
        return f"udpin://{LOOPBACK}:{self._udp}"

    @property
    def words(self) -> str:
        """The output of all programs, to diagnose a failed test."""
        client = "" if self.client is None else self.client.words
        return f"{self._words.read_text(errors='replace')}\nclient: {client}"

    def until(self, done: Callable[[], object]) -> None:
        """Wait until the condition is true."""
        end_s = time.monotonic() + _PATIENCE_S
        while not done():
            assert time.monotonic() < end_s and self._process.poll() is None, self.words
            time.sleep(0.01)

    def close(self) -> None:
        end_with_its_boats(self._process)


@pytest.fixture(params=[False, True], ids=["udp", "tcp"])
def fleet(bus: int, tmp_path: Path, request: pytest.FixtureRequest) -> Iterator[LiveFleet]:
    needs_flotillad()
    with closing(LiveFleet(bus, tmp_path, tcp=request.param)) as fleet:
        yield fleet
        print(fleet.words)


@pytest.fixture
def planner(fleet: LiveFleet, home: Path) -> Iterator[Planner]:
    with closing(Planner(fleet)) as planner:
        yield planner


def holds(planner: Planner) -> int:
    """How often the boat has said that it stops."""
    return sum(text.startswith("HOLD") for text in planner.sdk.texts)


def is_there(planner: Planner) -> bool:
    """Whether the boat has reached its last waypoint."""
    return bool(planner.progress) and planner.progress[-1].current == 2


def test_a_ground_station_sends_a_plan_and_a_live_boat_sails_it(planner: Planner) -> None:
    planner.sdk.sea.until(lambda: "FORMATION" in planner.sdk.texts)  # the run's start
    planner.upload(planner.at(4, 0), planner.at(4, 3))
    # On a busy machine a boat may stop, as its states are late; then it is sent on.
    while not is_there(planner):
        held = holds(planner)
        with suppress(MissionError):
            planner.sdk.call(planner.mission.start_mission)
            planner.sdk.sea.until(lambda held=held: is_there(planner) or holds(planner) > held)
    assert planner.sdk.call(planner.mission.is_mission_finished)
