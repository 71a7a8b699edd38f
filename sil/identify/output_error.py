# SPDX-License-Identifier: MIT
"""Output error: the terms with which open-loop simulation comes nearest to the logs.

Minimises Σ |(measured − simulated) / σ|² / κ + Σ z² over the terms z (in deviations from their
guesses), current and wind of each log, and of each window its gust and the state in which it
begins: a damped Gauss-Newton step within bounds, again and again (`equations`). κ samples of a
residual count as one: κ = 1 + 2 Σ ρ_k, where neighbours at k samples correlate by ρ_k, or a whole
window. σ of each channel is the residuals' own; both are found in rounds.
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
    """How a search goes.

    rounds: gate (of the dead band, wide at first to be found from afar), share of each window that
    counts. alike: κ; None: as the residuals' neighbours correlate. gusts: as `Problem` has them.
    odd: a window above so many times the median window's cost counts less.
    """

    rounds: tuple[tuple[float, float], ...]
    alike: float | None = None
    gusts: float = 1.0
    odd: float = np.inf


# A boat of which a log tells little needs whole windows, and what is believed of its terms. An
# unstable one is soon far from where first guesses take it: it needs their begin first, and some of
# its windows say nothing.
AT_ONCE = Schedule(((0.5, 1.0), (0.2, 1.0), (0.05, 1.0)), alike=_ALIKE)
BY_AND_BY = Schedule(((0.5, 0.25), (0.2, 0.5), (0.05, 1.0)), gusts=3.0, odd=5.0)

# m, m, rad, m/s, m/s, rad/s: the first round's deviations, and the least that later ones take.
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
    """Search from `values` (K); told(share) hears of the progress."""
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
    """Down to the lowest point within reach; there, the cost of each window."""
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
    """Of each window (W): its errors, and what is believed of its gust."""
    places = places_of(problem, point)
    error = residuals(problem, values_of(problem, point.z, values), places, point.start)
    scaled = np.nan_to_num(error / sigma[:, None])
    costs: Array = (scaled**2).sum(axis=(0, 1)) + (point.gust**2).sum(axis=0)
    return costs


def _cost(point: Point, costs: Array, odd: float) -> float:
    """Of all, with Cauchy's loss above `odd` medians."""
    if np.isfinite(odd):
        limit = odd * np.median(costs)
        costs = limit * np.log1p(costs / limit)
    return float(costs.sum() + (point.z**2).sum() + (point.local**2).sum())


def _counts(costs: Array, odd: float) -> Array:
    """How much each window counts in a step, Cauchy's weights."""
    counts: Array = 1.0 / (1.0 + costs / (odd * np.median(costs)))
    return counts


def _eased(
    problem: Problem, point: Point, moved: Point, values: Array, sigma: Array
) -> tuple[Point, Array]:
    """`moved`, but of its own way each window goes the share of `_SHARES` that costs least.

    A window in which the boat is unstable may be off after a whole step, however short that of the
    terms is, and would stop the search of all.
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
    """The residuals' deviations (6), times √κ."""
    places = places_of(problem, point)
    error = residuals(problem, values_of(problem, point.z, values), places, point.start)
    with np.errstate(invalid="ignore"):
        rms = np.sqrt(np.nanmean(error**2, axis=(0, 2)))
    rms[:2] = np.sqrt((rms[:2] ** 2).mean())
    kappa = [alike or _alike(np.nan_to_num(error[:, k])) for k in range(len(rms))]
    sigma: Array = np.maximum(np.nan_to_num(rms, nan=1.0), _LEAST_SIGMA) * np.sqrt(kappa)
    return sigma


def _alike(error: Array) -> float:
    """κ of residuals (samples, W): correlation of neighbours, up to the first that has none."""
    whole = float((error**2).sum())
    kappa = 1.0
    for k in range(1, len(error)):
        rho = float((error[k:] * error[:-k]).sum()) / max(whole, 1e-30)
        if rho < _NONE:
            break
        kappa += 2.0 * rho
    return min(kappa, _ALIKE)
