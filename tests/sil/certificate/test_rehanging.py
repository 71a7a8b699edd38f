# SPDX-License-Identifier: MIT
"""Trees after one boat has failed: against the rule told boat by boat, and for all small trees."""

import itertools
import math

import pytest

from sil.certificate.rehanging import depth, rehangings, rehung
from sil.scenario import scenario


@pytest.mark.parametrize("boats", range(2, 7))
def test_after_any_failure_no_boat_is_deeper_in_the_tree(boats: int) -> None:
    for leaders in itertools.product(*(range(1, boat) for boat in range(2, boats + 1))):
        follows = {1: 0, **dict(enumerate(leaders, start=2))}
        for failed in follows:
            left = rehung(follows, failed)
            assert set(left) == set(follows) - {failed}
            assert failed not in left.values() and list(left.values()).count(0) == 1
            assert all(depth(left, boat) <= depth(follows, boat) for boat in left)


def test_followers_of_a_failed_boat_follow_its_leader_or_the_new_one() -> None:
    tree = {1: 0, 2: 1, 3: 2, 4: 2, 5: 1}
    assert rehung(tree, 2) == {1: 0, 3: 1, 4: 1, 5: 1}
    assert rehung(tree, 1) == {2: 0, 3: 2, 4: 2, 5: 2}
    # behind a leader that is none of them
    assert rehung({1: 0, 2: 0, 3: 1}, 1) == {2: 0, 3: 0}


def test_a_new_leader_moves_the_shape_by_the_distance_of_two_places() -> None:
    found = rehangings(scenario.load("lead"))
    assert found.after <= found.before == 2
    offset_m = scenario.load("lead").boat[1].offset_m
    assert found.step_m == pytest.approx(math.hypot(*offset_m))
    assert rehangings(scenario.load("diamond")).step_m == 0.0
