# SPDX-License-Identifier: MIT
"""Decay of the sampled loops against the gains: along k_x, and the fastest that a search finds.

The search is coarse: a grid, then steps that are halved around its best point. Each point is the
slowest of all boats behind all references that move, by `sampled.quick_decay`, with the estimates
of current and unknown forces off, whose modes these gains hardly move; with them at work it must
not be unstable. Only small deviations in calm water count: saturation and far starts are for the
simulation to show; of noise it is told how much more of it such gains hand on.
"""

import itertools
from collections.abc import Callable, Sequence

import numpy as np

from sil.certificate.loop import Boat
from sil.certificate.monodromy import Points
from sil.certificate.sampled import quick_decay
from sil.certificate.search import Search, Searcher

Tell = Callable[[float], None]

CURVE_K_X: tuple[float, ...] = tuple(np.geomspace(0.01, 2.0, 31).tolist())

_REFINEMENTS = 4


def curve(boat: Boat, points: Points, tell: Tell) -> list[tuple[float, float]]:
    """Decay and that of the law alone, 1/s, at each `CURVE_K_X`; the other gains as they are."""
    found = []
    for k, k_x in enumerate(CURVE_K_X, start=1):
        found.append(quick_decay(boat.with_parameters({"LAW_KX": k_x}), points))
        tell(k / len(CURVE_K_X))
    return found


def fastest(boats: Sequence[tuple[Boat, Points]], tell: Tell) -> Search:
    """Search k_x, k_ψ and, where the boats have one, the look-ahead."""
    names = ["LAW_KX", "LAW_KPSI"]
    if all(boat.parameters.get("LAW_XT_DIST", 0.0) > 0.0 for boat, _ in boats):
        names.append("LAW_XT_DIST")
    search = Searcher(boats, names)
    axes = search.axes()
    points = list(itertools.product(*axes))
    steps = np.array([axis[1] - axis[0] for axis in axes])
    # neighbours are twice as many as gains, and each refinement may walk one step
    total = len(points) + _REFINEMENTS * 4 * len(names)
    for point in points:
        search.try_out(point)
        tell(search.evaluations / total)
    for _ in range(_REFINEMENTS):
        steps = steps / 2.0
        for _ in range(2):
            before = search.best
            for axis, sign in itertools.product(range(len(names)), (-1.0, 1.0)):
                near = np.array(before)
                near[axis] += sign * steps[axis]
                search.try_out(tuple(near.tolist()))
                tell(min(1.0, search.evaluations / total))
            if search.best == before:
                break
    tell(1.0)
    return search.found()
