# SPDX-License-Identifier: MIT
"""The result of a campaign's run: outcome, figures of each boat, one sample per second."""

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from sil.lockstep import metrics
from sil.lockstep.start import RunError
from sil.lockstep.world import Run
from sil.plant.hull import Array
from sil.scenario.scenario import Scenario

DIVERGED_M, DIVERGED_TIMES = 10.0, 2.0
SETTLED_S = 100.0
"""After this time, or half the duration if that is shorter, boats should be in formation."""


def _none() -> Array:
    return np.zeros((0, 0), np.float32)


Figures = dict[str, float | None]


@dataclass(frozen=True)
class RunResult:
    """The results of a run; `boats` and `states` have one entry for each boat, none if it failed.

    outcome "ok", "diverged", "failed"; `error_m`, `psi_rad` (N, S) at the whole seconds 0 … S − 1.
    """

    run: int
    seed: int
    outcome: str
    reason: str
    digest: str = ""
    min_separation_m: float | None = None
    boats: tuple[Figures, ...] = ()
    states: tuple[Mapping[str, float], ...] = ()
    error_m: Array = field(default_factory=_none)
    psi_rad: Array = field(default_factory=_none)


def result_of(run: int, scenario: Scenario, outcome: Run | RunError) -> RunResult:
    """Figures and samples of one run."""
    if isinstance(outcome, RunError):
        return RunResult(run, scenario.seed, "failed", str(outcome))
    trace = outcome.trace
    t_s, error = trace["t_s"], trace["error"]
    with np.errstate(all="ignore"):  # figures of a diverged run are not finite
        distance = metrics.distances(error)
        reason = _divergence(t_s, distance, trace)
        entries = metrics.boats(t_s, error, trace["thrust"], outcome.states)
        late = distance[t_s >= min(SETTLED_S, 0.5 * t_s[-1])]
        p50, p95 = np.quantile(late, [0.5, 0.95], axis=0, method="inverted_cdf")
        second = _whole_seconds(t_s)
        return RunResult(
            run,
            scenario.seed,
            "diverged" if reason else "ok",
            reason,
            motion_digest(trace),
            metrics.min_separation_m(trace["eta"]),
            tuple(
                {
                    "rms_error_m": entry["rms_error_m"],
                    "max_error_m": entry["max_error_m"],
                    "final_x_m": entry["final_error"]["x_m"],
                    "final_y_m": entry["final_error"]["y_m"],
                    "final_psi_rad": entry["final_error"]["psi_rad"],
                    "error_p50_m": float(p50[i]),
                    "error_p95_m": float(p95[i]),
                    "settling_time_s": entry["settling_time_s"],
                    "thrust_rms_N": entry["thrust_rms_N"],
                    "thrust_step_rms_N": entry["thrust_step_rms_N"],
                }
                for i, entry in enumerate(entries)
            ),
            tuple(outcome.states),
            distance[second].T.astype(np.float32),
            error[second, :, 2].T.astype(np.float32),
        )


def distances(results: Sequence[RunResult]) -> Array:
    """Distances from the slot (R, N, S), m, of runs that sailed; infinite for diverged runs."""
    sailed = [result for result in results if result.boats]
    if not sailed:
        return np.zeros((0, 0, 0), np.float32)
    error = np.array([result.error_m for result in sailed])
    error[[result.outcome == "diverged" for result in sailed]] = np.inf
    return error


def _divergence(t_s: Array, distance: Array, trace: Mapping[str, Array]) -> str:
    """Describe which agents of a run diverged and how; empty if none did."""
    told = [] if _finite(trace, 0) else ["virtual leader: state not finite"]
    late = distance[t_s >= t_s[-1] * 2.0 / 3.0].max(axis=0)
    limit = np.maximum(DIVERGED_M, DIVERGED_TIMES * distance[0])
    for i in range(distance.shape[1]):
        if not _finite(trace, i + 1):
            told.append(f"boat {i + 1}: state not finite")
        elif not late[i] <= limit[i]:  # also true for NaN
            told.append(f"boat {i + 1}: {late[i]:.1f} m from its slot")
    return "; ".join(told)


def _finite(trace: Mapping[str, Array], agent: int) -> bool:
    return all(bool(np.isfinite(trace[name][:, agent]).all()) for name in ("eta", "nu"))


def motion_digest(trace: Mapping[str, Array]) -> str:
    """SHA-256 of poses and velocities at the whole seconds; `trace`: t_s, eta, nu at least."""
    digest = hashlib.sha256()
    ticks = _whole_seconds(trace["t_s"])
    for name in ("eta", "nu"):
        digest.update(np.ascontiguousarray(trace[name][ticks]).tobytes())
    return digest.hexdigest()


def _whole_seconds(t_s: Array) -> NDArray[np.intp]:
    return np.searchsorted(t_s, np.arange(int(t_s[-1] + 1e-6) + 1) - 1e-6)
