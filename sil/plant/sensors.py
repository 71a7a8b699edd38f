# SPDX-License-Identifier: MIT
"""The measurements of the navigation units: the exact state, or the state with Gaussian noise.

The position may also have an error that drifts, a Gauss–Markov process of first order:
e₊ = e^(−h/T) e + σ √(1 − e^(−2h/T)) n, n standard normal; it begins at σ n.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from flotilla import kernels

from sil.plant.bodies import Bodies
from sil.plant.hull import Array
from sil.plant.normals import Normals


@dataclass(frozen=True)
class SensorNoise:
    """Standard deviations of the noise, independent in each axis and sample; 0 is exact.

    `drift_m`, `drift_s`: σ and T of the drift of each axis of the position.
    """

    position_m: float = 0.0
    heading_rad: float = 0.0
    velocity_mps: float = 0.0
    yaw_rate_radps: float = 0.0
    drift_m: float = 0.0
    drift_s: float = 60.0

    @property
    def sigma(self) -> Array:
        """Standard deviations (2, 3) of [x y ψ] and [u v r]."""
        pose = [self.position_m, self.position_m, self.heading_rad]
        velocity = [self.velocity_mps, self.velocity_mps, self.yaw_rate_radps]
        return np.array([pose, velocity])


class Sensors:
    """The units of R virtual leaders and of N boats behind each; `bodies` has the true states.

    A virtual leader knows its state exactly, because it is a reference. `noise` (R): noise of the
    boats of each run; `rngs` (2, R): generators for the noise of each step of `h_s` seconds and for
    the drift; runs without noise or drift draw nothing. `eta` and `nu`: the last measured values,
    with rows and units as in `bodies`; without any noise, the truth itself. `worse` (R + R N):
    factor of each vessel's standard deviations.
    """

    def __init__(
        self,
        noise: Sequence[SensorNoise],
        rngs: Sequence[Sequence[np.random.Generator]],
        bodies: Bodies,
        h_s: float,
    ) -> None:
        self.eta, self.nu = bodies.eta, bodies.nu
        self._true = bodies.eta, bodies.nu
        self._sigma = np.array([one.sigma for one in noise])
        self._drift_sigma = np.array([one.drift_m for one in noise])[:, None, None]
        self._kept = np.exp(-h_s / np.array([one.drift_s for one in noise]))[:, None, None]
        noisy = [bool(sigma.any()) for sigma in self._sigma]
        drifts = [one.drift_m > 0.0 for one in noise]
        self.worse: Array = np.ones(len(bodies.eta))
        agents = len(bodies.eta) // bodies.runs
        self._normals = _normals(rngs[0], noisy, (2, agents, 3))
        self._steps = _normals(rngs[1], drifts, (agents - 1, 2))
        self._drift: Array | None = None
        if any(noisy) or any(drifts):
            self.eta, self.nu = bodies.eta.copy(), bodies.nu.copy()

    def measure(self) -> None:
        """Measure all vessels once."""
        if self._normals is not None:
            normals = self._normals.step()
            kernels.measure(*self._true, self._sigma, self.worse, normals, self.eta, self.nu)
        if self._steps is not None:
            if self._normals is None:
                self.eta[:], self.nu[:] = self._true
            self._add_drift(self._drift_sigma * self._steps.step())

    def _add_drift(self, n: Array) -> None:
        """Advance the drift (R, N, 2) with the new numbers `n`, and add it to the positions."""
        kept = self._kept
        self._drift = n if self._drift is None else kept * self._drift + (1 - kept**2) ** 0.5 * n
        runs = len(n)
        self.eta[runs:, :2] += self.worse[runs:, None] * self._drift.reshape(-1, 2)


def _normals(
    rngs: Sequence[np.random.Generator], drawn: Sequence[bool], shape: tuple[int, ...]
) -> Normals | None:
    if not any(drawn):
        return None
    return Normals([rng if draws else None for rng, draws in zip(rngs, drawn, strict=True)], shape)
