# SPDX-License-Identifier: MIT
"""A boat that keeps its slot stays in FORMATION; an impossible fleet is not sailed."""

import numpy as np
import pytest

from sil.lockstep import metrics
from tests.loop.conftest import Sail

PRODUCT = ("law=product", "link.everyone=true", "duration_s=60")


def test_ten_boats_in_line_close_up_and_stay_in_formation(sail: Sail) -> None:
    run = sail("line10", "duration_s=60")
    assert [set(states) for states in run.states] == [{"FORMATION"}] * 10
    assert metrics.distances(run.trace["error"])[-1000:].max() < 0.1


def test_slot_inside_a_turn_stops_its_boat_and_no_other_comes_near(sail: Sail) -> None:
    """`diamond` with slots that turn: boat 2 would have to go astern."""
    run = sail("diamond", *PRODUCT, "duration_s=90", parameters={"FORM_FRAME": 1.0})
    assert [boat for boat, states in enumerate(run.states, 1) if "HOLD" in states] == [2]
    # without collision avoidance while they close up: FS_SEP_M is 0
    separation = metrics.min_separation_m(run.trace["eta"][2000:])
    assert separation is not None and separation > 0.5
    errors = metrics.distances(run.trace["error"])[-1500:]
    assert np.delete(errors, 1, axis=1).max() < 0.2


@pytest.mark.parametrize(
    ("how", "why"),
    [
        ("boat.1.parameters.FORM_LEADER=4", "leaders form a cycle"),
        ("boat.3.offset_m=[0, 0]", "boat 3: Refused: slot is taken"),
    ],
)
def test_impossible_fleet_is_not_sailed(sail: Sail, how: str, why: str) -> None:
    with pytest.raises(Exception, match="not in the wanted mode after 30 s") as told:
        sail("diamond", *PRODUCT, how)
    assert why in str(told.value)


def test_of_two_boats_with_the_same_slot_the_one_with_the_higher_id_holds(sail: Sail) -> None:
    run = sail("diamond", *PRODUCT, "boat.4.offset_m=[-4, 0]")  # boat 2's, seen from the root
    assert ["HOLD" in states for states in run.states] == [False, False, False, True]
    assert run.states[3]["FORMATION"] < 2.5


@pytest.mark.parametrize("pair", [(2, 3), (1, 4)])
def test_boats_that_swap_slots_keep_clear_by_default_and_arrive(
    sail: Sail, pair: tuple[int, int]
) -> None:
    """Without FS_SEP_M they came within 0.03 m and 0.15 m."""
    slots = {1: (0, 0), 2: (-2, -2), 3: (2, -2), 4: (0, -4)}
    one, other = pair
    slots[one], slots[other] = slots[other], slots[one]
    starts = [f"boat.{boat}.eta=[{x}, {y}, 0]" for boat, (x, y) in slots.items()]
    run = sail("diamond", *PRODUCT, *starts, parameters={"FS_SEP_M": -1.0})
    separation = metrics.min_separation_m(run.trace["eta"])
    assert separation is not None and separation > 1.2 * 1.3
    assert metrics.distances(run.trace["error"])[-1].max() < 0.02
