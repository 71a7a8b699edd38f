# SPDX-License-Identifier: MIT
"""Three-degree-of-freedom hulls in a steady current.

M ν̇_r + C(ν_r) ν_r + D(ν_r) ν_r = [X 0 N]ᵀ + w,  ν_r = ν − R(ψ)ᵀ c,  η̇ = R(ψ) ν

η = [x y ψ], north-east-down, ψ clockwise, never wrapped (m, rad); ν = [u v r] over ground, body
x forward, y starboard (m/s, rad/s); c = [north east], the water's velocity, uniform and constant,
hence irrotational. Source: Wang and Loría, eq:sim, where M = diag(m11 m22 m33),
D = diag(d11 d22 d33), c = 0; with the rest of `HullParameters` Fossen, Handbook of Marine Craft
Hydrodynamics and Motion Control, 2nd ed., chapters 6 and 10.
"""

from collections.abc import Iterable
from dataclasses import astuple, dataclass, replace

import numpy as np
import numpy.typing as npt
from numba import njit

Array = npt.NDArray[np.float64]
# What a kernel is given as None is compiled away.
Water = tuple[float, float] | None

# numpy's division by zero: a check of each divisor would cost a fifth of the time.
_compiled = njit(cache=True, error_model="numpy")

# Columns of `stack`: the fields of HullParameters, then M inverted.
(
    _M11, _M22, _M33, _D11, _D22, _D33, _M23, _D11_UU, _D33_RR, _CROSSFLOW, _LENGTH,
    _SWAY_OF_YAW, _SWAY_INERTIA, _YAW_OF_SWAY, _YAW_INERTIA,
) = range(15)  # fmt: skip

_PAPER = ("m11", "m22", "m33", "d11", "d22", "d33")


@dataclass(frozen=True)
class HullParameters:
    """Inertia with added mass (kg, kg, kg m²) and linear drag (N s/m, N s/m, N m s).

    The rest is 0 for the paper's vessel. `crossflow` is ½ ρ T C_d (density, draft, drag
    coefficient) along the waterline from −`length_m`/2 to `length_m`/2.
    """

    m11: float
    m22: float
    m33: float
    d11: float
    d22: float
    d33: float
    m23: float = 0.0  # kg m: sway-yaw coupling, mass × distance of its centre ahead of the origin
    d11_quadratic: float = 0.0  # N s²/m², of u |u|
    d33_quadratic: float = 0.0  # N m s², of r |r|
    crossflow: float = 0.0  # kg/m²
    length_m: float = 0.0


def stack(hulls: Iterable[HullParameters]) -> Array:
    """Parameters (n, 15) of n vessels: columns in the order of `HullParameters`, then M inverted.

    The last four are m23/m33, m22 − m23²/m33, m23/m22, m33 − m23²/m22: M has one element off its
    diagonal, which is eliminated. ValueError where M is not positive definite.
    """
    rows = []
    for hull in hulls:
        m22, m33, m23 = hull.m22, hull.m33, hull.m23
        if m23 * m23 >= m22 * m33:
            raise ValueError(f"m23 = {m23:g}: its square must be less than m22 m33")
        schur = (m23 / m33, m22 - m23 * m23 / m33, m23 / m22, m33 - m23 * m23 / m22)
        rows.append((*astuple(hull), *schur))
    return np.array(rows, dtype=np.float64)


def mismatched(hull: HullParameters, share: float, rng: np.random.Generator) -> HullParameters:
    """`hull` with each of the paper's six parameters times its own U(1 − share, 1 + share)."""
    factors = rng.uniform(1.0 - share, 1.0 + share, len(_PAPER))
    changed = {
        name: getattr(hull, name) * factor for name, factor in zip(_PAPER, factors, strict=True)
    }
    return replace(hull, **changed)


@_compiled
def advance(
    eta: Array, nu: Array, tau: Array, w: Array, current: Array, parameters: Array, h_s: float
) -> None:
    """Carry n vessels over one step of `h_s` seconds, in place, by classical Runge-Kutta 4.

    Shapes: eta (n, 3), nu (n, 3), parameters (n, 15) from `stack`.
    tau (3, n, 2): [X N] (N, N m) at the start, the middle and the end of the step.
    w (n, 3): body-fixed disturbance [X Y N] (N, N, N m), held over the step.
    current (n, 2): velocity of the water around each, north and east (m/s).
    """
    for i in range(eta.shape[0]):
        p, north, east = parameters[i], current[i, 0], current[i, 1]
        plain = p[_M23] == p[_D11_UU] == p[_D33_RR] == p[_CROSSFLOW] == 0.0
        if plain and north == 0.0 and east == 0.0:
            _carry(i, eta, nu, tau, w, None, p, h_s)
        else:
            _carry(i, eta, nu, tau, w, (north, east), p, h_s)


@_compiled
def sail(
    eta: Array, nu: Array, tau: Array, w: Array, current: Array, parameters: Array, h_s: float
) -> None:
    """`advance` over many steps: tau (2 steps + 1, n, 2) at their ends and their middles."""
    for k in range(0, tau.shape[0] - 1, 2):
        advance(eta, nu, tau[k : k + 3], w, current, parameters, h_s)


@_compiled
def _carry(
    i: int, eta: Array, nu: Array, tau: Array, w: Array, water: Water, p: Array, h_s: float
) -> None:
    """Carry vessel i over a step; `water` None is the paper's vessel on still water."""
    half, sixth = 0.5 * h_s, h_s / 6.0
    psi, u, v, r, wi = eta[i, 2], nu[i, 0], nu[i, 1], nu[i, 2], w[i]
    a = _rates(psi, u, v, r, tau[0, i], wi, water, p)
    b = _rates(
        *(psi + half * a[2], u + half * a[3], v + half * a[4], r + half * a[5]),
        *(tau[1, i], wi, water, p),
    )
    c = _rates(
        *(psi + half * b[2], u + half * b[3], v + half * b[4], r + half * b[5]),
        *(tau[1, i], wi, water, p),
    )
    d = _rates(
        *(psi + h_s * c[2], u + h_s * c[3], v + h_s * c[4], r + h_s * c[5]),
        *(tau[2, i], wi, water, p),
    )
    for j in range(3):
        eta[i, j] += sixth * (a[j] + 2.0 * (b[j] + c[j]) + d[j])
        nu[i, j] += sixth * (a[j + 3] + 2.0 * (b[j + 3] + c[j + 3]) + d[j + 3])


@_compiled
def _rates(
    psi: float, u: float, v: float, r: float, tau: Array, w: Array, water: Water, p: Array
) -> tuple[float, float, float, float, float, float]:
    """[ẋ ẏ ψ̇ u̇ v̇ ṙ], written out by rows."""
    m11, m22, d11, d22, d33, m23 = p[_M11], p[_M22], p[_D11], p[_D22], p[_D33], p[_M23]
    cos, sin = np.cos(psi), np.sin(psi)
    x_dot, y_dot = cos * u - sin * v, sin * u + cos * v
    if water is None:  # the same bits as below, in half the time
        surge = tau[0] + w[0] + m22 * v * r - d11 * u
        sway = w[1] - m11 * u * r - d22 * v
        yaw = tau[1] + w[2] - (m22 - m11) * u * v - d33 * r
        return x_dot, y_dot, r, surge / m11, sway / p[_SWAY_INERTIA], yaw / p[_YAW_INERTIA]
    north, east = water
    u_c, v_c = cos * north + sin * east, cos * east - sin * north
    u_r, v_r = u - u_c, v - v_c
    surge = tau[0] + w[0] + m22 * v_r * r - d11 * u_r + (m23 * r * r - p[_D11_UU] * abs(u_r) * u_r)
    sway = w[1] - m11 * u_r * r - d22 * v_r
    yaw = tau[1] + w[2] - (m22 - m11) * u_r * v_r - d33 * r - (m23 * u_r + p[_D33_RR] * abs(r)) * r
    if p[_CROSSFLOW] > 0.0:
        sway_drag, yaw_drag = _crossflow(v_r, r, p[_CROSSFLOW], 0.5 * p[_LENGTH])
        sway -= sway_drag
        yaw -= yaw_drag
    return (
        x_dot,
        y_dot,
        r,
        surge / m11 + r * v_c,
        (sway - p[_SWAY_OF_YAW] * yaw) / p[_SWAY_INERTIA] - r * u_c,
        (yaw - p[_YAW_OF_SWAY] * sway) / p[_YAW_INERTIA],
    )


@_compiled
def _crossflow(v: float, r: float, k: float, half_m: float) -> tuple[float, float]:
    """Cross-flow drag in sway and yaw: k ∫ |v + x r| (v + x r) [1 x] dx, x over the waterline.

    In closed form: v + x r changes its sign on the waterline, or does not.
    """
    swing = r * half_m
    if abs(v) >= abs(swing):
        drag = 2.0 * half_m * k * abs(v) * v
        share = (swing / v) ** 2 if v != 0.0 else 0.0
        return drag * (1.0 + share / 3.0), (2.0 / 3.0) * drag * half_m * (swing / v if v else 0.0)
    drag = half_m * k * abs(swing) * swing
    q = v / swing
    return drag * (2.0 + (2.0 / 3.0) * q * q) * q, drag * half_m * (
        0.5 + q * q * (1.0 - q * q / 6.0)
    )
