# SPDX-License-Identifier: MIT
"""JSON for the page, whatever the numbers."""

import json
from math import inf, nan

from sil.view.plain_json import json_of


def test_numbers_that_are_not_finite_are_null_and_all_else_is_kept() -> None:
    value = {"t_s": 1.5, "vessels": [{"x_m": nan, "slot": (inf, 2.0), "text": "é"}, None, True, 3]}
    assert json.loads(json_of(value)) == {
        "t_s": 1.5,
        "vessels": [{"x_m": None, "slot": [None, 2.0], "text": "é"}, None, True, 3],
    }
