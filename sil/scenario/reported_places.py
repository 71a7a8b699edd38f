# SPDX-License-Identifier: MIT
"""Converts poses to the coordinates that each agent's navigation unit sends."""

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from sil.plant.hull import Array
from sil.scenario.wiring import ORIGIN, WORLD
from sil.wire.navigation_unit import Settings

Degrees = npt.NDArray[np.int32]

_FAR_M = 1e7


class Told:
    """The poses of A agents, each in its own unit's local frame, or as latitude and longitude.

    `origins` (A): latitude and longitude (degE7) and altitude (mm) of each unit's local frame.
    `degE7` (A, 2): latitude and longitude of agents that send them; None if none does. Positions
    and heading keep their last values while the position is not finite or outside the globe.
    """

    def __init__(self, units: Sequence[Settings]) -> None:
        self._frames = {
            agent: WORLD.moved(*unit.origin_m)
            for agent, unit in enumerate(units)
            if any(unit.origin_m)
        }
        self._on_globe = [
            agent for agent, unit in enumerate(units) if unit.message in ("global", "follow_target")
        ]
        begins = {agent: frame.origin_degE7 for agent, frame in self._frames.items()}
        self.origins = [(*begins.get(a, ORIGIN[:2]), ORIGIN[2]) for a in range(len(units))]
        self.degE7: Degrees | None = np.zeros((len(units), 2), np.int32) if self._on_globe else None
        self._eta = np.empty((len(units), 3))
        start = WORLD.geodetic(0.0, 0.0, 0.0)
        self._last = dict.fromkeys(self._on_globe, start)

    def poses(self, eta: Array) -> Array:
        """Convert `eta` (A, 3), in the world's frame, to reported poses (A, 3); sets `degE7`."""
        if not self._frames and not self._on_globe:
            return eta
        self._eta[:] = eta
        for agent, frame in self._frames.items():
            self._eta[agent] = WORLD.seen_from(frame, *eta[agent].tolist())
        for agent in self._on_globe:
            pose = eta[agent].tolist()
            # a diverging run must still reach its end
            if all(abs(number) < _FAR_M for number in pose):
                self._last[agent] = WORLD.geodetic(*pose)
            latitude, longitude, self._eta[agent, 2] = self._last[agent]
            assert self.degE7 is not None
            self.degE7[agent] = latitude, longitude
        return self._eta
