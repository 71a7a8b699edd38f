# SPDX-License-Identifier: MIT
"""Boats whose hull is half or twice what they were told stay in FORMATION, near their slots."""

import pytest

from sil.scenario import presets
from tests.each_push import few
from tests.loop.off_hull import SHORT, measured
from tests.loop.presets import WEATHER

# As `python -m tests.loop.off_hull` prints it, m: the worst case of `SHORT` of each hull.
MEASURED = {
    "blueboat": 0.0345,
    "heron": 0.1065,
    "otter": 0.0538,
    "paper": 0.0153,
    "wamv": 0.0599,
}
EACH_PUSH = ["heron"]
WORST_IN_WEATHER = ("heron", "m11", 2.0), 0.1263
MOST_M = 0.2


@pytest.mark.parametrize("name", few(presets.names(), EACH_PUSH))
def test_no_boat_leaves_formation_or_its_slot(name: str) -> None:
    own = measured([name], SHORT)
    assert not [fleet.left for fleet in own.values() if fleet.left]
    worst = max(fleet.rms_m for fleet in own.values())
    assert worst <= MOST_M
    assert 0.5 * MEASURED[name] < worst < 1.5 * MEASURED[name]


def test_worst_of_all_in_weather_stays_in_formation_too() -> None:
    key, rms_m = WORST_IN_WEATHER
    fleet = measured([key[0]], (key[1:],), WEATHER)[key]
    assert not fleet.left
    assert fleet.rms_m <= MOST_M
    assert 0.5 * rms_m < fleet.rms_m < 1.5 * rms_m
