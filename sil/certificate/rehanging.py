# SPDX-License-Identifier: MIT
"""What becomes of a scenario's tree when one of its boats fails.

By the rule of a fleet's table (firmware/docs/FLEET.md): who followed the failed boat hangs on that
one's own leader; if the failed boat leads, the first other one does, and they hang on it.
"""

import math
from dataclasses import dataclass

from sil.certificate.probe import path_to
from sil.scenario.scenario import Scenario


@dataclass(frozen=True)
class Rehanging:
    """The deepest line of boats, before, and after any one of them has failed.

    `step_m`: from the place of the boat that leads to that of the one that would; 0 where no boat
    leads.
    """

    before: int
    after: int
    step_m: float


def rehung(follows: dict[int, int], failed: int) -> dict[int, int]:
    """Boat by boat, whom it follows afterwards; 0: the root, which is no boat or the boat's own."""
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
    """How many boats the line from the root to a boat has."""
    return 0 if boat == 0 else 1 + depth(follows, follows[boat])


def _deepest(follows: dict[int, int]) -> int:
    return max((depth(follows, boat) for boat in follows), default=0)


def rehangings(scenario: Scenario) -> Rehanging:
    """Every boat of the scenario fails, one at a time."""
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
    """A boat's slot behind the root."""
    offsets_m = [scenario.boat[agent - 1].offset_m for agent in path_to(scenario, boat)]
    return [sum(axis) for axis in zip((0.0, 0.0), *offsets_m, strict=True)]
