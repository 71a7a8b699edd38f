# SPDX-License-Identifier: MIT
"""The traces of runs: the truth at every control tick from the release on."""

from collections.abc import Sequence

import flotilla
import numpy as np
import numpy.typing as npt
from numba import njit

from sil.lockstep import metrics
from sil.plant.bodies import Bodies
from sil.plant.hull import Array
from sil.scenario.scenario import Scenario

Ints = npt.NDArray[np.integer]


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
        _note_truth(0, bodies.eta, bodies.nu, self._eta, self._nu)

    def note(self, k: int, states: Ints) -> None:
        """Record the bodies, which were just advanced from tick `k` to the next one.

        `states` (R N): the boats' at tick k, as indices of `flotilla.STATES`.
        """
        bodies = self._bodies
        truth = (bodies.eta, bodies.nu, bodies.tau)
        _note(k, self._every, *truth, states, self._eta, self._nu, self._tau, self._counts)

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


@njit(cache=True)
def _note(
    k: int,
    every: int,
    eta: Array,
    nu: Array,
    tau: Array,
    states: Ints,
    eta_out: Array,
    nu_out: Array,
    tau_out: Array,
    counts: Ints,
) -> None:
    """Store tau and states of tick k, eta and nu of the next; `_out` (R, kept, ...)."""
    for boat in range(states.shape[0]):
        counts[boat, states[boat]] += 1
    if k % every == 0:
        boats = tau_out.shape[2]
        for run in range(tau_out.shape[0]):
            for i in range(boats):
                for j in range(2):
                    tau_out[run, k // every, i, j] = tau[run * boats + i, j]
    at = (k + 1) // every
    if (k + 1) % every == 0 and at < eta_out.shape[1]:
        _note_truth(at, eta, nu, eta_out, nu_out)


@njit(cache=True)
def _note_truth(at: int, eta: Array, nu: Array, eta_out: Array, nu_out: Array) -> None:
    """Store eta and nu (leaders first, then boats) at index `at` of their runs."""
    runs, agents = eta_out.shape[0], eta_out.shape[2]
    for run in range(runs):
        for i in range(agents):
            row = run if i == 0 else runs + run * (agents - 1) + i - 1
            for j in range(3):
                eta_out[run, at, i, j] = eta[row, j]
                nu_out[run, at, i, j] = nu[row, j]
