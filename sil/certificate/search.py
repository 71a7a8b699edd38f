# SPDX-License-Identifier: MIT
"""The state of a search for gains: its ranges, its best point, and its results.

A count of linearised cycles limits it, so that the result does not depend on the computer's load.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from sil.certificate.loop import Boat
from sil.certificate.monodromy import Points
from sil.certificate.noise import noise_gains
from sil.certificate.sampled import quick_decay

SEARCH_CYCLES = 25_000  # linearised cycles: 40 s on a quiet core

_RANGES = {"LAW_KX": (0.02, 2.0), "LAW_KPSI": (0.05, 2.0), "LAW_XT_DIST": (0.25, 8.0)}
_GRID = {2: 8, 3: 5}
_LEAST_GRID = 3
_END = 1e-6


@dataclass(frozen=True)
class Search:
    """The result of a search: `gains` by parameter name, after `evaluations` points.

    `decay_of_law`: 1/s, the maximized quantity. `decay`: the same with the estimates on. `*_now`:
    the same with the present gains. `noise`: by `noise.SOURCES`, thrust due to noise of the boat's
    fixes, as a multiple of its present value, for the boat with the largest. `complete`: the search
    ended before `SEARCH_CYCLES` did. `ranges`: the ranges searched. `at_end`: the gains that lie at
    an end of their range.
    """

    gains: dict[str, float]
    decay_of_law: float
    decay: float
    decay_of_law_now: float
    decay_now: float
    noise: dict[str, float]
    evaluations: int
    complete: bool
    ranges: dict[str, tuple[float, float]]
    at_end: list[str]


class Searcher:
    """The best point so far, in logarithms of the gains."""

    def __init__(self, boats: Sequence[tuple[Boat, Points]], names: Sequence[str]) -> None:
        self._boats, self._names = boats, names
        cycles = sum(boat.cycle * len(points.ticks) for boat, points in boats)
        self._most = SEARCH_CYCLES // max(1, cycles)
        self.best: tuple[float, ...] = tuple(_span(name)[0] for name in names)
        self.decays = (-math.inf, -math.inf)
        self.evaluations = 0
        self.late = False

    def axes(self) -> list[list[float]]:
        """A grid, coarser if loops are costly: half of the cycles remain for the refinement."""
        dimensions = len(self._names)
        affordable = int((0.5 * self._most) ** (1.0 / dimensions) + 1e-9)
        count = max(_LEAST_GRID, min(_GRID[dimensions], affordable))
        return [np.linspace(*_span(name), count).tolist() for name in self._names]

    def named(self, point: Sequence[float]) -> dict[str, float]:
        """Gains by parameter name at a point."""
        return {name: math.exp(x) for name, x in zip(self._names, point, strict=True)}

    def try_out(self, point: tuple[float, ...]) -> None:
        """Keep a point if it lies in the ranges and is better than the best so far."""
        inside = all(
            low - 1e-9 <= x <= high + 1e-9
            for x, (low, high) in zip(point, map(_span, self._names), strict=True)
        )
        if not inside:
            return
        self.late = self.late or self.evaluations >= self._most
        if self.late:
            return
        self.evaluations += 1
        decays = self._slowest(self.named(point), self.decays)
        if decays > self.decays:
            self.best, self.decays = point, decays

    def found(self) -> Search:
        """The best point, with the present gains for comparison."""
        gains, ranges = self.named(self.best), {name: _RANGES[name] for name in self._names}
        of_law_now, now = self._slowest({}, (-math.inf, -math.inf))
        ends = [
            name for name, x in gains.items() if min(abs(x / e - 1.0) for e in ranges[name]) < _END
        ]
        return Search(
            gains=gains,
            decay_of_law=self.decays[0],
            decay=self.decays[1],
            decay_of_law_now=of_law_now,
            decay_now=now,
            noise=self._noise(gains),
            evaluations=self.evaluations,
            complete=not self.late,
            ranges=ranges,
            at_end=ends,
        )

    def _noise(self, gains: Mapping[str, float]) -> dict[str, float]:
        most: dict[str, float] = {}
        for boat, points in self._boats:
            before = noise_gains(boat, points)
            for name, after in noise_gains(boat.with_parameters(gains), points).items():
                ratio = after / before[name] if before[name] > 0.0 else math.inf
                most[name] = max(most.get(name, 0.0), ratio)
        return most

    def _slowest(
        self, gains: Mapping[str, float], best: tuple[float, float]
    ) -> tuple[float, float]:
        """Slowest decay of the law, and of all; stops once the point cannot be the best."""
        of_law, of_all = math.inf, math.inf
        for boat, points in self._boats:
            whole, law = quick_decay(boat.with_parameters(gains), points)
            of_law, of_all = min(of_law, law), min(of_all, whole)
            if (of_law, of_all) <= best:
                break  # already worse than the best
        return of_law, of_all


def _span(name: str) -> tuple[float, float]:
    low, high = _RANGES[name]
    return math.log(low), math.log(high)
