# SPDX-License-Identifier: MIT
"""Oddities of logs that do not stop an identification, as sentences to read before its figures."""

from collections.abc import Sequence

import numpy as np

from sil.identify.voyage_log import SAMPLE_S, VoyageLog

# Correlation of neighbouring second differences: −2/3 for white noise, positive if smoothed.
_SMOOTH = -0.3
_SETTLED = 20  # samples
_COARSE = 0.7
_LATE_S = 0.05
_SHIFTS = 5  # samples
_TURNING = 0.1  # rad/s
_FUTURE, _NEAR = 6, 2  # samples of commands to come; the next ones do not count
_SURE = 4.0  # standard errors


def of_logs(logs: Sequence[VoyageLog]) -> list[str]:
    """Sentences about the columns of logs (wiring mended) of one boat."""
    found = []
    coarse = float(np.mean([log.fresh for log in logs]))
    if coarse < _COARSE:
        found.append(
            f"the position is new in only {coarse:.0%} of the samples: "
            f"it comes at about {coarse / SAMPLE_S:.0f} Hz and is repeated"
        )
    smooth = [
        name
        for name, column in (("surge", 3), ("sway", 4), ("yaw rate", 5))
        if np.median([roughness(log, column) for log in logs]) > _SMOOTH
    ]
    if smooth:
        found.append(f"{', '.join(smooth)} look smoothed: neighbouring samples share their noise")
    late = yaw_rate_age(logs)
    if abs(late) >= _LATE_S:
        word = "later" if late > 0.0 else "earlier"
        found.append(f"the yaw rate is {abs(late):.2f} s {word} than the heading")
    found += [
        f"{name} answers commands {(_NEAR + 1) * SAMPLE_S:.1f} s before they are given: "
        "it was smoothed with samples from the future (acausal), or the clocks differ"
        for name, column, sign in (("surge", 3, 1.0), ("the yaw rate", 5, -1.0))
        if foresight(logs, column, sign) > _SURE
    ]
    return found


def roughness(log: VoyageLog, column: int) -> float:
    """Correlation of neighbouring second differences while commands have been steady for 2 s."""
    moved = np.any(np.diff(log.commands, axis=0, prepend=log.commands[:1]) != 0.0, axis=1)
    quiet = np.convolve(moved, np.ones(_SETTLED), mode="full")[: len(moved)] == 0.0
    second = np.diff(log.motion[:, column], 2)
    a, b = second[:-1], second[1:]
    known = np.isfinite(a) & np.isfinite(b) & quiet[3:]
    if known.sum() < _SETTLED or np.std(a[known]) == 0.0:
        return -1.0
    return float(np.corrcoef(a[known], b[known])[0, 1])


def yaw_rate_age(logs: Sequence[VoyageLog]) -> float:
    """Delay of the yaw rate after the heading's slope, s, resolved to a part of a sample."""
    errors = np.zeros(2 * _SHIFTS + 1)
    for log in logs:
        slope = np.gradient(log.motion[:, 2], SAMPLE_S)
        rate = log.motion[:, 5]
        for k, shift in enumerate(range(-_SHIFTS, _SHIFTS + 1)):
            moved = np.roll(slope, shift)
            inside = slice(_SHIFTS, len(rate) - _SHIFTS)
            known = np.isfinite(moved[inside]) & np.isfinite(rate[inside])
            turning = known & (np.abs(rate[inside]) > _TURNING)
            errors[k] += ((moved[inside] - rate[inside])[turning] ** 2).sum()
    best = int(np.argmin(errors))
    if best in (0, 2 * _SHIFTS):
        return float((best - _SHIFTS) * SAMPLE_S)
    below, least, above = errors[best - 1 : best + 2]
    bend = below - 2.0 * least + above
    part = 0.5 * (below - above) / bend if bend > 0.0 else 0.0
    return float((best - _SHIFTS + part) * SAMPLE_S)


def foresight(logs: Sequence[VoyageLog], column: int, sign: float) -> float:
    """Significance, in standard errors, of a response to commands before they are given.

    Changes of u (sign 1: the sum of both propellers) or r (sign −1: port minus starboard) over a
    sample, regressed on changes of the commands from the future to 1.5 s ago.
    """
    lags = range(_FUTURE, -16, -1)
    rows = []
    for log in logs:
        push = log.commands @ np.array([1.0, sign])
        change = np.diff(log.motion[:, column])
        steps = np.diff(push, prepend=push[:1])
        now = np.arange(16, len(change) - _FUTURE)
        motion = [change[now], log.motion[now, column]]
        rows.append(np.column_stack([*motion, *(steps[now + lag] for lag in lags)]))
    table = np.vstack(rows)
    table = table[np.all(np.isfinite(table), axis=1)]
    if len(table) < 100:
        return 0.0
    a, y = table[:, 1:], table[:, 0]
    inverse = np.linalg.pinv(a.T @ a)
    x = inverse @ a.T @ y
    noise = ((y - a @ x) ** 2).sum() / (len(y) - a.shape[1])
    far = np.zeros(len(x))
    far[1 : 1 + _FUTURE - _NEAR] = 1.0
    return float(far @ x / np.sqrt(max(noise * (far @ inverse @ far), 1e-30)))
