# SPDX-License-Identifier: MIT
"""Numbers of a run: formation errors of the truth, settling, effort, separation.

Trace arrays as in trace.npz, SI: T control ticks from release (t = 0) on, N boats, agent 0 the
virtual leader. Errors in metres are √(e_x² + e_y²).
"""

from collections.abc import Mapping, Sequence
from itertools import combinations
from typing import TypedDict

import numpy as np

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
    states: dict[str, float]


class Summary(TypedDict):
    """summary.json."""

    scenario: str
    seed: int
    duration_s: float
    wall_s: float
    real_time_factor: float
    digest: str | None
    boats: list[BoatSummary]
    min_separation_m: float | None


def formation_error(eta: Array, follows: Sequence[int], offset_m: Array) -> Array:
    """Formation errors [e_x e_y e_ψ] (T, N, 3) of boats 1 … N; e_ψ in (−π, π].

    `eta` (T, N+1, 3); boat i follows agent `follows[i-1]` at `offset_m[i-1]` [north east].
    Source: Wang and Loría, eq:formation-error.
    """
    own, leader = eta[:, 1:], eta[:, list(follows)]
    north, east = np.moveaxis(own[..., :2] - leader[..., :2] - offset_m, -1, 0)
    psi = own[..., 2]
    e_x = np.cos(psi) * north + np.sin(psi) * east
    e_y = np.cos(psi) * east - np.sin(psi) * north
    return np.stack([e_x, e_y, wrap(psi - leader[..., 2])], axis=-1)


def wrap(angle: Array) -> Array:
    """The angle, rad, in (−π, π]."""
    wrapped = np.pi - np.mod(np.pi - angle, 2.0 * np.pi)
    # the modulus of a tiny negative number is rounded up to 2π
    return np.where(wrapped > -np.pi, wrapped, np.pi)


def boats(
    t_s: Array, error: Array, thrust: Array, states: Sequence[Mapping[str, float]]
) -> list[BoatSummary]:
    """Entries of summary.json, one a boat.

    t_s (T), error (T, N, 3), thrust (T, N, 2) in N, states (N): seconds spent in each state.
    RMS and maximum error are over the last third of the run, RMS thrust is over all of it.
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
                "states": dict(states[i]),
            }
        )
    return entries


def distances(error: Array) -> Array:
    """√(e_x² + e_y²) (...), m, of errors (..., 3)."""
    return np.asarray(np.hypot(error[..., 0], error[..., 1]))


def settling_time_s(t_s: Array, distance: Array) -> float | None:
    """Time after which `distance` (T) stays under 0.05 m; None if it does not at the end."""
    # "not under" rather than "over": NaN has not settled
    outside = np.flatnonzero(~(distance < SETTLED_M))
    if outside.size == 0:
        return 0.0
    if outside[-1] == t_s.size - 1:
        return None
    return float(t_s[outside[-1] + 1] - t_s[0])


def min_separation_m(eta: Array) -> float | None:
    """Smallest distance between two real boats of eta (T, N+1, 3), ever; None for a single boat."""
    pairs = combinations(range(1, eta.shape[1]), 2)
    return min((float(distances(eta[:, i] - eta[:, j]).min()) for i, j in pairs), default=None)


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(np.square(values))))
