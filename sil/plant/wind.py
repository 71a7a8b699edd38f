# SPDX-License-Identifier: MIT
"""Wind: one mass of air with gusts, and what it does to what stands above the water.

X = ½ ρ c_x A_F V a_x   Y = ½ ρ c_y A_L V a_y   N = −ρ c_n A_L L a_x a_y

a = [a_x a_y]: the air's velocity past the boat in its body axes, V = |a|; A_F, A_L the frontal
and lateral area, L the length. Source: Fossen, Handbook of Marine Craft Hydrodynamics and Motion
Control, 2nd ed., section 10.1 (C_X = −c_x cos γ, C_Y = c_y sin γ, C_N = c_n sin 2γ, the wind's
angle of attack γ written out).
"""

from collections.abc import Iterable
from dataclasses import astuple, dataclass

import numpy as np
from numba import njit

from sil.plant.hull import Array

AIR_KGPM3 = 1.225


@dataclass(frozen=True)
class Windage:
    """What of a boat stands in the wind: areas, coefficients, length."""

    frontal_m2: float
    lateral_m2: float
    c_x: float
    c_y: float
    c_n: float
    length_m: float


class Gusts:
    """A first-order Gauss-Markov process in each of two axes, stationary from the beginning.

    One-sided spectrum 4 σ² T / (1 + (2π f T)²), f in Hz, σ = `sigma_mps`, T = `time_s`.
    """

    def __init__(self, sigma_mps: float, time_s: float, rng: np.random.Generator) -> None:
        self._sigma_mps = sigma_mps
        self._time_s = time_s
        self._rng = rng
        self._now: Array = sigma_mps * rng.standard_normal(2)

    def step(self, h_s: float) -> Array:
        """The gust (2) in m/s of this step, north and east; on to the next step."""
        now = self._now
        kept = np.exp(-h_s / self._time_s)
        fresh = self._sigma_mps * np.sqrt(1.0 - kept * kept)
        self._now = kept * now + fresh * self._rng.standard_normal(2)
        return now


class Wind:
    """The wind's force on n boats; `mean_mps`: velocity of the air, north and east."""

    def __init__(
        self, mean_mps: tuple[float, float], gusts: Gusts, boats: Iterable[Windage]
    ) -> None:
        self._mean: Array = np.array(mean_mps)
        self._gusts = gusts
        self._boats = np.array([astuple(boat) for boat in boats])

    def step(self, _t_s: float, eta: Array, nu: Array, h_s: float, /) -> Array:
        """The force (n, 3) on boats at eta (n, 3) with nu (n, 3)."""
        w = np.zeros_like(eta)
        _push(eta, nu, self._mean + self._gusts.step(h_s), self._boats, w)
        return w


@njit(cache=True)
def _push(eta: Array, nu: Array, air: Array, boats: Array, w: Array) -> None:
    """Write the force w (n, 3) of `air` (2), north and east, on `boats` (n, 6)."""
    for i in range(eta.shape[0]):
        frontal, lateral, length = boats[i, 0], boats[i, 1], boats[i, 5]
        c_x, c_y, c_n = boats[i, 2], boats[i, 3], boats[i, 4]
        cos, sin = np.cos(eta[i, 2]), np.sin(eta[i, 2])
        a_x = cos * air[0] + sin * air[1] - nu[i, 0]
        a_y = cos * air[1] - sin * air[0] - nu[i, 1]
        pressure = 0.5 * AIR_KGPM3 * np.hypot(a_x, a_y)
        w[i, 0] = pressure * c_x * frontal * a_x
        w[i, 1] = pressure * c_y * lateral * a_y
        w[i, 2] = -AIR_KGPM3 * c_n * lateral * length * a_x * a_y
