# SPDX-License-Identifier: MIT
"""Strangers on a boat's links, to see whether they delay its control loop.

Nine senders flood a UDP link with DATAGRAMS_PER_S datagrams in all: every second one is a byte that
is not MAVLink, the others are HEARTBEATs of other systems. Each second they close their sockets and
come back with new ones. A serial line appears and disappears again and again, with such HEARTBEATs
on it.
"""

import multiprocessing
import os
import socket
import time
import tty
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from multiprocessing.sharedctypes import Synchronized
from pathlib import Path

from pymavlink.dialects.v20 import common as mavlink

from sil.live.udp_end import LOOPBACK

DATAGRAMS_PER_S, STRANGERS = 10_000, 9
BAUD = 115_200
_TORN_S, _ANEW_S, _PAUSE_S = 0.5, 1.0, 0.002
_FIRST_SYSTEM = 101


@contextmanager
def strangers(port: int, line: Path) -> Iterator["Synchronized[int]"]:
    """Disturb a boat from a process of its own; the number of datagrams sent so far."""
    spawn = multiprocessing.get_context("spawn")
    sent = spawn.Value("q", 0)
    process = spawn.Process(target=_disturb, args=(port, str(line), sent), daemon=True)
    process.start()
    try:
        yield sent
    finally:
        process.terminate()
        process.join()
        with suppress(FileNotFoundError):
            line.unlink()


def _heartbeats() -> list[bytes]:
    beat = mavlink.MAVLink_heartbeat_message(11, 8, 0, 0, 4, 3)
    systems = range(_FIRST_SYSTEM, _FIRST_SYSTEM + STRANGERS)
    return [bytes(beat.pack(mavlink.MAVLink(None, srcSystem=each))) for each in systems]


def _disturb(port: int, line: str, sent: "Synchronized[int]") -> None:
    beats, began_s = _heartbeats(), time.monotonic()
    sockets: list[socket.socket] = []
    cable: tuple[int, int] | None = None
    anew_s = torn_s = 0.0
    while True:
        now_s = time.monotonic() - began_s
        if now_s >= anew_s:
            anew_s += _ANEW_S
            for each in sockets:
                each.close()
            sockets = [socket.socket(socket.AF_INET, socket.SOCK_DGRAM) for _ in range(STRANGERS)]
        if now_s >= torn_s:
            torn_s += _TORN_S
            if cable is None:
                cable = _plug(line)
            else:
                _tear(cable, line)
                cable = None
        if cable is not None:
            with suppress(OSError):
                os.write(cable[0], beats[0])
        while sent.value < DATAGRAMS_PER_S * now_s:
            k = sent.value % STRANGERS
            with suppress(OSError):  # refused: the boat is not there
                sockets[k].sendto(beats[k] if sent.value % 2 else b"x", (LOOPBACK, port))
            sent.value += 1
        time.sleep(_PAUSE_S)


def _plug(line: str) -> tuple[int, int]:
    ours, theirs = os.openpty()
    os.set_blocking(ours, False)
    tty.setraw(theirs)
    Path(os.ttyname(theirs)).chmod(0o666)
    Path(line).symlink_to(os.ttyname(theirs))
    return ours, theirs


def _tear(cable: tuple[int, int], line: str) -> None:
    Path(line).unlink()
    for end in cable:
        os.close(end)
