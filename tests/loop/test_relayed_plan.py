# SPDX-License-Identifier: MIT
"""Boats of a line that hear their neighbours only keep their slots of the leader's plan."""

from tests.loop.relayed_plan import sail


def test_twenty_boats_in_a_line_keep_their_slots_of_the_plan() -> None:
    it = sail()
    assert it.well
    assert it.rms_m.max() <= 0.1, it.rms_m
    assert it.worst_m.max() <= 0.2, it.worst_m
    # Of 5,760 bytes a second at 57,600 Bd.
    assert it.told_Bps[0] <= 200.0, it.told_Bps


def test_nineteen_boats_keep_their_slots_though_each_hop_loses_three_of_ten_messages() -> None:
    it = sail(loss=0.3)
    assert it.well
    assert it.rms_m[:17].max() <= 0.1, it.rms_m
    assert it.rms_m[:19].max() <= 0.12, it.rms_m  # boat 20 is beyond it: 0.33 m
