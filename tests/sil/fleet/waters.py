# SPDX-License-Identifier: MIT
"""Four boats of the scenario `lead` under way, and an operator's radio, all in simulated time.

The boats are the firmware; the command line's station is the shipped one. Its clock is the
simulation's, so a run takes a moment, and is the same every time.
"""

import io
import random
import struct
from collections.abc import Sequence
from typing import Any

import flotilla
import numpy as np
from pymavlink.generator.mavcrc import x25crc
from rich.console import Console

from sil.fleet.actions import Wish, perform
from sil.fleet.ends import End, Peer
from sil.fleet.station import Station
from sil.lockstep.batch import Batch
from sil.lockstep.start import start
from sil.scenario import scenario
from sil.wire.mavlink_messages import FLEET_BEACON, LAYOUTS, SEEDS

BOATS = (1, 2, 3, 4)
SETTINGS = (
    "leader.waypoints=[[0, 0], [70, 0], [70, 50], [0, 50]]",
    "formation.shape=vee",
    "formation.spacing_m=4.5",
    "link.everyone=true",
    "link.delay_s=0.1",
)
_SLICE_S = 0.05
_STILL = np.zeros((1, 1, 2))


class Waters:
    """The boats; they start in AUTO and FORMATION. `loss`: of each message of the operator's radio.

    `deaf`: boats that this radio reaches neither way.
    """

    def __init__(self, loss: float = 0.0, seed: int = 1, boat_loss: float = 0.05) -> None:
        print(f"seed {seed}")
        one = scenario.load("lead", (*SETTINGS, f"link.loss={boat_loss}", f"seed={seed}"))
        self.batch = Batch([one], {})
        (ready_us,) = start(self.batch)
        assert isinstance(ready_us, int), ready_us
        self.t_us = ready_us
        self.loss = loss
        self.deaf: set[int] = set()
        self.dice = random.Random(seed)
        self.airs: list[Air] = []
        self.date_s = 0.0
        self.wait((), 1.0)  # until all have said something

    def now_s(self) -> float:
        return 1e-6 * self.t_us

    def unix_s(self) -> float:
        return self.date_s

    def wait(self, ends: Sequence[End], for_s: float) -> Sequence[End]:
        """Sail on for that time; returns the ends that have received something."""
        for _ in range(max(1, round(1e6 * for_s / self.batch.h_us))):
            self.t_us += self.batch.h_us
            self.batch.tick(self.t_us)
            self.batch.bodies.advance(self.batch.command, _STILL, 1e-6 * self.batch.h_us)
            for boat in BOATS:
                said = self.batch.fleet.sent(self.agent(boat))
                for air in self.airs if said and self.reaches(boat) else ():
                    air.heard.append((("boat", boat), said))
        return [end for end in ends if isinstance(end, Air) and end.heard]

    def reaches(self, boat: int) -> bool:
        """Whether the operator's radio carries a message of or to a boat."""
        return boat not in self.deaf and self.dice.random() >= self.loss

    def agent(self, boat: int) -> int:
        return self.batch.row(0, boat)

    def state(self, boat: int) -> str:
        name: str = flotilla.STATES[self.batch.states[0, boat - 1]]
        return name

    @property
    def states(self) -> list[str]:
        return [self.state(boat) for boat in BOATS]

    def places(self) -> np.ndarray:
        """North and east of the boats from boat 1, m."""
        eta = self.batch.bodies.eta[list(self.batch.agents(0)), :2]
        return np.asarray(eta - eta[0])

    def fault(self, boat: int, kind: str, *, over: bool = False) -> None:
        change = self.batch.fleet.clear_fault if over else self.batch.fleet.set_fault
        change(self.agent(boat), kind, self.t_us)

    def station(self, system: int = 255) -> Station:
        air = Air(self)
        self.airs.append(air)
        return Station([air], system, clock=self)

    def command(
        self, *, system: int = 255, strange: Sequence[bytes] = (), **wish: Any
    ) -> tuple[int, str]:
        """Exit status and words of a command of an operator, who hears strange frames first."""
        words = io.StringIO()
        console = Console(file=words, width=120, highlight=False)
        station = self.station(system)
        for frame in strange:
            heard(self, frame)
        status = perform(station, Wish(**wish), console)
        self.airs.pop()
        print(f"{wish}: {status}\n{words.getvalue()}")
        return status, words.getvalue()


class Air(End):
    """The operator's radio, as a `udpin` end: a peer for each boat."""

    address = "air"

    def __init__(self, waters: Waters) -> None:
        self.heard: list[tuple[Peer, bytes]] = []
        self._waters = waters

    def fileno(self) -> int:
        raise NotImplementedError

    def receive(self) -> list[tuple[Peer, bytes]]:
        heard, self.heard = self.heard, []
        return heard

    def send(self, frame: bytes, peer: Peer) -> None:
        for boat in BOATS if peer is None else (peer[1],):
            if self._waters.reaches(boat):
                agent = self._waters.agent(boat)
                self._waters.batch.fleet.hear(agent, frame, self._waters.t_us)

    def close(self) -> None:
        pass


def heard(waters: Waters, frame: bytes) -> None:
    """A stranger's frame, at all the operators' radios."""
    for air in waters.airs:
        air.heard.append((("boat", 1), frame))


def beacon_message(system: int, epoch: int, digest: int, component: int = 1) -> bytes:
    """A FLEET_BEACON frame of a boat that is not fit and does not lead."""
    payload = LAYOUTS[FLEET_BEACON].pack(0, epoch, digest, 0, 0, 0, 0).rstrip(b"\0")
    head = bytes([len(payload), 0, 0, 0, system, component]) + FLEET_BEACON.to_bytes(3, "little")
    crc = x25crc(head + payload + bytes([SEEDS[FLEET_BEACON]])).crc
    return b"\xfd" + head + payload + struct.pack("<H", crc)
