# SPDX-License-Identifier: MIT
"""The tree of a scenario after one of its boats has failed.

By the rule of a fleet's table (firmware/docs/FLEET.md), the followers of the failed boat follow
that boat's leader. If the failed boat led, the first other boat leads, and they follow it.
"""

import math
from dataclasses import dataclass

from sil.certificate.probe import path_to
from sil.scenario.scenario import Scenario


@dataclass(frozen=True)
class Rehanging:
    """The deepest line of boats, before, and after any one of them has failed.

    `step_m`: distance from the place of the boat that leads to that of its successor; 0 if no boat
    leads.
    """

    before: int
    after: int
    step_m: float


def rehung(follows: dict[int, int], failed: int) -> dict[int, int]:
    """Each boat's leader after the failure; 0: the root, which is no boat or the boat itself."""
    left = {boat: leader for boat, leader in follows.items() if boat != failed}
    above = follows[failed]
    if above == 0 and list(follows.values()).count(0) == 1 and left:
        above = min(left)
        left[above] = 0
    return {
        boat: above if leader == failed and boat != above else leader
        for boat, leader in left.items()
    }


def depth(follows: dict[int, int], boat: int) -> int:
    """Number of boats in the line from the root to a boat."""
    return 0 if boat == 0 else 1 + depth(follows, follows[boat])


def _deepest(follows: dict[int, int]) -> int:
    return max((depth(follows, boat) for boat in follows), default=0)


def rehangings(scenario: Scenario) -> Rehanging:
    """Let every boat of the scenario fail, one at a time."""
    leads = scenario.leader.boat
    follows = {
        boat: 0 if boat == leads else scenario.heard_by(boat)
        for boat in range(1, len(scenario.boat) + 1)
    }
    after = max((_deepest(rehung(follows, failed)) for failed in follows), default=0)
    others = [boat for boat in follows if boat != leads]
    step_m = 0.0
    if leads is not None and others:
        step_m = math.dist(_place_m(scenario, leads), _place_m(scenario, min(others)))
    return Rehanging(_deepest(follows), after, step_m)


def _place_m(scenario: Scenario, boat: int) -> list[float]:
    """A boat's slot relative to the root, m."""
    offsets_m = [scenario.boat[agent - 1].offset_m for agent in path_to(scenario, boat)]
    return [sum(axis) for axis in zip((0.0, 0.0), *offsets_m, strict=True)]
