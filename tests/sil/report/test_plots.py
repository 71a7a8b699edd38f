# SPDX-License-Identifier: MIT
import pytest

from sil.report.plots import decimal


@pytest.mark.parametrize(
    ("value", "label"), [(9.999999999999999e-06, "0.00001"), (0.01, "0.01"), (100.0, "100")]
)
def test_a_tick_is_labelled_by_its_decade(value: float, label: str) -> None:
    assert decimal(value) == label
