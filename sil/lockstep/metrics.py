# SPDX-License-Identifier: MIT
"""Figures of a run: true formation errors, settling, effort, separation.

Trace arrays as in trace.npz, SI units: T control ticks from the release (t = 0) on, N boats; agent
0 is the virtual leader. Errors in metres are √(e_x² + e_y²).
"""

from collections.abc import Mapping, Sequence
from typing import NotRequired, TypedDict

import numpy as np
import numpy.typing as npt
from flotilla import kernels

from sil.plant.hull import Array

SETTLED_M = 0.05


class FinalError(TypedDict):
    """The formation error at the end of the run."""

    x_m: float
    y_m: float
    psi_rad: float


class BoatSummary(TypedDict):
    """One boat's entry of summary.json."""

    id: int
    rms_error_m: float
    max_error_m: float
    final_error: FinalError
    settling_time_s: float | None
    thrust_rms_N: float
    thrust_step_rms_N: float
    states: dict[str, float]
    closing_m: NotRequired[float]  # final distance from its slot, if it did not reach it
    said: NotRequired[list[str]]  # texts from when it first fell out of FORMATION


class PlanEnd(TypedDict):
    """How far a boat got in its plan."""

    item: int  # it sails to this one of `items`, the first is 1
    items: int
    over_s: float | None  # when its plan was over
    waiting_m: float | None  # greatest distance of a boat from its slot after that


class Summary(TypedDict):
    """summary.json. Lockstep runs have a digest, live runs the two times after it."""

    scenario: str
    seed: int
    duration_s: float
    wall_s: float
    real_time_factor: float
    digest: str | None
    release_unix_s: float | None  # UNIX time of t_s = 0
    late_s: float | None  # greatest delay of a tick of the simulation
    boats: list[BoatSummary]  # figures until the plan was over, if there was one
    min_separation_m: float | None
    hull_m: float  # length of the longest hull
    plan: NotRequired[PlanEnd]  # boat 1 leads by its plan
    voyage: NotRequired[str]  # the only boat measures its hull, without a slot: its last text of it


def formation_error(
    eta: Array, follows: Sequence[int], offset_m: Array, turns: npt.ArrayLike | None = None
) -> Array:
    """Formation errors [e_x e_y e_ψ] (T, N, 3) of boats 1 … N; e_ψ in (−π, π].

    `eta` (T, N+1, 3); boat i follows agent `follows[i-1]`. Its slot is at `offset_m[i-1]` from it,
    [north east], or [forward starboard] if `turns[i-1]` (FORM_FRAME 1; by default false).
    e_ψ is relative to the leader's heading in either case.
    Source: Wang and Loría, eq:formation-error.
    """
    error = np.empty((len(eta), len(follows), 3))
    turning = np.zeros(len(follows), bool) if turns is None else np.array(turns, bool)
    kernels.formation_errors(eta, np.array(follows, np.int64), offset_m, turning, error)
    error[..., 2] = wrap(error[..., 2])
    return error


def wrap(angle: Array) -> Array:
    """Wrap an angle, rad, to (−π, π]; NaN if it is not finite."""
    with np.errstate(invalid="ignore"):
        wrapped = np.pi - np.mod(np.pi - angle, 2.0 * np.pi)
    # the modulus of a tiny negative number rounds up to 2π
    return np.where(wrapped <= -np.pi, np.pi, wrapped)


@np.errstate(all="ignore")
def boats(
    t_s: Array, error: Array, thrust: Array, states: Sequence[Mapping[str, float]]
) -> list[BoatSummary]:
    """Entries of summary.json, one per boat.

    t_s (T), error (T, N, 3), thrust (T, N, 2) in N, states (N): seconds spent in each state.
    RMS and maximum error are over the last third of the run, RMS thrust over all of it;
    `thrust_step_rms_N` is that of the propeller that changes more, over the last third. Figures of
    a diverged run are not finite.
    """
    distance = distances(error)
    last_third = t_s >= t_s[0] + (t_s[-1] - t_s[0]) * 2.0 / 3.0
    entries: list[BoatSummary] = []
    for i in range(error.shape[1]):
        late = distance[last_third, i]
        x_m, y_m, psi_rad = error[-1, i].tolist()
        entries.append(
            {
                "id": i + 1,
                "rms_error_m": _rms(late),
                "max_error_m": float(late.max()),
                "final_error": {"x_m": x_m, "y_m": y_m, "psi_rad": psi_rad},
                "settling_time_s": settling_time_s(t_s, distance[:, i]),
                "thrust_rms_N": _rms(thrust[:, i]),
                "thrust_step_rms_N": float(thrust_step_rms_N(thrust[last_third, i]).max()),
                "states": dict(states[i]),
            }
        )
    return entries


def thrust_step_rms_N(thrust: Array) -> Array:
    """RMS change per tick of thrusts (T, ...): (...), N; 0 for a single tick."""
    change = np.diff(thrust, axis=0)
    return np.asarray(np.sqrt(np.sum(np.square(change), axis=0) / max(1, len(change))))


def distances(error: Array) -> Array:
    """√(e_x² + e_y²) (...), m, of errors (..., 3)."""
    return np.asarray(np.hypot(error[..., 0], error[..., 1]))


def settling_time_s(t_s: Array, distance: Array) -> float | None:
    """Time after which `distance` (T) stays below 0.05 m; None if it ends above."""
    # "not below" rather than "above": NaN counts as not settled
    outside = np.flatnonzero(~(distance < SETTLED_M))
    if outside.size == 0:
        return 0.0
    if outside[-1] == t_s.size - 1:
        return None
    return float(t_s[outside[-1] + 1] - t_s[0])


def min_separation_m(eta: Array) -> float | None:
    """Smallest distance between two boats over the run, eta (T, N+1, 3); None for a single boat.

    The virtual leader does not count.
    """
    if eta.shape[1] <= 2:
        return None
    return float(np.sqrt(kernels.least_square_distance(eta)))


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(np.square(values))))
