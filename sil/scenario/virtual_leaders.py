# SPDX-License-Identifier: MIT
"""Moves agent 0 of each run: a hull under its inputs, a reference along waypoints, or a plan."""

from collections.abc import Mapping, Sequence

import numpy as np

from sil.plant.bodies import Bodies
from sil.plant.hull import Array
from sil.scenario.scenario import Scenario
from sil.scenario.told_plan import ToldPlan


class VirtualLeaders:
    """Moves the bodies of R runs from tick to tick, each agent 0 as its scenario specifies.

    `leading`: for each run, the firmware parameters of the boat that leads; by default the file's.
    """

    def __init__(
        self,
        scenarios: Sequence[Scenario],
        leading: Mapping[int, Mapping[str, float]] | None = None,
    ) -> None:
        first = scenarios[0]
        self._h_s = first.step_s
        t_s = np.arange(first.ticks) * np.float64(self._h_s)
        times = t_s[:, None] + np.array([0.0, 0.5 * self._h_s, self._h_s])
        leaders = [one.leader for one in scenarios]
        if all(leader.input == leaders[0].input for leader in leaders):
            leaders = leaders[:1]
        self._input = np.stack([leader.tau(times) for leader in leaders], axis=2)
        self._routes: dict[int, Array] = {}
        self._plans: dict[int, ToldPlan] = {}
        for run, one in enumerate(scenarios):
            if one.leader.boat is not None:
                own = (leading or {}).get(run)
                self._plans[run] = ToldPlan(one.route(own), self._h_s, one.leader.boat)
            elif one.leader.waypoints:
                self._routes[run] = one.route()[:, :6]

    def hear(self, run: int, data: bytes, t_us: int) -> None:
        """Process whole frames that the leading boat of a run sends at `t_us`."""
        self._plans[run].hear(data, t_us)

    def advance(self, k: int, bodies: Bodies, command: Array, t_us: int | None = None) -> None:
        """Carry the bodies from tick `k` to the next one under `command` (R N, 2).

        `t_us`: the time of the tick; needed if boats lead.
        """
        bodies.advance(command, self._input[k], self._h_s)
        for run, motion in self._routes.items():
            bodies.eta[run], bodies.nu[run] = motion[k + 1, :3], motion[k + 1, 3:]
        for run, plan in self._plans.items():
            assert t_us is not None
            bodies.eta[run], bodies.nu[run] = plan.forward(t_us)
