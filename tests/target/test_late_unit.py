# SPDX-License-Identifier: MIT
"""A late navigation unit without TIMESYNC: the boat's reports and refusals."""

from __future__ import annotations

import pytest

from tests.target.hull import Afloat, Hull, s_curve
from tests.target.sea import PAPER
from tests.target.test_long_texts import words


def sailing(late_s: float, law: dict[str, float], seconds: float = 25.0) -> Afloat:
    sea = Afloat(law, Hull([-2.0, 1.0, 0.3, 0.1, 0.0, 0.0]), s_curve)
    sea.own.delay_us = round(1e6 * late_s)
    sea.run(1.0)
    sea.enter_formation()
    sea.run(seconds)
    return sea


def words_of_the_unit(sea: Afloat) -> list[str]:
    return [text for text in words(sea.ticks) if "navigation" in text]


def test_the_boat_tells_how_late_its_unit_is_once() -> None:
    sea = sailing(0.2, {})
    assert sea.state == "FORMATION"
    (told,) = words_of_the_unit(sea)
    assert float(told.split()[3]) == pytest.approx(0.2, abs=0.03)
    assert told.endswith("(no TIMESYNC): compensated")


@pytest.mark.parametrize("law", [{}, {"NAV_LAG_S": 0.2}])
def test_a_prompt_unit_or_a_known_latency_causes_no_message(law: dict[str, float]) -> None:
    sea = sailing(law.get("NAV_LAG_S", 0.0), law)
    assert sea.state == "FORMATION" and words_of_the_unit(sea) == []


def test_a_unit_that_is_too_late_leads_to_hold_and_formation_is_refused_with_the_reason() -> None:
    sea = sailing(0.42, {})
    assert sea.state == "HOLD"
    assert any("navigation latency is too high" in text for text in words_of_the_unit(sea))


def test_the_known_latency_counts_as_age() -> None:
    ages = [
        sailing(0.0, {"NAV_LAG_S": lag_s, **PAPER}, 1.0).boat.snapshot()["own_age_s"]
        for lag_s in (0.0, 0.15)
    ]
    assert ages[1] - ages[0] == pytest.approx(0.15, abs=1e-5)
