# SPDX-License-Identifier: MIT
"""What the navigation units measure: the exact state, or the state with Gaussian noise."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numba import njit

from sil.plant.bodies import Bodies
from sil.plant.hull import Array
from sil.plant.normals import Normals


@dataclass(frozen=True)
class SensorNoise:
    """Standard deviations, each axis and sample independent; 0 is exact."""

    position_m: float = 0.0
    heading_rad: float = 0.0
    velocity_mps: float = 0.0
    yaw_rate_radps: float = 0.0

    @property
    def sigma(self) -> Array:
        """Standard deviations (2, 3) of [x y ψ] and [u v r]."""
        pose = [self.position_m, self.position_m, self.heading_rad]
        velocity = [self.velocity_mps, self.velocity_mps, self.yaw_rate_radps]
        return np.array([pose, velocity])


class Sensors:
    """The units of R virtual leaders and of N boats behind each; `bodies` are their truth.

    A virtual leader knows its state: it is a reference. `noise` and `rngs` (R): of the boats of
    each run; nothing is drawn where there is no noise. `eta` and `nu`: rows and units of the
    bodies', as they last were measured; the truth itself where nobody has noise. `worse` (R + R N):
    how many times each one's deviations are what they should be.
    """

    def __init__(
        self, noise: Sequence[SensorNoise], rngs: Sequence[np.random.Generator], bodies: Bodies
    ) -> None:
        self.eta, self.nu = bodies.eta, bodies.nu
        self._true = bodies.eta, bodies.nu
        self._sigma = np.array([one.sigma for one in noise])
        noisy = [bool(sigma.any()) for sigma in self._sigma]
        self.worse: Array = np.ones(len(bodies.eta))
        self._normals: Normals | None = None
        if any(noisy):
            agents = len(bodies.eta) // bodies.runs
            sources = [rng if drawn else None for rng, drawn in zip(rngs, noisy, strict=True)]
            self._normals = Normals(sources, (2, agents, 3))
            self.eta, self.nu = bodies.eta.copy(), bodies.nu.copy()

    def measure(self) -> None:
        """Measure once, everybody."""
        if self._normals is not None:
            _measure(*self._true, self._sigma, self.worse, self._normals.step(), self.eta, self.nu)


@njit(cache=True)
def _measure(
    eta: Array,
    nu: Array,
    sigma: Array,
    worse: Array,
    normals: Array,
    eta_out: Array,
    nu_out: Array,
) -> None:
    """Sigma (R, 2, 3), worse (R + R N), normals (R, 2, N+1, 3), the rest (R + R N, 3)."""
    runs, boats = normals.shape[0], normals.shape[2] - 1
    for run in range(runs):
        eta_out[run], nu_out[run] = eta[run], nu[run]
        for i in range(boats):
            row = runs + run * boats + i
            for j in range(3):
                pose, velocity = normals[run, 0, i + 1, j], normals[run, 1, i + 1, j]
                eta_out[row, j] = eta[row, j] + worse[row] * sigma[run, 0, j] * pose
                nu_out[row, j] = nu[row, j] + worse[row] * sigma[run, 1, j] * velocity
