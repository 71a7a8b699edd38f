# SPDX-License-Identifier: MIT
"""A boat that leads by its plan waits for a follower that falls behind, but not for ever."""

import numpy as np

from sil.lockstep.world import Run, all_sailed, sail
from sil.plant.hull import Array
from sil.scenario import scenario

WAIT_S, WEAK = 20.0, 3
LEADER_RESTS_MPS = 0.05


def sailed(*overrides: str, duration_s: float = 150.0) -> Run:
    """Three boats of `lead` along 110 m at 0.8 m/s."""
    one = scenario.load(
        "lead",
        [
            "formation.shape=vee",
            "formation.boats=3",
            "leader.waypoints=[[0, 0], [80, 0], [80, 30]]",
            "leader.speed_mps=0.8",
            f"duration_s={duration_s}",
            f"parameters.WP_WAIT_S={WAIT_S}",
            *overrides,
        ],
    )
    (run,) = all_sailed(sail([one], {}, keep_s=0.1))
    return run


def rests_s(run: Run) -> float:
    """The longest time for which boat 1 made no way between its start and its arrival."""
    eta: Array = run.trace["eta"][:, 1, :2]
    speed = np.hypot(*(np.diff(eta[::10], axis=0)).T)
    under_way = speed[5:][: int(np.argmax(np.hypot(*(eta[::10] - eta[-1]).T) < 1.0)) or None]
    longest = count = 0
    for one in under_way:
        count = count + 1 if one < LEADER_RESTS_MPS else 0
        longest = max(longest, count)
    return float(longest)


def slowest_mps(run: Run) -> float:
    """Boat 1's least speed on the first leg, from 20 to 60 m."""
    eta: Array = run.trace["eta"][::10, 1, :2]
    way = eta[(eta[:, 0] > 20.0) & (eta[:, 0] < 60.0) & (eta[:, 1] < 5.0)]
    return float(np.hypot(*np.diff(way, axis=0).T).min())


def sailed_m(run: Run) -> float:
    """How far boat 1 has sailed."""
    steps = np.diff(run.trace["eta"][:, 1, :2], axis=0)
    return float(np.hypot(*steps.T).sum())


def test_the_leader_waits_for_a_weak_follower_which_stays_in_formation() -> None:
    weak = f"boat.{WEAK}.propellers.forward_max_N=4.5"
    waits, goes_on = sailed(weak), sailed(weak, "parameters.WP_WAIT_S=0.0")
    assert set(waits.states[WEAK - 1]) == {"FORMATION"}, waits.states
    assert set(goes_on.states[WEAK - 1]) != {"FORMATION"}, goes_on.states
    assert sailed_m(waits) < sailed_m(goes_on) - 3.0
    assert slowest_mps(waits) < 0.4
    assert slowest_mps(goes_on) > 0.7


def test_the_leader_does_not_wait_for_a_boat_that_fails() -> None:
    fault = f'fault=[{{kind = "esc_silent", agent = {WEAK}, at_s = 40.0}}]'
    failed, whole = sailed(fault), sailed()
    assert failed.states[WEAK - 1].get("FAULT", 0.0) > 60.0
    assert rests_s(failed) < WAIT_S + 5.0
    assert abs(sailed_m(failed) - sailed_m(whole)) < 3.0


def test_the_leader_does_not_wait_while_all_keep_their_slots() -> None:
    assert rests_s(sailed(duration_s=80.0)) < 2.0
