# SPDX-License-Identifier: MIT
"""The law neither follows nor steers by states of unknown or too great age."""

from __future__ import annotations

import math
from typing import Any

import pytest
from pymavlink.dialects.v20 import common as mavlink

from tests.target.agent import Agent
from tests.target.course import Course
from tests.target.hull import Afloat, Hull, s_curve
from tests.target.operator_words import drive, param_set
from tests.target.sea import Sea, texts
from tests.target.stations import FORMATION, MANUAL

UNKNOWN = {"NAV_LAG_S": -1.0, "FORM_LAG_S": -1.0}
NAV_UNKNOWN = "navigation lag unknown: set NAV_LAG_S"
LEADER_UNKNOWN = "leader latency unknown: set FORM_LAG_S"


def prompt_sea(**parameters: float) -> Sea:
    """A sea whose two senders answer TIMESYNC at once; no latency is configured."""
    sea = Sea(UNKNOWN | parameters, leader=Course(5.0, 5.0, 0.5, 0.5))
    sea.own.answers_timesync = sea.leader.answers_timesync = True
    return sea


def asked_for_formation(sea: Sea, agent: Agent, late_s: float) -> list[str]:
    """Ask for FORMATION, with time for TIMESYNC answers; the boat's texts meanwhile."""
    agent.delay_us = round(1e6 * late_s)
    sea.run(2.5 * late_s + 4.0)
    sea.arm()
    sea.mode(FORMATION)
    for _ in range(500):
        sea.step()
        assert sea.state != "FORMATION" and not any(sea.commands)
    return texts(sea.ticks)


@pytest.mark.parametrize("late_s", [1.0, 2.4, 3.0, 10.0, 15.0])
def test_the_age_of_a_leader_that_is_late_from_its_start_is_known_from_its_answers(
    late_s: float,
) -> None:
    sea = prompt_sea()
    said = asked_for_formation(sea, sea.leader, late_s)
    assert "Refused: leader lost or origin unknown" in said
    assert sea.condition("leader_timed")
    assert sea.snapshot()["leader_age_s"] == pytest.approx(late_s + 0.05, abs=0.07)


@pytest.mark.parametrize("late_s", [0.6, 3.0, 10.0])
def test_an_own_unit_that_was_late_from_its_start_leaves_manual_only(late_s: float) -> None:
    sea = prompt_sea()
    said = asked_for_formation(sea, sea.own, late_s)
    assert "armed, no FORMATION: no recent navigation data" in said
    assert sea.snapshot()["own_age_s"] == pytest.approx(late_s + 0.025, abs=0.04)


@pytest.mark.parametrize("late_s", [0.0, 3.0, 20.0])
@pytest.mark.parametrize("who", ["own", "leader"])
def test_the_age_of_a_sender_that_answers_nothing_or_too_late_is_unknown(
    who: str, late_s: float
) -> None:
    """Half a minute later an answer can no longer be assigned to its request."""
    sea = prompt_sea()
    agent = getattr(sea, who)
    agent.answers_timesync = late_s == 20.0
    said = asked_for_formation(sea, agent, late_s)
    why = NAV_UNKNOWN if who == "own" else LEADER_UNKNOWN
    assert said.count(why) >= 1, "told while disarmed"
    assert f"Refused: {why}" in said
    assert sea.snapshot()[f"{who}_age_s"] is None


@pytest.mark.parametrize("who", ["own", "leader"])
def test_a_latency_set_as_a_parameter_is_used(who: str) -> None:
    sea = prompt_sea()
    agent = getattr(sea, who)
    agent.answers_timesync, agent.delay_us = False, 200_000
    sea.run(3.0)
    sea.say(param_set("NAV_LAG_S" if who == "own" else "FORM_LAG_S", 0.2))
    sea.run(1.0)
    sea.enter_formation()
    age_s = sea.snapshot()[f"{who}_age_s"]
    assert age_s == pytest.approx(0.2 + 0.5e-6 * agent.period_us, abs=0.06)


class OtherClock(Agent):
    """A sender whose TIMESYNC and time stamps are of different clocks."""

    ahead_us = 0

    def hear(self, messages: Any, now_us: int) -> None:
        for m in messages:
            if m.get_type() == "TIMESYNC" and m.tc1 == 0:
                read_ns = 1000 * (self.clock(now_us) + self.ahead_us)
                self.post(now_us, mavlink.MAVLink_timesync_message(max(read_ns, 1), m.ts1))


@pytest.mark.parametrize("ahead_s", [1.7e9, 50.0, -0.5, -9.0])
def test_a_leader_whose_answers_contradict_its_stamps_has_an_unknown_age(ahead_s: float) -> None:
    sea = prompt_sea()
    sea.leader.__class__ = OtherClock
    sea.leader.ahead_us = round(1e6 * ahead_s)  # type: ignore[attr-defined]
    said = asked_for_formation(sea, sea.leader, 0.0)
    assert f"Refused: {LEADER_UNKNOWN}" in said


@pytest.mark.parametrize("who", ["own", "leader"])
def test_a_latency_set_as_a_parameter_is_not_used_for_senders_with_contradictory_answers(
    who: str,
) -> None:
    """Its answers contradict its stamps; from then on the radio is three seconds late."""
    sea = prompt_sea(NAV_LAG_S=0.0, FORM_LAG_S=0.0)
    agent = getattr(sea, who)
    agent.__class__ = OtherClock
    agent.ahead_us = -500_000
    sea.run(5.0)
    agent.delay_us = 3_000_000
    said = asked_for_formation(sea, agent, 3.0)
    reasons = ("latency unknown", "no recent navigation data", "leader lost")
    assert any(any(why in text for why in reasons) for text in said)


def test_a_boat_coasts_when_its_leaders_answers_begin_to_contradict_its_stamps() -> None:
    sea = prompt_sea()
    sea.run(2.0)
    sea.enter_formation()
    sea.leader.__class__ = OtherClock
    sea.leader.ahead_us = -2_000_000  # type: ignore[attr-defined]
    sea.run(2.0)
    assert sea.state == "COAST" and not sea.condition("leader_timed")
    assert any(t.startswith(f"COAST: {LEADER_UNKNOWN}") for t in texts(sea.ticks))
    sea.leader.__class__ = Agent
    sea.run(2.0)
    assert sea.state == "FORMATION"


def test_turning_in_manual_measures_the_unknown_latency_of_the_own_unit() -> None:
    sea = Afloat(UNKNOWN | {"FORM_LAG_S": 0.0}, Hull(), s_curve)
    sea.own.delay_us = 150_000
    sea.run(1.0)
    sea.enter_hold()
    drive(sea, 0)
    sea.mode(MANUAL)
    for k in range(400):
        drive(sea, 200, 300 if math.sin(0.5 * k) * math.sin(0.17 * k + 1.0) > 0.0 else -300, 0.15)
        assert sea.state == "MANUAL"
        if sea.condition("own_timed"):
            break
    assert sea.condition("own_timed"), "not within a minute"
    assert sea.snapshot()["own_age_s"] < 0.4
