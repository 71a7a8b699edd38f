# SPDX-License-Identifier: MIT
"""Radios and units with varying delay: checks that no boat is driven by states that are too old.

    python -m tests.loop.late_radio --runs 1000

Each run has a sender that answers TIMESYNC, the leader or the own unit, and paths both ways with
drawn delays: from 0 to 10 s, from the start, in steps, slowly, both ways or one, in order or not.
In half of the runs the sender's clock is also set once, or runs fast or slow.
An operator requests FORMATION all the time. The harness knows the true age of each state.
"""

import argparse
import math
import sys
from collections.abc import Iterable
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from random import Random
from typing import Any

from pymavlink.dialects.v20 import common as mavlink
from rich.console import Console
from rich.progress import track

from tests.target.agent import START_US, Agent
from tests.target.course import Course
from tests.target.sea import Sea
from tests.target.stations import FORMATION

DELAYS_S = (0.0, 0.1, 0.3, 1.0, 3.0, 10.0)
CLOCK_SET_S = (0.0, 0.0, 0.9, 1.9, 9.9, -0.9, -9.9)
DRIFTS = (0.0, 0.0, 0.001, 0.01, -0.001)
DURATION_S = 60.0
RUNNING = ("FORMATION", "COAST")


@dataclass(frozen=True)
class Way:
    """One direction: its delay is `before_s` until `at_s`, and `slope_s` later `after_s`."""

    before_s: float
    after_s: float
    at_s: float
    slope_s: float
    in_order: bool

    def delay_us(self, now_us: int) -> int:
        gone_s = 1e-6 * (now_us - START_US) - self.at_s
        share = min(max(gone_s / self.slope_s, 0.0), 1.0)
        return round(1e6 * (self.before_s + share * (self.after_s - self.before_s)))

    @classmethod
    def drawn(cls, random: Random) -> "Way":
        steps = random.random() < 0.5
        return cls(
            random.choice(DELAYS_S),
            random.choice(DELAYS_S),
            random.uniform(0.0, 0.6 * DURATION_S),
            0.01 if steps else random.uniform(1.0, 30.0),
            random.random() < 0.5,
        )


class LateAgent(Agent):
    """A sender behind two paths; `newest_us`: true time of the newest state that arrived."""

    to: Way
    fro: Way
    newest_us: int = -1
    drift: float = 0.0
    set_s: float = 0.0
    set_at_us: int = 0

    def __init__(self, plain: Agent) -> None:
        super().__init__(plain.station, plain.course, plain.period_us, beats=plain.beats)
        self.tells_fix = plain.tells_fix
        self.answers_timesync = plain.answers_timesync
        self.asked: list[tuple[int, int]] = []
        self.told: list[tuple[int, int]] = []
        self.last_us = self.last_asked_us = 0

    def clock(self, now_us: int) -> int:
        drifted_us = round(self.drift * (now_us - START_US))
        set_us = round(1e6 * self.set_s) if now_us >= self.set_at_us else 0
        return super().clock(now_us) + drifted_us + set_us

    def post(self, now_us: int, message: Any) -> None:
        at_us = now_us + self.to.delay_us(now_us)
        if self.to.in_order:
            at_us = self.last_us = max(at_us, self.last_us)
        self.in_flight.append((at_us, self.station.pack(message)))
        if message.get_type() == "ODOMETRY":
            self.told.append((at_us, now_us))

    def hear(self, messages: Iterable[Any], now_us: int) -> None:
        at_us = now_us + self.fro.delay_us(now_us)
        for message in messages:
            if message.get_type() == "TIMESYNC" and message.tc1 == 0:
                if self.fro.in_order:
                    at_us = self.last_asked_us = max(at_us, self.last_asked_us)
                self.asked.append((at_us, message.ts1))

    def wire(self, now_us: int) -> bytes:
        for at_us, ts1 in self.asked:
            if at_us <= now_us:
                answer = mavlink.MAVLink_timesync_message(max(1000 * self.clock(now_us), 1), ts1)
                self.post(now_us, answer)
        self.asked = [(at_us, ts1) for at_us, ts1 in self.asked if at_us > now_us]
        data = super().wire(now_us)
        arrived = [true_us for at_us, true_us in self.told if at_us <= now_us]
        self.newest_us = max([self.newest_us, *arrived])
        self.told = [(at_us, true_us) for at_us, true_us in self.told if at_us > now_us]
        return data


@dataclass(frozen=True)
class Ended:
    """`oldest_s`: true age of the newest state heard while the law drove the boat, `limit_s`: its
    parameter; `wrong_s`: by how much the age told fell short of that age meanwhile; `driven_s`."""

    seed: int
    who: str
    limit_s: float
    oldest_s: float
    wrong_s: float
    driven_s: float

    @property
    def broke(self) -> bool:
        return self.oldest_s > self.limit_s + 0.02  # a tick to notice it, and one to stop


def sailed(seed: int, answers: bool = True) -> Ended:
    """One random run; if the sender does not answer, its latency is configured as 0."""
    random = Random(seed)
    who = random.choice(("leader", "own"))
    lag_s = -1.0 if answers else 0.0
    given = {"NAV_LAG_S": lag_s, "FORM_LAG_S": lag_s, "FS_LEADER_ACT": random.choice((0.0, 1.0))}
    sea = Sea(given, leader=Course(5.0, 5.0, 0.5, 0.3))
    sea.own.answers_timesync = sea.leader.answers_timesync = answers
    plain = getattr(sea, who)
    late = LateAgent(plain)
    late.clock_offset_us = random.randrange(-5_000_000, 10_000_000_000)
    ways = Way.drawn(random), Way.drawn(random)
    still = replace(Way.drawn(random), before_s=0.0, after_s=0.0)
    late.to, late.fro = random.choice(
        [ways, (ways[0], ways[0]), (ways[0], still), (still, ways[1])]
    )
    if answers and random.random() < 0.5:
        late.set_s, late.drift = random.choice(CLOCK_SET_S), random.choice(DRIFTS)
        late.set_at_us = START_US + round(1e6 * random.uniform(0.0, 0.6 * DURATION_S))
    setattr(sea, who, late)
    limit_s = sea.boat.parameters()["FS_LEADER_S" if who == "leader" else "FS_NAV_S"]
    judged = RUNNING[:1] if who == "leader" else RUNNING
    oldest_s = wrong_s = driven_s = 0.0
    for tick in range(round(100 * DURATION_S)):
        if tick % 100 == 50:
            sea.arm() if sea.state == "DISARMED" else sea.mode(FORMATION)
        sea.step()
        if tick % 100 == 0:
            sea.ticks.clear()
            sea.step()
        if sea.state not in judged or not any(sea.commands):
            continue
        driven_s += 0.01
        true_s = 1e-6 * (sea.ticks[-1].now_us - late.newest_us)
        oldest_s = max(oldest_s, true_s)
        told_s = sea.snapshot()[f"{who}_age_s"]
        wrong_s = max(wrong_s, true_s - (math.inf if told_s is None else told_s))
    return Ended(seed, who, limit_s, oldest_s, wrong_s, driven_s)


def main() -> int:
    """Exit status: 0 if no boat was driven by a state that was too old."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=int, default=1000, help="(1000)")
    options = parser.parse_args()
    with ProcessPoolExecutor() as pool:
        runs = pool.map(sailed, range(1, options.runs + 1), chunksize=4)
        bar = track(runs, total=options.runs, console=Console(stderr=True))
        ended = list(bar)
    broke = [one for one in ended if one.broke]
    drove = [one for one in ended if one.driven_s > 0.0]
    print(f"{len(broke)} of {len(ended)} boats were driven by states older than the limit")
    print(f"{len(drove)} were driven at all, for {sum(one.driven_s for one in drove):.0f} s")
    for who in ("leader", "own"):
        of = [one for one in drove if one.who == who]
        oldest = max((one.oldest_s / one.limit_s for one in of), default=0.0)
        wrong_s = max((one.wrong_s for one in of), default=0.0)
        print(f"{who}: oldest {oldest:.2f} of its limit; told up to {wrong_s:.2f} s too young")
    for one in broke[:10]:
        print(one)
    return int(bool(broke))


if __name__ == "__main__":
    sys.exit(main())
