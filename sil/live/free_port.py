# SPDX-License-Identifier: MIT
"""A free UDP port for a program that is about to start."""

import itertools
import os
import socket
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

from sil.live.udp_end import LOOPBACK


def _free_ports() -> Iterator[int]:
    """UDP ports outside the ephemeral range; those of processes that run together differ.

    The kernel could give an ephemeral port to another program before its user opens it.
    """
    ephemeral = Path("/proc/sys/net/ipv4/ip_local_port_range").read_text()
    first, last = map(int, ephemeral.split())
    every = range(2048, 65536)
    ports = [port for port in every if not first <= port <= last] or [*every]
    start = os.getpid() * 64 % len(ports)
    for port in itertools.cycle(ports[start:] + ports[:start]):
        if _is_free(port):
            yield port


def _is_free(port: int) -> bool:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe, suppress(OSError):
        probe.bind((LOOPBACK, port))
        return True
    return False


_ports = _free_ports()


def free_port() -> int:
    """A UDP port that no program has, and that none is likely to take before it is opened."""
    return next(_ports)
