# SPDX-License-Identifier: MIT
"""The short form of `python -m tests.loop.random_trees`."""

from collections import Counter
from pathlib import Path

import pytest

from tests.loop.random_trees import End, ends

MUST_NOT_BE = {"driven astray", "spinning"}


@pytest.mark.parametrize(
    "runs", [range(20), pytest.param(range(20, 200), marks=pytest.mark.nightly)], ids=str
)
def test_of_random_trees_nearly_all_end_in_their_slots_and_no_boat_is_driven_astray(
    runs: range, tmp_path: Path
) -> None:
    found = ends(runs, tmp_path)
    words = Counter(end.word if isinstance(end, End) else end for end in found.values())
    assert not MUST_NOT_BE & words.keys(), words
    assert words["all in their slots"] >= 0.9 * len(runs), words
