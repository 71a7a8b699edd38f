# SPDX-License-Identifier: MIT
"""Confidence intervals by bootstrap over windows, and whether the logs determine each number."""

from dataclasses import dataclass

import numpy as np

from sil.identify.equations import Bools, Problem, step, summed
from sil.identify.hull_terms import LOCAL
from sil.identify.output_error import Fit
from sil.identify.voyage_log import Array

DRAWS = 200
# Ratio of a number's standard deviation with the logs to that without: above this, the logs do not
# determine the number.
_UNTOLD = 0.5
_SURE = 0.95


@dataclass(frozen=True)
class Intervals:
    """draws (DRAWS, K): sets of terms that fit as well; determined (K): by the logs."""

    draws: Array
    determined: Bools

    def of(self, values: Array) -> tuple[float, float]:
        """The 95 % interval of a figure that was computed for each draw."""
        low, high = np.quantile(values, [(1.0 - _SURE) / 2.0, (1.0 + _SURE) / 2.0])
        return float(low), float(high)


def intervals(problem: Problem, fit: Fit, seed: int = 1) -> Intervals:
    """Bootstrap: draws windows with replacement; each draw is one Gauss-Newton step from the fit.

    Each draw also gets the spread of a step itself, including that of the first guesses. Without
    it, all draws would agree on a number that the windows do not affect. Source: Efron and
    Tibshirani 1993, chapter 9.
    """
    rng = np.random.default_rng(seed)
    count = len(problem.windows)
    free = int(problem.free.sum())
    terms = [t for t, searched in zip(problem.terms, problem.free, strict=True) if searched]
    guess, spread = (np.array([getattr(t, n) for t in terms]) for n in ("guess", "spread"))
    places = np.array([[t.guess, t.spread] for t in LOCAL])
    local = ((fit.local - places[:, 0]) / places[:, 1]).ravel()
    at = np.concatenate([(fit.values[problem.free] - guess) / spread, local])
    h, _ = summed(problem, fit.equations, np.ones(count))
    inverse = np.linalg.inv(h + np.eye(len(h)))[:free, :free]
    root = np.linalg.cholesky(inverse + 1e-12 * np.eye(free))
    draws = np.tile(fit.values, (DRAWS, 1))
    for draw in draws:
        counts = np.bincount(rng.integers(0, count, count), minlength=count).astype(float)
        z = at[:free] + step(problem, *summed(problem, fit.equations, counts), at, 0.0)[:free]
        z += root @ rng.normal(size=free)
        low = np.array([(t.least - t.guess) / t.spread for t in terms])
        high = np.array([(t.greatest - t.guess) / t.spread for t in terms])
        draw[problem.free] = guess + spread * np.clip(z, low, high)
    determined = np.zeros(len(fit.values), dtype=bool)
    determined[problem.free] = np.sqrt(np.diag(inverse)) < _UNTOLD
    return Intervals(draws, determined)
