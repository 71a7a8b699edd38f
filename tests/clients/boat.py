# SPDX-License-Identifier: MIT
"""A flotillad whose operator is an existing ground station, on a UDP link of its own."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Protocol

import flotilla
import pytest
from pymavlink.dialects.v20 import common as mavlink

from sil.live.free_port import free_port
from tests.linux.process import LOOPBACK, PATIENT, RealSea
from tests.target.stations import BOAT

ESCS_SILENT = "PreArm: an ESC is offline or reports a fault"
OWN_STATE_STALE = "armed, no FORMATION: no recent navigation data"


#: A test with this mark runs with each value of MAV_AUTOPILOT.
BOTH_IDENTITIES = pytest.mark.parametrize("autopilot", [0.0, 1.0], ids=["generic", "ardupilot"])


def parameters(autopilot: float = 0.0) -> dict[str, float]:
    """The parameters, by name, of a boat as started here."""
    given = {**PATIENT, "MAV_AUTOPILOT": autopilot}
    boat: dict[str, float] = flotilla.Boat(parameters=given).parameters()
    return boat


class Client(Protocol):
    """The interface of an operator's program."""

    @property
    def words(self) -> str:
        """All its output."""
        ...


class Waters(Protocol):
    """Boats, and a client of theirs."""

    client: Client | None

    @property
    def address(self) -> str:
        """Where MAVSDK finds a boat."""
        ...

    @property
    def words(self) -> str:
        """The output of all programs, to diagnose a failed test."""
        ...

    def until(self, done: Callable[[], object]) -> None:
        """Sail on until the condition is true."""


class Sea(RealSea):
    """Navigation unit and leader are on the first link; on the second is the client at `port`."""

    def __init__(self, bus: int, folder: Path, autopilot: float = 0.0) -> None:
        super().__init__(bus, folder)
        self.port = free_port()
        self.client: Client | None = None
        param = {**PATIENT, "MAV_AUTOPILOT": autopilot}
        self.start(f"--mavlink=udpout:{LOOPBACK}:{self.port}", param=param)

    @property
    def address(self) -> str:
        return f"udpin://{LOOPBACK}:{self.port}"

    @property
    def words(self) -> str:
        """The output of all programs, to diagnose a failed test."""
        client = "" if self.client is None else self.client.words
        return f"{super()._story()}\nclient: {client}"

    def _story(self) -> str:
        return self.words

    @property
    def armable(self) -> bool:
        """Whether all pre-arm checks pass by the last SYS_STATUS."""
        said = self.named("SYS_STATUS")
        bit = mavlink.MAV_SYS_STATUS_PREARM_CHECK
        return bool(said and said[-1].onboard_control_sensors_health & bit)

    @property
    def ever_armed(self) -> bool:
        beats = self.named("HEARTBEAT")
        return any(m.base_mode & mavlink.MAV_MODE_FLAG_SAFETY_ARMED for m in beats)

    def beat(self) -> None:
        """Wait for the boat's next two HEARTBEATs: messages in flight are processed by then."""
        heard = len(self.named("HEARTBEAT"))
        self.until(lambda: len(self.named("HEARTBEAT")) > heard + 1)

    def asked(self, name: str) -> float:
        """A parameter's value, read over the first link."""
        ask = mavlink.MAVLink_param_request_read_message(BOAT, 1, name.encode(), -1)
        told = len(self.named("PARAM_VALUE"))

        def answers() -> list[float]:
            news = self.named("PARAM_VALUE")[told:]
            return [m.param_value for m in news if m.param_id == name]

        self.repeat(lambda: self.say(ask), answers)
        return answers()[-1]
