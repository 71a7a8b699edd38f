# SPDX-License-Identifier: MIT
"""The short form of `python -m tests.loop.encounters`."""

import math
from collections.abc import Collection

import numpy as np
import pytest

from sil.scenario import presets
from tests.loop.encounters import ARRIVED_M, AT_REST_M, CROWDS, Crowd, crowds, encounters

#: Of 200 encounters each, as measured: hulls that turn slowly, or slip, do less well.
SIDE = 0.98
GUARDS = {"blueboat": 1.4, "heron": 1.2, "otter": 1.4, "paper": 1.3, "wamv": 1.0}
AWAY = 0.01


def shares(first: int, last: int, each_push: Collection[str]) -> list[object]:
    """The first runs of some hulls, of the slowest a third of them; nightly the others."""
    found: list[object] = []
    for hull in presets.names():
        now = math.ceil(first / 3) if hull == "wamv" else first
        nightly = () if hull in each_push else pytest.mark.nightly
        found.append(pytest.param(hull, range(now), id=f"{hull}-{now}", marks=nightly))
        if now < last:
            more = f"{hull}-{now}-{last}"
            found.append(pytest.param(hull, range(now, last), id=more, marks=pytest.mark.nightly))
    return found


@pytest.mark.parametrize(("hull", "runs"), shares(15, 200, ["wamv"]))
def test_strangers_are_given_room_on_the_side_of_the_rules_and_the_boat_comes_back(
    hull: str, runs: range
) -> None:
    passed = encounters(hull, runs)
    assert min(each.least for each in passed) > GUARDS[hull]
    assert np.mean([not each.arrived for each in passed]) <= AWAY
    assert np.mean([each.right for each in passed if each.right is not None]) >= SIDE


@pytest.mark.parametrize(("hull", "runs"), shares(2, 2, ["blueboat"]))
def test_boats_in_swapped_slots_never_come_too_near_and_all_arrive(hull: str, runs: range) -> None:
    found = crowds(hull, runs, Crowd(8, 0.5, True))
    assert found[:, 0].min() > 1.0
    assert found[:, 1].max() < ARRIVED_M


#: A boat of the heron's fleet 13 turned to and fro between the law and yielding, and never arrived.
AT_REST = [*shares(2, 2, ["paper"]), pytest.param("heron", range(13, 14), id="heron-13")]


@pytest.mark.parametrize(("hull", "runs"), AT_REST)
def test_boats_in_swapped_slots_behind_a_leader_at_rest_all_arrive(hull: str, runs: range) -> None:
    at_rest = next(one for one in CROWDS if one.speed_mps == 0.0)
    found = crowds(hull, runs, at_rest)
    assert found[:, 0].min() > 1.0
    assert found[:, 1].max() < AT_REST_M
