# SPDX-License-Identifier: MIT
"""Nonlinear model-predictive control of both propellers along the plan, by CasADi's IPOPT.

  min Σ q_p |p − p_d|² + q_ψ (1 − cos(ψ − ψ_d)) + q_u (u − u_d)² + r |T|² + s |ΔT|²
  ν̇ = M⁻¹ (τ(T) − C(ν) ν − D ν) + d,  |T| ≤ T_max

over 4 s in steps of 0.2 s. p_d is the plan's vessel, beginning at the point beside the boat. d is
an acceleration that the model lacks (current, weak propeller). It is estimated from the difference
between measured and predicted velocity; without it the boat stays off the path. The model is the
firmware's: linear drag, ideal propellers. Source: Pannocchia and Rawlings, Disturbance models for
offset-free model-predictive control, AIChE Journal 49 (2), 2003.
"""

from typing import Any

import casadi as ca
import numpy as np

from sil.plant.hull import Array
from sil.rivals.helm import Known, Seen, Thrust
from sil.rivals.path import Path

_STEPS, _STEP_S = 20, 0.2
_STATES, _INPUTS = 6, 2
_LEARNS = 0.3  # 1/s
_OPTIONS: Any = {
    "ipopt": {"max_iter": 30, "print_level": 0, "sb": "yes", "tol": 1e-3, "mu_init": 1e-2},
    "print_time": False,
}


class Mpc:
    """A boat on a path; solves every `_STEP_S`, and holds the thrusts in between."""

    def __init__(self, known: Known, path: Path, position: float = 20.0, rest: float = 0.02):
        self._known, self._path = known, path
        self._rate = _rate_of(known)
        self._solver = _solver(known, self._rate, position, rest)
        self._plan: Array = np.zeros(_STEPS * (_STATES + _INPUTS))
        self._thrust: Array = np.zeros(_INPUTS)
        self._unknown: Array = np.zeros(3)
        self._expected: Array | None = None
        self._next_s = 0.0

    def steer(self, seen: Seen) -> Thrust:
        """See `Helm`."""
        if seen.t_s >= self._next_s - 1e-6:
            self._next_s = seen.t_s + _STEP_S
            self._solve(seen)
        return float(self._thrust[0]), float(self._thrust[1])

    def _solve(self, seen: Seen) -> None:
        now = np.array(seen[1:], dtype=np.float64)
        if self._expected is not None:
            self._unknown += _LEARNS * (now[3:] - self._expected[3:])
        at = self._path.beside(seen.x, seen.y)
        times_s: Array = _STEP_S * np.arange(1, _STEPS + 1, dtype=np.float64)
        ahead = self._path.ahead(at.k, 0.5 + times_s)
        places = self._path.ahead(at.k, times_s)
        wanted = np.column_stack([places[:, :3], ahead[:, 3]])
        given = np.concatenate([now, self._thrust, self._unknown, wanted.ravel()])
        found = self._solver["solve"](
            x0=self._plan, p=given, lbx=self._solver["low"], ubx=self._solver["high"], lbg=0, ubg=0
        )
        self._plan = np.array(found["x"]).ravel()
        self._thrust = self._plan[:_INPUTS].copy()
        rate = self._rate(now, self._thrust, self._unknown)
        self._expected = now + _STEP_S * np.array(rate).ravel()


def _rate_of(known: Known) -> Any:
    """ẋ (6) of state (6), thrusts (2) and unknown acceleration (3)."""
    x, thrust, d = ca.SX.sym("x", 6), ca.SX.sym("T", 2), ca.SX.sym("d", 3)
    psi, u, v, r = x[2], x[3], x[4], x[5]
    surge, yaw = thrust[0] + thrust[1], known.arm_m * (thrust[0] - thrust[1])
    rate = ca.vertcat(
        u * ca.cos(psi) - v * ca.sin(psi),
        u * ca.sin(psi) + v * ca.cos(psi),
        r,
        (surge + known.m22 * v * r - known.d11 * u) / known.m11 + d[0],
        (-known.m11 * u * r - known.d22 * v) / known.m22 + d[1],
        (yaw - (known.m22 - known.m11) * u * v - known.d33 * r) / known.m33 + d[2],
    )
    return ca.Function("rate", [x, thrust, d], [rate])


def _solver(known: Known, rate: Any, position: float, rest: float) -> dict[str, Any]:
    """Multiple shooting with steps of Runge and Kutta; variables: per step thrusts, then state."""
    z = ca.SX.sym("z", _STEPS * (_STATES + _INPUTS))
    p = ca.SX.sym("p", _STATES + _INPUTS + 3 + 4 * _STEPS)
    x, before, d = p[:6], p[6:8], p[8:11]
    cost: Any = 0
    gaps: list[Any] = []
    for k in range(_STEPS):
        row = k * (_STATES + _INPUTS)
        thrust, after = z[row : row + _INPUTS], z[row + _INPUTS : row + _INPUTS + _STATES]
        gaps.append(after - _stepped(rate, x, thrust, d))
        to = p[11 + 4 * k : 15 + 4 * k]
        cost += position * ca.sumsqr(after[:2] - to[:2]) + 0.5 * (1 - ca.cos(after[2] - to[2]))
        cost += 5.0 * (after[3] - to[3]) ** 2
        cost += 1e-4 * ca.sumsqr(thrust) + rest * ca.sumsqr(thrust - before)
        x, before = after, thrust
    problem = {"x": z, "p": p, "f": cost, "g": ca.vertcat(*gaps)}
    high = ([known.most_N] * _INPUTS + [np.inf] * _STATES) * _STEPS
    low = [-value for value in high]
    return {"solve": ca.nlpsol("mpc", "ipopt", problem, _OPTIONS), "low": low, "high": high}


def _stepped(rate: Any, x: Any, thrust: Any, d: Any) -> Any:
    h = _STEP_S
    a = rate(x, thrust, d)
    b = rate(x + 0.5 * h * a, thrust, d)
    c = rate(x + 0.5 * h * b, thrust, d)
    e = rate(x + h * c, thrust, d)
    return x + h / 6.0 * (a + 2 * b + 2 * c + e)
