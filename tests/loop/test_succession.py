# SPDX-License-Identifier: MIT
"""Eight boats lose their leader, an inner boat, or half of their radio, and sail on."""

import pytest

from tests.loop.succession import KINDS, Healed, sail


@pytest.fixture(scope="module", params=KINDS)
def healed(request: pytest.FixtureRequest) -> Healed:
    (it,) = sail(request.param, [41.3])
    return it


def test_one_boat_leads_within_three_seconds(healed: Healed) -> None:
    assert healed.leads_s <= 3.0 and healed.two_s <= 2.0


def test_the_mission_goes_on(healed: Healed) -> None:
    assert healed.goes_on


def test_one_leads_and_all_others_follow_it(healed: Healed) -> None:
    assert set(healed.states) == {"AUTO", "FORMATION"}
    assert healed.states.count("AUTO") == 1


def test_no_two_boats_come_near(healed: Healed) -> None:
    assert healed.nearest_m >= 0.8 * 1.44  # of FS_SEP_M


def test_all_are_in_their_slots_after_a_minute(healed: Healed) -> None:
    assert healed.off_m <= 0.2
