# SPDX-License-Identifier: MIT
"""The verdict on certificates with one defect, and on a good one."""

from dataclasses import replace
from typing import Any

import pytest

from sil.certificate import verdict
from sil.certificate.certificate import Certificate
from sil.certificate.sampled import Misled
from tests.sil.certificate.made_up import SINE, quick_certificate


@pytest.fixture(scope="module")
def straight() -> Certificate:
    return quick_certificate("diamond", [SINE], "product")


def with_loop(certificate: Certificate, **changes: Any) -> Certificate:
    (leg,) = certificate.legs
    (case,) = leg.cases
    changed = replace(case, sampled=replace(case.sampled, **changes))
    return replace(certificate, legs=[replace(leg, cases=[changed])])


def test_boats_that_keep_their_slots_are_certified(straight: Certificate) -> None:
    assert verdict.holds(straight)
    assert verdict.sentence(straight).startswith("certified about the formation")
    assert "off the slot" not in verdict.sentence(straight)


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"decay": -0.2}, "boats 1–4: small errors grow by 0.2 1/s"),
        ({"decay": 0.0}, "boats 1–4: some error never decays"),
        ({"steady": False, "error": [3.0, 4.0, 0.0]}, "no steady regime, 5 m off its slot"),
        ({"steady": False, "limited": True}, "a propeller at its limit"),
    ],
)
def test_the_verdict_names_the_fault(
    straight: Certificate, changes: dict[str, Any], said: str
) -> None:
    wrong = with_loop(straight, **changes)
    assert not verdict.holds(wrong)
    assert verdict.sentence(wrong).startswith("not certified")
    assert said in verdict.sentence(wrong)


@pytest.mark.parametrize(
    ("name", "overrides"),
    [
        ("lead", []),
        pytest.param("square", ["formation.boats=2", "fault=[]"], marks=pytest.mark.nightly),
    ],
)
def test_straight_legs_in_a_current_are_certified_and_its_unmeasured_part_reported(
    name: str, overrides: list[str]
) -> None:
    found = quick_certificate(name, overrides, None)
    assert verdict.holds(found)
    assert "current along a straight leg is not measured" in verdict.sentence(found)


@pytest.mark.parametrize(
    ("off_m", "limited", "holds"), [(0.01, False, True), (1.1, False, False), (0.01, True, False)]
)
def test_current_that_is_not_measured_may_move_a_boat_within_its_slot(
    straight: Certificate, off_m: float, limited: bool, holds: bool
) -> None:
    found = with_loop(straight, misled=Misled(0.1, off_m, 0.0, limited))
    assert verdict.holds(found) == holds
    assert f"moves a boat by at most {off_m:g} m" in verdict.sentence(found)


def test_boat_that_stays_beside_its_slot_is_certified_and_its_offset_reported(
    straight: Certificate,
) -> None:
    beside = with_loop(straight, error=[0.3, 0.4, 0.0])
    assert verdict.holds(beside)
    assert "0.50 m off the slot permanently" in verdict.sentence(beside)


@pytest.mark.parametrize(("slot_m", "limit"), [(5.0, "1"), (0.5, "0.2"), (0.0, "1")])
def test_boat_that_stays_far_beside_its_slot_is_not_certified(
    straight: Certificate, slot_m: float, limit: str
) -> None:
    far = with_loop(straight, error=[3.0, 4.0, 0.0])
    (leg,) = far.legs
    (case,) = leg.cases
    own = {**case.setup.parameters, "FS_SLOT_M": slot_m}
    cases = [replace(case, setup=replace(case.setup, parameters=own))]
    far = replace(far, legs=[replace(leg, cases=cases)])
    assert not verdict.holds(far)
    assert f"boats 1–4: 5.00 m off the slot permanently, over {limit} m" in verdict.sentence(far)


@pytest.mark.parametrize(("look_ahead_m", "said"), [(1.0, "up to 1.5 m"), (0.0, "as they are")])
def test_permanent_errors_behind_a_leader_at_rest_are_named(
    straight: Certificate, look_ahead_m: float, said: str
) -> None:
    neutral = with_loop(straight, neutral=1)
    case = neutral.legs[0].cases[0]
    own = dict(case.setup.parameters) | {"LAW_XT_DIST": look_ahead_m}
    cases = [replace(case, setup=replace(case.setup, parameters=own))]
    sentence = verdict.sentence(replace(neutral, legs=[replace(neutral.legs[0], cases=cases)]))
    assert sentence.endswith(said) and "any law" not in sentence


@pytest.mark.parametrize(
    ("margin", "said"),
    [
        (-0.25, "25 % more reverse thrust than the starboard propeller can give"),
        (-1231.0, "more than ten times the reverse thrust that the starboard propeller can give"),
    ],
)
def test_weak_propellers_are_reported_before_other_faults(
    straight: Certificate, margin: float, said: str
) -> None:
    (leg,) = straight.legs
    weak = replace(leg.cases[0].thrust, margin=margin, side="stbd", direction="reverse")
    cases = [replace(with_loop(straight, decay=-1.0).legs[0].cases[0], thrust=weak)]
    wrong = replace(straight, legs=[replace(leg, cases=cases)])
    assert said in verdict.sentence(wrong)


@pytest.mark.parametrize(
    ("boats", "words"), [([3], "boat 3"), ([2, 3, 4], "boats 2–4"), ([1, 3], "boats 1, 3")]
)
def test_boats_are_named_briefly(boats: list[int], words: str) -> None:
    assert verdict.name(boats) == words
