# SPDX-License-Identifier: MIT
"""The conditions that keep a boat out of FORMATION."""

import flotilla

from sil.view.states import held_by, keep_from_arming

BITS = {c["name"]: 1 << c["bit"] for c in flotilla.supervisor_conditions()}
ALL = sum(BITS.values())


def test_a_boat_that_may_sail_is_held_by_nothing() -> None:
    assert held_by(ALL, "HOLD") == held_by(0, "FORMATION") == ()


def test_what_holds_a_boat_is_what_formation_needs_in_the_boats_own_words() -> None:
    leader = ALL & ~BITS["leader_fresh"]
    assert held_by(leader, "COAST") == ("leader's state is not fresh",)
    sticks = ALL & ~BITS["sticks_fresh"]
    assert held_by(sticks, "HOLD") == ()
    saved = ALL & ~BITS["parameters_saved"]
    assert held_by(saved, "HOLD") == () and held_by(saved, "DISARMED")


def test_what_keeps_a_boat_from_arming_is_told_apart() -> None:
    assert keep_from_arming(ALL) == ()
    for name, kept in (("escs_online", True), ("parameters_saved", True), ("own_fresh", False)):
        assert bool(keep_from_arming(ALL & ~BITS[name])) == kept


def test_numbers_of_conditions_that_there_are_not_say_nothing() -> None:
    assert held_by(ALL | 1 << 40, "HOLD") == ()
