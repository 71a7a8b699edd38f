# SPDX-License-Identifier: MIT
"""Verdicts on figures of runs with a known, artificial change."""

import math
from functools import partial

import numpy as np
import pytest

from sil.campaign import change
from sil.plant.hull import Array

TESTS = 7
of_ratio = partial(change.of_ratio, tests=TESTS, least=1e-3, less_is_worse=False)


def figures(runs: int, seed: int) -> Array:
    """Figures of runs that differ from each other by half or so."""
    return np.asarray(np.random.default_rng(seed).lognormal(0.0, 0.4, runs))


@pytest.mark.parametrize("share", [0.5, 0.95])
def test_change_of_every_pair_by_a_fifth_is_found_in_both_directions(share: float) -> None:
    a = figures(20, seed=1)
    worse = of_ratio(a, 1.2 * a, share, paired=True)
    better = of_ratio(1.2 * a, a, share, paired=True)
    assert (worse.verdict, better.verdict) == ("worse", "better")
    assert (worse.ratio, better.ratio) == pytest.approx((1.2, 1.0 / 1.2))


def test_a_significant_change_within_the_margin_is_no_change() -> None:
    a = figures(100, seed=2)
    found = of_ratio(a, 1.005 * a, 0.5, paired=True)
    assert found.low == pytest.approx(1.005) and found.verdict == "same"
    assert of_ratio(a, 1.02 * a, 0.5, paired=True).verdict == "worse"


def test_differences_below_the_least_relevant_one_are_equal() -> None:
    tiny = 1e-5 * figures(40, seed=3)
    assert of_ratio(tiny, 10.0 * tiny, 0.5, paired=True).ratio == 1.0


def test_unpaired_interval_has_the_theoretical_width() -> None:
    a, b = figures(400, seed=4), figures(400, seed=5)
    found = of_ratio(a, b, 0.5, paired=False)
    # of a median: √(π/2) σ/√n, of the difference of two √2 times that; 3.2 deviations each way
    half = 3.19 * math.sqrt(2.0) * math.sqrt(math.pi / 2.0) * 0.4 / math.sqrt(400.0)
    assert found.verdict == "same"
    assert 0.5 * math.log(found.high / found.low) == pytest.approx(half, rel=0.3)
    assert of_ratio(a, 1.3 * b, 0.5, paired=False).verdict == "worse"


def test_runs_that_never_settle_are_infinite_and_only_a_new_one_is_a_change() -> None:
    settled, never = figures(40, seed=6), np.full(40, np.inf)
    assert of_ratio(never, never, 0.5, paired=True).ratio == 1.0
    for paired in (True, False):
        found = of_ratio(settled, never, 0.5, paired=paired)
        assert (found.b, found.ratio, found.verdict) == (math.inf, math.inf, "worse")
        assert of_ratio(never, settled, 0.5, paired=paired).verdict == "better"


def test_some_runs_that_never_settle_do_not_move_the_median_to_infinity() -> None:
    some = np.where(np.arange(41) < 15, np.inf, figures(41, seed=7))
    found = of_ratio(figures(41, seed=7), some, 0.5, paired=True)
    assert found.a <= found.b < math.inf and found.ratio == 1.0
    assert of_ratio(some, some, 0.95, paired=True).a == math.inf


def test_boats_that_come_closer_are_worse() -> None:
    a = figures(40, seed=8)
    compare = partial(change.of_ratio, a, tests=TESTS, least=1e-3, less_is_worse=True)
    assert compare(0.8 * a, 0.5, paired=True).verdict == "worse"
    assert compare(1.2 * a, 0.5, paired=True).verdict == "better"


def test_interval_is_the_same_every_time() -> None:
    a, b = figures(40, seed=9), figures(40, seed=10)
    assert of_ratio(a, b, 0.95, paired=False) == of_ratio(a, b, 0.95, paired=False)


def test_pairs_that_diverge_in_one_campaign_only_get_a_sign_test() -> None:
    a, b = np.zeros(100, bool), np.zeros(100, bool)
    a[:30] = b[:30] = True
    b[30:42] = True
    found = change.of_share(a, b, TESTS, paired=True)
    assert found.p == pytest.approx(2.0 * 0.5**12)
    assert (found.a, found.b, found.verdict) == (0.3, 0.42, "worse")
    assert change.of_share(b, a, TESTS, paired=True).verdict == "better"
    b[38:42] = False
    assert change.of_share(a, b, TESTS, paired=True).verdict == "same"


def test_unpaired_shares_get_fishers_exact_test() -> None:
    a, b = np.arange(40) < 0, np.arange(40) < 12
    found = change.of_share(a, b, TESTS, paired=False)
    # all twelve among the one half of eighty, or all among the other
    assert found.p == pytest.approx(2.0 * math.comb(40, 12) / math.comb(80, 12))
    assert found.verdict == "worse"
    assert change.of_share(a, np.arange(40) < 4, TESTS, paired=False).verdict == "same"


def test_share_that_changes_in_less_than_one_run_of_a_hundred_is_no_change() -> None:
    a, b = np.zeros(4000, bool), np.arange(4000) < 30
    assert change.of_share(a, b, TESTS, paired=True).p < 1e-6
    assert change.of_share(a, b, TESTS, paired=True).verdict == "same"
