# SPDX-License-Identifier: MIT
"""What pushes the boats: forces w = [X Y N] in each boat's body axes, held over a step."""

from collections.abc import Sequence
from typing import Protocol

import numpy as np

from sil.plant.hull import Array


class Force(Protocol):
    """One cause of a force on n boats."""

    def step(self, t_s: float, eta: Array, nu: Array, h_s: float, /) -> Array:
        """Force (n, 3) on boats at eta (n, 3) with nu (n, 3), for the step from `t_s` on."""


class Weather:
    """The sum of several forces; time runs from the first step on."""

    def __init__(self, forces: Sequence[Force]) -> None:
        self._forces = forces
        self._t_s = 0.0

    def step(self, eta: Array, nu: Array, h_s: float) -> Array:
        """Force (n, 3), N, N, N m, on boats at eta (n, 3) with nu (n, 3); on to the next step."""
        w = np.zeros_like(eta)
        for force in self._forces:
            w += force.step(self._t_s, eta, nu, h_s)
        self._t_s += h_s
        return w


class WhiteNoise:
    """White noise in each axis: normal, of variance `power` / `sample_s`, held for `sample_s`.

    Source: Wang and Loría, section III; power and sample time as Simulink's block has them.
    ValueError where a sample is not a whole number of steps.
    """

    def __init__(self, power: float, sample_s: float, rng: np.random.Generator) -> None:
        self._sigma = float(np.sqrt(power / sample_s))
        self._sample_s = sample_s
        self._rng = rng
        self._steps = 0
        self._held: Array = np.zeros((0, 3))

    def step(self, _t_s: float, eta: Array, _nu: Array, h_s: float, /) -> Array:
        """The noise of the step, (n, 3)."""
        if self._steps % steps_of(self._sample_s, h_s) == 0:
            self._held = self._sigma * self._rng.standard_normal(eta.shape)
        self._steps += 1
        return self._held


def steps_of(sample_s: float, h_s: float) -> int:
    """Steps of `h_s` in a sample; ValueError where that is no whole number."""
    steps = round(sample_s / h_s)
    if steps < 1 or abs(steps * h_s - sample_s) > 1e-9:
        raise ValueError(f"a sample of {sample_s:g} s is not a whole number of steps of {h_s:g} s")
    return steps
