# SPDX-License-Identifier: MIT
"""Output error: the terms with which open-loop simulation comes nearest to the logs.

Minimises Σ |(measured − simulated) / σ|² / κ + Σ z² over the terms z (in deviations from their
guesses), current and push of each log, and the state in which each window begins. The beginnings
are eliminated window by window (variable projection: Golub and Pereyra 1973), the rest is a damped
Gauss-Newton step within bounds. κ samples of a residual count as one, since they are alike.
σ of each channel is the residuals' own, found in rounds.
Source: Jategaonkar, Flight Vehicle System Identification, 2nd ed., chapters 4 and 5.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt
from scipy.optimize import lsq_linear

from sil.identify.hull_terms import LOCAL, Term
from sil.identify.voyage_log import Array
from sil.identify.voyage_model import Body, simulate
from sil.identify.windows import Windows

Bools = npt.NDArray[np.bool_]
Told = Callable[[float], None]

# m, m, rad, m/s, m/s, rad/s: the first round's deviations, and the least that later ones take.
_FIRST_SIGMA = np.array([0.5, 0.5, 0.1, 0.1, 0.1, 0.05])
_LEAST_SIGMA = np.array([0.02, 0.02, 0.005, 0.01, 0.01, 0.005])
_ALIKE = 100.0  # κ: a window of a channel
_STEP = 1e-3  # of a finite difference, in deviations
_ROUNDS = 3
_ITERATIONS = 12
_EARLY = 5  # samples
_STATES, _PLACES = 6, len(LOCAL)
_LOCAL_GUESS = np.array([term.guess for term in LOCAL])
_LOCAL_SPREAD = np.array([term.spread for term in LOCAL])


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
    """Of W windows without their beginnings: A δ = e as AᵀA (W, n, n) and Aᵀe (W, n)."""

    squares: Array
    right: Array
    back: Callable[[Array], Array]


@dataclass(frozen=True)
class _Point:
    z: Array  # (free terms)
    local: Array  # (logs, 4), in deviations
    start: Array  # (6, W)


def fit(problem: Problem, values: Array, told: Told, rounds: int = _ROUNDS) -> Fit:
    """Search from `values` (K); told(share) hears of the progress."""
    guess, spread = _scale(problem)
    z = ((values - guess) / spread)[problem.free]
    point = _Point(z, np.zeros((problem.logs, _PLACES)), first_start(problem.windows))
    sigma = _FIRST_SIGMA
    cost = 0.0
    for turn in range(rounds):
        part = part_of(told, turn / rounds, (turn + 1) / rounds)
        point, cost = _descend(problem, point, values, sigma, part)
        if turn < rounds - 1:
            sigma = _spread_of(problem, point, values)
    equations = _equations(problem, point, values, sigma)
    local = _LOCAL_GUESS + point.local * _LOCAL_SPREAD
    return Fit(_full(problem, point.z, values), local, point.start, sigma, cost, equations)


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


def residuals(problem: Problem, values: Array, local: Array, start: Array) -> Array:
    """Measured minus simulated (samples, 6, W), NaN where nothing was measured."""
    places = local[problem.windows.log].T[:, :, None]
    out = simulate(
        values[:, None], places, start[:, :, None], problem.windows.commands, problem.body
    )
    return problem.windows.measured - out[:, :, :, 0]


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
    problem: Problem, point: _Point, values: Array, sigma: Array, told: Told
) -> tuple[_Point, float]:
    damping = 1e-2
    cost = _cost(problem, point, values, sigma)
    for turn in range(_ITERATIONS):
        told(turn / _ITERATIONS)
        equations = _equations(problem, point, values, sigma)
        before = cost
        for _ in range(6):
            trial = _moved(problem, point, equations, damping)
            there = _cost(problem, trial, values, sigma)
            if there < cost:
                point, cost, damping = trial, there, max(damping * 0.1, 1e-6)
                break
            damping *= 10.0
        if before - cost < 1e-4 * before:
            break
    return point, cost


def _cost(problem: Problem, point: _Point, values: Array, sigma: Array) -> float:
    local = _LOCAL_GUESS + point.local * _LOCAL_SPREAD
    error = residuals(problem, _full(problem, point.z, values), local, point.start)
    scaled = np.nan_to_num(error / sigma[:, None])
    prior = (point.z**2).sum() + (point.local**2).sum()
    return float((scaled**2).sum() / _ALIKE + prior)


def _spread_of(problem: Problem, point: _Point, values: Array) -> Array:
    local = _LOCAL_GUESS + point.local * _LOCAL_SPREAD
    error = residuals(problem, _full(problem, point.z, values), local, point.start)
    with np.errstate(invalid="ignore"):
        rms = np.sqrt(np.nanmean(error**2, axis=(0, 2)))
    rms[:2] = np.sqrt((rms[:2] ** 2).mean())
    sigma: Array = np.maximum(np.nan_to_num(rms, nan=1.0), _LEAST_SIGMA)
    return sigma


def _equations(problem: Problem, point: _Point, values: Array, sigma: Array) -> Equations:
    """Derivatives by differences, all columns in one simulation; beginnings eliminated by QR."""
    windows, free = problem.windows, int(problem.free.sum())
    count = len(windows)
    columns = 1 + free + _PLACES + _STATES
    full = _full(problem, point.z, values)
    terms = np.repeat(full[:, None], columns, axis=1)
    local = (_LOCAL_GUESS + point.local * _LOCAL_SPREAD)[windows.log].T
    places = np.repeat(local[:, :, None], columns, axis=2)
    start = np.repeat(point.start[:, :, None], columns, axis=2)
    steps = np.empty(columns)
    for c, k in enumerate(np.flatnonzero(problem.free)):
        term = problem.terms[k]
        step = _STEP if full[k] + _STEP * term.spread <= term.greatest else -_STEP
        terms[k, 1 + c] += step * term.spread
        steps[1 + c] = step
    for c in range(_PLACES):
        places[c, :, 1 + free + c] += _STEP * _LOCAL_SPREAD[c]
        steps[1 + free + c] = _STEP
    for c in range(_STATES):
        start[c, :, 1 + free + _PLACES + c] += _STEP
        steps[1 + free + _PLACES + c] = _STEP
    out = simulate(terms, places, start, windows.commands, problem.body)
    weight = np.isfinite(windows.measured) / (sigma[:, None] * _ALIKE**0.5)
    error = np.nan_to_num(windows.measured - out[..., 0]) * weight
    slopes = (out[..., 1:] - out[..., :1]) / steps[1:] * weight[..., None]
    e = np.moveaxis(error, 2, 0).reshape(count, -1)
    j = np.moveaxis(slopes, 2, 0).reshape(count, e.shape[1], columns - 1)
    shared, own = j[:, :, : free + _PLACES], j[:, :, free + _PLACES :]
    q, r = np.linalg.qr(own)
    onto, seen = np.einsum("wmk,wm->wk", q, e), np.einsum("wmk,wmn->wkn", q, shared)
    rest = shared - q @ seen
    ridge = r + 1e-9 * np.eye(_STATES)

    def back(delta: Array) -> Array:
        """Change of the beginnings (6, W) that goes with (W, n) changes of the rest."""
        right = onto - np.einsum("wkn,wn->wk", seen, delta)
        return np.linalg.solve(ridge, right[:, :, None])[:, :, 0].T

    return Equations(np.swapaxes(rest, 1, 2) @ rest, np.einsum("wmn,wm->wn", rest, e), back)


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
    return replace(
        point,
        z=np.clip(point.z + delta[:free], least[:free], greatest[:free]),
        local=point.local + local,
        start=point.start + equations.back(each),
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
