# SPDX-License-Identifier: MIT
"""The lockstep SIL in real time: two boats in FORMATION, a ground station on one's radio."""

from __future__ import annotations

import socket
import time
from collections.abc import Callable
from contextlib import suppress

import flotilla
import numpy as np

from sil.faults.rows import FOLDER
from sil.live.free_port import free_port
from sil.lockstep.batch import Batch
from sil.lockstep.start import start
from sil.scenario import scenario
from tests.clients.boat import Client
from tests.linux.process import LOOPBACK

_PATIENCE_S = 30.0


class FleetSea:
    """The client at `port` commands boat 1; failures are simulated around the boats."""

    def __init__(self, autopilot: float = 0.0) -> None:
        one = scenario.load(FOLDER / "pair.toml")
        self.batch = Batch([one], {"MAV_AUTOPILOT": autopilot}, inject_failures=True)
        (ready_us,) = start(self.batch)
        assert isinstance(ready_us, int), ready_us
        self._t_us = ready_us
        self._lag_us = time.monotonic_ns() // 1000 - ready_us
        self._tau = one.leader.tau(np.zeros(3))[:, None, :]
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.bind((LOOPBACK, 0))
        self._socket.setblocking(False)
        self.port = free_port()
        self.client: Client | None = None

    @property
    def address(self) -> str:
        return f"udpin://{LOOPBACK}:{self.port}"

    @property
    def words(self) -> str:
        """The output of all programs, to diagnose a failed test."""
        client = "" if self.client is None else self.client.words
        return f"states {[self.state(boat) for boat in (1, 2)]}\nclient: {client}"

    def state(self, boat: int = 1) -> str:
        name: str = flotilla.STATES[self.batch.states[0, boat - 1]]
        return name

    def until(self, done: Callable[[], object]) -> None:
        """Sail on until the condition is true."""
        end_s = time.monotonic() + _PATIENCE_S
        while not done():
            assert time.monotonic() < end_s, self.words
            self._sail()
            time.sleep(0.001)

    def _sail(self) -> None:
        agent = self.batch.row(0, 1)
        while self._t_us + self.batch.h_us <= time.monotonic_ns() // 1000 - self._lag_us:
            self._t_us += self.batch.h_us
            with suppress(BlockingIOError):
                while True:
                    self.batch.fleet.hear(agent, self._socket.recv(4096), self._t_us)
            self.batch.tick(self._t_us)
            self.batch.bodies.advance(self.batch.command, self._tau, 1e-6 * self.batch.h_us)
            if said := self.batch.fleet.sent(agent):
                self._socket.sendto(said, (LOOPBACK, self.port))

    def close(self) -> None:
        self._socket.close()
