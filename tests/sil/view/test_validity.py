# SPDX-License-Identifier: MIT
"""Until when a repeated value is valid."""

import pytest

from sil.view.validity import Validity


@pytest.mark.parametrize(
    ("times_s", "until_s"),
    [
        ([0.0], 30.0),
        ([0.0, 1.0], 6.0),
        ([0.0, 10.0], 35.0),
        ([0.0, 10.0, 10.1], 35.0),  # a copy over another link
        ([0.0, 600.0], 660.0),
        ([0.0, 600.0, 601.0], 606.0),
        ([0.02 * k for k in range(101)], 7.0),
    ],
)
def test_a_value_is_valid_for_two_and_a_half_of_its_intervals_within_bounds(
    times_s: list[float], until_s: float
) -> None:
    valid = Validity()
    assert valid.until_s < 0.0
    for now_s in times_s:
        valid.renew(now_s)
    assert valid.until_s == pytest.approx(until_s, abs=0.5)
