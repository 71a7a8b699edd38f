# SPDX-License-Identifier: MIT
"""A flotillad process and its surroundings, in real time, in one loop that waits on sockets.

Tests wait for conditions with generous deadlines; nothing depends on exact timing. The boat's
clock and all others are CLOCK_MONOTONIC.
"""

from __future__ import annotations

import os
import pty
import select
import signal
import socket
import subprocess
import time
import tty
from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any, NamedTuple, Protocol, Self

import can
from pymavlink.dialects.v20 import common as mavlink

from sil.live.ordinary_user import ordinary_user
from sil.live.parameter_file import set_up
from sil.wire.esc_node import EscNode
from sil.wire.heartbeat import state_of
from tests.dialect import dialect
from tests.flotillad import FLOTILLAD
from tests.target.agent import Agent
from tests.target.bus import ARMING_STATUS, RAW_COMMAND, Frames, commands, type_of
from tests.target.course import TURN, Course
from tests.target.stations import (
    ARM,
    ARMED_BIT,
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
)

ROOT = Path(__file__).parents[2]
LOOPBACK = "127.0.0.1"
STORAGE = mavlink.MAV_CMD_PREFLIGHT_STORAGE

#: The boat's ids, and time limits that a loaded machine can keep.
PATIENT = {
    "MAV_SYSID": BOAT,
    "FORM_LEADER": LEADER,
    "FS_NAV_S": 2.0,
    "FS_LEADER_S": 5.0,
    "FS_ESC_S": 3.0,
    "NAV_LAG_S": 0.0,  # no sender answers TIMESYNC
    "FORM_LAG_S": 0.0,
}

_PATIENCE_S = 20.0
_BEAT_S = 0.01
_REPEAT_US = 200_000


def now_us() -> int:
    return time.monotonic_ns() // 1000


class End(Protocol):
    """The other end of a MAVLink link of flotillad."""

    option: str

    def fileno(self) -> int: ...
    def receive(self) -> list[bytes]: ...
    def send(self, data: bytes) -> None: ...
    def close(self) -> None: ...


class Udp:
    """Sends to the last sender, or to `port` of this machine if given."""

    def __init__(self, port: int | None = None, at: str = LOOPBACK) -> None:
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.bind((at, 0))
        self.socket.setblocking(False)
        self.peer = (LOOPBACK, port) if port else None
        own = self.socket.getsockname()[1]
        self.option = f"udpin:{LOOPBACK}:{port}" if port else f"udpout:{LOOPBACK}:{own}"

    def fileno(self) -> int:
        return self.socket.fileno()

    def receive(self) -> list[bytes]:
        chunks = []
        with suppress(BlockingIOError):
            while True:
                data, self.peer = self.socket.recvfrom(4096)
                chunks.append(data)
        return chunks

    def send(self, data: bytes) -> None:
        if self.peer is not None:
            self.socket.sendto(data, self.peer)

    def close(self) -> None:
        self.socket.close()


def broadcast_listener() -> Udp:
    end = Udp(at="127.255.255.255")
    end.option = f"udpbcast:127.255.255.255:{end.socket.getsockname()[1]}"
    return end


class Serial:
    """A serial cable; its end `device`, for flotillad, exists while this is open."""

    def __init__(self, device: Path, baud: int = 57600) -> None:
        self._master, self._slave = pty.openpty()
        tty.setraw(self._slave)
        os.set_blocking(self._master, False)
        self._device = device
        device.symlink_to(os.ttyname(self._slave))
        self.option = f"serial:{device}:{baud}"

    def fileno(self) -> int:
        return self._master

    def receive(self) -> list[bytes]:
        chunks = []
        with suppress(BlockingIOError):
            while data := os.read(self._master, 4096):
                chunks.append(data)
        return chunks

    def send(self, data: bytes) -> None:
        with suppress(BlockingIOError):
            os.write(self._master, data)

    def close(self) -> None:
        self._device.unlink()
        os.close(self._slave)
        os.close(self._master)


class CanFrame(NamedTuple):
    heard_us: int
    can_id: int
    data: bytes


class Flotillad:
    """The process; its output goes to a file, or to the descriptor `mouth`."""

    def __init__(
        self,
        folder: Path,
        options: Sequence[str],
        environment: dict[str, str] | None = None,
        prefix: Sequence[str] = (),
        mouth: int | None = None,
        program: Path = FLOTILLAD,
    ) -> None:
        self._words = folder / "words"
        with self._words.open("wb") as words:
            self.process = subprocess.Popen(
                [*prefix, *ordinary_user(), program, *options],
                stdin=subprocess.DEVNULL,
                stdout=words,
                stderr=words if mouth is None else mouth,
                env={**os.environ, **(environment or {})},
            )

    @property
    def pid(self) -> int:
        return self.process.pid

    @property
    def words(self) -> str:
        return self._words.read_text()

    @property
    def status(self) -> int | None:
        return self.process.poll()

    def signal(self, number: signal.Signals) -> None:
        self.process.send_signal(number)

    def close(self) -> None:
        if self.status is None:
            self.process.kill()
        self.process.wait()


class RealSea:
    """One flotillad, navigation unit, leader, ESCs and operator; `on` = False silences a sender.

    The navigation unit is at the first link's end, leader and operator are at the last one's.
    """

    def __init__(self, bus: int, folder: Path) -> None:
        self.bus = bus
        self.folder = folder
        self.program = FLOTILLAD
        self.state_dir = folder / "state"
        self.set_up = True  # parameters were saved before the first start
        self.boat: Flotillad | None = None
        self.can = can.Bus(interface="mcast", channel=str(bus))
        self.own = Agent(Station(BOAT, NAVIGATION), Course(1.0, 2.0, 0.3), 50_000, beats=False)
        self.leader = Agent(Station(LEADER, LEADER_COMPONENT), TURN, 100_000)
        self.gcs = Station(GCS, GCS_COMPONENT)
        self.escs = [EscNode(31, 0), EscNode(32, 1)]
        self.escs_on = True
        self.ends: list[End] = [Udp()]
        self._leaving = False
        self.forget()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        if self.boat is not None:
            self.boat.close()
        self.can.shutdown()
        for end in self.ends:
            end.close()

    def connect(self, *ends: End) -> None:
        """Replace the UDP link by other links."""
        for end in self.ends:
            end.close()
        self.ends = list(ends)
        self.forget()

    def forget(self) -> None:
        """Discard everything received so far."""
        self.heard: list[CanFrame] = []
        self.messages: list[list[Any]] = [[] for _ in self.ends]
        self.bytes_heard = [0 for _ in self.ends]
        self._parsers = [dialect().MAVLink(None) for _ in self.ends]
        for parser in self._parsers:
            parser.robust_parsing = True

    def start(
        self,
        *options: str,
        param: dict[str, float] | None = None,
        environment: dict[str, str] | None = None,
        prefix: Sequence[str] = (),
        mouth: int | None = None,
    ) -> None:
        """Start a flotillad, ending a running one first; `param` replaces PATIENT."""
        if self.boat is not None:
            self.boat.close()
        if self.set_up:
            set_up(self.state_dir, {})
        self._listen()
        self.forget()
        given = [f"--can=mcast:{self.bus}", f"--state-dir={self.state_dir}"]
        given += [f"--mavlink={option}" for option in dict.fromkeys(e.option for e in self.ends)]
        values = PATIENT if param is None else param
        given += [f"--param={name}={value}" for name, value in values.items()]
        self._leaving = False
        self.boat = Flotillad(
            self.folder, [*given, *options], environment, prefix, mouth, self.program
        )

    @property
    def process(self) -> Flotillad:
        assert self.boat is not None
        return self.boat

    # -- time

    def until(self, happened: Callable[[], object], seconds: float = _PATIENCE_S) -> None:
        """Simulate until the event; fails after `seconds`."""
        deadline_us = now_us() + round(1e6 * seconds)
        while not happened():
            if now_us() > deadline_us:
                raise AssertionError(f"not within {seconds} s; {self._story()}")
            if self.boat is not None and self.boat.status is not None and not self._leaving:
                raise AssertionError(f"left by itself; {self._story()}")
            self._go_on()

    def run(self, seconds: float) -> None:
        end_us = now_us() + round(1e6 * seconds)
        while now_us() < end_us:
            self._go_on()

    def _story(self) -> str:
        beats = self.named("HEARTBEAT", -1)[-1:]
        return (
            f"{len(self.heard)} frames, last command {self.raw_commands()[-1:]}, "
            f"{[len(each) for each in self.messages]} messages, {beats}, texts {self.texts()}, "
            f"status {self.process.status}, words: {self.process.words}"
        )

    def _go_on(self) -> None:
        waits: list[Any] = [self.can, *self.ends]
        select.select(waits, [], [], _BEAT_S)
        self._listen()
        self._speak()

    def _listen(self) -> None:
        at_us = now_us()
        while (message := self.can.recv(0.0)) is not None:
            frame = CanFrame(at_us, message.arbitration_id, bytes(message.data))
            self.heard.append(frame)
            for esc in self.escs:
                esc.on_can(frame.can_id, frame.data, at_us)
        for i, end in enumerate(self.ends):
            for data in end.receive():
                self.bytes_heard[i] += len(data)
                self.messages[i] += self._parsers[i].parse_buffer(data) or []

    def _speak(self) -> None:
        at_us = now_us()
        for agent, link in ((self.own, 0), (self.leader, -1)):
            if wire := agent.wire(at_us):
                self.ends[link].send(wire)
        for esc in self.escs if self.escs_on else []:
            for can_id, data in esc.tick(at_us, 0.0, 24.0, float("nan")):
                self.send_can(can_id, data)

    # -- the operator, and others who speak

    def say(self, *messages: Any, link: int = -1) -> None:
        self.ends[link].send(self.gcs.pack(*messages))

    def send_can(self, can_id: int, data: bytes) -> None:
        self.can.send(can.Message(arbitration_id=can_id, data=data))

    def repeat(self, ask: Callable[[], object], happened: Callable[[], object]) -> None:
        """Repeat a request five times a second until the event."""
        asked_us = 0

        def asked() -> object:
            nonlocal asked_us
            if now_us() >= asked_us + _REPEAT_US:
                asked_us = now_us()
                ask()
            return happened()

        self.until(asked)

    def insist(self, happened: Callable[[], object], command: int, *params: float) -> None:
        """Repeat the operator's command until the event."""
        self.repeat(lambda: self.say(command_long(command, *params)), happened)

    def arm(self) -> None:
        self.insist(lambda: self.armed, ARM, 1.0)

    def enter_formation(self) -> None:
        """Enter FORMATION from any state; wait until the propellers turn."""
        self.arm()
        self.insist(lambda: self.state == "FORMATION", SET_MODE, 1.0, float(FORMATION))
        self.until(self.driven)

    def save_parameters(self) -> None:
        self.insist(lambda: "saved (on request)" in self.process.words, STORAGE, 1.0)

    def set_parameter(self, name: str, value: float) -> None:
        """Set a parameter; wait until the boat confirms it."""
        asked = mavlink.MAVLink_param_set_message(
            BOAT, 0, name.encode(), value, mavlink.MAV_PARAM_TYPE_REAL32
        )

        def done() -> bool:
            told = [m for m in self.named("PARAM_VALUE") if m.param_id == name]
            return bool(told) and told[-1].param_value == value

        self.repeat(lambda: self.say(asked), done)

    def end(self, number: signal.Signals = signal.SIGTERM) -> int:
        """Terminate the flotillad and read its output to the end; its exit status."""
        self._leaving = True
        self.process.signal(number)
        self.until(lambda: self.process.status is not None)
        self._listen()
        status = self.process.status
        assert status is not None
        return status

    # -- what was heard

    def ready(self) -> bool:
        """Whether it ticks and has been heard on every link."""
        return bool(self.heard) and all(self.messages)

    def named(self, name: str, link: int = -1) -> list[Any]:
        return [m for m in self.messages[link] if m.get_type() == name]

    @property
    def armed(self) -> bool:
        beats = self.named("HEARTBEAT")
        return bool(beats and beats[-1].base_mode & ARMED_BIT)

    @property
    def state(self) -> str | None:
        for beat in self.named("HEARTBEAT")[-1:]:
            return state_of(beat.custom_mode, beat.base_mode, beat.system_status)
        return None

    def texts(self, link: int = -1) -> list[str]:
        return [m.text for m in self.named("STATUSTEXT", link)]

    def acks(self, link: int = -1) -> list[tuple[int, int]]:
        return [(m.command, m.result) for m in self.named("COMMAND_ACK", link)]

    def frames(self, *types: int) -> Frames:
        """The message frames of these types, or all frames."""
        wanted = {(False, each) for each in types}
        return [
            (can_id, data)
            for _, can_id, data in self.heard
            if not types or type_of(can_id)[:2] in wanted
        ]

    def raw_commands(self) -> list[tuple[int, ...]]:
        return [commands([frame]) for frame in self.frames(RAW_COMMAND)]

    def arming(self) -> list[int]:
        """The ArmingStatus values: one byte, then the tail byte."""
        return [data[0] for _, data in self.frames(ARMING_STATUS)]

    def driven(self) -> bool:
        """Whether an ESC commands its motor to turn."""
        return any(esc.command(now_us()) for esc in self.escs)

    def source_node(self) -> int:
        return self.heard[-1].can_id & 0x7F
