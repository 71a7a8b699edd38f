# SPDX-License-Identifier: MIT
"""A boat sails its plan and three others follow: the page's figures, and their limits."""

from functools import cache

import pytest

from sil.rivals.routes import ROUTES
from tests import measurements
from tests.each_push import few
from tests.loop.leading import Sailed, sail

EACH_PUSH = ["sharp angles"]


@cache
def sailed(name: str, weather: str) -> Sailed:
    # as long as on the page, where all are sailed together: `closest` counts beyond the arrival
    return sail([name], weather, as_long_as=list(ROUTES))[name]


@pytest.mark.parametrize("name", few(ROUTES, EACH_PUSH))
def test_the_fleet_sails_the_plan_in_a_current_with_a_weak_propeller(name: str) -> None:
    it = sailed(name, "still")
    assert it.well
    assert it.mean_m <= 0.08 and it.worst_m <= 0.35 and it.corner_m <= 0.25
    assert it.speed >= 0.95 and it.rms_m <= 0.10 and it.closest >= 0.8


@pytest.mark.nightly
@pytest.mark.parametrize("name", ROUTES)
def test_the_fleet_sails_the_plan_in_wind_and_a_strong_current(name: str) -> None:
    it = sailed(name, "sea")
    assert it.well
    assert it.mean_m <= 0.2 and it.speed >= 0.95 and it.rms_m <= 0.3 and it.closest >= 0.8


@pytest.mark.parametrize("name", few(ROUTES, EACH_PUSH))
def test_the_figures_in_calm_water_are_those_of_the_page(name: str) -> None:
    now = figures(sailed(name, "still"))
    assert noted(f"{name}, calm") == pytest.approx(now, rel=0.05, abs=0.011)


@pytest.mark.nightly
@pytest.mark.parametrize("name", ROUTES)
def test_the_figures_in_wind_are_those_of_the_page(name: str) -> None:
    now = figures(sailed(name, "sea"))
    assert noted(f"{name}, wind") == pytest.approx(now, rel=0.05, abs=0.011)


def noted(row: str) -> list[float]:
    return measurements.numbers(" ".join(measurements.row(row)))


def figures(it: Sailed) -> tuple[float, ...]:
    return it.mean_m, it.worst_m, it.corner_m, it.cut_m, it.speed, it.rms_m, it.closest
