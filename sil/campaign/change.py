# SPDX-License-Identifier: MIT
"""Tests whether a figure differs between campaigns A and B by more than chance.

Figures of runs are compared as ratios, by percentile bootstrap of the difference of logarithms:
Efron and Tibshirani, An Introduction to the Bootstrap, 1993, chapter 13. Shares of runs are
compared by exact tests: Fisher's, or McNemar's if the runs are pairs.
"""

import math
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
import scipy  # its parts are imported on first use: stats takes half a second

from sil.campaign.finished import Mask
from sil.plant.hull import Array

Verdict = Literal["better", "worse", "same"]

FALSE_ALARMS = 0.01
"""Greatest share of comparisons of equal code in which any figure is reported as changed."""
MARGIN = 0.01
"""A ratio nearer to 1 does not count as a change, however certain it is."""
_MARGIN_OF_SHARE = 0.01
_MEDIAN, _NEVER = 0.5, 1e9
_RESAMPLES, _BATCH, _SEED = 9999, 500, 20


@dataclass(frozen=True)
class Change:
    """A comparison of a figure between two campaigns.

    `a`, `b`: the figure in both; `ratio`: b/a with its interval, NaN for shares; `p`: p-value of
    shares. For pairs, the ratio of a median figure is the median of the runs' own ratios.
    """

    a: float
    b: float
    verdict: Verdict
    ratio: float = math.nan
    low: float = math.nan
    high: float = math.nan
    p: float = math.nan


def confidence(tests: int) -> float:
    """Confidence level of each interval if `tests` figures are compared at once."""
    return 1.0 - FALSE_ALARMS / tests


def of_ratio(
    a: Array, b: Array, share: float, tests: int, *, least: float, paired: bool, less_is_worse: bool
) -> Change:
    """Compare the quantile `share` of figures `a`, `b` of runs (R), which may be infinite.

    Figures below `least` count as `least`. `tests`: how many figures are compared at once.
    `paired`: a[k] and b[k] belong to the same run.
    """
    logs = tuple(np.log(np.clip(values, least, _NEVER)) for values in (a, b))
    of_each = paired and share == _MEDIAN
    samples = (logs[1] - logs[0],) if of_each else logs

    def statistic(*groups: Array, axis: int = -1) -> Array:
        first, *second = (_quantile(group, share, axis) for group in groups)
        return second[0] - first if second else first

    found: Any = scipy.stats.bootstrap(
        samples,
        statistic,
        paired=paired and not of_each,
        vectorized=True,
        n_resamples=_RESAMPLES,
        batch=_BATCH,
        confidence_level=confidence(tests),
        method="percentile",
        rng=np.random.default_rng(_SEED),
    )
    low, high = found.confidence_interval
    more = low > math.log1p(MARGIN)
    less = high < -math.log1p(MARGIN)
    own, other = (float(_quantile(values, share, -1)) for values in (a, b))
    ratios = [_ratio(float(log)) for log in (statistic(*samples), low, high)]
    return Change(own, other, _verdict(more, less, less_is_worse), *ratios)


def of_share(a: Mask, b: Mask, tests: int, *, paired: bool) -> Change:
    """Compare the shares of runs (R, bool) in which an unwanted event happened."""
    own, other = float(np.mean(a)), float(np.mean(b))
    if paired:
        only_a, only_b = int(np.sum(a & ~b)), int(np.sum(b & ~a))
        p = scipy.stats.binomtest(only_a, only_a + only_b).pvalue if only_a + only_b else 1.0
    else:
        counts = np.array([[np.sum(a), np.sum(~a)], [np.sum(b), np.sum(~b)]])
        p = scipy.stats.fisher_exact(counts).pvalue
    certain = p < FALSE_ALARMS / tests and abs(other - own) > _MARGIN_OF_SHARE
    verdict = _verdict(certain and other > own, certain and other < own, less_is_worse=False)
    return Change(own, other, verdict, p=float(p))


def _verdict(more: bool, less: bool, less_is_worse: bool) -> Verdict:
    if not (more or less):
        return "same"
    return "worse" if less == less_is_worse else "better"


def _quantile(values: Array, share: float, axis: int) -> Array:
    # without interpolation, which is impossible between a number and infinity
    return np.asarray(np.quantile(values, share, axis=axis, method="inverted_cdf"))


def _ratio(log: float) -> float:
    """The ratio from its logarithm; infinite or 0 if only one campaign has the event."""
    far = 0.5 * math.log(_NEVER)
    return math.inf if log > far else 0.0 if log < -far else math.exp(log)
