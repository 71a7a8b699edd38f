# SPDX-License-Identifier: MIT
"""System ids of a fleet, unique for everybody who hears them."""

import pytest

from sil.scenario import scenario
from sil.scenario.agents import parameters_of, systems_of
from sil.scenario.scenario import Scenario


def fleet(*follows: int) -> Scenario:
    """Boats of `diamond`, one behind each of these agents."""
    diamond = scenario.load("diamond")
    boats = tuple(diamond.boat[0].model_copy(update={"follows": leader}) for leader in follows)
    return diamond.model_copy(update={"boat": boats})


def test_boats_of_a_small_fleet_have_the_ids_of_their_numbers() -> None:
    assert systems_of(scenario.load("tree")) == [100, 1, 2, 3, 4, 5, 6, 7]


TREES = {
    "a line": range(1000),
    "two behind each": [i // 2 for i in range(1000)],
    "two hundred behind each": [i // 200 for i in range(1000)],
    "each behind the 250th before it": [max(0, i - 249) for i in range(1000)],
}


@pytest.mark.parametrize("follows", TREES.values(), ids=TREES.keys())
def test_all_boats_that_one_receiver_hears_have_different_ids(follows: list[int]) -> None:
    systems = systems_of(fleet(*follows))
    if 100 in follows:
        assert systems[:100] == [100, *range(1, 100)]
    assert set(systems[1:]) <= set(range(1, 251))
    heard: list[list[int]] = [[100], *([systems[i + 1]] for i in range(1000))]
    for agent, leader in enumerate(follows, start=1):
        heard[agent].append(systems[leader])
        heard[leader].append(systems[agent])
    for agent, ids in enumerate(heard):
        # More than there are ids cannot differ; then the leader's still does.
        some = ids if len(ids) <= 250 else [ids[0], *set(ids[1:])]
        assert len(set(some)) == len(some), agent


def test_more_followers_than_ids_still_know_their_leader() -> None:
    systems = systems_of(fleet(0, *[1] * 600))
    assert 1 not in systems[2:] and 100 not in systems[2:]
    assert set(systems[2:]) == set(range(1, 251)) - {1, 100}


def test_form_leader_is_the_system_id_of_the_leader() -> None:
    behind = [i // 2 for i in range(1000)]
    chosen = fleet(*behind)
    systems = systems_of(chosen)
    for agent, own in enumerate(parameters_of(chosen, {"LAW_KX": 0.3}), start=1):
        assert own["MAV_SYSID"] == systems[agent]
        assert own["FORM_LEADER"] == systems[behind[agent - 1]]
        assert own["LAW_KX"] == 0.3 and own["CTL_RATE"] == 100.0
