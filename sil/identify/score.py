# SPDX-License-Identifier: MIT
"""Scores a hull's open-loop predictions over ten seconds of logs that it was not fitted to."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from sil.identify.equations import Problem, residuals
from sil.identify.voyage_log import Array, VoyageLog
from sil.identify.voyage_model import deviation
from sil.identify.windows import Windows, cut, first_start

_STRIDE_S = 1.0


@dataclass(frozen=True)
class Score:
    """R² of u, v and r; position error (m) at the windows' ends."""

    windows: int
    u: float
    v: float
    r: float
    median_m: float
    ninetieth_m: float


def score(problem: Problem, values: Array, local: Array, logs: Sequence[VoyageLog]) -> Score | None:
    """Score over windows of `logs` in which the propellers work, one window a second.

    Each window begins as measured: position and heading of its first sample, velocities from its
    first half second, corrected by the compass deviation of `values`. local (logs, 4): current and
    wind of each log (`LOCAL`). None if there is no such window.
    """
    windows = cut(logs, _STRIDE_S)
    # A window without a first sample, as in a gap, has no initial state.
    known = np.isfinite(windows.measured)
    begun = np.all(known[0] | ~known.any(axis=0), axis=0)
    windows = windows.chosen(windows.working() & begun)
    if len(windows) == 0:
        return None
    error = predicted(problem, values, local, windows)
    measured = windows.measured
    r2 = [_determination(measured[:, k], error[:, k]) for k in (3, 4, 5)]
    ends = np.hypot(error[-1, 0], error[-1, 1])
    median, ninetieth = np.nanquantile(ends, [0.5, 0.9])
    return Score(len(windows), r2[0], r2[1], r2[2], float(median), float(ninetieth))


def predicted(problem: Problem, values: Array, local: Array, windows: Windows) -> Array:
    """Measured minus predicted (samples, 6, W); local: as in `score`."""
    held_out = Problem(windows, problem.body, problem.terms, problem.free)
    places = np.vstack([local[windows.log].T, np.zeros((4, len(windows)))])
    return residuals(held_out, values, places, _start(values, places, windows))


def _start(values: Array, places: Array, windows: Windows) -> Array:
    start = first_start(windows)
    start[2] -= deviation(values[:, None], start[2][:, None])[:, 0]
    # The measured velocities are along the measured heading.
    turned = first_start(windows)[2] - start[2]
    u = np.cos(turned) * start[3] - np.sin(turned) * start[4]
    v = np.sin(turned) * start[3] + np.cos(turned) * start[4]
    cos, sin = np.cos(start[2]), np.sin(start[2])
    start[3] = u - cos * places[0] - sin * places[1]
    start[4] = v - cos * places[1] + sin * places[0]
    return start


def _determination(measured: Array, error: Array) -> float:
    spread = measured - np.nanmean(measured)
    return float(1.0 - np.nansum(error**2) / np.nansum(spread**2))
