# SPDX-License-Identifier: MIT
"""A sender of states to the boat: its navigation unit or its leader."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from typing import Any

from pymavlink.dialects.v20 import common as mavlink

from tests.target.course import Course
from tests.target.stations import Station, gps, heartbeat, odometry, origin

START_US = 10_000_000


@dataclass
class Agent:
    """A sender of states: the boat's navigation unit or its leader."""

    station: Station
    course: Course
    period_us: int
    on: bool = True
    origin_on: bool = True
    beats: bool = True
    tells_fix: bool = False
    answers_timesync: bool = False
    clock_offset_us: int = 0
    delay_us: int = 0
    next_us: int = 0
    next_second_us: int = 0
    in_flight: list[tuple[int, bytes]] = field(default_factory=list)

    def clock(self, now_us: int) -> int:
        return now_us + self.clock_offset_us

    def truth(self, now_us: int) -> Course:
        return self.course.at((now_us - START_US) * 1e-6)

    def measured(self, now_us: int) -> Course:
        """The measured state: its heading varies by a microradian, as of any real instrument."""
        truth = self.truth(now_us)
        return replace(truth, psi=truth.psi + 1e-6 * (now_us // self.period_us % 3))

    def wire(self, now_us: int) -> bytes:
        """The bytes that arrive at the boat now."""
        if self.on and now_us >= self.next_us:
            self.next_us = now_us + self.period_us
            self.post(now_us, odometry(self.measured(now_us), self.clock(now_us)))
        if self.on and now_us >= self.next_second_us:
            self.next_second_us = now_us + 1_000_000
            if self.beats:
                self.post(now_us, heartbeat(mavlink.MAV_TYPE_GENERIC))
            if self.origin_on:
                self.post(now_us, origin(self.clock(now_us)))
            if self.tells_fix:
                self.post(now_us, gps())
        if not self.in_flight:
            return b""
        due = [data for at, data in self.in_flight if at <= now_us]
        self.in_flight = [(at, data) for at, data in self.in_flight if at > now_us]
        return b"".join(due)

    def post(self, now_us: int, message: Any) -> None:
        self.in_flight.append((now_us + self.delay_us, self.station.pack(message)))

    def hear(self, messages: Iterable[Any], now_us: int) -> None:
        """Answer TIMESYNC requests; request and answer each take delay_us."""
        for message in messages:
            if message.get_type() == "TIMESYNC" and message.tc1 == 0:
                heard_ns = (self.clock(now_us) + self.delay_us) * 1000
                answer = mavlink.MAVLink_timesync_message(heard_ns, message.ts1)
                self.in_flight.append((now_us + 2 * self.delay_us, self.station.pack(answer)))
