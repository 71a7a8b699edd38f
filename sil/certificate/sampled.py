# SPDX-License-Identifier: MIT
"""Multipliers and decay of the sampled closed loop of one boat behind one reference.

A boat never acts on its leader. Therefore the fleet's linearisation is block triangular, and its
multipliers are those of all boats together. A link's delay and rate only shift the follower's view
of its leader: they are outside every loop, and no multiplier depends on them. The rate of a boat's
own fixes is inside.

Three kinds of multipliers are left out of `decay`. The first are those of modes that stay in the
firmware's memory and never move the boat. The second, behind a leader at rest, are those at 1 that
the hull has under any thrusts (Popov, Belevitch and Hautus: rank [A − I B]): a boat without way on
cannot move sideways. They are counted as `neutral`. The third is the current along a straight leg.
The observer learns the current c from its push across the bow only, so that on one heading ψ the
product [cos ψ  sin ψ] c never changes (`core/estimation/observer.hpp`): it is the left eigenvector
of a multiplier that is exactly 1. Such a mode neither grows nor decays before the next turn. Its
effect is measured by sailing on with a wrong estimate (`Misled`).
"""

import math
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
import numpy.typing as npt
from scipy import linalg

from sil.certificate import monodromy
from sil.certificate.loop import COMPONENTS, Boat, Loop, leader_rows
from sil.certificate.monodromy import Points
from sil.plant import hull
from sil.plant.hull import Array

Outcome = Literal["converges", "stays", "grows"]

_INSTANTS, _QUICK_INSTANTS = 512, 48
_STAYS = 1e-4  # 1/s: smaller rates are neither decay nor growth
_STATIONARY = 1e-7
_SHOWN = 6
_ROUNDING = 1e-11
_PART = 0.1
_CURRENT = [COMPONENTS.index(f"current {way}") for way in ("north", "east")]
_ONLY = 1e-5  # greatest part of anything else in the left eigenvector of the current along a leg
_MISLED_S, _UNDER_WAY_MPS = 120.0, 0.05
ESTIMATES = ("LAW_CUR_BW", "LAW_OBS_BW")


@dataclass(frozen=True)
class Misled:
    """The effect of a wrong estimate of the current along a straight leg, until the next turn.

    `wrong_mps`: the error, of either sign, as large as the scenario's current: the estimate begins
    at 0, and what it learns across the bow only makes its error smaller. `off_m`, `thrust_N`:
    greatest change of a boat's place and of a propeller's thrust after half of `_MISLED_S`, in
    which the observer and the law adapt to the error that is put in; `limited`: a propeller was at
    its limit.
    """

    wrong_mps: float
    off_m: float
    thrust_N: float
    limited: bool


@dataclass(frozen=True)
class SampledLoop:
    """The stability of small deviations of one boat.

    `radius`: largest |multiplier| over one window of `window_s`, without the neutral ones. `decay`:
    1/s, negative for growth. `decay_of_law`: the same with `ESTIMATES` 0, because the estimates of
    current and unknown forces have modes of their own, which the gains hardly affect. `decays`: the
    slowest ones. `slowest`: components of the state with their shares of the slowest mode, the
    largest first. `misled`: None without a current, or if all of it is observable. `steady`: the
    boat reached a regime that repeats itself without a propeller at its limit (`limited`), and was
    linearised there, otherwise on its slot. `error` (3): mean |deviation| from the slot north, east
    and in heading, m, m, rad.
    """

    window_s: float
    radius: float
    decay: float
    decay_of_law: float
    decays: list[float]
    slowest: dict[str, float]
    neutral: int
    misled: Misled | None
    steady: bool
    limited: bool
    error: list[float]

    @property
    def outcome(self) -> Outcome:
        """Whether small deviations decay, stay, or grow."""
        if self.decay > _STAYS:
            return "converges"
        return "stays" if self.decay > -_STAYS else "grows"

    @property
    def holds(self) -> bool:
        """Whether the boat stays in a steady regime and small deviations decay."""
        return self.steady and self.outcome == "converges"


def sampled_loop(boat: Boat, at_rest: bool) -> tuple[SampledLoop, Points]:
    """Sail a boat into its steady regime behind its leader, at rest or not, and linearise there.

    Also returns a few points of that regime, for `quick_decay`.
    """
    where = monodromy.instants(boat, _INSTANTS)
    few = monodromy.instants(boat, _QUICK_INSTANTS, windows=1)
    regime = monodromy.settle(boat, [where, few])
    neutral = uncontrollable(boat, regime.points[0].states[0]) if at_rest else 0
    modes, found = _without(_modes(boat, regime.points[0]), neutral)
    window_s = where.length * boat.h_s / where.windows
    decay = modes.decays[0]
    loop = SampledLoop(
        window_s=window_s,
        radius=math.exp(min(-decay * window_s, 700.0)),
        decay=decay,
        decay_of_law=_decay_of_law(boat, regime.points[1], decay, neutral),
        decays=modes.decays[:_SHOWN],
        slowest=modes.slowest,
        neutral=found,
        misled=_misled(boat, regime.points[0]),
        steady=regime.steady,
        limited=regime.limited,
        error=regime.error.tolist(),
    )
    return loop, regime.points[1]


def quick_decay(boat: Boat, points: Points) -> tuple[float, float]:
    """`decay` and `decay_of_law`, 1/s, about `points` of the regime with the original gains."""
    decay = _modes(boat, points).decays[0]
    return decay, _decay_of_law(boat, points, decay, 0)


def _decay_of_law(boat: Boat, points: Points, decay: float, neutral: int) -> float:
    if decay < -_STAYS or not any(boat.parameters.get(name, 0.0) for name in ESTIMATES):
        return decay
    held = boat.with_parameters(dict.fromkeys(ESTIMATES, 0.0))
    return _without(_modes(held, points), neutral)[0].decays[0]


def uncontrollable(boat: Boat, state: Array) -> int:
    """Multipliers at 1 that a hull in `state` has under any thrusts: 6 − rank [A − I  B]."""
    n, inputs, delta = 6, 2, 1e-4
    nudges = delta * np.vstack([np.eye(n + inputs), -np.eye(n + inputs)])
    start = state[:n] + nudges[:, :n]
    eta, nu = np.ascontiguousarray(start[:, :3]), np.ascontiguousarray(start[:, 3:])
    count, arm_m = len(nudges), boat.propellers.arm_m
    port, stbd = state[n : n + 2]
    tau = np.array([port + stbd, arm_m * (port - stbd)]) + nudges[:, n:]
    water = (np.zeros((count, 3)), np.tile(boat.current, (count, 1)))
    hulls = hull.stack([boat.hull] * count)
    hull.advance(eta, nu, np.tile(tau, (3, 1, 1)), *water, hulls, boat.h_s)
    end = np.hstack([eta, nu])
    slopes = (end[: n + inputs] - end[n + inputs :]).T / (2.0 * delta)
    slopes[:, :n] -= np.eye(n)
    return int(np.sum(np.linalg.svd(slopes, compute_uv=False) < _STATIONARY))


@dataclass(frozen=True)
class _Modes:
    """Visible modes (k), slowest first: decays, 1/s, and distance of the multiplier from 1.

    `slowest`: the components with the largest shares of the slowest mode, as in `SampledLoop`.
    """

    decays: list[float]
    from_one: list[float]
    slowest: dict[str, float]


def _modes(boat: Boat, points: Points) -> _Modes:
    factors = monodromy.jacobians(boat, points)
    if not np.isfinite(factors).all():
        return _Modes([-math.inf], [math.inf], {})
    kept = monodromy.written(factors)
    factors = factors[:, kept][:, :, kept]
    partial, scale = monodromy.products(factors, points.cycles)
    values, left, right = linalg.eig(partial[-1], left=True, right=True)
    visible = monodromy.visible(values, right, partial)
    if _straight(points):
        visible &= ~_of_current(values, left, kept)
    seen = np.flatnonzero(visible)
    # smaller values are rounding errors
    seen = seen[np.abs(values[seen]) > _ROUNDING * np.abs(values[seen]).max()]
    logs = np.log(np.abs(values[seen]))
    seen, logs = seen[np.argsort(-logs)], np.sort(logs)[::-1] + scale
    slowest = _shares(np.array(COMPONENTS)[kept], np.abs(left[:, seen[0]] * right[:, seen[0]]))
    from_one = np.abs(values[seen] * math.exp(min(scale, 300.0)) - 1.0)
    length_s = int(points.cycles.sum()) * boat.cycle * boat.h_s
    return _Modes((-logs / length_s).tolist(), from_one.tolist(), slowest)


def _straight(points: Points) -> bool:
    """Whether the boat sails on one heading."""
    return len(points.ticks) == 1 and math.hypot(*points.states[0, 3:5]) > _UNDER_WAY_MPS


def _of_current(
    values: monodromy.Complex, left: monodromy.Complex, kept: npt.NDArray[np.bool_]
) -> npt.NDArray[np.bool_]:
    """Mask of the modes at 1 that conserve a component of the estimated current."""
    size = np.abs(left)
    others = ~np.isin(np.flatnonzero(kept), _CURRENT)
    only = size[others].max(axis=0) < _ONLY * size.max(axis=0)
    return np.asarray((np.abs(values - 1.0) < monodromy.NEAR_ONE) & only)


def _misled(boat: Boat, points: Points) -> Misled | None:
    """Sail on with the estimate as it is, and with both that are wrong by the current."""
    wrong_mps = math.hypot(*boat.current)
    estimates = boat.parameters.get("LAW_CUR_BW", 0.0) > 0.0
    if not (estimates and wrong_mps > 0.0 and _straight(points)):
        return None
    states = np.repeat(points.states, 3, axis=0)
    psi = points.states[0, 2]
    ahead = np.array([np.cos(psi), np.sin(psi)])
    states[1:, _CURRENT] += np.outer(
        [wrong_mps, -wrong_mps] + ahead @ (boat.current - states[0, _CURRENT]), ahead
    )
    loop = Loop(boat, 3)
    loop.resume(int(points.ticks[0]), states)
    count = round(_MISLED_S * boat.rate_hz)
    off_m = thrust_N = 0.0
    times_s: Array = boat.h_s * (loop.tick + np.arange(count, dtype=np.float64))
    for k, row in enumerate(leader_rows(boat.leader, times_s)):
        if 2 * k == count:
            loop.limited = False
        loop.step(row)
        if 2 * k >= count:
            off_m = max(off_m, float(np.hypot(*(loop.eta[1:, :2] - loop.eta[0, :2]).T).max()))
            thrust_N = max(thrust_N, float(np.abs(loop.thrust[1:] - loop.thrust[0]).max()))
    return Misled(wrong_mps, off_m, thrust_N, loop.limited)


def _shares(names: npt.NDArray[np.str_], part: Array) -> dict[str, float]:
    """Shares of at least a tenth in a mode, from products of its left and right vectors."""
    share = part / part.sum()
    order = [int(i) for i in np.argsort(-share, kind="stable") if share[i] >= _PART]
    return {str(names[i]): float(share[i]) for i in order}


def _without(modes: _Modes, neutral: int) -> tuple[_Modes, int]:
    """The modes without at most `neutral` modes at 1, and the number of modes removed."""
    near = np.argsort(modes.from_one)[:neutral].tolist()
    dropped = {j for j in near if modes.from_one[j] < monodromy.NEAR_ONE}
    rest = [j for j in range(len(modes.decays)) if j not in dropped]
    decays, from_one = ([of[j] for j in rest] for of in (modes.decays, modes.from_one))
    return replace(modes, decays=decays, from_one=from_one), len(dropped)
