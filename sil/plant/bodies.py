# SPDX-License-Identifier: MIT
"""The bodies of all vessels of a batch of runs; the firmware knows them only by its sensors."""

import numpy as np

from sil.plant import hull, propeller
from sil.plant.hull import Array
from sil.plant.weather import Weather


class Bodies:
    """Hulls of R virtual leaders and of N boats behind each, and the boats' propellers.

    Rows are the leaders of all runs, then the boats, run by run: A = R + R N. `eta` and `nu` (A,
    3): current pose (m, m, rad) and velocity (m/s, m/s, rad/s); `rpm` (R N, 2): shaft speeds, port
    and starboard; `tau` (R N, 2): surge force and yaw moment (N, N m) that the propellers gave at
    the beginning of the last step. `hulls` (A, 16) and `propellers` (R N, 9): from their `stack`;
    `current` (A, 2): velocity of the water around each vessel, north and east (m/s); `weather`: the
    force on the boats, if any; `push` (A, 3): a further force on all vessels, if any (N, N, N m in
    body axes). No run's numbers depend on another run.
    """

    def __init__(
        self,
        hulls: Array,
        propellers: Array,
        eta: Array,
        nu: Array,
        current: Array,
        weather: Weather | None = None,
    ) -> None:
        agents, boats = len(hulls), len(propellers)
        self.runs = agents - boats
        self.eta: Array = eta.copy()
        self.nu: Array = nu.copy()
        self.rpm: Array = np.zeros((boats, 2))
        self._hulls, self._propellers, self._current = hulls, propellers, current
        self._thrust: Array = np.zeros((boats, 2))
        self._stages: Array = np.zeros((3, agents, 2))
        self._reference = self._stages[:, : self.runs]
        self._given = self._stages[:, self.runs :]
        self.tau: Array = self._given[0]
        self._weather = weather
        self.push: Array | None = None
        self._w: Array = np.zeros((agents, 3))
        # The boats' rows, by run.
        self._boats_eta, self._boats_nu, self._boats_w = (
            rows[self.runs :].reshape(self.runs, -1, 3) for rows in (self.eta, self.nu, self._w)
        )

    def advance(self, command: Array, reference: Array, h_s: float) -> None:
        """Advance all bodies by a step of `h_s` seconds.

        `command` (R N, 2): the ESCs' commands to their motors, in [-1, 1], held over the step.
        `reference` (3, R, 2) or (3, 1, 2): the virtual leaders' surge force and yaw moment at the
        start, the middle and the end of the step.
        """
        propeller.advance(self._thrust, command, self._given, self._propellers, h_s)
        propeller.shaft_speed(self._thrust, self._propellers, self.rpm)
        self._reference[:] = reference
        if self._weather is not None:
            self._weather.step(self._boats_eta, self._boats_nu, self._boats_w, h_s)
        w = self._w if self.push is None else self._w + self.push
        water = (w, self._current, self._hulls)
        hull.advance(self.eta, self.nu, self._stages, *water, h_s)

    def thrust_of(self, run: int, tau: Array) -> Array:
        """Thrusts (…, N, 2), port and starboard, N, that produce a run's `tau` (…, N, 2)."""
        arms = self._propellers[:, 0].reshape(self.runs, -1)[run]
        half_yaw = 0.5 * tau[..., 1] / arms
        return np.stack([0.5 * tau[..., 0] + half_yaw, 0.5 * tau[..., 0] - half_yaw], axis=-1)
