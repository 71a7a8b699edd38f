# SPDX-License-Identifier: MIT
"""Decay of the sampled loops as a function of the gains: along k_x, and its maximum by a search.

The search is coarse: a grid, then steps that are halved around its best point. The value of a point
is the slowest decay of all boats behind all references that move, by `sampled.quick_decay`. There
the estimates of current and unknown forces are off, because these gains hardly affect their modes;
with the estimates on, the point must not be unstable. Only small deviations in calm water count;
the simulation shows saturation and distant starts. The result also states how much more noise these
gains pass to the propellers.
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
    """Decay and decay of the law alone, 1/s, at each `CURVE_K_X`; other gains unchanged."""
    found = []
    for k, k_x in enumerate(CURVE_K_X, start=1):
        found.append(quick_decay(boat.with_parameters({"LAW_KX": k_x}), points))
        tell(k / len(CURVE_K_X))
    return found


def fastest(boats: Sequence[tuple[Boat, Points]], tell: Tell) -> Search:
    """Search k_x, k_ψ and, if the boats have one, the look-ahead."""
    names = ["LAW_KX", "LAW_KPSI"]
    if all(boat.parameters.get("LAW_XT_DIST", 0.0) > 0.0 for boat, _ in boats):
        names.append("LAW_XT_DIST")
    search = Searcher(boats, names)
    axes = search.axes()
    points = list(itertools.product(*axes))
    steps = np.array([axis[1] - axis[0] for axis in axes])
    # there are two neighbours for each gain, and each refinement may move one step
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
