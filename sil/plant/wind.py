# SPDX-License-Identifier: MIT
"""Wind: one mass of air with gusts, and its force on the boat above the water.

X = ½ ρ c_x A_F V a_x   Y = ½ ρ c_y A_L V a_y   N = −ρ c_n A_L L a_x a_y

a = [a_x a_y]: the air's velocity past the boat in its body axes, V = |a|; A_F, A_L the frontal
and lateral area, L the length. Source: Fossen, Handbook of Marine Craft Hydrodynamics and Motion
Control, 2nd ed., section 10.1 (C_X = −c_x cos γ, C_Y = c_y sin γ, C_N = c_n sin 2γ, the wind's
angle of attack γ written out).
"""

from collections.abc import Sequence
from dataclasses import astuple, dataclass

import numpy as np
from flotilla import kernels

from sil.plant.hull import Array
from sil.plant.normals import Normals

AIR_KGPM3 = 1.225


@dataclass(frozen=True)
class Windage:
    """A boat's properties in wind: areas, coefficients, length."""

    frontal_m2: float
    lateral_m2: float
    c_x: float
    c_y: float
    c_n: float
    length_m: float


class Gusts:
    """A first-order Gauss-Markov process in each of two axes, stationary from the beginning.

    One-sided spectrum 4 σ² T / (1 + (2π f T)²), f in Hz, σ = `sigma_mps`, T = `time_s`; these and
    `rngs` have one entry for each of R runs.
    """

    def __init__(
        self,
        sigma_mps: Sequence[float],
        time_s: Sequence[float],
        rngs: Sequence[np.random.Generator],
    ) -> None:
        self._sigma_mps = np.array(sigma_mps)[:, np.newaxis]
        self._time_s = np.array(time_s)[:, np.newaxis]
        self._normals = Normals(rngs, (2,))
        self._now: Array | None = None

    def step(self, h_s: float) -> Array:
        """The gusts (R, 2) of this step, m/s, north and east; go to the next step."""
        normals = self._normals.step()
        if self._now is None:
            self._now = self._sigma_mps * normals
        else:
            kept = np.exp(-h_s / self._time_s)
            fresh = self._sigma_mps * np.sqrt(1.0 - kept * kept)
            self._now = kept * self._now + fresh * normals
        return self._now


class Wind:
    """The wind's force on N boats of each of R runs.

    `mean_mps` (R): mean velocity of the air, north and east; `boats` (R, N).
    """

    def __init__(
        self,
        mean_mps: Sequence[tuple[float, float]],
        gusts: Gusts,
        boats: Sequence[Sequence[Windage]],
    ) -> None:
        self._mean: Array = np.array(mean_mps)
        self._gusts = gusts
        self._boats = np.array([[astuple(boat) for boat in run] for run in boats])

    def push(self, _t_s: float, eta: Array, nu: Array, h_s: float, w: Array, /) -> None:
        """Add the force on boats at eta with nu to w; all (R, N, 3)."""
        air = self._mean + self._gusts.step(h_s)
        kernels.add_wind(eta, nu, air, self._boats, w, AIR_KGPM3)
