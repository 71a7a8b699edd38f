# SPDX-License-Identifier: MIT
"""How the virtual leaders of runs move: a hull under its inputs, or a reference along waypoints."""

from collections.abc import Sequence

import numpy as np

from sil.plant.bodies import Bodies
from sil.plant.hull import Array
from sil.scenario.route import route
from sil.scenario.scenario import Scenario


class VirtualLeaders:
    """Moves the bodies of R runs from tick to tick, their virtual leaders as scenarios have it."""

    def __init__(self, scenarios: Sequence[Scenario]) -> None:
        first = scenarios[0]
        self._h_s = first.step_s
        t_s = np.arange(first.ticks) * np.float64(self._h_s)
        times = t_s[:, None] + np.array([0.0, 0.5 * self._h_s, self._h_s])
        leaders = [one.leader for one in scenarios]
        if all(leader.input == leaders[0].input for leader in leaders):
            leaders = leaders[:1]
        self._input = np.stack([leader.tau(times) for leader in leaders], axis=2)
        routes = {
            run: route(one.leader, one.boat, one.step_s, one.ticks)
            for run, one in enumerate(scenarios)
            if one.leader.waypoints
        }
        self._routes = {run: motion[:, :6] for run, motion in routes.items()}

    def advance(self, k: int, bodies: Bodies, command: Array) -> None:
        """Carry the bodies from tick `k` to the next one under `command` (R N, 2)."""
        bodies.advance(command, self._input[k], self._h_s)
        for run, motion in self._routes.items():
            bodies.eta[run], bodies.nu[run] = motion[k + 1, :3], motion[k + 1, 3:]
