# SPDX-License-Identifier: MIT
"""Fleets of the named hulls keep their slots as well as they did, give or take a factor of two."""

import pytest

from tests.loop import presets

# As `python -m tests.loop.presets` prints it, m.
MEASURED = {
    ("blueboat", "calm"): 0.0189,
    ("blueboat", "weather"): 0.0259,
    ("heron", "calm"): 0.0599,
    ("heron", "weather"): 0.0893,
    ("otter", "calm"): 0.0018,
    ("otter", "weather"): 0.0137,
    ("paper", "calm"): 0.0001,
    ("paper", "weather"): 0.0154,
    ("wamv", "calm"): 0.0110,
    ("wamv", "weather"): 0.0258,
    ("mixed", "calm"): 0.0170,
    ("mixed", "weather"): 0.0195,
}


@pytest.fixture(scope="module")
def found() -> dict[tuple[str, str], float]:
    return presets.measured({})


def test_every_hull_is_sailed(found: dict[tuple[str, str], float]) -> None:
    assert found.keys() == MEASURED.keys()


@pytest.mark.parametrize("fleet", MEASURED, ids=" in ".join)
def test_fleet_of_a_named_hull_stays_in_its_slots(
    fleet: tuple[str, str], found: dict[tuple[str, str], float]
) -> None:
    assert found[fleet] < 2.0 * MEASURED[fleet]


def test_mixed_fleet_stays_within_a_tenth_of_a_metre(found: dict[tuple[str, str], float]) -> None:
    assert found["mixed", "calm"] <= 0.10
