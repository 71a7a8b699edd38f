# SPDX-License-Identifier: MIT
"""Environmental forces on the boats: w = [X Y N] in each boat's body axes, held over a step."""

from collections.abc import Sequence
from typing import Protocol

import numpy as np
from flotilla import kernels

from sil.plant.hull import Array
from sil.plant.normals import Normals


class Force(Protocol):
    """One cause of a force on the N boats of each of R runs."""

    def push(self, t_s: float, eta: Array, nu: Array, h_s: float, w: Array, /) -> None:
        """Add the force on boats at eta with nu over the step from `t_s` on to w; all (R, N, 3)."""


class Weather:
    """The sum of several forces; time begins at the first step."""

    def __init__(self, forces: Sequence[Force]) -> None:
        self._forces = forces
        self._t_s = 0.0

    def step(self, eta: Array, nu: Array, w: Array, h_s: float) -> None:
        """Write the force w, N, N, N m, on boats at eta with nu, all (R, N, 3), for one step."""
        w[:] = 0.0
        for force in self._forces:
            force.push(self._t_s, eta, nu, h_s, w)
        self._t_s += h_s


class WhiteNoise:
    """White noise in each axis: normal, of variance `power` / `sample_s`, held for `sample_s`.

    `power` and `rngs` (R): of each run; a run with power 0 draws nothing. Source: Wang and Loría,
    section III; power and sample time as in Simulink's block. ValueError if a sample is not a whole
    number of steps.
    """

    def __init__(
        self,
        power: Sequence[float],
        sample_s: float,
        rngs: Sequence[np.random.Generator],
        boats: int,
    ) -> None:
        self._sigma = np.sqrt(np.array(power) / sample_s)
        self._sample_s = sample_s
        sources = [rng if p else None for rng, p in zip(rngs, power, strict=True)]
        self._normals = Normals(sources, (boats, 3))
        self._steps = 0
        self._held: Array = np.zeros((len(power), boats, 3))

    def push(self, _t_s: float, _eta: Array, _nu: Array, h_s: float, w: Array, /) -> None:
        """Add the noise of the step."""
        if self._steps % steps_of(self._sample_s, h_s) == 0:
            self._held = self._normals.step()
        self._steps += 1
        kernels.add_noise(self._sigma, self._held, w)


def steps_of(sample_s: float, h_s: float) -> int:
    """Number of steps of `h_s` in a sample; ValueError if it is not whole."""
    steps = round(sample_s / h_s)
    if steps < 1 or abs(steps * h_s - sample_s) > 1e-9:
        raise ValueError(f"a sample of {sample_s:g} s is not a whole number of steps of {h_s:g} s")
    return steps
