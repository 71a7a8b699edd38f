# SPDX-License-Identifier: MIT
"""One flotillad on vcan0 in real time; one thread simulates everything around it.

Navigation unit, leader and operator talk MAVLink over one UDP link, two ESCs behave as AM32 does.
The boat moves under its own thrust; the leader turns steadily, so that every propeller has work.
All waits are for a socket or the next message that is due, with a deadline. The data of a program
that the machine does not run are old, and then a boat rightly refuses: such time does not count,
and a test that loses too much of it is not judged.
"""

import itertools
import json
import select
import shlex
import socket
import subprocess
import time
from collections.abc import Callable
from contextlib import ExitStack, suppress
from pathlib import Path
from typing import Any, Self

import pytest

from sil.live.ordinary_user import ordinary_user
from sil.live.parameter_file import set_up
from sil.wire.esc_node import EscNode
from sil.wire.heartbeat import state_of
from tests.flotillad import FLOTILLAD
from tests.linux.process import PATIENT
from tests.punctual import lateness
from tests.target.agent import START_US, Agent
from tests.target.bus import ARMING_STATUS, NODE, RAW_COMMAND, type_of
from tests.target.course import TURN, Course
from tests.target.hull import ARM_M, GREATEST_N, Helmsman, Hull
from tests.target.stations import (
    ARM,
    BOAT,
    FORMATION,
    GCS,
    GCS_COMPONENT,
    LEADER,
    LEADER_COMPONENT,
    NAVIGATION,
    SET_MODE,
    Station,
    command_long,
    decode,
)
from tests.vcan.bus import INTERFACE, Can

ESC_NODES = (31, 32)
ACCEPTED = 0

_STEP_US = 10_000
_LONGEST_S = 0.1
_PATIENCE_S = 30.0
_LATE_S = 0.05  # a longer turn is time in which the machine did not run this program
_MOST_LATE_S = 60.0
_RETRY_US = 50_000
_MESSAGE = socket.CAN_EFF_FLAG | socket.CAN_RTR_FLAG | 0xFFFF80
#: The frames that the ESCs receive; the kernel filters a flood of others.
_HEARD = [
    (socket.CAN_EFF_FLAG | RAW_COMMAND << 8, _MESSAGE),
    (socket.CAN_EFF_FLAG | ARMING_STATUS << 8, _MESSAGE),
]


def now_us() -> int:
    return time.monotonic_ns() // 1000


class Boat:
    """The boat and its surroundings; a context manager that kills a boat still running.

    Received so far: `state`, `texts` (STATUSTEXT), `commands` (time and frame of each RawCommand).
    `esc_frames` counts the ESCs' frames.
    """

    def __init__(self, folder: Path) -> None:
        self.state: str | None = None
        self.texts: list[str] = []
        self.commands: list[tuple[int, tuple[int, bytes]]] = []
        self.esc_frames = 0
        self.escs_speak = True
        self.escs = [EscNode(node, index) for index, node in enumerate(ESC_NODES)]
        self._folder = folder
        self._results: list[int] = []
        self._gcs = Station(GCS, GCS_COMPONENT)
        self._hull = Hull([1.0, 2.0, 0.3, 0.0, 0.0, 0.0])
        self._moved_us = now_us()
        self._agents = (
            Helmsman(Station(BOAT, NAVIGATION), Course(), 50_000, beats=False, hull=self._hull),
            Agent(Station(LEADER, LEADER_COMPONENT), TURN, 100_000),
        )
        for agent in self._agents:
            agent.answers_timesync = True
        self._peer: tuple[str, int] | None = None
        self._start_us = self._due_us = now_us()

    def __enter__(self) -> Self:
        with ExitStack() as opened:
            self.can = Can(_HEARD)
            opened.callback(self.can.close)
            self._udp = opened.enter_context(socket.socket(socket.AF_INET, socket.SOCK_DGRAM))
            self._udp.bind(("127.0.0.1", 0))
            self._udp.setblocking(False)
            self._shell = opened.enter_context(
                subprocess.Popen(["sh"], stdin=subprocess.PIPE, stdout=subprocess.PIPE)
            )
            self.start()
            opened.callback(self.kill)
            self._opened = opened.pop_all()
        return self

    def __exit__(self, *_: object) -> None:
        self._opened.close()

    def start(self) -> None:
        """Start a new process and wait for its first message."""
        self._peer = None
        set_up(self._folder / "state", PATIENT)
        self.process = subprocess.Popen(
            [
                *ordinary_user(),
                FLOTILLAD,
                f"--can=socketcan:{INTERFACE}",
                f"--mavlink=udpout:127.0.0.1:{self._udp.getsockname()[1]}",
                *(f"--param={name}={value}" for name, value in PATIENT.items()),
                f"--state-dir={self._folder / 'state'}",
                f"--stats={self._folder / 'stats.json'}",
            ],
            stdin=subprocess.DEVNULL,
        )
        try:
            self.wait(lambda: self._peer is not None, "a word of the boat")
        except BaseException:
            self.kill()
            raise

    def kill(self) -> None:
        self.process.kill()
        self.process.wait()

    def stop(self) -> dict[str, Any]:
        """Terminate the process; the statistics that it writes."""
        self.process.terminate()
        self.wait(lambda: self.process.poll() is not None, "end of the process")
        assert self.process.returncode == 0
        return dict(json.loads((self._folder / "stats.json").read_text()))

    def lateness(self) -> float:
        """Stops the process; the share of its ticks that were late; 0 if it does not tell."""
        self.process.terminate()
        with suppress(subprocess.TimeoutExpired, FileNotFoundError):
            self.process.wait(_PATIENCE_S)
            return lateness(self._folder / "stats.json")
        return 0.0

    # Time

    def run(self, seconds: float) -> None:
        end_us = now_us() + round(1e6 * seconds)
        while now_us() < end_us:
            self._turn()

    def count_commands(self, seconds: float) -> int:
        """The number of RawCommands that arrive in that time."""
        self._hear_bus()
        known = len(self.commands)
        self.run(seconds)
        return len(self.commands) - known

    def share_lost(self, commands: int) -> float:
        """The share of the RawCommands sent that do not arrive, until so many more have arrived.

        Each transfer has the number after the last one's, 5 bits wide, in its last byte.
        """
        self._hear_bus()
        known = len(self.commands)
        self.wait(lambda: len(self.commands) > known + commands, f"{commands} RawCommands")
        numbers = [data[-1] & 31 for _, (_, data) in self.commands[known:]]
        sent = sum((after - before) % 32 for before, after in itertools.pairwise(numbers))
        return 1.0 - (len(numbers) - 1) / sent

    def execute(self, *command: str) -> None:
        """Run a system program through a waiting shell.

        Looking up PATH from Python stalls user-mode Linux so long that the boat detects no motion
        and stops.
        """
        assert self._shell.stdin is not None and self._shell.stdout is not None
        self._shell.stdin.write(f"{shlex.join(command)}; echo $?\n".encode())
        self._shell.stdin.flush()
        output = self._shell.stdout
        self.wait(lambda: bool(select.select([output], [], [], 0.0)[0]), f"end of {command[0]}")
        assert output.readline() == b"0\n", f"{shlex.join(command)} failed"

    def wait(self, done: Callable[[], bool], what: str) -> None:
        """Turn until `done`; fails after _PATIENCE_S, not counting what the machine was late."""
        punctual_s = late_s = 0.0
        while not done():
            if late_s > _MOST_LATE_S:
                pytest.skip(f"not judged: this machine is too slow: no {what} in {late_s:.0f} s")
            if punctual_s > _PATIENCE_S:
                said = "; ".join(self.texts[-3:])
                raise AssertionError(f"no {what} after {_PATIENCE_S} s: {self.state}; {said}")
            begin_us = now_us()
            self._turn()
            turn_s = 1e-6 * (now_us() - begin_us)
            if turn_s < _LATE_S:
                punctual_s += turn_s
            else:
                late_s += turn_s

    def _turn(self) -> None:
        """Send everything that is due; process input until the next step."""
        t_us = now_us()
        if t_us >= self._due_us:
            self._due_us = t_us + _STEP_US
            if self._peer is not None:  # unheard, a message would be repeated only a second later
                self._speak(t_us)
        left_s = max(0.0, 1e-6 * (self._due_us - now_us()))
        select.select([self._udp, self.can.socket], [], [], left_s)
        self._hear_bus()
        self._hear_link()

    def _clock(self, t_us: int) -> int:
        return t_us - self._start_us + START_US

    def _speak(self, t_us: int) -> None:
        self._sail(t_us)
        for agent in self._agents:
            self._say(agent.wire(self._clock(t_us)))
        if not self.escs_speak:
            return
        for esc in self.escs:
            for frame in esc.tick(t_us, 1000.0 * esc.command(t_us), 24.0, 1.0):
                self.esc_frames += 1
                self.can.send(*frame)

    def _sail(self, t_us: int) -> None:
        """Advance the hull; a longer interval than usual counts as a moment only."""
        port, stbd = (GREATEST_N * esc.command(t_us) for esc in self.escs)
        h = min(1e-6 * (t_us - self._moved_us), _LONGEST_S)
        self._hull.advance(port + stbd, ARM_M * (port - stbd), h)
        self._moved_us = t_us

    def _say(self, wire: bytes) -> None:
        if wire and self._peer is not None:
            with suppress(ConnectionRefusedError):  # it was killed
                self._udp.sendto(wire, self._peer)

    def _hear_bus(self) -> None:
        t_us = now_us()
        for frame in self.can.receive():
            if type_of(frame[0]) == (False, RAW_COMMAND, NODE):
                self.commands.append((t_us, frame))
            for esc in self.escs:
                esc.on_can(*frame, t_us)

    def _hear_link(self) -> None:
        chunks = []
        with suppress(BlockingIOError, ConnectionRefusedError):
            while True:
                data, self._peer = self._udp.recvfrom(4096)
                chunks.append(data)
        for message in decode(chunks):
            match message.get_type():
                case "HEARTBEAT":
                    fields = message.custom_mode, message.base_mode, message.system_status
                    self.state = state_of(*fields)
                case "STATUSTEXT":
                    self.texts.append(message.text)
                case "COMMAND_ACK":
                    self._results.append(message.result)
                case "TIMESYNC":
                    for agent in self._agents:
                        agent.hear([message], self._clock(now_us()))

    def stays(self, state: str) -> None:
        """Fails with the boat's texts if it is in another state."""
        assert self.state == state, "; ".join(self.texts[-3:])

    # The operator

    def order(self, command: int, *params: float) -> int:
        """A COMMAND_LONG; its result."""
        answered = len(self._results)
        self._say(self._gcs.pack(command_long(command, *params)))
        self.wait(lambda: len(self._results) > answered, "answer")
        return self._results[-1]

    def arm(self) -> bool:
        return self.order(ARM, 1.0) == ACCEPTED

    def disarm(self) -> None:
        assert self.order(ARM, 0.0) == ACCEPTED
        self.wait(lambda: self.state == "DISARMED", "DISARMED")

    def arm_when_it_may(self) -> None:
        """Repeat the arming command until the boat is in HOLD."""
        self._insist("HOLD", ARM, 1.0)

    def enter_formation(self) -> None:
        """Arm and set FORMATION; wait until the propellers turn."""
        self.arm_when_it_may()
        self._insist("FORMATION", SET_MODE, 1.0, FORMATION)
        self.wait(self.drives, "thrust")

    def _insist(self, state: str, command: int, *params: float) -> None:
        asked_us = 0

        def there() -> bool:
            nonlocal asked_us
            if self.state != state and now_us() - asked_us > _RETRY_US:
                asked_us = now_us()
                self._say(self._gcs.pack(command_long(command, *params)))
            return self.state == state

        self.wait(there, state)

    def drives(self) -> bool:
        """Whether an ESC commands its motor to turn."""
        t_us = now_us()
        return all(esc.command(t_us) != 0.0 for esc in self.escs)

    def rests(self) -> bool:
        """Whether all ESCs command their motors to stop."""
        t_us = now_us()
        return all(esc.command(t_us) == 0.0 for esc in self.escs)
