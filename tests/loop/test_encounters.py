# SPDX-License-Identifier: MIT
"""The short form of `python -m tests.loop.encounters`."""

import numpy as np
import pytest

from tests.loop.encounters import ARRIVED_M, GUARD_M, crowds, encounters

SIDE = 0.95


@pytest.mark.parametrize(
    "runs", [range(30), pytest.param(range(30, 200), marks=pytest.mark.nightly)], ids=str
)
def test_strangers_are_given_room_on_the_side_of_the_rules_and_the_boat_comes_back(
    runs: range,
) -> None:
    passed = encounters(runs)
    assert min(each.least_m for each in passed) > GUARD_M
    assert all(each.arrived for each in passed)
    assert np.mean([each.right for each in passed if each.right is not None]) >= SIDE


def test_boats_in_swapped_slots_never_come_too_near_and_all_arrive() -> None:
    found = crowds(range(2), 8, 0.5, swapped=True)
    assert found[:, 0].min() > GUARD_M
    assert found[:, 1].max() < ARRIVED_M
