# SPDX-License-Identifier: MIT
"""Standard normal numbers for many runs, each run's from its own generator."""

from collections.abc import Sequence

import numpy as np

from sil.plant.hull import Array

# A generator's call takes as long for one number as for a hundred.
_AHEAD = 64


class Normals:
    """Numbers of `shape` for each of R runs and each step, drawn many steps ahead.

    Each run's numbers come from its entry of `sources`, in the same order as if drawn step by step;
    a run whose entry is None draws nothing and has zeros.
    """

    def __init__(
        self, sources: Sequence[np.random.Generator | None], shape: tuple[int, ...]
    ) -> None:
        self._sources = sources
        self._steps = 0
        self._block: Array = np.zeros((_AHEAD, len(sources), *shape))
        self._drawn: Array = np.empty((_AHEAD, *shape))

    def step(self) -> Array:
        """The numbers (R, *shape) of the next step; valid until the next call."""
        now = self._steps % _AHEAD
        if now == 0:
            for run, source in enumerate(self._sources):
                if source is not None:
                    source.standard_normal(out=self._drawn)
                    self._block[:, run] = self._drawn
        self._steps += 1
        numbers: Array = self._block[now]
        return numbers
