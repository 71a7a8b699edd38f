# SPDX-License-Identifier: MIT
"""What the navigation unit measures: the exact state, or the state with Gaussian noise."""

from dataclasses import dataclass

import numpy as np

from sil.plant.hull import Array


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


def measure(eta: Array, nu: Array, sigma: Array, rng: np.random.Generator) -> tuple[Array, Array]:
    """Measured η and ν, new arrays of the shapes of `eta` and `nu` (..., 3), in their units.

    `sigma` (2, 3) is `SensorNoise.sigma`; nothing is drawn from `rng` where it is all zero.
    """
    if not sigma.any():
        return eta.copy(), nu.copy()
    noise = rng.standard_normal((2, *eta.shape))
    return eta + sigma[0] * noise[0], nu + sigma[1] * noise[1]
