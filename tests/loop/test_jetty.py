# SPDX-License-Identifier: MIT
"""The short form of `python -m tests.loop.jetty`."""

import pytest

from sil.lockstep import metrics
from sil.lockstep.world import Run, sail
from sil.scenario import presets, scenario
from tests.each_push import few
from tests.loop.jetty import outings

NEAREST = 0.95  # of the guard; measured: 0.99 for the BlueBoat, all others over 1
STARTS_M = (  # ahead and abeam of the slots
    (0.0, 64.0),
    (-60.0, 0.0),
)


@pytest.mark.parametrize("hull", few(presets.names(), ["blueboat", "wamv"]))
@pytest.mark.parametrize(
    "numbers", [range(1), pytest.param(range(1, 40), marks=pytest.mark.nightly)], ids=str
)
def test_a_fleet_of_any_hull_comes_from_its_jetty_to_its_slots_and_no_two_boats_meet(
    hull: str, numbers: range
) -> None:
    found = outings(hull, numbers)
    assert len(found) >= 0.97 * len(numbers)
    assert min(each.nearest for each in found) >= NEAREST, found
    assert not any(each.left for each in found), found
    assert max(each.arrived_s for each in found) < 400.0, found


def test_boats_in_line_reach_their_slots_though_each_leader_is_far_from_its_own() -> None:
    """Each is in its slot behind the boat ahead, which is itself far from its own."""
    starts = [boat.eta for boat in scenario.load("sea").boat]
    fleets = [
        [
            f"boat.{number}.eta=[{north + ahead_m}, {east + abeam_m}, {psi}]"
            for number, (north, east, psi) in enumerate(starts, 1)
        ]
        for ahead_m, abeam_m in STARTS_M
    ]
    for run in sail([scenario.load("sea", [*one, "duration_s=200.0"]) for one in fleets], {}):
        assert isinstance(run, Run)
        assert [list(states) for states in run.states] == [["FORMATION"]] * len(starts)
        assert metrics.distances(run.trace["error"])[-1].max() < 0.1
