# SPDX-License-Identifier: MIT
"""Notes on a certificate: effects that it leaves out."""

import pytest

from sil.certificate.certificate import Certificate
from sil.certificate.notes import notes
from sil.scenario import scenario


@pytest.mark.parametrize(("delay_s", "told"), [(0.4, True), (0.05, False)])
def test_late_navigation_unit_is_noted(delay_s: float, told: bool) -> None:
    late = scenario.load("diamond", [f"navigation.delay_s={delay_s}"], "product")
    text = " ".join(notes(Certificate(late, [], None)))
    assert ("The navigation unit is 0.40 s late" in text) is told
