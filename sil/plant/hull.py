# SPDX-License-Identifier: MIT
"""Three-degree-of-freedom hulls: M ν̇ + C(ν) ν + D ν = [X 0 N]ᵀ + w, η̇ = R(ψ) ν.

Source: Wang and Loría, eq:sim. η = [x y ψ], north-east-down, ψ clockwise, never wrapped (m, rad);
ν = [u v r], body x forward, y starboard (m/s, rad/s); M = diag(m11 m22 m33),
D = diag(d11 d22 d33).
"""

from collections.abc import Iterable
from dataclasses import astuple, dataclass

import numpy as np
import numpy.typing as npt
from numba import njit

Array = npt.NDArray[np.float64]


@dataclass(frozen=True)
class HullParameters:
    """Inertia with added mass (kg, kg, kg m²) and linear drag (N s/m, N s/m, N m s)."""

    m11: float
    m22: float
    m33: float
    d11: float
    d22: float
    d33: float


def stack(hulls: Iterable[HullParameters]) -> Array:
    """Parameters (n, 6) of n vessels, columns in the order of `HullParameters`."""
    return np.array([astuple(hull) for hull in hulls], dtype=np.float64)


@njit(cache=True)
def advance(eta: Array, nu: Array, tau: Array, w: Array, parameters: Array, h_s: float) -> None:
    """Carry n vessels over one step of `h_s` seconds, in place, by classical Runge-Kutta 4.

    Shapes: eta (n, 3), nu (n, 3), parameters (n, 6) from `stack`.
    tau (3, n, 2): [X N] (N, N m) at the start, the middle and the end of the step.
    w (n, 3): body-fixed disturbance [X Y N] (N, N, N m), held over the step.
    """
    half = 0.5 * h_s
    sixth = h_s / 6.0
    for i in range(eta.shape[0]):
        p, wi = parameters[i], w[i]
        psi, u, v, r = eta[i, 2], nu[i, 0], nu[i, 1], nu[i, 2]
        a = _rates(psi, u, v, r, tau[0, i], wi, p)
        b = _rates(
            psi + half * a[2], u + half * a[3], v + half * a[4], r + half * a[5], tau[1, i], wi, p
        )
        c = _rates(
            psi + half * b[2], u + half * b[3], v + half * b[4], r + half * b[5], tau[1, i], wi, p
        )
        d = _rates(
            psi + h_s * c[2], u + h_s * c[3], v + h_s * c[4], r + h_s * c[5], tau[2, i], wi, p
        )
        for j in range(3):
            eta[i, j] += sixth * (a[j] + 2.0 * (b[j] + c[j]) + d[j])
            nu[i, j] += sixth * (a[j + 3] + 2.0 * (b[j + 3] + c[j + 3]) + d[j + 3])


@njit(cache=True)
def _rates(
    psi: float, u: float, v: float, r: float, tau: Array, w: Array, p: Array
) -> tuple[float, float, float, float, float, float]:
    """[ẋ ẏ ψ̇ u̇ v̇ ṙ]: eq:sim, written out by rows."""
    m11, m22, m33, d11, d22, d33 = p[0], p[1], p[2], p[3], p[4], p[5]
    cos, sin = np.cos(psi), np.sin(psi)
    return (
        cos * u - sin * v,
        sin * u + cos * v,
        r,
        (tau[0] + w[0] + m22 * v * r - d11 * u) / m11,
        (w[1] - m11 * u * r - d22 * v) / m22,
        (tau[1] + w[2] - (m22 - m11) * u * v - d33 * r) / m33,
    )
