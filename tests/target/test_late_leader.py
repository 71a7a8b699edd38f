# SPDX-License-Identifier: MIT
"""A leader on the paper's S-curve, heard over a radio that delays, loses, repeats and reorders."""

from __future__ import annotations

import math
import random
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any

import pytest
from pymavlink.dialects.v20 import common as mavlink

from tests.target.course import Course
from tests.target.hull import Afloat, Helmsman, Hull, s_curve
from tests.target.sea import Sea
from tests.target.stations import FORMATION


@dataclass
class OverRadio(Helmsman):
    """A sender over a radio: 30 % of its messages are lost, 20 % duplicated; delays vary."""

    dice: random.Random = field(default_factory=random.Random)
    delays_us: tuple[int, int] = (0, 0)

    def delay(self) -> int:
        return self.dice.randint(*self.delays_us)

    def lost(self) -> bool:
        return self.dice.random() < 0.3

    def post(self, now_us: int, message: Any) -> None:
        if self.lost():
            return
        data = self.station.pack(message)
        for _ in range(2 if self.dice.random() < 0.2 else 1):
            self.in_flight.append((now_us + self.delay(), data))

    def hear(self, messages: Iterable[Any], now_us: int) -> None:
        for message in messages:
            if message.get_type() == "TIMESYNC" and message.tc1 == 0 and not self.lost():
                read_us = now_us + self.delay()
                answer = mavlink.MAVLink_timesync_message(self.clock(read_us) * 1000, message.ts1)
                self.post(read_us, answer)


def followed(period_us: int, delays_us: tuple[int, int], seed: int) -> Afloat:
    """A boat in FORMATION for ten seconds; the leader's clock is seven hours ahead."""
    hull = Hull([1.46, 0.45, 1.33, 0.0, 0.0, 0.0])
    sea = Afloat({"FS_LEADER_S": 5.0}, hull, s_curve, own_period_us=10_000)
    sea.leader = OverRadio(
        sea.leader.station,
        Course(),
        period_us,
        answers_timesync=True,
        clock_offset_us=7 * 3_600_000_000,
        dice=random.Random(seed),
        delays_us=delays_us,
        hull=Hull(),
    )
    sea.run(6.0)
    sea.enter_hold()
    sea.run(0.3)
    sea.mode(FORMATION)
    sea.run(10.0)
    return sea


def off(sea: Afloat) -> tuple[float, float]:
    """After one tick, the error of the leader's estimated position and heading."""
    now = sea.off_slot()
    sea.step()
    assert sea.state == "FORMATION"
    thought = sea.snapshot()["error"]
    return (
        math.hypot(thought["x_m"] - now[0], thought["y_m"] - now[1]),
        abs(thought["psi_rad"] - now[2]),
    )


# one draw of losses and delays for each push
@pytest.mark.parametrize("seed", [0, *(pytest.param(k, marks=pytest.mark.nightly) for k in (1, 2))])
@pytest.mark.parametrize("delays_us", [(0, 200_000), (100_000, 300_000)])
@pytest.mark.parametrize("period_us", [200_000, 100_000, 20_000])
def test_the_leader_is_known_to_centimetres(
    period_us: int, delays_us: tuple[int, int], seed: int
) -> None:
    """At 0.6 m/s and 0.3 s latency; and never worse than the boat's own estimate."""
    sea = followed(period_us, delays_us, seed)
    for _ in range(3000):
        metres, radians = off(sea)
        assert metres < 0.02 and radians < 0.02
        assert metres < sea.snapshot()["leader_uncertainty_m"] + 0.003
    assert sea.counter("mavlink_old_stamp") > 0
    assert math.hypot(*sea.off_slot()[:2]) < 0.02


def test_three_overtaken_messages_do_not_shift_the_leaders_estimated_clock() -> None:
    """The latency is 0.2 s, except for one message with 0.16 s; TIMESYNC is always answered."""
    sea = Sea(leader=Course(5.0, 5.0, 0.5, 1.0, 0.0, 0.0))
    sea.leader.answers_timesync, sea.leader.delay_us, sea.leader.period_us = True, 200_000, 10_000
    sea.run(3.5)
    sea.leader.delay_us -= 40_000
    sea.step()
    sea.leader.delay_us += 40_000
    for _ in range(40):
        tick = sea.step()
        ahead, abeam, _ = sea.own.truth(0).minus(sea.leader.truth(tick.now_us))
        error = sea.snapshot()["error"]
        assert math.hypot(error["x_m"] - ahead, error["y_m"] - abeam) < 0.05
    assert sea.counter("mavlink_old_stamp") == 3
