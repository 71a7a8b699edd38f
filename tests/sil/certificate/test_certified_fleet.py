# SPDX-License-Identifier: MIT
"""Groups of equal boats, each behind its own leader."""

import numpy as np
import pytest

from sil.certificate.certified_fleet import fleet, parameters, vessel_of
from sil.certificate.references import references
from sil.scenario import scenario
from tests.sil.certificate.made_up import SINE


def groups(name: str, *overrides: str) -> list[list[int]]:
    chosen = scenario.load(name, overrides)
    firmware = parameters(chosen, {})
    return [boats for boats, _, _ in fleet(chosen, references(chosen)[0], firmware)]


def test_boats_of_the_diamond_are_all_alike() -> None:
    assert groups("diamond") == [[1, 2, 3, 4]]


def test_boat_with_other_parameters_is_examined_by_itself() -> None:
    assert groups("diamond", "boat.3.parameters={LAW_KX = 0.3}") == [[1, 2, 4], [3]]
    assert groups("diamond", "boat.2.navigation.rate_hz=20.0") == [[1, 3, 4], [2]]
    assert groups("diamond", "boat.4.vessel.m11=1.2") == [[1, 2, 3], [4]]


def test_in_a_current_boat_1_follows_a_leader_that_does_not_feel_it() -> None:
    assert groups("diamond", "water.current_mps=[0.0, 0.1]") == [[1], [2, 3, 4]]


def test_follower_of_a_boat_in_a_current_has_a_leader_that_heads_up() -> None:
    chosen = scenario.load("diamond", ["water.current_mps=[0.0, 0.1]", SINE])
    (_, _, first), (_, _, others) = fleet(chosen, references(chosen)[0], parameters(chosen, {}))
    now = np.zeros(1)
    assert first.leader.eta(now)[0, 2] == 0.0
    assert others.leader.eta(now)[0, 2] == pytest.approx(-np.arctan(0.1 * 3.436 / 2.0))


def test_boats_of_one_size_form_a_group() -> None:
    assert groups("tree") == [[1], [2, 3], [4, 5, 6, 7]]


def test_law_uses_the_vessel_of_the_parameters() -> None:
    chosen = scenario.load("diamond", ["mismatch.share=0.3"])
    own = parameters(chosen, {"VES_M11": 1.5})[0]
    vessel = vessel_of(own, 0.5)
    assert (vessel.m11, vessel.d22) == pytest.approx((1.5, 18.99))
    assert (vessel.d11, vessel.d33) == pytest.approx((3.436, 0.864))
    fast = vessel_of(own | {"VES_D11Q": 8.0, "VES_D33U": 4.0}, 0.5)
    assert (fast.d11, fast.d33) == pytest.approx((7.436, 2.864))


@pytest.mark.parametrize("wrong", [{"LAW_KX": 9.0}, {"LAW_KZ": 1.0}])
def test_parameters_that_the_firmware_refuses_are_refused(wrong: dict[str, float]) -> None:
    with pytest.raises(ValueError, match="LAW_K"):
        parameters(scenario.load("diamond"), wrong)
