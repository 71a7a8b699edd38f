# SPDX-License-Identifier: MIT
"""The bodies of all vessels of a run: what the firmware never sees but by its sensors."""

from collections.abc import Iterable, Sequence

import numpy as np

from sil.plant import hull, propeller
from sil.plant.hull import Array, HullParameters
from sil.plant.propeller import PropellerParameters
from sil.plant.weather import Weather


class Fleet:
    """Hulls of agents 0 … N and propellers of boats 1 … N; agent 0 is the virtual leader.

    `eta` and `nu` (N+1, 3): pose (m, m, rad) and velocity (m/s, m/s, rad/s) now; `rpm` (N, 2):
    shaft speeds, port and starboard; `tau` (N, 2): surge force and yaw moment (N, N m) that the
    propellers gave at the beginning of the last step. `current` (N+1, 2): velocity of the water
    around each, north and east (m/s); `weather` pushes them, or nothing does.
    """

    def __init__(
        self,
        hulls: Iterable[HullParameters],
        propellers: Iterable[PropellerParameters],
        eta: Sequence[Sequence[float]],
        nu: Sequence[Sequence[float]],
        current: Array | None = None,
        weather: Weather | None = None,
    ) -> None:
        self.eta: Array = np.array(eta, dtype=np.float64)
        self.nu: Array = np.array(nu, dtype=np.float64)
        n = len(self.eta) - 1
        self.rpm: Array = np.zeros((n, 2))
        self._hulls = hull.stack(hulls)
        self._propellers = propeller.stack(propellers)
        self._thrust: Array = np.zeros((n, 2))
        self._tau: Array = np.zeros((3, n + 1, 2))
        self._current: Array = np.zeros((n + 1, 2)) if current is None else current
        self._weather = weather
        self._w: Array = np.zeros((n + 1, 3))

    @property
    def tau(self) -> Array:
        """Surge force and yaw moment (N, 2) at the beginning of the last step."""
        return self._tau[0, 1:]

    def advance(self, command: Array, reference: Array, h_s: float) -> None:
        """Carry all bodies over a step of `h_s` seconds.

        `command` (N, 2): what the ESCs tell their motors, in [-1, 1], held. `reference` (3, 2):
        agent 0's surge force and yaw moment at the start, the middle and the end of the step.
        """
        propeller.advance(self._thrust, command, self._tau[:, 1:], self._propellers, h_s)
        propeller.shaft_speed(self._thrust, self._propellers, self.rpm)
        self._tau[:, 0] = reference
        if self._weather is not None:
            self._w[1:] = self._weather.step(self.eta[1:], self.nu[1:], h_s)
        hull.advance(self.eta, self.nu, self._tau, self._w, self._current, self._hulls, h_s)

    def thrust_of(self, tau: Array) -> Array:
        """Thrusts (…, N, 2), port and starboard, N, that give `tau` (…, N, 2)."""
        half_yaw = 0.5 * tau[..., 1] / self._propellers[:, 0]
        return np.stack([0.5 * tau[..., 0] + half_yaw, 0.5 * tau[..., 0] - half_yaw], axis=-1)
