# SPDX-License-Identifier: MIT
"""The short form of `python -m tests.loop.random_trees`."""

from collections import Counter
from pathlib import Path

import pytest

from sil.scenario.scenario import Scenario
from tests.loop.random_trees import IN_SLOTS, WANTED, End, certified, draw, ends, in_slots

MUST_NOT_BE = {"driven astray", "spinning"}


@pytest.mark.parametrize(
    "runs", [range(8), pytest.param(range(200), marks=pytest.mark.nightly)], ids=str
)
def test_nearly_all_random_trees_end_in_their_slots_and_none_ends_astray(
    runs: range, tmp_path: Path
) -> None:
    found = ends({number: draw(number, tmp_path) for number in runs})
    words = Counter(end.word if isinstance(end, End) else end for end in found.values())
    assert not MUST_NOT_BE & words.keys(), words
    assert words[IN_SLOTS] >= 0.9 * len(runs), words


@pytest.mark.parametrize(
    "runs", [range(5, 6), pytest.param(range(1, 60), marks=pytest.mark.nightly)], ids=str
)
def test_the_certificate_passes_most_random_trees_and_they_end_in_their_slots(
    runs: range, tmp_path: Path
) -> None:
    drawn = {number: draw(number, tmp_path) for number in runs}
    passed = certified(drawn)
    assert len(passed) >= 0.85 * len(runs)  # 88 % of 1,000 trees are certified
    assert in_slots(passed, ends(drawn)) >= WANTED


def test_the_certificate_passes_no_deep_tree_that_does_not_steer_by_the_reference(
    tmp_path: Path,
) -> None:
    assert certified({0: without_reference(draw(1, tmp_path))}) == set()


def without_reference(tree: Scenario) -> Scenario:
    return tree.model_copy(update={"parameters": {**tree.parameters, "LAW_REF": 0.0}})
