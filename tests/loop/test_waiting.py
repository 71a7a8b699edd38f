# SPDX-License-Identifier: MIT
"""LOITER against current, wind and gusts, for five minutes; for twenty with --all."""

import pytest

from tests.each_push import few
from tests.loop.waiting import WEATHERS, wait

EACH_PUSH = ["current from the quarter", "current, wind and gusts across"]


@pytest.mark.parametrize(
    "minutes", [5.0, pytest.param(20.0, marks=pytest.mark.nightly)], ids=["short", "whole"]
)
@pytest.mark.parametrize("weather", few(WEATHERS, EACH_PUSH))
def test_a_boat_keeps_its_place_bow_into_the_drift_with_hardly_more_thrust_than_it_needs(
    weather: str, minutes: float
) -> None:
    it = wait(weather, minutes)
    assert it.state == "LOITER"
    assert it.worst_m < 0.5  # asked for: 1.5
    assert it.mean_m < 0.12
    assert it.bow_rad < 0.3
    assert it.thrust < 1.3
