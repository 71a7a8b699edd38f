# SPDX-License-Identifier: MIT
"""The fleets that tools/bench sails."""

from itertools import combinations

import numpy as np
import pytest

from sil.bench import bench_fleet


@pytest.mark.parametrize("boats", [1, 2, 4, 100])
def test_every_boat_starts_in_its_own_slot_behind_one_that_is_before_it(boats: int) -> None:
    tree = bench_fleet.tree(boats, 1.0)
    assert len(tree.boat) == boats
    places = [tree.leader.eta[:2]]
    for number, boat in enumerate(tree.boat, start=1):
        assert boat.follows < number
        assert boat.eta[:2] == tuple(np.add(places[boat.follows], boat.offset_m))
        places.append(boat.eta[:2])
    assert all(np.hypot(*np.subtract(a, b)) >= 2.0 for a, b in combinations(places[1:], 2))


def test_the_fleets_formation_is_sailed_and_measured() -> None:
    figure = bench_fleet.sail(4, 2.0)
    assert figure["boat_seconds_per_s"] > 0.0
    assert list(figure["stages_us"]) == ["plant", "codec", "control"]
    assert all(us > 0.0 for us in figure["stages_us"].values())
