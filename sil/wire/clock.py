# SPDX-License-Identifier: MIT
"""A vessel's own clock: an offset and a drift from the world's time."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Clock:
    """Runs `offset_us` ahead of the world's time and gains `drift_ppm` on it."""

    offset_us: int = 0
    drift_ppm: float = 0.0

    def at(self, t_us: int) -> int:
        """The clock's reading, us, at the world's time `t_us`."""
        gained_us = round(t_us * self.drift_ppm * 1e-6) if self.drift_ppm else 0
        return t_us + self.offset_us + gained_us
