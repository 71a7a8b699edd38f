# SPDX-License-Identifier: MIT
"""Multipliers and decay of the sampled closed loop of one boat behind one reference.

A boat never acts on its leader. Therefore the fleet's linearisation is block triangular, and its
multipliers are those of all boats together. A link's delay and rate only shift the follower's view
of its leader: they are outside every loop, and no multiplier depends on them. The rate of a boat's
own fixes is inside.

Two kinds of multipliers do not concern the law and are left out. The first are those of modes that
stay in the firmware's memory and never move the boat. The second, behind a leader at rest, are
those at 1 that the hull has under any thrusts (Popov, Belevitch and Hautus: rank [A − I B]): a boat
without way on cannot move sideways. The latter are counted as `neutral`.
"""

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np
import numpy.typing as npt
from scipy import linalg

from sil.certificate import monodromy
from sil.certificate.loop import COMPONENTS, Boat
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
ESTIMATES = ("LAW_CUR_BW", "LAW_OBS_BW")


@dataclass(frozen=True)
class SampledLoop:
    """The stability of small deviations of one boat.

    `radius`: largest |multiplier| over one window of `window_s`, without the neutral ones. `decay`:
    1/s, negative for growth. `decay_of_law`: the same with `ESTIMATES` 0, because the estimates of
    current and unknown forces have modes of their own, which the gains hardly affect. `decays`: the
    slowest ones. `slowest`: components of the state with their shares of the slowest mode, the
    largest first. `steady`: the boat reached a regime that repeats itself without a propeller at
    its limit (`limited`), and was linearised there, otherwise on its slot. `error` (3): mean
    |deviation| from the slot north, east and in heading, m, m, rad.
    """

    window_s: float
    radius: float
    decay: float
    decay_of_law: float
    decays: list[float]
    slowest: dict[str, float]
    neutral: int
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
    seen = np.flatnonzero(monodromy.visible(values, right, partial))
    # smaller values are rounding errors
    seen = seen[np.abs(values[seen]) > _ROUNDING * np.abs(values[seen]).max()]
    logs = np.log(np.abs(values[seen]))
    seen, logs = seen[np.argsort(-logs)], np.sort(logs)[::-1] + scale
    slowest = _shares(np.array(COMPONENTS)[kept], np.abs(left[:, seen[0]] * right[:, seen[0]]))
    from_one = np.abs(values[seen] * math.exp(min(scale, 300.0)) - 1.0)
    length_s = int(points.cycles.sum()) * boat.cycle * boat.h_s
    return _Modes((-logs / length_s).tolist(), from_one.tolist(), slowest)


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
    return _Modes(decays, from_one, modes.slowest), len(dropped)
