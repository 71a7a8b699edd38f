# SPDX-License-Identifier: MIT
"""`flotilla fleet` commands four flotillad processes of a live run, by UDP and by TCP."""

from __future__ import annotations

import re
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Any

import pytest
from pymavlink import mavutil
from pymavlink.dialects.v20 import common as mavlink

from sil.live.free_port import free_port
from tests.flotillad import needs_flotillad
from tests.linux.process import LOOPBACK
from tests.live_buses import end_with_its_boats, live_buses

_PATIENCE_S = 90.0
_COMMAND = (sys.executable, "-m", "sil")


class LiveFleet:
    """A live run of `lead`: boat 1 sails its plan, three boats follow in a diamond."""

    def __init__(self, bus: str, folder: Path) -> None:
        self._udp = free_port()
        self._words = folder / "words"
        settings = ("link.everyone=true", "duration_s=300")
        with self._words.open("wb") as words:
            self._process = subprocess.Popen(
                [
                    *(*_COMMAND, "live", "lead", f"--bus={bus}", f"--out={folder / 'out'}"),
                    f"--gcs=udpout:{LOOPBACK}:{self._udp}",
                    *(f"--set={setting}" for setting in settings),
                ],
                stdin=subprocess.DEVNULL,
                stdout=words,
                stderr=subprocess.STDOUT,
            )

    @property
    def by_udp(self) -> list[str]:
        return [f"udpin:{LOOPBACK}:{self._udp}"]

    def by_tcp(self) -> list[str]:
        """The doors that the run has told."""
        return re.findall(r"is at (tcp:127.0.0.1:\d+)", self.words())

    def words(self) -> str:
        return self._words.read_text(errors="replace")

    def command(self, ends: list[str], *words: str) -> tuple[int, str]:
        """Exit status and words of a command of an operator."""
        assert self._process.poll() is None, self.words()
        links = [f"--mavlink={end}" for end in ends]
        done = subprocess.run(
            [*_COMMAND, "fleet", *links, *words],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            check=False,
            timeout=60,
        )
        print(f"{words}: {done.returncode}\n{done.stdout}")
        return done.returncode, done.stdout

    @contextmanager
    def served(self, ends: list[str]) -> Iterator[Any]:
        """The fleet as one vehicle, at pymavlink's connection."""
        port = free_port()  # not where the boats send
        ground: Any = mavutil.mavlink_connection(f"udpin:{LOOPBACK}:{port}")
        links = [f"--mavlink={end}" for end in ends]
        server = subprocess.Popen(
            [*_COMMAND, "fleet", "serve", f"--ground=udpout:{LOOPBACK}:{port}", *links],
            stdin=subprocess.DEVNULL,
        )
        try:
            assert ground.wait_heartbeat(timeout=_PATIENCE_S) is not None
            yield ground
            server.send_signal(signal.SIGINT)
            assert server.wait(20.0) == 130
        finally:
            server.kill()
            server.wait()
            ground.close()

    def is_seen(self, verdict: str) -> None:
        """Ask again until the first line is the verdict."""
        end_s = time.monotonic() + _PATIENCE_S
        while not (told := self.command(self.by_udp, "status")[1]).startswith(verdict):
            assert time.monotonic() < end_s, self.words()
            # On a busy machine a boat may stop, the leader too, as its states are late.
            if "nobody in formation" in told and "HOLD" in told:
                self.command(self.by_udp, "loiter", "--boats=1")
            if "HOLD" in told:
                self.command(self.by_udp, "follow", "--boats=2,3,4")

    def close(self) -> None:
        end_with_its_boats(self._process)


@pytest.fixture
def fleet(tmp_path: Path) -> Iterator[LiveFleet]:
    needs_flotillad()
    with live_buses() as bus, closing(LiveFleet(bus, tmp_path)) as fleet:
        yield fleet
        print(fleet.words())


def test_an_operator_forms_holds_sends_off_and_stops_a_live_fleet(fleet: LiveFleet) -> None:
    fleet.is_seen("4 of 4 in formation behind boat 1")
    doors = fleet.by_tcp()
    assert len(doors) == 4
    # The options may stand between the words.
    words = fleet.command(fleet.by_udp, "form", "--spacing", "5", "vee", "--boats=1,2,3,4")[1]
    assert re.match(r"table \d+ is in force with 4 of 4 boats", words)
    assert fleet.command(doors, "hold")[0] == 0
    # By the same link: by another one a boat refuses to sail for five seconds after a stop.
    assert fleet.command(doors, "loiter", "--boats=1")[0] == 0
    fleet.command(doors, "follow", "--boats=2,3,4")
    fleet.is_seen("4 of 4 in formation behind boat 1")
    with fleet.served(doors) as ground:
        assert ground.target_system == 250
        for mode in ("HOLD", "LOITER"):
            ground.set_mode(mode)
            result = mavlink.MAV_RESULT_IN_PROGRESS
            while result == mavlink.MAV_RESULT_IN_PROGRESS:
                told = ground.recv_match(type="COMMAND_ACK", blocking=True, timeout=30.0)
                assert told is not None, mode
                result = told.result
            # LOITER can fail on a busy machine: a boat whose states are late does not follow.
            assert result == mavlink.MAV_RESULT_ACCEPTED or mode == "LOITER"
    fleet.is_seen("4 of 4 in formation behind boat 1")
    # By boat 4's door alone: it hands on what is for the others.
    assert fleet.command(doors[3:], "stop", "--boats=1,2,3,4")[1] == "4 of 4 stopped and disarmed\n"
