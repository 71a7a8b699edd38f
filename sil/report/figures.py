# SPDX-License-Identifier: MIT
"""Figures of runs, each for the worst boat.

They are computed from trace arrays as in trace.npz (`sil.lockstep.metrics`), and infinite if
undefined: for example, if a boat never settled or a leader never stopped.
"""

from collections.abc import Iterator, Mapping
from itertools import pairwise
from pathlib import Path

import numpy as np

from sil.lockstep import metrics
from sil.plant.hull import Array

REFERENCE = Path(__file__).with_name("nominal_formation.csv")
ARRIVED_M = 2.0
STOPPED_MPS = 0.05
UNDER_WAY_S = 100.0

Trace = Mapping[str, Array]


def rms_error_m(trace: Trace) -> float:
    """RMS distance from the slot over the last third, as in summary.json."""
    return _worst_rms(metrics.distances(trace["error"])[_last_third(trace)])


def settling_s(trace: Trace) -> float:
    """Time from release after which all boats stay within 0.05 m of their slots."""
    times = [
        metrics.settling_time_s(trace["t_s"], distance)
        for distance in metrics.distances(trace["error"]).T
    ]
    return max(np.inf if time is None else time for time in times)


def thrust_rms_N(trace: Trace) -> float:
    """RMS thrust of a propeller over the whole run, as in summary.json."""
    return _worst_rms(trace["thrust"])


def thrust_change_N(trace: Trace) -> float:
    """RMS change of a propeller's thrust from tick to tick over the last third, likewise."""
    return float(metrics.thrust_step_rms_N(trace["thrust"][_last_third(trace)]).max())


def driven_astray(trace: Trace) -> float:
    """Number of boats that have thrust and are more than 1 m off their slots, in the last third."""
    late = _last_third(trace)
    off = ~(metrics.distances(trace["error"])[late].max(axis=0) <= 1.0)  # NaN is off
    return float(np.count_nonzero(off & trace["thrust"][late].any(axis=(0, 2))))


def overshoot_m(trace: Trace) -> float:
    """Distance that a boat moved away from its slot again, after it had been within 2 m of it."""
    largest = 0.0
    for distance in metrics.distances(trace["error"]).T:
        arrival = np.flatnonzero(distance < ARRIVED_M)
        if arrival.size == 0:
            return np.inf
        since = distance[arrival[0] :]
        largest = max(largest, float((since - np.minimum.accumulate(since)).max()))
    return largest


def turns_at_a_stop(trace: Trace) -> float:
    """Turns between a boat's extreme headings while agent 0 is stopped; a full circle is 1.

    Agent 0 is stopped while its speed is below 0.05 m/s.
    """
    psi = np.unwrap(trace["eta"][:, 1:, 2], axis=0)
    turned = [np.ptp(psi[stop], axis=0).max() / (2.0 * np.pi) for stop in _stops(trace)]
    return float(max(turned, default=np.inf))


def deviation_from_reference(trace: Trace) -> float:
    """Largest deviation of e_x, e_y (m), e_ψ (rad) from the continuous-time `diamond`.

    The deviation is taken at each whole second.
    """
    table = np.genfromtxt(REFERENCE, delimiter=",", names=True)
    t_s, error = trace["t_s"], trace["error"]
    seconds = np.arange(int(t_s[-1] + 1e-6) + 1)
    axes = ("ex{}_m", "ey{}_m", "epsi{}_rad")
    boats = range(1, error.shape[1] + 1)
    expected = np.array([[table[axis.format(boat)] for axis in axes] for boat in boats])
    deviation = error[np.searchsorted(t_s, seconds - 1e-6)] - np.moveaxis(expected, -1, 0)[seconds]
    deviation[..., 2] = metrics.wrap(deviation[..., 2])
    return float(np.abs(deviation).max())


def largest_yaw_rate_radps(trace: Trace) -> float:
    """Largest yaw rate of a boat from 100 s on, to either side."""
    return float(_yaw_rates(trace)[1:].max())


def roots_yaw_rate_radps(trace: Trace) -> float:
    """Largest yaw rate of agent 0 from 100 s on, to either side."""
    return float(_yaw_rates(trace)[0])


def yaw_rate_growth(trace: Trace) -> float:
    """Ratio of the last boat's largest yaw rate from 100 s on to that of boat 2."""
    yaw_rates = _yaw_rates(trace)
    return float(yaw_rates[-1] / yaw_rates[2])


def largest_speed_mps(trace: Trace) -> float:
    """Largest speed over ground of a boat from 100 s on."""
    return float(_speeds(trace)[1:].max())


def roots_speed_mps(trace: Trace) -> float:
    """Largest speed over ground of agent 0 from 100 s on."""
    return float(_speeds(trace)[0])


def least_separation_m(trace: Trace) -> float:
    """Smallest distance between two boats from 100 s on; infinite for a single boat."""
    least = metrics.min_separation_m(trace["eta"][trace["t_s"] >= UNDER_WAY_S])
    return np.inf if least is None else least


def _yaw_rates(trace: Trace) -> Array:
    return _largest(trace, np.abs(trace["nu"][..., 2]))


def _speeds(trace: Trace) -> Array:
    return _largest(trace, metrics.distances(trace["nu"]))


def _largest(trace: Trace, values: Array) -> Array:
    """The largest of values (T, N+1) of each agent from 100 s on."""
    late = values[trace["t_s"] >= UNDER_WAY_S]
    return np.asarray(late.max(axis=0) if len(late) else np.full(values.shape[1], np.inf))


def _worst_rms(values: Array) -> float:
    """The largest over boats of the RMS of values (T, N, ...)."""
    over_all_else = tuple(axis for axis in range(values.ndim) if axis != 1)
    return float(np.sqrt(np.mean(np.square(values), axis=over_all_else)).max())


def _last_third(trace: Trace) -> Array:
    t_s = trace["t_s"]
    return np.asarray(t_s >= t_s[0] + (t_s[-1] - t_s[0]) * 2.0 / 3.0)


def _stops(trace: Trace) -> Iterator[slice]:
    stopped = metrics.distances(trace["nu"][:, 0]) < STOPPED_MPS
    changes = np.flatnonzero(np.diff(stopped)) + 1
    for begin, end in pairwise([*changes, stopped.size]):
        if stopped[begin]:
            yield slice(begin, end)
