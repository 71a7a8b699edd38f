# SPDX-License-Identifier: MIT
"""The tables name numbers that are easily misread."""

import io
from dataclasses import replace

import pytest
from rich.console import Console

from sil.certificate import certificate, certificate_report, search
from sil.certificate.certificate import Certificate, certify
from sil.certificate.small_gain import MOST_K_X
from sil.scenario import scenario
from tests.sil.certificate.made_up import SINE


@pytest.fixture(scope="module")
def straight() -> Certificate:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(search, "SEARCH_CYCLES", 60)
        patch.setattr(certificate, "_chain", lambda *_: (None, None))  # no test here needs it
        slew = {"THR_SLEW": 5.0, "THR_DEAD": 0.01}
        return certify(scenario.load("diamond", [SINE], "product"), slew, lambda what, share: None)


def told(certificate: Certificate) -> str:
    console = Console(width=80, record=True, file=io.StringIO())
    certificate_report.tell(certificate, console)
    return " ".join(console.export_text().split())


def test_gain_at_the_end_of_the_formulas_range_is_reported_as_a_lower_bound(
    straight: Certificate,
) -> None:
    (leg,) = straight.legs
    (case,) = leg.cases
    test = replace(case.small_gain, k_x_product=MOST_K_X, k_x_sum_of_squares=9.99)
    changed = replace(straight, legs=[replace(leg, cases=[replace(case, small_gain=test)])])
    assert "largest k_x (1/s) over 10 " in told(changed)
    assert "largest k_x (1/s) 9.9900 " in told(changed)


def test_suggested_gains_are_shown_with_todays_gains_and_their_noise(straight: Certificate) -> None:
    found = straight.search
    assert found is not None
    text = told(straight)
    assert f"LAW_KX {found.gains['LAW_KX']:.3g} (now 0.2; " in text
    at_end = replace(straight, search=replace(found, at_end=["LAW_KPSI"]))
    assert "(now 0.5; at the end of 0.05 … 2)" in told(at_end)
    assert f"{found.decay_of_law:.4f} (now {found.decay_of_law_now:.4f})" in text
    assert f"in place {found.noise['place']:.2g}" in text and found.noise["place"] > 1.0


def test_the_report_names_the_limits_of_the_linearised_loop(straight: Certificate) -> None:
    assert "THR_SLEW = 5, THR_DEAD = 0.01: not in the linearised loop" in told(straight)
    assert "concerns small errors" in told(straight)


def test_slowest_components_are_named(straight: Certificate) -> None:
    slowest = straight.legs[0].cases[0].sampled.slowest
    assert slowest and f"slowest is in {', '.join([*slowest][:3])}" in told(straight)
