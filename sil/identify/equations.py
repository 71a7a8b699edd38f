# SPDX-License-Identifier: MIT
"""The equations of one step of the output-error search, with each window's own unknowns eliminated.

The difference between measured and simulated values, each channel over its σ, is linear in small
changes of the searched quantities, which are the terms and the logs' places, and of each window's
own start and gust. The latter are eliminated window by window (variable projection: Golub and
Pereyra 1973).
Source: Jategaonkar, Flight Vehicle System Identification, 2nd ed., chapters 4 and 9.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt
from scipy.optimize import lsq_linear

from sil.identify.hull_terms import GUSTS, INDEX, LOCAL, MEASURED, Term
from sil.identify.voyage_log import Array
from sil.identify.voyage_model import Body, measured, sail, simulate
from sil.identify.windows import Windows

Bools = npt.NDArray[np.bool_]

_STEP = 1e-3  # of a finite difference, in deviations
_STATES, _PLACES, _GUSTS = 6, len(LOCAL), len(GUSTS)
_OWN = _STATES + _GUSTS
_LOCAL_GUESS = np.array([term.guess for term in LOCAL])
_LOCAL_SPREAD = np.array([term.spread for term in LOCAL])
_ONLY_MEASURED = frozenset(INDEX[name] for name in MEASURED)


@dataclass(frozen=True)
class Problem:
    """Windows, hull, terms (with guesses for this hull) and a mask of the searched terms.

    gusts: factor of the wind's changes relative to `GUSTS`.
    """

    windows: Windows
    body: Body
    terms: tuple[Term, ...]
    free: Bools
    gusts: float = 1.0

    @property
    def gust_spread(self) -> Array:
        """Deviations of a window's gust (6)."""
        stronger = [1.0 if "turn" in term.name else self.gusts for term in GUSTS]
        return np.array([term.spread for term in GUSTS]) * stronger

    @property
    def logs(self) -> int:
        """Number of logs that the windows come from."""
        return int(self.windows.log.max()) + 1


@dataclass(frozen=True)
class Point:
    """The present point of a search: terms, places and gusts, in deviations from their guesses."""

    z: Array  # (free terms)
    local: Array  # (logs, 4)
    start: Array  # (6, W)
    gust: Array  # (6, W)


@dataclass(frozen=True)
class Equations:
    """Equations A δ = e of W windows without their own unknowns: AᵀA (W, n, n) and Aᵀe (W, n).

    back: change of the windows' own unknowns (12, W) for changes (W, n) of the others.
    """

    squares: Array
    right: Array
    back: Callable[[Array], Array]

    def counted(self, counts: Array) -> "Equations":
        """The equations with each window weighted by its count."""
        return replace(
            self,
            squares=self.squares * counts[:, None, None],
            right=self.right * counts[:, None],
        )


def residuals(problem: Problem, values: Array, places: Array, start: Array) -> Array:
    """Measured minus simulated (samples, 6, W), NaN where nothing was measured.

    places (8, W): as in `simulate`.
    """
    windows = problem.windows
    out = simulate(
        values[:, None], places[:, :, None], start[:, :, None], windows.commands, problem.body
    )
    return windows.measured - out[:, :, :, 0]


def places_of(problem: Problem, point: Point) -> Array:
    """Current, wind and moment in each window, and the rise of wind and moment (8, W)."""
    local = local_of(point)[problem.windows.log].T
    gust = point.gust * problem.gust_spread[:, None]
    return np.vstack([local[:2], local[2:] + gust[:2], gust[2:]])


def local_of(point: Point) -> Array:
    """Current and wind of each log (logs, 4)."""
    local: Array = _LOCAL_GUESS + point.local * _LOCAL_SPREAD
    return local


def scale_of(problem: Problem) -> tuple[Array, Array]:
    """Guesses and deviations of all terms."""
    return (
        np.array([term.guess for term in problem.terms]),
        np.array([term.spread for term in problem.terms]),
    )


def values_of(problem: Problem, z: Array, values: Array) -> Array:
    """All terms (K): the searched ones from z, in deviations; the others from `values`."""
    guess, spread = scale_of(problem)
    out = values.copy()
    out[problem.free] = guess[problem.free] + z * spread[problem.free]
    return out


def equations_of(problem: Problem, point: Point, values: Array, sigma: Array) -> Equations:
    """The equations at a point; derivatives by finite differences, all in one simulation.

    A QR decomposition eliminates each window's own unknowns.
    """
    windows, free = problem.windows, int(problem.free.sum())
    shared = free + _PLACES
    out, steps = _perturbed(problem, point, values)
    weight = np.isfinite(windows.measured) / sigma[:, None]
    error = np.nan_to_num(windows.measured - out[..., 0]) * weight
    slopes = (out[..., 1:] - out[..., :1]) / steps * weight[..., None]
    count = len(windows)
    e = np.moveaxis(error, 2, 0).reshape(count, -1)
    j = np.moveaxis(slopes, 2, 0).reshape(count, e.shape[1], -1)
    # The rows of the prior of a window's gust.
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
        right = onto - np.einsum("wkn,wn->wk", seen, delta)
        return np.linalg.solve(ridge, right[:, :, None])[:, :, 0].T

    turned = np.swapaxes(rest, 1, 2)
    return Equations(turned @ rest, (turned @ e[:, :, None])[:, :, 0], back)


def _perturbed(problem: Problem, point: Point, values: Array) -> tuple[Array, Array]:
    """Simulated (samples, 6, W, 1 + n): unchanged, then with each number changed by its step (n).

    Columns: terms, current and wind, initial state, gusts. A number that changes the measurements
    but not the motion through the water needs no simulation of its own.
    """
    searched = np.flatnonzero(problem.free)
    current = 1 + len(searched)
    begin = current + _PLACES
    columns = begin + _OWN
    full = values_of(problem, point.z, values)
    terms = np.repeat(full[:, None], columns, axis=1)
    places = np.repeat(places_of(problem, point)[:, :, None], columns, axis=2)
    start = np.repeat(point.start[:, :, None], columns, axis=2)
    steps = np.full(columns, _STEP)
    for c, k in enumerate(searched, start=1):
        term = problem.terms[k]
        if full[k] + _STEP * term.spread > term.greatest:
            steps[c] = -_STEP
        terms[k, c] += steps[c] * term.spread
    for c, spread in enumerate(_LOCAL_SPREAD):
        places[c, :, current + c] += _STEP * spread
    for c in range(_STATES):
        start[c, :, begin + c] += _STEP
    for c, spread in enumerate(problem.gust_spread):
        places[2 + c, :, begin + _STATES + c] += _STEP * spread
    alike = [c for c, k in enumerate(searched, start=1) if k in _ONLY_MEASURED]
    alike += [current, current + 1, begin, begin + 1]
    own = np.setdiff1d(np.arange(columns), alike)
    commands, body = problem.windows.commands, problem.body
    out = np.empty((len(problem.windows.measured), _STATES, len(problem.windows), columns))
    out[..., own] = sail(terms[:, own], places[..., own], start[..., own], commands, body)
    out[..., alike] = out[..., :1]
    t = np.arange(len(out))[:, None] * body.h_s
    for c in range(2):
        out[:, c, :, current + c] += t * _STEP * _LOCAL_SPREAD[c]
        out[:, c, :, begin + c] += _STEP
    return measured(out, terms, places, body.h_s), steps[1:]


def summed(problem: Problem, equations: Equations, counts: Array) -> tuple[Array, Array]:
    """The sum of all windows' equations, weighted by `counts`: terms, then each log's places."""
    free = int(problem.free.sum())
    size = free + _PLACES * problem.logs
    h, g = np.zeros((size, size)), np.zeros(size)
    for number in range(problem.logs):
        mine = problem.windows.log == number
        at = np.r_[0:free, free + _PLACES * number : free + _PLACES * (number + 1)]
        h[np.ix_(at, at)] += np.einsum("w,wnk->nk", counts[mine], equations.squares[mine])
        g[at] += counts[mine] @ equations.right[mine]
    return h, g


def moved_by(problem: Problem, point: Point, equations: Equations, damping: float) -> Point:
    """The point after the equations' step."""
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
    """The bounded step from `at` (deviations) that solves the equations together with the prior."""
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
