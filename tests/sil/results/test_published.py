# SPDX-License-Identifier: MIT
"""The file of published figures, from made-up ones."""

import json
import math
from collections import Counter

from sil.results import published
from sil.results.published import Published
from sil.results.results_campaigns import MonteCarlo
from sil.results.sailing import Job, Outcome


def test_figures_come_back_with_six_digits_never_as_null_and_failures_with_their_reason() -> None:
    never = {"rms_error_m": 0.012345678, "settling_s": math.inf, "thrust_rms_N": math.nan}
    outcomes = [
        Outcome(Job("diamond", "paper"), figures=never),
        Outcome(Job("mismatch", "product", 3), "rammed a pier"),
    ]
    campaign = MonteCarlo("two", Counter(ok=1, diverged=1), [[0.1, math.inf]], [[[0.1, 2.0]]])
    content = published.encoded(Published(outcomes, [campaign], {"diamond": 2e-7}))
    assert json.loads(content)["runs"][0]["figures"]["settling_s"] is None
    found = published.decoded(content)
    assert [(o.job, o.failure) for o in found.outcomes] == [(o.job, o.failure) for o in outcomes]
    assert found.outcomes[0].figures == {
        "rms_error_m": 0.0123457,
        "settling_s": math.inf,
        "thrust_rms_N": math.inf,
    }
    assert (found.campaigns, found.measured) == ([campaign], {"diamond": 2e-7})
    assert published.encoded(found) == content
