# SPDX-License-Identifier: MIT
"""Whether position, heading, speed and yaw rate of a log tell of the same motion."""

from typing import Any

import numpy as np
import numpy.typing as npt

from sil.identify.voyage_log import SAMPLE_S, Array, BadLogError, VoyageLog

Complex = npt.NDArray[Any]

_TURN_S, _WAY_S = 1.0, 5.0
_LEAST_TURN, _LEAST_WAY_M = 0.1, 1.0  # rad, m: smaller ones are noise
_LEAST = 200  # stretches; one begins at each sample
_RATIO = 2.0  # of the heading's turn and that of the yaw rate
_ASTRAY = 0.4  # of a way, as after a compass that deviates by 23°; speeds in knots: 0.49


def check(log: VoyageLog) -> None:
    """BadLogError if axes, signs or units of the motion contradict each other."""
    _, _, psi, u, v, r = log.motion.T
    by_rate = _means(r, _TURN_S) * _TURN_S
    turned = _ratios(_changes(psi, _TURN_S), by_rate, _LEAST_TURN)
    if len(turned) >= _LEAST and not 1.0 / _RATIO < np.median(turned) < _RATIO:
        raise BadLogError(
            f"{log.name}: when the yaw rate says 1°, the heading turns by "
            f"{np.median(turned):.2g}°. Both count clockwise, seen from above: check their signs "
            "and units"
        )
    north, east = np.cos(psi) * u - np.sin(psi) * v, np.sin(psi) * u + np.cos(psi) * v
    by_speed = (_means(north, _WAY_S) + 1j * _means(east, _WAY_S)) * _WAY_S
    way = _changes(log.motion[:, 0], _WAY_S) + 1j * _changes(log.motion[:, 1], _WAY_S)
    astray = np.abs(_ratios(way, by_speed, _LEAST_WAY_M) - 1.0)
    if len(astray) >= _LEAST and np.median(astray) > _ASTRAY:
        raise BadLogError(
            f"{log.name}: the position does not move as heading and speed say: after "
            f"{_WAY_S:.0f} s it is off by {np.median(astray):.0%} of the way. Check which columns "
            "are north and east, ahead and to starboard, their signs and their units"
        )


def _means(series: Array, stretch_s: float) -> Array:
    """Means over all stretches, by the trapezoidal rule."""
    step = round(stretch_s / SAMPLE_S)
    between = 0.5 * (series[:-1] + series[1:])
    return np.convolve(between, np.full(step, 1.0 / step), "valid")


def _changes(series: Array, stretch_s: float) -> Array:
    step = round(stretch_s / SAMPLE_S)
    return series[step:] - series[:-step]


def _ratios(a: Complex, b: Complex, least: float) -> Complex:
    """The ratios a / b where both are known and |b| exceeds `least`.

    If there are too few, where |a| exceeds it: b may be in a wrong unit. Infinite where b is 0.
    """
    known = np.isfinite(a) & np.isfinite(b)
    large = known & (np.abs(b) > least)
    if np.count_nonzero(large) < _LEAST:
        large = known & (np.abs(a) > least)
    with np.errstate(divide="ignore", invalid="ignore"):
        return a[large] / b[large]
