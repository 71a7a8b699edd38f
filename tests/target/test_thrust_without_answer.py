# SPDX-License-Identifier: MIT
"""Propellers without thrust or with reversed thrust: the boat detects the missing response."""

from __future__ import annotations

import pytest

from tests.target.hull import Afloat, Hull, s_curve
from tests.target.sea import PAPER, texts
from tests.target.stations import FORMATION


class Faulty(Afloat):
    """A sea whose propellers give only a share of the commanded thrust."""

    shares = (1.0, 1.0)

    def obeyed(self, commands: tuple[int, ...]) -> tuple[int, ...]:
        return tuple(round(s * c) for s, c in zip(self.shares, commands, strict=True))


def sailing(law: dict[str, float]) -> Faulty:
    sea = Faulty(law, Hull([-2.0, 1.0, 0.3, 0.1, 0.0, 0.0]), s_curve)
    sea.enter_formation()
    sea.run(20.0)
    assert sea.state == "FORMATION"
    return sea


def stops_after(sea: Faulty) -> float:
    since_us = sea.now_us
    while sea.state == "FORMATION":
        sea.step()
        assert sea.now_us - since_us < 10_000_000
    return (sea.now_us - since_us) * 1e-6


LAWS = pytest.mark.parametrize("law", [{}, PAPER, {"LAW_OBS_BW": 0.0}], ids=["", "paper", "0"])


@LAWS
@pytest.mark.parametrize("shares", [(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0)])
def test_a_propeller_that_turns_the_other_way_is_seen_within_three_seconds(
    shares: tuple[float, float], law: dict[str, float]
) -> None:
    sea = sailing(law)
    sea.shares = shares
    assert stops_after(sea) < 3.0
    assert sea.state == "HOLD" and sea.commands == (0, 0)
    assert any("does not respond" in text for text in texts(sea.ticks))


@LAWS
@pytest.mark.parametrize("shares", [(0.0, 0.0), (0.0, 1.0), (1.0, 0.0)])
def test_a_propeller_that_gives_nothing_is_seen_within_five_seconds(
    shares: tuple[float, float], law: dict[str, float]
) -> None:
    sea = sailing(law)
    sea.shares = shares
    assert stops_after(sea) < 5.0
    assert sea.state == "HOLD" and not sea.condition("boat_answers")


def test_formation_is_accepted_again_after_the_propellers_rested() -> None:
    sea = sailing({})
    sea.shares = (-1.0, -1.0)
    stops_after(sea)
    sea.shares = (1.0, 1.0)
    sea.run(10.0)
    assert sea.condition("boat_answers") and sea.state == "HOLD"
    sea.mode(FORMATION)
    sea.run(20.0)
    assert sea.state == "FORMATION"


@pytest.mark.parametrize("current", [(0.5, 0.0), (-0.5, 0.3)])
def test_a_current_is_not_taken_for_missing_thrust(current: tuple[float, float]) -> None:
    sea = Faulty({}, Hull([-2.0, 1.0, 0.3, 0.0, 0.0, 0.0], current=current), s_curve)
    sea.enter_formation()
    sea.run(60.0)
    assert sea.state == "FORMATION" and sea.condition("boat_answers")
