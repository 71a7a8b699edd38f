# SPDX-License-Identifier: MIT
"""Three-degree-of-freedom hulls in a steady current.

M ν̇_r + C(ν_r) ν_r + D(ν_r) ν_r = [X 0 N]ᵀ + w,  ν_r = ν − R(ψ)ᵀ c,  η̇ = R(ψ) ν

D(ν_r) ν_r = [(d11 + d11q |u_r|) u_r,  d22 v_r + Y_c,  (d33 + d33q |r| + d33u |u_r|) r + N_c]
[Y_c N_c] = k ∫ |v_r + x r| (v_r + x r) [1 x] dx along the waterline: cross-flow drag

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
from flotilla import kernels

Array = npt.NDArray[np.float64]
PAPER = ("m11", "m22", "m33", "d11", "d22", "d33")


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
    d33_speed: float = 0.0  # N s²: of |u| r, yaw damping that grows with the speed ahead


def stack(hulls: Iterable[HullParameters]) -> Array:
    """Parameters (n, 16) of n vessels: columns in the order of `HullParameters`, then M inverted.

    The last four are m23/m33, m22 − m23²/m33, m23/m22, m33 − m23²/m22: they eliminate the one
    element of M off its diagonal. ValueError if M is not positive definite.
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
    """`hull` with each of the paper's six parameters times a factor U(1 − share, 1 + share)."""
    factors = rng.uniform(1.0 - share, 1.0 + share, len(PAPER))
    changed = {
        name: getattr(hull, name) * factor for name, factor in zip(PAPER, factors, strict=True)
    }
    return replace(hull, **changed)


def advance(
    eta: Array, nu: Array, tau: Array, w: Array, current: Array, parameters: Array, h_s: float
) -> None:
    """Carry n vessels over one step of `h_s` seconds, in place, by classical Runge-Kutta 4.

    Shapes: eta (n, 3), nu (n, 3), parameters (n, 16) from `stack`.
    tau (3, n, 2): [X N] (N, N m) at the start, the middle and the end of the step.
    w (n, 3): body-fixed disturbance [X Y N] (N, N, N m), held over the step.
    current (n, 2): velocity of the water around each, north and east (m/s).
    """
    kernels.advance_hulls(eta, nu, tau, w, current, parameters, h_s)


def sail(
    eta: Array, nu: Array, tau: Array, w: Array, current: Array, parameters: Array, h_s: float
) -> None:
    """The same as `advance` over many steps: tau (2 steps + 1, n, 2) at their ends and middles."""
    kernels.advance_hulls(eta, nu, tau, w, current, parameters, h_s)
