# SPDX-License-Identifier: MIT
"""The conditions that keep a boat out of FORMATION."""

import flotilla

from sil.view.states import held_by, keep_from_arming

BITS = {c["name"]: 1 << c["bit"] for c in flotilla.supervisor_conditions()}
ALL = sum(BITS.values())


def test_a_boat_that_may_sail_has_no_unmet_condition() -> None:
    assert held_by(ALL, "HOLD") == held_by(0, "FORMATION") == ()


def test_unmet_conditions_of_formation_are_listed_in_the_boats_words() -> None:
    leader = ALL & ~BITS["leader_fresh"]
    assert held_by(leader, "COAST") == ("leader lost or origin unknown",)
    sticks = ALL & ~BITS["sticks_fresh"]
    assert held_by(sticks, "HOLD") == ()
    saved = ALL & ~BITS["parameters_saved"]
    assert held_by(saved, "HOLD") == () and held_by(saved, "DISARMED")


def test_conditions_that_prevent_arming_are_listed_separately() -> None:
    assert keep_from_arming(ALL) == ()
    for name, kept in (("escs_online", True), ("parameters_saved", True), ("own_fresh", False)):
        assert bool(keep_from_arming(ALL & ~BITS[name])) == kept


def test_unknown_condition_bits_are_ignored() -> None:
    assert held_by(ALL | 1 << 40, "HOLD") == ()
