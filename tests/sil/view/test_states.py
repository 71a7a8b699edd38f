# SPDX-License-Identifier: MIT
"""A boat's state in its HEARTBEAT, and what holds it there."""

import flotilla
import pytest

from sil.view.states import held_by, state_of

BITS = {c["name"]: 1 << c["bit"] for c in flotilla.supervisor_conditions()}
ALL = sum(BITS.values())


@pytest.mark.parametrize(
    ("mode", "base", "status", "state"),
    [
        (4, 1, 3, "DISARMED"),
        (4, 129, 4, "HOLD"),
        (0, 129 | 64, 4, "MANUAL"),
        (6, 129 | 12, 4, "FORMATION"),
        (6, 129 | 12, 5, "COAST"),
        (4, 129 | 2, 4, "TEST"),
        (4, 129, 6, "FAULT"),
        (17, 129, 4, None),
    ],
)
def test_a_heartbeat_tells_the_state(mode: int, base: int, status: int, state: str | None) -> None:
    assert state_of(mode, base, status) == state
    assert state is None or state in flotilla.STATES


def test_a_boat_that_may_sail_is_held_by_nothing() -> None:
    assert held_by(ALL, "HOLD") == held_by(0, "FORMATION") == ()


def test_what_holds_a_boat_is_what_formation_needs_in_the_boats_own_words() -> None:
    leader = ALL & ~BITS["leader_fresh"]
    assert held_by(leader, "COAST") == ("leader's state is not fresh",)
    sticks = ALL & ~BITS["sticks_fresh"]
    assert held_by(sticks, "HOLD") == ()
    saved = ALL & ~BITS["parameters_saved"]
    assert held_by(saved, "HOLD") == () and held_by(saved, "DISARMED")


def test_numbers_of_conditions_that_there_are_not_say_nothing() -> None:
    assert held_by(ALL | 1 << 30, "HOLD") == ()
