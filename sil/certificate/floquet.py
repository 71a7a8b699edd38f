# SPDX-License-Identifier: MIT
"""Floquet multipliers of the paper's periodic linear system.

 ė_x = −k_x e_x + ω_d e_y      ė_y = −ω_d e_x + v̄_y
 v̄̇_y = −(d22/m22) v̄_y + (m11/m22) k_x ω_d e_x

Source: Wang and Loría, eq:26. The multipliers are the eigenvalues of the solution over one period.
e_ψ and ν − ν* decay independently in that equation, and are left out.
"""

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt
from scipy.integrate import solve_ivp

from sil.certificate.references import Reference
from sil.plant.hull import Array, HullParameters

Multipliers = npt.NDArray[np.complex128]


def multipliers(vessel: HullParameters, reference: Reference, k_x: Sequence[float]) -> Multipliers:
    """Multipliers (K, 3) over `period_s(reference)` for K gains k_x, 1/s; largest first."""
    T_s, gains = period_s(reference), np.asarray(k_x)
    motion = reference.motion
    ratio = vessel.m11 / vessel.m22
    decay = vessel.d22 / vessel.m22
    at = np.zeros((len(gains), 3, 3))
    at[:, 0, 0] = -gains
    at[:, 1, 2] = 1.0
    at[:, 2, 2] = -decay

    def rates(t_s: float, flat: Array) -> Array:
        omega = motion.nu(np.array([t_s]))[0, 2]
        at[:, 0, 1], at[:, 1, 0] = omega, -omega
        at[:, 2, 0] = ratio * gains * omega
        return np.asarray(at @ flat.reshape(at.shape)).ravel()

    start = np.tile(np.eye(3), (len(gains), 1, 1)).ravel()
    span = (motion.begin_s, motion.begin_s + T_s)
    solution = solve_ivp(rates, span, start, "DOP853", t_eval=span[1:], rtol=1e-10, atol=1e-13)
    values = np.linalg.eigvals(solution.y[:, -1].reshape(at.shape))
    order = np.argsort(-np.abs(values), axis=1)
    return np.take_along_axis(values, order, axis=1).astype(np.complex128)


def decay_rates(reference: Reference, values: Multipliers) -> Array:
    """Decay (K), 1/s, of the slowest mode of multipliers (K, 3); negative for growth."""
    largest = np.maximum(np.abs(values).max(axis=1), 1e-300)
    return np.asarray(-np.log(largest) / period_s(reference))


def period_s(reference: Reference) -> float:
    """Period of ω_d, s; 1 s if ω_d is constant."""
    return reference.T_s if reference.kind == "periodic" and reference.T_s else 1.0
