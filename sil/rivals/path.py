# SPDX-License-Identifier: MIT
"""The rounded plan as a path: its point beside a boat, and its course ahead.

The motion is that of Flotilla's own planner, so that all rivals are judged by the same curve and
speed.
"""

from typing import NamedTuple

import numpy as np

from sil.plant.hull import Array

_BEHIND, _AHEAD = 50, 400  # search window, samples: the boat does not jump along the path


class Beside(NamedTuple):
    """The path's point nearest to a boat.

    `y_m`: the boat's distance to starboard of it; `course_rad`; `curvature_1pm`; `speed_mps`: the
    plan's speed a little ahead, because it is 0 at the start.
    """

    k: int
    y_m: float
    course_rad: float
    curvature_1pm: float
    speed_mps: float


class Path:
    """A plan's motion (T, 10), every `h_s`, until its arrival, for one boat."""

    def __init__(self, motion: Array, h_s: float) -> None:
        self.motion, self.h_s = motion, h_s
        self._k = 0

    def beside(self, x: float, y: float, slack_s: float = 0.5) -> Beside:
        """The point beside a boat at (x, y), m; it only moves forward along the path."""
        first = max(0, self._k - _BEHIND)
        near = self.motion[first : self._k + _AHEAD, :2]
        self._k = first + int(np.hypot(near[:, 0] - x, near[:, 1] - y).argmin())
        at = self.motion[self._k]
        north, east = x - at[0], y - at[1]
        aside = -np.sin(at[2]) * north + np.cos(at[2]) * east
        bend = at[5] / at[3] if at[3] > 0.05 else 0.0
        ahead = self.motion[min(self._k + round(slack_s / self.h_s), len(self.motion) - 1)]
        speed = max(float(ahead[3]), float(at[3]))
        return Beside(self._k, float(aside), float(at[2]), float(bend), speed)

    def ahead(self, k: int, times_s: Array) -> Array:
        """The motion (N, 10) at times after sample k."""
        rows = k + np.round(times_s / self.h_s).astype(int)
        motion: Array = self.motion[np.minimum(rows, len(self.motion) - 1)]
        return motion
