# SPDX-License-Identifier: MIT
"""`flotilla fleet` and a flotillad with a key, by UDP and along a serial cable."""

from __future__ import annotations

import os
import select
import stat
import subprocess
import sys
import threading
from contextlib import ExitStack
from pathlib import Path

import pytest

from sil.live.free_port import free_port
from tests.linux.process import LOOPBACK, RealSea, Serial, Udp
from tests.target.stations import ARM, BOAT, command_long

KEY = bytes(range(7, 39))


@pytest.fixture
def keys(tmp_path: Path) -> dict[str, Path]:
    """Key files: the boat's, and a stranger's."""
    files = {"own": tmp_path / "key", "other": tmp_path / "other"}
    for file, key in zip(files.values(), (KEY, bytes(32)), strict=True):
        file.write_bytes(key)
        file.chmod(stat.S_IRUSR)
    return files


def relay(boat: Serial, operator: Serial, stack: ExitStack) -> None:
    """Connect two cables."""
    over = threading.Event()

    def run() -> None:
        while not over.is_set():
            ready, _, _ = select.select([boat, operator], [], [], 0.05)
            for here, there in ((boat, operator), (operator, boat)):
                for data in here.receive() if here in ready else ():
                    there.send(data)

    thread = threading.Thread(target=run)
    thread.start()
    stack.callback(thread.join)
    stack.callback(over.set)


def fleet(sea: RealSea, *words: str) -> tuple[int, str]:
    """Exit status and words of the command, while the boat sails."""
    process = subprocess.Popen(
        [sys.executable, "-m", "sil", "fleet", *words],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        env={**os.environ, "COLUMNS": "200"},
    )
    sea.until(lambda: process.poll() is not None, 40.0)
    told = process.communicate()[0]
    print(words, process.returncode, told)
    return process.returncode, told


def armed(sea: RealSea) -> None:
    sea.repeat(lambda: sea.say(command_long(ARM, 1.0), link=0), lambda: is_armed(sea))


def is_armed(sea: RealSea) -> bool:
    beats = sea.named("HEARTBEAT", 0)
    return bool(beats) and bool(beats[-1].base_mode & 128)


@pytest.mark.parametrize("way", ["udp", "serial"])
def test_the_keys_holder_stops_the_boat_and_nobody_else_does(
    sea: RealSea, keys: dict[str, Path], opened: ExitStack, tmp_path: Path, way: str
) -> None:
    options = [f"--signing-key={keys['own']}"]
    if way == "udp":
        port = free_port()
        options.append(f"--mavlink=udpin:{LOOPBACK}:{port},signing=required")
        link = f"udpout:{LOOPBACK}:{port}"
    else:
        boat, operator = Serial(tmp_path / "boat"), Serial(tmp_path / "operator")
        opened.callback(boat.close)
        opened.callback(operator.close)
        options.append(f"--mavlink={boat.option},signing=required")
        link = f"{os.ttyname(operator._slave)}:57600"
        relay(boat, operator, opened)
        os.chmod(os.ttyname(boat._slave), 0o666)
    trusted = Udp()
    trusted.option += ",signing=off"
    sea.connect(trusted)
    sea.start(*options)
    sea.until(sea.ready)
    armed(sea)
    wrong = [] if way == "udp" else [f"--key={keys['other']}"]
    status, told = fleet(sea, f"--mavlink={link}", *wrong, "stop", f"--boats={BOAT}")
    assert status == 1 and f"boat {BOAT}: no answer" in told
    assert is_armed(sea)
    status, told = fleet(sea, f"--mavlink={link}", f"--key={keys['own']}", "status")
    assert (status, told.splitlines()[0]) == (0, "nobody in formation: 1 HOLD")
    status, told = fleet(sea, f"--mavlink={link}", f"--key={keys['own']}", "stop")
    assert (status, told) == (0, "1 of 1 stopped and disarmed\n")
    sea.until(lambda: not is_armed(sea))
