# SPDX-License-Identifier: MIT
"""Output error: the terms with which open-loop simulation comes nearest to the logs.

Minimises Σ |(measured − simulated) / σ|² / κ + Σ z² over the terms z (in deviations from their
guesses), current and push of each log, and of each window its gust and the state in which it
begins. What is a window's own is eliminated window by window (variable projection: Golub and
Pereyra 1973), the rest is a damped Gauss-Newton step within bounds. κ samples of a residual count
as one, since they are alike.
σ of each channel is the residuals' own, found in rounds.
Source: Jategaonkar, Flight Vehicle System Identification, 2nd ed., chapters 4, 5 and 9.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt
from scipy.optimize import lsq_linear

from sil.identify.hull_terms import GUSTS, LOCAL, Term
from sil.identify.voyage_log import Array
from sil.identify.voyage_model import Body, simulate
from sil.identify.windows import Windows

Bools = npt.NDArray[np.bool_]
Told = Callable[[float], None]


@dataclass(frozen=True)
class Schedule:
    """How a search goes.

    rounds: gate (of the dead band, wide at first to be found from afar), share of each window that
    counts. odd: a window above so many times the median window's cost counts less.
    """

    rounds: tuple[tuple[float, float], ...]
    odd: float = np.inf


# A boat of which a log tells little needs whole windows. An unstable one is soon far from where
# first guesses take it: it needs their begin first, and some of its windows say nothing.
AT_ONCE = Schedule(((0.5, 1.0), (0.2, 1.0), (0.05, 1.0)))
BY_AND_BY = Schedule(((0.5, 0.25), (0.2, 0.5), (0.05, 1.0)), odd=5.0)

# m, m, rad, m/s, m/s, rad/s: the first round's deviations, and the least that later ones take.
_FIRST_SIGMA = np.array([0.5, 0.5, 0.1, 0.1, 0.1, 0.05])
_LEAST_SIGMA = np.array([0.02, 0.02, 0.005, 0.01, 0.01, 0.005])
_ALIKE = 100.0  # κ: a window of a channel
_STEP = 1e-3  # of a finite difference, in deviations
_ITERATIONS = 12
_SHARES = (1.0, 0.3, 0.0)
_EARLY = 5  # samples
_STATES, _PLACES, _GUSTS = 6, len(LOCAL), len(GUSTS)
_OWN = _STATES + _GUSTS
_LOCAL_GUESS = np.array([term.guess for term in LOCAL])
_LOCAL_SPREAD = np.array([term.spread for term in LOCAL])
_GUST_SPREAD = np.array([term.spread for term in GUSTS])


@dataclass(frozen=True)
class Problem:
    """Windows, hull, terms (with guesses for this hull) and which of them are searched."""

    windows: Windows
    body: Body
    terms: tuple[Term, ...]
    free: Bools

    @property
    def logs(self) -> int:
        """How many logs the windows come from."""
        return int(self.windows.log.max()) + 1


@dataclass(frozen=True)
class Fit:
    """values (K) of the terms; local (logs, 4); start (6, W); σ; equations of each window."""

    values: Array
    local: Array
    start: Array
    sigma: Array
    cost: float
    equations: "Equations"


@dataclass(frozen=True)
class Equations:
    """Of W windows without what is their own: A δ = e as AᵀA (W, n, n) and Aᵀe (W, n)."""

    squares: Array
    right: Array
    back: Callable[[Array], Array]

    def counted(self, counts: Array) -> "Equations":
        """Each window counted so often."""
        return replace(
            self,
            squares=self.squares * counts[:, None, None],
            right=self.right * counts[:, None],
        )


@dataclass(frozen=True)
class _Point:
    z: Array  # (free terms)
    local: Array  # (logs, 4), in deviations
    start: Array  # (6, W)
    gust: Array  # (3, W), in deviations


def fit(whole: Problem, values: Array, schedule: Schedule, told: Told) -> Fit:
    """Search from `values` (K); told(share) hears of the progress."""
    guess, spread = _scale(whole)
    z = ((values - guess) / spread)[whole.free]
    count = len(whole.windows)
    places, gusts = np.zeros((whole.logs, _PLACES)), np.zeros((_GUSTS, count))
    point = _Point(z, places, first_start(whole.windows), gusts)
    problem, sigma = whole, _FIRST_SIGMA
    costs = np.zeros(count)
    for turn, (gate, share) in enumerate(schedule.rounds):
        if turn > 0:
            sigma = _spread_of(problem, point, values)
        body, windows = replace(whole.body, gate=gate), whole.windows.begun(share)
        problem = replace(whole, body=body, windows=windows)
        part = part_of(told, turn / len(schedule.rounds), (turn + 1) / len(schedule.rounds))
        point, costs = _descend(problem, point, values, sigma, schedule.odd, part)
    equations = _equations(problem, point, values, sigma)
    equations = equations.counted(_counts(costs, schedule.odd))
    local = _LOCAL_GUESS + point.local * _LOCAL_SPREAD
    full = _full(problem, point.z, values)
    cost = _cost(point, costs, schedule.odd)
    return Fit(full, local, point.start, sigma, cost, equations)


def part_of(told: Told, begin: float, end: float) -> Told:
    """Progress of one part of a longer work."""
    return lambda share: told(begin + share * (end - begin))


def first_start(windows: Windows) -> Array:
    """State (6, W) with which each window begins as measured.

    Position and heading of the first sample; velocities on a straight line through the first.
    """
    t = np.arange(_EARLY) - (_EARLY - 1) / 2.0
    early = np.nan_to_num(windows.measured[:_EARLY])
    slope = np.einsum("s,skw->kw", t, early) / (t @ t)
    begin = early.mean(axis=0) + t[0] * slope
    return np.vstack([early[0, :3], begin[3:]])


def residuals(problem: Problem, values: Array, places: Array, start: Array) -> Array:
    """Measured minus simulated (samples, 6, W), NaN where nothing was measured.

    places (5, W): current and push, north and east, and a moment.
    """
    windows = problem.windows
    out = simulate(
        values[:, None], places[:, :, None], start[:, :, None], windows.commands, problem.body
    )
    return windows.measured - out[:, :, :, 0]


def _places(problem: Problem, point: _Point) -> Array:
    """Current, push and moment in each window (5, W)."""
    local = (_LOCAL_GUESS + point.local * _LOCAL_SPREAD)[problem.windows.log].T
    gust = point.gust * _GUST_SPREAD[:, None]
    return np.vstack([local[:2], local[2:] + gust[:2], gust[2:]])


def _scale(problem: Problem) -> tuple[Array, Array]:
    return (
        np.array([term.guess for term in problem.terms]),
        np.array([term.spread for term in problem.terms]),
    )


def _full(problem: Problem, z: Array, values: Array) -> Array:
    guess, spread = _scale(problem)
    out = values.copy()
    out[problem.free] = guess[problem.free] + z * spread[problem.free]
    return out


def _descend(
    problem: Problem, point: _Point, values: Array, sigma: Array, odd: float, told: Told
) -> tuple[_Point, Array]:
    """Down to the lowest point within reach; there, the cost of each window."""
    damping = 1e-2
    costs = _costs(problem, point, values, sigma)
    for turn in range(_ITERATIONS):
        told(turn / _ITERATIONS)
        equations = _equations(problem, point, values, sigma)
        equations = equations.counted(_counts(costs, odd))
        before = cost = _cost(point, costs, odd)
        for _ in range(6):
            moved = _moved(problem, point, equations, damping)
            trial, there = _eased(problem, point, moved, values, sigma)
            if _cost(trial, there, odd) < before:
                point, costs, damping = trial, there, max(damping * 0.1, 1e-6)
                cost = _cost(point, costs, odd)
                break
            damping *= 10.0
        if before - cost < 1e-4 * before:
            break
    return point, costs


def _costs(problem: Problem, point: _Point, values: Array, sigma: Array) -> Array:
    """Of each window (W): its errors, and what is believed of its gust."""
    places = _places(problem, point)
    error = residuals(problem, _full(problem, point.z, values), places, point.start)
    scaled = np.nan_to_num(error / sigma[:, None])
    costs: Array = (scaled**2).sum(axis=(0, 1)) / _ALIKE + (point.gust**2).sum(axis=0)
    return costs


def _cost(point: _Point, costs: Array, odd: float) -> float:
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
    problem: Problem, point: _Point, moved: _Point, values: Array, sigma: Array
) -> tuple[_Point, Array]:
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


def _spread_of(problem: Problem, point: _Point, values: Array) -> Array:
    places = _places(problem, point)
    error = residuals(problem, _full(problem, point.z, values), places, point.start)
    with np.errstate(invalid="ignore"):
        rms = np.sqrt(np.nanmean(error**2, axis=(0, 2)))
    rms[:2] = np.sqrt((rms[:2] ** 2).mean())
    sigma: Array = np.maximum(np.nan_to_num(rms, nan=1.0), _LEAST_SIGMA)
    return sigma


def _equations(problem: Problem, point: _Point, values: Array, sigma: Array) -> Equations:
    """Derivatives by differences, all columns in one simulation; a window's own go by QR."""
    windows, free = problem.windows, int(problem.free.sum())
    shared = free + _PLACES
    out, steps = _perturbed(problem, point, values)
    weight = np.isfinite(windows.measured) / (sigma[:, None] * _ALIKE**0.5)
    error = np.nan_to_num(windows.measured - out[..., 0]) * weight
    slopes = (out[..., 1:] - out[..., :1]) / steps * weight[..., None]
    count = len(windows)
    e = np.moveaxis(error, 2, 0).reshape(count, -1)
    j = np.moveaxis(slopes, 2, 0).reshape(count, e.shape[1], -1)
    # The rows of what is believed of a window's gust.
    e = np.hstack([e, -point.gust.T])
    believed = np.zeros((count, _GUSTS, j.shape[2]))
    believed[:, :, shared + _STATES :] = np.eye(_GUSTS)
    j = np.concatenate([j, believed], axis=1)
    q, r = np.linalg.qr(j[:, :, shared:])
    turned = np.swapaxes(q, 1, 2)
    onto, seen = (turned @ e[:, :, None])[:, :, 0], turned @ j[:, :, :shared]
    rest = j[:, :, :shared] - q @ seen
    ridge = r + 1e-9 * np.eye(_OWN)

    def back(delta: Array) -> Array:
        """Change of the windows' own (9, W) that goes with (W, n) changes of the rest."""
        right = onto - np.einsum("wkn,wn->wk", seen, delta)
        return np.linalg.solve(ridge, right[:, :, None])[:, :, 0].T

    turned = np.swapaxes(rest, 1, 2)
    return Equations(turned @ rest, (turned @ e[:, :, None])[:, :, 0], back)


def _perturbed(problem: Problem, point: _Point, values: Array) -> tuple[Array, Array]:
    """Simulated (samples, 6, W, 1 + n): as it is, then each number changed by its step (n)."""
    free = int(problem.free.sum())
    columns = 1 + free + _PLACES + _OWN
    full = _full(problem, point.z, values)
    terms = np.repeat(full[:, None], columns, axis=1)
    places = np.repeat(_places(problem, point)[:, :, None], columns, axis=2)
    start = np.repeat(point.start[:, :, None], columns, axis=2)
    steps = np.full(columns, _STEP)
    for c, k in enumerate(np.flatnonzero(problem.free), start=1):
        term = problem.terms[k]
        if full[k] + _STEP * term.spread > term.greatest:
            steps[c] = -_STEP
        terms[k, c] += steps[c] * term.spread
    for c, spread in enumerate(_LOCAL_SPREAD):
        places[c, :, 1 + free + c] += _STEP * spread
    for c in range(_STATES):
        start[c, :, 1 + free + _PLACES + c] += _STEP
    for c, spread in enumerate(_GUST_SPREAD):
        places[2 + c, :, 1 + free + _PLACES + _STATES + c] += _STEP * spread
    return simulate(terms, places, start, problem.windows.commands, problem.body), steps[1:]


def summed(problem: Problem, equations: Equations, counts: Array) -> tuple[Array, Array]:
    """All windows' equations as one: terms first, then each log's places; each counted so often."""
    free = int(problem.free.sum())
    size = free + _PLACES * problem.logs
    h, g = np.zeros((size, size)), np.zeros(size)
    for number in range(problem.logs):
        mine = problem.windows.log == number
        at = np.r_[0:free, free + _PLACES * number : free + _PLACES * (number + 1)]
        h[np.ix_(at, at)] += np.einsum("w,wnk->nk", counts[mine], equations.squares[mine])
        g[at] += counts[mine] @ equations.right[mine]
    return h, g


def _moved(problem: Problem, point: _Point, equations: Equations, damping: float) -> _Point:
    h, g = summed(problem, equations, np.ones(len(problem.windows)))
    delta = step(problem, h, g, np.concatenate([point.z, point.local.ravel()]), damping)
    free = int(problem.free.sum())
    least, greatest = _bounds(problem)
    local = delta[free:].reshape(problem.logs, _PLACES)
    each = np.hstack([np.tile(delta[:free], (len(problem.windows), 1)), local[problem.windows.log]])
    own = equations.back(each)
    return replace(
        point,
        z=np.clip(point.z + delta[:free], least[:free], greatest[:free]),
        local=point.local + local,
        start=point.start + own[:_STATES],
        gust=point.gust + own[_STATES:],
    )


def step(problem: Problem, h: Array, g: Array, at: Array, damping: float) -> Array:
    """The bounded step from `at` (deviations) that the equations and what is believed ask for."""
    h = h + np.eye(len(h))
    g = g - at
    h[np.diag_indices_from(h)] *= 1.0 + damping
    root = np.linalg.cholesky(h)
    least, greatest = _bounds(problem)
    low, high = np.minimum(least - at, -1e-12), np.maximum(greatest - at, 1e-12)
    return lsq_linear(root.T, np.linalg.solve(root, g), (low, high), method="bvls").x


def _bounds(problem: Problem) -> tuple[Array, Array]:
    searched = [t for t, free in zip(problem.terms, problem.free, strict=True) if free]
    searched += list(LOCAL) * problem.logs
    return (
        np.array([(t.least - t.guess) / t.spread for t in searched]),
        np.array([(t.greatest - t.guess) / t.spread for t in searched]),
    )
