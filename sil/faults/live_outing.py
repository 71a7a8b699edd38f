# SPDX-License-Identifier: MIT
"""One boat with a flotillad process on vcan0 behind a virtual leader, in real time."""

import socket
import struct
import subprocess
from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path

import numpy as np

from sil.live.live_world import LiveWorld, now_us
from sil.scenario import scenario
from sil.wire.dronecan import RAW_COMMAND
from sil.wire.dronecan_transfer import message_subject
from sil.wire.operator import next_request

INTERFACE = "vcan0"
SYSTEM = 1

_RETRY_US = 200_000
_PATIENCE_S = 20.0
_LONGEST_S = 300.0
_FRAME = struct.Struct("=IB3x8s")
_SUBJECT_MASK = 0xFFFF80
#: Longer timeouts than the firmware's defaults, because a busy machine is sometimes late.
_PARAMETERS = {"FS_NAV_S": 0.7, "FS_LEADER_S": 3.0, "FS_ESC_S": 3.0}


class LiveOuting(LiveWorld):
    """`state`: the boat's state by its last HEARTBEAT, "silent" before the first.

    `noticed_us`: when the event given to `watch` happened; None before. `thrust_N`: time (us) and
    the greatest commanded thrust of a propeller, tick by tick; `commands`: time of each RawCommand
    on the bus, and whether it contains anything but zeros.
    """

    def __init__(self, folder: Path) -> None:
        one = scenario.load("diamond", [f"duration_s={_LONGEST_S}"])
        one = one.model_copy(update={"boat": one.boat[:1]})
        super().__init__(one, f"socketcan:{INTERFACE}", _PARAMETERS)
        (self.boat,) = self.boats
        self.operator = self._operator
        self.folder = folder
        self.disk = folder / "state"
        self.thrust_N: list[tuple[int, float]] = []
        self.commands: list[tuple[int, bool]] = []
        self.noticed_us: int | None = None
        self._program: Path | None = None
        self._watched: Callable[[], bool] = lambda: False
        self._full_N = one.propellers.forward_max_N
        self._tick_us = 0
        self._ear = _ear()

    def begin(self, program: Path) -> None:
        """Start the boat and bring it into FORMATION with thrust; StartError if that fails."""
        self._program = program
        self.start()
        self._tick_us = self._start()
        self.wait(self.drives, "thrust")

    def start(self) -> None:
        """Start a new flotillad process; its parameters and logs are on `disk`."""
        self.forget()
        assert self._program is not None
        self.boat.start(self._program, self.folder, f"--log={self.disk / 'log'}")

    def close(self) -> None:
        """End the process and close the sockets."""
        self._ear.close()
        self._opened.close()

    # Time

    def run_for(self, seconds: float) -> None:
        """Sail on for `seconds`."""
        end_us = now_us() + round(1e6 * seconds)
        while now_us() < end_us:
            self._turn()

    def watch(self, happened: Callable[[], bool]) -> None:
        """Check for an event at every tick from now on, until it happens."""
        self.noticed_us, self._watched = None, happened

    def first(self, happened: Callable[[], bool], seconds: float) -> float | None:
        """Seconds until the event; None if it does not happen within `seconds`."""
        begin_us = now_us()
        while not happened():
            if now_us() - begin_us > 1e6 * seconds:
                return None
            self._turn()
        return 1e-6 * (now_us() - begin_us)

    def wait(self, happened: Callable[[], bool], what: str) -> None:
        """Wait for an event; TimeoutError if it does not happen."""
        if self.first(happened, _PATIENCE_S) is None:
            raise TimeoutError(f"no {what}: {self.state}, {self.text!r}")

    def execute(self, *command: str) -> None:
        """Run a system program and sail on meanwhile: it may outlast the boat's timeouts."""
        with subprocess.Popen(command) as process:  # noqa: S603
            self.wait(lambda: process.poll() is not None, f"end of {command[0]}")
        if process.returncode != 0:
            raise RuntimeError(f"{' '.join(command)}: status {process.returncode}")

    def _turn(self) -> None:
        k = len(self.thrust_N)
        self._command[0] = self.boat.command(self._tick_us)
        self.thrust_N.append((self._tick_us, self._full_N * float(np.abs(self._command).max())))
        h_s = 1e-6 * self._h_us
        tau = self._scenario.leader.tau(h_s * (k + np.array([0.0, 0.5, 1.0])))
        self._bodies.advance(self._command, tau[:, None], h_s)
        self._tick_us += self._h_us
        self._until(self._tick_us)
        self._send(self._tick_us)
        self._hear()
        if self.noticed_us is None and self._watched():
            self.noticed_us = now_us()

    def _hear(self) -> None:
        with suppress(OSError):  # no more frames, or no interface
            while True:
                can_id, size, data = _FRAME.unpack(self._ear.recv(_FRAME.size))
                if can_id & _SUBJECT_MASK == message_subject(RAW_COMMAND):
                    self.commands.append((now_us(), any(data[: size - 1])))

    def reopen(self) -> None:
        """Reopen the bus after its interface was recreated."""
        self.boat.reopen()
        self._ear.close()
        self._ear = _ear()

    # The operator

    @property
    def state(self) -> str:
        """The state in the last HEARTBEAT."""
        return self._operator.state.get(SYSTEM, "silent")

    @property
    def text(self) -> str:
        """The last STATUSTEXT."""
        return self._operator.text.get(SYSTEM, "")

    def forget(self) -> None:
        """Forget the state and text received so far."""
        for heard in (self._operator.state, self._operator.text):
            heard.pop(SYSTEM, None)

    def say(self, data: bytes) -> None:
        """Send to the boat by radio."""
        self.boat.radio.send(data)

    def drives(self) -> bool:
        """Whether the boat is in FORMATION and a propeller turns."""
        return self.state == "FORMATION" and any(self.boat.command(now_us()))

    def rests(self) -> bool:
        """Whether both ESCs command their motors to stop."""
        return not any(self.boat.command(now_us()))

    def help(self, well: Callable[[], bool], seconds: float) -> float | None:
        """As operator, disarm, arm and set FORMATION until `well`; return the time, s, or None."""
        asked_us = 0

        def there() -> bool:
            nonlocal asked_us
            if now_us() - asked_us > _RETRY_US:
                asked_us = now_us()
                self._ask()
            return well()

        return self.first(there, seconds)

    def _ask(self) -> None:
        if request := next_request(self.state):
            self.say(self._operator.ask(SYSTEM, request))


def greatest_N(thrust_N: Sequence[tuple[int, float]], from_us: int, to_us: int) -> float:
    """The greatest thrust between two times, us; 0 if there was none."""
    return max((level for t_us, level in thrust_N if from_us <= t_us <= to_us), default=0.0)


def _ear() -> socket.socket:
    """A socket that receives all frames on the bus."""
    ear = socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW)
    ear.setblocking(False)
    ear.bind((INTERFACE,))
    return ear
