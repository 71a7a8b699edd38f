# SPDX-License-Identifier: MIT
"""The trace of a run: the truth at every control tick from the release on."""

from collections import Counter
from collections.abc import Mapping, Sequence

import numpy as np

from sil import metrics
from sil.plant.fleet import Fleet
from sil.plant.hull import Array
from sil.scenario import Scenario


class Tracer:
    """Collects a scenario's trace and the boats' states, tick by tick.

    `parameters`: the firmware's of each boat, which say where its slot is.
    """

    def __init__(
        self, scenario: Scenario, fleet: Fleet, parameters: Sequence[Mapping[str, float]]
    ) -> None:
        self._scenario = scenario
        self._fleet = fleet
        self.h_s = 1e-6 * round(1e6 / scenario.rate_hz)
        self.ticks = round(scenario.duration_s / self.h_s) + 1
        self.t_s: Array = np.arange(self.ticks, dtype=np.float64) * np.float64(self.h_s)
        stages = np.array([0.0, 0.5 * self.h_s, self.h_s])
        self.reference: Array = scenario.leader.tau(self.t_s[:, None] + stages)
        agents = len(scenario.boat) + 1
        self._eta = np.empty((self.ticks, agents, 3))
        self._nu = np.empty((self.ticks, agents, 3))
        self._tau = np.empty((self.ticks, agents - 1, 2))
        self._offset_m = np.array([[p["FORM_OFS_N"], p["FORM_OFS_E"]] for p in parameters])
        self._turns = [p.get("FORM_FRAME", 0.0) == 1.0 for p in parameters]
        self._states: list[Counter[str]] = [Counter() for _ in scenario.boat]

    def step(self, k: int, command: Array, states: Sequence[str]) -> None:
        """Notes tick `k` and carries the fleet to the next one under `command` (N, 2)."""
        self._eta[k], self._nu[k] = self._fleet.eta, self._fleet.nu
        self._fleet.advance(command, self.reference[k], self.h_s)
        self._tau[k] = self._fleet.tau
        for count, state in zip(self._states, states, strict=True):
            count[state] += 1

    def trace(self) -> dict[str, Array]:
        """The arrays of trace.npz."""
        follows = [boat.follows for boat in self._scenario.boat]
        return {
            "t_s": self.t_s,
            "eta": self._eta,
            "nu": self._nu,
            "error": metrics.formation_error(self._eta, follows, self._offset_m, self._turns),
            "tau": self._tau,
            "thrust": self._fleet.thrust_of(self._tau),
        }

    def seconds(self) -> list[dict[str, float]]:
        """Seconds that each boat spent in each state."""
        return [{name: n * self.h_s for name, n in count.items()} for count in self._states]
