# SPDX-License-Identifier: MIT
"""The traces of runs: the truth at every control tick from the release on."""

from collections.abc import Sequence

import flotilla
import numpy as np
import numpy.typing as npt
from flotilla import kernels

from sil.lockstep import metrics
from sil.plant.bodies import Bodies
from sil.plant.hull import Array
from sil.scenario.scenario import Scenario

States = npt.NDArray[np.uint8]


class Tracer:
    """Collects the traces of R runs of one shape and their boats' states, tick by tick.

    `slots`: of each run, from `sil.scenario.agents.slots_of`. `keep_s`: interval of the samples
    kept, rounded to ticks; None: every tick.
    """

    def __init__(
        self,
        scenarios: Sequence[Scenario],
        bodies: Bodies,
        slots: Sequence[Array],
        keep_s: float | None = None,
    ) -> None:
        first = scenarios[0]
        self._bodies = bodies
        self._slots = slots
        self._follows = [boat.follows for boat in first.boat]
        self.h_s, self.ticks = first.step_s, first.ticks
        self._every = 1 if keep_s is None else max(1, round(keep_s / self.h_s))
        kept, boats = len(range(0, self.ticks, self._every)), len(first.boat)
        self._eta: Array = np.empty((bodies.runs, kept, boats + 1, 3))
        self._nu: Array = np.empty((bodies.runs, kept, boats + 1, 3))
        self._tau: Array = np.empty((bodies.runs, kept, boats, 2))
        self._counts = np.zeros((bodies.runs * boats, len(flotilla.STATES)), np.int64)
        for kept_rows, rows in ((self._eta, bodies.eta), (self._nu, bodies.nu)):
            kept_rows[:, 0, 0] = rows[: bodies.runs]
            kept_rows[:, 0, 1:] = rows[bodies.runs :].reshape(bodies.runs, boats, 3)

    def note(self, k: int, states: States) -> None:
        """Record the bodies, which were just advanced from tick `k` to the next one.

        `states` (R N): the boats' at tick k, as indices of `flotilla.STATES`.
        """
        bodies = self._bodies
        truth = (bodies.eta, bodies.nu, bodies.tau)
        kept = (self._eta, self._nu, self._tau)
        kernels.note_tick(k, self._every, *truth, states, *kept, self._counts)

    def trace(self, run: int) -> dict[str, Array]:
        """The arrays of trace.npz of a run."""
        offset_m, turns = self._slots[run][:, :2], self._slots[run][:, 2] == 1.0
        eta, tau = self._eta[run], self._tau[run]
        return {
            "t_s": np.arange(0, self.ticks, self._every) * np.float64(self.h_s),
            "eta": eta,
            "nu": self._nu[run],
            "error": metrics.formation_error(eta, self._follows, offset_m, turns),
            "tau": tau,
            "thrust": self._bodies.thrust_of(run, tau),
        }

    def seconds(self, run: int) -> list[dict[str, float]]:
        """Seconds that each boat of a run spent in each state."""
        boats = len(self._follows)
        counts = self._counts[run * boats : (run + 1) * boats].tolist()
        return [
            {name: n * self.h_s for name, n in zip(flotilla.STATES, count, strict=True) if n}
            for count in counts
        ]
