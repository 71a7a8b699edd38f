# SPDX-License-Identifier: MIT
"""Output error: finds the terms with which an open-loop simulation comes nearest to the logs.

Minimises Σ |(measured − simulated) / σ|² / κ + Σ z² by damped Gauss-Newton steps within bounds
(`equations`). Unknown are the terms z (in deviations from their guesses), current and wind of each
log, and gust and initial state of each window. κ samples of a residual count as one:
κ = 1 + 2 Σ ρ_k, where ρ_k is the correlation of samples k apart; at most a whole window. σ of each
channel is the standard deviation of its residuals. σ and κ are updated in each round.
Source: Jategaonkar, Flight Vehicle System Identification, 2nd ed., chapters 4, 5 and 9.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from sil.identify.equations import (
    Equations,
    Point,
    Problem,
    equations_of,
    local_of,
    moved_by,
    places_of,
    residuals,
    scale_of,
    values_of,
)
from sil.identify.hull_terms import GUSTS, LOCAL
from sil.identify.voyage_log import Array
from sil.identify.windows import first_start

Told = Callable[[float], None]


# A window of a channel.
_ALIKE = 100.0


@dataclass(frozen=True)
class Schedule:
    """The settings of a search.

    rounds: for each, the gate of the dead band (wide at first, so that the search finds it from
    afar), and the share of each window that is used. alike: κ; None: from the residuals'
    correlation. gusts: as in `Problem`. odd: a window whose cost exceeds the median by this factor
    counts less.
    """

    rounds: tuple[tuple[float, float], ...]
    alike: float | None = None
    gusts: float = 1.0
    odd: float = np.inf


# If a log contains little information, the search needs whole windows and the terms' priors. An
# unstable boat soon diverges from a simulation with the first guesses: its search begins with the
# first part of each window, and some of its windows contain no information.
AT_ONCE = Schedule(((0.5, 1.0), (0.2, 1.0), (0.05, 1.0)), alike=_ALIKE)
BY_AND_BY = Schedule(((0.5, 0.25), (0.2, 0.5), (0.05, 1.0)), gusts=3.0, odd=5.0)

# m, m, rad, m/s, m/s, rad/s: σ in the first round, and the least σ in later rounds.
_FIRST_SIGMA = 10.0 * np.array([0.5, 0.5, 0.1, 0.1, 0.1, 0.05])
_LEAST_SIGMA = np.array([0.02, 0.02, 0.005, 0.01, 0.01, 0.005])
_ITERATIONS = 12
_SHARES = (1.0, 0.3, 0.0)
_NONE = 0.02  # of a correlation


@dataclass(frozen=True)
class Fit:
    """values (K) of the terms; local (logs, 4); start (6, W); σ √κ; equations of each window."""

    values: Array
    local: Array
    start: Array
    sigma: Array
    cost: float
    equations: Equations


def fit(whole: Problem, values: Array, schedule: Schedule, told: Told) -> Fit:
    """Search from `values` (K); calls told(share) with the progress."""
    whole = replace(whole, gusts=schedule.gusts)
    guess, deviation = scale_of(whole)
    z = ((values - guess) / deviation)[whole.free]
    count = len(whole.windows)
    places, gusts = np.zeros((whole.logs, len(LOCAL))), np.zeros((len(GUSTS), count))
    point = Point(z, places, first_start(whole.windows), gusts)
    problem, sigma = whole, _FIRST_SIGMA
    costs = np.zeros(count)
    for turn, (gate, share) in enumerate(schedule.rounds):
        if turn > 0:
            sigma = _sigma_of(problem, point, values, schedule.alike)
        body, windows = replace(whole.body, gate=gate), whole.windows.begun(share)
        problem = replace(whole, body=body, windows=windows)
        part = part_of(told, turn / len(schedule.rounds), (turn + 1) / len(schedule.rounds))
        point, costs = _descend(problem, point, values, sigma, schedule.odd, part)
    equations = equations_of(problem, point, values, sigma)
    equations = equations.counted(_counts(costs, schedule.odd))
    local = local_of(point)
    full = values_of(problem, point.z, values)
    cost = _cost(point, costs, schedule.odd)
    return Fit(full, local, point.start, sigma, cost, equations)


def part_of(told: Told, begin: float, end: float) -> Told:
    """Progress of one part of a longer work."""
    return lambda share: told(begin + share * (end - begin))


def _descend(
    problem: Problem, point: Point, values: Array, sigma: Array, odd: float, told: Told
) -> tuple[Point, Array]:
    """The lowest point that the steps reach, and the cost of each window there."""
    damping = 1e-2
    costs = _costs(problem, point, values, sigma)
    for turn in range(_ITERATIONS):
        told(turn / _ITERATIONS)
        equations = equations_of(problem, point, values, sigma)
        equations = equations.counted(_counts(costs, odd))
        before = cost = _cost(point, costs, odd)
        for _ in range(6):
            moved = moved_by(problem, point, equations, damping)
            trial, there = _eased(problem, point, moved, values, sigma)
            if _cost(trial, there, odd) < before:
                point, costs, damping = trial, there, max(damping * 0.1, 1e-6)
                cost = _cost(point, costs, odd)
                break
            damping *= 10.0
        if before - cost < 1e-4 * before:
            break
    return point, costs


def _costs(problem: Problem, point: Point, values: Array, sigma: Array) -> Array:
    """Cost of each window (W): its errors and the prior of its gust."""
    places = places_of(problem, point)
    error = residuals(problem, values_of(problem, point.z, values), places, point.start)
    scaled = np.nan_to_num(error / sigma[:, None])
    costs: Array = (scaled**2).sum(axis=(0, 1)) + (point.gust**2).sum(axis=0)
    return costs


def _cost(point: Point, costs: Array, odd: float) -> float:
    """Cost of all windows, with Cauchy's loss above `odd` times the median."""
    if np.isfinite(odd):
        limit = odd * np.median(costs)
        costs = limit * np.log1p(costs / limit)
    return float(costs.sum() + (point.z**2).sum() + (point.local**2).sum())


def _counts(costs: Array, odd: float) -> Array:
    """Weight of each window in a step: Cauchy's weights."""
    counts: Array = 1.0 / (1.0 + costs / (odd * np.median(costs)))
    return counts


def _eased(
    problem: Problem, point: Point, moved: Point, values: Array, sigma: Array
) -> tuple[Point, Array]:
    """`moved`, but each window's own unknowns move by the share of `_SHARES` that costs least.

    Where the boat is unstable, a window may diverge after a whole step of its own unknowns, however
    short the terms' step is. Such a window would stop the whole search.
    """
    least = np.full(len(problem.windows), np.inf)
    best = moved
    for share in _SHARES:
        start = point.start + share * (moved.start - point.start)
        gust = point.gust + share * (moved.gust - point.gust)
        costs = _costs(problem, replace(moved, start=start, gust=gust), values, sigma)
        better = costs < least
        best = replace(
            best,
            start=np.where(better, start, best.start),
            gust=np.where(better, gust, best.gust),
        )
        least = np.minimum(least, costs)
    return best, least


def _sigma_of(problem: Problem, point: Point, values: Array, alike: float | None) -> Array:
    """The residuals' standard deviations (6), times √κ."""
    places = places_of(problem, point)
    error = residuals(problem, values_of(problem, point.z, values), places, point.start)
    with np.errstate(invalid="ignore"):
        rms = np.sqrt(np.nanmean(error**2, axis=(0, 2)))
    rms[:2] = np.sqrt((rms[:2] ** 2).mean())
    kappa = [alike or _alike(np.nan_to_num(error[:, k])) for k in range(len(rms))]
    sigma: Array = np.maximum(np.nan_to_num(rms, nan=1.0), _LEAST_SIGMA) * np.sqrt(kappa)
    return sigma


def _alike(error: Array) -> float:
    """κ of residuals (samples, W): sums correlations up to the first lag that has none."""
    whole = float((error**2).sum())
    kappa = 1.0
    for k in range(1, len(error)):
        rho = float((error[k:] * error[:-k]).sum()) / max(whole, 1e-30)
        if rho < _NONE:
            break
        kappa += 2.0 * rho
    return min(kappa, _ALIKE)
