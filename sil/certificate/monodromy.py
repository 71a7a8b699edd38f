# SPDX-License-Identifier: MIT
"""The linearisation of a boat's sampled loop over the time after which its leader repeats itself.

The map from one cycle of fixes to the next is differentiated by central differences in every
component of the state, at each of many instants, and the Jacobians are multiplied: Φ = ∏ A_k. The
origin of x and y moves on with the leader, by a shift and, after the window, whole turns; neither
changes Φ. Because the leader's motion is given, positions are not equivalent: a multiplier of 1
appears only for a state without any restoring force.

A propeller with a dead band has no derivative where it begins to turn. Its thrust is T(c) + w: T is
the curve without the dead band, w = −T(c) for |c| < dead, else 0, so that |w| ≤ |T(dead)|. The
Jacobians are those with T, about the regime that is sailed with w. If the modes of their product
decay, the bounded w moves the boat only by a bounded amount (a stable periodic linear system under
a bounded input), which is included in the regime's `error`.
"""

from collections.abc import Container, Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from sil.certificate.loop import BODY, Boat, Loop, leader_rows
from sil.plant.hull import Array

Complex = npt.NDArray[np.complex128]

_DELTA = 1e-5
_MOST_WINDOWS = 5
_LEAST_SAIL_S, _MOST_SAIL_S = 30.0, 3600.0
_REPEATS_M, _REPEATS = 1e-5, 1e-3
_LOST_M = 50.0
_IDLE = 1e-9
_VISIBLE, _EVERY = 1e-6, 8
NEAR_ONE = 1e-5  # as near as finite differences can tell


@dataclass(frozen=True)
class Instants:
    """The instants of a window: `ticks` (K); each stands for `cycles` (K) cycles of fixes.

    `begin`: the first tick of the window; `windows` windows take `length` ticks almost exactly.
    """

    begin: int
    length: int
    windows: int
    ticks: npt.NDArray[np.int64]
    cycles: npt.NDArray[np.int64]


def instants(boat: Boat, most: int, windows: int = _MOST_WINDOWS) -> Instants:
    """At most `most` instants over up to `windows` windows.

    The number of windows is the one whose length is nearest to whole cycles of fixes.
    """
    window_ticks, cycle = boat.leader.window_s * boat.rate_hz, boat.cycle
    count = min(
        range(1, windows + 1),
        # a penalty of a millionth a window: of equally good numbers, take the first
        key=lambda n: abs(n * window_ticks / cycle - round(n * window_ticks / cycle)) + 1e-6 * n,
    )
    total = max(1, round(count * window_ticks / cycle))
    if len(boat.leader.nu_periodic.values) == 1:
        most = 1  # all instants are alike
    edges = np.unique(np.linspace(0, total, min(most, total) + 1).round().astype(np.int64))
    begin = cycle * round(boat.leader.begin_s * boat.rate_hz / cycle)
    middles = (edges[:-1] + edges[1:] - 1) // 2
    return Instants(begin, total * cycle, count, begin + cycle * middles, np.diff(edges))


@dataclass(frozen=True)
class Points:
    """States (K, n) of a boat at ticks (K) that stand for `cycles` (K) cycles of fixes each."""

    ticks: npt.NDArray[np.int64]
    cycles: npt.NDArray[np.int64]
    states: Array


@dataclass(frozen=True)
class Regime:
    """The regime that a boat reaches from its slot; `points`: one for each `Instants` requested.

    `steady`: the motion repeats itself, and no propeller was at its limit; otherwise the points are
    those of a boat just put on its slot. `error` (3): mean |deviation| from the slot over the last
    window, m, m, rad; `limited`: a propeller was at its limit in that window.
    """

    steady: bool
    limited: bool
    error: Array
    points: list[Points]


def settle(boat: Boat, wanted: Sequence[Instants]) -> Regime:
    """Sail a boat from its slot until it repeats itself, for 30 to 3,600 s, and then its windows.

    A mode that decays by σ is within 1e-3 of its final value after 7/σ: the estimate of the current
    has 0.01 1/s on a slow hull, hence 700 s.
    """
    loop, rate = Loop(boat, 1), boat.rate_hz
    lap = max(boat.cycle, round(boat.leader.window_s * rate / boat.cycle) * boat.cycle)
    lap *= max(1, round(_LEAST_SAIL_S * rate / lap))
    loop.start(wanted[0].begin)
    before, repeats = np.full(3, np.inf), False
    for _ in range(max(2, round(_MOST_SAIL_S * rate / lap))):
        loop.limited = False
        error, _ = _sail(loop, lap)
        repeats = bool(np.abs(error - before).max() < _REPEATS_M + _REPEATS * error.max())
        before = error
        if repeats or not error.max() < _LOST_M:
            break
    if not repeats or loop.limited:
        return Regime(False, loop.limited, before, [on_slot(boat, where) for where in wanted])
    points = []
    for where in wanted:
        ticks = where.ticks + (loop.tick - where.begin)
        error, states = _sail(loop, where.length, set(ticks.tolist()))
        points.append(Points(ticks, where.cycles, np.array(states)))
    return Regime(True, False, error, points)


def on_slot(boat: Boat, where: Instants) -> Points:
    """States of a boat that was put on its slot two cycles before each instant."""
    loop, states = Loop(boat, 1), []
    for tick in where.ticks:
        loop.start(int(tick) - 2 * boat.cycle)
        _sail(loop, 2 * boat.cycle)
        states.append(loop.state[0])
    return Points(where.ticks, where.cycles, np.array(states))


def jacobians(boat: Boat, points: Points) -> Array:
    """Derivatives (K, n, n) of the state one cycle of fixes after each point by the state at it.

    The propellers have no dead band here.
    """
    n = points.states.shape[1]
    smooth = replace(boat, propellers=replace(boat.propellers, dead=0.0))
    loop, found = Loop(smooth, 2 * n), []
    nudges = _DELTA * np.vstack([np.eye(n), -np.eye(n)])
    ticks = points.ticks[:, None] + np.arange(boat.cycle)
    rows = leader_rows(boat.leader, boat.h_s * ticks.ravel().astype(np.float64))
    leader = rows.reshape(*ticks.shape, -1)
    for tick, state, cycle in zip(points.ticks, points.states, leader, strict=True):
        loop.resume(int(tick), state + nudges)
        for row in cycle:
            loop.step(row)
        end = loop.state
        found.append((end[:n] - end[n:]).T / (2.0 * _DELTA))
    return np.array(found)


def products(factors: Array, cycles: npt.NDArray[np.int64]) -> tuple[Array, float]:
    """Φ from the first instant to each later one and to the window's end (K, n, n), scaled.

    The true last matrix is the last one returned, times e to the power of the second result.
    """
    powers, scales = np.empty_like(factors), np.empty(len(factors))
    for count in np.unique(cycles).tolist():
        at = cycles == count
        powers[at], scales[at] = _power(factors[at], count)
    total, partial, scale = np.eye(factors.shape[1]), [], np.zeros(())
    for power, more in zip(powers, scales, strict=True):
        total, scale = _scaled(power @ total, scale + more)
        partial.append(total)
    return np.array(partial), float(scale)


def _power(factors: Array, count: int) -> tuple[Array, Array]:
    """The factors (K, n, n) to the power `count`, scaled; the logarithms of the scales (K)."""
    scale, more = np.zeros(len(factors)), np.zeros(len(factors))
    total = np.tile(np.eye(factors.shape[1]), (len(factors), 1, 1))
    while count:
        if count % 2:
            total, scale = _scaled(factors @ total, scale + more)
        factors, more = _scaled(factors @ factors, 2.0 * more)
        count //= 2
    return total, scale


def _scaled(product: Array, scale: Array) -> tuple[Array, Array]:
    """Matrices (..., n, n), divided by their sizes if these are extreme, and the new scales."""
    size = np.abs(product).max(axis=(-2, -1))
    size = np.where((size > 1e-50) & (size < 1e50), 1.0, size)
    return product / size[..., None, None], scale + np.log(size)


def written(factors: Array) -> npt.NDArray[np.bool_]:
    """Mask (n) of the components of the state that ever change.

    An estimate whose bandwidth is 0 belongs to the firmware's memory but is constant: it is not a
    state that could be disturbed.
    """
    change: Array = np.abs(factors - np.eye(factors.shape[1])).max(axis=(0, 2))
    return change >= _IDLE


def visible(values: Complex, vectors: Complex, partial: Array) -> npt.NDArray[np.bool_]:
    """Mask (n) of the modes that move the boat at any instant, not only the firmware's memory.

    Eigenvectors of a repeated eigenvalue may be any mixture: of those at 1, as many count as there
    are independent directions in the boat's own motion.
    """
    motion = np.vstack([vectors[:BODY], *(Phi[:BODY] @ vectors for Phi in partial[:-1:_EVERY])])
    size: Array = np.abs(motion).max(axis=0)
    seen = size > _VISIBLE * np.asarray(np.abs(vectors).max(axis=0))
    on_one = np.flatnonzero(np.abs(values - 1.0) < NEAR_ONE)
    if on_one.size > 1:
        left = np.linalg.svd(motion[:, on_one], compute_uv=False)
        seen[on_one] = np.arange(on_one.size) < np.sum(left > _VISIBLE * left[0])
    return seen


def _sail(loop: Loop, ticks: int, wanted: Container[int] = ()) -> tuple[Array, list[Array]]:
    """Continue a loop; return mean |deviation| (3) of its first copy, and states at `wanted`."""
    boat, count = loop.boat, range(loop.tick, loop.tick + ticks)
    times_s: Array = boat.h_s * np.array(count, dtype=np.float64)
    slot, rows = boat.slot.eta(times_s), leader_rows(boat.leader, times_s)
    states, total = [], np.zeros(3)
    for tick, row, there in zip(count, rows, slot, strict=True):
        if tick in wanted:
            states.append(loop.state[0])
        off = loop.eta[0] - there
        total += np.abs([off[0], off[1], np.remainder(off[2] + np.pi, 2.0 * np.pi) - np.pi])
        loop.step(row)
    return total / ticks, states
