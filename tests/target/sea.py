# SPDX-License-Identifier: MIT
"""A sea for one boat: navigation unit, leader, ground station, two ESCs, one virtual clock."""

from __future__ import annotations

import functools
import math
from collections.abc import Iterable
from dataclasses import dataclass
from itertools import takewhile
from typing import Any

import flotilla
from hypothesis import settings

from tests.target.agent import START_US, Agent
from tests.target.bus import Esc, Frames, arming_statuses, commands
from tests.target.course import BEHIND, TURN, Course
from tests.target.stations import (
    ARM,
    BOAT,
    FORMATION,
    GCS,
    GCS_COMPONENT,
    LEADER,
    LEADER_COMPONENT,
    NAVIGATION,
    REQUEST_MESSAGE,
    SET_MODE,
    Station,
    command_long,
    decode,
    decode_named,
    origin,
    state_messages,
)

#: The published law: its gains, all extensions off.
PAPER: dict[str, float] = {
    "LAW_KX": 0.2,
    "LAW_KPSI": 0.2,
    "LAW_KDU": 10.0,
    "LAW_KDR": 10.0,
    "LAW_OBS_BW": 0.0,
    "LAW_XT_DIST": 0.0,
    "LAW_CUR_BW": 0.0,
    "LAW_U_MAX": 0.0,
    "LAW_R_MAX": 0.0,
    "LAW_REF": 0.0,
    "FS_SEP_M": 0.0,
}

#: Hypothesis with equal examples in every run.
seeded = functools.partial(settings, derandomize=True, database=None, deadline=None)


@dataclass
class Tick:
    now_us: int
    mavlink: list[tuple[int, bytes]]
    can: Frames

    @property
    def commands(self) -> tuple[int, ...]:
        return commands(self.can)

    @property
    def arming(self) -> list[int]:
        return arming_statuses(self.can)

    def messages(self, link: int = 0) -> list[Any]:
        return decode(data for at, data in self.mavlink if at == link)

    def payloads(self, message_id: int, link: int = 0) -> list[bytes]:
        """The payloads of that message, as on the wire."""
        found = []
        data = b"".join(each for at, each in self.mavlink if at == link)
        while data:
            assert data[0] == 0xFD and not data[2] & 1
            if int.from_bytes(data[7:10], "little") == message_id:
                found.append(data[10 : 10 + data[1]])
            data = data[12 + data[1] :]
        return found

    def named(self, name: str, link: int = 0) -> list[Any]:
        return decode_named((data for at, data in self.mavlink if at == link), name)


class Sea:
    """Simulates one boat tick by tick; set `on` of a sender to False to silence it.

    The boat does not move under its thrust, so by default it is near its slot: elsewhere it would
    stop after some seconds because it does not respond.
    """

    def __init__(
        self,
        parameters: dict[str, float] | None = None,
        links: int = 1,
        scalar: str = "float",
        own: Course | None = None,
        leader: Course | None = None,
        start_us: int = START_US,
    ) -> None:
        known = {"NAV_LAG_S": 0.0, "FORM_LAG_S": 0.0}  # few senders here answer TIMESYNC
        given = {"MAV_SYSID": BOAT, "FORM_LEADER": LEADER} | known | (parameters or {})
        self.boat = flotilla.Boat(given, links, scalar)
        self.period_us: int = round(1e6 / self.boat.parameters()["CTL_RATE"])
        self.now_us = start_us
        own = own or Course(1.0, 2.0, 0.3)
        leader = leader or Course(1.4, 2.2, 0.4)
        self.own = Agent(Station(BOAT, NAVIGATION), own, 50_000, beats=False, tells_fix=True)
        self.leader = Agent(Station(LEADER, LEADER_COMPONENT), leader, 100_000)
        self.gcs = Station(GCS, GCS_COMPONENT)
        port = int(self.boat.parameters()["ESC_PORT"])
        stbd = int(self.boat.parameters()["ESC_STBD"])
        self.escs = [Esc(31, port), Esc(32, stbd)]
        self.ticks: list[Tick] = []

    def step(self) -> Tick:
        """All send, the boat ticks, time advances."""
        for agent in (self.own, self.leader):
            wire = agent.wire(self.now_us)
            if wire:
                self.boat.on_mavlink(wire, self.now_us)
        for esc in self.escs:
            self.on_can(esc.frames(self.now_us))
        return self.tick_only()

    def tick_only(self) -> Tick:
        out = self.boat.tick(self.now_us)
        tick = Tick(self.now_us, list(out.mavlink), list(out.can))
        self.ticks.append(tick)
        for agent in (self.own, self.leader):
            if agent.answers_timesync and agent.on:
                agent.hear(tick.named("TIMESYNC"), self.now_us)
        self.now_us += self.period_us
        return tick

    def on_can(self, frames: Iterable[tuple[int, bytes]]) -> None:
        for can_id, data in frames:
            self.boat.on_can(can_id, data, self.now_us)

    def run(self, seconds: float) -> list[Tick]:
        return [self.step() for _ in range(round(seconds * 1e6 / self.period_us))]

    def run_until(self, state: str, seconds: float) -> None:
        for _ in range(round(seconds * 1e6 / self.period_us)):
            self.step()
            if self.state == state:
                return
        raise AssertionError(f"{self.state}, not {state}, after {seconds} s: {self.snapshot()}")

    def say(self, *messages: Any, sender: Station | None = None, link: int = 0) -> None:
        self.boat.on_mavlink((sender or self.gcs).pack(*messages), self.now_us, link)

    def order(self, command: int, *params: float, link: int = 0, **how: Any) -> Tick:
        """Send a COMMAND_LONG from the ground station; the tick after it."""
        self.say(command_long(command, *params, **how), link=link)
        return self.step()

    def ask(self, message_id: int, link: int = 0) -> list[Any]:
        """Request a message; the answers after the ACK, without the boat's regular messages."""
        ack, *others = self.order(REQUEST_MESSAGE, float(message_id), link=link).messages(link)
        assert (ack.get_type(), ack.command, ack.result) == ("COMMAND_ACK", REQUEST_MESSAGE, 0)
        return list(takewhile(lambda m: m.get_msgId() == message_id, others))

    def arm(self) -> Tick:
        return self.order(ARM, 1.0)

    def disarm(self) -> Tick:
        return self.order(ARM, 0.0)

    def mode(self, number: int) -> Tick:
        return self.order(SET_MODE, 1.0, float(number))

    def settle(self) -> None:
        """Run long enough for all ages to be known."""
        self.run(0.3)

    def silence(self, who: str) -> int:
        """Silence a sender; the time of its last message that the boat received."""
        if who == "escs":
            said = self.escs[0].sent
            while self.escs[0].sent == said:
                self.step()
            self.escs[1].on = False
        else:
            agent = getattr(self, who)
            due_us = agent.next_us
            while agent.next_us == due_us:
                self.step()
            agent.on = False
        return self.ticks[-1].now_us

    def speak_for(self, agent: Agent, kind: str) -> None:
        """Silence an agent and send its states for 0.5 s in messages of that kind."""
        agent.on = False
        for _ in range(10):
            states = state_messages(kind, agent.course, self.now_us)
            self.say(origin(self.now_us), *states, sender=agent.station)
            self.run(0.05)

    def enter_hold(self) -> None:
        self.settle()
        self.arm()
        self.step()
        assert self.state == "HOLD", self.snapshot()

    def enter_formation(self) -> None:
        self.enter_hold()
        self.mode(FORMATION)
        self.step()
        assert self.state == "FORMATION", self.snapshot()

    @property
    def state(self) -> str:
        return str(self.boat.state)

    def snapshot(self) -> dict[str, Any]:
        return dict(self.boat.snapshot())

    def counter(self, name: str) -> int:
        return int(self.snapshot()["counters"][name])

    def refused(self, bus: str) -> int:
        """The sum of the boat's counters of rejected "mavlink" or "can" input."""
        bad = ["bad_checksum", "bad_value", "bad_frame"]
        if bus == "mavlink":
            bad += ["skipped_bytes", "old_stamp"]
        return sum(self.counter(f"{bus}_{name}") for name in bad)

    def condition(self, name: str) -> bool:
        return bool(self.snapshot()["conditions"][name])

    @property
    def commands(self) -> tuple[int, ...]:
        return self.ticks[-1].commands

    def own_course(self) -> Course:
        """The boat's own state in the last pair of messages that it sent."""
        position = named(self.ticks[-30:], "LOCAL_POSITION_NED")[-1]
        turn = named(self.ticks[-30:], "ATTITUDE")[-1]
        c, s = math.cos(turn.yaw), math.sin(turn.yaw)
        u, v = c * position.vx + s * position.vy, -s * position.vx + c * position.vy
        return Course(position.x, position.y, turn.yaw, u, v, turn.yawspeed)


def at_sea(parameters: dict[str, float] | None = None) -> Sea:
    """A boat that has been in FORMATION for a second, propellers turning."""
    sea = Sea(parameters, own=BEHIND, leader=TURN)
    sea.enter_formation()
    sea.run(1.0)
    assert sea.state == "FORMATION" and all(sea.commands)
    return sea


def messages(ticks: Iterable[Tick], link: int = 0) -> list[Any]:
    return decode(data for tick in ticks for at, data in tick.mavlink if at == link)


def named(ticks: Iterable[Tick], name: str, link: int = 0) -> list[Any]:
    return decode_named((data for tick in ticks for at, data in tick.mavlink if at == link), name)


def texts(ticks: Iterable[Tick], link: int = 0) -> list[str]:
    return [m.text for m in named(ticks, "STATUSTEXT", link)]


def acks(tick: Tick, link: int = 0) -> list[tuple[int, int]]:
    return [(m.command, m.result) for m in tick.named("COMMAND_ACK", link)]


def assert_finite(value: Any) -> None:
    if isinstance(value, dict):
        for each in value.values():
            assert_finite(each)
    elif isinstance(value, float):
        assert math.isfinite(value)
