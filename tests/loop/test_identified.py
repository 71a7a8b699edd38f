# SPDX-License-Identifier: MIT
"""A boat that knows only its kind measures its own hull, in wind and current."""

import pytest

from sil.identify.hull_terms import INDEX
from sil.identify.identification import problem_of, searched
from tests.loop.identified import body_of, sailed, shares, voyage

# About twice the errors of these hulls: see `python -m tests.loop.identified`.
BOUNDS = {
    "otter": {"drag 0.5": 0.03, "drag 1": 0.03, "yaw 0.1": 0.16, "yaw 0.3": 0.07, "m33": 0.05},
    "blueboat": {"drag 0.5": 0.1, "drag 1": 0.12, "m33": 0.05},
}


@pytest.mark.nightly
@pytest.mark.parametrize("kind", BOUNDS)
def test_a_voyage_in_wind_and_current_finds_the_hull(kind: str) -> None:
    chosen = sailed(kind, "RTK", 1)
    terms = searched(problem_of([voyage(chosen)], body_of(chosen)), lambda _: None).values
    errors = shares(terms, chosen)
    pair = chosen.propellers
    gain = (pair.stbd_gain - pair.port_gain) / (pair.stbd_gain + pair.port_gain)
    late = terms[INDEX["lag"]] + terms[INDEX["dead_time"]] - pair.lag_s
    print(errors, "gain", terms[INDEX["gain"]] - gain, "late", late)
    for name, bound in BOUNDS[kind].items():
        assert abs(errors[name]) < bound, name
    assert abs(terms[INDEX["gain"]] - gain) < 0.03
    assert abs(late) < 0.08
